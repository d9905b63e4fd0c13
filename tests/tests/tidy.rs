//! Rules for the sources that a program can check. Each names the file and line that breaks it.

use shatter_tests::sources::{check, code, files, lying, root, shipped, sources, tracked};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, PathBuf};
use std::process::Command;

/// Longest source file, lines.
const LINES_MAX: usize = 500;

#[test]
fn files_are_short() {
    let long = |(name, text): (String, String)| {
        let lines = text.lines().count();
        (lines > LINES_MAX).then(|| format!("{name}: {lines} lines"))
    };
    check("no source file is longer than 500 lines", sources().into_iter().filter_map(long).collect());
}

#[test]
fn shipped_code_has_no_unwrap() {
    let mut violations = Vec::new();
    for (name, text) in sources() {
        for (at, line) in shipped(&name, &text) {
            let code = code(&line);
            if [".unwrap()", ".expect(", "todo!(", "unimplemented!(", "dbg!("].iter().any(|word| code.contains(word)) {
                violations.push(format!("{name}:{at}: {}", line.trim()));
            }
        }
    }
    check("no unwrap, expect or stub outside tests", violations);
}

#[test]
fn no_todo_comments() {
    let mut violations = Vec::new();
    for (name, text) in sources() {
        for (at, line) in text.lines().enumerate() {
            let words = [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X")];
            if words.iter().any(|word| line.contains(word)) && !line.contains("issue ") {
                violations.push(format!("{name}:{}: {}", at + 1, line.trim()));
            }
        }
    }
    check("nothing is left to do without an issue", violations);
}

/// Folders and files that may use `unsafe`: shared memory, the transport's descriptors, memory maps, SIMD dispatch, the C interface, views
/// of Python, standard output before `main`, the C library's call that releases free memory.
const UNSAFE_ALLOWED: [&str; 11] = [
    "proto/src/zero_copy.rs",
    "proto/transport/src/",
    "client/src/",
    "client/c/src/",
    "client/cli/common/src/stdout.rs",
    "client/python/src/array.rs",
    "server/src/ipc/",
    "server/src/jobs/worker_pool.rs",
    "server/src/memory.rs",
    "server/fracture/src/database/container.rs",
    "server/fracture/src/centroidal/kernel.rs",
];

#[test]
fn unsafe_code_is_allowed_and_justified() {
    let mut violations = Vec::new();
    for (name, text) in sources() {
        let lines = shipped(&name, &text);
        for (index, (at, line)) in lines.iter().enumerate() {
            if !code(line).contains("unsafe ") || line.contains("unsafe_") {
                continue;
            }
            if !UNSAFE_ALLOWED.iter().any(|place| name.starts_with(place)) {
                violations.push(format!("{name}:{at}: unsafe has no business here"));
            }
            let before = lines[index.saturating_sub(8)..=index]
                .iter()
                .any(|(_, line)| line.contains("SAFETY") || line.contains("# Safety"));
            if !before {
                violations.push(format!("{name}:{at}: no SAFETY line"));
            }
        }
    }
    check("unsafe is rare and justified", violations);
}

#[test]
fn functions_are_short() {
    const FUNCTION_MAX: usize = 84;
    let mut violations = Vec::new();
    for (name, text) in sources() {
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let indent = line.len() - line.trim_start().len();
            let is_function = line.contains("fn ") && line.ends_with('{') && !line.trim_start().starts_with("//");
            let end = format!("{}}}", " ".repeat(indent));
            let length = lines[at..].iter().position(|line| **line == end).unwrap_or(0) + 1;
            if is_function && length > FUNCTION_MAX {
                violations.push(format!("{name}:{}: {length} lines", at + 1));
            }
        }
    }
    check("no function is longer than 84 lines", violations);
}

