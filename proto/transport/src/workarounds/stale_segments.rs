//! Segments and nodes of killed processes are not removed.
//!
//! **Symptom.** (1) A process killed between creating a segment and registering it leaves that segment. The transport's cleanup
//! follows registrations and misses it. (2) If a process is killed while it writes a tag, its node is never reclaimed. The cleanup
//! removes everything except the unfinished tag and its folder, and finds the node again each time. (3) A process killed while it
//! creates its node leaves a folder. The transport does not list it, because the node might still be starting.
//!
//! **Reproduction** (iceoryx2 0.10.0). Clients killed at random moments of their first 12 ms, as in the tests `faults` and
//! `reconnect` of `shatter-server`. 300 kills left folders of kind (3). After 30 kills, 17,538 cleanups were counted (2).
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file and its call in the loop of the daemon, once the transport's cleanup follows port tags. Every port writes
//! its tag first and removes it last, so a segment whose owner has no tag is stale.

use crate::instance::Instance;
use crate::{Ipc, PREFIX, config};
use iceoryx2::node::{Node, NodeState, NodeView};
use iceoryx2::prelude::CallbackProgression;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Extensions of segments of ports. Their names end in the port numbers: one, or both ends of a connection.
const SUFFIXES: [&str; 4] = ["connection", "data", "event", "event_mgmt"];

/// Reaper of segments and nodes of dead processes.
#[derive(Debug, Default)]
pub struct StaleSegmentReaper {
    /// Segments without an owner at the last check; a port that is being closed gets until the next check.
    suspects: BTreeSet<PathBuf>,
    /// Nodes that are neither alive nor reclaimable, and when they were first seen.
    shells: BTreeMap<u128, Instant>,
}

/// Age from which an incomplete node is stale; a living process creates its node within milliseconds.
const SHELL_AGE: Duration = Duration::from_secs(5);

impl StaleSegmentReaper {
    /// Removes segments that had no owner at this check and at the last one; returns the number of removed files.
    pub fn reap(&mut self, instance: &Instance) -> usize {
        self.reap_shells(instance) + self.reap_segments(instance)
    }

    /// Removes nodes that are dead and reclaimed, or were never finished, and still have a folder.
    fn reap_shells(&mut self, instance: &Instance) -> usize {
        let shells = shells(instance);
        self.shells.retain(|node, _| shells.contains(node));
        for node in shells {
            self.shells.entry(node).or_insert_with(Instant::now);
        }
        let old = self.shells.iter().filter(|(_, seen)| seen.elapsed() >= SHELL_AGE);
        old.filter(|(node, _)| remove_shell(instance, **node)).count()
    }

    fn reap_segments(&mut self, instance: &Instance) -> usize {
        let made: Vec<(PathBuf, Vec<u128>)> =
            entries(&instance.folder).filter_map(|entry| Some((entry.path(), ports(&entry.path())?))).collect();
        // Read after the segments: the tag of a living port is older than its segments.
        let tags = match tags(&instance.folder.join("nodes")) {
            Ok(tags) => tags,
            // Without descriptors, every segment would seem to be stale.
            Err(error) => {
                tracing::debug!(%error, "tags of ports cannot be listed");
                self.suspects.clear();
                return 0;
            }
        };
        let stale_segment =
            |(path, ports): (PathBuf, Vec<u128>)| ports.iter().any(|port| !tags.contains(port)).then_some(path);
        let stale_segments: BTreeSet<PathBuf> = made.into_iter().filter_map(stale_segment).collect();
        let removed = stale_segments.intersection(&self.suspects).filter(|path| fs::remove_file(path).is_ok()).count();
        self.suspects = stale_segments;
        removed
    }
}

/// Nodes that have a folder, and are neither alive nor reclaimable.
fn shells(instance: &Instance) -> BTreeSet<u128> {
    // Listed after the folders were read, so that a node created meanwhile is not in the set.
    let nodes = instance.folder.join("nodes");
    let mut shells: BTreeSet<u128> =
        entries(&nodes).filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect();
    let look = |node: NodeState<Ipc>| {
        if !matches!(&node, NodeState::Dead(node) if node.details().is_none()) {
            shells.remove(&node.node_id().value());
        }
        CallbackProgression::Continue
    };
    match config(instance).map(|config| Node::<Ipc>::list(&config, look)) {
        Ok(Ok(())) => shells,
        error => {
            tracing::debug!(?error, "nodes cannot be listed");
            BTreeSet::new()
        }
    }
}

/// Removes the folder of a node and its liveness files.
fn remove_shell(instance: &Instance, node: u128) -> bool {
    let nodes = instance.folder.join("nodes");
    let monitor = format!("{PREFIX}{node}.");
    let watched = entries(&nodes).filter(|entry| entry.file_name().to_string_lossy().starts_with(&monitor));
    let watched: Vec<PathBuf> = watched.map(|entry| entry.path()).collect();
    let _ = fs::remove_dir_all(nodes.join(node.to_string()));
    watched.iter().filter(|path| fs::remove_file(path).is_ok()).count() > 0
}

fn entries(folder: &Path) -> impl Iterator<Item = DirEntry> {
    fs::read_dir(folder).into_iter().flatten().flatten()
}

