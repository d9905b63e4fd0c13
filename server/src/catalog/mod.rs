//! Objects of the service.
//!
//! A database that cannot be loaded is logged and listed with its error; the others are served. A scene may make several objects of one
//! database: each is a separate entry, loaded separately.
//!
//! A catalog is immutable. A reload builds a new catalog, which keeps the versions of unchanged files, and replaces the old catalog
//! as a whole; objects that are new are served before, as soon as each is loaded. A request keeps the version with which it began.

mod directory_snapshot;
mod load_in_progress;
mod retired_versions;
mod version;

use directory_snapshot::FileStamp;
pub use directory_snapshot::{DatabaseSource, DirectorySnapshot, is_database, is_hidden};
pub use retired_versions::RetiredVersions;
pub use version::{ObjectVersion, unix_ns};

use bytemuck::Zeroable;
use load_in_progress::LoadInProgress;
use shatter_engine::object::{Loader, ServedObject};
use shatter_proto::control::{ObjectRow, ObjectState};
use shatter_proto::error::ErrorWire;
use shatter_proto::name::unknown_object;
use shatter_proto::{Error, ErrorKind};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::SystemTime;

/// All objects of a folder, by name.
pub struct Catalog {
    entries: BTreeMap<String, Entry>,
    /// Number of versions of each name since the start of the daemon, also of names that are gone.
    generations: BTreeMap<String, u32>,
    snapshot: DirectorySnapshot,
    read: SystemTime,
}

/// Entry of one name.
#[derive(Clone, Default)]
struct Entry {
    /// Version that is served.
    version: Option<Arc<ObjectVersion>>,
    /// Number of the version among those that this name has had, from 1.
    generation: u32,
    /// Why no version is served, or why the current file is not served.
    refusal: Option<Refusal>,
    /// Load of the database, while no version is served.
    loading: Option<LoadInProgress>,
}

/// File that is not served, and why.
#[derive(Clone)]
struct Refusal {
    source: DatabaseSource,
    /// File that holds the same object and is served.
    double_of: Option<DatabaseSource>,
    error: Error,
}

impl Default for Catalog {
    fn default() -> Self {
        Self {
            entries: BTreeMap::new(),
            generations: BTreeMap::new(),
            snapshot: DirectorySnapshot::default(),
            read: SystemTime::now(),
        }
    }
}

impl Catalog {
    /// Builds the catalog of `snapshot` on the current rayon pool.
    ///
    /// Keeps versions whose files did not change and retries files that failed. If the file of a version was replaced by one that fails,
    /// the old version stays served. New files are loaded before others are tried again. `loaded` receives each new version before the
    /// next files are loaded. A file that is gone when its turn comes is left out.
    #[must_use]
    pub fn renewed(
        &self,
        snapshot: DirectorySnapshot,
        loader: &Loader,
        loaded: impl Fn(&Arc<ObjectVersion>) + Sync,
    ) -> Self {
        let is_new = |file: &(DatabaseSource, FileStamp)| !self.snapshot.has(file);
        let found = snapshot.map(is_new, |source, stamp| match self.at(source) {
            Some(version) if version.stamp == stamp => Some((source.clone(), Ok(version.clone()))),
            _ => {
                let version = ObjectVersion::load_current(source, stamp, loader)?.map(Arc::new);
                version.iter().for_each(&loaded);
                Some((source.clone(), version))
            }
        });
        let found: Vec<_> = found.into_iter().flatten().collect();
        let generations = self.generations.clone();
        // A file that was left out counts as not seen, so that it is loaded once it is back.
        let snapshot = snapshot.without(|source| found.iter().all(|(own, _)| own != source));
        let mut catalog = Self { entries: BTreeMap::new(), generations, snapshot, read: SystemTime::now() };
        let mut loaded: Vec<_> =
            found.iter().filter_map(|(source, version)| Some((source, version.as_ref().ok()?))).collect();
        // If several files hold one name, the file of that name has precedence, because bakes write there; then the file that served
        // it before. So copies of a file take no names away.
        loaded.sort_by_key(|(source, version)| (source.name() != version.name, !self.serves(source, &version.name)));
        for (source, version) in loaded {
            catalog.put(source, version, self);
        }
        // Last, so that a version whose file was corrupted takes no name away from an intact file.
        for (source, version) in &found {
            if let Err(why) = version {
                catalog.miss(source, why, self);
            }
        }
        catalog
    }

