//! The daemon from start to end, and its event loop.

use crate::buckets;
use crate::catalog::{Catalog, RetiredVersions, unix_ns};
use crate::config::Config;
use crate::event_source::{EventSource, Signals, WakeEvent};
use crate::hot_reloader::HotReloader;
use crate::http_endpoints::{DaemonInquiry, DaemonReport, OperationsPort};
use crate::ipc::{ActiveControlRequest, DaemonPorts, RuntimeDirectory, WakeSocket};
use crate::jobs::{Jobs, WorkerEvent, WorkerPool, lanes};
use crate::loaded_databases::LoadedDatabases;
use crate::metrics::{JobEnd, Metrics};
use crate::pending_arrivals::PendingArrivals;
use crate::pending_list_requests::PendingListRequests;
use crate::retained::RetainedResults;
use bytemuck::Zeroable;
use sd_notify::NotifyState;
use shatter_engine::object::Loader;
use shatter_proto::control::{self, ControlReplyHeader, ControlRequest, ROWS_MAX, ReplyRow, ServiceStatusRow};
use shatter_proto::error::ErrorWire;
use shatter_proto::result::{AlignedBlock, BLOCK_BYTES};
use shatter_proto::{Error, ErrorKind, text};
use shatter_transport::failed;
use shatter_transport::paths::ServicePaths;
use shatter_transport::workarounds::client_entry::ClientEntryCheck;
use shatter_transport::workarounds::populated_pages::PopulatedPages;
use shatter_transport::workarounds::shared_memory;
use shatter_transport::workarounds::stale_segments::StaleSegmentReaper;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::Notify;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

const MIB: usize = 1024 * 1024;

/// Shared memory that must be free beyond the rehearsal, bytes.
const SHARED_MEMORY_SPARE: usize = 4 * MIB;

/// Time for computing requests to notice that they are canceled when the daemon ends.
const GRACE: Duration = Duration::from_secs(3);

/// Time for which an ending daemon stays reachable, so that refused clients can collect their errors.
///
/// Clients on a busy machine took over 100 ms.
const FINAL_REPLIES_TIME: Duration = Duration::from_millis(250);

/// Options of a daemon.
pub struct ServeOptions {
    /// Paths of the service.
    pub paths: ServicePaths,
    /// Configuration.
    pub config: Config,
    /// Loader of databases.
    pub loader: Loader,
    /// Objects of the scene and the names of their databases; `None`: all databases of the folder are served.
    pub only: Option<BTreeMap<String, String>>,
    /// Called once the daemon serves; an error ends it.
    pub ready: Box<dyn FnOnce() -> Result<(), Error> + Send>,
    /// Ends the daemon, as SIGTERM does.
    pub stop: Arc<Notify>,
}

/// Serves until SIGINT, SIGTERM or `options.stop`.
///
/// # Errors
/// `second_daemon`, `runtime_folder`, `database_folder`, `shared_memory`, `transport`.
pub fn run(options: ServeOptions) -> Result<(), Error> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|error| Error::new(ErrorKind::Failed, "runtime", error.to_string()))?;
    runtime.block_on(serve(options))
}

async fn serve(options: ServeOptions) -> Result<(), Error> {
    let ServeOptions { paths, config, loader, only, ready, stop } = options;
    let mut signals = Signals::listen_for_signals()?;
    let directory = RuntimeDirectory::take(&paths)?;
    let (operations, directory) = or_close(OperationsPort::open(config.operations.port).await, directory)?;
    let settings = config.clone();
    let Some(loaded) = signals.unless_ended(&stop, move || LoadedDatabases::of(&settings, loader, only)).await? else {
        tracing::info!("stopped while the databases were loaded");
        return directory.close();
    };
    let (loaded, directory) = or_close(loaded, directory)?;
    let (mut daemon, wake_socket, events) = Daemon::start(directory, config, loaded)?;
    let mut event_source = EventSource::new(&daemon.config, wake_socket, events, operations, signals, stop);
    daemon.directory.announce()?;
    daemon.tell(NotifyState::Ready);
    tracing::info!(service = paths.service.as_str(), folder = %paths.folder.display(), "ready");
    let reported = ready();
    if reported.is_ok() {
        daemon.reloader.finish(&daemon.catalog);
        while !daemon.turn(&mut event_source).await {}
    }
    daemon.end(event_source).await;
    reported
}

