//! Test places: every test has its own runtime directory, service name and shared memory, and leaves nothing.

use shatter_proto::name::ServiceName;
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use std::fs::File;
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// A test place, removed with everything in it on drop.
pub struct TestDirectory {
    pub place: ServicePaths,
    root: TempDir,
}

impl TestDirectory {
    /// A new place for the service `name`.
    pub fn new(name: &str) -> Self {
        // Short, so that sockets fit into their paths; in memory, because the transport syncs every file that it creates.
        let root = tempfile::Builder::new().prefix("sh").tempdir_in("/dev/shm").unwrap();
        let uid = rustix::process::geteuid().as_raw();
        let place = ServicePaths::new(&ServiceName::new(name).unwrap(), Some(root.path()), uid);
        std::fs::create_dir_all(root.path().join("data/shatter")).unwrap();
        Self { place, root }
    }

    /// Folder of databases that the programs use by default.
    pub fn databases(&self) -> PathBuf {
        self.root.path().join("data/shatter")
    }

    /// Writes a database of the toy engine, or a corrupt one for the real engine, as `shatterd bake` does: to a temporary file, then
    /// renamed.
    pub fn database(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let aside = self.databases().join(".shatter-test.part");
        std::fs::write(&aside, bytes).unwrap();
        std::fs::rename(aside, self.databases().join(name).with_extension("shatter")).unwrap();
    }

    /// Removes a database.
    pub fn remove(&self, name: &str) {
        std::fs::remove_file(self.databases().join(name).with_extension("shatter")).unwrap();
    }

    /// Writes a file beside the databases.
    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.root.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Sets the environment of a program to this place.
    pub fn aim(&self, command: &mut Command) {
        command.env("XDG_RUNTIME_DIR", self.root.path()).env("XDG_DATA_HOME", self.root.path().join("data"));
        command.env("SHATTER_SERVICE", self.place.service.as_str());
        command.env_remove("NOTIFY_SOCKET").env_remove("WATCHDOG_USEC");
    }

    /// Transport instance of the daemon that serves now.
    pub fn instance(&self) -> Instance {
        Instance::serving(&self.place).unwrap()
    }

    /// Transport folders of all daemons of this place.
    pub fn transports(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir("/dev/shm").unwrap().flatten();
        let ours = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(&self.place.mark);
        entries.map(|entry| entry.path()).filter(ours).collect()
    }

    /// Nodes that the transport knows: files, and a folder of tags each.
    pub fn nodes(&self) -> Vec<PathBuf> {
        let entries = |folder: PathBuf| std::fs::read_dir(folder.join("nodes")).into_iter().flatten();
        self.transports().into_iter().flat_map(entries).map(|entry| entry.unwrap().path()).collect()
    }

    /// Segments and sockets of this place.
    pub fn shared_memory(&self) -> Vec<PathBuf> {
        let entries = self.transports().into_iter().flat_map(|folder| std::fs::read_dir(folder).into_iter().flatten());
        entries.flatten().map(|entry| entry.path()).filter(|path| !path.is_dir()).collect()
    }

    /// Addresses at which this process has results of this place mapped.
    pub fn mapped(&self) -> Vec<std::ops::Range<usize>> {
        let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
        let ours = maps.lines().filter(|line| line.contains(&self.place.mark) && line.ends_with(".data"));
        let hex = |text: &str| usize::from_str_radix(text, 16).unwrap();
        ours.map(|line| {
            let (start, end) = line.split_once(' ').unwrap().0.split_once('-').unwrap();
            hex(start)..hex(end)
        })
        .collect()
    }
}

impl Drop for TestDirectory {
    fn drop(&mut self) {
        for folder in self.transports() {
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

/// True if `part` is inside one of `ranges`.
pub fn within(part: &std::ops::Range<usize>, ranges: &[std::ops::Range<usize>]) -> bool {
    ranges.iter().any(|range| range.start <= part.start && part.end <= range.end)
}

/// Replaces segments by empty, unreadable ones, as a process leaves them that dies while it makes them.
pub fn leave_unfinished(segments: &[PathBuf]) {
    for segment in segments {
        std::fs::remove_file(segment).unwrap();
        File::options().write(true).create_new(true).mode(0o200).open(segment).unwrap();
    }
}

/// Leaves an unreadable tag in the folder of each node, as a process leaves it that dies while it writes one.
pub fn leave_tags(nodes: &[PathBuf]) {
    for node in nodes {
        let tag = node.join(format!("{}77.port_tag", node.file_name().unwrap().to_string_lossy()));
        File::options().write(true).create_new(true).mode(0o600).open(tag).unwrap();
    }
}
