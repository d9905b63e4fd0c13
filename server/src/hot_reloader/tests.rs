//! Tests of hot reloads.

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

const TIMEOUT: Duration = Duration::from_secs(60);

/// Reloader of a separate folder, and its events.
fn start(folder: &TempDir, required: bool) -> (HotReloader, UnboundedReceiver<WorkerEvent>) {
    let (sender, events) = unbounded_channel();
    let loader: Loader = Arc::new(|_, _| Err("nothing is ever loaded here".to_owned()));
    let path = folder.path().join("databases");
    (HotReloader::new(DatabaseFolder { path, required, only: None }, loader, NICE, sender).unwrap(), events)
}

/// Object with deferred work that waits until the gate is open, and panics if its name is "b".
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
        while !self.2.load(Ordering::Relaxed) && begun.elapsed() < TIMEOUT {
            std::thread::yield_now();
        }
        assert!(self.0 != "b", "cannot be finished");
        Ok(())
    }

    fn result_bytes_max(&self) -> usize {
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
    let (mut reloader, mut events) = start(&folder, true);
    let databases = folder.path().join("databases");
    std::fs::create_dir(&databases).unwrap();
    let write = |name: &str| std::fs::write(databases.join(name).with_extension("shatter"), "").unwrap();
    ["a", "b"].iter().for_each(|name| write(name));
    let (finished, gate) = (Arc::new(Mutex::new(Vec::new())), Arc::new(AtomicBool::new(false)));
    let (seen, opened) = (finished.clone(), gate.clone());
    reloader.loader = Arc::new(move |path, _| {
        Ok(Arc::new(Raw(path.file_stem().unwrap().display().to_string(), seen.clone(), opened.clone())))
    });
    let mut catalog =
        Arc::new(Catalog::default().renewed(DirectorySnapshot::of(&databases).unwrap(), &reloader.loader, |_| ()));
    reloader.finish(&catalog);
    let begun = Instant::now();
    while finished.lock().unwrap().is_empty() && begun.elapsed() < TIMEOUT {
        std::thread::yield_now();
    }
    write("c");
    reloader.reload(&catalog);
    let begun = event(&mut events);
    assert!(matches!(begun, ReloadEvent::Begun(..)) && reloader.handle(begun, &catalog).is_none());
    let listed = reloader.expected(&catalog).unwrap();
    assert_eq!((listed.loading(), listed.failed(), listed.get("c").err().unwrap().kind), (1, 0, ErrorKind::Loading));
    assert_eq!(listed.get("another").err().unwrap().kind, ErrorKind::Loading, "the file `c` may hold it");
    assert!(reloader.expected(&listed).is_none() && listed.get("a").is_ok());
    let advanced = event(&mut events);
    let listed = reloader.handle(advanced, &listed).unwrap();
    assert!(listed.get("c").is_ok() && reloader.expected(&listed).is_none());
    let loaded = event(&mut events);
    assert!(
        matches!(loaded, ReloadEvent::Loaded(_)) && *finished.lock().unwrap() == ["a"],
        "a load waits for no deferred work"
    );
    catalog = reloader.handle(loaded, &listed).unwrap();
    assert_eq!((catalog.loading(), catalog.ready()), (0, 3));
    gate.store(true, Ordering::Relaxed);
    for _ in 0..4 {
        let more = event(&mut events);
        assert!(matches!(more, ReloadEvent::Finished) && reloader.handle(more, &catalog).is_none());
    }
    assert_eq!(*finished.lock().unwrap(), ["a", "a", "b", "c"], "a panic stops no other object");
    assert!(!reloader.finish_worker.is_busy && reloader.expected(&catalog).is_none());
}

