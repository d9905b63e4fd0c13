//! Dependencies between crates, and unique names of public types. Each rule names the place that breaks it.

use shatter_tests::imports::Imports;
use shatter_tests::sources::{CRATES, check, code, files, owner, root, shipped, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

#[test]
fn every_package_is_used_by_the_crate_that_owns_it() {
    let owners = [
        ("iceoryx2", "proto/transport"),
        ("iceoryx2", "client"),
        ("iceoryx2", "server"),
        ("serde", "proto/transport"),
        ("serde", "server"),
        ("serde", "server/fracture"),
        ("nalgebra", "server/fracture"),
        ("faer", "server/fracture"),
        ("rayon", "server/fracture"),
        ("rayon", "server"),
        ("tokio", "server"),
        ("tracing", "server"),
    ];
    let sources = sources();
    let mut violations = Vec::new();
    for (package, owner) in owners {
        let manifest = fs::read_to_string(root().join(owner).join("Cargo.toml")).unwrap();
        let (use_a, use_b) = (format!("use {package}"), format!("{package}::"));
        let used = sources.iter().any(|(name, text)| {
            name.starts_with(&format!("{owner}/src/"))
                && shipped(name, text).iter().any(|(_, line)| line.contains(&use_a) || line.contains(&use_b))
        });
        if !manifest.contains(&format!("{package}.workspace = true")) || !used {
            violations.push(format!("{owner} does not use {package}"));
        }
    }
    check("packages are really used", violations);
}

/// Bindings, whose types have the names of the types that they bind.
const BINDINGS: [&str; 2] = ["client/c", "client/python"];

/// Packages that are excluded from crates that hosts build, or that compute.
const FOREIGN: [(&str, &[&str]); 6] = [
    ("proto", &["iceoryx2.", "tokio", "clap"]),
    ("client", &["tokio", "faer", "clap", "plotters", "hdrhistogram", "toml"]),
    ("client/export", &["iceoryx2", "tokio"]),
    ("server", &["plotters", "png"]),
    ("server/engine", &["iceoryx2", "tokio"]),
    ("server/fracture", &["iceoryx2", "tokio", "clap"]),
];

/// Dependencies of a crate: of its shipped code, and of its tests only.
fn dependencies(folder: &str) -> [Vec<String>; 2] {
    let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
    ["[dependencies]", "[dev-dependencies]"].map(|section| {
        let lines = manifest.lines().skip_while(|line| *line != section).skip(1);
        let lines = lines.take_while(|line| !line.starts_with('['));
        lines.filter_map(|line| Some(line.split_once(['.', ' '])?.0.to_owned())).collect()
    })
}

#[test]
fn no_dependency_is_idle() {
    let sources = sources();
    let mut violations = Vec::new();
    for (folder, _) in CRATES {
        let own: Vec<&(String, String)> = sources.iter().filter(|(name, _)| owner(name) == folder).collect();
        // All code of the test crate is a test, and so are the optional parts of an example.
        let all = |path: &str| own.iter().any(|(_, text)| text.contains(path));
        let ships =
            |path: &str| own.iter().any(|(name, text)| shipped(name, text).iter().any(|(_, line)| line.contains(path)));
        let [normal, of_tests] = dependencies(folder);
        for dependency in &normal {
            let path = dependency.replace('-', "_");
            let is_used = if folder == "tests" || dependency == "rapier3d-f64" { all(&path) } else { ships(&path) };
            if !is_used {
                violations.push(format!("{folder} depends on {dependency}, and what it ships does not use it"));
            }
        }
        let idle =
            of_tests.iter().filter(|dependency| !all(&dependency.replace('-', "_")) || normal.contains(dependency));
        violations.extend(idle.map(|dependency| format!("{folder} has no use for {dependency} in its tests alone")));
    }
    check("no dependency is idle", violations);
}

#[test]
fn crate_dependencies_point_one_way() {
    let mut violations = Vec::new();
    for (folder, allowed) in CRATES {
        let [normal, _] = dependencies(folder);
        let own = normal.iter().filter_map(|name| name.strip_prefix("shatter-"));
        violations.extend(own.filter(|name| !allowed.contains(name)).map(|name| format!("{folder} → {name}")));
    }
    for (folder, names) in FOREIGN {
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
        let (manifest, _) = manifest.split_once("[dev-dependencies]").unwrap_or((&manifest, ""));
        let (_, manifest) = manifest.split_once("[dependencies]").unwrap();
        let has = |name: &&&str| manifest.lines().any(|line| line.starts_with(**name));
        violations.extend(names.iter().filter(has).map(|name| format!("{folder} → {name}")));
    }
    let members = files("Cargo.toml").len() - 1;
    assert_eq!(members, CRATES.len(), "every crate is judged");
    check("dependencies point one way", violations);
}

#[test]
fn no_public_type_has_the_name_of_another_crates() {
    let mut owners: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (name, text) in sources().iter().filter(|(name, _)| !BINDINGS.contains(&owner(name))) {
        for (_, line) in shipped(name, text) {
            let words: Vec<&str> =
                line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).collect();
            if let ["pub", "struct" | "enum" | "trait" | "type" | "union", own, ..] = words[..] {
                owners.entry(own.to_owned()).or_default().insert(owner(name));
            }
        }
    }
    assert!(owners.len() > 300, "{} public types", owners.len());
    // Each program has its own `Args`, which no other crate sees.
    let twice = owners.into_iter().filter(|(name, owners)| owners.len() > 1 && name != "Args");
    check("one name, one type", twice.map(|(name, owners)| format!("{name}: {owners:?}")).collect());
}