    /// Lists the new databases of `seen` as being loaded; `None` if this catalog lists the same ones already.
    pub fn expecting(&self, seen: &DirectorySnapshot) -> Option<Self> {
        let new: Vec<_> = seen.missing_from(&self.snapshot).filter(|(source, _)| self.at(source).is_none()).collect();
        let bytes = new.iter().map(|(_, stamp)| stamp.bytes()).sum();
        let serves = |name: &str| self.entries.get(name).is_some_and(|entry| entry.version.is_some());
        let names: BTreeSet<String> =
            new.iter().map(|(source, _)| source.name()).filter(|name| !serves(name)).collect();
        let listed = self.entries.iter().filter(|(_, entry)| entry.loading.is_some()).map(|(name, _)| name);
        if names.iter().eq(listed) {
            return None;
        }
        let mut entries = self.entries.clone();
        entries.iter_mut().filter(|(name, _)| !names.contains(*name)).for_each(|(_, entry)| entry.loading = None);
        let loading =
            LoadInProgress::now(bytes, self.versions().map(|version| (version.stamp.bytes(), version.load_time())));
        for name in names {
            // Entries that are listed already keep their start.
            entries.entry(name).or_default().loading.get_or_insert(loading);
        }
        entries.retain(|_, entry| !entry.is_empty());
        Some(Self { entries, generations: self.generations.clone(), snapshot: self.snapshot.clone(), read: self.read })
    }

    /// This catalog without the files that `seen`, a later look at the folder, lacks; `None` if it has them all.
    ///
    /// A file that held the same object as one of these is no longer refused. It counts as not loaded.
    #[must_use]
    pub fn without_removed(&self, seen: &DirectorySnapshot) -> Option<Self> {
        let is_gone = |source: &DatabaseSource| !seen.has_source(source);
        let is_free = |refusal: &Refusal| refusal.double_of.as_ref().is_some_and(is_gone);
        let refusals = || self.entries.values().filter_map(|entry| entry.refusal.as_ref());
        let freed: Vec<&DatabaseSource> = refusals().filter(|own| is_free(own)).map(|own| &own.source).collect();
        let snapshot = self.snapshot.without(|source| is_gone(source) || freed.contains(&source));
        if snapshot == self.snapshot && self.versions().all(|version| !is_gone(&version.source)) {
            return None;
        }
        let mut entries = self.entries.clone();
        for (object, entry) in &mut entries {
            if let Some(version) = entry.version.take_if(|version| is_gone(&version.source)) {
                let path = version.source.path.display();
                tracing::info!(object, %path, "the file of a database was removed; its object is not served any more");
            }
            entry.refusal.take_if(|own| is_gone(&own.source) || is_free(own));
        }
        entries.retain(|_, entry| !entry.is_empty());
        Some(Self { entries, generations: self.generations.clone(), snapshot, read: self.read })
    }

    /// This catalog with a new object, which was loaded during a reload to `target` that goes on. `None` if it must wait for the end of the
    /// reload: another version is served, and all such versions are replaced together, or another file may take precedence.
    #[must_use]
    pub fn advanced(&self, version: &Arc<ObjectVersion>, target: &DirectorySnapshot) -> Option<Self> {
        let is_served = self.entries.get(&version.name).is_some_and(|entry| entry.version.is_some());
        if is_served || version.source.name() != version.name && target.has_name(&version.name) {
            return None;
        }
        let mut entries = self.entries.clone();
        entries.remove(&version.name);
        entries.retain(|name, entry| *name != version.source.name() || entry.version.is_some());
        let (generations, snapshot) = (self.generations.clone(), self.snapshot.with(&version.source, version.stamp));
        let mut catalog = Self { entries, generations, snapshot, read: self.read };
        catalog.put(&version.source, version, self);
        Some(catalog)
    }

    /// Whether the version from `source` serves the object `name`.
    fn serves(&self, source: &DatabaseSource, name: &str) -> bool {
        self.at(source).is_some_and(|version| version.name == name)
    }

    /// Version that was loaded from `source`.
    fn at(&self, source: &DatabaseSource) -> Option<&Arc<ObjectVersion>> {
        self.versions().find(|version| version.source == *source)
    }

    /// All versions that are served.
    pub fn versions(&self) -> impl Iterator<Item = &Arc<ObjectVersion>> {
        self.entries.values().filter_map(|entry| entry.version.as_ref())
    }

    /// Adds `version` under its name, unless another file has that name.
    fn put(&mut self, source: &DatabaseSource, version: &Arc<ObjectVersion>, before: &Self) {
        if let Some(other) = self.entries.get(&version.name).and_then(|entry| entry.version.as_ref()) {
            let why = format!(
                "{} already holds an object `{}`; rename or remove one of the files",
                other.source.path.display(),
                version.name
            );
            let double_of = Some(other.source.clone());
            return self.refuse(&source.name(), source, double_of, &why);
        }
        let generation = match before.entries.get(&version.name) {
            Some(Entry { version: Some(old), generation, .. }) if Arc::ptr_eq(old, version) => *generation,
            _ => before.generations.get(&version.name).map_or(1, |last| last.saturating_add(1)),
        };
        self.generations.insert(version.name.clone(), generation);
        let entry = self.entries.entry(version.name.clone()).or_default();
        (entry.version, entry.generation) = (Some(version.clone()), generation);
    }

