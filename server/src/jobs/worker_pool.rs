//! Worker threads and their shared state.

use super::awake_threads::AwakeThreads;
use super::job::{JobPayload, StopCause, WrittenResult};
use super::{Job, overrun_cause};
use crate::error_mailbox::{ErrorMailbox, RequestKey};
use crate::hot_reloader::ReloadEvent;
use crate::ipc::{ClientWaker, LoanedBuffer};
use crate::metrics::JobEnd;
use crate::panics;
use crate::retained::{EvictedResults, RetainedResults, RetainedTarget};
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_engine::object::{EngineResult, ResultEnergies, ServedObject, write_profiled};
use shatter_engine::stage_profiler::StageProfiler;
use shatter_fracture::pipeline::Workspace;
use shatter_proto::error::ErrorWire;
use shatter_proto::layout::Layout;
use shatter_proto::request::{Request, RetainedFragment};
use shatter_proto::result::{AlignedBlock, EffectCost, StageCost};
use shatter_proto::text::counted;
use shatter_proto::{Error, ErrorKind, FaultParty};
use shatter_transport::workarounds::populated_pages::PopulatedPages;
use shatter_transport::workarounds::response_pool::LOANS_PER_REQUEST;
use std::collections::HashSet;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::mpsc::UnboundedSender;

/// Fraction of the time budget that a request aims at; the rest covers delays by other users of the machine.
const AIMED_AT: f64 = 0.85;

/// Pauses between attempts to loan memory for a result: during the first, the daemon reclaims the memory of dead clients; during the
/// others, clients may read their results. Failed loans count, so there is one pause fewer than the loans of a request.
const CROWDED: [Duration; LOANS_PER_REQUEST - 1] =
    [Duration::from_millis(4), Duration::from_millis(8), Duration::from_millis(16)];

/// Event from a worker thread to the event loop.
pub enum WorkerEvent {
    /// A request ended.
    Completed {
        /// The job.
        job: Arc<Job>,
        /// End of the request.
        end: JobEnd,
        /// Energies of the result; `None` if there is no result, or it has none because the request only aims.
        energies: Option<ResultEnergies>,
        /// Times of the stages.
        stages: Box<[StageCost]>,
        /// Times of the effects.
        effects: Box<[EffectCost]>,
    },
    /// An event from the hot reloader.
    Reload(ReloadEvent),
    /// Clients hold all memory for results; some of them may be dead.
    Crowded,
}

/// Threads on which a request computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkerSlot {
    /// All threads: no other request computes.
    All,
    /// The single thread of this slot.
    One(usize),
}

/// Worker threads and their shared state.
///
/// Requests never share a thread pool: a thread that waits for a part of its request would steal a whole other request, and delay
/// the first one by the time of that one.
pub struct WorkerPool {
    all: ThreadPool,
    lanes: Vec<ThreadPool>,
    workspaces: Mutex<Vec<Workspace>>,
    errors: Mutex<ErrorMailbox>,
    results: Mutex<RetainedResults>,
    populated: PopulatedPages,
    waker: ClientWaker,
    events: UnboundedSender<WorkerEvent>,
}

/// Creates a pool of worker threads, which run at a raised niceness to give way to the event loop and to hosts.
///
/// # Errors
/// `failed` if a thread cannot be started.
pub fn threads(count: usize, nice: i32) -> Result<ThreadPool, Error> {
    let builder = ThreadPoolBuilder::new().num_threads(count).thread_name(|index| format!("compute-{index}"));
    let lower_priority = move |_| {
        // On Linux the niceness is per thread.
        if let Err(error) = rustix::process::nice(nice) {
            tracing::debug!(%error, "cannot lower the priority of a worker thread");
        }
    };
    let built = builder.start_handler(lower_priority).build();
    built.map_err(|error| no_thread(&error))
}

/// The error for a thread that cannot be started because of `cause`.
pub fn no_thread(cause: &dyn std::fmt::Display) -> Error {
    let message = format!("no thread can be started: {cause}; raise the limits of this process (ulimit -u, -v, -d)");
    Error::new(ErrorKind::Failed, "threads", message)
}

