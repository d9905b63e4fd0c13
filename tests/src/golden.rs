//! Golden comparison: equal requests to the programs of two commits give equal fragments.
//!
//! Both are driven by their command lines, whose contract is stable, so the commits may differ in everything else. The comparison covers
//! the hashes of all sections of plain numbers, and every value of the documents that both print, except times.

use crate::fixture::Fixture;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Commit to compare with, if there is no tag of that name.
const TAG: &str = "golden";

/// Effects of the golden commit; a request switches off those that it does not name.
const EFFECTS: [&str; 16] = [
    "elastic",
    "tensile",
    "interior",
    "examples",
    "warp",
    "slivers",
    "release",
    "normals",
    "uv",
    "bonds",
    "debris",
    "hulls",
    "attributes",
    "skin",
    "anchored",
    "gravity",
];

/// Effects that the golden commit does not have. No request enables them, and their rows are left out.
const LATER: [&str; 1] = ["dynamics"];

/// Keys of documents that differ from run to run, or that the hash of a section covers.
const LEFT_OUT: [&str; 11] = [
    "ns",
    "time_ns",
    "round_trip_ns",
    "handle",
    "file",
    "files",
    "response_bytes",
    "output_hash",
    "debris",
    "bytes",
    "retry_after_ms",
];

/// Sections of rows, whose values are compared one by one.
const ROWS: [&str; 3] = ["summary", "stages", "effects"];

/// Results by request.
pub type Results = BTreeMap<String, Value>;

/// Folder of the requests and the recordings.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden")
}

/// Runs the requests, all or those with a star, with the programs of this build or with those in a folder. Elements are linear, and
/// fragments have the lattice's surface.
pub fn results(programs: Option<PathBuf>, all: bool) -> Results {
    let mut fixture = programs.map_or_else(Fixture::new, Fixture::with_programs);
    let scene = std::fs::read_to_string(folder().join("scene.toml")).unwrap();
    let scene = scene.replace("shape = ", "surface = \"lattice\"\nelements = \"linear\"\nshape = ");
    std::fs::write(fixture.path("scene.toml"), scene).unwrap();
    let text = std::fs::read_to_string(folder().join("requests.txt")).unwrap();
    let lines = text.lines().filter(|line| line.starts_with("* ") || all && line.starts_with("  "));
    let (mut results, mut last) = (Results::new(), Value::Null);
    for line in lines.map(|line| line[2..].trim()) {
        let words = line.split_whitespace().flat_map(|word| match word.strip_prefix("effects=") {
            Some(on) => effects(on),
            None => vec![filled(word, &last, &fixture)],
        });
        let words: Vec<String> = words.collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match words[0] {
            "bake" if words[1] == "--shape" => {
                fixture.ok("shatterd", &[&words[..], &["--surface", "lattice", "--elements", "linear"]].concat());
            }
            "bake" => drop(fixture.ok("shatterd", &words)),
            "serve" => {
                fixture.end();
                fixture.serve(&words[1..]);
            }
            _ => {
                let (_, document) = fixture.json("shatter", &words);
                assert!(document["handle"].is_null() || document["status"] == "ok", "{line}: {document}");
                results.insert(line.to_owned(), canonical(&document));
                if !document["handle"].is_null() {
                    last = document;
                }
            }
        }
    }
    results
}

/// A word of a request with its placeholders filled in.
fn filled(word: &str, last: &Value, fixture: &Fixture) -> String {
    let word =
        word.replace("{handle}", &last["handle"].to_string()).replace("scene.toml", &shown(fixture, "scene.toml"));
    let word = word.replace("pieces.glb", &shown(fixture, "pieces.glb"));
    if let Some((before, fragment)) = word.split_once("{center/") {
        let fragment: usize = fragment.trim_end_matches('}').parse().unwrap();
        let row = &last["fragments"][fragment];
        let center: Vec<String> = row["center_m"].as_array().unwrap().iter().map(Value::to_string).collect();
        return format!("{before}{}", center.join(","));
    }
    word
}

/// Options that switch every effect on or off by name.
fn effects(on: &str) -> Vec<String> {
    let on: Vec<&str> = on.split(',').filter(|effect| *effect != "none").collect();
    let off: Vec<&str> = EFFECTS.into_iter().filter(|effect| !on.contains(effect)).collect();
    let options = [("enable", on), ("disable", off)];
    let named = options.into_iter().filter(|(_, effects)| !effects.is_empty());
    named.map(|(option, effects)| format!("--{option}={}", effects.join(","))).collect()
}

