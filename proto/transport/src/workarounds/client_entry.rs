//! One segment keeps every client out.
//!
//! **Symptom.** Every process that connects opens the segment `*.global_mgmt` first. If a few bytes of it are zero, or it is gone, no client
//! connects any more, and the daemon does not notice.
//!
//! **Reproduction** (iceoryx2 0.10.0). The test `entrance` of `shatter-server` overwrites and removes the segment of a running daemon.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file, its call in the loop of the daemon and the counter of restored segments, once a node repairs or refuses the
//! segment. The folder is closed to other users; this user, root and cleaners of `/dev/shm` can still spoil it.

use crate::instance::Instance;
use crate::private_folder::PrivateFolder;
use crate::{Ipc, client_config, failed};
use iceoryx2::node::NodeBuilder;
use iceoryx2::prelude::SignalHandlingMode;
use shatter_proto::{Error, ErrorKind};
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;

/// How the segment's name ends.
const SEGMENT: &str = "global_mgmt";

/// How the names of segments end that last as long as the services, one each.
const SERVICE: &str = "dynamic";

/// First bytes of the segment, which never change: the transport's version. A counter follows.
const FIXED_BYTES: usize = 8;

/// Watches over the way in. Made once the services exist.
pub struct ClientEntryCheck {
    instance: Instance,
    folder: PrivateFolder,
    segment: PathBuf,
    /// What the segment held when it was made.
    bytes: Vec<u8>,
    /// Segments and descriptions without which no service can be opened.
    services: Vec<PathBuf>,
    /// What was found last and could not be put right.
    trouble: Option<String>,
    restored: u64,
}

impl ClientEntryCheck {
    /// Goes the way in to `instance` once. Errors: `transport`, which names what is in the way.
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
        let entrance = Self { instance, folder, segment, bytes, services, trouble: None, restored: 0 };
        entrance.go_in()?;
        Ok(entrance)
    }

    /// Times that it was spoilt and put right.
    pub fn restored(&self) -> u64 {
        self.restored
    }

    /// Looks whether clients can come in. What is in their way is put right, if it can be, named in the log, and returned: the next
    /// look then finds nothing. Errors: `transport`.
    pub fn check(&mut self) -> Result<(), Error> {
        let Err((path, what)) = self.look() else {
            self.trouble = None;
            return Ok(());
        };
        let message = format!("{} {what}: no client can connect", path.display());
        let healed = path == self.segment && self.restore().is_ok() && self.look().is_ok() && self.go_in().is_ok();
        if healed {
            self.restored += 1;
            tracing::error!("{message}; it was restored");
        } else if self.trouble.as_ref() != Some(&message) {
            tracing::error!("{message}; restart the daemon");
            self.trouble = Some(message.clone());
        }
        let advice = if healed { "it was restored" } else { "restart the daemon" };
        Err(Error::new(ErrorKind::Transport, path.display().to_string(), format!("{message}; {advice}")))
    }

    /// What is in the way, and where.
    fn look(&self) -> Result<(), (PathBuf, String)> {
        // Another folder in its place is not looked into.
        self.folder.check().map_err(|refusal| (self.instance.folder.clone(), refusal.message))?;
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

    /// Puts a fresh copy of the segment in its place.
    fn restore(&self) -> std::io::Result<()> {
        if self.segment.symlink_metadata().is_ok_and(|data| data.is_dir()) {
            fs::remove_dir_all(&self.segment)?;
        }
        let name = self.segment.file_name().and_then(OsStr::to_str).unwrap_or_default();
        self.folder.write(name, &self.bytes)
    }

    /// What a client does first.
    fn go_in(&self) -> Result<(), Error> {
        let config = client_config(&self.instance)?;
        let node = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let at = self.segment.display().to_string();
        node.create::<Ipc>().map(drop).map_err(|error| failed(&at, error))
    }
}
