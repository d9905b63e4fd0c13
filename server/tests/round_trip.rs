//! Round trips through shared memory with a daemon in this process and a toy engine: results, errors, isolation of requests.

mod support;

use iceoryx2::prelude::{NodeBuilder, SignalHandlingMode};
use shatter_client::{
    Client, Contact, Deadline, DegreeRule, Error, ErrorKind, Impact, Poll, Progress, StageKind, Status, Ticket,
};
use shatter_proto::request::RequestWire;
use shatter_proto::result::{AlignedBlock, ResultHeader};
use shatter_transport::{Ipc, STRIKE_SERVICE, config, service_name};
use std::future::IntoFuture;
use std::io::{Read, Write};
use support::{InProcess, TestDirectory, addresses, timeout, within};

fn start(objects: &[(&str, &str)], settings: &str) -> InProcess {
    let here = TestDirectory::new("trip");
    for (name, word) in objects {
        here.database(name, word);
    }
    InProcess::start(here, settings)
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

fn refused(service: &Client, object: &str, impact: &Impact) -> Error {
    let object = service.object(object, timeout()).unwrap();
    object.strike(impact).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap()
}

/// Waits with a timeout until the status holds: the daemon counts a result after it has sent it.
#[track_caller]
fn eventually(service: &Client, says: impl Fn(&Status) -> bool) {
    for _ in 0..2000 {
        if says(&service.status(timeout()).unwrap()) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("never: {:?}", service.status(timeout()).unwrap());
}

#[test]
fn fragments_come_back_through_shared_memory() {
    let daemon = start(&[("vase ä", "tetra")], "");
    let service = daemon.connect();
    let vase = service.object("vase ä", timeout()).unwrap();
    assert_eq!((vase.facts().material.as_str(), vase.facts().gamma_j_m2), ("toy", 2.0));
    let mut ticket = vase.strike(&impact().degree(DegreeRule::Sites(3)).seed(9)).unwrap();
    let result = ticket.wait(timeout()).unwrap();
    let summary = result.summary();
    assert_eq!((summary.object.as_str(), summary.sites, summary.seed), ("vase ä", 3, 9));
    assert_eq!(result.fragments().len(), 3);
    for (i, fragment) in result.fragments().enumerate() {
        assert!(fragment.is_closed() && fragment.id() as usize == i);
        assert_eq!((fragment.positions().len(), fragment.indices().len(), fragment.mass_kg()), (4, 12, 2.0));
        let run = fragment.runs().next().unwrap();
        assert_eq!((run.neighbor, run.index_first, run.vertex_first), (None, 0, 0));
        assert_eq!((run.indices, run.positions), (fragment.indices(), fragment.positions()));
    }
    let stages: Vec<StageKind> = result.stages().map(|cost| cost.stage).collect();
    assert_eq!(stages, StageKind::ALL);
    let ran: Vec<StageKind> = result.stages().filter(|cost| cost.has_run).map(|cost| cost.stage).collect();
    assert_eq!(ran, [StageKind::Load, StageKind::Fragments]);
    // The ticket is spent, and returns that.
    assert_eq!(ticket.poll().err().unwrap().kind, ErrorKind::TicketSpent);
}

#[test]
fn writer_and_reader_both_work_in_the_mapped_segment() {
    let daemon = start(&[("mapped", "tetra")], "");
    let vase = daemon.connect().object("mapped", timeout()).unwrap();
    let result = vase.strike(&impact()).unwrap().wait(timeout()).unwrap();
    let mapped = daemon.here.mapped();
    assert!(within(&result.address_range(), &mapped), "{:x?} is not in {mapped:x?}", result.address_range());
    let view = result.raw_view();
    for address in [view.positions.as_ptr() as usize, view.indices.as_ptr() as usize] {
        assert!(result.address_range().contains(&address) && address.is_multiple_of(64));
    }
    let written = addresses("mapped");
    assert_eq!(written.len(), 3, "positions, indices and merge pairs");
    for range in written {
        assert!(within(&range, &mapped), "{range:x?} is not in {mapped:x?}");
        assert!(!within(&range, &[result.address_range()]), "the daemon has a mapping of its own");
    }
}

#[test]
fn equal_strikes_give_equal_hashes() {
    let daemon = start(&[("vase", "tetra")], "");
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    let digest = |seed| vase.strike(&impact().seed(seed)).unwrap().wait(timeout()).unwrap().digest();
    let (a, b, c) = (digest(1), digest(1), digest(2));
    assert_eq!(a, b);
    assert_ne!(a.output_hash, c.output_hash);
    assert_eq!((a.output_hash.len(), a.sections.len()), (16, 8));
    assert_eq!(a.sections[6], c.sections[6]);
}

#[test]
fn polling_never_blocks_and_many_strikes_may_be_under_way() {
    let daemon = start(&[("vase", "tetra")], "");
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    let mut tickets: Vec<_> = (0..40).map(|seed| vase.strike(&impact().seed(seed)).unwrap()).collect();
    let mut results = Vec::new();
    let deadline = timeout();
    while !tickets.is_empty() && !deadline.passed() {
        tickets.retain_mut(|ticket| match ticket.poll().unwrap() {
            Poll::Pending => true,
            Poll::Ready(result) => {
                results.push(result.summary().seed);
                false
            }
        });
        std::thread::yield_now();
    }
    results.sort_unstable();
    assert_eq!(results, (0..40).collect::<Vec<u64>>());
}

#[test]
fn one_connection_serves_several_threads() {
    let daemon = start(&[("vase", "tetra")], "");
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let vase = vase.clone();
            scope.spawn(move || {
                for seed in 0..20 {
                    let result = vase.strike(&impact().seed(thread * 100 + seed)).unwrap().wait(timeout()).unwrap();
                    assert_eq!(result.summary().seed, thread * 100 + seed);
                }
            });
        }
    });
    eventually(&daemon.connect(), |row| row.completed == 80);
}

