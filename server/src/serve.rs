//! The daemon from start to end, and its loop.

use crate::catalog::{Catalog, Retired, unix_ns};
use crate::config::Config;
use crate::engine::Loader;
use crate::ipc::{ActiveQuestion, Bell, Home, Pool, Populated, Ports, shared_memory_free};
use crate::jobs::{Crew, Event, Jobs, threads};
use crate::librarian::{Folder, Librarian};
use crate::metrics::{End, Metrics};
use bytemuck::Zeroable;
use sd_notify::NotifyState;
use shatter_proto::answer::{BLOCK_BYTES, Block};
use shatter_proto::control::{self, ControlHeader, Question, ROWS_MAX, Row, StatusRow};
use shatter_proto::place::Place;
use shatter_proto::refusal::RefusalWire;
use shatter_proto::transport::failed;
use shatter_proto::{Kind, Refusal};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::Notify;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::time::{Interval, MissedTickBehavior, interval};

const MIB: usize = 1024 * 1024;

/// Smallest bucket: also a service without objects has a pool.
const BUCKET_MIN_BYTES: usize = MIB;

/// What shared memory must be able to take beyond the rehearsal.
const SHARED_MEMORY_SPARE: usize = 4 * MIB;

/// How long strikes that compute may take to finish when the daemon ends, and to notice that they are cancelled.
const GRACE: Duration = Duration::from_secs(3);

/// A pause as long as none at all.
const IDLE: Duration = Duration::from_secs(3600);

/// What a daemon needs to know.
pub struct Options {
    /// Where it lives.
    pub place: Place,
    /// How it is set.
    pub config: Config,
    /// How databases become objects.
    pub loader: Loader,
    /// Called once it serves.
    pub ready: Box<dyn FnOnce() + Send>,
    /// Ends it, as SIGTERM does.
    pub stop: Arc<Notify>,
}

/// Serves until SIGINT, SIGTERM or `options.stop`. Errors: `second_daemon`, `runtime_folder`, `database_folder`,
/// `shared_memory`, `transport`.
pub fn run(options: Options) -> Result<(), Refusal> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|error| Refusal::new(Kind::Failed, "runtime", error.to_string()))?;
    runtime.block_on(serve(options))
}

async fn serve(options: Options) -> Result<(), Refusal> {
    let Options { place, config, loader, ready, stop } = options;
    let mut signals = Signals::new().map_err(|error| Refusal::new(Kind::Failed, "signals", error.to_string()))?;
    let home = Home::take(&place)?;
    let (mut daemon, bell, mut events) = Daemon::start(home, config, loader)?;
    daemon.home.say_hello()?;
    notify(&[NotifyState::Ready]);
    tracing::info!(service = place.service.as_str(), folder = %place.folder.display(), "ready");
    ready();
    daemon.librarian.finish(&daemon.catalog);
    daemon.serve(&bell, &mut events, &mut signals, &stop).await;
    notify(&[NotifyState::Stopping]);
    daemon.end(bell, &mut events).await;
    Ok(())
}

fn notify(states: &[NotifyState]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::warn!(%error, "the supervisor cannot be told");
    }
}

struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hangup: Signal,
}

impl Signals {
    fn new() -> std::io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hangup: signal(SignalKind::hangup())?,
        })
    }
}

/// A running daemon. Fields are dropped in this order: what uses the ports before the ports, these before the home.
struct Daemon {
    jobs: Jobs,
    crew: Arc<Crew>,
    ports: Ports,
    catalog: Arc<Catalog>,
    librarian: Librarian,
    retired: Retired,
    reloads: u64,
    metrics: Metrics,
    started: Instant,
    config: Config,
    home: Home,
}

impl Daemon {
    fn start(home: Home, config: Config, loader: Loader) -> Result<(Self, Bell, UnboundedReceiver<Event>), Refusal> {
        let begun = Instant::now();
        let folder = folder(&config)?;
        let threads = threads(config.threads())?;
        let catalog = threads.install(|| folder.look().map(|shelf| Catalog::default().renewed(shelf, &loader)))?;
        announce(&catalog, begun);
        let pool = pool(&config, &catalog);
        let rehearsed = (config.answers.prefault_mib * MIB / BLOCK_BYTES).min(pool.blocks);
        let needed = (config.answers.prefault_buckets * rehearsed * BLOCK_BYTES + SHARED_MEMORY_SPARE) as u64;
        let free = shared_memory_free()?;
        if free < needed {
            let message = format!("shared memory has {free} bytes left, {needed} are needed to start");
            return Err(Refusal::new(Kind::SharedMemory, "/dev/shm", message));
        }
        let (ports, bell, waker) = Ports::open(home.place(), pool)?;
        let populated = Populated::default();
        ports.rehearse(config.answers.prefault_buckets, rehearsed, &populated)?;
        let (sender, events) = unbounded_channel();
        let librarian = Librarian::new(folder, loader, sender.clone())?;
        let crew = Arc::new(Crew::new(threads, populated, waker, sender));
        let jobs = Jobs::new(config.strikes_at_once(), config.compute.queue_max, crew.clone());
        let (metrics, started) = (Metrics::new()?, Instant::now());
        let (catalog, retired, reloads) = (Arc::new(catalog), Retired::default(), 0);
        let daemon = Self { jobs, crew, ports, catalog, librarian, retired, reloads, metrics, started, config, home };
        Ok((daemon, bell, events))
    }

