//! Every crate that is published makes a package that stands by itself.

use serde_json::Value;
use shatter_tests::sources::{CRATES, check, root};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

/// Crates that are not published.
const PRIVATE: [&str; 2] = ["server/lab", "tests"];

/// Files that a package may hold beside its sources.
const EXTRAS: [&str; 15] = [
    "Cargo.lock",
    "Cargo.toml",
    "Cargo.toml.orig",
    ".cargo_vcs_info.json",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "build.rs",
    "cbindgen.toml",
    "dist/",
    "include/shatter.h",
    "materials.toml",
    "pyproject.toml",
    "python/",
    "shatterd.toml",
];

/// A package holds less, bytes: no mesh and no picture.
const BYTES_MAX: u64 = 3 << 20;

/// Output of cargo.
fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO")).args(arguments).args(["--offline"]).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The crates of the workspace, as cargo describes them, by their folders.
fn crates() -> Vec<(&'static str, Value)> {
    let text = cargo(&["metadata", "--format-version", "1", "--no-deps", "--locked"]);
    let metadata: Value = serde_json::from_str(&text).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let of = |folder: &'static str| {
        let manifest = root().join(folder).join("Cargo.toml");
        let own = packages.iter().find(|own| Path::new(own["manifest_path"].as_str().unwrap()) == manifest);
        (folder, own.unwrap_or_else(|| panic!("{folder} is no member")).clone())
    };
    CRATES.map(|(folder, _)| of(folder)).to_vec()
}

fn is_published(own: &Value) -> bool {
    own["publish"].is_null()
}

#[test]
fn every_published_crate_says_what_a_registry_wants_to_know() {
    let mut violations = Vec::new();
    for (folder, own) in crates() {
        assert_eq!(is_published(&own), !PRIVATE.contains(&folder), "{folder}");
        if !is_published(&own) {
            continue;
        }
        let text = |key: &str| own[key].as_str().unwrap_or_default();
        let count = |key: &str| own[key].as_array().map_or(0, Vec::len);
        let readme = fs::read_to_string(root().join(folder).join(text("readme"))).unwrap_or_default();
        let rules = [
            ("a description", text("description").len() >= 20),
            ("a license", text("license") == "MIT OR Apache-2.0"),
            ("a README.md of 10 to 40 lines", (10..=40).contains(&readme.lines().count())),
            ("a README.md that names it first", readme.starts_with("# shatter-")),
            ("one to five keywords", (1..=5).contains(&count("keywords"))),
            ("a category", count("categories") > 0),
        ];
        let missing = rules.iter().filter(|(_, holds)| !holds);
        violations.extend(missing.map(|(what, _)| format!("{folder} has not {what}")));
    }
    check("published crates are described", violations);
}

#[test]
fn neighbors_are_asked_for_by_their_version() {
    let all = crates();
    let mut violations = Vec::new();
    for (folder, own) in all.iter().filter(|(_, own)| is_published(own)) {
        for dependency in own["dependencies"].as_array().unwrap().iter().filter(|own| !own["path"].is_null()) {
            let (name, asked) = (&dependency["name"], dependency["req"].as_str().unwrap());
            let neighbor = all.iter().find(|(_, own)| own["name"] == *name).map(|(_, own)| own).unwrap();
            if asked != format!("^{}", neighbor["version"].as_str().unwrap()) || !is_published(neighbor) {
                violations.push(format!("{folder} asks for {name} {asked}"));
            }
        }
    }
    check("a package finds its neighbors in a registry", violations);
}

/// `path` without `.` and `..`; `None` if it leaves the folder that it starts in.
fn within(path: &Path) -> Option<PathBuf> {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => plain.push(name),
            Component::ParentDir if !plain.pop() => return None,
            _ => {}
        }
    }
    Some(plain)
}

/// Files that a source reads when it is compiled.
fn read_by(source: &str) -> impl Iterator<Item = &str> {
    let marks = [concat!("include_", "str!(\""), concat!("include_", "bytes!(\""), concat!("#[pa", "th = \"")];
    marks.into_iter().flat_map(|mark| source.split(mark).skip(1)).filter_map(|rest| Some(rest.split_once('"')?.0))
}

#[test]
fn a_package_holds_what_its_sources_read_and_nothing_of_tests() {
    let mut violations = Vec::new();
    for (folder, own) in crates().into_iter().filter(|(_, own)| is_published(own)) {
        let name = own["name"].as_str().unwrap();
        let listed = cargo(&["package", "--list", "--allow-dirty", "--locked", "--package", name]);
        let listed: BTreeSet<&Path> = listed.lines().map(Path::new).collect();
        assert!(listed.contains(Path::new("README.md")), "{folder} {listed:?}");
        let is_source = |path: &Path| path.starts_with("src") && path.extension().is_some_and(|ending| ending == "rs");
        let may = |path: &Path| is_source(path) || EXTRAS.iter().any(|own| path.starts_with(own));
        violations
            .extend(listed.iter().filter(|path| !may(path)).map(|path| format!("{folder} ships {}", path.display())));
        let mut bytes = 0;
        for path in &listed {
            let Ok(text) = fs::read(root().join(folder).join(path)) else { continue };
            bytes += text.len() as u64;
            let text = String::from_utf8(text).unwrap();
            let wanted = read_by(&text).filter(|_| is_source(path));
            let missing = wanted.filter(|file| {
                let beside = within(&path.with_file_name("").join(file));
                !beside.is_some_and(|file| listed.contains(file.as_path()))
            });
            violations
                .extend(missing.map(|file| format!("{folder}/{} reads {file}, which is not shipped", path.display())));
        }
        if bytes > BYTES_MAX {
            violations.push(format!("{folder} ships {bytes} bytes"));
        }
    }
    check("packages stand by themselves", violations);
}
