//! Faults at random moments, with real processes: killed and stopped daemons and clients, machines without shared memory or descriptors,
//! clients that come and go by the thousand. After each fault, the next request gets a result and nothing is left behind.
//!
//! The long runs: `cargo test --release --workspace --test faults -- --ignored --nocapture`.

mod support;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rustix::process::Signal;
use shatter_client::{Client, Contact, Deadline, DegreeRule, Error, ErrorKind, Impact, Object};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::process::Command;
use std::sync::RwLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use support::{
    Child, InProcess, TestDirectory, bar, descriptors, eventually, leave_tags, leave_unfinished, pause, play,
    quantiles, role, shatter, shatterd, timeout, under,
};

/// Largest time by which a call may exceed its deadline, on a machine under any load.
const SLACK: Duration = Duration::from_secs(5);

/// Held alone by tests that count descriptors of this process, or start children with few: the transport's descriptors outlive `exec`,
/// so that a child has those of all tests under way. Shared by all others.
static ALONE: RwLock<()> = RwLock::new(());

/// Runs the process of another role for the tests below; does nothing by itself.
#[test]
fn play_a_role() {
    play(|client| match client {
        "striker" => strike_until_killed(),
        "crowded" => with_full_memory(),
        "poor" => with_few_descriptors(),
        other => panic!("no such role: {other}"),
    });
}

fn impact(number: u64) -> Impact {
    let y = 0.06 * ((number % 16) as f64 / 16.0 - 0.5);
    let impact = Impact::new([Contact::new([0.2, y, 0.0]).impulse([-50.0, 0.0, 0.0]).radius(0.05)]);
    impact.degree(DegreeRule::Sites(4 + (number % 5) as u32)).seed(number)
}

fn named() -> Client {
    Client::connect(&std::env::var("SHATTER_SERVICE").unwrap(), timeout()).unwrap()
}

/// Keeps eight requests under way and three results held at every moment.
fn strike_until_killed() {
    let bar = named().object("bar", timeout()).unwrap();
    println!("ready");
    let (mut under_way, mut held) = (VecDeque::new(), VecDeque::new());
    for number in 0.. {
        if let Ok(ticket) = bar.strike(&impact(number)) {
            under_way.push_back(ticket);
        }
        if under_way.len() >= 8
            && let Some(mut ticket) = under_way.pop_front()
            && let Ok(result) = ticket.wait(timeout())
        {
            held.push_back(result);
        }
        if held.len() > 3 {
            held.pop_front();
        }
    }
}

/// Outcomes of calls, and the largest excess of one over its deadline.
#[derive(Default)]
struct CallCounts {
    ends: BTreeMap<&'static str, u64>,
    overstayed: Duration,
}

impl CallCounts {
    fn add(&mut self, other: Self) {
        other.ends.into_iter().for_each(|(end, count)| *self.ends.entry(end).or_default() += count);
        self.overstayed = self.overstayed.max(other.overstayed);
    }
}