    /// Until someone ends it. Every wait has a bound, and after each everything is looked at.
    async fn serve(
        &mut self,
        bell: &Bell,
        events: &mut UnboundedReceiver<Event>,
        signals: &mut Signals,
        stop: &Notify,
    ) {
        let mut cleanup = every(Duration::from_millis(self.config.times.cleanup_ms));
        let mut metrics = every(Duration::from_secs(self.config.times.metrics_s));
        let watch = self.config.watch();
        let mut look = every(watch.unwrap_or(IDLE));
        let watchdog = sd_notify::watchdog_enabled();
        let mut heartbeat = every(watchdog.map_or(IDLE, |period| period / 2));
        loop {
            tokio::select! {
                () = bell.wait(self.nap()) => {}
                Some(event) = events.recv() => self.on(event),
                _ = cleanup.tick() => self.bury_the_dead(),
                _ = metrics.tick() => self.write_metrics(),
                _ = heartbeat.tick(), if watchdog.is_some() => notify(&[NotifyState::Watchdog]),
                _ = look.tick(), if watch.is_some() => self.librarian.look(),
                _ = signals.hangup.recv() => self.librarian.reload(&self.catalog),
                _ = signals.interrupt.recv() => return,
                _ = signals.terminate.recv() => return,
                () = stop.notified() => return,
            }
            self.receive();
            for _ in 0..self.jobs.prune() {
                self.metrics.ended(End::Cancelled);
            }
            for end in self.jobs.expire() {
                self.metrics.ended(end);
            }
        }
    }

    /// How long it may sleep: a tick, or until the next deadline.
    fn nap(&self) -> Duration {
        let left = |deadline: Instant| deadline.saturating_duration_since(Instant::now());
        self.jobs.next_deadline().map_or(self.config.tick(), |deadline| left(deadline).min(self.config.tick()))
    }

    /// Takes in everything that waits at the ports: scheduling is done in our own queue.
    fn receive(&mut self) {
        while let Some(question) = self.ports.next_question() {
            self.reply(&question);
        }
        while let Some(strike) = self.ports.next_strike() {
            if let Some(end) = self.jobs.admit(strike, &self.catalog) {
                self.metrics.ended(end);
            }
        }
    }

    fn on(&mut self, event: Event) {
        match event {
            Event::Landed { flight, end, stages } => {
                self.metrics.ran(end, flight.arrived().elapsed(), &stages);
                self.jobs.landed(&flight, end);
            }
            Event::News(news) => {
                if let Some(catalog) = self.librarian.hear(news, &self.catalog) {
                    self.take(catalog);
                }
            }
        }
    }

    /// Swaps the databases whole. Strikes that were admitted keep the versions that they were admitted with.
    fn take(&mut self, catalog: Arc<Catalog>) {
        if catalog.answer_bytes_max() as u64 > self.ports.pool().bucket_bytes() {
            tracing::warn!("answers of the new objects may exceed the buckets: restart the daemon to enlarge them");
        }
        self.retired.note(&self.catalog, &catalog);
        let (ready, entries, bytes) = (catalog.ready(), catalog.len(), catalog.memory_bytes());
        tracing::info!(ready, entries, bytes, "databases read again");
        self.librarian.release(std::mem::replace(&mut self.catalog, catalog));
        self.reloads += 1;
    }

    fn bury_the_dead(&mut self) {
        let dead = self.ports.bury_the_dead();
        if dead > 0 {
            tracing::info!(dead, "cleaned up after clients that died");
        }
    }

    fn write_metrics(&mut self) {
        let text = self.metrics.text(&self.status());
        if let Err(refusal) = self.home.write_metrics(&text) {
            tracing::warn!(%refusal, "metrics");
        }
    }

