//! Tests of catalogs with test-double objects, and of changes to their files.

use super::directory_snapshot::EXTENSION;
use super::*;
use shatter_engine::object::EngineResult;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{StageObserver, Workspace};
use shatter_proto::request::Request;
use std::path::PathBuf;
use tempfile::TempDir;

struct Named(String);

impl ServedObject for Named {
    fn row(&self) -> ObjectRow {
        let mut row = ObjectRow::zeroed();
        row.set_name(&self.0);
        row
    }

    fn bytes(&self) -> usize {
        100
    }

    fn result_bytes_max(&self) -> usize {
        self.0.len()
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

/// A test "database" is a text: the object's name, `!` for a corrupt file, `panic` for one that makes the loader panic.
fn loader() -> Loader {
    Arc::new(|path, object| match std::fs::read_to_string(path).map_err(|error| error.to_string())?.as_str() {
        "!" => Err("damaged".to_owned()),
        "panic" => panic!("fell over it"),
        name => Ok(Arc::new(Named(object.unwrap_or(name).to_owned()))),
    })
}

/// Folder of test "databases".
struct Folder(TempDir);

impl Folder {
    fn of(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        files.iter().for_each(|(file, text)| folder.put(file, text));
        folder
    }

    fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file).with_extension(EXTENSION)
    }

    /// Writes to another file and renames it.
    fn put(&self, file: &str, text: &str) {
        let aside = self.0.path().join("aside");
        std::fs::write(&aside, text).unwrap();
        std::fs::rename(aside, self.path(file)).unwrap();
    }

    fn load(&self) -> Catalog {
        self.reload(&Catalog::default())
    }

    fn reload(&self, catalog: &Catalog) -> Catalog {
        catalog.renewed(DirectorySnapshot::of(self.0.path()).unwrap(), &loader(), |_| ())
    }

    /// Builds the catalog of a scene: pairs of object and database.
    fn with_objects(&self, catalog: &Catalog, objects: &[(&str, &str)]) -> Catalog {
        let objects = objects.iter().map(|(object, database)| ((*object).to_owned(), (*database).to_owned())).collect();
        catalog.renewed(DirectorySnapshot::of(self.0.path()).unwrap().only(&objects), &loader(), |_| ())
    }

    fn source(&self, file: &str) -> DatabaseSource {
        DatabaseSource { path: self.path(file), object: None }
    }
}

fn row(catalog: &Catalog, name: &str) -> ObjectRow {
    catalog.rows(0, 99).into_iter().find(|row| row.name() == name).unwrap()
}

fn kind(catalog: &Catalog, name: &str) -> ErrorKind {
    catalog.get(name).err().unwrap().kind
}

#[test]
fn damaged_files_are_named_and_the_others_served() {
    let folder =
        Folder::of(&[("a", "alpha"), ("b", "!"), ("c", "alpha"), ("d d ä", "delta"), ("e", "x/y"), ("f", "panic")]);
    std::fs::write(folder.0.path().join("notes.txt"), "!").unwrap();
    let catalog = folder.load();
    assert_eq!((catalog.len(), catalog.ready(), catalog.result_bytes_max()), (6, 2, 5));
    assert!(catalog.get("alpha").is_ok() && catalog.get("delta").is_ok());
    for name in ["b", "c", "e", "f"] {
        assert_eq!(kind(&catalog, name), ErrorKind::CorruptObject, "{name}");
    }
    assert!(catalog.get("f").err().unwrap().message.contains("fell over it"));
    assert_eq!(kind(&catalog, "omega"), ErrorKind::UnknownObject);
    let rows = catalog.rows(1, 2);
    assert_eq!((rows.len(), rows[0].name(), rows[0].state), (2, "b".to_owned(), 0));
    let alpha = row(&catalog, "alpha");
    assert_eq!((alpha.state, alpha.file_bytes, alpha.memory_bytes, alpha.generation), (1, 5, 100, 1));
    assert!(alpha.loaded_unix_ns > 0 && alpha.error().is_none());
    assert_eq!(catalog.memory_bytes(), 200);
}

#[test]
fn a_file_that_is_replaced_while_it_is_loaded_is_loaded_again() {
    let folder = Arc::new(Folder::of(&[("a", "alpha"), ("b", "beta")]));
    let (replaced, inner) = (folder.clone(), loader());
    let is_first = std::sync::atomic::AtomicBool::new(true);
    let loader: Loader = Arc::new(move |path, object| {
        let loaded = inner(path, object);
        if path == replaced.path("a") && is_first.swap(false, std::sync::atomic::Ordering::Relaxed) {
            replaced.put("a", "gamma");
        }
        loaded
    });
    let published = std::sync::Mutex::new(Vec::new());
    let snapshot = DirectorySnapshot::of(folder.0.path()).unwrap();
    let note = |version: &Arc<ObjectVersion>| published.lock().unwrap().push(version.name.clone());
    let catalog = Catalog::default().renewed(snapshot, &loader, note);
    let mut published = published.into_inner().unwrap();
    published.sort();
    assert_eq!(published, ["beta", "gamma"]);
    assert_eq!((catalog.len(), catalog.ready(), kind(&catalog, "alpha")), (2, 2, ErrorKind::UnknownObject));
}