#[test]
fn the_engine_has_no_clock() {
    let mut violations = Vec::new();
    for (name, text) in sources().into_iter().filter(|(name, _)| name.starts_with("server/fracture/src/")) {
        for (at, line) in shipped(&name, &text) {
            if ["Instant::", "SystemTime", "std::process", "static mut"].iter().any(|word| code(&line).contains(word)) {
                violations.push(format!("{name}:{at}: {}", line.trim()));
            }
        }
    }
    check("the science knows nothing of clocks and processes", violations);
}

/// Folders that may read the time of day: to show it, and to start the processes of a load together.
const TIME_OF_DAY: [&str; 2] = ["server/src/catalog/", "server/lab/src/load/"];

#[test]
fn no_decision_depends_on_the_time_of_day() {
    let mut violations = Vec::new();
    for (name, text) in
        sources().into_iter().filter(|(name, _)| !TIME_OF_DAY.iter().any(|place| name.starts_with(place)))
    {
        for (at, line) in shipped(&name, &text) {
            if code(&line).contains("SystemTime") {
                violations.push(format!("{name}:{at}: {}", line.trim()));
            }
        }
    }
    check("clocks may jump: waits and ages are measured by the monotonic one", violations);
}

/// Names that may exist at the top level, without hidden files.
const TOP_LEVEL: [&str; 17] = [
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "SECURITY.md",
    "client",
    "config",
    "deny.toml",
    "proto",
    "server",
    "tests",
];

/// First parts of these paths that are not allowed.
fn odd(paths: &[PathBuf]) -> BTreeSet<String> {
    let first = |path: &PathBuf| match path.components().next() {
        Some(Component::Normal(name)) => Some(name.to_string_lossy().into_owned()),
        _ => None,
    };
    paths
        .iter()
        .filter_map(first)
        .filter(|name| !name.starts_with('.') && !TOP_LEVEL.contains(&name.as_str()))
        .collect()
}

#[test]
fn the_top_level_holds_the_agreed_tree() {
    let all = tracked().unwrap_or_else(|| lying(&root()));
    check("nothing else lies at the top level", odd(&all).into_iter().collect());
}

#[test]
fn generated_files_are_ignored() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(root().join(".gitignore"), folder.path().join(".gitignore")).unwrap();
    let left =
        ["broken.glb", "shatter-study/a.html", "shatter-demo/b.html", "rapier/film.glb", "databases/mug.shatter"];
    let more = [
        "broken.closed.glb",
        "env/a",
        "wheels/a",
        "study/a",
        "load/load.svg",
        "mug.xml",
        "mug_assets/a",
        "pieces/a",
        "again",
        "still",
        "strike",
    ];
    let left = [&left[..], &more].concat();
    for name in left.iter().chain(&["shares/mug.0-of-2.share", "client/notes.md", "odd/file.rs"]) {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }
    let found = lying(folder.path());
    assert_eq!(found, [".gitignore", "client/notes.md", "odd/file.rs"].map(PathBuf::from));
    assert_eq!(odd(&found), BTreeSet::from(["odd".to_owned()]));
    if tracked().is_some() {
        let git =
            |name: &str| Command::new("git").arg("-C").arg(root()).args(["check-ignore", "-q", name]).status().unwrap();
        assert!(left.iter().all(|name| git(name).success()), "git ignores them, too");
    }
}

#[test]
fn names_in_architecture_md_exist() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let sources = sources();
    let mut violations = Vec::new();
    for name in text.split('`').skip(1).step_by(2) {
        let name = name.trim();
        let is_path = name.contains('/') && name.chars().all(|c| c.is_ascii_alphanumeric() || "/_.-".contains(c));
        let is_type = name.chars().next().is_some_and(|c| c.is_ascii_uppercase())
            && name.chars().all(|c| c.is_ascii_alphanumeric())
            && name.chars().any(|c| c.is_ascii_lowercase());
        let is_function = name.contains('_') && name.chars().all(|c| c.is_ascii_lowercase() || c == '_');
        let defined = |kinds: &[&str]| {
            sources.iter().any(|(_, text)| kinds.iter().any(|kind| text.contains(&format!("{kind} {name}"))))
        };
        if is_path && !root().join(name).exists() {
            violations.push(format!("path {name}"));
        }
        if is_type && name != "Arc" && !defined(&["struct", "enum", "trait", "type"]) {
            violations.push(format!("type {name}"));
        }
        if is_function && !defined(&["fn", "mod"]) {
            violations.push(format!("function {name}"));
        }
    }
    check("ARCHITECTURE.md names what exists", violations);
}

