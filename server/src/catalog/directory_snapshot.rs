//! Snapshot of the database folder: paths and file stamps, without opening a file.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use shatter_proto::{Error, ErrorKind};
use std::collections::BTreeMap;
use std::fs::Metadata;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Extension of database files.
pub(super) const EXTENSION: &str = "shatter";

/// Identity of one version of a file.
///
/// It includes the time of the last status change, which no program can set: a file that was overwritten and given its old modification
/// time is another version.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FileStamp {
    device: u64,
    inode: u64,
    bytes: u64,
    modified: (i64, i64),
    changed: (i64, i64),
}

impl From<&Metadata> for FileStamp {
    fn from(data: &Metadata) -> Self {
        Self {
            device: data.dev(),
            inode: data.ino(),
            bytes: data.len(),
            modified: (data.mtime(), data.mtime_nsec()),
            changed: (data.ctime(), data.ctime_nsec()),
        }
    }
}

impl FileStamp {
    /// Stamp of a file; `None` if it no longer exists. A dangling symbolic link has a stamp, so that loading it reports the error.
    pub(super) fn of(path: &Path) -> Option<Self> {
        match std::fs::metadata(path) {
            Ok(data) => Some(Self::from(&data)),
            Err(_) => std::fs::symlink_metadata(path).ok().map(|_| Self::default()),
        }
    }

    /// Length of the file, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// Source of a catalog entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatabaseSource {
    /// Database file.
    pub path: PathBuf,
    /// Scene object that the database becomes; `None`: there is no scene, and the database holds the name.
    pub object: Option<String>,
}

impl DatabaseSource {
    /// Name of the entry while the file's contents are unknown.
    pub(super) fn name(&self) -> String {
        self.object.clone().unwrap_or_else(|| stem(&self.path))
    }
}

/// Databases of a folder at one moment, sorted by path, so that of several files with one name always the same one is used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DirectorySnapshot(Vec<(DatabaseSource, FileStamp)>);

impl DirectorySnapshot {
    /// Lists the databases of `folder`. Hidden files (with a leading dot) are none: other programs give their temporary files such names.
    ///
    /// # Errors
    /// `database_folder`.
    pub fn of(folder: &Path) -> Result<Self, Error> {
        let refuse = |error: io::Error| {
            let at = folder.display().to_string();
            let message = format!(
                "cannot read the folder of databases {at}: {error}; `shatterd bake --out DIR` makes one, --databases DIR names it"
            );
            Error::new(ErrorKind::DatabaseFolder, at, message)
        };
        let mut files = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(refuse)? {
            let path = entry.map_err(refuse)?.path();
            if is_database(&path) {
                files.extend(FileStamp::of(&path).map(|stamp| (path, stamp)));
            }
        }
        files.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(Self(files.into_iter().map(|(path, stamp)| (DatabaseSource { path, object: None }, stamp)).collect()))
    }

    /// Restricts the snapshot to a scene: repeats each file once for each of the `objects` that names it, and drops the others.
    #[must_use]
    pub fn only(self, objects: &BTreeMap<String, String>) -> Self {
        let cast = |(file, stamp): (DatabaseSource, FileStamp)| {
            let own = objects.iter().filter(|(_, database)| **database == stem(&file.path)).map(|(object, _)| object);
            own.map(|object| (DatabaseSource { object: Some(object.clone()), ..file.clone() }, stamp))
                .collect::<Vec<_>>()
        };
        Self(self.0.into_iter().flat_map(cast).collect())
    }