#[test]
fn errors_name_rule_and_field() {
    let daemon = start(&[("vase", "tetra"), ("worn", "?")], "");
    let service = daemon.connect();
    let kind = |name| service.object(name, timeout()).err().unwrap();
    assert_eq!((kind("pot").kind, kind("pot").at), (ErrorKind::UnknownObject, "pot".to_owned()));
    assert_eq!(kind("worn").kind, ErrorKind::CorruptObject);
    assert!(kind("worn").message.contains("checksum"), "{}", kind("worn"));
    let check = |impact: Impact, kind: ErrorKind, at: &str| {
        let error = refused(&service, "vase", &impact);
        assert_eq!((error.kind, error.at.as_str()), (kind, at), "{error}");
    };
    check(Impact::new([Contact::new([0.0; 3])]), ErrorKind::Impulse, "contacts[0].impulse_ns");
    let contacts = [[0.0, 0.1, 0.0], [f64::NAN; 3]].map(|point_m| Contact::new(point_m).impulse([-1.0, 0.0, 0.0]));
    check(Impact::new(contacts), ErrorKind::ContactPoint, "contacts[1].point_m");
    check(impact().gamma(-1.0), ErrorKind::Gamma, "gamma_j_m2");
    check(impact().degree(DegreeRule::Sites(0)), ErrorKind::Degree, "0");
    check(impact().degree(DegreeRule::Sites(3)).fragments_max(2), ErrorKind::CapExceeded, "fragments_max");
    check(impact().bytes_max(100), ErrorKind::CapExceeded, "bytes_max");
    // The refused requests were counted, and the daemon still serves.
    let result = service.object("vase", timeout()).unwrap().strike(&impact()).unwrap().wait(timeout()).unwrap();
    assert!(!result.is_whole());
    eventually(&service, |row| row.refused == 2);
}

#[test]
fn the_threshold_alone_has_no_fragments() {
    let daemon = start(&[("vase", "tetra")], "");
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    let result = vase.strike(&impact().threshold_only()).unwrap().wait(timeout()).unwrap();
    assert!(result.is_whole());
    assert_eq!(result.summary().threshold_impulse_factor, 0.5);
}

