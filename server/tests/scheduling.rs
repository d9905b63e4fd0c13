//! Order of requests by deadline, immediate errors, and late requests: a daemon in this process with one computing thread.

mod support;

use shatter_client::{Client, Contact, Deadline, DegreeRule, ErrorKind, Impact, Object, OverrunCause, Ticket};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use support::{InProcess, TestDirectory, eventually, order, timeout};

/// A daemon whose only worker is busy with a request until the gate opens.
struct BusyDaemon {
    daemon: InProcess,
    gate: PathBuf,
    service: Client,
    blocking_ticket: Ticket,
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

fn object(service: &Client, name: &str) -> Object {
    service.object(name, timeout()).unwrap()
}

impl BusyDaemon {
    fn new(objects: &[&str], queue_max: usize) -> Self {
        let here = TestDirectory::new("urgent");
        objects.iter().for_each(|name| here.database(name, "tetra"));
        here.database("keeper", "gate 2");
        here.database("slow", "slow");
        let gate = here.databases().join("keeper.gate");
        std::fs::write(&gate, "").unwrap();
        let daemon = InProcess::start(here, &format!("[compute]\nrequests_at_once = 1\nqueue_max = {queue_max}"));
        let service = daemon.connect();
        let blocking_ticket = object(&daemon.connect(), "keeper").strike(&impact()).unwrap();
        let busy = Self { daemon, gate, service, blocking_ticket };
        busy.until(|running, _| running == 1);
        busy
    }

