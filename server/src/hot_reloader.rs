//! Hot reload of the database folder on separate threads, so that requests wait neither for a scan of the folder, nor for a load, nor
//! for memory to be freed.
//!
//! Three threads, none of which waits for another: one scans the folder, one loads, one does the work that loading deferred. The load
//! thread has the priority of the worker threads: beside n of them it gets one part in n + 1 of the time.
//!
//! A file that is gone in a scan is served no more. A changed folder is reloaded once two consecutive scans are equal. A database that is renamed into the folder is loaded as a whole.
//! Many that arrive together make one reload. Of these, each object that is new is served as soon as it is loaded; the others are replaced
//! together.

mod debounce;

use crate::catalog::{Catalog, DirectorySnapshot, ObjectVersion};
use crate::jobs::{WorkerEvent, no_thread};
use debounce::Debounce;
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_engine::object::Loader;
use shatter_proto::name::suggestion;
use shatter_proto::{Error, ErrorKind};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Weak};
use std::time::Instant;
use tokio::sync::mpsc::UnboundedSender;

/// Niceness of background work. Requests and loads run at `compute.nice`, 5; beside them background work gets about a tenth.
const NICE: i32 = 15;

/// Event of the hot reloader.
pub enum ReloadEvent {
    /// A scan of the folder, begun at this time, ended.
    Seen(Instant, Result<DirectorySnapshot, Error>),
    /// A load of the databases of this snapshot, whose scan began at this time, began.
    Begun(Instant, DirectorySnapshot),
    /// One of these databases is loaded.
    Advanced(Arc<ObjectVersion>),
    /// A load ended.
    Loaded(Result<Catalog, Error>),
    /// The deferred work of one object ended.
    Finished,
}

/// Hot reloader of a folder. Owned by the event-loop thread, which it never blocks.
pub struct HotReloader {
    folder: DatabaseFolder,
    loader: Loader,
    scanner: Worker,
    load_worker: Worker,
    finish_worker: Worker,
    /// Whether a reload was requested during another one.
    is_reload_requested: bool,
    /// Latest snapshot of the folder, and when its scan began.
    seen: Option<(Instant, DirectorySnapshot)>,
    /// Snapshot whose databases are being loaded.
    target: Option<DirectorySnapshot>,
    /// Objects with deferred work.
    unfinished: VecDeque<Weak<ObjectVersion>>,
    debounce: Debounce,
    /// Number of scans that began.
    scans_begun: u64,
    /// Whether the current or next scan was started by the timer; only such scans show whether the folder is stable.
    is_periodic: bool,
    /// Whether a client asked during a scan, which may have begun before a change; another scan follows.
    is_rescan_requested: bool,
    /// Whether the folder could not be scanned, and the error was logged.
    is_scan_failing: bool,
    /// Number of reloads that are over.
    reloads: u64,
}

/// Thread that does one task at a time and sends the result as an event.
struct Worker {
    thread: ThreadPool,
    events: UnboundedSender<WorkerEvent>,
    is_busy: bool,
}

impl Worker {
    fn new(name: &'static str, nice: i32, events: UnboundedSender<WorkerEvent>) -> Result<Self, Error> {
        let builder = ThreadPoolBuilder::new().num_threads(1).thread_name(move |_| name.to_owned());
        let builder = builder.start_handler(move |_| {
            // On Linux niceness is per thread. If it cannot be raised, the thread runs at the priority of others.
            if let Err(error) = rustix::process::nice(nice) {
                tracing::debug!(%error, name, "cannot lower the priority of a thread");
            }
        });
        let thread = builder.build().map_err(|error| no_thread(&error))?;
        Ok(Self { thread, events, is_busy: false })
    }

    fn work(&mut self, work: impl FnOnce(&(dyn Fn(ReloadEvent) + Sync)) -> ReloadEvent + Send + 'static) {
        self.is_busy = true;
        let events = self.events.clone();
        self.thread.spawn(move || {
            // If the receiver is gone, the daemon has ended.
            let send = |event| drop(events.send(WorkerEvent::Reload(event)));
            send(work(&send));
        });
    }
}

/// Database folder.
#[derive(Clone)]
pub struct DatabaseFolder {
    /// Path of the folder.
    pub path: PathBuf,
    /// Whether it must exist: a configured folder must, the platform's default may not exist yet.
    pub required: bool,
    /// Objects of the scene and the names of their databases; `None`: all databases are served.
    pub only: Option<BTreeMap<String, String>>,
}

