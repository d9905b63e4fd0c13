//! Looks after the folder of databases while the daemon serves, on threads of its own, so that strikes wait neither for a look at
//! the folder, nor for a database that is loaded, nor for memory that is given back.
//!
//! Three threads, so that none of these waits for another: one looks at the folder, one loads, one finishes what loading left for
//! later. A load has one thread at the priority of the computing threads: beside n of them it gets one part in n + 1 of the time.
//!
//! A changed folder is read again once it has come to rest: once it looks the same twice in a row. A database that is renamed
//! into place is taken whole, and many that come together are one reload.

mod debounce;

use crate::catalog::{Catalog, DirectorySnapshot, ObjectVersion};
use crate::jobs::WorkerEvent;
use debounce::Debounce;
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_engine::object::Loader;
use shatter_proto::name::suggestion;
use shatter_proto::{Error, ErrorKind};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Weak};
use tokio::sync::mpsc::UnboundedSender;

/// Niceness of what nobody waits for. Strikes and loads are at `compute.nice`, 5: beside them it gets about a tenth.
const NICE: i32 = 15;

/// What the librarian found or did.
pub enum ReloadEvent {
    /// The folder, looked at.
    Seen(Result<DirectorySnapshot, Error>),
    /// The databases of the folder as it lies there are being read again.
    Begun(DirectorySnapshot),
    /// The databases, read again.
    Loaded(Result<Catalog, Error>),
    /// One more object has all that strikes may need.
    Finished,
}

/// Looks after a folder. Owned by the waiting thread, which it never blocks.
pub struct HotReloader {
    folder: DatabaseFolder,
    loader: Loader,
    looks: Worker,
    loads: Worker,
    finishes: Worker,
    /// A reload was asked for while another went on.
    asked: bool,
    /// The folder as it was found last.
    seen: Option<DirectorySnapshot>,
    /// The folder whose databases are being loaded.
    target: Option<DirectorySnapshot>,
    /// Objects with work that loading left for later, done between other things.
    unfinished: VecDeque<Weak<ObjectVersion>>,
    unrest: Debounce,
    /// Looks that began.
    looks_begun: u64,
    /// Whether the look under way, or the next one, was due by the clock: only such tell whether the folder rests.
    is_periodic: bool,
    /// A client asked during a look, which may have begun before something changed: another one follows.
    again: bool,
    /// The folder could not be looked at, which was said.
    blind: bool,
}

/// A thread that does one thing at a time and reports what came of it.
struct Worker {
    thread: ThreadPool,
    events: UnboundedSender<WorkerEvent>,
    is_busy: bool,
}

impl Worker {
    fn new(name: &'static str, nice: i32, events: UnboundedSender<WorkerEvent>) -> Result<Self, Error> {
        let builder = ThreadPoolBuilder::new().num_threads(1).thread_name(move |_| name.to_owned());
        let builder = builder.start_handler(move |_| {
            // On Linux this concerns the calling thread alone. Refused, the thread is as urgent as others.
            if let Err(error) = rustix::process::nice(nice) {
                tracing::debug!(%error, name, "the priority of a thread stays");
            }
        });
        let thread = builder.build().map_err(|error| Error::new(ErrorKind::Failed, "threads", error.to_string()))?;
        Ok(Self { thread, events, is_busy: false })
    }

    fn work(&mut self, work: impl FnOnce(&dyn Fn(ReloadEvent)) -> ReloadEvent + Send + 'static) {
        self.is_busy = true;
        let events = self.events.clone();
        self.thread.spawn(move || {
            // A waiting thread that is gone has ended the daemon: nobody to tell.
            let tell = |news| drop(events.send(WorkerEvent::News(news)));
            tell(work(&tell));
        });
    }
}

/// The folder of databases.
#[derive(Clone)]
pub struct DatabaseFolder {
    /// Where.
    pub path: PathBuf,
    /// Whether it must exist: one that was asked for must, the platform's own may not be there yet.
    pub required: bool,
    /// The only objects, and the names of the databases that they are made of, if not all count.
    pub only: Option<BTreeMap<String, String>>,
}

impl DatabaseFolder {
    /// Looks at it.
    ///
    /// # Errors
    /// `database_folder`.
    pub fn look(&self) -> Result<DirectorySnapshot, Error> {
        if !self.required && !self.path.exists() {
            return Ok(DirectorySnapshot::default());
        }
        let shelf = DirectorySnapshot::of(&self.path)?;
        Ok(match &self.only {
            Some(objects) => shelf.only(objects),
            None => shelf,
        })
    }