/// Removes the runtime directory if a step of the start failed.
fn or_close<T>(started: Result<T, Error>, directory: RuntimeDirectory) -> Result<(T, RuntimeDirectory), Error> {
    match started {
        Ok(started) => Ok((started, directory)),
        Err(error) => directory.close().and(Err(error)),
    }
}

fn notify(states: &[NotifyState]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::warn!(%error, "cannot notify the supervisor");
    }
}

/// Running daemon. Fields are dropped in this order: users of the ports, then the ports, then the runtime directory.
struct Daemon {
    jobs: Jobs,
    worker_pool: Arc<WorkerPool>,
    ports: DaemonPorts,
    catalog: Arc<Catalog>,
    reloader: HotReloader,
    retired: RetiredVersions,
    /// Bucket size that a warning has asked for, bytes; 0: no warning yet.
    short_bytes: u64,
    metrics: Metrics,
    started: Instant,
    config: Config,
    directory: RuntimeDirectory,
    reaper: StaleSegmentReaper,
    arrivals: PendingArrivals,
    lists: PendingListRequests,
    client_entry: ClientEntryCheck,
}

impl Daemon {
    fn start(
        directory: RuntimeDirectory,
        config: Config,
        loaded: LoadedDatabases,
    ) -> Result<(Self, WakeSocket, UnboundedReceiver<WorkerEvent>), Error> {
        let LoadedDatabases { folder, loader, threads, catalog } = loaded;
        let lanes = lanes(config.requests_at_once(), config.compute.nice)?;
        let pool = buckets::size(&config, &catalog)?;
        let rehearsed =
            (config.results.prefault_mib * MIB).min(catalog.result_bytes_max().max(MIB)).div_ceil(BLOCK_BYTES);
        let needed = (config.results.prefault_buckets * rehearsed * BLOCK_BYTES + SHARED_MEMORY_SPARE) as u64;
        shared_memory::need(needed)?;
        let (ports, wake_socket, waker) = DaemonPorts::open(directory.instance(), pool)?;
        let client_entry = ClientEntryCheck::open(directory.instance(), directory.paths().uid)?;
        let populated = PopulatedPages::default();
        ports.rehearse(config.results.prefault_buckets, rehearsed, &populated)?;
        shared_memory::populate_mapped(&directory.instance().folder)?;
        let (sender, events) = unbounded_channel();
        let reloader = HotReloader::new(folder, loader, config.compute.nice, sender.clone())?;
        let retained = RetainedResults::new(config.results.kept_max, config.kept());
        let worker_pool = Arc::new(WorkerPool::new(threads, lanes, retained, populated, waker, sender));
        let jobs = Jobs::new(config.compute.queue_max, config.held_max(), worker_pool.clone());
        let (metrics, started) = (Metrics::new()?, Instant::now());
        let (catalog, retired, reaper) = (Arc::new(catalog), RetiredVersions::default(), StaleSegmentReaper::default());
        let (arrivals, lists) = (PendingArrivals::default(), PendingListRequests::default());
        let daemon = Self {
            jobs,
            worker_pool,
            ports,
            catalog,
            reloader,
            retired,
            short_bytes: 0,
            metrics,
            started,
            config,
            directory,
            reaper,
            arrivals,
            lists,
            client_entry,
        };
        Ok((daemon, wake_socket, events))
    }