impl DatabaseFolder {
    /// Scans the folder.
    ///
    /// # Errors
    /// `database_folder`.
    pub fn scan(&self) -> Result<DirectorySnapshot, Error> {
        if !self.required && !self.path.exists() {
            return Ok(DirectorySnapshot::default());
        }
        let snapshot = DirectorySnapshot::of(&self.path)?;
        Ok(match &self.only {
            Some(objects) => snapshot.only(objects),
            None => snapshot,
        })
    }

    /// Checks that all databases of the scene exist.
    ///
    /// # Errors
    /// `unknown_object`, `database_folder`.
    pub fn complete(&self) -> Result<(), Error> {
        let snapshot = self.scan()?;
        let mut wanted = self.only.iter().flat_map(BTreeMap::values);
        match wanted.find(|name| !snapshot.holds(name)) {
            Some(name) => {
                let folder = self.path.display();
                let all = DirectorySnapshot::of(&self.path).map(|snapshot| snapshot.names()).unwrap_or_default();
                let all: Vec<&str> = all.iter().map(String::as_str).collect();
                let message = format!(
                    "the scene needs `{name}`, but {folder}/{name}.shatter is missing; bake it by `shatterd bake --scene FILE` if it has \
                     a `shape`, else by `shatterd bake MESH --name {name}`; {}",
                    suggestion(name, &all)
                );
                Err(Error::new(ErrorKind::UnknownObject, name.clone(), message))
            }
            None => Ok(()),
        }
    }
}

impl HotReloader {
    /// Creates a reloader that sends to `events` and loads at niceness `nice`.
    ///
    /// # Errors
    /// `failed` if a thread cannot be started.
    pub fn new(
        folder: DatabaseFolder,
        loader: Loader,
        nice: i32,
        events: UnboundedSender<WorkerEvent>,
    ) -> Result<Self, Error> {
        let scanner = Worker::new("look", nice, events.clone())?;
        let load_worker = Worker::new("load", nice, events.clone())?;
        let finish_worker = Worker::new("finish", NICE, events)?;
        let (unfinished, debounce) = (VecDeque::new(), Debounce::default());
        let (is_reload_requested, is_scan_failing, seen, target) = (false, false, None, None);
        let (scans_begun, reloads, is_periodic, is_rescan_requested) = (0, 0, false, false);
        Ok(Self {
            folder,
            loader,
            scanner,
            load_worker,
            finish_worker,
            is_reload_requested,
            seen,
            target,
            unfinished,
            debounce,
            scans_begun,
            is_periodic,
            is_rescan_requested,
            is_scan_failing,
            reloads,
        })
    }

    /// Starts a scan unless one is under way; its result arrives as an event. Called by the timer.
    pub fn scan(&mut self) {
        self.is_periodic = true;
        if !self.scanner.is_busy {
            self.begin_scan();
        }
    }

    /// Starts a scan of the current folder. Returns its number: it is over once [`Self::scans_done`] has reached it.
    pub fn scan_for_client(&mut self) -> u64 {
        if self.scanner.is_busy {
            self.is_rescan_requested = true;
            return self.scans_begun + 1;
        }
        self.begin_scan();
        self.scans_begun
    }

    /// Number of scans that are over.
    pub fn scans_done(&self) -> u64 {
        self.scans_begun - u64::from(self.scanner.is_busy)
    }

    fn begin_scan(&mut self) {
        self.scans_begun += 1;
        let folder = self.folder.clone();
        self.scanner.work(move |_| ReloadEvent::Seen(Instant::now(), folder.scan()));
    }

    /// Number of reloads that are over.
    pub fn reloads(&self) -> u64 {
        self.reloads
    }

    /// Reloads the databases: now, or when the current reload is over.
    pub fn reload(&mut self, catalog: &Arc<Catalog>) {
        if self.load_worker.is_busy {
            self.is_reload_requested = true;
            return;
        }
        self.is_reload_requested = false;
        let (folder, loader, catalog) = (self.folder.clone(), self.loader.clone(), catalog.clone());
        self.load_worker.work(move |send| {
            let begun = Instant::now();
            ReloadEvent::Loaded(folder.scan().map(|snapshot| {
                send(ReloadEvent::Begun(begun, snapshot.clone()));
                catalog.renewed(snapshot, &loader, |version| send(ReloadEvent::Advanced(version.clone())))
            }))
        });
    }