    /// Records that `source` cannot be loaded. The version that was loaded from it before stays served.
    fn miss(&mut self, source: &DatabaseSource, why: &str, before: &Self) {
        let free = |name: &str| self.entries.get(name).is_none_or(|entry| entry.version.is_none());
        match before.at(source).filter(|old| free(&old.name)) {
            Some(old) => {
                self.put(source, old, before);
                self.refuse(&old.name, source, None, why);
            }
            None => self.refuse(&source.name(), source, None, why),
        }
    }

    /// Records under `name` why `source` is not served; `double_of` is the file that holds the same object, if that is why.
    fn refuse(&mut self, name: &str, source: &DatabaseSource, double_of: Option<DatabaseSource>, why: &str) {
        let path = &source.path;
        let entry = self.entries.entry(name.to_owned()).or_default();
        let served = entry.version.is_some();
        tracing::error!(object = name, path = %path.display(), why, served, "a database cannot be loaded");
        let message = format!("{}: {why}", path.file_name().unwrap_or_default().to_string_lossy());
        let error = Error::new(ErrorKind::CorruptObject, name, message);
        entry.refusal.get_or_insert(Refusal { source: source.clone(), double_of, error });
    }

    /// Error for a name that no entry has.
    fn unknown(&self, name: &str) -> Error {
        let mut loading = self.entries.iter().filter_map(|(file, entry)| Some((file, entry.loading.as_ref()?)));
        if let Some((file, loading)) = loading.next() {
            return loading.error_of_unknown(name, file);
        }
        let served = self.entries.iter().filter(|(_, entry)| entry.version.is_some());
        unknown_object(name, &served.map(|(name, _)| name.as_str()).collect::<Vec<_>>())
    }

    /// The object `name`, or the reason why it is not served.
    pub fn get(&self, name: &str) -> Result<Arc<dyn ServedObject>, Error> {
        match self.entries.get(name) {
            Some(Entry { version: Some(version), .. }) => Ok(version.object.clone()),
            Some(Entry { loading: Some(loading), .. }) => Err(loading.error(name)),
            Some(Entry { refusal: Some(refusal), .. }) => Err(refusal.error.clone()),
            _ => Err(self.unknown(name)),
        }
    }

    /// Rows for `list`, from position `first` on, at most `count`.
    pub fn rows(&self, first: usize, count: usize) -> Vec<ObjectRow> {
        self.entries.iter().skip(first).take(count).map(|(name, entry)| entry.row(name)).collect()
    }

    /// Number of entries, loaded or not.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is no entry at all.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Number of objects that are served.
    pub fn ready(&self) -> usize {
        self.versions().count()
    }

    /// Number of objects that are being loaded and not served yet.
    pub fn loading(&self) -> usize {
        self.entries.values().filter(|entry| entry.version.is_none() && entry.loading.is_some()).count()
    }

    /// Number of objects that could not be loaded.
    pub fn failed(&self) -> usize {
        self.len() - self.ready() - self.loading()
    }

    /// Number of objects that are served from an older version, because their current files cannot be loaded.
    pub fn outdated(&self) -> usize {
        self.entries.values().filter(|entry| entry.version.is_some() && entry.refusal.is_some()).count()
    }

    /// Memory of the objects, bytes.
    pub fn memory_bytes(&self) -> u64 {
        self.versions().map(|version| version.memory_bytes()).sum()
    }

    /// Folder snapshot from which this catalog was built.
    pub fn snapshot(&self) -> &DirectorySnapshot {
        &self.snapshot
    }

    /// Time at which the catalog was built.
    pub fn read(&self) -> SystemTime {
        self.read
    }

    /// Size of the largest result that any object may produce, bytes.
    pub fn result_bytes_max(&self) -> usize {
        self.versions().map(|version| version.object.result_bytes_max()).max().unwrap_or(0)
    }
}

impl Entry {
    fn is_empty(&self) -> bool {
        self.version.is_none() && self.refusal.is_none() && self.loading.is_none()
    }

    fn row(&self, name: &str) -> ObjectRow {
        let mut row = ObjectRow::zeroed();
        match &self.version {
            Some(version) => row = version.row(self.generation),
            None => row.set_name(name),
        }
        if let Some(refusal) = &self.refusal {
            row.error = ErrorWire::from(&refusal.error);
        }
        if let (None, Some(loading)) = (&self.version, &self.loading) {
            (row.state, row.error) = (ObjectState::Loading as u32, ErrorWire::from(&loading.error(name)));
        }
        row
    }
}

#[cfg(test)]
mod tests;
