//! The daemon's runtime folder: one daemon per name, and nothing left of those that died.

use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::CallbackProgression;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};
use shatter_proto::hello::Hello;
use shatter_proto::place::Place;
use shatter_proto::transport::{Ipc, config};
use shatter_proto::unfinished::{Call, Rescue};
use shatter_proto::{Kind, Refusal, shared_memory};
use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;

/// Clients hold the lock for microseconds to see whether a daemon lives, and a killed daemon holds it until the kernel has taken its
/// memory apart: a second of tries gets past both.
const LOCK_TRIES: u32 = 100;
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// The daemons that a service has had before the one that runs. The file lies in the runtime folder, and goes with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Past {
    /// How many there were.
    pub restarts: u64,
    /// How many of them ended without a goodbye: killed, or crashed.
    pub crashes: u64,
}

impl Past {
    /// The past of a daemon that begins now.
    fn read(place: &Place) -> Self {
        let Ok(text) = fs::read(place.past()) else { return Self::default() };
        let past: Self = serde_json::from_slice(&text).unwrap_or_default();
        let crashed = u64::from(place.hello().exists());
        Self { restarts: past.restarts.saturating_add(1), crashes: past.crashes.saturating_add(crashed) }
    }

    /// Kept for the next daemon. A past that cannot be written is lost, no more.
    fn write(self, place: &Place) {
        let written = serde_json::to_vec(&self).map(|json| write_aside(&place.past(), &json));
        if !matches!(written, Ok(Ok(()))) {
            tracing::warn!("restarts are not counted: the runtime folder cannot be written");
        }
    }
}

/// The runtime folder of a running daemon. Dropping it gives up the name.
pub struct Home {
    place: Place,
    past: Past,
    _freed: Call,
    _rescue: Rescue,
    _lock: File,
}

impl Home {
    /// Takes the name: the kernel gives the lock back when the process ends, however it ends. Then heals what a killed
    /// predecessor left. Errors: `second_daemon`, `runtime_folder`.
    pub fn take(place: &Place) -> Result<Self, Refusal> {
        place.create()?;
        let lock = lock(place)?;
        let past = Past::read(place);
        past.write(place);
        // A stale hello would invite clients while the folders are being healed.
        let _ = fs::remove_file(place.hello());
        // A daemon that waits for what a dead client left unfinished serves nobody: it is watched as long as it runs.
        let rescue = Rescue::new(&place.prefix)?;
        let home = Self { place: place.clone(), past, _freed: rescue.call(), _rescue: rescue, _lock: lock };
        home.heal()?;
        Ok(home)
    }

    /// Where it is.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The daemons before this one.
    pub fn past(&self) -> Past {
        self.past
    }

    /// Tells clients that the daemon serves, and what it speaks.
    pub fn say_hello(&self) -> Result<(), Refusal> {
        let hello = Hello::ours(std::process::id()).to_json();
        write_aside(&self.place.hello(), hello.as_bytes())
    }

    /// Writes the metrics for whoever scrapes them.
    pub fn write_metrics(&self, text: &str) -> Result<(), Refusal> {
        write_aside(&self.place.metrics(), text.as_bytes())
    }

    /// Nobody is invited any more.
    pub fn say_goodbye(&self) {
        let _ = fs::remove_file(self.place.hello());
    }

    /// Removes what no living process uses. Called with the lock held, so no other daemon is creating anything.
    pub fn heal(&self) -> Result<(), Refusal> {
        if self.nodes_alive() {
            // Clients of a killed predecessor still hold its services: only what it did not finish is in the way.
            remove_unfinished(&self.place.transport.join("services"));
            return Ok(());
        }
        wipe(&self.place.transport);
        for entry in fs::read_dir(shared_memory::FOLDER).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&self.place.prefix) {
                let _ = fs::remove_file(entry.path());
            }
        }
        self.place.create()
    }

    fn nodes_alive(&self) -> bool {
        let mut alive = false;
        let look = |node: NodeState<Ipc>| {
            alive |= matches!(node, NodeState::Alive(_));
            if alive { CallbackProgression::Stop } else { CallbackProgression::Continue }
        };
        match config(&self.place).map(|config| Node::<Ipc>::list(&config, look)) {
            Ok(Ok(())) => alive,
            // Folders that cannot be listed belong to nobody alive.
            _ => false,
        }
    }
}