/// Sends requests, each with a deadline, until `over`; daemons come and go meanwhile.
fn strike_until(bar: &Object, over: &AtomicBool) -> CallCounts {
    const WAIT: Duration = Duration::from_millis(500);
    let mut counts = CallCounts::default();
    for number in 0.. {
        if over.load(Ordering::Relaxed) {
            break;
        }
        let begun = Instant::now();
        let result = bar.strike(&impact(number)).and_then(|mut ticket| ticket.wait(Deadline::after(WAIT)));
        counts.overstayed = counts.overstayed.max(begun.elapsed().saturating_sub(WAIT));
        let end = match &result {
            Ok(_) => "ok",
            Err(Error { kind, .. }) => kind.name(),
        };
        *counts.ends.entry(end).or_default() += 1;
        if result.is_err() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    counts
}

/// Kills the daemon `kills` times under full load, also while it starts. Every call ends, the next daemon serves the same connections, and
/// no resource accumulates.
fn daemons_killed(kills: u64) {
    const CLIENTS: usize = 3;
    let _alone = ALONE.write();
    let here = TestDirectory::new("kills");
    here.database("bar", bar(0.08));
    let before = descriptors(std::process::id());
    let mut random = ChaCha8Rng::seed_from_u64(kills);
    let (mut restarts, over) = (Vec::new(), AtomicBool::new(false));
    let mut daemon = Some(Child::start(&mut shatterd(&here)));
    let mut counts = CallCounts::default();
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let own = service.object("bar", timeout()).unwrap();
    let connect = || Client::connect_at(&here.place, timeout()).unwrap().object("bar", timeout()).unwrap();
    let files = here.shared_memory().len();
    std::thread::scope(|scope| {
        let bars: Vec<Object> = (0..CLIENTS).map(|_| connect()).collect();
        let over = &over;
        let clients: Vec<_> = bars.into_iter().map(|bar| scope.spawn(move || strike_until(&bar, over))).collect();
        for kill in 0..kills {
            pause(&mut random, 60_000);
            daemon.take().into_iter().for_each(Child::kill);
            // Some are killed before they serve.
            if kill % 4 == 0 {
                let early = Child::begin(&mut shatterd(&here));
                pause(&mut random, 30_000);
                early.kill();
            }
            let begun = Instant::now();
            daemon = Some(Child::start(&mut shatterd(&here)));
            let deadline = timeout();
            while let Err(error) = own.strike(&impact(kill)).and_then(|mut ticket| ticket.wait(timeout())) {
                assert!(error.kind.retry() && !deadline.passed(), "after kill {kill}: {error}");
            }
            restarts.push(begun.elapsed());
        }
        over.store(true, Ordering::Relaxed);
        clients.into_iter().for_each(|client| counts.add(client.join().unwrap()));
    });
    println!("{kills} killed daemons: next result after {}; {:?}", quantiles(restarts), counts.ends);
    println!("  a call overstayed its deadline by {:.1} ms at most", counts.overstayed.as_secs_f64() * 1e3);
    assert!(counts.overstayed < SLACK, "{:?}", counts.overstayed);
    let known = ["ok", "lost", "no_daemon", "late", "busy", "stopping", "transport", "version_mismatch"];
    assert!(counts.ends.keys().all(|end| known.contains(end)) && counts.ends["ok"] > kills, "{:?}", counts.ends);
    println!("  files in shared memory: {files} before, {} after", here.shared_memory().len());
    // The transport releases a connection when it sends the next time.
    let serves = || own.strike(&impact(0)).unwrap().wait(timeout()).is_ok() && service.status(timeout()).is_ok();
    eventually(
        || format!("files are removed: {:?}", here.shared_memory()),
        || serves() && here.shared_memory().len() <= files,
    );
    drop((own, service));
    assert_eq!(daemon.unwrap().terminate().code(), Some(0));
    assert_eq!(here.shared_memory(), Vec::<PathBuf>::new());
    eventually(|| "descriptors are released", || descriptors(std::process::id()) <= before);
}

#[test]
fn clients_survive_twenty_killed_daemons() {
    daemons_killed(20);
}

#[test]
#[ignore = "minutes"]
fn clients_survive_three_hundred_killed_daemons() {
    daemons_killed(300);
}

/// Kills `kills` clients at random moments, with requests under way and results held. Other clients are served, and the daemon gets all
/// resources back.
fn clients_killed(kills: u64) {
    let _together = ALONE.read();
    let here = TestDirectory::new("deaths");
    here.database("bar", bar(0.08));
    let config =
        here.file("config.toml", "[results]\nbuckets = 16\n[times]\ncleanup_ms = 50\n[log]\nfilter = \"error\"");
    let daemon = Child::start(shatterd(&here).args(["--config", config.to_str().unwrap()]));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let bar = service.object("bar", timeout()).unwrap();
    let strike = |number| bar.strike(&impact(number)).and_then(|mut ticket| ticket.wait(timeout()));
    drop(strike(0).unwrap());
    let found = || [descriptors(daemon.id()), here.shared_memory().len(), here.nodes().len()];
    let baseline = found();
    let mut random = ChaCha8Rng::seed_from_u64(kills);
    for kill in 0..kills {
        // Some before they are connected, most with requests under way.
        let killed_child = if kill % 4 == 0 {
            Child::begin(&mut role(&here, "striker", ""))
        } else {
            Child::start(&mut role(&here, "striker", ""))
        };
        pause(&mut random, 40_000);
        killed_child.kill();
        let result = strike(kill);
        assert!(result.is_ok(), "after kill {kill}: {:?}", result.err());
    }
    eventually(|| "dead clients are removed", || service.status(timeout()).unwrap().clients == 1);
    eventually(|| "nothing computes for them", || service.status(timeout()).unwrap().running == 0);
    // Their buckets are back: half of all are this client's share, the other half a second client's.
    let other = Client::connect_at(&here.place, timeout()).unwrap();
    let theirs = other.object("bar", timeout()).unwrap();
    let held: Vec<_> = (0..8).map(|number| strike(number).unwrap()).collect();
    let others: Vec<_> =
        (0..8).map(|number| theirs.strike(&impact(number)).unwrap().wait(timeout()).unwrap()).collect();
    drop((held, others, theirs, other));
    eventually(|| "the second one is gone", || service.status(timeout()).unwrap().clients == 1);
    println!("  descriptors, segments and nodes: {baseline:?} before, {:?} after", found());
    let back = || found().iter().zip(&baseline).all(|(now, before)| now <= before);
    eventually(|| format!("descriptors, segments and nodes are released: {:?}", found()), back);
    drop((bar, service));
    assert_eq!(daemon.terminate().code(), Some(0));
    assert_eq!(here.shared_memory(), Vec::<PathBuf>::new());
}

#[test]
fn the_daemon_survives_twenty_killed_clients() {
    clients_killed(20);
}

#[test]
#[ignore = "minutes"]
fn the_daemon_survives_three_hundred_killed_clients() {
    clients_killed(300);
}

/// A process that opens an unfinished segment blocks. The daemon that removes dead clients opens it, and so does the next daemon.
#[test]
fn unfinished_segments_of_killed_clients_block_no_client() {
    let _together = ALONE.read();
    let here = TestDirectory::new("unfinished");
    here.database("bar", bar(0.08));
    let config = here.file("config.toml", "[times]\ncleanup_ms = 50");
    let start = || Child::start(shatterd(&here).args(["--config", config.to_str().unwrap()]));
    let connections =
        || here.shared_memory().into_iter().filter(|path| path.extension() == Some("connection".as_ref()));
    let daemon = start();
    let own = here.nodes();
    let killed_child = Child::start(&mut role(&here, "striker", ""));
    let its: Vec<PathBuf> = here.nodes().into_iter().filter(|node| node.is_dir() && !own.contains(node)).collect();
    let theirs: Vec<PathBuf> = connections().collect();
    assert!(!theirs.is_empty(), "{:?}", here.shared_memory());
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let bar = service.object("bar", timeout()).unwrap();
    let served = |number| bar.strike(&impact(number)).and_then(|mut ticket| ticket.wait(timeout()));
    drop(served(0).unwrap());
    leave_unfinished(&theirs);
    leave_tags(&its);
    killed_child.kill();
    eventually(|| "its node is gone", || its.len() == 1 && !its[0].exists());
    eventually(|| "the killed client is removed", || service.status(timeout()).unwrap().clients == 1);
    drop(served(1).unwrap());
    leave_unfinished(&connections().collect::<Vec<_>>());
    daemon.kill();
    let daemon = start();
    eventually(|| "the next daemon serves", || served(2).is_ok());
    let new_client = Client::connect_at(&here.place, timeout()).unwrap().object("bar", timeout()).unwrap();
    assert!(new_client.strike(&impact(3)).unwrap().wait(timeout()).is_ok());
    drop((new_client, bar, service));
    assert_eq!(daemon.terminate().code(), Some(0));
    assert_eq!(here.shared_memory(), Vec::<PathBuf>::new());
}

#[test]
fn a_client_can_connect_right_after_another_is_killed() {
    let _together = ALONE.read();
    let here = TestDirectory::new("heirs");
    here.database("bar", bar(0.08));
    let config = here.file("config.toml", "[service]\nclients_max = 1\n[times]\ncleanup_ms = 100");
    let daemon = Child::start(shatterd(&here).args(["--config", config.to_str().unwrap()]));
    for number in 0..10 {
        let killed_child = Child::start(&mut role(&here, "striker", ""));
        assert_eq!(Client::connect_at(&here.place, Deadline::ms(0)).err().unwrap().kind, ErrorKind::Busy);
        killed_child.kill();
        let bar = Client::connect_at(&here.place, timeout()).unwrap().object("bar", timeout()).unwrap();
        assert!(bar.strike(&impact(number)).unwrap().wait(timeout()).is_ok());
    }
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn suspended_daemons_and_clients_block_no_other_process() {
    let _together = ALONE.read();
    let here = TestDirectory::new("stopped");
    here.database("bar", bar(0.08));
    let daemon = Child::start(&mut shatterd(&here));
    let client = Child::start(&mut role(&here, "striker", ""));
    let bar = Client::connect_at(&here.place, timeout()).unwrap().object("bar", timeout()).unwrap();
    client.signal(Signal::STOP);
    (0..40).for_each(|number| drop(bar.strike(&impact(number)).unwrap().wait(timeout()).unwrap()));
    daemon.signal(Signal::STOP);
    let begun = Instant::now();
    let mut ticket = bar.strike(&impact(1)).unwrap();
    assert_eq!(ticket.wait(Deadline::ms(300)).err().unwrap().kind, ErrorKind::Late);
    assert!(begun.elapsed() < Duration::from_millis(300) + SLACK);
    daemon.signal(Signal::CONT);
    client.signal(Signal::CONT);
    assert!(ticket.wait(timeout()).is_ok(), "it was late, not lost");
    drop((client, ticket, bar));
    assert_eq!(daemon.terminate().code(), Some(0));
}

/// Connects and disconnects `count` clients.
fn connects(count: usize) {
    const CLIENTS_MAX: usize = 8;
    let _alone = ALONE.write();
    let here = TestDirectory::new("guests");
    here.database("vase", "tetra");
    let daemon = InProcess::start(here, &format!("[service]\nclients_max = {CLIENTS_MAX}"));
    let strike = |service: &Client| {
        let vase = service.object("vase", timeout()).unwrap();
        vase.strike(&impact(0)).unwrap().wait(timeout()).unwrap().fragments().len()
    };
    let mut clients: VecDeque<Client> = (0..CLIENTS_MAX).map(|_| daemon.connect()).collect();
    let turn = |clients: &mut VecDeque<Client>| {
        let error = Client::connect_at(&daemon.here.place, Deadline::ms(0)).err().unwrap();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, "clients"), "{error}");
        clients.pop_front();
        let client = daemon.connect();
        assert_eq!(strike(&client), 4);
        clients.push_back(client);
    };
    (0..count / 10).for_each(|_| turn(&mut clients));
    let baseline = (descriptors(std::process::id()), daemon.here.shared_memory().len());
    (count / 10..count).for_each(|_| turn(&mut clients));
    let found = (descriptors(std::process::id()), daemon.here.shared_memory().len());
    println!("{count} connects, {CLIENTS_MAX} at once: descriptors and files {baseline:?}, then {found:?}");
    assert_eq!(found, baseline);
}

