//! Strikes on their way: a bounded queue by urgency, a few that compute, and the bookkeeping between the thread that waits and
//! the threads that compute.

mod forecast;
mod job;
mod overrun_cause;
mod queue;
mod worker_pool;

pub use job::Job;
pub use worker_pool::{WorkerEvent, WorkerPool, lanes, threads};

use crate::catalog::Catalog;
use crate::error_mailbox::RequestKey;
use crate::ipc::ActiveImpactRequest;
use crate::metrics::JobEnd;
use forecast::{Forecast, WorkKind};
use job::StopCause;
use queue::{ClientId, Queue, QueueKey};
use shatter_proto::control::ProgressRow;
use shatter_proto::request::RequestWire;
use shatter_proto::{Error, ErrorKind};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use worker_pool::WorkerSlot;

/// What a strike is expected to take of whose object nothing is known yet.
const COST_UNKNOWN: Duration = Duration::from_millis(10);

/// A client may be ahead of its share by so many of its strikes: enough for first come first served among clients that send at
/// random what they may, too few for one that sends a wall of them.
const AHEAD: f64 = 4.0;

/// Strikes of a client that does not read its answers wait no longer than this: it may wait for one of them before it reads.
const UNREAD_PATIENCE: Duration = Duration::from_secs(1);

/// Strikes that wait and strikes that compute. Owned by the waiting thread.
pub struct Jobs {
    waiting: Queue<Arc<Job>>,
    running: Vec<Running>,
    /// Answered, and not read yet.
    unread: Vec<Arc<Job>>,
    forecast: Forecast,
    /// Buckets that one client may hold.
    held_max: usize,
    /// Nothing more is taken in.
    closed: bool,
    /// Of those that were refused when their turn came.
    ends: Vec<JobEnd>,
    crew: Arc<WorkerPool>,
}

/// A strike that computes.
struct Running {
    flight: Arc<Job>,
    place: QueueKey,
    lane: WorkerSlot,
    begun: Instant,
}

impl Jobs {
    /// No strike yet. At most one computes in each lane of the crew, at most `queue_max` wait, and no client holds more than
    /// `held_max` buckets.
    pub fn new(queue_max: usize, held_max: usize, crew: Arc<WorkerPool>) -> Self {
        let (waiting, forecast) = (Queue::new(queue_max, crew.lanes(), AHEAD), Forecast::default());
        let (running, unread) = (Vec::new(), Vec::new());
        Self { waiting, running, unread, forecast, held_max, closed: false, ends: Vec::new(), crew }
    }

    /// Strikes that compute.
    pub fn running(&self) -> usize {
        self.running.len()
    }

    /// Strikes that wait.
    pub fn queued(&self) -> usize {
        self.waiting.len()
    }

    /// How far a strike is; `None` if it neither waits nor computes.
    pub fn progress(&self, strike: RequestKey) -> Option<ProgressRow> {
        let row = |state: u32, flight: &Job| {
            let age_ns = u64::try_from(flight.arrived().elapsed().as_nanos()).unwrap_or(u64::MAX);
            ProgressRow { state, stage: flight.stage().load(Ordering::Relaxed), age_ns }
        };
        let computing = self.running.iter().find(|running| running.flight.key() == strike);
        let waiting = || self.waiting.items().find(|flight| flight.key() == strike);
        computing.map(|running| row(2, &running.flight)).or_else(|| waiting().map(|flight| row(1, flight)))
    }

    /// Answers that their clients have not read yet.
    pub fn unread_answers(&self) -> usize {
        self.unread.len()
    }

    /// Takes nothing more in.
    pub fn close(&mut self) {
        self.closed = true;
    }

    /// Whether nothing more is taken in.
    pub fn closed(&self) -> bool {
        self.closed
    }

