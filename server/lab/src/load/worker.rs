//! Client process of a load: one thread sends due requests, another one receives results.

use super::plan::{ClientPlan, ClientReport, LoadTarget};
use super::schedule::Schedule;
use super::tally::{RequestEnd, RequestRecord};
use super::{RESULT_TIMEOUT, reply};
use shatter_cli_common::cli_error::{CliError, out};
use shatter_client::{
    Client, Contact, Deadline, DegreeRule, Error, ErrorKind, FractureResult, Impact, Object, Poll, Ticket,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

/// Sites of the request that explores the surface of a target.
const SITES: u32 = 8;

/// Maximum number of surface points that are kept.
const POINTS_MAX: usize = 4096;

/// Minimum pause before a retry.
const PAUSE: Duration = Duration::from_millis(10);

/// Time to wait for results after the last request is sent.
pub const TIMEOUT: Duration = Duration::from_secs(30);

/// Reads a plan, carries it out, and writes a report.
pub fn run(service: &str) -> Result<(), CliError> {
    // Without the parent process there is no receiver of the report.
    if let Err(error) = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::TERM)) {
        tracing::debug!(%error, "a client process may outlive the tool");
    }
    let report = match carried_out(service) {
        Ok(records) => ClientReport::Records(records),
        Err(Error { kind, at, message, .. }) => ClientReport::Refused { kind: kind.name().to_owned(), at, message },
    };
    out(format_args!("{}\n", serde_json::json!(report)))
}

fn carried_out(service: &str) -> Result<Vec<RequestRecord>, Error> {
    let wrong = |error: serde_json::Error| Error::new(ErrorKind::Configuration, "plan", error.to_string());
    let plan: ClientPlan = serde_json::from_reader(std::io::stdin()).map_err(wrong)?;
    let connection = Client::connect(service, reply())?;
    let marks = plan.targets.iter().map(|target| Mark::of(&connection, target)).collect::<Result<Vec<_>, _>>()?;
    let begin = SystemTime::UNIX_EPOCH + Duration::from_nanos(plan.begin_unix_ns);
    let begin = Instant::now() + begin.duration_since(SystemTime::now()).unwrap_or_default();
    let sender = Sender { schedule: Schedule::new(&plan), marks, begin, plan };
    Ok(if sender.plan.rate.is_some() { open(&connection, sender) } else { closed(sender) })
}

/// Object and points of its surface.
struct Mark {
    object: Object,
    degree: u32,
    points: Vec<[f64; 3]>,
    center: [f64; 3],
}

impl Mark {
    /// Surface points of a target, taken from its fragments.
    fn of(connection: &Client, target: &LoadTarget) -> Result<Self, Error> {
        let object = connection.object(&target.object, reply())?;
        let facts = object.facts();
        let center = facts.center_m;
        let all_over = Impact::new([Contact::new(center).impulse([1.0, 0.0, 0.0]).radius(facts.diagonal_m)])
            .degree(DegreeRule::Sites(SITES.min(facts.degree_max)));
        let fracture_result = retry_until_accepted(|| object.strike(&all_over)?.wait(Deadline::after(RESULT_TIMEOUT)))?;
        let points = surface(&fracture_result);
        if points.is_empty() {
            return Err(Error::new(
                ErrorKind::Failed,
                target.object.clone(),
                "the object has no outer surface to strike",
            ));
        }
        Ok(Self { degree: target.degree, points, center, object })
    }
}

/// Retries while the service is busy, as other clients may be exploring, too.
fn retry_until_accepted<T>(ask: impl Fn() -> Result<T, Error>) -> Result<T, Error> {
    let deadline = Deadline::after(RESULT_TIMEOUT);
    loop {
        match ask() {
            Err(error) if error.kind == ErrorKind::Busy && !deadline.passed() => {
                std::thread::sleep(error.retry_after.unwrap_or_default().clamp(PAUSE, Duration::from_secs(1)));
            }
            result => return result,
        }
    }
}

/// Samples points of the outer faces of all fragments.
fn surface(fracture_result: &FractureResult) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for fragment in fracture_result.fragments() {
        let [x, y, z] = fragment.center_m();
        let outer = fragment.runs().filter(|run| run.neighbor.is_none());
        points.extend(outer.flat_map(|run| run.positions).map(|p| {
            let [a, b, c] = p.map(f64::from);
            [x + a, y + b, z + c]
        }));
    }
    let stride = points.len().div_ceil(POINTS_MAX).max(1);
    points.into_iter().step_by(stride).collect()
}

/// Draws requests and sends them.
struct Sender {
    schedule: Schedule,
    marks: Vec<Mark>,
    begin: Instant,
    plan: ClientPlan,
}

/// Request in flight.
struct InFlightRequest {
    ticket: Ticket,
    due: Duration,
}

