//! The way in for clients, kept closed to other users.
//!
//! Every process that connects first opens one small segment, which iceoryx2 (0.10.0) makes readable and writable for all users of
//! the machine: a few zeros in it, and nobody connects any more. So the daemon puts a private copy in its place before any client
//! knows its name; whoever opened the original holds a file that nobody uses. What can still be spoilt, by the same user or by root,
//! is found by looking and put right.

use iceoryx2::node::NodeBuilder;
use iceoryx2::prelude::SignalHandlingMode;
use shatter_proto::instance::{Instance, random_token};
use shatter_proto::transport::{Ipc, client_config, failed};
use shatter_proto::{Kind, Refusal};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// How the segment's name ends.
const SEGMENT: &str = "global_mgmt";

/// How the names of segments end that last as long as the services, one each.
const SERVICE: &str = "dynamic";

/// Rights of the segment: its owner's alone.
const MODE: u32 = 0o600;

/// First bytes of the segment, which never change: the transport's version. A counter follows.
const FIXED_BYTES: usize = 8;

/// Watches over the way in. Made once the services exist.
pub struct Entrance {
    instance: Instance,
    uid: u32,
    segment: PathBuf,
    /// What the segment held when it was made.
    bytes: Vec<u8>,
    /// Segments without which no service can be opened.
    services: Vec<PathBuf>,
    /// Files of other users under names of ours that were told of.
    foreign: BTreeSet<PathBuf>,
    /// What was found last and could not be put right.
    trouble: Option<String>,
    restored: u64,
}

impl Entrance {
    /// Closes the way in of `instance` to other users, and goes it once. Errors: `transport`, which names what is in the way.
    pub fn close(instance: &Instance, uid: u32) -> Result<Self, Refusal> {
        let ending = |path: &PathBuf, ending: &str| path.extension() == Some(OsStr::new(ending));
        let (segments, instance) = (instance.segments(), instance.clone());
        let missing = || failed("node", format!("no file {}*.{SEGMENT} in shared memory", instance.prefix));
        let segment = segments.iter().find(|path| ending(path, SEGMENT)).cloned().ok_or_else(missing)?;
        let bytes = fs::read(&segment).map_err(|error| failed(&segment.display().to_string(), error))?;
        let services = segments.into_iter().filter(|path| ending(path, SERVICE)).collect();
        let (foreign, trouble, restored) = (BTreeSet::new(), None, 0);
        let entrance = Self { instance, uid, segment, bytes, services, foreign, trouble, restored };
        entrance.restore().map_err(|error| failed(&entrance.segment.display().to_string(), error))?;
        entrance.go_in()?;
        Ok(entrance)
    }

    /// Times that it was spoilt and put right.
    pub fn restored(&self) -> u64 {
        self.restored
    }

    /// Looks whether clients can come in. What is in their way is put right, if it can be, named in the log, and returned: the next
    /// look then finds nothing. Errors: `transport`.
    pub fn check(&mut self) -> Result<(), Refusal> {
        self.name_foreign();
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
        Err(Refusal::new(Kind::Transport, path.display().to_string(), format!("{message}; {advice}")))
    }

    /// What is in the way, and where.
    fn look(&self) -> Result<(), (PathBuf, String)> {
        let found = |what: String| (self.segment.clone(), what);
        let data = self.segment.symlink_metadata().map_err(|error| found(format!("cannot be read ({error})")))?;
        let rights = data.mode() & 0o777;
        if !data.is_file() {
            return Err(found("is not a file".to_owned()));
        }
        if data.uid() != self.uid {
            return Err(found(format!("belongs to user {}", data.uid())));
        }
        if rights != MODE {
            return Err(found(format!("is open to other users (mode {rights:o})")));
        }
        let now = fs::read(&self.segment).map_err(|error| found(format!("cannot be read ({error})")))?;
        if now.len() != self.bytes.len() || now.get(..FIXED_BYTES) != self.bytes.get(..FIXED_BYTES) {
            return Err(found("was overwritten".to_owned()));
        }
        self.instance.check(self.uid).map_err(|refusal| (self.instance.folder.clone(), refusal.message))?;
        match self.services.iter().find(|path| path.symlink_metadata().is_err()) {
            Some(gone) => Err((gone.clone(), "was removed".to_owned())),
            None => Ok(()),
        }
    }

    /// Puts a fresh private copy of the segment in its place.
    fn restore(&self) -> std::io::Result<()> {
        // Under a name that no other user can take beforehand.
        let word = random_token().map_err(std::io::Error::other)?;
        let aside = self.segment.with_file_name(format!("{}{word}", self.instance.prefix));
        if self.segment.symlink_metadata().is_ok_and(|data| data.is_dir()) {
            fs::remove_dir_all(&self.segment)?;
        }
        let mut copy = File::options().write(true).create_new(true).mode(MODE).open(&aside)?;
        copy.write_all(&self.bytes)?;
        fs::rename(&aside, &self.segment)
    }

    /// What a client does first.
    fn go_in(&self) -> Result<(), Refusal> {
        let config = client_config(&self.instance)?;
        let node = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
        let at = self.segment.display().to_string();
        node.create::<Ipc>().map(drop).map_err(|error| failed(&at, error))
    }

    /// Tells once of each file of another user that has a name of ours: it may take a name that a client needs, which then tries
    /// another one.
    fn name_foreign(&mut self) {
        let foreign = |path: &Path| path.symlink_metadata().is_ok_and(|data| data.uid() != self.uid);
        let found: BTreeSet<PathBuf> = self.instance.segments().into_iter().filter(|path| foreign(path)).collect();
        for path in found.difference(&self.foreign) {
            tracing::warn!(path = %path.display(), "another user made a file under a name of this service");
        }
        self.foreign = found;
    }
}
