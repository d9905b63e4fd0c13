//! Where a service lives: folders, files and the prefix of its shared memory. Pure rules that both sides share, so that
//! services of different names, users and runtime folders never meet.

use crate::name::ServiceName;
use crate::{Kind, Refusal};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Longest transport folder, bytes. A Unix socket's path has 108, of which the folder's slash, the prefix (19), a port id
/// (39 digits), `.event` and the closing zero take 66.
const TRANSPORT_FOLDER_MAX: usize = 42;

/// Where a service lives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The service.
    pub service: ServiceName,
    /// The user who owns everything here.
    pub uid: u32,
    /// The service's own folder.
    pub folder: PathBuf,
    /// Folder of the transport's files, short enough for sockets and in memory: every file in it is synced when it is
    /// created, which takes seconds on a busy disk.
    pub transport: PathBuf,
    /// Prefix of the transport's files and shared memory.
    pub prefix: String,
}

impl Place {
    /// The place of `service` for user `uid`, under `runtime` (`XDG_RUNTIME_DIR`) if that is an absolute path.
    pub fn new(service: &ServiceName, runtime: Option<&Path>, uid: u32) -> Self {
        let runtime = runtime.filter(|runtime| runtime.is_absolute()).map(|runtime| runtime.join("shatter"));
        let folder = match &runtime {
            Some(base) => base.join(service.as_str()),
            None => PathBuf::from(format!("/tmp/shatter-{uid}")).join(service.as_str()),
        };
        let hash = short_hash(folder.as_os_str().as_bytes(), uid);
        let beside = runtime.map(|base| base.join(format!(".t-{hash}")));
        let short = beside.filter(|beside| beside.as_os_str().len() <= TRANSPORT_FOLDER_MAX);
        let transport = short.unwrap_or_else(|| PathBuf::from(format!("/dev/shm/shatter-{uid}/.t-{hash}")));
        Self { service: service.clone(), uid, folder, transport, prefix: format!("shatter_{hash}_") }
    }

    /// The file that a daemon holds locked while it lives.
    pub fn lock(&self) -> PathBuf {
        self.folder.join("lock")
    }

    /// The [`crate::hello::Hello`].
    pub fn hello(&self) -> PathBuf {
        self.folder.join("hello.json")
    }

    /// The metrics as text.
    pub fn metrics(&self) -> PathBuf {
        self.folder.join("metrics.txt")
    }

    /// What the daemon knows of those before it.
    pub fn past(&self) -> PathBuf {
        self.folder.join("past.json")
    }

    /// Creates the folders for their owner alone, and checks those that exist.
    pub fn create(&self) -> Result<(), Refusal> {
        for folder in [&self.folder, &self.transport] {
            if let Some(parent) = folder.parent() {
                make(parent)?;
                trusted(parent, self.uid)?;
                parent.parent().map_or(Ok(()), |above| steady(above, self.uid))?;
            }
            make(folder)?;
            trusted(folder, self.uid)?;
        }
        Ok(())
    }

    /// Whether there is anything at all, in folders that belong to the user alone.
    pub fn exists(&self) -> Result<bool, Refusal> {
        for folder in [&self.folder, &self.transport] {
            if folder.symlink_metadata().is_err() {
                return Ok(false);
            }
            folder.parent().map_or(Ok(()), |parent| trusted(parent, self.uid))?;
            trusted(folder, self.uid)?;
        }
        Ok(true)
    }
}

fn make(folder: &Path) -> Result<(), Refusal> {
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(folder).map_err(|error| {
        let message = format!("cannot create the runtime folder {}: {error}", folder.display());
        Refusal::new(Kind::RuntimeFolder, folder.display().to_string(), message)
    })
}

/// A folder in which others cannot put something else in the place of what is the user's.
fn steady(folder: &Path, uid: u32) -> Result<(), Refusal> {
    const STICKY: u32 = 0o1000;
    let refuse = |what: String| {
        let message = format!("the folder {} above the runtime folder {what}", folder.display());
        Err(Refusal::new(Kind::RuntimeFolder, folder.display().to_string(), message))
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
fn trusted(folder: &Path, uid: u32) -> Result<(), Refusal> {
    let refuse = |what: String| {
        let message = format!("the runtime folder {} {what}", folder.display());
        Err(Refusal::new(Kind::RuntimeFolder, folder.display().to_string(), message))
    };
    match folder.symlink_metadata() {
        Err(error) => refuse(format!("cannot be read: {error}")),
        Ok(data) if !data.is_dir() => refuse("is not a folder".into()),
        Ok(data) if data.uid() != uid => refuse(format!("belongs to user {}, not to {uid}", data.uid())),
        Ok(data) if data.mode() & 0o077 != 0 => refuse(format!("is open to others (mode {:o})", data.mode() & 0o777)),
        Ok(_) => Ok(()),
    }
}

/// Ten hexadecimal digits of FNV-1a (Fowler, Noll & Vo 1991), which tells places apart, no more.
fn short_hash(bytes: &[u8], uid: u32) -> String {
    let fold = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325, fold);
    let hash = uid.to_le_bytes().iter().fold(hash, fold);
    format!("{:010x}", hash >> 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(name: &str, runtime: &str, uid: u32) -> Place {
        Place::new(&ServiceName::new(name).unwrap(), Some(Path::new(runtime)), uid)
    }

    #[test]
    fn sockets_fit_into_their_paths() {
        let longest = "x".repeat(32);
        let deep = format!("/{}", "deep/".repeat(40));
        for runtime in ["/run/user/1000", "/run/user/4294967295", deep.as_str(), "relative"] {
            let place = place(&longest, runtime, u32::MAX);
            let socket = format!("{}/{}{}.event\0", place.transport.display(), place.prefix, u128::MAX);
            assert!(socket.len() <= 108, "{socket}");
        }
    }

    #[test]
    fn services_users_and_folders_are_kept_apart() {
        let all = [place("a", "/r", 1), place("b", "/r", 1), place("a", "/s", 1), place("a", "/r", 2)];
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                assert!(a.prefix != b.prefix && a.transport != b.transport, "{a:?} {b:?}");
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
        let here = Place::new(&ServiceName::new("a").unwrap(), Some(&root), uid);
        assert_eq!(here.exists(), Ok(false));
        here.create().unwrap();
        assert_eq!(here.exists(), Ok(true));
        let other = Place { uid: uid + 1, ..here.clone() };
        assert_eq!(other.exists().unwrap_err().kind, Kind::RuntimeFolder);
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&here.folder, std::fs::Permissions::from_mode(0o755)).unwrap();
        assert_eq!(here.exists().unwrap_err().kind, Kind::RuntimeFolder);
        std::fs::remove_dir_all(&root).unwrap();
    }
}
