//! Reloads under load, with the real program and the real engine: every result is of one version, and none is missing.

mod support;

use rustix::process::Signal;
use shatter_client::{Client, Contact, DegreeRule, Impact, Ticket};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use support::{Child, TestDirectory, bar, shatterd, timeout};

const STRIKES: usize = 10_000;
const RELOADS: usize = 20;
/// Number of clients, with `UNDER_WAY` requests each.
const CLIENTS: usize = 3;
const UNDER_WAY: usize = 4;
/// Different impacts.
const IMPACTS: usize = 16;

fn impact(index: usize) -> Impact {
    let y = 0.06 * (index as f64 / IMPACTS as f64 - 0.5);
    let impact = Impact::new([Contact::new([0.2, y, 0.0]).impulse([-50.0, 0.0, 0.0]).radius(0.05)]);
    impact.degree(DegreeRule::Sites(4 + index as u32 % 5)).seed(index as u64)
}

/// Hashes of the results of all impacts.
type Hashes = Vec<String>;

fn hashes(service: &Client) -> Hashes {
    let bar = service.object("bar", timeout()).unwrap();
    (0..IMPACTS).map(|index| hash(&mut bar.strike(&impact(index)).unwrap())).collect()
}

fn hash(ticket: &mut Ticket) -> String {
    ticket.wait(timeout()).unwrap().digest().output_hash
}

fn generation(service: &Client) -> u32 {
    service.objects(timeout()).unwrap()[0].generation
}

/// Replaces the database by `bytes`, and waits until version `wanted` is served.
fn swap(here: &TestDirectory, daemon: &Child, service: &Client, bytes: &[u8], wanted: u32) {
    here.database("bar", bytes);
    daemon.signal(Signal::HUP);
    let deadline = timeout();
    while generation(service) < wanted {
        assert!(!deadline.passed(), "version {wanted} never came");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(generation(service), wanted);
}

/// Sends requests until all clients together have begun `STRIKES` and all reloads are done; returns the number of results of each version.
fn client(here: &TestDirectory, begun: &AtomicUsize, reloaded: &AtomicBool, versions: &[Hashes; 2]) -> [usize; 2] {
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let bar = service.object("bar", timeout()).unwrap();
    let (mut under_way, mut seen, deadline) = (VecDeque::new(), [0; 2], timeout());
    loop {
        let number = begun.fetch_add(1, Ordering::Relaxed);
        let more = number < STRIKES || !(reloaded.load(Ordering::Relaxed) || deadline.passed());
        if more {
            under_way.push_back((number % IMPACTS, bar.strike(&impact(number % IMPACTS)).unwrap()));
        }
        if more && under_way.len() < UNDER_WAY {
            continue;
        }
        let Some((index, mut ticket)) = under_way.pop_front() else { return seen };
        let hash = hash(&mut ticket);
        let version = versions.iter().position(|hashes| hashes[index] == hash);
        seen[version.unwrap_or_else(|| panic!("impact {index}: {hash} is of neither version"))] += 1;
    }
}

#[test]
fn ten_thousand_strikes_across_twenty_reloads_are_each_of_one_version() {
    let here = TestDirectory::new("load");
    let bytes = [bar(0.08), bar(0.07)];
    here.database("bar", &bytes[0]);
    let config = here.file("config.toml", "[databases]\nwatch_ms = 0\n[log]\nfilter = \"error\"");
    let daemon = Child::start(shatterd(&here).args(["--config", config.to_str().unwrap()]));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let first = hashes(&service);
    swap(&here, &daemon, &service, &bytes[1], 2);
    let versions = [first, hashes(&service)];
    assert!((0..IMPACTS).all(|index| versions[0][index] != versions[1][index]), "the results do not differ");
    let (began, begun, reloaded) = (Instant::now(), AtomicUsize::new(0), AtomicBool::new(false));
    let seen = std::thread::scope(|scope| {
        let strikes = || client(&here, &begun, &reloaded, &versions);
        let clients: Vec<_> = (0..CLIENTS).map(|_| scope.spawn(strikes)).collect();
        for reload in 0..RELOADS {
            // Spreads the reloads over the requests, which go on until the last version is served.
            while begun.load(Ordering::Relaxed) < (2 * reload + 1) * STRIKES / (2 * RELOADS) {
                std::thread::sleep(Duration::from_millis(1));
            }
            swap(&here, &daemon, &service, &bytes[reload % 2], 3 + reload as u32);
        }
        reloaded.store(true, Ordering::Relaxed);
        let seen = clients.into_iter().map(|client| client.join().unwrap());
        seen.fold([0; 2], |sum, seen| [sum[0] + seen[0], sum[1] + seen[1]])
    });
    println!("{seen:?} of the two versions in {:.1} s", began.elapsed().as_secs_f64());
    assert!(seen[0] + seen[1] >= STRIKES);
    assert!(seen.iter().all(|seen| *seen > STRIKES / 10), "{seen:?}");
    let row = service.status(timeout()).unwrap();
    assert_eq!((row.failed, row.refused, row.busy, row.canceled), (0, 0, 0, 0));
    assert_eq!(row.reloads, 1 + RELOADS as u64);
    let deadline = timeout();
    while service.status(timeout()).unwrap().retired > 0 {
        assert!(!deadline.passed(), "a replaced version is never released");
        std::thread::sleep(Duration::from_millis(1));
    }
}