fn lock(place: &Place) -> Result<File, Refusal> {
    let path = place.lock();
    let open = File::options().read(true).write(true).create(true).truncate(false).mode(0o600).open(&path);
    let mut file = open.map_err(|error| folder(&path, &error))?;
    for attempt in 1..=LOCK_TRIES {
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => break,
            Err(_) if attempt < LOCK_TRIES => std::thread::sleep(LOCK_PAUSE),
            Err(_) => return Err(second(place, &mut file)),
        }
    }
    let written = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| writeln!(file, "{}", std::process::id()));
    written.map_err(|error| folder(&path, &error))?;
    Ok(file)
}

fn second(place: &Place, lock: &mut File) -> Refusal {
    let mut pid = String::new();
    let _ = lock.read_to_string(&mut pid);
    let service = place.service.as_str();
    let message = format!("a daemon of service `{service}` already runs (pid {})", pid.trim());
    Refusal::new(Kind::SecondDaemon, service, message)
}

fn folder(path: &Path, error: &std::io::Error) -> Refusal {
    let at = path.display().to_string();
    let message = format!("cannot use {at}: {error}");
    Refusal::new(Kind::RuntimeFolder, at, message)
}

/// Written beside and renamed: readers see the old file or the new one.
fn write_aside(path: &Path, bytes: &[u8]) -> Result<(), Refusal> {
    let aside = path.with_extension("new");
    let written = fs::write(&aside, bytes).and_then(|()| fs::rename(&aside, path));
    written.map_err(|error| folder(path, &error))
}

/// A service that was being created when its daemon died keeps a writable file, and nobody can open it ever again.
fn remove_unfinished(services: &Path) {
    for entry in fs::read_dir(services).into_iter().flatten().flatten() {
        let unfinished = entry.metadata().is_ok_and(|data| data.is_file() && data.mode() & 0o200 != 0);
        if unfinished {
            tracing::warn!(path = %entry.path().display(), "removing a half-created service");
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Empties a folder.
fn wipe(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let _ = if folder { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::name::ServiceName;
    use std::os::unix::fs::PermissionsExt;

    fn place(root: &Path) -> Place {
        let uid = rustix::process::geteuid().as_raw();
        Place::new(&ServiceName::new("home").unwrap(), Some(root), uid)
    }

    #[test]
    fn a_name_is_taken_once_and_given_back() {
        let root = tempfile::tempdir().unwrap();
        let place = place(root.path());
        let home = Home::take(&place).unwrap();
        let refusal = Home::take(&place).err().unwrap();
        assert_eq!((refusal.kind, refusal.at.as_str()), (Kind::SecondDaemon, "home"));
        assert!(refusal.message.contains(&std::process::id().to_string()), "{refusal}");
        drop(home);
        assert!(Home::take(&place).is_ok());
    }

    #[test]
    fn restarts_and_crashes_are_counted() {
        let root = tempfile::tempdir().unwrap();
        let place = place(root.path());
        let past = |goodbye: bool| {
            let home = Home::take(&place).unwrap();
            home.say_hello().unwrap();
            if goodbye {
                home.say_goodbye();
            }
            (home.past().restarts, home.past().crashes)
        };
        assert_eq!([past(true), past(false), past(true), past(true)], [(0, 0), (1, 0), (2, 1), (3, 1)]);
        fs::write(place.past(), "not a past").unwrap();
        assert_eq!(past(true), (1, 0));
    }

    #[test]
    fn leftovers_of_the_dead_are_removed_and_others_spared() {
        let root = tempfile::tempdir().unwrap();
        let place = place(root.path());
        place.create().unwrap();
        let left = Path::new(shared_memory::FOLDER).join(format!("{}left.data", place.prefix));
        let other = Path::new(shared_memory::FOLDER).join(format!("shatter_other_{}", std::process::id()));
        fs::create_dir_all(place.transport.join("services")).unwrap();
        for path in [&left, &other, &place.transport.join("services/x.service"), &place.hello()] {
            fs::write(path, "").unwrap();
        }
        let _home = Home::take(&place).unwrap();
        assert!(!left.exists() && !place.transport.join("services").exists() && !place.hello().exists());
        assert!(other.exists());
        fs::remove_file(other).unwrap();
    }

    #[test]
    fn only_half_created_services_are_unfinished() {
        let folder = tempfile::tempdir().unwrap();
        for (name, mode) in [("half", 0o600), ("whole", 0o400)] {
            let path = folder.path().join(name);
            fs::write(&path, "").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        }
        remove_unfinished(folder.path());
        assert!(!folder.path().join("half").exists() && folder.path().join("whole").exists());
    }
}
