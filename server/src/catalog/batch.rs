//! Databases of one reload: loads them, and decides for all of them together whether they replace the served versions.

use super::directory_snapshot::FileStamp;
use super::{Catalog, DatabaseSource, DirectorySnapshot, ObjectVersion};
use shatter_engine::object::Loader;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// File of a batch, and the version that it holds or why it cannot be loaded.
pub(super) struct LoadedFile {
    pub source: DatabaseSource,
    pub version: Result<Arc<ObjectVersion>, String>,
    stamp: FileStamp,
}

/// Files of one reload.
pub(super) struct Batch {
    files: Vec<LoadedFile>,
    /// Whether a file that replaces a served version changed while the batch was loaded.
    is_overtaken: bool,
}

impl LoadedFile {
    fn kept(version: Arc<ObjectVersion>) -> Self {
        Self { source: version.source.clone(), stamp: version.stamp, version: Ok(version) }
    }

    fn new(source: &DatabaseSource, stamp: FileStamp, version: Result<ObjectVersion, String>) -> Self {
        // A file that was loaded again has a later stamp.
        let stamp = version.as_ref().map_or(stamp, |version| version.stamp);
        Self { source: source.clone(), stamp, version: version.map(Arc::new) }
    }

    /// Source and stamp.
    pub(super) fn key(&self) -> (DatabaseSource, FileStamp) {
        (self.source.clone(), self.stamp)
    }

    /// Whether it replaces, or would replace, a version of `before`.
    fn replaces(&self, before: &Catalog) -> bool {
        let is_served_file = before.at(&self.source).is_some();
        match &self.version {
            Ok(version) => {
                let is_kept = before.versions().any(|old| Arc::ptr_eq(&old.object, &version.object));
                !is_kept && (is_served_file || before.versions().any(|old| old.name == version.name))
            }
            Err(_) => is_served_file,
        }
    }
}

impl Batch {
    /// Loads the files of `snapshot` that `before` does not serve in this version. `loaded` receives the version of each new file.
    pub(super) fn load(
        before: &Catalog,
        snapshot: &DirectorySnapshot,
        loader: &Loader,
        loaded: impl Fn(&Arc<ObjectVersion>) + Sync,
    ) -> Self {
        let is_new = |file: &(DatabaseSource, FileStamp)| !before.snapshot.has(file);
        let is_overtaken = AtomicBool::new(false);
        let files = snapshot.map(is_new, |source, stamp| match before.at(source) {
            Some(old) if old.stamp == stamp || is_overtaken.load(Ordering::Relaxed) => {
                Some(LoadedFile::kept(old.clone()))
            }
            Some(_) => {
                let file = LoadedFile::new(source, stamp, ObjectVersion::load(source, stamp, loader));
                is_overtaken.fetch_or(FileStamp::of(&source.path) != Some(stamp), Ordering::Relaxed);
                Some(file)
            }
            None => {
                let file = LoadedFile::new(source, stamp, ObjectVersion::load_current(source, stamp, loader)?);
                file.version.iter().for_each(&loaded);
                Some(file)
            }
        });
        Self { files: files.into_iter().flatten().collect(), is_overtaken: is_overtaken.into_inner() }
    }

    /// Files of the next catalog; `now` is the folder after the load, `None` if it could not be read.
    pub(super) fn complete(self, before: &Catalog, now: Option<&DirectorySnapshot>) -> Vec<LoadedFile> {
        let is_current = |file: &LoadedFile| now.is_some_and(|now| now.has(&file.key()));
        let is_overtaken =
            self.is_overtaken || self.files.iter().any(|file| file.replaces(before) && !is_current(file));
        let mut files = self.files;
        if is_overtaken {
            let keep = |file: LoadedFile| match before.at(&file.source) {
                // The old version stays served also beside a damaged file, whose error is listed.
                Some(_) if file.version.is_err() && is_current(&file) => Some(file),
                Some(old) => Some(LoadedFile::kept(old.clone())),
                None => (!file.replaces(before)).then_some(file),
            };
            files = files.into_iter().filter_map(keep).collect();
            tracing::warn!(
                "databases changed again while their folder was loaded; the versions before stay served until all are loaded"
            );
        }
        match now {
            Some(now) => follow(files, now),
            None => files,
        }
    }
}

/// Drops the files that `now` lacks, except those that were renamed.
fn follow(files: Vec<LoadedFile>, now: &DirectorySnapshot) -> Vec<LoadedFile> {
    let (mut kept, gone): (Vec<_>, Vec<_>) = files.into_iter().partition(|file| now.has_source(&file.source));
    for file in gone {
        let renamed = file.version.ok().and_then(|version| version.renamed(now));
        kept.extend(
            renamed.filter(|to| kept.iter().all(|own| own.source != to.source)).map(Arc::new).map(LoadedFile::kept),
        );
    }
    kept
}