#[test]
fn a_panic_fails_its_own_strike_alone() {
    let daemon = start(&[("bomb", "panic"), ("vase", "tetra")], "");
    let service = daemon.connect();
    for _ in 0..3 {
        let error = refused(&service, "bomb", &impact());
        assert_eq!(error.kind, ErrorKind::Failed);
        assert!(error.message.contains("the toy is broken"), "{error}");
    }
    assert!(service.object("vase", timeout()).unwrap().strike(&impact()).unwrap().wait(timeout()).is_ok());
    eventually(&service, |row| row.failed == 3);
}

#[test]
fn a_full_queue_refuses_at_once_and_status_still_answers() {
    let daemon = start(&[("slow", "slow")], "[compute]\nrequests_at_once = 1\nqueue_max = 2");
    let service = daemon.connect();
    let slow = service.object("slow", timeout()).unwrap();
    let tickets: Vec<_> = (0..3).map(|_| slow.strike(&impact()).unwrap()).collect();
    let error = slow.strike(&impact()).unwrap().wait(timeout()).err().unwrap();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, "queue"), "{error}");
    assert!(error.kind.retry());
    eventually(&service, |row| (row.running, row.queued, row.busy) == (1, 2, 1));
    drop(tickets);
}

#[test]
fn errors_are_delivered_when_result_buffers_are_exhausted() {
    let daemon = start(&[("vase", "tetra")], "[results]\nbuckets = 2\nheld_max = 2");
    let services = [daemon.connect(), daemon.connect()];
    let strike =
        |service: &Client| service.object("vase", timeout()).unwrap().strike(&impact()).unwrap().wait(timeout());
    let held = services.each_ref().map(|service| strike(service).unwrap());
    for _ in 0..5 {
        let error = strike(&services[0]).err().unwrap();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, "results"), "{error}");
    }
    eventually(&services[0], |row| (row.busy, row.buckets_used_max) == (5, 2));
    assert_eq!(held[0].fragments().len(), 1);
    drop(held);
    assert!(strike(&services[0]).is_ok());
}

#[test]
fn no_client_holds_more_than_its_share_of_results() {
    let daemon = start(&[("vase", "tetra")], "[results]\nbuckets = 4");
    let [holding_client, other] = [daemon.connect(), daemon.connect()];
    let strike =
        |service: &Client| service.object("vase", timeout()).unwrap().strike(&impact()).unwrap().wait(timeout());
    let held = [strike(&holding_client).unwrap(), strike(&holding_client).unwrap()];
    let error = strike(&holding_client).err().unwrap();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, "share"), "{error}");
    assert!((0..3).all(|_| strike(&other).is_ok()));
    drop(held);
    assert!(strike(&holding_client).is_ok());
}

#[test]
fn a_client_that_never_reads_does_not_affect_others() {
    let daemon = start(&[("vase", "tetra")], "[results]\nbuckets = 4");
    let [silent, other] = [daemon.connect(), daemon.connect()];
    let vase = silent.object("vase", timeout()).unwrap();
    let mut unread: Vec<_> = (0..10).map(|_| vase.strike(&impact()).unwrap()).collect();
    eventually(&other, |row| row.completed == 2);
    let theirs = other.object("vase", timeout()).unwrap();
    (0..20).for_each(|_| drop(theirs.strike(&impact()).unwrap().wait(timeout()).unwrap()));
    // The client waits for the last result without reading the others: they block it, for a limited time.
    let error = unread.pop().unwrap().wait(timeout()).err().unwrap();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, "share"), "{error}");
    eventually(&other, |row| (row.completed, row.busy, row.queued) == (22, 8, 0));
    unread.drain(..2).for_each(|mut ticket| drop(ticket.wait(timeout()).unwrap()));
    // A client that reads results as they come is not blocked, however many requests are under way.
    let mut read: Vec<_> = (0..40).map(|_| vase.strike(&impact()).unwrap()).collect();
    read.iter_mut().for_each(|ticket| drop(ticket.wait(timeout()).unwrap()));
}

