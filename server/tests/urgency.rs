//! Order of requests by deadline, immediate errors, and late requests: a daemon in this process with one computing thread.

mod support;

use shatter_client::{Client, Contact, Deadline, DegreeRule, ErrorKind, Impact, Object, OverrunCause, Ticket};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use support::{InProcess, TestPlace, eventually, order, patience};

/// A daemon whose only worker is busy with a request until the gate opens.
struct Kept {
    daemon: InProcess,
    gate: PathBuf,
    service: Client,
    keeper: Ticket,
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

fn object(service: &Client, name: &str) -> Object {
    service.object(name, patience()).unwrap()
}

impl Kept {
    fn new(objects: &[&str], queue_max: usize) -> Self {
        let here = TestPlace::new("urgent");
        objects.iter().for_each(|name| here.database(name, "tetra"));
        here.database("keeper", "gate 2");
        here.database("slow", "slow");
        let gate = here.databases().join("keeper.gate");
        std::fs::write(&gate, "").unwrap();
        let daemon = InProcess::start(here, &format!("[compute]\nstrikes_at_once = 1\nqueue_max = {queue_max}"));
        let service = daemon.connect();
        let keeper = object(&daemon.connect(), "keeper").strike(&impact()).unwrap();
        let kept = Self { daemon, gate, service, keeper };
        kept.until(|running, _| running == 1);
        kept
    }