    /// Refuses to begin without one of those that are wanted.
    ///
    /// # Errors
    /// `unknown_object`, `database_folder`.
    pub fn complete(&self) -> Result<(), Error> {
        let shelf = self.look()?;
        let mut wanted = self.only.iter().flat_map(BTreeMap::values);
        match wanted.find(|name| !shelf.holds(name)) {
            Some(name) => {
                let folder = self.path.display();
                let all = DirectorySnapshot::of(&self.path).map(|shelf| shelf.names()).unwrap_or_default();
                let all: Vec<&str> = all.iter().map(String::as_str).collect();
                let message = format!(
                    "the scene wants `{name}`, but there is no {folder}/{name}.shatter: bake it (--scene, if it has a `shape`); {}",
                    suggestion(name, &all)
                );
                Err(Error::new(ErrorKind::UnknownObject, name.clone(), message))
            }
            None => Ok(()),
        }
    }
}

impl HotReloader {
    /// One that tells `events`, and loads at niceness `nice`.
    ///
    /// # Errors
    /// `failed` if a thread cannot be started.
    pub fn new(
        folder: DatabaseFolder,
        loader: Loader,
        nice: i32,
        events: UnboundedSender<WorkerEvent>,
    ) -> Result<Self, Error> {
        let looks = Worker::new("look", nice, events.clone())?;
        let loads = Worker::new("load", nice, events.clone())?;
        let finishes = Worker::new("finish", NICE, events)?;
        let (unfinished, unrest) = (VecDeque::new(), Debounce::default());
        let (asked, blind, seen, target) = (false, false, None, None);
        let (looks_begun, is_periodic, again) = (0, false, false);
        Ok(Self {
            folder,
            loader,
            looks,
            loads,
            finishes,
            asked,
            seen,
            target,
            unfinished,
            unrest,
            looks_begun,
            is_periodic,
            again,
            blind,
        })
    }

    /// Looks at the folder, unless it does already; what it found comes as news. Called by the clock.
    pub fn look(&mut self) {
        self.is_periodic = true;
        if !self.looks.is_busy {
            self.begin_look();
        }
    }

    /// Looks at the folder as it is now. Returns the number of that look: it is over once [`Self::looks_done`] has reached it.
    pub fn look_for_client(&mut self) -> u64 {
        if self.looks.is_busy {
            self.again = true;
            return self.looks_begun + 1;
        }
        self.begin_look();
        self.looks_begun
    }

    /// Looks that are over.
    pub fn looks_done(&self) -> u64 {
        self.looks_begun - u64::from(self.looks.is_busy)
    }

    fn begin_look(&mut self) {
        self.looks_begun += 1;
        let folder = self.folder.clone();
        self.looks.work(move |_| ReloadEvent::Seen(folder.look()));
    }

    /// Reads the databases again: now, or as soon as another reload is over.
    pub fn reload(&mut self, catalog: &Arc<Catalog>) {
        if self.loads.is_busy {
            self.asked = true;
            return;
        }
        self.asked = false;
        let (folder, loader, catalog) = (self.folder.clone(), self.loader.clone(), catalog.clone());
        self.loads.work(move |tell| {
            ReloadEvent::Loaded(folder.look().map(|shelf| {
                tell(ReloadEvent::Begun(shelf.clone()));
                catalog.renewed(shelf, &loader)
            }))
        });
    }

    /// Finishes the objects of `catalog`, one after the other.
    pub fn finish(&mut self, catalog: &Catalog) {
        self.unfinished = catalog.versions().map(Arc::downgrade).collect();
        self.finish_next();
    }

    fn finish_next(&mut self) {
        while !self.finishes.is_busy
            && let Some(version) = self.unfinished.pop_front()
        {
            if let Some(version) = version.upgrade() {
                self.finishes.work(move |_| {
                    version.finish();
                    ReloadEvent::Finished
                });
            }
        }
    }

    /// Takes note of its own news; the catalog that is to take the place of `catalog`, if there is one.
    pub fn handle(&mut self, news: ReloadEvent, catalog: &Arc<Catalog>) -> Option<Arc<Catalog>> {
        let mut fresh = None;
        match news {
            ReloadEvent::Seen(seen) => {
                self.looks.is_busy = false;
                self.saw(seen, catalog);
                if std::mem::take(&mut self.again) {
                    self.begin_look();
                }
            }
            ReloadEvent::Begun(shelf) => {
                self.seen = Some(shelf.clone());
                self.target = Some(shelf);
            }
            ReloadEvent::Loaded(loaded) => {
                (self.loads.is_busy, self.target) = (false, None);
                match loaded {
                    Ok(loaded) => {
                        self.finish(&loaded);
                        fresh = Some(Arc::new(loaded));
                    }
                    Err(refusal) => tracing::error!(%refusal, "the databases stay as they were"),
                }
            }
            ReloadEvent::Finished => {
                self.finishes.is_busy = false;
                self.finish_next();
            }
        }
        if self.asked && !self.loads.is_busy {
            self.reload(fresh.as_ref().unwrap_or(catalog));
        }
        fresh
    }

