//! The objects of the service. A database that cannot be loaded is logged and listed with its error; the others are served. A scene
//! may make several objects of one database: each is an entry of its own, loaded by itself.
//!
//! A catalog never changes: a reload makes another one of it, in which what lies in the folder unchanged is kept, and which
//! takes its place whole. Strikes hold on to the version that they began with.

mod directory_snapshot;
mod load_in_progress;
mod retired_versions;
mod version;

pub use directory_snapshot::{DatabaseSource, DirectorySnapshot};
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
    shelf: DirectorySnapshot,
    read: SystemTime,
}

/// What a name stands for.
#[derive(Clone, Default)]
struct Entry {
    /// What is served.
    version: Option<Arc<ObjectVersion>>,
    /// How many versions of this name there were, this one counted.
    generation: u32,
    /// Why there is none, or why what lies in its place now is not served.
    refusal: Option<Error>,
    /// There is none yet: its database is being loaded.
    loading: Option<LoadInProgress>,
}

impl Default for Catalog {
    fn default() -> Self {
        Self { entries: BTreeMap::new(), shelf: DirectorySnapshot::default(), read: SystemTime::now() }
    }
}

impl Catalog {
    /// The catalog of `shelf`, on the current rayon pool. Versions whose files did not change are kept; files that failed
    /// are tried again, and one that took the place of a version and fails leaves that version served.
    #[must_use]
    pub fn renewed(&self, shelf: DirectorySnapshot, loader: &Loader) -> Self {
        let found = shelf.map(|source, stamp| match self.at(source) {
            Some(version) if version.stamp == stamp => (source.clone(), Ok(version.clone())),
            _ => (source.clone(), ObjectVersion::load(source, stamp, loader).map(Arc::new)),
        });
        let mut catalog = Self { entries: BTreeMap::new(), shelf, read: SystemTime::now() };
        let mut loaded: Vec<_> =
            found.iter().filter_map(|(source, version)| Some((source, version.as_ref().ok()?))).collect();
        // A name that several files hold goes to the file of that name, where bakes write; else to the one that had it. Copies
        // take nothing away.
        loaded.sort_by_key(|(source, version)| (source.name() != version.name, !self.serves(source, &version.name)));
        for (source, version) in loaded {
            catalog.put(source, version, self);
        }
        // Last, so that a version whose place was spoilt takes no name away from one that was not.
        for (source, version) in &found {
            if let Err(why) = version {
                catalog.miss(source, why, self);
            }
        }
        catalog
    }

