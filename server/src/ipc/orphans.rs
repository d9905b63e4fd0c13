//! Segments that belong to nobody. A process that is killed between making a segment and taking its place in it leaves one that no
//! cleaning up after it finds: it goes by places (iceoryx2 0.10.0). What names its owner does not get lost: every port writes a tag
//! before it makes anything, and the tag goes after everything else.
//!
//! A process that is killed while it writes a tag leaves a node that is never rid of: cleaning up takes all of it but the unfinished
//! tag, whose folder stays, and finds it again for ever. What the dead own then is that tag and nothing else.

use iceoryx2::node::{Node, NodeState, NodeView};
use iceoryx2::prelude::CallbackProgression;
use shatter_proto::instance::Instance;
use shatter_proto::shared_memory;
use shatter_proto::transport::{Ipc, config};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::path::{Path, PathBuf};

/// What ports make. Names end in the numbers of the ports: one, or both ends of a connection.
const SUFFIXES: [&str; 4] = ["connection", "data", "event", "event_mgmt"];

/// Finds and removes what belongs to nobody.
#[derive(Debug, Default)]
pub struct Orphans {
    /// What belonged to nobody at the last look: ports that are being closed are given until the next.
    suspects: BTreeSet<PathBuf>,
    /// Dead nodes of which only a shell was left at the last look.
    shells: BTreeSet<u128>,
}

impl Orphans {
    /// Removes what belongs to nobody and did not at the last look either; returns how many there were.
    pub fn bury(&mut self, instance: &Instance) -> usize {
        self.bury_shells(instance) + self.bury_segments(instance)
    }

    /// Removes nodes that are dead, cleaned up, and still there.
    fn bury_shells(&mut self, instance: &Instance) -> usize {
        let mut shells = BTreeSet::new();
        let look = |node: NodeState<Ipc>| {
            if let NodeState::Dead(node) = node
                && node.details().is_none()
            {
                shells.insert(node.id().value());
            }
            CallbackProgression::Continue
        };
        if let Ok(config) = config(instance)
            && let Err(error) = Node::<Ipc>::list(&config, look)
        {
            tracing::debug!(?error, "nodes cannot be listed");
        }
        let buried = shells.intersection(&self.shells).filter(|node| remove_shell(instance, **node)).count();
        self.shells = shells;
        buried
    }

    fn bury_segments(&mut self, instance: &Instance) -> usize {
        let folders = [Path::new(shared_memory::FOLDER), &instance.folder];
        let made: Vec<(PathBuf, Vec<u128>)> = folders
            .into_iter()
            .flat_map(entries)
            .filter_map(|entry| Some((entry.path(), ports(&entry.path(), &instance.prefix)?)))
            .collect();
        // Read after what was made: the tag of a living port is older than anything that it makes.
        let tags = tags(&instance.folder.join("nodes"));
        let orphan =
            |(path, ports): (PathBuf, Vec<u128>)| ports.iter().any(|port| !tags.contains(port)).then_some(path);
        let orphans: BTreeSet<PathBuf> = made.into_iter().filter_map(orphan).collect();
        let buried = orphans.intersection(&self.suspects).filter(|path| fs::remove_file(path).is_ok()).count();
        self.suspects = orphans;
        buried
    }
}

/// Removes the folder of a node and the files that said whether it lives.
fn remove_shell(instance: &Instance, node: u128) -> bool {
    let nodes = instance.folder.join("nodes");
    let monitor = format!("{}{node}.", instance.prefix);
    let watched = entries(&nodes).filter(|entry| entry.file_name().to_string_lossy().starts_with(&monitor));
    let watched: Vec<PathBuf> = watched.map(|entry| entry.path()).collect();
    let _ = fs::remove_dir_all(nodes.join(node.to_string()));
    watched.iter().filter(|path| fs::remove_file(path).is_ok()).count() > 0
}

fn entries(folder: &Path) -> impl Iterator<Item = DirEntry> {
    fs::read_dir(folder).into_iter().flatten().flatten()
}

/// The ports that a segment belongs to; `None` for what is no port's.
fn ports(path: &Path, prefix: &str) -> Option<Vec<u128>> {
    let suffix = path.extension()?.to_str()?;
    let name = path.file_stem()?.to_str()?.strip_prefix(prefix)?;
    if !SUFFIXES.contains(&suffix) {
        return None;
    }
    let ends = if suffix == "connection" { 2 } else { 1 };
    let ports: Vec<u128> = name.rsplit('_').take(ends).filter_map(|word| word.parse().ok()).collect();
    (ports.len() == ends).then_some(ports)
}

/// Ports of all nodes, alive or not yet buried.
fn tags(nodes: &Path) -> BTreeSet<u128> {
    let tag = |entry: DirEntry| {
        let path = entry.path();
        let tagged = path.extension() == Some(OsStr::new("port_tag"));
        let word = path.file_stem()?.to_str()?.rsplit('_').next()?.parse().ok();
        word.filter(|_| tagged)
    };
    entries(nodes).map(|node| node.path()).flat_map(|node| entries(&node).collect::<Vec<_>>()).filter_map(tag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::name::ServiceName;
    use shatter_proto::place::Place;

    #[test]
    fn what_nobody_has_a_tag_for_is_removed_at_the_second_look() {
        let root = tempfile::tempdir().unwrap();
        let uid = rustix::process::geteuid().as_raw();
        let place = Place::new(&ServiceName::new("orphans").unwrap(), Some(root.path()), uid);
        place.create().unwrap();
        let instance = Instance::random(&place).unwrap();
        instance.create(uid).unwrap();
        let node = instance.folder.join("nodes/77");
        fs::create_dir_all(&node).unwrap();
        fs::write(node.join(format!("{}11.port_tag", instance.prefix)), "").unwrap();
        let shared = |name: &str| Path::new(shared_memory::FOLDER).join(format!("{}{name}", instance.prefix));
        let kept = ["a1_11.data", "a1_11.event_mgmt", "a1_99.dynamic", "node.global_mgmt", "b_x.data"].map(shared);
        let gone = ["a1_22.data", "a1_11_22.connection", "a1_22_11.connection", "a1_22.event_mgmt"].map(shared);
        let socket = instance.folder.join(format!("{}22.event", instance.prefix));
        for path in kept.iter().chain(&gone).chain([&socket]) {
            fs::write(path, "").unwrap();
        }
        let mut orphans = Orphans::default();
        assert_eq!((orphans.bury(&instance), orphans.bury(&instance), orphans.bury(&instance)), (0, 5, 0));
        assert!(kept.iter().all(|path| path.exists()) && !gone.iter().chain([&socket]).any(|path| path.exists()));
        kept.iter().for_each(|path| fs::remove_file(path).unwrap());
    }
}