#[test]
fn a_file_that_is_gone_before_its_turn_is_not_listed_as_failed() {
    let folder = Folder::of(&[("a", "alpha"), ("b", "beta"), ("c", "!")]);
    let snapshot = DirectorySnapshot::of(folder.0.path()).unwrap();
    std::fs::remove_file(folder.path("a")).unwrap();
    let catalog = Catalog::default().renewed(snapshot, &loader(), |_| ());
    assert_eq!((catalog.len(), catalog.ready(), catalog.failed()), (2, 1, 1));
    let message = catalog.get("x").err().unwrap().message;
    assert!(message.ends_with("there is `beta`"), "names that failed are not offered: {message}");
}

/// As when the whole folder cannot be read while a file is loaded.
#[test]
fn a_file_that_comes_back_unchanged_is_missing_from_the_catalog() {
    let folder = Folder::of(&[("a", "alpha"), ("b", "beta")]);
    let seen = DirectorySnapshot::of(folder.0.path()).unwrap();
    let aside = folder.0.path().join("aside");
    std::fs::rename(folder.path("a"), &aside).unwrap();
    let catalog = Catalog::default().renewed(seen.clone(), &loader(), |_| ());
    std::fs::rename(&aside, folder.path("a")).unwrap();
    assert!(*catalog.snapshot() != seen, "a later look asks for a reload");
    let catalog = folder.reload(&catalog);
    assert_eq!((catalog.ready(), row(&catalog, "alpha").generation), (2, 1));
}

#[test]
fn a_reload_keeps_what_is_unchanged_and_follows_the_folder() {
    let folder = Folder::of(&[("a", "alpha"), ("b", "beta"), ("c", "gamma")]);
    let before = folder.load();
    folder.put("b", "beta");
    std::fs::remove_file(folder.path("c")).unwrap();
    folder.put("d", "delta");
    let after = folder.reload(&before);
    let same = |name| Arc::ptr_eq(&before.get(name).unwrap(), &after.get(name).unwrap());
    assert!(same("alpha") && !same("beta"));
    assert_eq!(kind(&after, "gamma"), ErrorKind::UnknownObject);
    let generations = ["alpha", "beta", "delta"].map(|name| row(&after, name).generation);
    assert_eq!(generations, [1, 2, 1]);
    assert_eq!(row(&before, "alpha").loaded_unix_ns, row(&after, "alpha").loaded_unix_ns);
}

#[test]
fn a_bad_replacement_leaves_the_version_before_it_served() {
    let folder = Folder::of(&[("a", "alpha"), ("b", "beta")]);
    let before = folder.load();
    folder.put("a", "!");
    let damaged = folder.reload(&before);
    assert!(Arc::ptr_eq(&before.get("alpha").unwrap(), &damaged.get("alpha").unwrap()));
    assert_eq!((damaged.len(), damaged.ready(), damaged.outdated()), (2, 2, 1));
    let alpha = row(&damaged, "alpha");
    assert_eq!((alpha.state, alpha.generation), (1, 1));
    assert_eq!(alpha.error().unwrap().message, "a.shatter: damaged");
    // Repeated reloads change nothing.
    let still = folder.reload(&folder.reload(&damaged));
    assert!(Arc::ptr_eq(&before.get("alpha").unwrap(), &still.get("alpha").unwrap()));
    folder.put("a", "alpha");
    let restored = folder.reload(&still);
    let alpha = row(&restored, "alpha");
    assert_eq!((alpha.state, alpha.generation, alpha.error(), restored.outdated()), (1, 2, None, 0));
    std::fs::remove_file(folder.path("a")).unwrap();
    let removed = folder.reload(&restored);
    assert_eq!(kind(&removed, "alpha"), ErrorKind::UnknownObject, "a removed file is not served");
    folder.put("a", "alpha");
    assert_eq!(row(&folder.reload(&removed), "alpha").generation, 3, "it is the third version since the start");
}

#[test]
fn copies_of_a_database_take_nothing_away() {
    let folder = Folder::of(&[("spot", "spot"), ("vase-1", "vase")]);
    let before = folder.load();
    let same = |after: &Catalog, name: &str| Arc::ptr_eq(&before.get(name).unwrap(), &after.get(name).unwrap());
    // The copies sort before the originals.
    folder.put("a copy", "spot");
    folder.put("vase-0", "vase");
    let after = folder.reload(&before);
    assert!(same(&after, "spot") && same(&after, "vase"));
    assert_eq!(kind(&after, "a copy"), ErrorKind::CorruptObject);
    assert!(row(&after, "vase-0").error().unwrap().message.contains("vase-1.shatter already holds"));
    assert!(folder.load().get("spot").is_ok_and(|_| folder.load().at(&folder.source("spot")).is_some()));
    // The file that has the object's name takes precedence, also if it appears later.
    folder.put("vase", "vase");
    let after = folder.reload(&after);
    assert!(!same(&after, "vase") && after.at(&folder.source("vase")).is_some());
    assert_eq!((row(&after, "vase").generation, row(&after, "vase").error()), (2, None));
}

