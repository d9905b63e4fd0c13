//! Looks after the folder of databases while the daemon serves: a thread of its own, at lower priority, so that strikes wait
//! neither for a look at the folder, nor for a database that is loaded, nor for memory that is given back.
//!
//! A changed folder is read again once it has come to rest: once it looks the same twice in a row. A database that is renamed
//! into place is taken whole, and many that come together are one reload.

use crate::catalog::{Catalog, Shelf, Version};
use crate::engine::Loader;
use crate::jobs::Event;
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_proto::{Kind, Refusal};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Weak};
use tokio::sync::mpsc::UnboundedSender;

/// How much less urgent it is than the thread that waits; strikes are at `compute.nice`, 5: beside them it gets about a tenth.
const NICE: i32 = 15;

/// A folder that does not come to rest is read again after this many looks all the same.
const RESTLESS_MAX: u32 = 10;

/// What the librarian found or did.
pub enum News {
    /// The folder, looked at.
    Seen(Result<Shelf, Refusal>),
    /// The databases, read again.
    Loaded(Result<Catalog, Refusal>),
    /// One more object has all that strikes may need.
    Finished,
}

/// Looks after a folder. Owned by the waiting thread, which it never blocks.
pub struct Librarian {
    folder: Folder,
    loader: Loader,
    thread: ThreadPool,
    events: UnboundedSender<Event>,
    busy: bool,
    /// A reload was asked for while it was busy.
    asked: bool,
    /// Objects with work that loading left for later, done between other things.
    unfinished: VecDeque<Weak<Version>>,
    unrest: Unrest,
    /// The folder could not be looked at, which was said.
    blind: bool,
}

/// The folder of databases.
#[derive(Clone)]
pub struct Folder {
    /// Where.
    pub path: PathBuf,
    /// Whether it must exist: one that was asked for must, the platform's own may not be there yet.
    pub required: bool,
    /// The only objects, and the names of the databases that they are made of, if not all count.
    pub only: Option<BTreeMap<String, String>>,
}

impl Folder {
    /// Looks at it. Errors: `database_folder`.
    pub fn look(&self) -> Result<Shelf, Refusal> {
        if !self.required && !self.path.exists() {
            return Ok(Shelf::default());
        }
        let shelf = Shelf::of(&self.path)?;
        Ok(match &self.only {
            Some(objects) => shelf.only(objects),
            None => shelf,
        })
    }

    /// Refuses to begin without one of those that are wanted. Errors: `unknown_object`, `database_folder`.
    pub fn complete(&self) -> Result<(), Refusal> {
        let shelf = self.look()?;
        let mut wanted = self.only.iter().flat_map(BTreeMap::values);
        match wanted.find(|name| !shelf.holds(name)) {
            Some(name) => {
                let folder = self.path.display();
                let message = format!(
                    "the scene wants `{name}`, but there is no {folder}/{name}.shatter: bake it (--scene, if it has a `shape`)"
                );
                Err(Refusal::new(Kind::UnknownObject, name.clone(), message))
            }
            None => Ok(()),
        }
    }
}

impl Librarian {
    /// One that tells `events`.
    pub fn new(folder: Folder, loader: Loader, events: UnboundedSender<Event>) -> Result<Self, Refusal> {
        let builder = ThreadPoolBuilder::new().num_threads(1).thread_name(|_| "librarian".to_owned());
        let builder = builder.start_handler(|_| {
            // On Linux this concerns the calling thread alone. Refused, the thread is as urgent as others.
            if let Err(error) = rustix::process::nice(NICE) {
                tracing::debug!(%error, "the librarian's priority stays");
            }
        });
        let thread = builder.build().map_err(|error| Refusal::new(Kind::Failed, "threads", error.to_string()))?;
        let (unrest, [busy, asked, blind]) = (Unrest::default(), [false; 3]);
        let unfinished = VecDeque::new();
        Ok(Self { folder, loader, thread, events, busy, asked, unfinished, unrest, blind })
    }

    /// Looks at the folder, unless it is busy; what it found comes as news.
    pub fn look(&mut self) {
        if !self.busy {
            let folder = self.folder.clone();
            self.work(move || News::Seen(folder.look()));
        }
    }