/// Starts the threads that commands other than `serve` compute with; 0: one per core.
///
/// # Errors
/// `failed` if a thread cannot be started.
pub fn start_shared(count: usize) -> Result<(), Error> {
    ThreadPoolBuilder::new().num_threads(count).build_global().map_err(|error| no_thread(&error))
}

/// Creates single-threaded pools.
///
/// # Errors
/// Those of [`threads`].
pub fn lanes(count: usize, nice: i32) -> Result<Vec<ThreadPool>, Error> {
    (0..count).map(|_| threads(1, nice)).collect()
}

impl WorkerPool {
    /// Creates a worker pool that reports to `events` and retains results in `results`.
    ///
    /// `populated` knows the buckets that the rehearsal wrote.
    pub fn new(
        all: ThreadPool,
        lanes: Vec<ThreadPool>,
        results: RetainedResults,
        populated: PopulatedPages,
        waker: ClientWaker,
        events: UnboundedSender<WorkerEvent>,
    ) -> Self {
        let (workspaces, errors, results) = (Mutex::default(), Mutex::default(), Mutex::new(results));
        Self { all, lanes, workspaces, errors, results, populated, waker, events }
    }

    /// Number of requests that may compute at once.
    pub fn lanes(&self) -> usize {
        self.lanes.len()
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.all.current_num_threads()
    }

    /// Maximum number of buckets held or prepared at once, and their shared memory in bytes.
    pub fn pool_extent(&self) -> (u64, u64) {
        self.populated.extent()
    }

    /// Runs `work` in a slot and sends the event that it returns.
    fn spawn(self: &Arc<Self>, slot: WorkerSlot, work: impl FnOnce(&WorkerPool) -> WorkerEvent + Send + 'static) {
        let worker_pool = self.clone();
        let pool = match slot {
            WorkerSlot::One(slot) => self.lanes.get(slot).unwrap_or(&self.all),
            WorkerSlot::All => &self.all,
        };
        pool.spawn(move || {
            let event = work(&worker_pool);
            // If the receiver is gone, the daemon has ended.
            let _ = worker_pool.events.send(event);
        });
    }

    /// Computes a request in a slot. A panic fails only this request.
    pub(super) fn run(self: &Arc<Self>, job: Arc<Job>, slot: WorkerSlot) {
        self.spawn(slot, move |worker_pool| {
            let _awake = (slot == WorkerSlot::All).then(AwakeThreads::new);
            let profiler = StageProfiler::showing(job.stage().clone());
            let result = catch_unwind(AssertUnwindSafe(|| worker_pool.respond(&job, &profiler)));
            let result = result.unwrap_or_else(|panic| {
                let message = format!("the request failed inside the service: {}", panics::text(panic.as_ref()));
                Err(Error::new(ErrorKind::Failed, "strike", message))
            });
            let result = result.map_err(|error| match job.stopped() {
                Some(why) if error.kind == ErrorKind::Canceled => why.error(),
                _ => error,
            });
            let end = match &result {
                Ok(_) => JobEnd::Completed,
                Err(error) => {
                    if error.kind.fault() == FaultParty::Caller {
                        tracing::debug!(kind = error.kind.name(), at = error.at, "request failed: {error}");
                    } else {
                        tracing::warn!(kind = error.kind.name(), at = error.at, "request failed: {error}");
                    }
                    worker_pool.refuse(&job, error);
                    JobEnd::of(error)
                }
            };
            let energies = result.ok().flatten();
            let (stages, effects) = (Box::new(profiler.stages()), Box::new(profiler.effects()));
            WorkerEvent::Completed { job, end, energies, stages, effects }
        });
    }

    /// Stores the error, closes the request, wakes the client: in this order, so that a client that finds its request closed also
    /// finds the error.
    pub fn refuse(&self, job: &Job, error: &Error) {
        let error_wire = ErrorWire::from(error);
        self.errors.lock().unwrap_or_else(PoisonError::into_inner).keep(job.key(), error_wire);
        job.close();
        self.waker.wake(job.key().0);
    }

