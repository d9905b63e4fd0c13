//! The threads that compute, and what they share.

use super::job::{JobPayload, StopCause, WrittenResult};
use super::{Job, overrun_cause};
use crate::error_mailbox::{ErrorMailbox, RequestKey};
use crate::hot_reloader::ReloadEvent;
use crate::ipc::{ClientWaker, LoanedBuffer};
use crate::metrics::JobEnd;
use crate::panics;
use crate::retained::{EvictedResults, RetainedResults, RetainedTarget};
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_engine::object::{EngineResult, ServedObject};
use shatter_engine::stage_profiler::StageProfiler;
use shatter_fracture::pipeline::Workspace;
use shatter_proto::error::ErrorWire;
use shatter_proto::layout::Layout;
use shatter_proto::request::{Request, RetainedFragment};
use shatter_proto::result::{Block, EffectWire, StageWire};
use shatter_proto::{Error, ErrorKind, Fault};
use shatter_transport::workarounds::populated_pages::PopulatedPages;
use shatter_transport::workarounds::response_pool::LOANS_PER_REQUEST;
use std::collections::HashSet;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::mpsc::UnboundedSender;

/// The part of its time that a strike is to take; the rest is for what holds a machine up that others use, too.
const AIMED_AT: f64 = 0.85;

/// Pauses before memory for an answer is asked for again: in the first the dead are buried, in the others the living may read what
/// they were sent. Every failed loan counts, so there are as many as a request has, less one.
const CROWDED: [Duration; LOANS_PER_REQUEST - 1] =
    [Duration::from_millis(4), Duration::from_millis(8), Duration::from_millis(16)];

/// What the computing threads tell the waiting one.
pub enum WorkerEvent {
    /// A strike has ended.
    Landed {
        /// Which.
        flight: Arc<Job>,
        /// How.
        end: JobEnd,
        /// Where its answer's energy came from.
        energy: Option<&'static str>,
        /// What each stage did.
        stages: Box<[StageWire]>,
        /// What each effect did.
        effects: Box<[EffectWire]>,
    },
    /// What goes on in the folder of databases.
    News(ReloadEvent),
    /// Clients hold all memory for answers, among them perhaps dead ones.
    Crowded,
}

/// Where a strike computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkerSlot {
    /// On all threads: nothing else computes.
    All,
    /// On the one thread of this lane.
    One(usize),
}

/// The threads that compute, and what they share.
///
/// Strikes never share a pool: a thread that waits for a part of its strike would take up another whole strike meanwhile, and the
/// first would be as late as that one.
pub struct WorkerPool {
    all: ThreadPool,
    lanes: Vec<ThreadPool>,
    workspaces: Mutex<Vec<Workspace>>,
    verdicts: Mutex<ErrorMailbox>,
    answers: Mutex<RetainedResults>,
    populated: PopulatedPages,
    waker: ClientWaker,
    events: UnboundedSender<WorkerEvent>,
}

/// Computing threads, so much nicer than others: they give way to the thread that waits, and to hosts.
pub fn threads(count: usize, nice: i32) -> Result<ThreadPool, Error> {
    let builder = ThreadPoolBuilder::new().num_threads(count).thread_name(|index| format!("compute-{index}"));
    let give_way = move |_| {
        // On Linux it is the thread's own.
        if let Err(error) = rustix::process::nice(nice) {
            tracing::debug!(%error, "the priority of a computing thread stays");
        }
    };
    let built = builder.start_handler(give_way).build();
    built.map_err(|error| Error::new(ErrorKind::Failed, "threads", error.to_string()))
}

/// Threads of which each is its own.
pub fn lanes(count: usize, nice: i32) -> Result<Vec<ThreadPool>, Error> {
    (0..count).map(|_| threads(1, nice)).collect()
}

impl WorkerPool {
    /// A crew that reports to `events`, and keeps `answers`. `populated` knows what was rehearsed.
    pub fn new(
        all: ThreadPool,
        lanes: Vec<ThreadPool>,
        answers: RetainedResults,
        populated: PopulatedPages,
        waker: ClientWaker,
        events: UnboundedSender<WorkerEvent>,
    ) -> Self {
        let (workspaces, verdicts, answers) = (Mutex::default(), Mutex::default(), Mutex::new(answers));
        Self { all, lanes, workspaces, verdicts, answers, populated, waker, events }
    }

    /// Strikes that may compute at once.
    pub fn lanes(&self) -> usize {
        self.lanes.len()
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.all.current_num_threads()
    }

    /// Buckets that were held at once at most, and bytes of shared memory that they take up.
    pub fn pool_extent(&self) -> (u64, u64) {
        self.populated.extent()
    }

    /// Runs `work` in a lane, which reports by itself.
    fn spawn(self: &Arc<Self>, lane: WorkerSlot, work: impl FnOnce(&WorkerPool) -> WorkerEvent + Send + 'static) {
        let crew = self.clone();
        let pool = match lane {
            WorkerSlot::One(lane) => self.lanes.get(lane).unwrap_or(&self.all),
            WorkerSlot::All => &self.all,
        };
        pool.spawn(move || {
            let event = work(&crew);
            // A waiting thread that is gone has ended the daemon: nobody to tell.
            let _ = crew.events.send(event);
        });
    }