    /// Reads the databases again: now, or as soon as what it is busy with is done.
    pub fn reload(&mut self, catalog: &Arc<Catalog>) {
        if self.busy {
            self.asked = true;
            return;
        }
        self.asked = false;
        let (folder, loader, catalog) = (self.folder.clone(), self.loader.clone(), catalog.clone());
        self.work(move || News::Loaded(folder.look().map(|shelf| catalog.renewed(shelf, &loader))));
    }

    /// Finishes the objects of `catalog`, one after the other.
    pub fn finish(&mut self, catalog: &Catalog) {
        self.unfinished = catalog.versions().map(Arc::downgrade).collect();
        if !self.busy {
            self.go_on();
        }
    }

    fn go_on(&mut self) {
        while let Some(version) = self.unfinished.pop_front() {
            if let Some(version) = version.upgrade() {
                return self.work(move || {
                    version.finish();
                    News::Finished
                });
            }
        }
    }

    /// Takes note of its own news; the catalog that is to take the place of `catalog`, if there is one.
    pub fn hear(&mut self, news: News, catalog: &Arc<Catalog>) -> Option<Arc<Catalog>> {
        self.busy = false;
        let fresh = match news {
            News::Seen(Ok(shelf)) => {
                self.blind = false;
                self.asked |= self.unrest.settled(shelf, catalog.shelf());
                None
            }
            News::Loaded(Ok(fresh)) => {
                self.unfinished = fresh.versions().map(Arc::downgrade).collect();
                Some(Arc::new(fresh))
            }
            News::Finished => None,
            News::Loaded(Err(refusal)) => {
                tracing::error!(%refusal, "the databases stay as they were");
                None
            }
            News::Seen(Err(refusal)) => {
                if !std::mem::replace(&mut self.blind, true) {
                    tracing::error!(%refusal, "the databases stay as they were");
                }
                None
            }
        };
        if self.asked {
            self.reload(fresh.as_ref().unwrap_or(catalog));
        } else {
            self.go_on();
        }
        fresh
    }

    /// Lets go of a catalog that was replaced. Giving back the memory of large objects takes milliseconds.
    pub fn release(&self, old: Arc<Catalog>) {
        self.thread.spawn(move || drop(old));
    }

    fn work(&mut self, work: impl FnOnce() -> News + Send + 'static) {
        self.busy = true;
        let events = self.events.clone();
        self.thread.spawn(move || {
            // A waiting thread that is gone has ended the daemon: nobody to tell.
            let _ = events.send(Event::News(work()));
        });
    }
}

/// Whether a folder that differs from what is served has come to rest.
#[derive(Default)]
struct Unrest {
    last: Option<Shelf>,
    looks: u32,
}

impl Unrest {
    /// Whether it is time to read a folder that looks like `seen` while `served` is served.
    fn settled(&mut self, seen: Shelf, served: &Shelf) -> bool {
        if seen == *served {
            *self = Self::default();
            return false;
        }
        self.looks += 1;
        if self.last.as_ref() == Some(&seen) || self.looks >= RESTLESS_MAX {
            *self = Self::default();
            return true;
        }
        self.last = Some(seen);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Object, Outcome};
    use bytemuck::Zeroable;
    use shatter_fracture::pipeline::{Watch, Workspace};
    use shatter_fracture::token::Token;
    use shatter_proto::control::ObjectRow;
    use shatter_proto::request::Strike;
    use std::sync::Mutex;
    use std::time::{Duration, Instant};
    use tempfile::TempDir;
    use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

    fn shelf(folder: &TempDir, text: &str) -> Shelf {
        std::fs::write(folder.path().join("a.shatter"), text).unwrap();
        Shelf::of(folder.path()).unwrap()
    }

    #[test]
    fn a_folder_is_read_when_it_rests_and_in_any_case_at_last() {
        let folder = tempfile::tempdir().unwrap();
        let [served, one, two] = ["", "1", "22"].map(|text| shelf(&folder, text));
        let mut unrest = Unrest::default();
        let mut look = |seen: &Shelf| unrest.settled(seen.clone(), &served);
        assert!(!look(&served) && !look(&one) && !look(&two) && look(&two), "twice the same");
        assert!(!look(&one) && !look(&served) && !look(&one), "what was undone is forgotten");
        let restless: Vec<bool> = (0..RESTLESS_MAX).map(|turn| look(if turn % 2 == 0 { &two } else { &one })).collect();
        assert_eq!(restless.iter().filter(|read| **read).count(), 1, "{restless:?}");
    }

