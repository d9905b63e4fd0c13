//! Folders and files of a service. Pure rules that both sides share, so that services of different names, users and
//! runtime folders never meet. What changes with each daemon is an [`Instance`](crate::instance::Instance).

use crate::instance::DIGITS;
use shatter_proto::name::ServiceName;
use shatter_proto::{Error, ErrorKind};
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Paths of a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServicePaths {
    /// The service.
    pub service: ServiceName,
    /// The user who owns everything here.
    pub uid: u32,
    /// The service's own folder.
    pub folder: PathBuf,
    /// First part of the names of its folders in shared memory: shows people where one comes from. Others may have the same.
    pub mark: String,
    /// Whether the folder lies in one that all users share.
    is_shared: bool,
}

impl ServicePaths {
    /// The place of `service` for user `uid`, under `runtime` (`XDG_RUNTIME_DIR`) if that is an absolute path.
    pub fn new(service: &ServiceName, runtime: Option<&Path>, uid: u32) -> Self {
        let runtime = runtime.filter(|runtime| runtime.is_absolute()).map(|runtime| runtime.join("shatter"));
        let folder = match &runtime {
            Some(base) => base.join(service.as_str()),
            None => PathBuf::from(format!("/tmp/shatter-{uid}")).join(service.as_str()),
        };
        Self::of_folder(service.clone(), uid, folder, runtime.is_none())
    }

    fn of_folder(service: ServiceName, uid: u32, folder: PathBuf, is_shared: bool) -> Self {
        let mark = format!("sh_{}", short_hash(folder.as_os_str().as_bytes(), uid));
        Self { service, uid, folder, mark, is_shared }
    }

    /// The other services of the user that have a folder, in no order. Their daemons may have ended.
    pub fn others(&self) -> impl Iterator<Item = Self> {
        let base = self.folder.parent().map(Path::to_path_buf).unwrap_or_default();
        let entries = std::fs::read_dir(&base).into_iter().flatten().flatten();
        let services = entries.filter_map(|entry| ServiceName::new(entry.file_name().to_str()?).ok());
        let (own, uid, is_shared) = (self.service.clone(), self.uid, self.is_shared);
        let others = services.filter(move |service| *service != own);
        others.map(move |service| {
            let folder = base.join(service.as_str());
            Self::of_folder(service, uid, folder, is_shared)
        })
    }

    /// Command that starts a daemon of the service, for messages.
    pub fn start_command(&self) -> String {
        format!("shatterd serve --service {}", self.service.as_str())
    }

    /// The file that a daemon holds locked while it lives.
    pub fn lock(&self) -> PathBuf {
        self.folder.join("lock")
    }

    /// The [`crate::daemon_info::DaemonInfo`].
    pub fn hello(&self) -> PathBuf {
        self.folder.join("hello.json")
    }

    /// The metrics as text.
    pub fn metrics(&self) -> PathBuf {
        self.folder.join("metrics.txt")
    }

    /// File with the daemon's record of earlier daemons.
    pub fn past(&self) -> PathBuf {
        self.folder.join("past.json")
    }

    /// The tokens of the instances whose files may be left.
    pub fn instances(&self) -> PathBuf {
        self.folder.join("instances.json")
    }

    /// Creates the folder for its owner alone, and checks it if it exists.
    ///
    /// # Errors
    /// `runtime_folder`: a folder cannot be created, belongs to another user, or is open to others.
    pub fn create(&self) -> Result<(), Error> {
        self.make_private().map_err(|error| self.advised(error))
    }

    fn make_private(&self) -> Result<(), Error> {
        if let Some(parent) = self.folder.parent() {
            make(parent)?;
            trusted(parent, self.uid)?;
            parent.parent().map_or(Ok(()), |above| steady(above, self.uid))?;
        }
        make(&self.folder)?;
        trusted(&self.folder, self.uid)
    }

    /// Whether there is anything at all, in a folder that belongs to the user alone.
    ///
    /// # Errors
    /// `runtime_folder`: a folder belongs to another user, or is open to others.
    pub fn exists(&self) -> Result<bool, Error> {
        self.is_there().map_err(|error| self.advised(error))
    }

    fn is_there(&self) -> Result<bool, Error> {
        // What lies in a folder of another user may not even be looked at, so the outer folder comes first.
        for folder in self.folder.parent().into_iter().chain([self.folder.as_path()]) {
            match folder.symlink_metadata() {
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
                _ => trusted(folder, self.uid)?,
            }
        }
        // As the daemon does: who may rename in the folder above can put another runtime folder in its place.
        let above = self.folder.parent().and_then(Path::parent);
        above.map_or(Ok(()), |above| steady(above, self.uid))?;
        Ok(true)
    }

    /// `error`, and what to do about it.
    fn advised(&self, error: Error) -> Error {
        let remedy = if self.is_shared { "set XDG_RUNTIME_DIR" } else { "correct that folder, or set XDG_RUNTIME_DIR" };
        let message = format!(
            "{}; {remedy}, for the daemon and its clients, to the absolute path of a folder that only you can open and write to",
            error.message
        );
        Error { message, ..error }
    }
}

/// Creates one folder that was not there, for its owner alone.
pub(crate) fn create_private(folder: &Path) -> Result<(), Error> {
    create(std::fs::DirBuilder::new().mode(0o700), folder)
}