/// Ports that a segment belongs to; `None` if it is not a port's segment.
fn ports(path: &Path) -> Option<Vec<u128>> {
    let suffix = path.extension()?.to_str()?;
    let name = path.file_stem()?.to_str()?.strip_prefix(PREFIX)?;
    if !SUFFIXES.contains(&suffix) {
        return None;
    }
    let ends = if suffix == "connection" { 2 } else { 1 };
    let ports: Vec<u128> = name.rsplit('_').take(ends).filter_map(|word| word.parse().ok()).collect();
    (ports.len() == ends).then_some(ports)
}

/// Ports of all nodes, alive or not yet reclaimed.
///
/// # Errors
/// A folder that cannot be read, other than one that was removed meanwhile.
fn tags(nodes: &Path) -> io::Result<BTreeSet<u128>> {
    let tag = |path: &Path| {
        let tagged = path.extension() == Some(OsStr::new("port_tag"));
        let word = path.file_stem()?.to_str()?.rsplit('_').next()?.parse::<u128>().ok();
        word.filter(|_| tagged)
    };
    let mut tags = BTreeSet::new();
    for node in fs::read_dir(nodes)? {
        match fs::read_dir(node?.path()) {
            Ok(files) => {
                for file in files {
                    tags.extend(tag(&file?.path()));
                }
            }
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(tags)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths::ServicePaths;
    use shatter_proto::name::ServiceName;
    use std::fs::File;
    use std::os::unix::fs::OpenOptionsExt;

    /// The folder of a daemon, and the runtime folder that belongs to it.
    fn created(service: &str) -> (tempfile::TempDir, Instance) {
        let root = tempfile::tempdir().unwrap();
        let uid = rustix::process::geteuid().as_raw();
        let paths = ServicePaths::new(&ServiceName::new(service).unwrap(), Some(root.path()), uid);
        paths.create().unwrap();
        let instance = Instance::random(&paths).unwrap();
        instance.create(uid).unwrap();
        (root, instance)
    }

    #[test]
    fn untagged_segments_are_removed_at_the_second_scan() {
        let (_root, instance) = created("stale");
        let node = instance.folder.join("nodes/77");
        fs::create_dir_all(&node).unwrap();
        fs::write(node.join(format!("{PREFIX}11.port_tag")), "").unwrap();
        let segment = |name: &str| instance.folder.join(format!("{PREFIX}{name}"));
        let kept = ["a1_11.data", "a1_11.event_mgmt", "a1_99.dynamic", "node.global_mgmt", "b_x.data"].map(segment);
        let gone = ["a1_22.data", "a1_11_22.connection", "a1_22_11.connection", "a1_22.event_mgmt"].map(segment);
        let socket = segment("22.event");
        for path in kept.iter().chain(&gone).chain([&socket]) {
            fs::write(path, "").unwrap();
        }
        let mut reaper = StaleSegmentReaper::default();
        assert_eq!((reaper.reap(&instance), reaper.reap(&instance), reaper.reap(&instance)), (0, 5, 0));
        assert!(kept.iter().all(|path| path.exists()) && !gone.iter().chain([&socket]).any(|path| path.exists()));
        fs::remove_dir_all(&instance.folder).unwrap();
    }

    /// A daemon without descriptors cannot list its own ports. The folder of a node that leads to itself fails in the same way.
    #[test]
    fn segments_stay_while_tags_cannot_be_listed() {
        let (_root, instance) = created("poor");
        let (nodes, segment) = (instance.folder.join("nodes"), instance.folder.join(format!("{PREFIX}a1_22.data")));
        fs::create_dir_all(&nodes).unwrap();
        fs::write(&segment, "").unwrap();
        std::os::unix::fs::symlink(nodes.join("77"), nodes.join("77")).unwrap();
        let mut reaper = StaleSegmentReaper::default();
        assert_eq!([(); 3].map(|()| reaper.reap(&instance)), [0; 3]);
        assert!(segment.exists());
        fs::remove_file(nodes.join("77")).unwrap();
        assert_eq!([(); 2].map(|()| reaper.reap(&instance)), [0, 1]);
        fs::remove_dir_all(&instance.folder).unwrap();
    }

    /// Reproduces the state after three hundred kills: a details file, and monitor files that are not readable yet.
    #[test]
    fn an_unfinished_node_is_removed_after_a_delay() {
        let (_root, instance) = created("shells");
        let nodes = instance.folder.join("nodes");
        fs::create_dir_all(nodes.join("77")).unwrap();
        fs::write(nodes.join("77").join(format!("{PREFIX}node.details")), "").unwrap();
        for name in ["node_monitor", "node_monitor_context", "node_monitor_owner_lock"] {
            let mut file = File::options();
            file.write(true).create_new(true).mode(0o200).open(nodes.join(format!("{PREFIX}77.{name}"))).unwrap();
        }
        let mut reaper = StaleSegmentReaper::default();
        assert_eq!((reaper.reap(&instance), reaper.reap(&instance), reaper.shells.len()), (0, 0, 1));
        let seen = Instant::now().checked_sub(SHELL_AGE).unwrap();
        reaper.shells.insert(77, seen);
        assert_eq!((reaper.reap(&instance), entries(&nodes).count()), (1, 0));
        fs::remove_dir_all(&instance.folder).unwrap();
    }
}
