//! Requests in progress: a bounded queue by urgency, a few that compute, and the bookkeeping between the event-loop thread and the
//! worker threads.

mod awake_threads;
mod forecast;
mod job;
mod overrun_cause;
mod queue;
mod worker_pool;

pub use job::Job;
pub use worker_pool::{WorkerEvent, WorkerPool, lanes, no_thread, start_shared, threads};

use crate::catalog::Catalog;
use crate::error_mailbox::RequestKey;
use crate::ipc::ActiveImpactRequest;
use crate::metrics::JobEnd;
use forecast::{Forecast, WorkKind};
use job::StopCause;
use queue::{ClientId, Queue, QueueKey};
use shatter_proto::control::ProgressRow;
use shatter_proto::request::RequestWire;
use shatter_proto::text::counted;
use shatter_proto::{Error, ErrorKind};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use worker_pool::WorkerSlot;

/// Default cost estimate for an object without samples.
const COST_UNKNOWN: Duration = Duration::from_millis(10);

/// Number of requests by which a client may be ahead of its share: enough for first come first served among clients that send at
/// random within their share, too few for a client that sends a large burst.
const AHEAD: f64 = 4.0;

/// Longest wait of requests whose client does not read its results: the client may wait for one of these before it reads.
const UNREAD_TIMEOUT: Duration = Duration::from_secs(1);

/// Waiting and computing requests. Owned by the event-loop thread.
pub struct Jobs {
    waiting: Queue<Arc<Job>>,
    running: Vec<Running>,
    /// Sent results that are not read yet.
    unread: Vec<Arc<Job>>,
    forecast: Forecast,
    /// Number of buckets that one client may hold.
    held_max: usize,
    /// Whether new requests are refused.
    closed: bool,
    /// Ends of requests that were refused at dispatch.
    ends: Vec<JobEnd>,
    worker_pool: Arc<WorkerPool>,
}

/// Computing request.
struct Running {
    job: Arc<Job>,
    queue_key: QueueKey,
    slot: WorkerSlot,
    begun: Instant,
}

impl Jobs {
    /// Creates an empty job table.
    ///
    /// At most one request computes per worker slot, at most `queue_max` wait, and no client holds more than `held_max` buckets.
    pub fn new(queue_max: usize, held_max: usize, worker_pool: Arc<WorkerPool>) -> Self {
        let (waiting, forecast) = (Queue::new(queue_max, worker_pool.lanes(), AHEAD), Forecast::default());
        let (running, unread) = (Vec::new(), Vec::new());
        Self { waiting, running, unread, forecast, held_max, closed: false, ends: Vec::new(), worker_pool }
    }

    /// Number of computing requests.
    pub fn running(&self) -> usize {
        self.running.len()
    }

    /// Number of waiting requests.
    pub fn queued(&self) -> usize {
        self.waiting.len()
    }

    /// Progress of a request; `None` if it neither waits nor computes.
    pub fn progress(&self, strike: RequestKey) -> Option<ProgressRow> {
        let row = |state: u32, job: &Job| {
            let age_ns = u64::try_from(job.arrived().elapsed().as_nanos()).unwrap_or(u64::MAX);
            ProgressRow { state, stage: job.stage().load(Ordering::Relaxed), age_ns }
        };
        let computing = self.running.iter().find(|running| running.job.key() == strike);
        let waiting = || self.waiting.items().find(|job| job.key() == strike);
        computing.map(|running| row(2, &running.job)).or_else(|| waiting().map(|job| row(1, job)))
    }

    /// Number of results that their clients have not read yet.
    pub fn unread_results(&self) -> usize {
        self.unread.len()
    }

    /// Refuses new requests from now on.
    pub fn close(&mut self) {
        self.closed = true;
    }

    /// Whether new requests are refused.
    pub fn closed(&self) -> bool {
        self.closed
    }

    /// Accepts a request or refuses it at once; returns its end if it was refused. `wire` is the only copy of the payload: the client
    /// can still write to the original.
    pub fn admit(&mut self, active: ActiveImpactRequest, wire: &RequestWire, catalog: &Catalog) -> Option<JobEnd> {
        // The job exists before its request is valid, since it holds the address to which an error is sent.
        let mut job = Job::new(active, wire.listener, wire.sequence);
        let placed = wire.validate().and_then(|strike| {
            self.open()?;
            self.within_share(wire.held)?;
            let target = match strike.from {
                None => (catalog.get(&strike.object)?, None),
                Some(origin) => self.worker_pool.target(&strike.object, origin)?,
            };
            let deadline = strike.deadline.and_then(|deadline| job.arrived().checked_add(deadline));
            let work = WorkKind::of(&strike);
            self.in_time(deadline, &work, job.arrived())?;
            let cost = self.forecast.of(&work).unwrap_or(COST_UNKNOWN);
            Ok((QueueKey { client: wire.listener, deadline, cost }, strike, target))
        });
        let queue_key = match placed {
            Ok((queue_key, strike, target)) => {
                job.set_work(strike, target);
                queue_key
            }
            Err(error) => return Some(self.refuse(&job, &error)),
        };
        let pushed = self.waiting.push(job.arrived(), queue_key, Arc::new(job));
        let refused = pushed.err().map(|job| self.refuse(&job, &self.full(&queue_key.client)));
        self.dispatch();
        refused
    }

