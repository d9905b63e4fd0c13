//! A daemon killed while starting leaves a service that cannot be opened.
//!
//! **Symptom.** (1) An unfinished `.service` file remains, of mode 0600 (finished ones have 0400). Every later call that opens the
//! service then fails with `HangsInCreation` after a second. `Node::force_remove_service` does not remove the file. (2) Nodes
//! without details remain, because the cleanup searches for them under the default configuration instead of the given one. (3) The
//! segment `*.global_mgmt` is never removed.
//!
//! **Reproduction** (iceoryx2 0.10.0). (1) 4 of 400 kills in the first 12 ms of a daemon. (2) 33 of 60 kills. (3) Every daemon that
//! ends.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** [`remove_unused`], and with it the list of earlier instances in the runtime folder. Only
//! [`private_segments`](super::private_segments) may then still need a folder per daemon process.

use crate::instance::Instance;
use crate::{Ipc, config};
use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::CallbackProgression;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;

/// Removes the folder of an earlier daemon unless a living process uses it; returns whether it is gone.
pub fn remove_unused(instance: &Instance) -> bool {
    let path = &instance.folder;
    let removed = match path.symlink_metadata() {
        Err(error) => return error.kind() == io::ErrorKind::NotFound,
        // A folder of another user is not even read.
        Ok(data) if data.uid() != rustix::process::geteuid().as_raw() => return true,
        Ok(data) if data.is_dir() && is_used(instance) => return false,
        Ok(data) if data.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
    };
    if let Err(error) = &removed {
        tracing::warn!(path = %path.display(), %error, "cannot remove the folder of an earlier daemon");
    }
    removed.is_ok()
}

/// True if a living process has a node in an instance.
fn is_used(instance: &Instance) -> bool {
    let mut used = false;
    let look = |node: NodeState<Ipc>| {
        used |= matches!(node, NodeState::Alive(_));
        if used { CallbackProgression::Stop } else { CallbackProgression::Continue }
    };
    match config(instance).map(|config| Node::<Ipc>::list(&config, look)) {
        Ok(Ok(())) => used,
        // A folder that cannot be listed belongs to no living process.
        _ => false,
    }
}