#[test]
fn a_damaged_replacement_takes_no_name_from_a_valid_file() {
    let folder = Folder::of(&[("a", "alpha")]);
    let before = folder.load();
    folder.put("a", "!");
    folder.put("z", "alpha");
    let after = folder.reload(&before);
    assert!(!Arc::ptr_eq(&before.get("alpha").unwrap(), &after.get("alpha").unwrap()));
    assert_eq!((row(&after, "alpha").generation, row(&after, "alpha").error()), (2, None));
    assert_eq!(kind(&after, "a"), ErrorKind::CorruptObject);
    // A corrupt file whose name equals an object from another file is reported, too.
    folder.put("alpha", "!");
    let after = folder.reload(&after);
    assert!(row(&after, "alpha").error().unwrap().message.starts_with("alpha.shatter"));
    assert!(after.get("alpha").is_ok());
}

#[test]
fn what_was_replaced_is_counted_until_it_is_released() {
    let folder = Folder::of(&[("a", "alpha"), ("b", "beta")]);
    let (before, mut retired) = (folder.load(), RetiredVersions::default());
    folder.put("a", "alpha");
    let after = folder.reload(&before);
    retired.note(&before, &after);
    let struck = before.get("alpha").unwrap();
    assert_eq!(retired.alive(), (1, 100));
    drop(before);
    assert_eq!(retired.alive(), (1, 100), "a request holds it");
    drop(struck);
    assert_eq!(retired.alive(), (0, 0));
    retired.note(&after, &after);
    assert!(retired.alive() == (0, 0) && after.ready() == 2);
}

#[test]
fn objects_of_one_database_are_replaced_together() {
    const OBJECT_DATABASES: [(&str, &str); 3] = [("near", "statue"), ("far", "statue"), ("vase", "vase")];
    let folder = Folder::of(&[("statue", "anything"), ("vase", "vase"), ("idle", "idle")]);
    let with_objects = |before: &Catalog| folder.with_objects(before, &OBJECT_DATABASES);
    let names = |catalog: &Catalog| catalog.rows(0, 99).iter().map(ObjectRow::name).collect::<Vec<_>>();
    let same = |one: &Catalog, two: &Catalog, name: &str| Arc::ptr_eq(&one.get(name).unwrap(), &two.get(name).unwrap());
    let generations = |catalog: &Catalog| OBJECT_DATABASES.map(|(name, _)| row(catalog, name).generation);
    let first = with_objects(&Catalog::default());
    assert_eq!(names(&first), ["far", "near", "vase"]);
    assert!(!Arc::ptr_eq(&first.get("near").unwrap(), &first.get("far").unwrap()));
    assert_eq!((first.memory_bytes(), first.ready(), row(&first, "far").memory_bytes), (300, 3, 100));
    assert_eq!(kind(&first, "statue"), ErrorKind::UnknownObject, "the file's own name is not served");

    let still = with_objects(&first);
    assert!(OBJECT_DATABASES.iter().all(|(name, _)| same(&first, &still, name)));
    folder.put("statue", "another");
    let replaced = with_objects(&still);
    assert!(!same(&still, &replaced, "near") && !same(&still, &replaced, "far") && same(&still, &replaced, "vase"));
    assert_eq!(generations(&replaced), [2, 2, 1]);

    folder.put("statue", "!");
    let damaged = with_objects(&replaced);
    assert_eq!((damaged.ready(), damaged.outdated()), (3, 2));
    for name in ["near", "far"] {
        assert!(same(&replaced, &damaged, name));
        let error = row(&damaged, name).error().unwrap();
        assert_eq!((error.at.as_str(), error.message.as_str()), (name, "statue.shatter: damaged"));
    }
    std::fs::remove_file(folder.path("statue")).unwrap();
    let removed = with_objects(&damaged);
    assert_eq!(names(&removed), ["vase"]);
    folder.put("statue", "!");
    let bad = with_objects(&removed);
    assert_eq!(["near", "far"].map(|name| kind(&bad, name)), [ErrorKind::CorruptObject; 2]);
    folder.put("statue", "it is back");
    assert_eq!((names(&with_objects(&bad)), with_objects(&bad).outdated()), (names(&first), 0));
}

#[test]
fn new_objects_are_served_before_the_end_of_a_reload_and_replaced_ones_are_not() {
    let folder = Folder::of(&[("a", "a"), ("b", "b")]);
    let before = folder.load();
    folder.put("a", "a");
    folder.put("c", "c");
    let after = folder.reload(&before);
    let advanced = |name: &str| before.advanced(after.at(&folder.source(name)).unwrap(), after.snapshot());
    assert!(advanced("a").is_none());
    let with_new = advanced("c").unwrap();
    let same = |name: &str| Arc::ptr_eq(&before.get(name).unwrap(), &with_new.get(name).unwrap());
    assert!(same("a") && same("b") && with_new.get("c").is_ok());
    assert_eq!(row(&with_new, "c").generation, row(&after, "c").generation);
}