    /// Refuses every request once the table is closed.
    fn open(&self) -> Result<(), Error> {
        if self.closed { Err(StopCause::Ending.error()) } else { Ok(()) }
    }

    /// Refuses a client that holds its share of the buckets.
    fn within_share(&self, held: u64) -> Result<(), Error> {
        if held < self.held_max as u64 {
            return Ok(());
        }
        let held = counted(held, "result");
        let message = format!("this client holds {held}, and a client may hold {}; drop some", self.held_max);
        Err(Error::new(ErrorKind::Busy, "share", message))
    }

    /// Refuses a request that is expected to miss its deadline.
    fn in_time(&mut self, deadline: Option<Instant>, work: &WorkKind, arrived: Instant) -> Result<(), Error> {
        let (Some(deadline), Some(cost)) = (deadline, self.forecast.of(work)) else { return Ok(()) };
        let wait = self.wait(Some(deadline));
        if arrived + cost > deadline {
            self.forecast.reduce_estimate(work, arrived);
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if wait + cost <= left {
            return Ok(());
        }
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let message = format!(
            "{:.1} ms are left, but {:.1} ms of waiting and {:.1} ms of computing are expected; allow more time",
            ms(left),
            ms(wait),
            ms(cost)
        );
        let error = Error::new(ErrorKind::Late, "deadline", message);
        // If the request would not have to wait, a retry changes nothing.
        Err(if wait > Duration::ZERO { error.after(wait) } else { error })
    }

    /// Expected waiting time of a new request with this deadline.
    fn wait(&self, deadline: Option<Instant>) -> Duration {
        if self.running.len() < self.worker_pool.lanes() {
            return Duration::ZERO;
        }
        let remaining = |running: &Running| running.queue_key.cost.saturating_sub(running.begun.elapsed());
        let ahead = self.running.iter().map(remaining).sum::<Duration>() + self.waiting.ahead(deadline);
        ahead / self.worker_pool.lanes().max(1) as u32
    }

    /// Error for a request of this client that the queue does not accept.
    fn full(&self, client: &ClientId) -> Error {
        let (all, own) = (self.waiting.len(), self.waiting.held(client));
        let all = counted(all as u64, "request");
        let (at, message) = match self.waiting.is_full() {
            true => ("queue", format!("the queue is full with {all}; retry later")),
            false => ("share", format!("of {all}, {own} are this client's; the rest of the queue is for others")),
        };
        Error::new(ErrorKind::Busy, at, message).after(self.wait(None))
    }

    fn refuse(&self, job: &Job, error: &Error) -> JobEnd {
        tracing::debug!(kind = error.kind.name(), at = error.at, "refused: {error}");
        self.worker_pool.refuse(job, error);
        JobEnd::of(error)
    }

    /// Starts waiting requests while worker slots are free. Requests of a client that does not read its results wait until it does.
    fn dispatch(&mut self) {
        while self.running.len() < self.worker_pool.lanes() {
            let buckets = self.buckets();
            let may = |client: &ClientId| buckets.get(client).is_none_or(|held| *held < self.held_max);
            let Some((queue_key, job)) = self.waiting.pop(may) else { return };
            let cost = self.forecast.of(job.work()).unwrap_or(queue_key.cost);
            if queue_key.deadline.is_some_and(|deadline| Instant::now() + cost > deadline) {
                // It would miss its deadline; the next one may still meet its own.
                self.waiting.completed(Instant::now(), &queue_key, Duration::ZERO);
                let late = Error::new(
                    ErrorKind::Late,
                    "deadline",
                    "the deadline (deadline_ms) ends before the request can be computed; give a later one, or none",
                );
                let end = self.refuse(&job, &late);
                self.ends.push(end);
                continue;
            }
            let slot = self.slot();
            self.running.push(Running { job: job.clone(), queue_key, slot, begun: Instant::now() });
            self.worker_pool.run(job, slot);
        }
    }

    /// Buckets by client that the daemon knows of: those of computing requests and of unread results.
    fn buckets(&self) -> HashMap<ClientId, usize> {
        let (running, unread) = (self.running.iter().map(|running| &running.job), self.unread.iter());
        let mut buckets: HashMap<ClientId, usize> = HashMap::new();
        running.chain(unread).for_each(|job| *buckets.entry(job.key().0).or_default() += 1);
        buckets
    }

    /// Worker slot of the next request: all threads if it is the only one, else a free slot.
    fn slot(&self) -> WorkerSlot {
        if self.running.is_empty() && self.waiting.len() == 0 {
            return WorkerSlot::All;
        }
        let free = |slot: &usize| self.running.iter().all(|running| running.slot != WorkerSlot::One(*slot));
        (0..self.worker_pool.lanes()).find(free).map_or(WorkerSlot::All, WorkerSlot::One)
    }

    /// Records the end of a job.
    pub fn completed(&mut self, job: &Arc<Job>, end: JobEnd) {
        let Some(index) = self.running.iter().position(|running| Arc::ptr_eq(&running.job, job)) else { return };
        let Running { queue_key, begun, .. } = self.running.swap_remove(index);
        let time = begun.elapsed();
        self.waiting.completed(Instant::now(), &queue_key, time);
        if end == JobEnd::Completed {
            self.forecast.learn(job.work(), time);
            self.unread.push(job.clone());
        } else if end == JobEnd::Late {
            self.forecast.learn_lower_bound(job.work(), time);
        }
        self.dispatch();
    }

    /// Drops results that were read, and cancels requests that their clients dropped; returns the number of waiting ones dropped.
    pub fn prune(&mut self) -> usize {
        let unread = self.unread.len();
        self.unread.retain(|job| job.is_open());
        for running in &self.running {
            running.job.cancel_if_abandoned();
        }
        let dropped = self.waiting.take(|_, job| job.cancel_if_abandoned()).len();
        if self.unread.len() < unread {
            self.dispatch();
        }
        dropped
    }

    /// Ends late requests: refuses waiting ones, and asks computing ones to stop at their next checkpoint.
    ///
    /// Also refuses requests that waited too long for their client to read. Returns the ends of all refused requests, including those
    /// refused at dispatch.
    pub fn expire(&mut self) -> Vec<JobEnd> {
        let now = Instant::now();
        let late = |queue_key: &QueueKey| queue_key.deadline.is_some_and(|deadline| deadline <= now);
        for running in self.running.iter().filter(|running| late(&running.queue_key)) {
            running.job.stop(StopCause::Late);
        }
        let waiting = self.waiting.take(|queue_key, _| late(queue_key));
        let buckets = self.buckets();
        let stuck = self.waiting.take(|queue_key, job| {
            let full = buckets.get(&queue_key.client).is_some_and(|held| *held >= self.held_max);
            full && job.arrived().elapsed() > UNREAD_TIMEOUT
        });
        let late = waiting.iter().map(|job| (job, StopCause::Late.error()));
        let stuck = stuck.iter().map(|job| (job, self.unread(job)));
        let now: Vec<JobEnd> = late.chain(stuck).map(|(job, error)| self.refuse(job, &error)).collect();
        self.ends.extend(now);
        std::mem::take(&mut self.ends)
    }

    /// Error for a request that would exceed the number of buckets of its client.
    fn unread(&self, job: &Job) -> Error {
        let held = self.buckets().get(&job.key().0).copied().unwrap_or(0);
        let (held, verb) = (counted(held as u64, "result"), if held == 1 { "is" } else { "are" });
        let message = format!("{held} of this client {verb} unread, as many as a client may hold; read some");
        Error::new(ErrorKind::Busy, "share", message)
    }

    /// Next deadline of any request.
    pub fn next_deadline(&self) -> Option<Instant> {
        let running = self.running.iter().filter(|running| running.job.stopped().is_none());
        running.filter_map(|running| running.queue_key.deadline).chain(self.waiting.next_deadline()).min()
    }

    /// Refuses all waiting requests and lets computing ones finish; returns the number of refused ones.
    pub fn stop(&mut self) -> usize {
        let error = StopCause::Ending.error();
        let waiting = self.waiting.take(|_, _| true);
        for job in &waiting {
            self.worker_pool.refuse(job, &error);
        }
        waiting.len()
    }

    /// Asks all computing requests to stop at their next checkpoint.
    pub fn cancel(&self) {
        self.running.iter().for_each(|running| running.job.stop(StopCause::Ending));
    }
}
