//! Runtime directory of the daemon: one daemon per service name, and removal of files that dead daemons left.

use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};
use shatter_proto::{Error, ErrorKind};
use shatter_transport::daemon_info::DaemonInfo;
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use shatter_transport::private_folder::PrivateFolder;
use shatter_transport::regular_file;
use shatter_transport::workarounds::left_behind::remove_unused;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Number of attempts to take the lock, one second in total. Clients hold it for microseconds to check whether a daemon runs, and a
/// killed daemon holds it until the kernel has freed its memory.
const LOCK_TRIES: u32 = 100;
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// Counts of the daemons that served under this name before; failed starts do not count.
///
/// Stored in the runtime directory, and removed with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct RestartHistory {
    /// Number of daemons.
    pub restarts: u64,
    /// Number of daemons that were killed or crashed.
    pub crashes: u64,
}

impl RestartHistory {
    /// Reads the history that the last daemon wrote when it began to serve; empty if there is none or it cannot be read.
    fn read(paths: &ServicePaths) -> Self {
        regular_file::read(&paths.past()).ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
    }

    /// Adds one crash.
    fn with_crash(self) -> Self {
        Self { crashes: self.crashes.saturating_add(1), ..self }
    }

    /// Adds one daemon that served.
    fn with_restart(self) -> Self {
        Self { restarts: self.restarts.saturating_add(1), ..self }
    }

    /// Writes the history for the next daemon. A failure loses only the history.
    fn write(self, paths: &ServicePaths, runtime: &PrivateFolder) {
        let written = serde_json::to_vec(&self).map(|json| write(runtime, &paths.past(), &json));
        if !matches!(written, Ok(Ok(()))) {
            tracing::warn!("cannot write to the runtime folder: this restart is not counted");
        }
    }
}

/// Runtime directory of a running daemon. Dropping it releases the service name.
pub struct RuntimeDirectory {
    paths: ServicePaths,
    instance: Instance,
    /// Earlier instances with remaining files.
    earlier: Vec<Instance>,
    past: RestartHistory,
    /// Runtime folder and folder of the instance; the daemon stops using either once another folder has replaced it.
    runtime: PrivateFolder,
    segments: PrivateFolder,
    /// Whether the service is announced to clients.
    is_announced: AtomicBool,
    lock: File,
}

impl RuntimeDirectory {
    /// Takes the service name, then removes the files of killed predecessors.
    ///
    /// The kernel releases the lock whenever the process ends.
    ///
    /// # Errors
    /// `second_daemon`, `runtime_folder`.
    pub fn take(paths: &ServicePaths) -> Result<Self, Error> {
        paths.create()?;
        let runtime = PrivateFolder::open(&paths.folder, paths.uid)?;
        let instance = Instance::random(paths)?;
        let lock = lock(paths, &instance)?;
        let mut past = RestartHistory::read(paths);
        if paths.hello().exists() {
            // Written now: if this start fails, the next one finds no hello file.
            past = past.with_crash();
            past.write(paths, &runtime);
        }
        // A stale hello file would make clients connect before the services exist.
        let _ = fs::remove_file(paths.hello());
        let earlier = listed(paths);
        // Listed before any of its files exists: if this process is killed, its successor knows where to look for files.
        let all: Vec<Instance> = earlier.iter().chain([&instance]).cloned().collect();
        write_list(paths, &runtime, &all)?;
        instance.create(paths.uid)?;
        let segments = PrivateFolder::open(&instance.folder, paths.uid)?;
        let is_announced = AtomicBool::new(false);
        let mut directory =
            Self { paths: paths.clone(), instance, earlier, past, runtime, segments, is_announced, lock };
        directory.sweep();
        Ok(directory)
    }

    /// Paths of the service.
    pub fn paths(&self) -> &ServicePaths {
        &self.paths
    }

    /// Transport instance of this daemon.
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Counts of earlier daemons.
    pub fn past(&self) -> RestartHistory {
        self.past
    }

    /// Announces the service to clients: protocol version and instance. The first call counts this daemon in the history.
    ///
    /// # Errors
    /// `runtime_folder` if the file cannot be written.
    pub fn announce(&self) -> Result<(), Error> {
        let hello = DaemonInfo::ours(std::process::id(), &self.instance.token).to_json();
        if !self.is_announced.swap(true, Ordering::Relaxed) {
            self.past.with_restart().write(&self.paths, &self.runtime);
        }
        write(&self.runtime, &self.paths.hello(), hello.as_bytes())
    }

    /// Whether the transport's folder is still the one that this daemon created; a replacement is neither cleaned up nor read.
    pub fn has_segments(&self) -> bool {
        self.segments.check().is_ok()
    }