/// Files whose names are not those of their objects: `b` holds `z`, as `e` does, and `c` holds `d`, as the file `d` does. `f` is damaged.
#[test]
fn each_database_of_a_batch_is_served_as_soon_as_it_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reloader, mut events) = start(&folder, true);
    let databases = folder.path().join("databases");
    std::fs::create_dir(&databases).unwrap();
    let write = |name: &str| std::fs::write(databases.join(name).with_extension("shatter"), "").unwrap();
    ["a", "b", "c", "d", "e", "f", "x"].iter().for_each(|name| write(name));
    let gates = ["d", "x"].map(|name| (name, Arc::new(AtomicBool::new(false))));
    let opened = gates.clone();
    reloader.loader = Arc::new(move |path, _| {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let begun = Instant::now();
        let is_shut = || opened.iter().any(|(own, gate)| *own == name && !gate.load(Ordering::Relaxed));
        while is_shut() && begun.elapsed() < TIMEOUT {
            std::thread::yield_now();
        }
        let name = match name {
            "b" | "e" => "z",
            "c" => "d",
            "f" => return Err("damaged".to_owned()),
            name => name,
        };
        Ok(Arc::new(Raw(name.to_owned(), Arc::default(), opened[0].1.clone())))
    });
    let mut catalog = Arc::new(Catalog::default());
    reloader.reload(&catalog);
    let mut handle = |reloader: &mut HotReloader, catalog: &mut Arc<Catalog>| {
        let next = event(&mut events);
        if let Some(fresh) = reloader.handle(next, catalog) {
            *catalog = fresh;
        }
        if let Some(fresh) = reloader.expected(catalog) {
            *catalog = fresh;
        }
    };
    let kinds = |catalog: &Catalog, names: &[&str]| -> Vec<Option<ErrorKind>> {
        names.iter().map(|name| catalog.get(name).err().map(|error| error.kind)).collect()
    };
    let (loading, corrupt) = (Some(ErrorKind::Loading), Some(ErrorKind::CorruptObject));
    // The start, a, b and c.
    (0..4).for_each(|_| handle(&mut reloader, &mut catalog));
    assert_eq!(
        kinds(&catalog, &["a", "z", "d", "x"]),
        [None, None, loading, loading],
        "`d` waits for the file of its name"
    );
    assert_eq!((catalog.ready(), reloader.reloads()), (2, 0));
    let early = catalog.get("z").unwrap();
    gates[0].1.store(true, Ordering::Relaxed);
    // d and e.
    (0..2).for_each(|_| handle(&mut reloader, &mut catalog));
    assert_eq!(kinds(&catalog, &["a", "z", "d", "x"]), [None, None, None, loading]);
    gates[1].1.store(true, Ordering::Relaxed);
    while reloader.reloads() == 0 {
        handle(&mut reloader, &mut catalog);
    }
    assert_eq!(kinds(&catalog, &["a", "z", "d", "x"]), [None; 4]);
    assert_eq!(kinds(&catalog, &["c", "e", "f"]), [corrupt; 3]);
    assert!(Arc::ptr_eq(&early, &catalog.get("z").unwrap()), "nothing is loaded twice");
    assert!(catalog.rows(0, 9).iter().filter(|row| row.state == 1).all(|row| row.generation == 1));
}

/// `b` and `double` hold one object; `slow` is loaded until its gate is open.
#[test]
fn a_removed_file_is_gone_at_the_next_scan_whatever_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reloader, mut events) = start(&folder, true);
    let databases = folder.path().join("databases");
    std::fs::create_dir(&databases).unwrap();
    let path = |name: &str| databases.join(name).with_extension("shatter");
    let write = |name: &str| std::fs::write(path(name), "").unwrap();
    ["a", "b", "double", "damaged"].iter().for_each(|name| write(name));
    let gate = Arc::new(AtomicBool::new(false));
    let opened = gate.clone();
    reloader.loader = Arc::new(move |path, _| {
        let name = match path.file_stem().unwrap().to_str().unwrap() {
            "double" => "b",
            "damaged" => return Err("damaged".to_owned()),
            name => name,
        };
        let begun = Instant::now();
        while name == "slow" && !opened.load(Ordering::Relaxed) && begun.elapsed() < TIMEOUT {
            std::thread::yield_now();
        }
        Ok(Arc::new(Raw(name.to_owned(), Arc::default(), opened.clone())))
    });
    let mut catalog =
        Arc::new(Catalog::default().renewed(DirectorySnapshot::of(&databases).unwrap(), &reloader.loader, |_| ()));
    let mut handle = |reloader: &mut HotReloader, catalog: &mut Arc<Catalog>| {
        let next = event(&mut events);
        if let Some(fresh) = reloader.handle(next, catalog) {
            *catalog = fresh;
        }
        if let Some(fresh) = reloader.expected(catalog) {
            *catalog = fresh;
        }
    };
    let state = |catalog: &Catalog| (catalog.ready(), catalog.loading(), catalog.failed());
    assert_eq!(state(&catalog), (2, 0, 2));
    write("slow");
    reloader.reload(&catalog);
    handle(&mut reloader, &mut catalog);
    assert_eq!(state(&catalog), (2, 1, 2));
    ["a", "b", "damaged"].iter().for_each(|name| std::fs::remove_file(path(name)).unwrap());
    reloader.scan();
    handle(&mut reloader, &mut catalog);
    assert_eq!(state(&catalog), (0, 2, 0), "`double` and `slow` are being loaded");
    assert_eq!(catalog.get("double").err().unwrap().kind, ErrorKind::Loading);
    gate.store(true, Ordering::Relaxed);
    while reloader.reloads() == 0 {
        handle(&mut reloader, &mut catalog);
        assert!(catalog.get("a").is_err() && catalog.get("damaged").err().unwrap().kind != ErrorKind::CorruptObject);
    }
    assert!(catalog.get("slow").is_ok() && catalog.get("a").is_err());
    reloader.reload(&catalog);
    while reloader.reloads() == 1 || reloader.load_worker.is_busy {
        handle(&mut reloader, &mut catalog);
    }
    assert_eq!(state(&catalog), (2, 0, 0));
    assert!(catalog.get("b").is_ok(), "the other file holds it");
}