#[test]
fn connections_outlive_the_daemon_and_say_what_was_lost() {
    let mut daemon = start(&[("slow", "slow"), ("vase", "tetra")], "");
    let service = daemon.connect();
    let [slow, vase] = ["slow", "vase"].map(|name| service.object(name, timeout()).unwrap());
    let mut under_way = slow.strike(&impact()).unwrap();
    let unread = vase.strike(&impact()).unwrap();
    eventually(&service, |row| row.completed == 1);
    daemon.end().unwrap();
    let lost = under_way.wait(timeout()).err().unwrap();
    let said = ["safe", "start one with `shatterd serve --service "].iter().all(|part| lost.message.contains(part));
    assert!(lost.kind == ErrorKind::Lost && lost.kind.retry() && said, "{lost}");
    let gone = vase.strike(&impact()).err().unwrap();
    assert!(matches!(gone.kind, ErrorKind::Lost | ErrorKind::NoDaemon), "{gone}");
    assert_eq!(vase.strike(&impact()).err().unwrap().kind, ErrorKind::NoDaemon, "known by now, and said at once");
    daemon.again();
    assert_eq!(vase.strike(&impact()).unwrap().wait(timeout()).unwrap().fragments().len(), 1);
    assert_eq!((service.status(timeout()).unwrap().restarts, service.objects(timeout()).unwrap().len()), (1, 2));
    drop(unread);
}

#[test]
fn a_result_larger_than_a_bucket_is_refused() {
    let daemon = start(&[("large", "large 20480"), ("fits", "large 900")], "");
    let service = daemon.connect();
    assert_eq!(refused(&service, "large", &impact()).kind, ErrorKind::ResultTooLarge);
    let fits = service.object("fits", timeout()).unwrap().strike(&impact()).unwrap().wait(timeout()).unwrap();
    assert!(fits.bytes() > 900 * 1024);
}

#[test]
fn tickets_can_be_awaited_and_a_dropped_future_cancels() {
    let daemon = start(&[("vase", "tetra"), ("slow", "slow")], "[compute]\nrequests_at_once = 1");
    let service = daemon.connect();
    let [vase, slow] = ["vase", "slow"].map(|name| service.object(name, timeout()).unwrap());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
    runtime.block_on(async {
        let tasks: Vec<_> = (0..20).map(|_| tokio::spawn(vase.strike(&impact()).unwrap().into_future())).collect();
        for task in tasks {
            assert_eq!(task.await.unwrap().unwrap().fragments().len(), 1);
        }
        let rejected = service.object("vase", timeout()).unwrap().strike(&impact().degree(DegreeRule::Sites(0)));
        assert_eq!(rejected.err().unwrap().kind, ErrorKind::Degree);
        let error = vase.strike(&impact().bytes_max(100)).unwrap().await.err().unwrap();
        assert_eq!(error.kind, ErrorKind::CapExceeded);
        let slow = slow.strike(&impact()).unwrap().into_future();
        assert!(tokio::time::timeout(std::time::Duration::from_millis(30), slow).await.is_err());
        assert!(vase.strike(&impact()).unwrap().await.is_ok(), "the only worker is free again");
    });
    eventually(&service, |row| row.canceled == 1);
}