    /// Checks whether clients can find the daemon, and writes the hello file again if it was removed. Errors: `runtime_folder`, after
    /// which the daemon must be restarted.
    ///
    /// # Errors
    /// `runtime_folder`, which a restart mends.
    pub fn check(&self) -> Result<(), Error> {
        let advised = |error: Error| Error { message: format!("{}; restart the daemon", error.message), ..error };
        self.runtime.check().map_err(advised)?;
        let (path, own) = (self.paths.lock(), self.lock.metadata());
        let same = |own: &fs::Metadata, other: &fs::Metadata| (own.dev(), own.ino()) == (other.dev(), other.ino());
        if !matches!((&own, &path.symlink_metadata()), (Ok(own), Ok(other)) if same(own, other)) {
            return Err(advised(folder(&path, &io::Error::other("it was removed or replaced"))));
        }
        if self.is_announced.load(Ordering::Relaxed) && self.paths.hello().symlink_metadata().is_err() {
            tracing::error!(path = %self.paths.hello().display(), "the hello file was removed, so no client could connect; it was written again");
            self.announce()?;
        }
        Ok(())
    }

    /// Writes the metrics file.
    ///
    /// # Errors
    /// `runtime_folder` if the file cannot be written.
    pub fn write_metrics(&self, text: &str) -> Result<(), Error> {
        write(&self.runtime, &self.paths.metrics(), text.as_bytes())
    }

    /// Removes the announcement: clients no longer connect.
    pub fn withdraw(&self) {
        self.is_announced.store(false, Ordering::Relaxed);
        let _ = fs::remove_file(self.paths.hello());
    }

    /// Removes files of earlier instances that no living process uses. Called with the lock held, so no other process creates files there.
    pub fn sweep(&mut self) {
        let before = self.earlier.len();
        self.earlier.retain(|instance| !remove_unused(instance));
        if self.earlier.len() < before
            && let Err(error) = self.list()
        {
            tracing::warn!(%error, "cannot write the list of instances");
        }
    }

    /// Removes the files of this instance. If clients still hold some of them, the next daemon removes them.
    ///
    /// # Errors
    /// `runtime_folder` if the list of instances cannot be written.
    pub fn close(mut self) -> Result<(), Error> {
        // A folder that replaced it does not belong to this daemon.
        let left = (self.has_segments() && !remove_unused(&self.instance)).then(|| self.instance.clone());
        self.earlier.retain(|instance| !remove_unused(instance));
        self.earlier.extend(left);
        write_list(&self.paths, &self.runtime, &self.earlier)
    }

    /// Writes the list of instances of which files may exist.
    fn list(&self) -> Result<(), Error> {
        let all: Vec<Instance> = self.earlier.iter().chain([&self.instance]).cloned().collect();
        write_list(&self.paths, &self.runtime, &all)
    }
}

/// Instances listed in the runtime directory; empty if the list cannot be read.
fn listed(paths: &ServicePaths) -> Vec<Instance> {
    let Ok(text) = regular_file::read(&paths.instances()) else { return Vec::new() };
    let tokens: Vec<String> = serde_json::from_str(&text).unwrap_or_else(|error| {
        tracing::warn!(%error, "cannot read the list of instances: files of killed daemons may stay in shared memory");
        Vec::new()
    });
    tokens.iter().filter_map(|token| Instance::of_token(paths, token)).collect()
}

fn write_list(paths: &ServicePaths, runtime: &PrivateFolder, instances: &[Instance]) -> Result<(), Error> {
    let tokens: Vec<&str> = instances.iter().map(|instance| instance.token.as_str()).collect();
    // A list of strings always serializes.
    write(runtime, &paths.instances(), &serde_json::to_vec(&tokens).unwrap_or_default())
}

fn lock(paths: &ServicePaths, instance: &Instance) -> Result<File, Error> {
    let path = paths.lock();
    let open = File::options().read(true).write(true).create(true).truncate(false).mode(0o600).open(&path);
    let mut file = open.map_err(|error| folder(&path, &error))?;
    for attempt in 1..=LOCK_TRIES {
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => break,
            Err(_) if attempt < LOCK_TRIES => std::thread::sleep(LOCK_PAUSE),
            Err(_) => return Err(second(paths, &mut file)),
        }
    }
    // A process that finds the lock held reads its owner. A single write prevents partial reads.
    let text = format!("{}\n{}\n", std::process::id(), instance.token);
    let written = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(text.as_bytes()));
    written.map_err(|error| folder(&path, &error))?;
    Ok(file)
}

fn second(paths: &ServicePaths, lock: &mut File) -> Error {
    let mut text = String::new();
    let _ = lock.read_to_string(&mut text);
    let (service, pid) = (paths.service.as_str(), text.lines().next().unwrap_or("unknown"));
    let message = format!(
        "a daemon of service `{service}` already runs (pid {pid}); end it, or choose another name with --service"
    );
    Error::new(ErrorKind::SecondDaemon, service, message)
}