    /// Files that `other` lacks or holds in another version.
    pub(super) fn missing_from<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = &'a (DatabaseSource, FileStamp)> {
        self.0.iter().filter(|file| !other.0.contains(file))
    }

    /// This snapshot with another version of a file.
    pub(super) fn with(&self, source: &DatabaseSource, stamp: FileStamp) -> Self {
        let mut files: Vec<_> = self.0.iter().filter(|(own, _)| own != source).cloned().collect();
        let place = files.partition_point(|(own, _)| (&own.path, &own.object) < (&source.path, &source.object));
        files.insert(place, (source.clone(), stamp));
        Self(files)
    }

    /// Whether there is a database of that name.
    pub fn holds(&self, name: &str) -> bool {
        self.0.iter().any(|(source, _)| stem(&source.path) == name)
    }

    /// Names of all databases, sorted by path.
    pub fn names(&self) -> Vec<String> {
        self.0.iter().map(|(source, _)| stem(&source.path)).collect()
    }

    /// This snapshot without the files that `is_dropped` selects.
    pub(super) fn without(&self, is_dropped: impl Fn(&DatabaseSource) -> bool) -> Self {
        Self(self.0.iter().filter(|(source, _)| !is_dropped(source)).cloned().collect())
    }

    /// Whether a file is in it, in any version.
    pub(super) fn has_source(&self, source: &DatabaseSource) -> bool {
        let key = (&source.path, &source.object);
        self.0.binary_search_by(|(own, _)| (&own.path, &own.object).cmp(&key)).is_ok()
    }

    /// Whether a file is in it, in this version.
    pub(super) fn has(&self, file: &(DatabaseSource, FileStamp)) -> bool {
        self.0.contains(file)
    }

    /// Whether the name of an entry, while the contents of its file are unknown, is `name`.
    pub(super) fn has_name(&self, name: &str) -> bool {
        self.0.iter().any(|(source, _)| source.name() == name)
    }

    /// Calls `each` for every file on the current rayon pool, first for those that `is_first` selects; the results are in the order of the
    /// files.
    pub(super) fn map<T: Send>(
        &self,
        is_first: impl Fn(&(DatabaseSource, FileStamp)) -> bool,
        each: impl Fn(&DatabaseSource, FileStamp) -> T + Sync,
    ) -> Vec<T> {
        let (first, others): (Vec<usize>, Vec<usize>) = (0..self.0.len()).partition(|&place| is_first(&self.0[place]));
        let run = |places: Vec<usize>| -> Vec<(usize, T)> {
            let each = |place: usize| (place, each(&self.0[place].0, self.0[place].1));
            places.into_par_iter().map(each).collect()
        };
        let mut results = run(first);
        results.extend(run(others));
        results.sort_by_key(|(place, _)| *place);
        results.into_iter().map(|(_, result)| result).collect()
    }
}

/// Whether a leading dot hides a file.
pub fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

/// Whether the name of a file is that of a database: it ends with `.shatter` and is not hidden.
pub fn is_database(path: &Path) -> bool {
    !is_hidden(path) && path.extension().is_some_and(|extension| extension == EXTENSION)
}

/// File name without extension.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn any_change_of_a_database_shows_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let scan = || DirectorySnapshot::of(folder.path()).unwrap();
        assert_eq!(scan(), DirectorySnapshot::default());
        let mut last = scan();
        let mut changes = |what: &str, wanted: bool| {
            let now = scan();
            assert_eq!(now != last, wanted, "{what}");
            last = now;
        };
        fs::write(at("a.shatter"), "one").unwrap();
        changes("a file appears", true);
        changes("nothing happens", false);
        fs::write(at("notes.txt"), "x").unwrap();
        fs::write(at(".shatter-x.part"), "x").unwrap();
        fs::write(at(".hid.shatter"), "x").unwrap();
        changes("other files appear", false);
        fs::write(at("aside"), "two").unwrap();
        let dated = fs::metadata(at("a.shatter")).unwrap().modified().unwrap();
        fs::File::options().write(true).open(at("aside")).unwrap().set_modified(dated).unwrap();
        fs::rename(at("aside"), at("a.shatter")).unwrap();
        changes("another file of the same size and date takes its place", true);
        std::os::unix::fs::symlink(at("nowhere"), at("b.shatter")).unwrap();
        changes("a link to nowhere appears", true);
        fs::remove_file(at("a.shatter")).unwrap();
        changes("a file is removed", true);
    }

    #[test]
    fn a_missing_folder_is_refused_by_name() {
        let error = DirectorySnapshot::of(Path::new("/nowhere/at all")).err().unwrap();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::DatabaseFolder, "/nowhere/at all"));
    }
}