    /// Error of a closed request, if it is known.
    pub fn collect_error(&self, strike: RequestKey) -> Option<ErrorWire> {
        self.errors.lock().unwrap_or_else(PoisonError::into_inner).collect(strike)
    }

    fn results(&self) -> MutexGuard<'_, RetainedResults> {
        self.results.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Target of a request that strikes a fragment of a retained result of the object `name`.
    pub(super) fn target(&self, name: &str, origin: RetainedFragment) -> Result<RetainedTarget, Error> {
        self.results().target(name, origin, Instant::now())
    }

    /// Releases a retained result.
    ///
    /// # Errors
    /// `unknown_handle`.
    pub fn release(&self, handle: u64) -> Result<(), Error> {
        let gone = self.results().release(handle)?;
        self.drop_evicted(gone);
        Ok(())
    }

    /// Evicts the retained results whose time is over.
    pub fn expire_kept(&self) {
        let gone = self.results().expire(Instant::now());
        self.drop_evicted(gone);
    }

    /// Number of retained results, and their memory in bytes.
    pub fn kept(&self) -> (u64, u64) {
        self.results().extent()
    }

    /// Frees the memory on a worker thread.
    fn drop_evicted(&self, gone: EvictedResults) {
        if !gone.is_empty() {
            self.all.spawn(move || drop(gone));
        }
    }

    /// Retains a result if its request asks for it; returns its handle, or zero.
    fn keep(&self, strike: &Request, object: Arc<dyn ServedObject>, outcome: &dyn EngineResult) -> u64 {
        if !strike.keep || !self.results().allows_keeping() {
            return 0;
        }
        let Some(kept) = outcome.keep() else { return 0 };
        // The evicted results are dropped here, without the lock.
        let (handle, _gone) = self.results().keep(&strike.object, object, kept, Instant::now());
        handle
    }

    /// Clients that listen.
    pub fn listeners(&self) -> HashSet<[u8; 16]> {
        self.waker.listeners()
    }

    /// Wakes a client.
    pub fn wake(&self, listener: [u8; 16]) {
        self.waker.wake(listener);
    }

    /// Computes and sends the result; returns its energies. Drops the object at the end: the worker thread that uses a
    /// replaced version last frees it.
    fn respond(&self, job: &Job, profiler: &StageProfiler) -> Result<Option<ResultEnergies>, Error> {
        let JobPayload { strike, object, kept } = job.unload()?;
        let _span =
            tracing::info_span!("strike", object = strike.object, client = job.client(), sequence = job.key().1)
                .entered();
        let begun = Instant::now();
        let time = strike.time_ms_max.map(|ms| Duration::from_secs_f64(1e-3 * AIMED_AT * ms));
        let due = time.and_then(|time| job.arrived().checked_add(time));
        let token = due.map_or_else(|| job.token().clone(), |due| job.token().with_time(move || remaining_s(due)));
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
        if job.stopped() == Some(StopCause::Late) {
            return Err(StopCause::Late.error());
        }
        let layout = layout_within_request(&strike, outcome.as_ref())?;
        let mut buffer = self.loan(job, layout.blocks())?;
        self.populated.ensure(buffer.payload_mut())?;
        *buffer.user_header_mut() = layout.header(job.key().1);
        let handle = self.keep(&strike, object, outcome.as_ref());
        let timing = Timing { handle, arrived: job.arrived(), begun, time_ms_max: strike.time_ms_max };
        let written = write(buffer, &layout, outcome.as_ref(), &timing, profiler);
        // The woken client may preempt this thread, so the time is taken before.
        let took = begun.elapsed();
        let sent = written.and_then(|written| job.send(written));
        if handle != 0 && sent.is_err() {
            // No client knows the handle. The result may have been evicted already.
            let _ = self.release(handle);
        }
        sent?;
        // Before the outcome is dropped, which takes as long again.
        self.waker.wake(job.key().0);
        outcome.took(took, &profiler.stages());
        let energies = outcome.energies();
        if let Some(own) = energies {
            let (source, stress) = (own.source.name(), own.stress_over_strength);
            let ResultEnergies { impactor_j, strain_j, surface_j, released_j, deficit_j, .. } = own;
            tracing::debug!(source, impactor_j, strain_j, surface_j, released_j, deficit_j, stress, "energies");
        }
        Ok(energies)
    }