    /// Takes a strike in, or refuses it at once; the end of one that was refused. `wire` is the one copy of its payload: the sender
    /// can still write to the original.
    pub fn admit(&mut self, active: ActiveImpactRequest, wire: &RequestWire, catalog: &Catalog) -> Option<JobEnd> {
        let mut flight = Job::new(active, wire.listener, wire.sequence);
        let placed = wire.validate().and_then(|strike| {
            self.open()?;
            self.within_share(wire.held)?;
            let target = match strike.from {
                None => (catalog.get(&strike.object)?, None),
                Some(origin) => self.crew.target(&strike.object, origin)?,
            };
            let deadline = strike.deadline.and_then(|deadline| flight.arrived().checked_add(deadline));
            let work = WorkKind::of(&strike);
            self.in_time(deadline, &work, flight.arrived())?;
            let cost = self.forecast.of(&work).unwrap_or(COST_UNKNOWN);
            Ok((QueueKey { client: wire.listener, deadline, cost }, strike, target))
        });
        let place = match placed {
            Ok((place, strike, target)) => {
                flight.place(strike, target);
                place
            }
            Err(refusal) => return Some(self.refuse(&flight, &refusal)),
        };
        let pushed = self.waiting.push(flight.arrived(), place, Arc::new(flight));
        let refused = pushed.err().map(|flight| self.refuse(&flight, &self.full(&place.client)));
        self.dispatch();
        refused
    }

    /// Refuses everything once it is closed.
    fn open(&self) -> Result<(), Error> {
        if self.closed { Err(StopCause::Ending.refusal()) } else { Ok(()) }
    }

    /// Refuses a client that holds its share of the buckets.
    fn within_share(&self, held: u64) -> Result<(), Error> {
        if held < self.held_max as u64 {
            return Ok(());
        }
        let message = format!("this client holds {held} answers, of {} that one may hold: drop some", self.held_max);
        Err(Error::new(ErrorKind::Busy, "share", message))
    }

