//! Every dependency supports the oldest Rust that the workspace promises, and is built once.

use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

/// Major, minor and patch; missing parts are 0.
fn version(text: &str) -> [u32; 3] {
    let mut parts = text.split('.').map(|part| part.parse().unwrap_or(0));
    [0; 3].map(|zero: u32| parts.next().unwrap_or(zero))
}

#[test]
fn no_dependency_needs_a_newer_rust_than_the_workspace_promises() {
    let arguments =
        ["metadata", "--format-version", "1", "--locked", "--offline", "--filter-platform", "x86_64-unknown-linux-gnu"];
    let output = Command::new(env!("CARGO")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let own = packages.iter().find(|package| package["name"] == "shatter-tests").unwrap();
    let promised = version(own["rust_version"].as_str().unwrap());
    let newer: Vec<String> = packages
        .iter()
        .filter_map(|package| Some((package, package["rust_version"].as_str()?)))
        .filter(|(_, needed)| version(needed) > promised)
        .map(|(package, needed)| format!("{} {} needs Rust {needed}", package["name"], package["version"]))
        .collect();
    assert!(newer.is_empty(), "newer than Rust {promised:?}:\n  {}", newer.join("\n  "));
    assert!(packages.len() > 100, "all dependencies are listed");
}

/// Every package with its features, where edges of these kinds are followed.
fn features(edges: &str) -> BTreeSet<String> {
    let arguments = ["tree", "--workspace", "--locked", "--offline", "--prefix", "none", "-f", "{p}: {f}", "-e", edges];
    let output = Command::new(env!("CARGO")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

#[test]
fn programs_and_tests_share_one_build_of_every_dependency() {
    let [of_programs, of_tests] = ["normal,build", "normal,build,dev"].map(features);
    let twice: Vec<&str> = of_programs.difference(&of_tests).map(String::as_str).collect();
    assert!(twice.is_empty(), "a dev-dependency widens features, so these are built twice:\n  {}", twice.join("\n  "));
    assert!(of_programs.len() > 100, "all dependencies are listed");
}