    /// Loans memory for a result. Retries, so that a computed result is not lost because a client died a moment ago.
    fn loan(&self, job: &Job, blocks: usize) -> Result<LoanedBuffer, Error> {
        for pause in CROWDED {
            match job.loan(blocks) {
                Err(error) if error.kind == ErrorKind::Busy && job.stopped().is_none() => {
                    let _ = self.events.send(WorkerEvent::Crowded);
                    std::thread::sleep(pause);
                }
                result => return result,
            }
        }
        job.loan(blocks)
    }
}

/// Seconds until `due`; negative after it.
fn remaining_s(due: Instant) -> f64 {
    let now = Instant::now();
    due.saturating_duration_since(now).as_secs_f64() - now.saturating_duration_since(due).as_secs_f64()
}

/// Computes the layout of the result and checks it against the caller's caps.
fn layout_within_request(strike: &Request, outcome: &dyn EngineResult) -> Result<Layout, Error> {
    let counts = outcome.counts();
    if let Some(cap) = strike.fragments_max.filter(|cap| counts.fragments > *cap as usize) {
        let made = counted(counts.fragments as u64, "fragment");
        let message = format!("{made}, but the request allows {cap}; raise fragments_max");
        return Err(Error::new(ErrorKind::CapExceeded, "fragments_max", message));
    }
    let layout = Layout::new(&counts).ok_or_else(|| {
        Error::new(ErrorKind::ResultTooLarge, "results", format!("{counts:?} cannot be addressed by 32 bits"))
    })?;
    match strike.bytes_max.filter(|cap| layout.used_bytes() > *cap) {
        None => Ok(layout),
        Some(cap) => {
            let message = format!("{} bytes, but the request allows {cap}; raise bytes_max", layout.used_bytes());
            Err(Error::new(ErrorKind::CapExceeded, "bytes_max", message))
        }
    }
}

/// Data of a result that the engine does not know.
struct Timing {
    /// Handle of the retained result; 0: not retained.
    handle: u64,
    /// Arrival of the request.
    arrived: Instant,
    /// Start of the computation.
    begun: Instant,
    /// Requested time budget, ms.
    time_ms_max: Option<f64>,
}

/// Writes the result into the loaned buffer that the client will read.
fn write(
    mut buffer: LoanedBuffer,
    layout: &Layout,
    outcome: &dyn EngineResult,
    timing: &Timing,
    profiler: &StageProfiler,
) -> Result<WrittenResult, Error> {
    let raw: *mut [MaybeUninit<AlignedBlock>] = buffer.payload_mut();
    // SAFETY: the slice is borrowed from `buffer`, which is not touched while `payload` lives. Its bytes are initialized: they are in
    // shared memory, whose pages the kernel zeroes and earlier results wrote; any bytes are a valid `AlignedBlock`.
    let payload: &mut [AlignedBlock] = unsafe { &mut *(raw as *mut [AlignedBlock]) };
    let unfit = || Error::new(ErrorKind::Failed, "layout", "the loaned memory is shorter than the layout");
    let mut sections = layout.split(payload).ok_or_else(unfit)?;
    write_profiled(outcome, &mut sections, layout.base_bytes(), profiler)?;
    let took = timing.arrived.elapsed();
    sections.summary.handle = timing.handle;
    sections.summary.time_ns = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
    if let Some(over) = timing.time_ms_max.and_then(|ms| took.checked_sub(Duration::from_secs_f64(1e-3 * ms))) {
        let waited = timing.begun.saturating_duration_since(timing.arrived);
        let reason = overrun_cause::reason(over, waited, timing.begun.elapsed(), outcome.solved(), &profiler.stages());
        sections.summary.overrun = reason as u32;
        sections.summary.overrun_ns = u64::try_from(over.as_nanos()).unwrap_or(u64::MAX).max(1);
    }
    // SAFETY: every byte is initialized, see above.
    Ok(unsafe { buffer.assume_init() })
}