impl Sender {
    fn strike(&mut self) -> Result<Ticket, Error> {
        let mark = &self.marks[self.schedule.target()];
        let point = mark.points[self.schedule.pick(mark.points.len())];
        let inward: [f64; 3] = std::array::from_fn(|axis| mark.center[axis] - point[axis]);
        let length = inward.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = if length > 0.0 { inward.map(|x| x / length) } else { [1.0, 0.0, 0.0] };
        let impact = Impact::new([Contact::new(point).impulse(direction)])
            .degree(DegreeRule::Sites(mark.degree))
            .seed(self.schedule.seed());
        let deadline = self.plan.deadline_ms.map(Duration::from_millis);
        mark.object.strike(&deadline.map_or(impact.clone(), |deadline| impact.deadline(deadline)))
    }

    /// Sleeps until the due time.
    fn sleep_until(&self, due: Duration) {
        std::thread::sleep((self.begin + due).saturating_duration_since(Instant::now()));
    }

    fn over(&self, due: Duration) -> bool {
        due.as_secs_f64() >= self.plan.seconds
    }
}

/// Open loop: sends every request at its due time, whatever the state of earlier ones.
fn open(connection: &Client, mut sender: Sender) -> Vec<RequestRecord> {
    let (in_flight, done) = (Mutex::new(Vec::new()), AtomicBool::new(false));
    let begin = sender.begin;
    std::thread::scope(|scope| {
        let refused = scope.spawn(|| {
            let mut refused = Vec::new();
            while let Some(due) = sender.schedule.next().filter(|due| !sender.over(*due)) {
                sender.sleep_until(due);
                // Locked before sending: a result may arrive before its ticket is stored.
                let mut in_flight = in_flight.lock().unwrap_or_else(PoisonError::into_inner);
                match sender.strike() {
                    Ok(ticket) => in_flight.push(InFlightRequest { ticket, due }),
                    Err(error) => refused.push(ended(begin, due, &error)),
                }
            }
            done.store(true, Ordering::Release);
            refused
        });
        let mut records = receive(connection, begin, &in_flight, &done);
        records.extend(refused.join().unwrap_or_default());
        records.sort_by_key(|record| record.due_us);
        records
    })
}

/// Receives results until no more can arrive.
fn receive(
    connection: &Client,
    begin: Instant,
    in_flight: &Mutex<Vec<InFlightRequest>>,
    done: &AtomicBool,
) -> Vec<RequestRecord> {
    let (mut own, mut records): (Vec<InFlightRequest>, Vec<RequestRecord>) = (Vec::new(), Vec::new());
    let mut last: Option<Deadline> = None;
    loop {
        let over = done.load(Ordering::Acquire);
        own.append(&mut in_flight.lock().unwrap_or_else(PoisonError::into_inner));
        own.retain_mut(|strike| match strike.ticket.poll() {
            Ok(Poll::Pending) => true,
            Ok(Poll::Ready(fracture_result)) => {
                records.push(completed(begin, strike.due, &fracture_result));
                false
            }
            Err(error) => {
                records.push(ended(begin, strike.due, &error));
                false
            }
        });
        if over && own.is_empty() {
            return records;
        }
        if over && last.get_or_insert_with(|| Deadline::after(TIMEOUT)).passed() {
            let lost = Error::new(ErrorKind::Late, "ticket", "no result arrived");
            records.extend(own.iter().map(|strike| ended(begin, strike.due, &lost)));
            return records;
        }
        connection.wait_for_reply(Deadline::ms(5));
    }
}

/// Closed loop: sends the next request when the previous one has ended.
fn closed(mut sender: Sender) -> Vec<RequestRecord> {
    let mut records = Vec::new();
    sender.sleep_until(Duration::ZERO);
    loop {
        let due = sender.begin.elapsed();
        if sender.over(due) {
            return records;
        }
        let result = sender.strike().and_then(|mut ticket| ticket.wait(Deadline::after(TIMEOUT)));
        records.push(match result {
            Ok(fracture_result) => completed(sender.begin, due, &fracture_result),
            Err(error) => {
                let record = ended(sender.begin, due, &error);
                std::thread::sleep(error.retry_after.unwrap_or_default().clamp(PAUSE, Duration::from_secs(1)));
                record
            }
        });
    }
}

fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

fn completed(begin: Instant, due: Duration, fracture_result: &FractureResult) -> RequestRecord {
    let stages = fracture_result.stages().map(|cost| cost.time);
    let service: Duration = stages.chain(fracture_result.effects().map(|cost| cost.time)).sum();
    RequestRecord {
        due_us: micros(due),
        latency_us: micros(begin.elapsed().saturating_sub(due)),
        service_us: micros(service),
        ipc_us: micros(fracture_result.round_trip().saturating_sub(service)),
        end: RequestEnd::Ok,
        why: None,
    }
}

fn ended(begin: Instant, due: Duration, error: &Error) -> RequestRecord {
    let end = match error.kind {
        ErrorKind::Busy => RequestEnd::Busy,
        ErrorKind::Late => RequestEnd::Late,
        _ => RequestEnd::Failed,
    };
    let latency_us = micros(begin.elapsed().saturating_sub(due));
    let why = (end == RequestEnd::Failed).then_some(error.kind.code());
    RequestRecord { due_us: micros(due), latency_us, service_us: 0, ipc_us: 0, end, why }
}
