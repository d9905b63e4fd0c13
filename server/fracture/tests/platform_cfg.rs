//! The engine compiles on systems without Unix: calls specific to a system are below a `cfg` and have a counterpart.

use std::path::{Path, PathBuf};

/// Paths that exist only on some systems.
const PARTICULAR: [&str; 4] = ["std::os::", "rustix", "libc::", "nix::"];

/// Largest distance from a `cfg` to a specific call below it, lines.
const LINES: usize = 4;

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            sources(&entry, found);
        } else if entry.extension().is_some_and(|own| own == "rs") && !entry.to_string_lossy().ends_with("tests.rs") {
            found.push(entry);
        }
    }
}

#[test]
fn platform_specific_code_is_below_a_cfg() {
    let mut files = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    assert!(files.len() > 100);
    let mut naked = Vec::new();
    for file in &files {
        let text = std::fs::read_to_string(file).unwrap();
        let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let lines: Vec<&str> = shipped.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let code = line.split("//").next().unwrap();
            let guarded = lines[at.saturating_sub(LINES)..=at].iter().any(|line| line.contains("#[cfg(unix)]"));
            if PARTICULAR.iter().any(|call| code.contains(call)) && !guarded {
                naked.push(format!("{}:{}: {line}", file.display(), at + 1));
            }
        }
        assert_eq!(shipped.matches("#[cfg(unix)]").count(), shipped.matches("#[cfg(not(unix))]").count(), "{file:?}");
    }
    assert!(naked.is_empty(), "without `#[cfg(unix)]`:\n{}", naked.join("\n"));
}