    /// This catalog with the new databases of `seen` listed as being loaded; `None` if it lists the same ones already.
    pub fn expecting(&self, seen: &DirectorySnapshot) -> Option<Self> {
        let new: Vec<_> = seen.missing_from(&self.shelf).filter(|(source, _)| self.at(source).is_none()).collect();
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
            // One that is listed already began earlier.
            entries.entry(name).or_default().loading.get_or_insert(loading);
        }
        entries.retain(|_, entry| entry.version.is_some() || entry.refusal.is_some() || entry.loading.is_some());
        Some(Self { entries, shelf: self.shelf.clone(), read: self.read })
    }

    /// Whether the object `name` is the one from `source`.
    fn serves(&self, source: &DatabaseSource, name: &str) -> bool {
        self.at(source).is_some_and(|version| version.name == name)
    }

    /// The version that was loaded from `source`.
    fn at(&self, source: &DatabaseSource) -> Option<&Arc<ObjectVersion>> {
        self.versions().find(|version| version.source == *source)
    }

    /// Everything that can be struck.
    pub fn versions(&self) -> impl Iterator<Item = &Arc<ObjectVersion>> {
        self.entries.values().filter_map(|entry| entry.version.as_ref())
    }

    /// Takes `version` in under its name, unless another file has it.
    fn put(&mut self, source: &DatabaseSource, version: &Arc<ObjectVersion>, before: &Self) {
        if let Some(other) = self.entries.get(&version.name).and_then(|entry| entry.version.as_ref()) {
            let why = format!("{} already holds an object `{}`", other.source.path.display(), version.name);
            return self.refuse(&source.name(), source, &why);
        }
        let generation = match before.entries.get(&version.name) {
            Some(Entry { version: Some(old), generation, .. }) if Arc::ptr_eq(old, version) => *generation,
            Some(Entry { generation, .. }) => generation + 1,
            None => 1,
        };
        let entry = self.entries.entry(version.name.clone()).or_default();
        (entry.version, entry.generation) = (Some(version.clone()), generation);
    }

    /// `source` cannot be loaded. What was loaded from that place before is served on.
    fn miss(&mut self, source: &DatabaseSource, why: &str, before: &Self) {
        let free = |name: &str| self.entries.get(name).is_none_or(|entry| entry.version.is_none());
        match before.at(source).filter(|old| free(&old.name)) {
            Some(old) => {
                self.put(source, old, before);
                self.refuse(&old.name, source, why);
            }
            None => self.refuse(&source.name(), source, why),
        }
    }

    /// Lists under `name` that `source` is not served.
    fn refuse(&mut self, name: &str, source: &DatabaseSource, why: &str) {
        let path = &source.path;
        let entry = self.entries.entry(name.to_owned()).or_default();
        let served = entry.version.is_some();
        tracing::error!(object = name, path = %path.display(), why, served, "cannot be loaded");
        let message = format!("{}: {why}", path.file_name().unwrap_or_default().to_string_lossy());
        entry.refusal.get_or_insert(Error::new(ErrorKind::CorruptObject, name, message));
    }

    /// The object `name`, or why there is none.
    pub fn get(&self, name: &str) -> Result<Arc<dyn ServedObject>, Error> {
        match self.entries.get(name) {
            Some(Entry { version: Some(version), .. }) => Ok(version.object.clone()),
            Some(Entry { loading: Some(loading), .. }) => Err(loading.refusal(name)),
            Some(Entry { refusal: Some(refusal), .. }) => Err(refusal.clone()),
            _ => {
                let names: Vec<&str> = self.entries.keys().map(String::as_str).collect();
                Err(unknown_object(name, &names))
            }
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

    /// Number of objects that can be struck.
    pub fn ready(&self) -> usize {
        self.versions().count()
    }

    /// Number of objects whose databases are being loaded and that cannot be struck before.
    pub fn loading(&self) -> usize {
        self.entries.values().filter(|entry| entry.version.is_none() && entry.loading.is_some()).count()
    }

    /// Number of objects that could not be loaded.
    pub fn failed(&self) -> usize {
        self.len() - self.ready() - self.loading()
    }

    /// Number of objects that can be struck, but are not what lies in their place now.
    pub fn outdated(&self) -> usize {
        self.entries.values().filter(|entry| entry.version.is_some() && entry.refusal.is_some()).count()
    }

    /// Bytes of memory that the objects hold.
    pub fn memory_bytes(&self) -> u64 {
        self.versions().map(|version| version.memory_bytes()).sum()
    }

    /// The folder as it was when this catalog was made.
    pub fn shelf(&self) -> &DirectorySnapshot {
        &self.shelf
    }

    /// When it was made.
    pub fn read(&self) -> SystemTime {
        self.read
    }

    /// Bytes of the largest answer that any object may give.
    pub fn answer_bytes_max(&self) -> usize {
        self.versions().map(|version| version.object.answer_bytes_max()).max().unwrap_or(0)
    }
}

impl Entry {
    fn row(&self, name: &str) -> ObjectRow {
        let mut row = ObjectRow::zeroed();
        match &self.version {
            Some(version) => row = version.row(self.generation),
            None => row.set_name(name),
        }
        if let Some(refusal) = &self.refusal {
            row.refusal = ErrorWire::from(refusal);
        }
        if let (None, Some(loading)) = (&self.version, &self.loading) {
            (row.state, row.refusal) = (ObjectState::Loading as u32, ErrorWire::from(&loading.refusal(name)));
        }
        row
    }
}

#[cfg(test)]
mod tests;
