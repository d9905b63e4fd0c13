//! What works around the transport is in one module, each with its reproduction and what to delete.

use shatter_tests::sources::{check, root, shipped, sources};
use std::fs;

/// The module.
const FOLDER: &str = "proto/transport/src/workarounds/";

/// The version of the transport that is worked around.
const VERSION: &str = concat!("iceoryx2 ", "0.10");

/// Where the version stands for another reason: it is part of what a daemon says of itself.
const TOLD: &str = "proto/transport/src/lib.rs";

/// Settings and calls that are named in the module alone; callers use its constants and functions.
const NAMED_THERE: [&str; 10] = [
    "AllocationStrategy::",
    "BackpressureStrategy::",
    "Advice::LinuxPopulateWrite",
    "NonBlockingLockShared",
    "cleanup_dead_nodes_on",
    "global_mgmt",
    "iceoryx2_cal",
    "port_tag",
    "Resource::Nofile",
    "try_wait(|_| {})",
];

#[test]
fn workarounds_of_the_transport_are_in_one_module() {
    let mut broken = Vec::new();
    for (name, text) in sources().iter().filter(|(name, _)| !name.starts_with(FOLDER)) {
        for (at, line) in shipped(name, text) {
            let versioned = line.contains(VERSION) && name != TOLD;
            if versioned || NAMED_THERE.iter().any(|word| line.contains(word)) {
                broken.push(format!("{name}:{at}: {}", line.trim()));
            }
        }
    }
    check("the transport is worked around in one module", broken);
}

#[test]
fn every_workaround_says_what_an_upgrade_deletes() {
    let index = fs::read_to_string(root().join(FOLDER).join("mod.rs")).unwrap();
    let mut broken = Vec::new();
    let mut count = 0;
    for (name, text) in sources().iter().filter(|(name, _)| name.starts_with(FOLDER) && !name.ends_with("mod.rs")) {
        let file = name.trim_start_matches(FOLDER).trim_end_matches(".rs");
        let head: String = text.lines().take_while(|line| line.starts_with("//!")).collect();
        // A file may be the second half of another's workaround.
        let refers = head.contains("what to delete");
        let marks = ["**Symptom.**", "**Reproduction** (iceoryx2 0.10.0).", "**Upstream.**", "**Delete.**"];
        let missing = marks.iter().filter(|mark| !refers && !head.contains(**mark));
        broken.extend(missing.map(|mark| format!("{name} has no {mark}")));
        if !index.contains(&format!("[`{file}`]")) {
            broken.push(format!("{FOLDER}mod.rs does not list {file}"));
        }
        count += 1;
    }
    check("every workaround says what an upgrade deletes", broken);
    assert!(count >= 10, "{count} files");
}