    /// Computes a strike in a lane. A panic in it fails this strike alone.
    pub(super) fn run(self: &Arc<Self>, flight: Arc<Job>, lane: WorkerSlot) {
        self.spawn(lane, move |crew| {
            let profiler = StageProfiler::showing(flight.stage().clone());
            let result = catch_unwind(AssertUnwindSafe(|| crew.answer(&flight, &profiler)));
            let result = result.unwrap_or_else(|panic| {
                let message = format!("the strike failed inside the service: {}", panics::text(panic.as_ref()));
                Err(Error::new(ErrorKind::Failed, "strike", message))
            });
            let result = result.map_err(|refusal| match flight.stopped() {
                Some(why) if refusal.kind == ErrorKind::Cancelled => why.refusal(),
                _ => refusal,
            });
            let end = match &result {
                Ok(()) => JobEnd::Answered,
                Err(refusal) => {
                    if refusal.kind.fault() == Fault::Caller {
                        tracing::debug!(kind = refusal.kind.name(), at = refusal.at, "not answered: {refusal}");
                    } else {
                        tracing::warn!(kind = refusal.kind.name(), at = refusal.at, "not answered: {refusal}");
                    }
                    crew.refuse(&flight, refusal);
                    JobEnd::of(refusal)
                }
            };
            let (energy, stages, effects) =
                (profiler.energy(), Box::new(profiler.rows()), Box::new(profiler.effects()));
            WorkerEvent::Landed { flight, end, energy, stages, effects }
        });
    }

    /// Keeps the verdict, closes the request, wakes the client: in this order, so that a client that finds its request
    /// closed finds the verdict too.
    pub fn refuse(&self, flight: &Job, refusal: &Error) {
        let verdict = ErrorWire::from(refusal);
        self.verdicts.lock().unwrap_or_else(PoisonError::into_inner).keep(flight.key(), verdict);
        flight.close();
        self.waker.wake(flight.key().0);
    }

    /// Tells the verdict on a strike, if it is known.
    pub fn verdict(&self, strike: RequestKey) -> Option<ErrorWire> {
        self.verdicts.lock().unwrap_or_else(PoisonError::into_inner).tell(strike)
    }

    fn answers(&self) -> MutexGuard<'_, RetainedResults> {
        self.answers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is struck when a fragment of an answer of the object `name` is.
    pub(super) fn target(&self, name: &str, origin: RetainedFragment) -> Result<RetainedTarget, Error> {
        self.answers().target(name, origin, Instant::now())
    }

    /// Gives back an answer that is kept.
    pub fn release(&self, handle: u64) -> Result<(), Error> {
        let gone = self.answers().release(handle)?;
        self.drop_evicted(gone);
        Ok(())
    }

    /// Gives back the answers whose time is over.
    pub fn expire_kept(&self) {
        let gone = self.answers().expire(Instant::now());
        self.drop_evicted(gone);
    }

    /// How many answers are kept, and the bytes that they hold.
    pub fn kept(&self) -> (u64, u64) {
        self.answers().extent()
    }

    /// Lets a computing thread give the memory back.
    fn drop_evicted(&self, gone: EvictedResults) {
        if !gone.is_empty() {
            self.all.spawn(move || drop(gone));
        }
    }

    /// Keeps an answer whose strike asks for it; its handle, or zero.
    fn keep(&self, strike: &Request, object: Arc<dyn ServedObject>, outcome: &dyn EngineResult) -> u64 {
        if !strike.keep || !self.answers().keeps() {
            return 0;
        }
        let Some(kept) = outcome.keep() else { return 0 };
        // What makes room is given back here, without the lock.
        let (handle, _gone) = self.answers().keep(&strike.object, object, kept, Instant::now());
        handle
    }

    /// The clients that listen.
    pub fn listeners(&self) -> HashSet<[u8; 16]> {
        self.waker.listeners()
    }

    /// Wakes a client.
    pub fn wake(&self, listener: [u8; 16]) {
        self.waker.wake(listener);
    }