    fn status(&self) -> StatusRow {
        let pool = self.ports.pool();
        let mut row = StatusRow {
            pid: std::process::id(),
            objects_ready: self.catalog.ready() as u32,
            objects_failed: (self.catalog.len() - self.catalog.ready()) as u32,
            threads: self.crew.threads() as u32,
            running: self.jobs.running() as u32,
            queued: self.jobs.queued() as u32,
            queue_max: self.config.compute.queue_max as u32,
            clients: self.ports.clients() as u32,
            buckets: pool.buckets as u32,
            objects_outdated: self.catalog.outdated() as u32,
            bucket_bytes: pool.bucket_bytes(),
            uptime_ns: u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX),
            memory_bytes: self.catalog.memory_bytes(),
            reloads: self.reloads,
            read_unix_ns: unix_ns(self.catalog.read()),
            ..StatusRow::zeroed()
        };
        (row.retired, row.retired_bytes) = self.retired.alive();
        self.metrics.fill(&mut row);
        row
    }

    /// Replies to a question at once, from the small pool.
    fn reply(&self, active: &ActiveQuestion) {
        let wire = *active.payload();
        let sent = match wire.validate() {
            Ok(Question::List(first)) => {
                let rows = self.catalog.rows(first as usize, ROWS_MAX);
                send_rows(active, &rows, self.catalog.len(), false)
            }
            Ok(Question::Status) => send_rows(active, &[self.status()], 1, false),
            Ok(Question::Verdict(sequence)) => {
                let verdict = self.crew.verdict((wire.listener, sequence));
                send_rows(active, verdict.as_slice(), verdict.iter().len(), false)
            }
            Err(refusal) => send_rows(active, &[RefusalWire::from(&refusal)], 1, true),
        };
        match sent {
            Ok(()) => self.crew.wake(wire.listener),
            Err(refusal) => tracing::warn!(%refusal, "a question stays without a reply"),
        }
    }

    /// Ends in order: nobody new, what waits is refused, what computes may finish for a while.
    async fn end(mut self, bell: Bell, events: &mut UnboundedReceiver<Event>) {
        tracing::info!("ending");
        self.home.say_goodbye();
        for _ in 0..self.jobs.stop() {
            self.metrics.ended(End::Busy);
        }
        let begun = Instant::now();
        while self.jobs.running() > 0 && begun.elapsed() < 2 * GRACE {
            tokio::select! {
                Some(event) = events.recv() => self.on(event),
                () = bell.wait(self.config.tick()) => {}
            }
            while let Some(question) = self.ports.next_question() {
                self.reply(&question);
            }
            self.jobs.prune();
            if begun.elapsed() > GRACE {
                self.jobs.cancel();
            }
        }
        self.write_metrics();
        let Self { jobs, crew, ports, home, .. } = self;
        // Everything that holds on to the transport: afterwards no node of ours is alive.
        drop((jobs, crew, ports, bell));
        if let Err(refusal) = home.heal() {
            tracing::warn!(%refusal, "leftovers stay");
        }
    }
}

/// Where the databases are. The platform's own folder may not exist yet; one that was asked for must.
fn folder(config: &Config) -> Result<Folder, Refusal> {
    let required = !config.databases.folder.as_os_str().is_empty();
    let folder = Folder { path: config.databases()?, required };
    if !required && !folder.path.exists() {
        tracing::warn!(folder = %folder.path.display(), "there are no databases yet");
    }
    Ok(folder)
}

fn announce(catalog: &Catalog, begun: Instant) {
    let (ready, entries, bytes) = (catalog.ready(), catalog.len(), catalog.memory_bytes());
    tracing::info!(ready, entries, bytes, ms = begun.elapsed().as_millis() as u64, "databases loaded");
}

/// Buckets as large as the largest answer of the loaded objects needs. They cost nothing until they are written.
fn pool(config: &Config, catalog: &Catalog) -> Pool {
    let bytes = catalog.answer_bytes_max().max(BUCKET_MIN_BYTES).min(config.answers.bucket_mib_max * MIB);
    Pool { buckets: config.answers.buckets, blocks: bytes.div_ceil(BLOCK_BYTES) }
}

fn every(period: Duration) -> Interval {
    let mut interval = interval(period.max(Duration::from_millis(1)));
    interval.set_missed_tick_behavior(MissedTickBehavior::Skip);
    interval
}

fn send_rows<R: Row>(active: &ActiveQuestion, rows: &[R], total: usize, refused: bool) -> Result<(), Refusal> {
    let mut payload = vec![Block::zeroed(); control::blocks::<R>(rows.len()).max(1)];
    let header: ControlHeader = control::write(&mut payload, rows, total, refused);
    let lent = active.loan_slice_uninit(payload.len()).map_err(|error| failed("reply", error))?;
    let mut reply = lent.write_from_slice(&payload);
    *reply.user_header_mut() = header;
    reply.send().map_err(|error| failed("reply", error))
}