#[test]
fn clients_come_and_go() {
    connects(200);
}

#[test]
#[ignore = "minutes"]
fn ten_thousand_clients_come_and_go() {
    connects(10_000);
}

/// Little shared memory: requests that do not fit are refused, no process ends, and freed memory is used again.
fn with_full_memory() {
    let here = TestDirectory::new("crowded");
    here.database("vase", "tetra");
    here.database("large", "large 900");
    let daemon = InProcess::start(here, "[results]\nbucket_mib_max = 1");
    let service = daemon.connect();
    let strike = |name: &str| {
        let object = service.object(name, timeout())?;
        object.strike(&impact(0))?.wait(timeout())
    };
    assert!(strike("vase").is_ok());
    let held: Vec<_> = std::iter::from_fn(|| strike("large").ok()).collect();
    assert!(held.len() > 2, "{}", held.len());
    let error = strike("large").err().unwrap();
    assert_eq!(error.kind, ErrorKind::SharedMemory, "{error}");
    // Results leave memory for clients.
    drop(daemon.connect());
    // Another process takes the rest.
    let filler_file = std::path::Path::new("/dev/shm/greedy");
    let _ = std::fs::write(filler_file, vec![1u8; 64 << 20]);
    for _ in 0..20 {
        let error = strike("large").err().unwrap();
        assert_eq!(error.kind, ErrorKind::SharedMemory, "{error}");
    }
    let late = Client::connect_at(&daemon.here.place, Deadline::ms(100)).err().unwrap();
    assert_eq!(late.kind, ErrorKind::SharedMemory, "{late}");
    drop(held);
    std::fs::remove_file(filler_file).unwrap();
    for name in ["large", "vase"] {
        drop(strike(name).unwrap());
    }
    drop(Client::connect_at(&daemon.here.place, timeout()).unwrap());
    println!("ready");
}