    /// Computes and sends the answer. The object is let go of here, with the strike: a version that was replaced is given
    /// back by the thread that struck it last.
    fn answer(&self, flight: &Job, profiler: &StageProfiler) -> Result<(), Error> {
        let JobPayload { strike, object, kept } = flight.unload()?;
        let _span =
            tracing::info_span!("strike", object = strike.object, client = flight.client(), sequence = flight.key().1)
                .entered();
        let begun = Instant::now();
        let time = strike.time_ms_max.map(|ms| Duration::from_secs_f64(1e-3 * AIMED_AT * ms));
        let due = time.and_then(|time| flight.arrived().checked_add(time));
        let token =
            due.map_or_else(|| flight.token().clone(), |due| flight.token().with_time(move || remaining_s(due)));
        let workspace = self.workspaces.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut workspace = workspace.unwrap_or_default();
        let outcome = match (&kept, strike.from) {
            (Some(kept), Some(origin)) => {
                object.strike_again((kept, origin.fragment), &strike, &mut workspace, &token, profiler)
            }
            _ => object.strike(&strike, &mut workspace, &token, profiler),
        };
        self.workspaces.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
        let outcome = outcome?;
        if flight.stopped() == Some(StopCause::Late) {
            return Err(StopCause::Late.refusal());
        }
        let layout = fit(&strike, outcome.as_ref())?;
        let mut lent = self.loan(flight, layout.blocks())?;
        self.populated.ensure(lent.payload_mut())?;
        *lent.user_header_mut() = layout.header(flight.key().1);
        let handle = self.keep(&strike, object, outcome.as_ref());
        let timing = Timing { handle, arrived: flight.arrived(), begun, time_ms_max: strike.time_ms_max };
        let written = write(lent, &layout, outcome.as_ref(), &timing, profiler);
        // Whoever is woken may take this very core.
        let took = begun.elapsed();
        let sent = written.and_then(|written| flight.send(written));
        if handle != 0 && sent.is_err() {
            // Nobody knows of it; whether younger ones took its place already does not matter.
            let _ = self.release(handle);
        }
        sent?;
        // Before the outcome is given back, which takes as long again.
        self.waker.wake(flight.key().0);
        outcome.took(took, &profiler.rows());
        Ok(())
    }

    /// Lends memory for an answer; what was computed is not thrown away because somebody died a moment ago.
    fn loan(&self, flight: &Job, blocks: usize) -> Result<LoanedBuffer, Error> {
        for pause in CROWDED {
            match flight.loan(blocks) {
                Err(refusal) if refusal.kind == ErrorKind::Busy && flight.stopped().is_none() => {
                    let _ = self.events.send(WorkerEvent::Crowded);
                    std::thread::sleep(pause);
                }
                result => return result,
            }
        }
        flight.loan(blocks)
    }
}

/// Seconds until `due`, less than 0 after it.
fn remaining_s(due: Instant) -> f64 {
    let now = Instant::now();
    due.saturating_duration_since(now).as_secs_f64() - now.saturating_duration_since(due).as_secs_f64()
}

/// Lays the answer out, within the caller's caps.
fn fit(strike: &Request, outcome: &dyn EngineResult) -> Result<Layout, Error> {
    let counts = outcome.counts();
    if let Some(cap) = strike.fragments_max.filter(|cap| counts.fragments > *cap as usize) {
        let message = format!("{} fragments, the request takes {cap}", counts.fragments);
        return Err(Error::new(ErrorKind::CapExceeded, "fragments_max", message));
    }
    let layout = Layout::new(&counts).ok_or_else(|| {
        Error::new(ErrorKind::AnswerTooLarge, "answers", format!("{counts:?} cannot be addressed by 32 bits"))
    })?;
    match strike.bytes_max.filter(|cap| layout.used_bytes() > *cap) {
        None => Ok(layout),
        Some(cap) => {
            let message = format!("{} bytes, the request takes {cap}", layout.used_bytes());
            Err(Error::new(ErrorKind::CapExceeded, "bytes_max", message))
        }
    }
}

/// What an answer says that its outcome does not know.
struct Timing {
    /// Names the answer to later strikes.
    handle: u64,
    /// When its strike arrived.
    arrived: Instant,
    /// When it began to compute.
    begun: Instant,
    /// The time that was asked for.
    time_ms_max: Option<f64>,
}

/// Writes the answer where the client will read it.
fn write(
    mut lent: LoanedBuffer,
    layout: &Layout,
    outcome: &dyn EngineResult,
    timing: &Timing,
    profiler: &StageProfiler,
) -> Result<WrittenResult, Error> {
    let raw: *mut [MaybeUninit<Block>] = lent.payload_mut();
    // SAFETY: the slice is borrowed from `lent`, which is not touched while `payload` lives. Its bytes are initialised:
    // they lie in shared memory, whose pages the kernel zeroes and earlier answers wrote; any bytes are a `Block`.
    let payload: &mut [Block] = unsafe { &mut *(raw as *mut [Block]) };
    let unfit = || Error::new(ErrorKind::Failed, "layout", "the lent memory is shorter than the layout");
    let mut sections = layout.split(payload).ok_or_else(unfit)?;
    profiler.write(outcome, &mut sections, layout.base_bytes())?;
    let took = timing.arrived.elapsed();
    sections.summary.handle = timing.handle;
    sections.summary.time_ns = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
    if let Some(over) = timing.time_ms_max.and_then(|ms| took.checked_sub(Duration::from_secs_f64(1e-3 * ms))) {
        let waited = timing.begun.saturating_duration_since(timing.arrived);
        let reason = overrun_cause::reason(over, waited, outcome.solved(), &profiler.rows());
        sections.summary.overrun = reason as u32;
        sections.summary.overrun_ns = u64::try_from(over.as_nanos()).unwrap_or(u64::MAX).max(1);
    }
    // SAFETY: every byte is initialised, see above.
    Ok(unsafe { lent.assume_init() })
}