    fn saw(&mut self, seen: Result<DirectorySnapshot, Error>, catalog: &Catalog) {
        let is_periodic = std::mem::take(&mut self.is_periodic);
        match seen {
            Ok(shelf) => {
                self.blind = false;
                let served = self.target.as_ref().unwrap_or(catalog.shelf());
                self.asked |= is_periodic && self.unrest.settled(shelf.clone(), served);
                self.seen = Some(shelf);
            }
            Err(refusal) => {
                if !std::mem::replace(&mut self.blind, true) {
                    tracing::error!(%refusal, "the databases stay as they were");
                }
            }
        }
    }

    /// `catalog` with the databases listed that were found and are not loaded yet; `None` if it lists them already.
    pub fn expected(&self, catalog: &Catalog) -> Option<Arc<Catalog>> {
        self.seen.as_ref().and_then(|seen| catalog.expecting(seen)).map(Arc::new)
    }

    /// Lets go of a catalog that was replaced. Giving back the memory of large objects takes milliseconds.
    pub fn release(&self, old: Arc<Catalog>) {
        self.finishes.thread.spawn(move || drop(old));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use shatter_engine::object::{EngineResult, ServedObject};
    use shatter_fracture::cancel_token::CancelToken;
    use shatter_fracture::pipeline::{StageObserver, Workspace};
    use shatter_proto::control::ObjectRow;
    use shatter_proto::request::Request;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};
    use tempfile::TempDir;
    use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

    const PATIENCE: Duration = Duration::from_secs(60);

    /// A librarian of a folder of its own, and what it tells.
    fn start(folder: &TempDir, required: bool) -> (HotReloader, UnboundedReceiver<WorkerEvent>) {
        let (sender, events) = unbounded_channel();
        let loader: Loader = Arc::new(|_, _| Err("nothing is ever loaded here".to_owned()));
        let path = folder.path().join("databases");
        (HotReloader::new(DatabaseFolder { path, required, only: None }, loader, NICE, sender).unwrap(), events)
    }

    /// An object that must be finished, which waits until the gate is open, and panics if it is named so.
    struct Raw(String, Arc<Mutex<Vec<String>>>, Arc<AtomicBool>);

    impl ServedObject for Raw {
        fn row(&self) -> ObjectRow {
            let mut row = ObjectRow::zeroed();
            row.set_name(&self.0);
            row
        }

        fn bytes(&self) -> usize {
            1
        }

        fn finish(&self) -> Result<(), Error> {
            self.1.lock().unwrap().push(self.0.clone());
            let begun = Instant::now();
            while !self.2.load(Ordering::Relaxed) && begun.elapsed() < PATIENCE {
                std::thread::yield_now();
            }
            assert!(self.0 != "b", "cannot be finished");
            Ok(())
        }

        fn answer_bytes_max(&self) -> usize {
            1
        }

        fn strike(
            &self,
            _: &Request,
            _: &mut Workspace,
            _: &CancelToken,
            _: &dyn StageObserver,
        ) -> Result<Box<dyn EngineResult>, Error> {
            Err(Error::new(ErrorKind::Failed, "", "not struck here"))
        }
    }

