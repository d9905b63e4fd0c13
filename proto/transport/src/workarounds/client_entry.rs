//! A corrupt segment stops every client.
//!
//! **Symptom.** Every process that connects opens the segment `*.global_mgmt` first. If a few bytes of it are zero, or it is gone, no
//! client can connect, and the daemon does not notice.
//!
//! **Reproduction** (iceoryx2 0.10.0). The test `runtime_files` of `shatter-server` overwrites and removes the segment of a running daemon.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file, its call in the loop of the daemon and the counter of restored segments, once a node repairs or rejects the
//! segment. The folder is closed to other users; this user, root and cleaners of `/dev/shm` can still damage it.

use crate::instance::Instance;
use crate::private_folder::PrivateFolder;
use crate::{Ipc, client_config, failed};
use iceoryx2::node::NodeBuilder;
use iceoryx2::prelude::SignalHandlingMode;
use shatter_proto::{Error, ErrorKind};
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;

/// Extension of the segment.
const SEGMENT: &str = "global_mgmt";

/// Extension of the segments that exist as long as the services, one each.
const SERVICE: &str = "dynamic";

/// Length of the segment's constant prefix, the transport's version, bytes. A counter follows.
const FIXED_BYTES: usize = 8;

/// Check of the files that clients need to connect. Created after the services.
pub struct ClientEntryCheck {
    instance: Instance,
    folder: PrivateFolder,
    segment: PathBuf,
    /// Original contents of the segment.
    bytes: Vec<u8>,
    /// Segments and descriptions without which no service can be opened.
    services: Vec<PathBuf>,
    /// Last damage that could not be repaired.
    last_error: Option<String>,
    restored: u64,
}

impl ClientEntryCheck {
    /// Opens a test connection to `instance`.
    ///
    /// # Errors
    /// `transport`, which names what is in the way.
    pub fn open(instance: &Instance, uid: u32) -> Result<Self, Error> {
        let ending = |path: &PathBuf, ending: &str| path.extension() == Some(OsStr::new(ending));
        let entries = fs::read_dir(&instance.folder).into_iter().flatten().flatten();
        let segments: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        let instance = instance.clone();
        let missing = || failed("node", format!("no file *.{SEGMENT} in {}", instance.folder.display()));
        let segment = segments.iter().find(|path| ending(path, SEGMENT)).cloned().ok_or_else(missing)?;
        let bytes = fs::read(&segment).map_err(|error| failed(&segment.display().to_string(), error))?;
        let described = fs::read_dir(instance.folder.join("services")).into_iter().flatten().flatten();
        let services = segments.into_iter().filter(|path| ending(path, SERVICE));
        let services = services.chain(described.map(|entry| entry.path())).collect();
        let folder = PrivateFolder::open(&instance.folder, uid)?;
        let entrance = Self { instance, folder, segment, bytes, services, last_error: None, restored: 0 };
        entrance.connect()?;
        Ok(entrance)
    }

    /// Number of repairs.
    pub fn restored(&self) -> u64 {
        self.restored
    }

    /// Checks whether clients can connect.
    ///
    /// Damage is logged, repaired if possible, and returned as an error; after a repair the next check succeeds.
    ///
    /// # Errors
    /// `transport`.
    pub fn check(&mut self) -> Result<(), Error> {
        let Err((path, what)) = self.find_damage() else {
            self.last_error = None;
            return Ok(());
        };
        let message = format!("{} {what}: no client can connect", path.display());
        let is_restored =
            path == self.segment && self.restore().is_ok() && self.find_damage().is_ok() && self.connect().is_ok();
        if is_restored {
            self.restored += 1;
            tracing::error!("{message}; it was restored");
        } else if self.last_error.as_ref() != Some(&message) {
            tracing::error!("{message}; restart the daemon");
            self.last_error = Some(message.clone());
        }
        let advice = if is_restored { "it was restored" } else { "restart the daemon" };
        Err(Error::new(ErrorKind::Transport, path.display().to_string(), format!("{message}; {advice}")))
    }

    /// Finds the first damaged file and describes the damage.
    fn find_damage(&self) -> Result<(), (PathBuf, String)> {
        // If another folder has replaced this one, nothing in it is read.
        self.folder.check().map_err(|error| (self.instance.folder.clone(), error.message))?;
        let found = |what: String| (self.segment.clone(), what);
        let data = self.segment.symlink_metadata().map_err(|error| found(format!("cannot be read ({error})")))?;
        if !data.is_file() {
            return Err(found("is not a file".to_owned()));
        }
        let now = fs::read(&self.segment).map_err(|error| found(format!("cannot be read ({error})")))?;
        if now.len() != self.bytes.len() || now.get(..FIXED_BYTES) != self.bytes.get(..FIXED_BYTES) {
            return Err(found("was overwritten".to_owned()));
        }
        match self.services.iter().find(|path| path.symlink_metadata().is_err()) {
            Some(gone) => Err((gone.clone(), "was removed".to_owned())),
            None => Ok(()),
        }
    }

    /// Replaces the segment by a fresh copy.
    fn restore(&self) -> std::io::Result<()> {
        if self.segment.symlink_metadata().is_ok_and(|data| data.is_dir()) {
            fs::remove_dir_all(&self.segment)?;
        }
        let name = self.segment.file_name().and_then(OsStr::to_str).unwrap_or_default();
        self.folder.write(name, &self.bytes)
    }

    /// Connects as a client does.
    fn connect(&self) -> Result<(), Error> {
        let config = client_config(&self.instance)?;
        let node = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let at = self.segment.display().to_string();
        node.create::<Ipc>().map(drop).map_err(|error| failed(&at, error))
    }
}