    /// Waits until the numbers of computing and waiting requests hold.
    fn until(&self, holds: impl Fn(u32, u32) -> bool) {
        let deadline = patience();
        loop {
            let status = self.service.status(patience()).unwrap();
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
        drop(self.keeper.wait(patience()).unwrap());
    }
}

fn refused(mut ticket: Ticket) -> shatter_client::Error {
    ticket.wait(patience()).err().unwrap()
}

#[test]
fn the_earliest_deadline_goes_first() {
    let mut kept = Kept::new(&["never-d", "late-d", "soon-d"], 99);
    let within = |seconds| impact().deadline(Duration::from_secs(seconds));
    let mut tickets = vec![kept.send(&kept.service, "never-d", &impact(), 1)];
    tickets.push(kept.send(&kept.service, "late-d", &within(120), 2));
    tickets.push(kept.send(&kept.service, "soon-d", &within(60), 3));
    kept.open();
    tickets.iter_mut().for_each(|ticket| drop(ticket.wait(patience()).unwrap()));
    assert_eq!(order("-d"), ["soon-d", "late-d", "never-d"]);
}

/// On several threads, each with a client of its own: what takes a millisecond of waiting takes the kernel a tick of its clock.
#[test]
fn nobody_sleeps_beyond_a_deadline_that_has_passed() {
    const THREADS: u64 = 12;
    let kept = Kept::new(&["vase-z"], 99);
    let wait = |own: u64| {
        let service = kept.daemon.connect();
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
    let mut kept = Kept::new(&["greedy-t", "modest-t"], 99);
    let other = kept.daemon.connect();
    let mut tickets: Vec<Ticket> = (1..=20).map(|n| kept.send(&kept.service, "greedy-t", &impact(), n)).collect();
    tickets.push(kept.send(&other, "modest-t", &impact(), 21));
    kept.open();
    tickets.iter_mut().for_each(|ticket| drop(ticket.wait(patience()).unwrap()));
    let found = order("-t");
    let place = found.iter().position(|name| name == "modest-t").unwrap();
    assert!(place < 10 && found.len() == 21, "{found:?}");
}

#[test]
fn a_full_queue_is_shared_and_the_refused_know_when_to_come_back() {
    let mut kept = Kept::new(&["vase-f"], 6);
    let other = kept.daemon.connect();
    let mut taken: Vec<Ticket> = (1..=4).map(|n| kept.send(&kept.service, "vase-f", &impact(), n)).collect();
    let share = refused(object(&kept.service, "vase-f").strike(&impact()).unwrap());
    taken.extend((5..=6).map(|n| kept.send(&other, "vase-f", &impact(), n)));
    let full = refused(object(&other, "vase-f").strike(&impact()).unwrap());
    for (refusal, at) in [(&share, "share"), (&full, "queue")] {
        assert_eq!((refusal.kind, refusal.at.as_str()), (ErrorKind::Busy, at), "{refusal}");
        assert!(refusal.retry_after.is_some_and(|wait| wait > Duration::ZERO), "{refusal:?}");
    }
    kept.open();
    taken.iter_mut().for_each(|ticket| drop(ticket.wait(patience()).unwrap()));
}

#[test]
fn what_is_late_costs_no_more_and_what_will_be_late_is_refused_at_once() {
    let mut kept = Kept::new(&["vase-l"], 99);
    let within = |ms| impact().deadline(Duration::from_millis(ms));
    let late = refused(object(&kept.service, "vase-l").strike(&within(20)).unwrap());
    assert_eq!((late.kind, late.at.as_str()), (ErrorKind::Late, "deadline"), "while the keeper still computes: {late}");
    std::thread::sleep(Duration::from_millis(100));
    kept.open();
    let late = refused(object(&kept.service, "slow").strike(&within(20)).unwrap());
    assert_eq!((late.kind, late.at.as_str()), (ErrorKind::Late, "deadline"), "it would compute for a minute: {late}");
    // The daemon knows that the gate's object takes a tenth of a second.
    let begun = Instant::now();
    let hopeless = refused(object(&kept.service, "keeper").strike(&within(50)).unwrap());
    assert_eq!((hopeless.kind, hopeless.at.as_str()), (ErrorKind::Late, "deadline"), "{hopeless}");
    assert!(hopeless.message.contains("expected"), "{hopeless} after {:?}", begun.elapsed());
    drop(object(&kept.service, "keeper").strike(&within(60_000)).unwrap().wait(patience()).unwrap());
    kept.until(|running, queued| running == 0 && queued == 0);
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
    let mut kept = Kept::new(&names.iter().map(String::as_str).collect::<Vec<_>>(), 99);
    let sent = at_once(&kept.daemon, &names, |rank| 1000 * (100 + rank));
    kept.until(|_, queued| queued == (CLIENTS * EACH) as u32);
    kept.open();
    for mut ticket in sent.into_iter().flat_map(|(_, tickets)| tickets) {
        drop(ticket.wait(patience()).unwrap());
    }
    let mut sorted = names.clone();
    sorted.sort();
    assert_eq!(order("-m"), sorted);
}

/// One after another the requests take longer than the least urgent deadline. Whatever the machine does, each is complete or late, urgent
/// ones come first among the complete ones, and a late one is not computed to its end.
#[test]
fn forty_impacts_that_cannot_all_be_in_time_are_answered_or_late() {
    let here = TestPlace::new("wall");
    let names = names("n");
    names.iter().for_each(|name| here.database(name, "brief 5"));
    let daemon = InProcess::start(here, "[compute]\nstrikes_at_once = 1");
    let sent = at_once(&daemon, &names, |rank| 40 + 2 * rank);
    let (mut answered, mut late) = (0, 0);
    for mut ticket in sent.into_iter().flat_map(|(_, tickets)| tickets) {
        match ticket.wait(patience()) {
            Ok(_) => answered += 1,
            Err(refusal) => {
                assert_eq!((refusal.kind, refusal.at.as_str()), (ErrorKind::Late, "deadline"), "{refusal}");
                late += 1;
            }
        }
    }
    assert_eq!(answered + late, CLIENTS * EACH);
    assert!(late > 0, "40 of 5 ms in 118 ms");
    assert_eq!(order("-n").len(), answered, "what is late is not written");
}

/// Long requests say nothing about short ones, and a wrong prediction is corrected in the end.
#[test]
fn a_wrong_forecast_does_not_refuse_for_ever() {
    let here = TestPlace::new("wrong");
    here.database("vase", "sites 4");
    let daemon = InProcess::start(here, "[compute]\nstrikes_at_once = 1");
    let service = daemon.connect();
    let vase = object(&service, "vase");
    let many = impact().degree(DegreeRule::Sites(100));
    (0..2).for_each(|_| drop(vase.strike(&many).unwrap().wait(patience()).unwrap()));
    let soon = |sites| impact().degree(DegreeRule::Sites(sites)).deadline(Duration::from_millis(200));
    drop(vase.strike(&soon(2)).unwrap().wait(patience()).unwrap());
    // About as many sites as those that took 400 ms, and predicted to take as long. The request takes half of that, and is tried in the
    // end.
    let refused = (0..60).take_while(|_| {
        std::thread::sleep(Duration::from_millis(25));
        let refusal = vase.strike(&soon(64)).unwrap().wait(patience()).err();
        refusal.is_some_and(|refusal| {
            assert!(refusal.kind == ErrorKind::Late && refusal.retry_after.is_none(), "{refusal:?}");
            refusal.message.contains("expected")
        })
    });
    assert!((1..60).contains(&refused.count()));
}

/// A request that misses its time because it waited reports that; one with enough time does not.
#[test]
fn a_time_missed_in_the_queue_is_told() {
    let here = TestPlace::new("missed");
    here.database("gate", "gate 1");
    here.database("vase", "tetra");
    let gate = here.databases().join("gate.gate");
    std::fs::write(&gate, "").unwrap();
    let daemon = InProcess::start(here, "[compute]\nthreads = 1");
    let service = daemon.connect();
    let [first, vase] = ["gate", "vase"].map(|name| service.object(name, patience()).unwrap());
    let impact = Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])]);
    let mut tickets = [first.strike(&impact).unwrap(), vase.strike(&impact.clone().time_ms(1.0)).unwrap()];
    eventually(|| "one waits", || service.status(patience()).unwrap().queued == 1);
    std::thread::sleep(Duration::from_millis(5));
    std::fs::remove_file(gate).unwrap();
    let [held, missed] = tickets.each_mut().map(|ticket| ticket.wait(patience()).unwrap().summary().missed_time);
    assert_eq!((held, missed.map(|missed| missed.cause)), (None, Some(OverrunCause::Queue)));
    let roomy = vase.strike(&impact.time_ms(60_000.0)).unwrap().wait(patience()).unwrap();
    assert_eq!(roomy.summary().missed_time, None);
}