/// Folders of crates that hosts link, whose public interface has no row of shared memory.
const WITHOUT_ROWS: [&str; 2] = ["client/src", "client/export/src"];

/// True for the name of a row of shared memory, or of a type that holds rows.
fn is_row(name: &str) -> bool {
    name.ends_with("Wire") || name.ends_with("Row") || ["ResultView", "SectionsMut", "CheckedLayout"].contains(&name)
}

/// Public signatures of a source, except those that documentation hides: items, fields, re-exports and implementations of traits, each with
/// the number of its first line.
fn signatures(lines: &[(usize, String)]) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut is_hidden = false;
    let mut lines = lines.iter();
    while let Some((number, line)) = lines.next() {
        let text = code(line).trim();
        let is_public = text.starts_with("pub ") || (text.starts_with("impl") && text.contains(" for "));
        if !is_public {
            is_hidden = text == "#[doc(hidden)]" || (is_hidden && text.is_empty());
            continue;
        }
        let ends: &[char] = match text {
            text if text.starts_with("pub use ") => &[';'],
            text if text.contains("fn ") || text.starts_with("impl") => &['{', ';'],
            _ => &['{', ';', ','],
        };
        let mut signature = text.to_owned();
        while !signature.ends_with(ends) {
            let Some((_, line)) = lines.next() else { break };
            signature = format!("{signature} {}", code(line).trim());
        }
        if !std::mem::take(&mut is_hidden) {
            found.push((*number, signature));
        }
    }
    found
}

/// The first name of a row in a signature.
fn row_in(signature: &str) -> Option<&str> {
    signature.split(|c: char| !c.is_alphanumeric() && c != '_').find(|name| is_row(name))
}

#[test]
fn no_host_sees_a_row_of_shared_memory() {
    let (mut violations, mut count) = (Vec::new(), 0);
    for (name, text) in sources().iter().filter(|(name, _)| WITHOUT_ROWS.iter().any(|folder| name.starts_with(folder)))
    {
        for (number, signature) in signatures(&shipped(name, text)) {
            count += 1;
            violations.extend(row_in(&signature).map(|row| format!("{name}:{number}: {row}")));
        }
    }
    assert!(count > 300, "{count} public signatures");
    check("public signatures hold plain types", violations);
}

#[test]
fn a_row_is_found_in_every_kind_of_signature() {
    let text = "\
pub fn a(&self) -> Option<SummaryWire> {
pub fn b(
    row: &ServiceStatusRow,
) -> u32 {
pub use x::{
    A, ResultView,
};
    pub rows: &'a [BondWire],
impl From<&ObjectRow> for Facts {
pub(crate) fn c(row: &RunWire) {
fn d(row: &RunWire) {
#[doc(hidden)]
pub fn e(&self) -> ResultView<'_> {
pub fn f(&self) -> Row2 {
";
    let lines: Vec<(usize, String)> = (1..).zip(text.lines().map(str::to_owned)).collect();
    let found = signatures(&lines);
    let rows: Vec<(usize, Option<&str>)> = found.iter().map(|(number, own)| (*number, row_in(own))).collect();
    let wanted = [(1, "SummaryWire"), (2, "ServiceStatusRow"), (5, "ResultView"), (8, "BondWire"), (9, "ObjectRow")];
    assert_eq!(rows, wanted.map(|(n, row)| (n, Some(row))).into_iter().chain([(14, None)]).collect::<Vec<_>>());
}

/// Folders whose files import each other in cycles of at most [`CYCLE_MAX`].
const WITHOUT_CYCLES: [&str; 6] =
    ["server/src", "server/engine/src", "server/fracture/src", "proto/src", "client/src", "client/export/src"];

/// Largest number of files that may import each other in a cycle: those that cannot be separated without a third.
const CYCLE_MAX: usize = 3;

#[test]
fn files_import_each_other_in_small_cycles_at_most() {
    let sources = sources();
    let cycles = |folder: &str| -> Vec<String> {
        let imports = Imports::of(folder, &sources);
        imports.cycles(CYCLE_MAX).iter().map(|cycle| format!("{folder}: {}", cycle.join(", "))).collect()
    };
    check("no cycle of more than three files", WITHOUT_CYCLES.into_iter().flat_map(cycles).collect());
}

#[test]
fn a_cycle_is_found_through_re_exports() {
    let file = |name: &str, text: &str| (format!("x/src/{name}"), text.to_owned());
    let sources = [
        file("lib.rs", "mod a;\nmod b;\npub use a::A;\npub use b::{B, deep::C};\n"),
        file("a.rs", "use crate::{\n    B,\n};\npub struct A;\n"),
        file("b/mod.rs", "pub mod deep;\nuse self::deep::C;\npub struct B;\n"),
        file("b/deep.rs", "use super::super::A;\npub struct C;\n"),
    ];
    let imports = Imports::of("x/src", &sources);
    assert_eq!(imports.cycles(2), [vec!["a.rs", "b/deep.rs", "b/mod.rs"]]);
    assert!(imports.cycles(3).is_empty());
}