#[test]
fn full_shared_memory_is_an_error_and_not_a_signal() {
    let _together = ALONE.read();
    let namespace = ["unshare", "--user", "--map-root-user", "--mount"];
    let own = "mount -t tmpfs -o size=24m tmpfs /dev/shm";
    let probe = Command::new(namespace[0]).args(&namespace[1..]).args(["sh", "-c", own]).output();
    if !probe.is_ok_and(|probe| probe.status.success()) {
        println!("skipped: this machine allows no shared memory of a process's own");
        return;
    }
    let here = TestDirectory::new("outside");
    let inside = under(&namespace, own, role(&here, "crowded", ""));
    Child::start(&mut { inside }).finish();
}

/// Few descriptors, on both sides: what does not fit is refused, no process ends, and the next client is served.
fn with_few_descriptors() {
    let service = named();
    let mut clients = vec![service];
    let error = loop {
        match Client::connect(&std::env::var("SHATTER_SERVICE").unwrap(), Deadline::ms(200)) {
            Ok(client) => clients.push(client),
            Err(error) => break error,
        }
    };
    println!("a client with few descriptors has {} connections, then: {error}", clients.len());
    let vase = clients[0].object("vase", timeout()).unwrap();
    assert!(vase.strike(&impact(0)).unwrap().wait(timeout()).is_ok());
    println!("ready");
}