    /// Refuses what is expected to be late anyway.
    fn in_time(&mut self, deadline: Option<Instant>, work: &WorkKind, arrived: Instant) -> Result<(), Error> {
        let (Some(deadline), Some(cost)) = (deadline, self.forecast.of(work)) else { return Ok(()) };
        let wait = self.wait(Some(deadline));
        if arrived + cost > deadline {
            self.forecast.doubt(work, arrived);
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if wait + cost <= left {
            return Ok(());
        }
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let message = format!(
            "{:.1} ms are left, but {:.1} ms of waiting and {:.1} ms of computing are expected",
            ms(left),
            ms(wait),
            ms(cost)
        );
        let refusal = Error::new(ErrorKind::Late, "deadline", message);
        // Where nothing is in the way, coming back later changes nothing.
        Err(if wait > Duration::ZERO { refusal.after(wait) } else { refusal })
    }

    /// How long a new strike with this deadline is expected to wait.
    fn wait(&self, deadline: Option<Instant>) -> Duration {
        if self.running.len() < self.crew.lanes() {
            return Duration::ZERO;
        }
        let remaining = |running: &Running| running.place.cost.saturating_sub(running.begun.elapsed());
        let ahead = self.running.iter().map(remaining).sum::<Duration>() + self.waiting.ahead(deadline);
        ahead / self.crew.lanes().max(1) as u32
    }

    /// The refusal of one of this client for which there is no room.
    fn full(&self, client: &ClientId) -> Error {
        let (all, own) = (self.waiting.len(), self.waiting.held(client));
        let (at, message) = match self.waiting.is_full() {
            true => ("queue", format!("the queue is full: {all} waiting")),
            false => {
                ("share", format!("of {all} that wait {own} are this client's: the rest of the queue is for others"))
            }
        };
        Error::new(ErrorKind::Busy, at, message).after(self.wait(None))
    }

    fn refuse(&self, flight: &Job, refusal: &Error) -> JobEnd {
        tracing::debug!(kind = refusal.kind.name(), at = refusal.at, "refused: {refusal}");
        self.crew.refuse(flight, refusal);
        JobEnd::of(refusal)
    }

    /// Lets waiting strikes compute while there is room. Those of a client that does not read its answers wait until it does.
    fn dispatch(&mut self) {
        while self.running.len() < self.crew.lanes() {
            let buckets = self.buckets();
            let may = |client: &ClientId| buckets.get(client).is_none_or(|held| *held < self.held_max);
            let Some((place, flight)) = self.waiting.pop(may) else { return };
            let cost = self.forecast.of(flight.work()).unwrap_or(place.cost);
            if place.deadline.is_some_and(|deadline| Instant::now() + cost > deadline) {
                // It would be late: whoever is next may be in time.
                self.waiting.completed(Instant::now(), &place, Duration::ZERO);
                let late = Error::new(ErrorKind::Late, "deadline", "its turn came too late for the deadline");
                let end = self.refuse(&flight, &late);
                self.ends.push(end);
                continue;
            }
            let lane = self.lane();
            self.running.push(Running { flight: flight.clone(), place, lane, begun: Instant::now() });
            self.crew.run(flight, lane);
        }
    }

    /// Buckets by client, as far as the daemon sees: of what computes, and of answers that are unread.
    fn buckets(&self) -> HashMap<ClientId, usize> {
        let (running, unread) = (self.running.iter().map(|running| &running.flight), self.unread.iter());
        let mut buckets: HashMap<ClientId, usize> = HashMap::new();
        running.chain(unread).for_each(|flight| *buckets.entry(flight.key().0).or_default() += 1);
        buckets
    }

    /// Where the next one computes: on all threads if it is alone, else in a lane that is free.
    fn lane(&self) -> WorkerSlot {
        if self.running.is_empty() && self.waiting.len() == 0 {
            return WorkerSlot::All;
        }
        let free = |lane: &usize| self.running.iter().all(|running| running.lane != WorkerSlot::One(*lane));
        (0..self.crew.lanes()).find(free).map_or(WorkerSlot::All, WorkerSlot::One)
    }

    /// A strike has ended.
    pub fn completed(&mut self, flight: &Arc<Job>, end: JobEnd) {
        let Some(index) = self.running.iter().position(|running| Arc::ptr_eq(&running.flight, flight)) else { return };
        let Running { place, begun, .. } = self.running.swap_remove(index);
        let time = begun.elapsed();
        self.waiting.completed(Instant::now(), &place, time);
        if end == JobEnd::Answered {
            self.forecast.learn(flight.work(), time);
            self.unread.push(flight.clone());
        } else if end == JobEnd::Late {
            self.forecast.learn_at_least(flight.work(), time);
        }
        self.dispatch();
    }

    /// Forgets answers that were read, and cancels what nobody waits for any more; returns how many of the waiting were dropped.
    pub fn prune(&mut self) -> usize {
        let unread = self.unread.len();
        self.unread.retain(|flight| flight.is_open());
        for running in &self.running {
            running.flight.cancel_if_abandoned();
        }
        let dropped = self.waiting.take(|_, flight| flight.cancel_if_abandoned()).len();
        if self.unread.len() < unread {
            self.dispatch();
        }
        dropped
    }

    /// Ends what is late: refuses what waits, and asks what computes to stop at its next checkpoint; refuses what has waited too long
    /// for its client to read. The ends of those that were refused, here or because their turn came too late.
    pub fn expire(&mut self) -> Vec<JobEnd> {
        let now = Instant::now();
        let late = |place: &QueueKey| place.deadline.is_some_and(|deadline| deadline <= now);
        for running in self.running.iter().filter(|running| late(&running.place)) {
            running.flight.stop(StopCause::Late);
        }
        let waiting = self.waiting.take(|place, _| late(place));
        let buckets = self.buckets();
        let stuck = self.waiting.take(|place, flight| {
            let full = buckets.get(&place.client).is_some_and(|held| *held >= self.held_max);
            full && flight.arrived().elapsed() > UNREAD_PATIENCE
        });
        let late = waiting.iter().map(|flight| (flight, StopCause::Late.refusal()));
        let stuck = stuck.iter().map(|flight| (flight, self.unread(flight)));
        let now: Vec<JobEnd> = late.chain(stuck).map(|(flight, refusal)| self.refuse(flight, &refusal)).collect();
        self.ends.extend(now);
        std::mem::take(&mut self.ends)
    }

    /// The refusal of what would need a bucket more than its client may hold.
    fn unread(&self, flight: &Job) -> Error {
        let held = self.buckets().get(&flight.key().0).copied().unwrap_or(0);
        let message = format!("{held} answers of this client are unread, as many as one may hold: read some");
        Error::new(ErrorKind::Busy, "share", message)
    }

    /// The next deadline of a strike.
    pub fn next_deadline(&self) -> Option<Instant> {
        let running = self.running.iter().filter(|running| running.flight.stopped().is_none());
        running.filter_map(|running| running.place.deadline).chain(self.waiting.next_deadline()).min()
    }

    /// Refuses everything that waits; what computes may finish. Returns how many were refused.
    pub fn stop(&mut self) -> usize {
        let refusal = StopCause::Ending.refusal();
        let waiting = self.waiting.take(|_, _| true);
        for flight in &waiting {
            self.crew.refuse(flight, &refusal);
        }
        waiting.len()
    }

    /// Asks what computes to stop at its next checkpoint.
    pub fn cancel(&self) {
        self.running.iter().for_each(|running| running.flight.stop(StopCause::Ending));
    }
}