    /// Does the deferred work of the objects of `catalog`, one after the other.
    pub fn finish(&mut self, catalog: &Catalog) {
        self.unfinished = catalog.versions().map(Arc::downgrade).collect();
        self.finish_next_object();
    }

    fn finish_next_object(&mut self) {
        while !self.finish_worker.is_busy
            && let Some(version) = self.unfinished.pop_front()
        {
            if let Some(version) = version.upgrade() {
                self.finish_worker.work(move |_| {
                    version.finish();
                    ReloadEvent::Finished
                });
            }
        }
    }

    /// Handles an event of its threads; returns the catalog that replaces `catalog`, if there is one.
    pub fn handle(&mut self, event: ReloadEvent, catalog: &Arc<Catalog>) -> Option<Arc<Catalog>> {
        let mut fresh = None;
        match event {
            ReloadEvent::Seen(begun, seen) => {
                self.scanner.is_busy = false;
                self.scan_finished(begun, seen, catalog);
                if std::mem::take(&mut self.is_rescan_requested) {
                    self.begin_scan();
                }
            }
            ReloadEvent::Begun(begun, snapshot) => {
                self.note_seen(begun, snapshot.clone());
                self.target = Some(snapshot);
            }
            ReloadEvent::Advanced(version) => {
                fresh = self.target.as_ref().and_then(|target| catalog.advanced(&version, target)).map(Arc::new);
            }
            ReloadEvent::Loaded(loaded) => {
                (self.load_worker.is_busy, self.target) = (false, None);
                match loaded {
                    Ok(loaded) => {
                        self.reloads += 1;
                        let (ready, entries, bytes) = (loaded.ready(), loaded.len(), loaded.memory_bytes());
                        tracing::info!(ready, entries, bytes, "databases reloaded");
                        self.finish(&loaded);
                        fresh = Some(Arc::new(loaded));
                    }
                    Err(error) => tracing::error!(%error, "cannot reload the databases; the old ones stay served"),
                }
            }
            ReloadEvent::Finished => {
                self.finish_worker.is_busy = false;
                self.finish_next_object();
            }
        }
        // A load that goes on, or that has just ended, knows nothing of files that were removed meanwhile.
        let current = fresh.as_ref().unwrap_or(catalog);
        let kept = self.seen.as_ref().and_then(|(_, seen)| current.without_removed(seen));
        fresh = kept.map(Arc::new).or(fresh);
        if self.is_reload_requested && !self.load_worker.is_busy {
            self.reload(fresh.as_ref().unwrap_or(catalog));
        }
        fresh
    }

    /// Remembers a snapshot, unless the scan of another began later.
    fn note_seen(&mut self, begun: Instant, snapshot: DirectorySnapshot) {
        if self.seen.as_ref().is_none_or(|(last, _)| *last <= begun) {
            self.seen = Some((begun, snapshot));
        }
    }

    fn scan_finished(&mut self, begun: Instant, seen: Result<DirectorySnapshot, Error>, catalog: &Catalog) {
        let is_periodic = std::mem::take(&mut self.is_periodic);
        match seen {
            Ok(snapshot) => {
                self.is_scan_failing = false;
                let served = self.target.as_ref().unwrap_or(catalog.snapshot());
                self.is_reload_requested |= is_periodic && self.debounce.settled(snapshot.clone(), served);
                self.note_seen(begun, snapshot);
            }
            Err(error) => {
                if !std::mem::replace(&mut self.is_scan_failing, true) {
                    tracing::error!(%error, "cannot scan the database folder; the old databases stay served");
                }
            }
        }
    }

    /// `catalog` plus the databases that were found and are not loaded yet; `None` if it lists them already.
    pub fn expected(&self, catalog: &Catalog) -> Option<Arc<Catalog>> {
        self.seen.as_ref().and_then(|(_, seen)| catalog.expecting(seen)).map(Arc::new)
    }

    /// Drops a replaced catalog on a background thread: freeing the memory of large objects takes milliseconds.
    pub fn release(&self, old: Arc<Catalog>) {
        self.finish_worker.thread.spawn(move || drop(old));
    }
}

#[cfg(test)]
mod tests;