fn event(events: &mut UnboundedReceiver<WorkerEvent>) -> ReloadEvent {
    let begun = Instant::now();
    loop {
        match events.try_recv() {
            Ok(WorkerEvent::Reload(event)) => return event,
            _ => assert!(begun.elapsed() < TIMEOUT, "no news"),
        }
        std::thread::yield_now();
    }
}

#[test]
fn a_scan_for_a_client_does_not_count_for_the_debounce() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reloader, mut events) = start(&folder, true);
    let databases = folder.path().join("databases");
    std::fs::create_dir(&databases).unwrap();
    let catalog = Arc::new(Catalog::default());
    assert_eq!(
        (reloader.scan_for_client(), reloader.scan_for_client()),
        (1, 2),
        "the first scan may have begun too early"
    );
    std::fs::write(databases.join("a.shatter"), "").unwrap();
    for done in [1, 2] {
        assert_eq!(reloader.scans_done(), done - 1);
        let seen = event(&mut events);
        assert!(matches!(seen, ReloadEvent::Seen(_, Ok(_))) && reloader.handle(seen, &catalog).is_none());
    }
    let listed = reloader.expected(&catalog).unwrap();
    assert_eq!((reloader.scans_done(), listed.get("a").err().unwrap().kind), (2, ErrorKind::Loading));
    assert!(
        !reloader.load_worker.is_busy && !reloader.is_reload_requested,
        "two scans for clients do not show a stable folder"
    );
    for _ in 0..2 {
        reloader.scan();
        let seen = event(&mut events);
        assert!(reloader.handle(seen, &listed).is_none());
    }
    assert!(reloader.load_worker.is_busy);
}

#[test]
fn a_reload_asked_for_during_another_is_not_lost() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reloader, mut events) = start(&folder, false);
    let catalog = Arc::new(Catalog::default());
    reloader.reload(&catalog);
    let loaded = |reloader: &mut HotReloader, events: &mut UnboundedReceiver<WorkerEvent>| {
        let begun = event(events);
        assert!(matches!(begun, ReloadEvent::Begun(..)) && reloader.handle(begun, &catalog).is_none());
        event(events)
    };
    let first = loaded(&mut reloader, &mut events);
    // The folder changes after the scan, and before the first reload is over.
    std::fs::create_dir(folder.path().join("databases")).unwrap();
    std::fs::write(folder.path().join("databases/a.shatter"), "").unwrap();
    reloader.reload(&catalog);
    let first = reloader.handle(first, &catalog).unwrap();
    assert_eq!(first.len(), 0);
    let second = loaded(&mut reloader, &mut events);
    assert_eq!(reloader.handle(second, &first).unwrap().len(), 1);
}

#[test]
fn a_missing_folder_keeps_the_catalog() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reloader, mut events) = start(&folder, true);
    let catalog = Arc::new(Catalog::default());
    reloader.scan();
    reloader.scan();
    let seen = event(&mut events);
    assert!(matches!(seen, ReloadEvent::Seen(_, Err(_))) && reloader.handle(seen, &catalog).is_none());
    reloader.reload(&catalog);
    let loaded = event(&mut events);
    assert!(matches!(loaded, ReloadEvent::Loaded(Err(_))) && reloader.handle(loaded, &catalog).is_none());
    assert!(events.try_recv().is_err(), "a scan was under way already");
}