    /// Waits for an event or a tick, then handles everything that is pending: every wait has a bound. Returns whether the daemon should
    /// end.
    async fn turn(&mut self, event_source: &mut EventSource) -> bool {
        match event_source.next(self.time_until_tick()).await {
            WakeEvent::Wake => {}
            WakeEvent::Event(event) => self.on(event),
            WakeEvent::Cleanup => {
                self.reap_dead_clients();
                self.reap_stale_segments();
                self.arrivals.retain(&self.worker_pool.listeners());
                self.directory.sweep();
                // The check logs and repairs damage itself.
                let _ = self.check_client_entry();
            }
            WakeEvent::Metrics => self.write_metrics(),
            WakeEvent::Heartbeat => notify(&[NotifyState::Watchdog]),
            WakeEvent::Scan => self.reloader.scan(),
            WakeEvent::Reload => self.reloader.reload(&self.catalog),
            WakeEvent::Inquiry(inquiry) => self.report(inquiry),
            WakeEvent::End => return true,
        }
        for _ in 0..self.jobs.prune() {
            self.metrics.ended(JobEnd::Canceled);
        }
        self.worker_pool.expire_kept();
        self.receive();
        for end in self.jobs.expire() {
            self.metrics.ended(end);
        }
        false
    }

    /// Longest wait: a tick, or until the next deadline.
    fn time_until_tick(&self) -> Duration {
        let left = |deadline: Instant| deadline.saturating_duration_since(Instant::now());
        self.jobs.next_deadline().map_or(self.config.tick(), |deadline| left(deadline).min(self.config.tick()))
    }

    /// Receives everything that waits at the ports; the daemon schedules in its own queue.
    fn receive(&mut self) {
        self.receive_impact_requests();
        while let Some(active) = self.ports.next_control_request() {
            let wire = *active.payload();
            let early =
                wire.validate().ok().filter(|request| !self.arrivals.follows_all_requests(wire.listener, *request));
            let now = match early {
                Some(request) => self.arrivals.hold(active, wire.listener, request),
                None => Some(active),
            };
            now.into_iter().for_each(|active| self.handle_control(active));
        }
        if self.arrivals.is_waiting() {
            // The impact requests that a control request follows were sent before it.
            self.receive_impact_requests();
            self.arrivals.due().into_iter().for_each(|active| self.handle_control(active));
        }
        self.lists.due(self.reloader.scans_done()).iter().for_each(|active| self.reply(active));
    }

    /// Replies to a control request. The first page of a list waits for a scan of the database folder, so that a database written a moment
    /// ago is listed as being loaded.
    fn handle_control(&mut self, active: ActiveControlRequest) {
        let is_list = matches!(active.payload().validate(), Ok(ControlRequest::List(0)));
        let now = match is_list && self.config.watch().is_some() {
            true => self.lists.hold(active, self.reloader.scan_for_client()),
            false => Some(active),
        };
        now.iter().for_each(|active| self.reply(active));
    }

    fn receive_impact_requests(&mut self) {
        while let Some(strike) = self.ports.next_impact_request() {
            let wire = *strike.payload();
            self.arrivals.note(wire.listener, wire.sequence);
            if let Some(end) = self.jobs.admit(strike, &wire, &self.catalog) {
                self.metrics.ended(end);
            }
        }
    }

    fn on(&mut self, event: WorkerEvent) {
        match event {
            WorkerEvent::Completed { job, end, energies, stages, effects } => {
                self.metrics.ran(end, job.arrived().elapsed(), energies, &stages, &effects);
                self.jobs.completed(&job, end);
            }
            WorkerEvent::Reload(reload_event) => {
                if let Some(catalog) = self.reloader.handle(reload_event, &self.catalog) {
                    self.take(catalog);
                }
                if let Some(catalog) = self.reloader.expected(&self.catalog) {
                    self.catalog = catalog;
                }
            }
            WorkerEvent::Crowded => self.reap_dead_clients(),
        }
    }