    /// A librarian of a folder of its own, and what it tells.
    fn start(folder: &TempDir, required: bool) -> (Librarian, UnboundedReceiver<Event>) {
        let (sender, events) = unbounded_channel();
        let loader: Loader = Arc::new(|_, _| Err("nothing is ever loaded here".to_owned()));
        let path = folder.path().join("databases");
        (Librarian::new(Folder { path, required, only: None }, loader, sender).unwrap(), events)
    }

    /// An object that must be finished, and falls over it if it is named so.
    struct Raw(String, Arc<Mutex<Vec<String>>>);

    impl Object for Raw {
        fn row(&self) -> ObjectRow {
            let mut row = ObjectRow::zeroed();
            row.set_name(&self.0);
            row
        }

        fn bytes(&self) -> usize {
            1
        }

        fn finish(&self) -> Result<(), Refusal> {
            self.1.lock().unwrap().push(self.0.clone());
            assert!(self.0 != "b", "cannot be finished");
            Ok(())
        }

        fn answer_bytes_max(&self) -> usize {
            1
        }

        fn strike(
            &self,
            _: &Strike,
            _: &mut Workspace,
            _: &Token,
            _: &mut dyn Watch,
        ) -> Result<Box<dyn Outcome>, Refusal> {
            Err(Refusal::new(Kind::Failed, "", "not struck here"))
        }
    }

    #[test]
    fn objects_are_finished_one_by_one_and_a_reload_goes_first() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, true);
        let databases = folder.path().join("databases");
        std::fs::create_dir(&databases).unwrap();
        let write = |name: &str| std::fs::write(databases.join(name).with_extension("shatter"), "").unwrap();
        ["a", "b", "c"].iter().for_each(|name| write(name));
        let finished = Arc::new(Mutex::new(Vec::new()));
        let told = finished.clone();
        librarian.loader =
            Arc::new(move |path, _| Ok(Arc::new(Raw(path.file_stem().unwrap().display().to_string(), told.clone()))));
        let catalog = Arc::new(Catalog::default().renewed(Shelf::of(&databases).unwrap(), &librarian.loader));
        librarian.finish(&catalog);
        librarian.reload(&catalog);
        let first = news(&mut events);
        assert!(matches!(first, News::Finished) && librarian.hear(first, &catalog).is_none());
        let second = news(&mut events);
        assert_eq!(*finished.lock().unwrap(), ["a"], "the reload that was asked for went first");
        let catalog = librarian.hear(second, &catalog).unwrap();
        for _ in 0..3 {
            let more = news(&mut events);
            assert!(matches!(more, News::Finished) && librarian.hear(more, &catalog).is_none());
        }
        assert_eq!(*finished.lock().unwrap(), ["a", "a", "b", "c"], "one that falls over it stops nobody");
        assert!(!librarian.busy);
    }

    fn news(events: &mut UnboundedReceiver<Event>) -> News {
        let begun = Instant::now();
        loop {
            match events.try_recv() {
                Ok(Event::News(news)) => return news,
                _ => assert!(begun.elapsed() < Duration::from_secs(60), "no news"),
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_reload_asked_for_during_another_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, false);
        let catalog = Arc::new(Catalog::default());
        librarian.reload(&catalog);
        let first = news(&mut events);
        // The folder changes after it was read, and before the first reload is over.
        std::fs::create_dir(folder.path().join("databases")).unwrap();
        std::fs::write(folder.path().join("databases/a.shatter"), "").unwrap();
        librarian.reload(&catalog);
        let first = librarian.hear(first, &catalog).unwrap();
        assert_eq!(first.len(), 0);
        let second = news(&mut events);
        assert_eq!(librarian.hear(second, &first).unwrap().len(), 1);
    }

    #[test]
    fn a_folder_that_must_exist_and_does_not_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let (mut librarian, mut events) = start(&folder, true);
        let catalog = Arc::new(Catalog::default());
        librarian.look();
        librarian.look();
        let seen = news(&mut events);
        assert!(matches!(seen, News::Seen(Err(_))) && librarian.hear(seen, &catalog).is_none());
        librarian.reload(&catalog);
        let loaded = news(&mut events);
        assert!(matches!(loaded, News::Loaded(Err(_))) && librarian.hear(loaded, &catalog).is_none());
        assert!(events.try_recv().is_err(), "the second look found it busy");
    }
}
