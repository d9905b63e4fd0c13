//! Location of the transport of one daemon process: a private folder in shared memory, under a random name.
//!
//! Shared memory has one folder for all users of a machine, and another user who knows a name beforehand can take it. So a daemon
//! draws a random name when it starts, keeps everything in a folder of that name which is closed to others, and tells the name in
//! its private runtime folder: to clients in its lock file and its [`DaemonInfo`], to its successor in a list of the instances whose
//! files may be left.

use crate::daemon_info::DaemonInfo;
use crate::paths::{ServicePaths, create_private, trusted};
use crate::regular_file;
use shatter_proto::{Error, ErrorKind};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The folder of shared memory, one for all users.
pub const SHARED_MEMORY: &str = "/dev/shm";

/// Digits of a token, of 36 each: 57 bits, too many to try out.
const TOKEN_DIGITS: usize = 11;

/// The digits of tokens and marks.
pub(crate) const DIGITS: &[u8; 36] = b"0123456789abcdefghijklmnopqrstuvwxyz";

/// Location of the transport of one daemon process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    /// Random token that distinguishes it from other instances of the service.
    pub token: String,
    /// Folder of the transport's segments, sockets and other files.
    pub folder: PathBuf,
}

/// A random word.
///
/// # Errors
/// `runtime_folder` where there is no source of random numbers.
pub fn random_token() -> Result<String, Error> {
    let source = Path::new("/dev/urandom");
    let mut bytes = [0; TOKEN_DIGITS];
    File::open(source).and_then(|mut file| file.read_exact(&mut bytes)).map_err(|error| {
        let at = source.display().to_string();
        Error::new(ErrorKind::RuntimeFolder, at.clone(), format!("cannot read {at}: {error}"))
    })?;
    Ok(bytes.iter().map(|byte| char::from(DIGITS[usize::from(*byte) % DIGITS.len()])).collect())
}

impl Instance {
    /// Creates an instance at `paths` under a new random name.
    ///
    /// # Errors
    /// As of [`random_token`].
    pub fn random(paths: &ServicePaths) -> Result<Self, Error> {
        Ok(Self::named(paths, random_token()?))
    }

    /// The one at `paths` that has this token; `None` for what is no token.
    pub fn of_token(paths: &ServicePaths, token: &str) -> Option<Self> {
        let valid = token.len() == TOKEN_DIGITS && token.bytes().all(|digit| DIGITS.contains(&digit));
        valid.then(|| Self::named(paths, token.to_owned()))
    }

    /// The one of the daemon that serves at `paths` now.
    ///
    /// # Errors
    /// `no_daemon`, `version_mismatch`.
    pub fn serving(paths: &ServicePaths) -> Result<Self, Error> {
        let none = |why: String| Error::new(ErrorKind::NoDaemon, paths.service.as_str(), why);
        let path = paths.hello();
        let json = regular_file::read(&path).map_err(|error| none(format!("{}: {error}", path.display())))?;
        let hello = DaemonInfo::from_json(&json)?;
        hello.check()?;
        Self::of_token(paths, &hello.instance).ok_or_else(|| none(format!("{} names no instance", path.display())))
    }

    fn named(paths: &ServicePaths, token: String) -> Self {
        let folder = Path::new(SHARED_MEMORY).join(format!("{}{token}", paths.mark));
        Self { token, folder }
    }

    /// Creates the folder for its owner alone.
    ///
    /// # Errors
    /// `runtime_folder`: the folder cannot be created, or others can change it.
    pub fn create(&self, uid: u32) -> Result<(), Error> {
        create_private(&self.folder)?;
        self.check(uid)
    }

    /// Refuses a folder that others can change.
    ///
    /// # Errors
    /// `runtime_folder`.
    pub fn check(&self, uid: u32) -> Result<(), Error> {
        trusted(&self.folder, uid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PREFIX;
    use shatter_proto::name::ServiceName;

    fn paths(name: &str, runtime: &str, uid: u32) -> ServicePaths {
        ServicePaths::new(&ServiceName::new(name).unwrap(), Some(Path::new(runtime)), uid)
    }

    #[test]
    fn sockets_fit_into_their_paths() {
        let longest = "x".repeat(32);
        let deep = format!("/{}", "deep/".repeat(40));
        for runtime in ["/run/user/1000", "/run/user/4294967295", deep.as_str(), "relative"] {
            let instance = Instance::random(&paths(&longest, runtime, u32::MAX)).unwrap();
            let socket = format!("{}/{PREFIX}{}.event\0", instance.folder.display(), u128::MAX);
            assert!(socket.len() <= 108, "{socket}");
        }
    }

    #[test]
    fn no_two_starts_have_the_same_names() {
        let paths = paths("a", "/r", 1);
        let [a, b] = [(); 2].map(|()| Instance::random(&paths).unwrap());
        assert!(a.folder != b.folder && a.folder.display().to_string().contains(&paths.mark));
        assert_eq!(Instance::of_token(&paths, &a.token), Some(a));
        for token in ["", "short", "0123456789A", "0123456789ab", "../../../..", "01234567/9a"] {
            assert_eq!(Instance::of_token(&paths, token), None, "{token}");
        }
    }
}