    /// Replaces the catalog as a whole. Accepted requests keep their versions.
    fn take(&mut self, catalog: Arc<Catalog>) {
        let wanted = (buckets::blocks(&self.config, &catalog) * BLOCK_BYTES) as u64;
        if buckets::is_short(wanted, self.ports.pool().bucket_bytes(), &mut self.short_bytes) {
            let [wanted_mib, bucket_mib] = [wanted, self.ports.pool().bucket_bytes()].map(|bytes| bytes / MIB as u64);
            tracing::warn!(
                wanted_mib,
                bucket_mib,
                "results may exceed the buckets; restart the daemon to enlarge them"
            );
        }
        self.retired.note(&self.catalog, &catalog);
        self.reloader.release(std::mem::replace(&mut self.catalog, catalog));
    }

    fn reap_dead_clients(&mut self) {
        if !self.directory.has_segments() {
            return;
        }
        let dead = self.ports.reap_dead_clients();
        if dead > 0 {
            tracing::info!(dead, "cleaned up after dead clients");
        }
    }

    /// Removes segments that no process owns, alive or dead.
    fn reap_stale_segments(&mut self) {
        if !self.directory.has_segments() {
            return;
        }
        let removed_segments = self.reaper.reap(self.directory.instance());
        if removed_segments > 0 {
            tracing::info!(removed_segments, "removed segments without an owner");
        }
    }

    fn write_metrics(&mut self) {
        let text = self.metrics.text(&self.status());
        if let Err(error) = self.directory.write_metrics(&text) {
            tracing::warn!(%error, "cannot write the metrics file");
        }
    }

