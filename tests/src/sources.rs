//! Sources of the project, as rules about them see them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Root of the project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// All files of the project with this ending, sorted: those that git tracks, or, in an archive without git's folder, those that
/// `.gitignore` does not name.
pub fn files(ending: &str) -> Vec<PathBuf> {
    let all = tracked().unwrap_or_else(|| {
        println!("no git: files are judged as they lie in the folder");
        lying(&root())
    });
    all.into_iter().map(|name| root().join(name)).filter(|path| path.to_string_lossy().ends_with(ending)).collect()
}

/// Paths of the tracked files that exist, relative to the root, sorted; `None` if the root is not a work tree of git.
pub fn tracked() -> Option<Vec<PathBuf>> {
    let root = root();
    if !root.join(".git").exists() {
        return None;
    }
    let listed = Command::new("git").arg("-C").arg(&root).args(["ls-files", "-z"]).output().ok()?;
    let names = String::from_utf8(listed.stdout).ok().filter(|_| listed.status.success())?;
    let paths: BTreeSet<PathBuf> = names.split_terminator('\0').map(PathBuf::from).collect();
    Some(paths.into_iter().filter(|path| root.join(path).exists()).collect())
}

/// Paths of the files below `root` that are not hidden and that `.gitignore` does not name, relative to it, sorted.
pub fn lying(root: &Path) -> Vec<PathBuf> {
    let ignored = fs::read_to_string(root.join(".gitignore")).unwrap_or_default();
    let ignored: BTreeSet<&str> = ignored.lines().map(|line| line.trim_matches('/')).collect();
    let mut found = BTreeSet::new();
    let mut open = vec![root.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = entry.file_name().unwrap().to_string_lossy().into_owned();
            let relative = entry.strip_prefix(root).unwrap().to_owned();
            match entry.is_dir() {
                _ if relative.to_str().is_some_and(|path| ignored.contains(path)) => {}
                true if name != "target" && !name.starts_with('.') => open.push(entry),
                true => {}
                false => drop(found.insert(relative)),
            }
        }
    }
    found.into_iter().collect()
}

/// All Rust files, by their paths from the root.
pub fn sources() -> Vec<(String, String)> {
    let root = root();
    files(".rs")
        .into_iter()
        .map(|path| {
            let name = path.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).unwrap();
            (name, text)
        })
        .collect()
}

/// Lines that ship: without test files and items marked `#[cfg(test)]`.
pub fn shipped(name: &str, text: &str) -> Vec<(usize, String)> {
    let test_file = name.starts_with("tests/")
        || name.contains("/tests/")
        || name.ends_with("tests.rs")
        || name.contains("/benches/")
        || name.contains("/examples/");
    if test_file {
        return Vec::new();
    }
    let mut kept = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((at, line)) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            // The next item ends at once (`mod tests;`), or with a closing brace in the first column.
            let one_line = lines.next().is_some_and(|(_, next)| next.ends_with(';'));
            let _ = !one_line && lines.any(|(_, line)| line == "}");
        } else {
            kept.push((at + 1, line.to_owned()));
        }
    }
    kept
}

/// Fails with every place that breaks the rule.
#[track_caller]
pub fn check(rule: &str, violations: Vec<String>) {
    assert!(violations.is_empty(), "{rule}:\n  {}", violations.join("\n  "));
}

/// A line without its comment.
pub fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or("")
}

/// The crates, and the crates that each of them may use.
pub const CRATES: [(&str, &[&str]); 14] = [
    ("proto", &[]),
    ("proto/transport", &["proto"]),
    ("client", &["export", "proto", "transport"]),
    ("client/c", &["client", "export", "proto"]),
    ("client/cli", &["cli-common", "client", "export", "proto", "view"]),
    ("client/cli/common", &["proto"]),
    ("client/export", &["proto"]),
    ("client/python", &["client", "export", "proto"]),
    ("client/view", &["client", "export", "proto"]),
    ("server", &["cli-common", "engine", "export", "fracture", "proto", "transport"]),
    ("server/engine", &["fracture", "proto"]),
    ("server/fracture", &[]),
    ("server/lab", &["cli-common", "client", "engine", "export", "fracture", "proto", "server"]),
    ("tests", &["client", "engine", "export", "fracture", "lab", "proto", "server", "transport"]),
];

/// Folder of the crate that a file belongs to.
pub fn owner(name: &str) -> &'static str {
    let within = |folder: &&str| name.strip_prefix(*folder).is_some_and(|rest| rest.starts_with('/'));
    CRATES.into_iter().map(|(folder, _)| folder).filter(within).max_by_key(|folder| folder.len()).unwrap_or("")
}