#[test]
fn exhausted_descriptors_are_an_error_and_not_a_crash() {
    let _alone = ALONE.write();
    let here = TestDirectory::new("poor");
    here.database("vase", "tetra");
    // A client with few descriptors at a daemon with many.
    let daemon = Child::start(&mut role(&here, "daemon", ""));
    Child::start(&mut under(&[], "ulimit -n 48", role(&here, "poor", ""))).finish();
    assert_eq!(daemon.terminate().code(), Some(0));
    // Clients with many descriptors at a daemon with few.
    let daemon = Child::start(&mut under(&[], "ulimit -n 90", role(&here, "daemon", "")));
    let connect = |deadline: Deadline| {
        let service = Client::connect_at(&here.place, deadline)?;
        let vase = service.object("vase", deadline)?;
        drop(vase.strike(&impact(0)).and_then(|mut ticket| ticket.wait(deadline))?);
        Ok::<_, Error>(service)
    };
    let first = connect(timeout()).unwrap();
    let (mut clients, mut refused) = (Vec::new(), 0);
    for _ in 0..24 {
        match connect(Deadline::ms(200)) {
            Ok(client) => clients.push(client),
            Err(_) => refused += 1,
        }
    }
    println!("a poor daemon serves {} more clients, {refused} were refused", clients.len());
    drop(clients);
    let vase = first.object("vase", timeout()).unwrap();
    assert!(vase.strike(&impact(0)).unwrap().wait(timeout()).is_ok());
    let deadline = timeout();
    while let Err(error) = connect(Deadline::ms(5000)) {
        assert!(!deadline.passed(), "{error}");
    }
    drop((vase, first));
    assert_eq!(daemon.terminate().code(), Some(0));
}

/// Anonymous memory of the process `pid`, KiB: allocated memory without mapped memory.
fn allocated_kib(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find(|line| line.starts_with("RssAnon:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

/// Eight client processes at 80 % of the service's capacity, for `SHATTER_SOAK_MINUTES` (30).
#[test]
#[ignore = "half an hour"]
fn half_an_hour_of_load_leaves_memory_where_it_was() {
    /// First minutes, in which buffers grow to the largest request.
    const WARM: u64 = 3;
    let _alone = ALONE.write();
    let minutes: u64 = std::env::var("SHATTER_SOAK_MINUTES").map_or(30, |text| text.parse().unwrap());
    assert!(minutes > WARM, "the first {WARM} minutes tell nothing");
    let here = TestDirectory::new("soak");
    here.database("bar", bar(0.03));
    let daemon = Child::start(&mut shatterd(&here));
    let load = |how: &[&str]| {
        let (code, text) = shatter(&here, &[&["load", "bar", "--clients", "8", "--json"], how].concat());
        assert_eq!(code, 0, "{text}");
        serde_json::from_str::<serde_json::Value>(&text).unwrap()
    };
    let rate = 0.8 * load(&["--closed", "--seconds", "10"])["throughput_hz"].as_f64().unwrap();
    let mut memory = Vec::new();
    for minute in 0..minutes {
        let (seed, rate) = (minute.to_string(), rate.to_string());
        let reported = load(&["--rate", &rate, "--seconds", "58", "--seed", &seed]);
        memory.push(allocated_kib(daemon.id()));
        println!(
            "minute {minute}: {} of {} ok, p99 {} us, {} KiB, {} descriptors, {} files",
            reported["ok"],
            reported["sent"],
            reported["latency_us"]["p99"],
            memory[memory.len() - 1],
            descriptors(daemon.id()),
            here.shared_memory().len()
        );
    }
    let drift = memory[memory.len() - 1] as f64 / memory[WARM as usize] as f64 - 1.0;
    println!("memory drifted by {:.2} % from minute {WARM} on", 100.0 * drift);
    assert!(drift < 0.02, "{memory:?}");
    assert_eq!(daemon.terminate().code(), Some(0));
}