/// Files that a page links to, without network addresses and anchors.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    let files = targets.filter_map(|(target, _)| target.split('#').next());
    files.filter(|file| !file.is_empty() && !file.starts_with("http"))
}

#[test]
fn links_and_names_in_pages_exist() {
    let header = fs::read_to_string(root().join("client/include/shatter.h")).unwrap();
    let known: BTreeSet<&str> = words(&header).collect();
    let conventions = fs::read_to_string(root().join("proto/src/convention.rs")).unwrap();
    let mut violations = Vec::new();
    for path in files(".md") {
        let text = fs::read_to_string(&path).unwrap();
        let name = path.strip_prefix(root()).unwrap().display();
        let gone = links(&text).filter(|file| !path.with_file_name(file).exists());
        violations.extend(gone.map(|file| format!("{name}: no file {file}")));
        // What is generated from the code names crates and metrics.
        let is_generated = path.starts_with(root().join("client/guide/src/reference"));
        let of_c = words(&text).filter(|word| {
            let of_ours = ["shatter_", "SHATTER_EFFECT_", "SHATTER_CODE_"].iter().any(|start| word.starts_with(start));
            of_ours
                && !is_generated
                && !word.ends_with('_')
                && !["shatter_client", "shatter_export", "shatter_fracture", "shatter_proto"].contains(word)
        });
        violations.extend(
            of_c.filter(|word| !known.contains(word)).map(|word| format!("{name}: {word} is not in the header")),
        );
        let named = text.split("Convention::").skip(1).filter_map(|rest| words(rest).next());
        let unknown =
            named.filter(|own| own.chars().all(char::is_uppercase) && !conventions.contains(&format!("const {own}:")));
        violations.extend(unknown.map(|own| format!("{name}: no Convention::{own}")));
    }
    check("links of pages lead to files, and pages name what the header has", violations);
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_').filter(|word| !word.is_empty())
}

/// A file that the suite does not name would never run.
#[test]
fn the_suite_names_every_file_of_its_folder() {
    let folder = root().join("tests/tests");
    let named = fs::read_to_string(folder.join("main.rs")).unwrap();
    let stems = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path().file_stem().unwrap().to_owned());
    let stems = stems.map(|stem| stem.into_string().unwrap()).filter(|stem| stem != "main");
    let lost: Vec<_> = stems.filter(|stem| !named.contains(&format!("\nmod {stem};"))).collect();
    check("tests/tests/main.rs names every file", lost);
}

#[test]
fn nothing_names_the_machine_it_was_written_on() {
    let words = [concat!("/wo", "rk/"), concat!("/ro", "ot/"), concat!("/ho", "me/")];
    let mut violations = Vec::new();
    for ending in [".rs", ".toml", ".md", "run"] {
        for path in files(ending) {
            let Ok(text) = fs::read_to_string(&path) else { continue };
            for (at, line) in text.lines().enumerate().filter(|(_, line)| words.iter().any(|word| line.contains(word)))
            {
                violations.push(format!("{}:{}: {}", path.display(), at + 1, line.trim()));
            }
        }
    }
    check("no machine paths", violations);
}

#[test]
fn the_readme_begins_with_the_demo_and_the_tests() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    let commands: Vec<&str> = text.lines().map(str::trim).filter(|line| line.starts_with("cargo ")).collect();
    assert_eq!(commands.first(), Some(&"cargo run --release -- demo"));
    assert_eq!(commands.get(1), Some(&"cargo test --release --workspace"));
}
