//! Everything that wakes the daemon's loop: bells, events, clocks, signals, questions from the operations port.

use crate::config::Config;
use crate::http_endpoints::{LoopInquiry, OperationsPort};
use crate::ipc::WakeSocket;
use crate::jobs::WorkerEvent;
use shatter_proto::{Error, ErrorKind};
use std::sync::Arc;
use std::time::Duration;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::Notify;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::{Interval, MissedTickBehavior, interval};

/// A pause as long as none at all.
const IDLE: Duration = Duration::from_secs(3600);

/// What woke the loop.
pub enum WakeEvent {
    /// A client rang, or a tick has passed.
    Bell,
    /// A computing thread or the librarian has news.
    Event(WorkerEvent),
    /// Time to look for clients that died.
    Cleanup,
    /// Time to write the metrics.
    Metrics,
    /// Time to tell the supervisor that the loop turns.
    Heartbeat,
    /// Time to look at the folder of databases.
    Look,
    /// SIGHUP.
    Reload,
    /// A question from the operations port.
    Inquiry(LoopInquiry),
    /// SIGINT, SIGTERM, or whoever started it.
    End,
}

/// All of it.
pub struct EventSource {
    bell: WakeSocket,
    events: UnboundedReceiver<WorkerEvent>,
    operations: OperationsPort,
    stop: Arc<Notify>,
    cleanup: Interval,
    metrics: Interval,
    look: Option<Interval>,
    heartbeat: Option<Interval>,
    signals: Signals,
}

/// The signals that the daemon hears; heard from the moment it has them, so that one that comes early ends it in order.
pub struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hangup: Signal,
}

impl Signals {
    /// Needs a tokio runtime.
    ///
    /// # Errors
    /// `failed`.
    pub fn listen_for_signals() -> Result<Self, Error> {
        let hear = |kind| signal(kind).map_err(|error| Error::new(ErrorKind::Failed, "signals", error.to_string()));
        Ok(Self {
            interrupt: hear(SignalKind::interrupt())?,
            terminate: hear(SignalKind::terminate())?,
            hangup: hear(SignalKind::hangup())?,
        })
    }

    /// What `work` returns, done on a thread of its own; `None` if SIGINT, SIGTERM or `stop` came first. The work is then abandoned: it ends with
    /// the process.
    ///
    /// # Errors
    /// `failed` if the work panicked, or no thread can be started.
    pub async fn unless_ended<T: Send + 'static>(
        &mut self,
        stop: &Notify,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<Option<T>, Error> {
        let (sender, done) = tokio::sync::oneshot::channel();
        let failed = |why: String| Error::new(ErrorKind::Failed, "threads", why);
        // The receiver is gone where the work was abandoned.
        let work = move || drop(sender.send(work()));
        let begun = std::thread::Builder::new().name("begin".to_owned()).spawn(work);
        begun.map_err(|error| failed(format!("no thread can be started: {error}")))?;
        tokio::select! {
            biased;
            _ = self.interrupt.recv() => Ok(None),
            _ = self.terminate.recv() => Ok(None),
            () = stop.notified() => Ok(None),
            done = done => done.map(Some).map_err(|_| failed("loading the databases failed".to_owned())),
        }
    }
}

impl EventSource {
    /// Needs a tokio runtime.
    pub fn new(
        config: &Config,
        bell: WakeSocket,
        events: UnboundedReceiver<WorkerEvent>,
        operations: OperationsPort,
        signals: Signals,
        stop: Arc<Notify>,
    ) -> Self {
        let mut cleanup = every(Duration::from_millis(config.times.cleanup_ms));
        // At the start there is nothing to clean up.
        cleanup.reset();
        Self {
            bell,
            events,
            operations,
            stop,
            cleanup,
            metrics: every(Duration::from_secs(config.times.metrics_s)),
            look: config.watch().map(every),
            heartbeat: sd_notify::watchdog_enabled().map(|period| every(period / 2)),
            signals,
        }
    }

    /// Waits until something happens, or a tick has passed: a lost ring costs that long.
    pub async fn next(&mut self, tick: Duration) -> WakeEvent {
        tokio::select! {
            () = self.bell.wait(tick) => WakeEvent::Bell,
            Some(event) = self.events.recv() => WakeEvent::Event(event),
            _ = self.cleanup.tick() => WakeEvent::Cleanup,
            _ = self.metrics.tick() => WakeEvent::Metrics,
            () = next(&mut self.heartbeat) => WakeEvent::Heartbeat,
            () = next(&mut self.look) => WakeEvent::Look,
            inquiry = self.operations.next() => WakeEvent::Inquiry(inquiry),
            _ = self.signals.hangup.recv() => WakeEvent::Reload,
            _ = self.signals.interrupt.recv() => WakeEvent::End,
            _ = self.signals.terminate.recv() => WakeEvent::End,
            () = self.stop.notified() => WakeEvent::End,
        }
    }
}

fn every(period: Duration) -> Interval {
    let mut interval = interval(period.clamp(Duration::from_millis(1), IDLE));
    interval.set_missed_tick_behavior(MissedTickBehavior::Skip);
    interval
}

/// The next tick of a clock that may not be wanted.
async fn next(interval: &mut Option<Interval>) {
    match interval {
        Some(interval) => drop(interval.tick().await),
        None => std::future::pending().await,
    }
}
