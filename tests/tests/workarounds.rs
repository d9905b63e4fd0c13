//! Workarounds for the transport are in one module, each with its reproduction and the code to delete.

use shatter_tests::sources::{check, root, shipped, sources};
use std::fs;

/// The module.
const FOLDER: &str = "proto/transport/src/workarounds/";

/// Version of the transport that the workarounds are for.
const VERSION: &str = concat!("iceoryx2 ", "0.10");

/// File that names the version for another reason: a daemon announces it to its clients.
const ANNOUNCED: &str = "proto/transport/src/lib.rs";

/// Settings and calls that only the module names; callers use its constants and functions.
const ONLY_THERE: [&str; 10] = [
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
    let mut violations = Vec::new();
    for (name, text) in sources().iter().filter(|(name, _)| !name.starts_with(FOLDER)) {
        for (at, line) in shipped(name, text) {
            let versioned = line.contains(VERSION) && name != ANNOUNCED;
            if versioned || ONLY_THERE.iter().any(|word| line.contains(word)) {
                violations.push(format!("{name}:{at}: {}", line.trim()));
            }
        }
    }
    check("the transport is worked around in one module", violations);
}

#[test]
fn every_workaround_says_what_an_upgrade_deletes() {
    let index = fs::read_to_string(root().join(FOLDER).join("mod.rs")).unwrap();
    let mut violations = Vec::new();
    let mut count = 0;
    for (name, text) in sources().iter().filter(|(name, _)| name.starts_with(FOLDER) && !name.ends_with("mod.rs")) {
        let file = name.trim_start_matches(FOLDER).trim_end_matches(".rs");
        let head: String = text.lines().take_while(|line| line.starts_with("//!")).collect();
        // A file may be the second part of another file's workaround.
        let refers = head.contains("what to delete");
        let marks = ["**Symptom.**", "**Reproduction** (iceoryx2 0.10.0).", "**Upstream.**", "**Delete.**"];
        let missing = marks.iter().filter(|mark| !refers && !head.contains(**mark));
        violations.extend(missing.map(|mark| format!("{name} has no {mark}")));
        if !index.contains(&format!("[`{file}`]")) {
            violations.push(format!("{FOLDER}mod.rs does not list {file}"));
        }
        count += 1;
    }
    check("every workaround says what an upgrade deletes", violations);
    assert!(count >= 10, "{count} files");
}