    /// Waits until the numbers of computing and waiting requests hold.
    fn until(&self, holds: impl Fn(u32, u32) -> bool) {
        let deadline = timeout();
        loop {
            let status = self.service.status(timeout()).unwrap();
            if holds(status.running, status.queued) {
                return;
            }
            assert!(!deadline.passed(), "never");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Sends a request, and waits until it is in the queue.
    fn send(&self, service: &Client, name: &str, impact: &Impact, queued: u32) -> Ticket {
        let ticket = object(service, name).strike(impact).unwrap();
        self.until(|_, found| found == queued);
        ticket
    }

    fn open(&mut self) {
        std::fs::remove_file(&self.gate).unwrap();
        drop(self.blocking_ticket.wait(timeout()).unwrap());
    }
}

fn refused(mut ticket: Ticket) -> shatter_client::Error {
    ticket.wait(timeout()).err().unwrap()
}

#[test]
fn the_earliest_deadline_goes_first() {
    let mut busy = BusyDaemon::new(&["never-d", "late-d", "soon-d"], 99);
    let within = |seconds| impact().deadline(Duration::from_secs(seconds));
    let mut tickets = vec![busy.send(&busy.service, "never-d", &impact(), 1)];
    tickets.push(busy.send(&busy.service, "late-d", &within(120), 2));
    tickets.push(busy.send(&busy.service, "soon-d", &within(60), 3));
    busy.open();
    tickets.iter_mut().for_each(|ticket| drop(ticket.wait(timeout()).unwrap()));
    assert_eq!(order("-d"), ["soon-d", "late-d", "never-d"]);
}

/// On several threads, each with a client of its own: what takes a millisecond of waiting takes the kernel a tick of its clock.
#[test]
fn no_worker_waits_past_a_deadline() {
    const THREADS: u64 = 12;
    let busy = BusyDaemon::new(&["vase-z"], 99);
    let wait = |own: u64| {
        let service = busy.daemon.connect();
        let mut waiting = object(&service, "vase-z").strike(&impact()).unwrap();
        let all = (0..4000).chain((0..2000).map(|ns| 500 * ns));
        for ns in all.skip(own as usize).step_by(THREADS as usize) {
            let deadline = Deadline::after(Duration::from_nanos(ns));
            service.wait_for_reply(deadline);
            if ns % 50 == 0 {
                assert_eq!(waiting.wait(deadline).err().unwrap().kind, ErrorKind::Late);
            }
        }
    };
    let wait = &wait;
    std::thread::scope(|scope| (0..THREADS).for_each(|own| drop(scope.spawn(move || wait(own)))));
}

#[test]
fn clients_take_turns() {
    let mut busy = BusyDaemon::new(&["greedy-t", "modest-t"], 99);
    let other = busy.daemon.connect();
    let mut tickets: Vec<Ticket> = (1..=20).map(|n| busy.send(&busy.service, "greedy-t", &impact(), n)).collect();
    tickets.push(busy.send(&other, "modest-t", &impact(), 21));
    busy.open();
    tickets.iter_mut().for_each(|ticket| drop(ticket.wait(timeout()).unwrap()));
    let found = order("-t");
    let place = found.iter().position(|name| name == "modest-t").unwrap();
    assert!(place < 10 && found.len() == 21, "{found:?}");
}

#[test]
fn a_full_queue_is_shared_and_reports_when_to_retry() {
    let mut busy = BusyDaemon::new(&["vase-f"], 6);
    let other = busy.daemon.connect();
    let mut taken: Vec<Ticket> = (1..=4).map(|n| busy.send(&busy.service, "vase-f", &impact(), n)).collect();
    let share = refused(object(&busy.service, "vase-f").strike(&impact()).unwrap());
    taken.extend((5..=6).map(|n| busy.send(&other, "vase-f", &impact(), n)));
    let full = refused(object(&other, "vase-f").strike(&impact()).unwrap());
    for (error, at) in [(&share, "share"), (&full, "queue")] {
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Busy, at), "{error}");
        assert!(error.retry_after.is_some_and(|wait| wait > Duration::ZERO), "{error:?}");
    }
    busy.open();
    taken.iter_mut().for_each(|ticket| drop(ticket.wait(timeout()).unwrap()));
}

#[test]
fn late_requests_are_canceled_and_hopeless_ones_rejected_at_once() {
    let mut busy = BusyDaemon::new(&["vase-l"], 99);
    let within = |ms| impact().deadline(Duration::from_millis(ms));
    let late = refused(object(&busy.service, "vase-l").strike(&within(20)).unwrap());
    assert_eq!((late.kind, late.at.as_str()), (ErrorKind::Late, "deadline"), "while the keeper still computes: {late}");
    std::thread::sleep(Duration::from_millis(100));
    busy.open();
    let late = refused(object(&busy.service, "slow").strike(&within(20)).unwrap());
    assert_eq!((late.kind, late.at.as_str()), (ErrorKind::Late, "deadline"), "it would compute for a minute: {late}");
    // The daemon knows that the gate's object takes a tenth of a second.
    let begun = Instant::now();
    let too_late = refused(object(&busy.service, "keeper").strike(&within(50)).unwrap());
    assert_eq!((too_late.kind, too_late.at.as_str()), (ErrorKind::Late, "deadline"), "{too_late}");
    assert!(too_late.message.contains("expected"), "{too_late} after {:?}", begun.elapsed());
    drop(object(&busy.service, "keeper").strike(&within(60_000)).unwrap().wait(timeout()).unwrap());
    busy.until(|running, queued| running == 0 && queued == 0);
}

/// Requests of four clients, ten each, sent at once, with deadlines of `ms(rank)`; the names of the objects contain the ranks.
fn at_once(daemon: &InProcess, names: &[String], ms: impl Fn(u64) -> u64 + Sync) -> Vec<(Client, Vec<Ticket>)> {
    let together = std::sync::Barrier::new(CLIENTS);
    std::thread::scope(|scope| {
        let strikes = |client: usize| {
            let service = daemon.connect();
            let objects: Vec<Object> = (0..EACH).map(|own| object(&service, &names[client * EACH + own])).collect();
            let (together, ms) = (&together, &ms);
            move || {
                together.wait();
                let send = |own: &Object| {
                    let rank: u64 = own.facts().name[1..3].parse().unwrap();
                    own.strike(&impact().deadline(Duration::from_millis(ms(rank)))).unwrap()
                };
                (service, objects.iter().map(send).collect::<Vec<Ticket>>())
            }
        };
        let threads: Vec<_> = (0..CLIENTS).map(|client| scope.spawn(strikes(client))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

const CLIENTS: usize = 4;
const EACH: usize = 10;

/// Names of objects that contain ranks, mixed: every client has urgent and less urgent requests.
fn names(ending: &str) -> Vec<String> {
    (0..CLIENTS * EACH).map(|number| format!("w{:02}-{ending}", number * 7 % (CLIENTS * EACH))).collect()
}

#[test]
fn forty_impacts_of_one_moment_are_all_answered_by_deadline() {
    let names = names("m");
    let mut busy = BusyDaemon::new(&names.iter().map(String::as_str).collect::<Vec<_>>(), 99);
    let sent = at_once(&busy.daemon, &names, |rank| 1000 * (100 + rank));
    busy.until(|_, queued| queued == (CLIENTS * EACH) as u32);
    busy.open();
    for mut ticket in sent.into_iter().flat_map(|(_, tickets)| tickets) {
        drop(ticket.wait(timeout()).unwrap());
    }
    let mut sorted = names.clone();
    sorted.sort();
    assert_eq!(order("-m"), sorted);
}

/// One after another the requests take longer than the least urgent deadline. Whatever the machine does, each is complete or late, urgent
/// ones come first among the complete ones, and a late one is not computed to its end.
#[test]
fn forty_impacts_that_cannot_all_be_in_time_are_answered_or_late() {
    let here = TestDirectory::new("wall");
    let names = names("n");
    names.iter().for_each(|name| here.database(name, "brief 5"));
    let daemon = InProcess::start(here, "[compute]\nrequests_at_once = 1");
    let sent = at_once(&daemon, &names, |rank| 40 + 2 * rank);
    let (mut completed, mut late) = (0, 0);
    for mut ticket in sent.into_iter().flat_map(|(_, tickets)| tickets) {
        match ticket.wait(timeout()) {
            Ok(_) => completed += 1,
            Err(error) => {
                assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Late, "deadline"), "{error}");
                late += 1;
            }
        }
    }
    assert_eq!(completed + late, CLIENTS * EACH);
    assert!(late > 0, "40 of 5 ms in 118 ms");
    assert_eq!(order("-n").len(), completed, "what is late is not written");
}

/// Long requests say nothing about short ones, and a wrong prediction is corrected in the end.
#[test]
fn a_wrong_forecast_recovers() {
    let here = TestDirectory::new("wrong");
    here.database("vase", "sites 4");
    let daemon = InProcess::start(here, "[compute]\nrequests_at_once = 1");
    let service = daemon.connect();
    let vase = object(&service, "vase");
    let many = impact().degree(DegreeRule::Sites(100));
    (0..2).for_each(|_| drop(vase.strike(&many).unwrap().wait(timeout()).unwrap()));
    let short_deadline = |sites| impact().degree(DegreeRule::Sites(sites)).deadline(Duration::from_millis(200));
    drop(vase.strike(&short_deadline(2)).unwrap().wait(timeout()).unwrap());
    // About as many sites as those that took 400 ms, and predicted to take as long. The request takes half of that, and is tried in the
    // end.
    let refused = (0..60).take_while(|_| {
        std::thread::sleep(Duration::from_millis(25));
        let error = vase.strike(&short_deadline(64)).unwrap().wait(timeout()).err();
        error.is_some_and(|error| {
            assert!(error.kind == ErrorKind::Late && error.retry_after.is_none(), "{error:?}");
            error.message.contains("expected")
        })
    });
    assert!((1..60).contains(&refused.count()));
}

/// A request that misses its time because it waited reports that; one with enough time does not.
#[test]
fn a_time_missed_in_the_queue_is_reported() {
    let here = TestDirectory::new("missed");
    here.database("gate", "gate 1");
    here.database("vase", "tetra");
    let gate = here.databases().join("gate.gate");
    std::fs::write(&gate, "").unwrap();
    let daemon = InProcess::start(here, "[compute]\nthreads = 1");
    let service = daemon.connect();
    let [first, vase] = ["gate", "vase"].map(|name| service.object(name, timeout()).unwrap());
    let impact = Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])]);
    let mut tickets = [first.strike(&impact).unwrap(), vase.strike(&impact.clone().time_ms(1.0)).unwrap()];
    eventually(|| "one waits", || service.status(timeout()).unwrap().queued == 1);
    std::thread::sleep(Duration::from_millis(5));
    std::fs::remove_file(gate).unwrap();
    let [held, missed] = tickets.each_mut().map(|ticket| ticket.wait(timeout()).unwrap().summary().missed_time);
    assert_eq!((held, missed.map(|missed| missed.cause)), (None, Some(OverrunCause::Queue)));
    let roomy = vase.strike(&impact.time_ms(60_000.0)).unwrap().wait(timeout()).unwrap();
    assert_eq!(roomy.summary().missed_time, None);
}
