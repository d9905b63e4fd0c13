//! Events that wake the daemon's loop: client wake-ups, worker events, timers, signals, inquiries from the operations port.

use crate::config::Config;
use crate::http_endpoints::{DaemonInquiry, OperationsPort};
use crate::ipc::WakeSocket;
use crate::jobs::{WorkerEvent, no_thread};
use shatter_proto::{Error, ErrorKind};
use std::sync::Arc;
use std::time::Duration;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::Notify;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::{Interval, MissedTickBehavior, interval};

/// Longest period of a timer.
const IDLE: Duration = Duration::from_secs(3600);

/// Reason for which the loop woke up.
pub enum WakeEvent {
    /// A client woke the daemon, or a tick has passed.
    Wake,
    /// A worker thread or the hot reloader sent an event.
    Event(WorkerEvent),
    /// Time to look for dead clients.
    Cleanup,
    /// Time to write the metrics.
    Metrics,
    /// Time to report to the supervisor that the loop runs.
    Heartbeat,
    /// Time to scan the database folder.
    Scan,
    /// SIGHUP.
    Reload,
    /// Inquiry from the operations port.
    Inquiry(DaemonInquiry),
    /// SIGINT, SIGTERM, or the stop notification of the caller.
    End,
}

/// Source of all events of the loop.
pub struct EventSource {
    wake_socket: WakeSocket,
    events: UnboundedReceiver<WorkerEvent>,
    operations: OperationsPort,
    stop: Arc<Notify>,
    cleanup: Interval,
    metrics: Interval,
    scan: Option<Interval>,
    heartbeat: Option<Interval>,
    signals: Signals,
}

/// Signal handlers of the daemon. They are installed early, so that a signal during start-up ends the daemon in order.
pub struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hangup: Signal,
}

impl Signals {
    /// Installs the handlers. Needs a tokio runtime.
    ///
    /// # Errors
    /// `failed`.
    pub fn listen_for_signals() -> Result<Self, Error> {
        let listen = |kind| signal(kind).map_err(|error| Error::new(ErrorKind::Failed, "signals", error.to_string()));
        Ok(Self {
            interrupt: listen(SignalKind::interrupt())?,
            terminate: listen(SignalKind::terminate())?,
            hangup: listen(SignalKind::hangup())?,
        })
    }

    /// Runs `work` on a separate thread and returns its result; `None` if SIGINT, SIGTERM or `stop` came first.
    ///
    /// The abandoned work then ends with the process.
    ///
    /// # Errors
    /// `failed` if the work panicked, or no thread can be started.
    pub async fn unless_ended<T: Send + 'static>(
        &mut self,
        stop: &Notify,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<Option<T>, Error> {
        let (sender, done) = tokio::sync::oneshot::channel();
        // If the work was abandoned, there is no receiver.
        let work = move || drop(sender.send(work()));
        let begun = std::thread::Builder::new().name("begin".to_owned()).spawn(work);
        begun.map_err(|error| no_thread(&error))?;
        tokio::select! {
            biased;
            _ = self.interrupt.recv() => Ok(None),
            _ = self.terminate.recv() => Ok(None),
            () = stop.notified() => Ok(None),
            done = done => done.map(Some).map_err(|_| Error::new(ErrorKind::Failed, "threads", "loading the databases failed")),
        }
    }
}

impl EventSource {
    /// Creates the source. Needs a tokio runtime.
    pub fn new(
        config: &Config,
        wake_socket: WakeSocket,
        events: UnboundedReceiver<WorkerEvent>,
        operations: OperationsPort,
        signals: Signals,
        stop: Arc<Notify>,
    ) -> Self {
        let mut cleanup = every(Duration::from_millis(config.times.cleanup_ms));
        // At start-up there is nothing to clean up.
        cleanup.reset();
        Self {
            wake_socket,
            events,
            operations,
            stop,
            cleanup,
            metrics: every(Duration::from_secs(config.times.metrics_s)),
            scan: config.watch().map(every),
            heartbeat: sd_notify::watchdog_enabled().map(|period| every(period / 2)),
            signals,
        }
    }

    /// Waits until an event arrives or a tick has passed; a lost wake-up costs at most a tick.
    pub async fn next(&mut self, tick: Duration) -> WakeEvent {
        tokio::select! {
            () = self.wake_socket.wait(tick) => WakeEvent::Wake,
            Some(event) = self.events.recv() => WakeEvent::Event(event),
            _ = self.cleanup.tick() => WakeEvent::Cleanup,
            _ = self.metrics.tick() => WakeEvent::Metrics,
            () = next(&mut self.heartbeat) => WakeEvent::Heartbeat,
            () = next(&mut self.scan) => WakeEvent::Scan,
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

/// Next tick of a timer; never returns without a timer.
async fn next(interval: &mut Option<Interval>) {
    match interval {
        Some(interval) => drop(interval.tick().await),
        None => std::future::pending().await,
    }
}