fn shown(fixture: &Fixture, name: &str) -> String {
    fixture.path(name).to_str().unwrap().to_owned()
}

/// The compared part of a document.
fn canonical(document: &Value) -> Value {
    match document {
        Value::Object(map) => {
            let kept = map.iter().filter(|(key, _)| !LEFT_OUT.contains(&key.as_str()));
            let without = |all: &[Value], names: &[&str]| {
                let named = |row: &&Value| row["name"].as_str().is_some_and(|name| names.contains(&name));
                Value::Array(all.iter().filter(|row| !named(row)).map(canonical).collect())
            };
            let value = |key: &str, value: &Value| match (key, value) {
                ("sections", Value::Array(all)) => without(all, &ROWS),
                ("stages", Value::Array(all)) => without(all, &LATER),
                _ => canonical(value),
            };
            Value::Object(kept.map(|(key, held)| (key.clone(), value(key, held))).collect::<Map<_, _>>())
        }
        Value::Array(all) => Value::Array(all.iter().map(canonical).collect()),
        _ => document.clone(),
    }
}

/// Differences between two sets of results: requests, and the paths of values that both have.
pub fn differences(before: &Results, now: &Results) -> Vec<String> {
    let mut found = Vec::new();
    for (request, old) in before {
        match now.get(request) {
            Some(new) => differ(request, old, new, &mut found),
            None => found.push(format!("{request}: not answered now")),
        }
    }
    found
}

fn differ(at: &str, old: &Value, new: &Value, found: &mut Vec<String>) {
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => {
            let both = old.iter().filter_map(|(key, value)| Some((key, value, new.get(key)?)));
            both.for_each(|(key, old, new)| differ(&format!("{at} > {key}"), old, new, found));
        }
        (Value::Array(old), Value::Array(new)) if old.len() == new.len() => {
            let pairs = old.iter().zip(new).enumerate();
            pairs.for_each(|(index, (old, new))| differ(&format!("{at} > {index}"), old, new, found));
        }
        _ if old == new => {}
        _ => found.push(format!("{at}: {} before, {} now", cut(old), cut(new))),
    }
}

fn cut(value: &Value) -> String {
    value.to_string().chars().take(80).collect()
}

/// Properties of the processor that decide rounding: its instructions, and the caches that set block sizes.
pub fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        let line = text.lines().find(|line| line.split(':').next().is_some_and(|key| key.trim() == name));
        line.and_then(|line| line.split(':').nth(1)).unwrap_or("").trim().to_owned()
    };
    let words =
        [std::env::consts::ARCH.to_owned(), field("vendor_id"), field("cpu family"), field("model"), field("CPU part")];
    let known: Vec<String> = words.into_iter().filter(|word| !word.is_empty()).collect();
    known.join("-").to_lowercase()
}

/// Programs of the golden commit; builds them in the target folder if they do not exist.
///
/// # Panics
/// If the repository has no such commit, or it cannot be built.
pub fn programs_before() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let stated = std::fs::read_to_string(folder().join("commit")).unwrap();
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().unwrap();
        output.status.success().then(|| String::from_utf8(output.stdout).unwrap().trim().to_owned())
    };
    let commit = git(&["rev-parse", "--verify", "--quiet", &format!("{TAG}^{{commit}}")])
        .or_else(|| git(&["rev-parse", "--verify", "--quiet", &format!("{}^{{commit}}", stated.trim())]));
    let commit = commit.unwrap_or_else(|| panic!("no commit {}: fetch the whole history", stated.trim()));
    let base = root.join("target/golden");
    let (tree, target) = (base.join("tree"), base.join("target"));
    if tree.exists() {
        let _ = git(&["worktree", "remove", "--force", tree.to_str().unwrap()]);
    }
    assert!(git(&["worktree", "add", "--force", "--detach", tree.to_str().unwrap(), &commit]).is_some());
    let arguments = ["build", "--quiet", "--release", "--locked", "--workspace", "--bins", "--target-dir"];
    let built = Command::new(env!("CARGO")).args(arguments).arg(&target).current_dir(&tree).status().unwrap();
    let _ = git(&["worktree", "remove", "--force", tree.to_str().unwrap()]);
    assert!(built.success(), "the golden commit {commit} does not build");
    target.join("release")
}