    #[test]
    fn objects_are_finished_one_by_one_and_no_reload_waits_for_that() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, true);
        let databases = folder.path().join("databases");
        std::fs::create_dir(&databases).unwrap();
        let write = |name: &str| std::fs::write(databases.join(name).with_extension("shatter"), "").unwrap();
        ["a", "b"].iter().for_each(|name| write(name));
        let (finished, gate) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicBool::new(false)));
        let (told, opened) = (finished.clone(), gate.clone());
        librarian.loader = Arc::new(move |path, _| {
            Ok(Arc::new(Raw(path.file_stem().unwrap().display().to_string(), told.clone(), opened.clone())))
        });
        let mut catalog =
            Arc::new(Catalog::default().renewed(DirectorySnapshot::of(&databases).unwrap(), &librarian.loader));
        librarian.finish(&catalog);
        let begun = Instant::now();
        while finished.lock().unwrap().is_empty() && begun.elapsed() < PATIENCE {
            std::thread::yield_now();
        }
        write("c");
        librarian.reload(&catalog);
        let begun = news(&mut events);
        assert!(matches!(begun, ReloadEvent::Begun(_)) && librarian.handle(begun, &catalog).is_none());
        let listed = librarian.expected(&catalog).unwrap();
        assert_eq!(
            (listed.loading(), listed.failed(), listed.get("c").err().unwrap().kind),
            (1, 0, ErrorKind::Loading)
        );
        assert!(librarian.expected(&listed).is_none() && listed.get("a").is_ok());
        let loaded = news(&mut events);
        assert!(
            matches!(loaded, ReloadEvent::Loaded(_)) && *finished.lock().unwrap() == ["a"],
            "it waits for no finish"
        );
        catalog = librarian.handle(loaded, &listed).unwrap();
        assert_eq!((catalog.loading(), catalog.ready()), (0, 3));
        gate.store(true, Ordering::Relaxed);
        for _ in 0..4 {
            let more = news(&mut events);
            assert!(matches!(more, ReloadEvent::Finished) && librarian.handle(more, &catalog).is_none());
        }
        assert_eq!(*finished.lock().unwrap(), ["a", "a", "b", "c"], "one that panics stops nobody");
        assert!(!librarian.finishes.is_busy && librarian.expected(&catalog).is_none());
    }

    fn news(events: &mut UnboundedReceiver<WorkerEvent>) -> ReloadEvent {
        let begun = Instant::now();
        loop {
            match events.try_recv() {
                Ok(WorkerEvent::News(news)) => return news,
                _ => assert!(begun.elapsed() < PATIENCE, "no news"),
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_look_for_a_client_sees_what_is_there_now_and_says_nothing_of_rest() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, true);
        let databases = folder.path().join("databases");
        std::fs::create_dir(&databases).unwrap();
        let catalog = Arc::new(Catalog::default());
        assert_eq!(
            (librarian.look_for_client(), librarian.look_for_client()),
            (1, 2),
            "the first may have begun too early"
        );
        std::fs::write(databases.join("a.shatter"), "").unwrap();
        for done in [1, 2] {
            assert_eq!(librarian.looks_done(), done - 1);
            let seen = news(&mut events);
            assert!(matches!(seen, ReloadEvent::Seen(Ok(_))) && librarian.handle(seen, &catalog).is_none());
        }
        let listed = librarian.expected(&catalog).unwrap();
        assert_eq!((librarian.looks_done(), listed.get("a").err().unwrap().kind), (2, ErrorKind::Loading));
        assert!(!librarian.loads.is_busy && !librarian.asked, "twice the same, a moment apart, is no rest");
        for _ in 0..2 {
            librarian.look();
            let seen = news(&mut events);
            assert!(librarian.handle(seen, &listed).is_none());
        }
        assert!(librarian.loads.is_busy);
    }

    #[test]
    fn a_reload_asked_for_during_another_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, false);
        let catalog = Arc::new(Catalog::default());
        librarian.reload(&catalog);
        let loaded = |librarian: &mut HotReloader, events: &mut UnboundedReceiver<WorkerEvent>| {
            let begun = news(events);
            assert!(matches!(begun, ReloadEvent::Begun(_)) && librarian.handle(begun, &catalog).is_none());
            news(events)
        };
        let first = loaded(&mut librarian, &mut events);
        // The folder changes after it was read, and before the first reload is over.
        std::fs::create_dir(folder.path().join("databases")).unwrap();
        std::fs::write(folder.path().join("databases/a.shatter"), "").unwrap();
        librarian.reload(&catalog);
        let first = librarian.handle(first, &catalog).unwrap();
        assert_eq!(first.len(), 0);
        let second = loaded(&mut librarian, &mut events);
        assert_eq!(librarian.handle(second, &first).unwrap().len(), 1);
    }

    #[test]
    fn a_folder_that_must_exist_and_does_not_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, true);
        let catalog = Arc::new(Catalog::default());
        librarian.look();
        librarian.look();
        let seen = news(&mut events);
        assert!(matches!(seen, ReloadEvent::Seen(Err(_))) && librarian.handle(seen, &catalog).is_none());
        librarian.reload(&catalog);
        let loaded = news(&mut events);
        assert!(matches!(loaded, ReloadEvent::Loaded(Err(_))) && librarian.handle(loaded, &catalog).is_none());
        assert!(events.try_recv().is_err(), "the second look found it busy");
    }
}
