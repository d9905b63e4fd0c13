//! The objects of the service. A database that cannot be loaded is logged and listed with its error; the others are served.

use crate::engine::{Loader, Object};
use bytemuck::Zeroable;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use shatter_proto::control::ObjectRow;
use shatter_proto::name::object_name;
use shatter_proto::refusal::RefusalWire;
use shatter_proto::{Kind, Refusal};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The ending of database files.
const EXTENSION: &str = "shatter";

/// All objects of a folder, by name.
#[derive(Default)]
pub struct Catalog {
    entries: BTreeMap<String, Result<Arc<dyn Object>, Refusal>>,
}

impl Catalog {
    /// Loads every `*.shatter` of `folder` on the current rayon pool.
    pub fn load(folder: &Path, loader: &Loader) -> Result<Self, Refusal> {
        let files = files(folder)?;
        let loaded: Vec<_> = files.par_iter().map(|path| loader(path)).collect();
        let mut catalog = Self::default();
        for (path, object) in files.iter().zip(loaded) {
            catalog.insert(path, object);
        }
        Ok(catalog)
    }

    fn insert(&mut self, path: &Path, object: Result<Arc<dyn Object>, String>) {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let named = object.and_then(|object| {
            let name = object.row().name();
            object_name(&name).map_err(|refusal| refusal.message)?;
            match self.entries.get(&name) {
                Some(Ok(_)) => Err(format!("another file already holds an object `{name}`")),
                _ => Ok((name, object)),
            }
        });
        match named {
            Ok((name, object)) => {
                tracing::info!(object = name, path = %path.display(), "loaded");
                self.entries.insert(name, Ok(object));
            }
            Err(why) => {
                tracing::error!(object = stem, path = %path.display(), why, "cannot be loaded");
                let message = format!("{}: {why}", path.file_name().unwrap_or_default().to_string_lossy());
                self.entries.entry(stem.clone()).or_insert(Err(Refusal::new(Kind::CorruptObject, stem, message)));
            }
        }
    }

    /// The object `name`, or why there is none.
    pub fn get(&self, name: &str) -> Result<Arc<dyn Object>, Refusal> {
        match self.entries.get(name) {
            Some(entry) => entry.clone(),
            None => {
                let message = format!("the service has no object `{name}`");
                Err(Refusal::new(Kind::UnknownObject, name, message))
            }
        }
    }

    /// Rows for `list`, from position `first` on, at most `count`.
    pub fn rows(&self, first: usize, count: usize) -> Vec<ObjectRow> {
        self.entries.iter().skip(first).take(count).map(|(name, entry)| row(name, entry)).collect()
    }

    /// Number of entries, loaded or not.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is no entry at all.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Number of objects that can be struck.
    pub fn ready(&self) -> usize {
        self.entries.values().filter(|entry| entry.is_ok()).count()
    }

    /// Bytes of the largest answer that any object may give.
    pub fn answer_bytes_max(&self) -> usize {
        self.entries.values().flatten().map(|object| object.answer_bytes_max()).max().unwrap_or(0)
    }
}

fn row(name: &str, entry: &Result<Arc<dyn Object>, Refusal>) -> ObjectRow {
    match entry {
        Ok(object) => ObjectRow { ready: 1, ..object.row() },
        Err(refusal) => {
            let mut row = ObjectRow::zeroed();
            row.set_name(name);
            row.refusal = RefusalWire::from(refusal);
            row
        }
    }
}

/// The databases of a folder, sorted: a name given twice always goes to the same file.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Refusal> {
    let refuse = |error: std::io::Error| {
        let at = folder.display().to_string();
        let message = format!("cannot read the folder of databases {at}: {error}");
        Refusal::new(Kind::DatabaseFolder, at, message)
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refuse)? {
        let path = entry.map_err(refuse)?.path();
        if path.extension().is_some_and(|extension| extension == EXTENSION) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Outcome;
    use shatter_fracture::pipeline::{Watch, Workspace};
    use shatter_fracture::token::Token;
    use shatter_proto::request::Strike;

    struct Named(String);

    impl Object for Named {
        fn row(&self) -> ObjectRow {
            let mut row = ObjectRow::zeroed();
            row.set_name(&self.0);
            row
        }

        fn answer_bytes_max(&self) -> usize {
            self.0.len()
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

    /// A "database" is a text: the object's name, or `!` for a damaged one.
    fn loader() -> Loader {
        Arc::new(|path| match std::fs::read_to_string(path).map_err(|error| error.to_string())?.as_str() {
            "!" => Err("damaged".to_owned()),
            name => Ok(Arc::new(Named(name.to_owned()))),
        })
    }

    #[test]
    fn damaged_files_are_named_and_the_others_served() {
        let folder = tempfile::tempdir().unwrap();
        for (file, text) in [("a", "alpha"), ("b", "!"), ("c", "alpha"), ("d d ä", "delta"), ("e", "x/y")] {
            std::fs::write(folder.path().join(file).with_extension(EXTENSION), text).unwrap();
        }
        std::fs::write(folder.path().join("notes.txt"), "!").unwrap();
        let catalog = Catalog::load(folder.path(), &loader()).unwrap();
        assert_eq!((catalog.len(), catalog.ready(), catalog.answer_bytes_max()), (5, 2, 5));
        assert!(catalog.get("alpha").is_ok() && catalog.get("delta").is_ok());
        let kind = |name: &str| catalog.get(name).err().unwrap().kind;
        assert_eq!(kind("b"), Kind::CorruptObject);
        assert_eq!(kind("c"), Kind::CorruptObject);
        assert_eq!(kind("e"), Kind::CorruptObject);
        assert_eq!(kind("omega"), Kind::UnknownObject);
        let rows = catalog.rows(1, 2);
        assert_eq!((rows.len(), rows[0].name(), rows[0].ready), (2, "b".to_owned(), 0));
    }

    #[test]
    fn a_missing_folder_is_refused_by_name() {
        let refusal = Catalog::load(Path::new("/nowhere/at all"), &loader()).err().unwrap();
        assert_eq!((refusal.kind, refusal.at.as_str()), (Kind::DatabaseFolder, "/nowhere/at all"));
    }
}