#[test]
fn a_ticket_tells_how_far_its_strike_is() {
    let daemon = start(&[("gate", "gate 1")], "[compute]\nrequests_at_once = 1");
    let gate = daemon.here.databases().join("gate.gate");
    std::fs::write(&gate, "").unwrap();
    let object = daemon.connect().object("gate", timeout()).unwrap();
    let [mut first, mut second] = [object.strike(&impact()).unwrap(), object.strike(&impact()).unwrap()];
    let until = |ticket: &mut Ticket, holds: fn(Progress) -> bool| {
        let deadline = timeout();
        while !holds(ticket.progress()) {
            assert!(!deadline.passed(), "never");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    };
    until(&mut first, |at| matches!(at, Progress::Computing { stage: StageKind::Load, age } if !age.is_zero()));
    (0..20).for_each(|_| until(&mut second, |progress| progress == Progress::Waiting));
    std::fs::remove_file(gate).unwrap();
    for ticket in [&mut first, &mut second] {
        drop(ticket.wait(timeout()).unwrap());
        assert_eq!(ticket.progress(), Progress::Ended);
    }
}

#[test]
fn a_dropped_ticket_frees_its_worker() {
    let daemon = start(&[("slow", "slow"), ("vase", "tetra")], "[compute]\nrequests_at_once = 1");
    let service = daemon.connect();
    let slow = service.object("slow", timeout()).unwrap();
    let mut computing = slow.strike(&impact()).unwrap();
    let waiting = slow.strike(&impact()).unwrap();
    assert_eq!(computing.wait(Deadline::ms(20)).err().unwrap().kind, ErrorKind::Late);
    drop((computing, waiting));
    // The only worker is free again.
    assert!(service.object("vase", timeout()).unwrap().strike(&impact()).unwrap().wait(timeout()).is_ok());
    eventually(&service, |row| row.canceled == 2);
}

#[test]
fn malformed_requests_are_rejected() {
    let daemon = start(&[("vase", "tetra")], "");
    let settings = config(&daemon.here.instance()).unwrap();
    let node = NodeBuilder::new()
        .config(&settings)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Ipc>()
        .unwrap();
    let strikes = node
        .service_builder(&service_name(STRIKE_SERVICE).unwrap())
        .request_response::<RequestWire, [AlignedBlock]>()
        .response_user_header::<ResultHeader>()
        .open()
        .unwrap();
    let client = strikes.client_builder().create().unwrap();
    for byte in [0x00, 0x01, 0x7f, 0xff] {
        let wire: RequestWire = bytemuck::pod_read_unaligned(&[byte; size_of::<RequestWire>()]);
        let pending = client.send_copy(wire).unwrap();
        let deadline = timeout();
        while pending.is_connected() && !deadline.passed() {
            std::thread::yield_now();
        }
        assert!(pending.receive().unwrap().is_none());
    }
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    assert!(vase.strike(&impact()).unwrap().wait(timeout()).is_ok());
}

#[test]
fn results_outlive_connection_and_daemon() {
    let mut daemon = start(&[("vase", "tetra")], "");
    let result = {
        let vase = daemon.connect().object("vase", timeout()).unwrap();
        vase.strike(&impact()).unwrap().wait(timeout()).unwrap()
    };
    daemon.end().unwrap();
    assert!(result.fragments().all(|fragment| fragment.is_closed()));
}

#[test]
fn a_stopping_daemon_rejects_queued_requests_and_removes_its_files() {
    let mut daemon = start(&[("slow", "slow")], "[compute]\nrequests_at_once = 1");
    let service = daemon.connect();
    let slow = service.object("slow", timeout()).unwrap();
    let _computing = slow.strike(&impact()).unwrap();
    let mut waiting = slow.strike(&impact()).unwrap();
    while service.status(timeout()).unwrap().queued == 0 {
        std::thread::yield_now();
    }
    let failure = std::thread::scope(|scope| {
        let failure = scope.spawn(|| waiting.wait(timeout()).err().unwrap());
        daemon.end().unwrap();
        failure.join().unwrap()
    });
    assert_eq!(failure.kind, ErrorKind::Stopping, "{failure}");
    drop((_computing, waiting, slow, service));
    assert!(!daemon.here.place.hello().exists());
}

#[test]
fn connecting_without_a_daemon_fails_at_once() {
    let here = TestDirectory::new("absent");
    let absent = || Client::connect_at(&here.place, timeout()).err().unwrap();
    assert_eq!(absent().kind, ErrorKind::NoDaemon);
    here.place.create().unwrap();
    assert_eq!(absent().kind, ErrorKind::NoDaemon);
    // A hello file that a killed daemon left does not count.
    std::fs::write(here.place.hello(), "{}").unwrap();
    std::fs::write(here.place.lock(), "1").unwrap();
    assert_eq!(absent().kind, ErrorKind::NoDaemon);
}

#[test]
fn the_client_limit_holds_and_slots_are_released() {
    const CLIENTS_MAX: usize = 8;
    let daemon = start(&[("vase", "tetra")], &format!("[service]\nclients_max = {CLIENTS_MAX}"));
    let connect = || Client::connect_at(&daemon.here.place, timeout());
    let mut clients: Vec<Client> = (0..CLIENTS_MAX).map(|_| connect().unwrap()).collect();
    let error = loop {
        match connect() {
            Ok(client) => clients.push(client),
            Err(error) => break error,
        }
        assert!(clients.len() < 2 * CLIENTS_MAX);
    };
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, "clients"), "{error}");
    clients.pop();
    let vase = connect().unwrap().object("vase", timeout()).unwrap();
    assert!(vase.strike(&impact()).unwrap().wait(timeout()).is_ok());
}