fn make(folder: &Path) -> Result<(), Error> {
    create(std::fs::DirBuilder::new().recursive(true).mode(0o700), folder)
}

fn create(builder: &std::fs::DirBuilder, folder: &Path) -> Result<(), Error> {
    builder.create(folder).map_err(|error| {
        let message = format!("cannot create the runtime folder {}: {error}", folder.display());
        Error::new(ErrorKind::RuntimeFolder, folder.display().to_string(), message)
    })
}

/// A folder in which others cannot put something else in the place of what is the user's.
fn steady(folder: &Path, uid: u32) -> Result<(), Error> {
    const STICKY: u32 = 0o1000;
    let refuse = |what: String| {
        let message = format!("the folder {} above the runtime folder {what}", folder.display());
        Err(Error::new(ErrorKind::RuntimeFolder, folder.display().to_string(), message))
    };
    match folder.metadata() {
        Err(error) => refuse(format!("cannot be read: {error}")),
        Ok(data) if data.uid() != uid && data.uid() != 0 => refuse(format!("belongs to user {}", data.uid())),
        Ok(data) if data.mode() & 0o022 != 0 && data.mode() & STICKY == 0 => {
            refuse(format!("can be changed by others (mode {:o})", data.mode() & 0o7777))
        }
        Ok(_) => Ok(()),
    }
}

/// A real folder, owned by the user, closed to everyone else: `/tmp` is open to all, and names in it can be guessed.
pub(crate) fn trusted(folder: &Path, uid: u32) -> Result<(), Error> {
    let refuse = |what: String| {
        let message = format!("the runtime folder {} {what}", folder.display());
        Err(Error::new(ErrorKind::RuntimeFolder, folder.display().to_string(), message))
    };
    match folder.symlink_metadata() {
        Err(error) => refuse(format!("cannot be read: {error}")),
        Ok(data) if !data.is_dir() => refuse("is not a folder".into()),
        Ok(data) if data.uid() != uid => refuse(format!("belongs to user {}, not to {uid}", data.uid())),
        Ok(data) if data.mode() & 0o077 != 0 => refuse(format!("is open to others (mode {:o})", data.mode() & 0o777)),
        Ok(_) => Ok(()),
    }
}

/// Four digits of FNV-1a (Fowler, Noll & Vo 1991), which tell places apart to people, no more.
fn short_hash(bytes: &[u8], uid: u32) -> String {
    let fold = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325, fold);
    let mut hash = uid.to_le_bytes().iter().fold(hash, fold) >> 24;
    let digit = |_| {
        let digit = DIGITS[(hash % 36) as usize];
        hash /= 36;
        char::from(digit)
    };
    (0..4).map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(name: &str, runtime: &str, uid: u32) -> ServicePaths {
        ServicePaths::new(&ServiceName::new(name).unwrap(), Some(Path::new(runtime)), uid)
    }

    #[test]
    fn services_users_and_folders_are_kept_apart() {
        let all = [place("a", "/r", 1), place("b", "/r", 1), place("a", "/s", 1), place("a", "/r", 2)];
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                assert!(a.mark != b.mark && a.folder != b.folder || a.uid != b.uid, "{a:?} {b:?}");
            }
        }
        assert_eq!(place("a", "/r", 1).folder, Path::new("/r/shatter/a"));
        assert_eq!(place("a", "relative", 7).folder, Path::new("/tmp/shatter-7/a"));
    }

    #[test]
    fn folders_of_others_are_refused() {
        let root = std::env::temp_dir().join(format!("shatter-place-{}", std::process::id()));
        std::fs::create_dir_all(&root).unwrap();
        let uid = root.metadata().unwrap().uid();
        let here = ServicePaths::new(&ServiceName::new("a").unwrap(), Some(&root), uid);
        assert_eq!(here.exists(), Ok(false));
        here.create().unwrap();
        assert_eq!(here.exists(), Ok(true));
        let other = ServicePaths { uid: uid + 1, ..here.clone() };
        let error = other.exists().unwrap_err();
        assert_eq!(error.kind, ErrorKind::RuntimeFolder);
        assert!(error.message.contains("; correct that folder, or set XDG_RUNTIME_DIR, for the daemon"), "{error}");
        let shared = ServicePaths { is_shared: true, ..other };
        for error in [shared.exists().unwrap_err(), shared.create().unwrap_err()] {
            assert!(error.message.contains("XDG_RUNTIME_DIR"), "{error}");
            assert!(error.message.contains(&format!("belongs to user {uid}, not to {}", uid + 1)), "{error}");
        }
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&root, std::fs::Permissions::from_mode(0o777)).unwrap();
        let error = here.exists().unwrap_err();
        assert!(error.message.contains("can be changed by others (mode 777)"), "{error}");
        std::fs::set_permissions(&root, std::fs::Permissions::from_mode(0o700)).unwrap();
        std::fs::set_permissions(&here.folder, std::fs::Permissions::from_mode(0o755)).unwrap();
        assert_eq!(here.exists().unwrap_err().kind, ErrorKind::RuntimeFolder);
        std::fs::remove_dir_all(&root).unwrap();
    }
}