fn folder(path: &Path, error: &std::io::Error) -> Error {
    let at = path.display().to_string();
    let message = format!(
        "cannot use {at}: {error}; give the user of the daemon write access to its folder, or set XDG_RUNTIME_DIR, for the daemon and its \
         clients, to another folder"
    );
    Error::new(ErrorKind::RuntimeFolder, at, message)
}

/// Writes a file of the runtime directory.
fn write(runtime: &PrivateFolder, path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
    runtime.write(name, bytes).map_err(|error| folder(path, &error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::name::ServiceName;

    fn paths(root: &Path) -> ServicePaths {
        let uid = rustix::process::geteuid().as_raw();
        ServicePaths::new(&ServiceName::new("home").unwrap(), Some(root), uid)
    }

    #[test]
    fn a_name_is_taken_once_and_given_back() {
        let root = tempfile::tempdir().unwrap();
        let paths = paths(root.path());
        let directory = RuntimeDirectory::take(&paths).unwrap();
        let error = RuntimeDirectory::take(&paths).err().unwrap();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::SecondDaemon, "home"));
        assert!(error.message.contains(&std::process::id().to_string()), "{error}");
        drop(directory);
        RuntimeDirectory::take(&paths).unwrap().close().unwrap();
    }

    #[test]
    fn restarts_and_crashes_are_counted() {
        let root = tempfile::tempdir().unwrap();
        let paths = paths(root.path());
        let past = |is_withdrawn: bool| {
            let directory = RuntimeDirectory::take(&paths).unwrap();
            directory.announce().unwrap();
            if is_withdrawn {
                directory.withdraw();
            }
            (directory.past().restarts, directory.past().crashes)
        };
        assert_eq!([past(true), past(false), past(true), past(true)], [(0, 0), (1, 0), (2, 1), (3, 1)]);
        fs::write(paths.past(), "not a past").unwrap();
        assert_eq!(past(true), (0, 0));
        RuntimeDirectory::take(&paths).unwrap().close().unwrap();
    }

    #[test]
    fn a_start_that_fails_is_no_restart_and_hides_no_crash() {
        let root = tempfile::tempdir().unwrap();
        let paths = paths(root.path());
        let start = || RuntimeDirectory::take(&paths).unwrap();
        start().close().unwrap();
        let served = start();
        served.announce().unwrap();
        assert_eq!(served.past(), RestartHistory { restarts: 0, crashes: 0 });
        // As if the process were killed.
        drop(served);
        for _ in 0..2 {
            let failed = start();
            assert_eq!(failed.past(), RestartHistory { restarts: 1, crashes: 1 });
            failed.close().unwrap();
        }
    }

    #[test]
    fn everything_of_killed_daemons_is_removed_and_nothing_of_others() {
        let root = tempfile::tempdir().unwrap();
        let paths = paths(root.path());
        paths.create().unwrap();
        let earlier: Vec<Instance> = (0..3).map(|_| Instance::random(&paths).unwrap()).collect();
        let runtime = PrivateFolder::open(&paths.folder, paths.uid).unwrap();
        write_list(&paths, &runtime, &earlier[..2]).unwrap();
        let mut left = Vec::new();
        for instance in &earlier {
            instance.create(paths.uid).unwrap();
            fs::create_dir_all(instance.folder.join("services")).unwrap();
            left.push(instance.folder.join("left.data"));
            left.push(instance.folder.join("services/x.service"));
        }
        for path in left.iter().chain([&paths.hello()]) {
            fs::write(path, "").unwrap();
        }
        let directory = RuntimeDirectory::take(&paths).unwrap();
        assert!(earlier[..2].iter().all(|instance| !instance.folder.exists()) && !paths.hello().exists());
        assert!(left[4..].iter().all(|path| path.exists()), "unlisted folders are not this service's");
        assert_eq!(listed(&paths), [directory.instance().clone()]);
        let own = directory.instance().clone();
        fs::write(own.folder.join("own.data"), "").unwrap();
        directory.close().unwrap();
        assert!(!own.folder.exists() && listed(&paths).is_empty());
        assert!(remove_unused(&earlier[2]));
    }

    #[test]
    fn an_instance_is_listed_before_anything_of_it_exists() {
        let root = tempfile::tempdir().unwrap();
        let paths = paths(root.path());
        let names: Vec<String> = (0..3)
            .map(|_| {
                let directory = RuntimeDirectory::take(&paths).unwrap();
                let token = directory.instance().token.clone();
                assert!(fs::read_to_string(paths.lock()).unwrap().contains(&token));
                // As if the process were killed.
                drop(directory);
                token
            })
            .collect();
        assert!(names[0] != names[1] && names[1] != names[2]);
        let left = listed(&paths);
        assert_eq!(left.iter().map(|instance| &instance.token).collect::<Vec<_>>(), [&names[2]]);
        assert!(left.iter().all(remove_unused));
        fs::write(paths.instances(), "no list").unwrap();
        assert!(listed(&paths).is_empty() && RuntimeDirectory::take(&paths).unwrap().close().is_ok());
    }
}