#[test]
fn a_stopping_daemon_finishes_accepted_requests_and_rejects_new_ones() {
    let mut daemon = start(&[("gate", "gate 1"), ("vase", "tetra")], "[compute]\nrequests_at_once = 1");
    let gate = daemon.here.databases().join("gate.gate");
    std::fs::write(&gate, "").unwrap();
    let service = daemon.connect();
    let [kept, vase] = ["gate", "vase"].map(|name| service.object(name, timeout()).unwrap());
    let mut finished = [kept.strike(&impact()).unwrap(), vase.strike(&impact()).unwrap()];
    eventually(&service, |row| (row.running, row.queued) == (1, 1));
    std::thread::scope(|scope| {
        let ending = scope.spawn(|| daemon.end().unwrap());
        eventually(&service, |row| row.is_ending);
        let refused = vase.strike(&impact()).unwrap().wait(timeout()).err().unwrap();
        assert_eq!(refused.kind, ErrorKind::Stopping, "{refused}");
        std::fs::remove_file(gate).unwrap();
        finished.iter_mut().for_each(|ticket| drop(ticket.wait(timeout()).unwrap()));
        ending.join().unwrap();
    });
}

/// Sends a request of a scraper or a supervisor; returns status line and body.
fn get(port: u16, request: &str) -> (String, String) {
    let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(std::time::Duration::from_secs(30))).unwrap();
    stream.write_all(format!("{request} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let (head, body) = text.split_once("\r\n\r\n").unwrap();
    (head.lines().next().unwrap().to_owned(), body.to_owned())
}

#[test]
fn supervisors_and_scrapers_are_answered_on_a_loopback_port() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let mut daemon = start(&[("vase", "tetra")], &format!("[operations]\nport = {free}"));
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    drop(vase.strike(&impact()).unwrap().wait(timeout()).unwrap());
    let (head, body) = get(free, "GET /readyz");
    assert!(head.contains("200") && body.starts_with("serving: 1 of 1 objects ready"), "{head} {body}");
    assert!(get(free, "GET /healthz").0.contains("200"));
    let wanted =
        ["requests_total{end=\"completed\"} 1", "stage_seconds_bucket{", "queued 0", "pool_buckets 64", "restarts 0"];
    eventually(&daemon.connect(), |row| row.completed == 1);
    let (_, body) = get(free, "GET /metrics");
    wanted.iter().for_each(|line| assert!(body.contains(&format!("shatter_{line}")), "{line}: {body}"));
    assert!(body.ends_with("# EOF\n"));
    assert!(get(free, "GET /secrets").0.contains("404") && get(free, "POST /metrics").0.contains("405"));
    // Silent connections leave capacity for others, and garbage affects no other connection.
    let _silent: Vec<_> = (0..8).map(|_| std::net::TcpStream::connect(("127.0.0.1", free)).unwrap()).collect();
    assert!(get(free, "GET /healthz").0.contains("200"));
    assert!(get(free, "\u{1}\u{2}\u{3}").0.contains("400"));
    let taken = InProcess::refused(TestDirectory::new("taken"), &format!("[operations]\nport = {free}"));
    assert_eq!((taken.kind, taken.at.as_str()), (ErrorKind::Port, "operations.port"), "{taken}");
    daemon.end().unwrap();
    assert!(std::net::TcpStream::connect(("127.0.0.1", free)).is_err());
}

#[test]
fn metrics_are_written_as_text() {
    let mut daemon = start(&[("vase", "tetra")], "");
    let vase = daemon.connect().object("vase", timeout()).unwrap();
    drop(vase.strike(&impact()).unwrap().wait(timeout()).unwrap());
    drop(vase);
    let metrics = daemon.here.place.metrics();
    daemon.end().unwrap();
    let text = std::fs::read_to_string(metrics).unwrap();
    assert!(text.contains("shatter_requests_total{end=\"completed\"} 1"), "{text}");
    assert!(text.contains("shatter_stage_seconds_bucket"), "{text}");
}