    fn status(&self) -> ServiceStatusRow {
        let pool = self.ports.pool();
        let mut row = ServiceStatusRow {
            pid: std::process::id(),
            objects_ready: self.catalog.ready() as u32,
            objects_failed: self.catalog.failed() as u32,
            objects_loading: self.catalog.loading() as u32,
            threads: self.worker_pool.threads() as u32,
            running: self.jobs.running() as u32,
            queued: self.jobs.queued() as u32,
            queue_max: self.config.compute.queue_max as u32,
            clients: self.ports.clients() as u32,
            clients_max: pool.clients as u32,
            buckets: pool.buckets as u32,
            objects_outdated: self.catalog.outdated() as u32,
            bucket_bytes: pool.bucket_bytes(),
            uptime_ns: u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX),
            memory_bytes: self.catalog.memory_bytes(),
            restarts: self.directory.past().restarts,
            crashes: self.directory.past().crashes,
            ending: u32::from(self.jobs.closed()),
            unread: self.jobs.unread_results() as u64,
            reloads: self.reloader.reloads(),
            read_unix_ns: unix_ns(self.catalog.read()),
            ..ServiceStatusRow::zeroed()
        };
        (row.retired, row.retired_bytes) = self.retired.alive();
        (row.buckets_used_max, row.buckets_bytes) = self.worker_pool.pool_extent();
        (row.kept, row.kept_bytes) = self.worker_pool.kept();
        self.metrics.fill(&mut row);
        row
    }

    /// Replies to a control request at once, from the small pool.
    fn reply(&self, active: &ActiveControlRequest) {
        let wire = *active.payload();
        let sent = match wire.validate() {
            Ok(ControlRequest::List(first)) => {
                let rows = self.catalog.rows(first as usize, ROWS_MAX);
                send_rows(active, &rows, self.catalog.len(), false)
            }
            Ok(ControlRequest::Status) => send_rows(active, &[self.status()], 1, false),
            Ok(ControlRequest::RequestError(sequence)) => {
                let error = self.worker_pool.collect_error((wire.listener, sequence));
                send_rows(active, error.as_slice(), error.iter().len(), false)
            }
            Ok(ControlRequest::Progress(sequence)) => {
                let progress = self.jobs.progress((wire.listener, sequence));
                send_rows(active, progress.as_slice(), progress.iter().len(), false)
            }
            Ok(ControlRequest::Release { handle, .. }) => match self.worker_pool.release(handle) {
                Ok(()) => send_rows::<ErrorWire>(active, &[], 0, false),
                Err(error) => send_rows(active, &[ErrorWire::from(&error)], 1, true),
            },
            Err(error) => send_rows(active, &[ErrorWire::from(&error)], 1, true),
        };
        match sent {
            Ok(()) => self.worker_pool.wake(wire.listener),
            Err(error) => tracing::warn!(%error, "cannot reply to a control request"),
        }
    }

    /// Reports a state and a summary to the supervisor.
    fn tell(&self, state: NotifyState<'_>) {
        notify(&[state, NotifyState::Status(&self.summary())]);
    }

    /// Summary of the daemon's state in one line.
    fn summary(&self) -> String {
        let (ready, entries) = (self.catalog.ready(), self.catalog.len());
        let state = if self.jobs.closed() { "ending" } else { "serving" };
        let (running, queued) = (self.jobs.running(), self.jobs.queued());
        format!("{state}: {ready} of {entries} objects ready; requests: {running} computing, {queued} waiting\n")
    }

    /// Checks whether clients can connect, and repairs what it can.
    ///
    /// # Errors
    /// `runtime_folder`, `transport`, `shared_memory`, `busy`.
    fn check_client_entry(&mut self) -> Result<(), Error> {
        self.directory.check().and_then(|()| self.client_entry.check())?;
        shared_memory::need(shared_memory::CONNECTION_BYTES)?;
        self.ports.check_admission()
    }

    /// Replies to the operations port, if the connection still waits.
    fn report(&mut self, inquiry: DaemonInquiry) {
        let client_entry = self.check_client_entry();
        let metrics = self.metrics.text(&self.status());
        let mut summary = self.summary();
        if let Err(error) = &client_entry {
            summary += &format!("not ready: {error}\n");
        } else if self.client_entry.restored() > 0 {
            let times = text::counted(self.client_entry.restored(), "time");
            summary += &format!("files that clients need to connect were restored {times}\n");
        }
        let _ = inquiry.send(DaemonReport { ready: !self.jobs.closed() && client_entry.is_ok(), summary, metrics });
    }

    /// Ends in order: refuses new requests, lets accepted ones finish for a while (a second signal ends the wait), then refuses or
    /// cancels the rest.
    async fn end(mut self, mut event_source: EventSource) {
        self.jobs.close();
        tracing::info!(running = self.jobs.running(), queued = self.jobs.queued(), "ending");
        self.tell(NotifyState::Stopping);
        let (begun, drain) = (Instant::now(), self.config.drain());
        while self.jobs.running() + self.jobs.queued() > 0 && begun.elapsed() < drain {
            if self.turn(&mut event_source).await {
                break;
            }
        }
        self.directory.withdraw();
        for _ in 0..self.jobs.stop() {
            self.metrics.ended(JobEnd::Busy);
        }
        self.jobs.cancel();
        let canceled = Instant::now();
        while self.jobs.running() > 0 && canceled.elapsed() < GRACE {
            self.turn(&mut event_source).await;
        }
        let replied = Instant::now();
        while replied.elapsed() < FINAL_REPLIES_TIME {
            self.turn(&mut event_source).await;
        }
        self.write_metrics();
        let Self { jobs, worker_pool, ports, directory, .. } = self;
        // Drops all users of the transport; afterwards this process has no live node.
        drop((jobs, worker_pool, ports, event_source));
        if let Err(error) = directory.close() {
            tracing::warn!(%error, "cannot remove the files of this daemon");
        }
    }
}

fn send_rows<R: ReplyRow>(active: &ActiveControlRequest, rows: &[R], total: usize, refused: bool) -> Result<(), Error> {
    let mut payload = vec![AlignedBlock::zeroed(); control::blocks::<R>(rows.len()).max(1)];
    let header: ControlReplyHeader = control::write(&mut payload, rows, total, refused);
    let buffer = active.loan_slice_uninit(payload.len()).map_err(|error| failed("reply", error))?;
    let mut reply = buffer.write_from_slice(&payload);
    *reply.user_header_mut() = header;
    reply.send().map_err(|error| failed("reply", error))
}
