//! README and guide: size, links, the files and tests that they name, and the reference pages.

use shatter_fracture::database::FORMAT;
use shatter_proto::PROTOCOL_VERSION;
use shatter_tests::pages::{GUIDE, guide, root, text};
use shatter_tests::reference::reference_pages;
use shatter_tests::sources::check;
use shatter_tests::statistics::median;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Pages of the project, from its folder.
fn all_pages() -> Vec<String> {
    let top = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md"];
    [top.map(str::to_owned).to_vec(), guide()].concat()
}

/// The text outside fenced blocks.
fn outside_blocks(text: &str) -> String {
    let outside = text.split("```").step_by(2);
    outside.collect::<Vec<_>>().join("\n")
}

#[test]
fn the_readme_is_short() {
    let text = text("README.md");
    let words = text.split_whitespace().count();
    assert!(words <= 900, "{words} words");
    let long = text.lines().enumerate().filter(|(_, line)| line.chars().count() > 120);
    check("no line of the README is longer than 120 characters", long.map(|(at, _)| format!("{}", at + 1)).collect());
    let command = text.lines().position(|line| line == "cargo run --release -- demo");
    assert!(command.is_some_and(|line| line < 24), "the first command stands on the first screen: {command:?}");
}

/// Figures have one source: the README quotes rows of the guide.
#[test]
fn tables_of_the_readme_are_those_of_the_guide() {
    let pages: String = guide().iter().map(|page| text(page)).collect();
    let known: BTreeSet<&str> = pages.lines().collect();
    let readme = text("README.md");
    let rows: Vec<&str> = readme.lines().filter(|line| line.starts_with("| ")).collect();
    assert!(rows.len() > 12, "{rows:?}");
    let odd = rows.into_iter().filter(|row| !known.contains(row)).map(str::to_owned);
    check("every row of the README's tables is a row of the guide", odd.collect());
}

/// Link target of a heading, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let letters = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    letters.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    let outside = outside_blocks(text);
    let headings = outside.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

/// Targets of links in `text`, unchanged.
fn targets(text: &str) -> Vec<String> {
    let outside = outside_blocks(text);
    let inline = outside.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    inline.map(|(target, _)| target.to_owned()).filter(|target| !target.starts_with("http")).collect()
}

#[test]
fn links_and_anchors_resolve() {
    let mut violations = Vec::new();
    let mut count = 0;
    for page in all_pages() {
        let own = text(&page);
        for target in targets(&own) {
            count += 1;
            let (file, fragment) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { root().join(&page) } else { root().join(&page).with_file_name(file) };
            let Ok(path) = path.canonicalize() else {
                violations.push(format!("{page}: no file {target}"));
                continue;
            };
            if page.starts_with(GUIDE) && !path.starts_with(root().join(GUIDE)) {
                violations.push(format!("{page}: {target} leaves the guide, and the built book lacks it"));
            }
            if !fragment.is_empty() && !anchors(&fs::read_to_string(&path).unwrap()).contains(fragment) {
                violations.push(format!("{page}: no heading {target}"));
            }
        }
    }
    assert!(count > 60, "{count}");
    check("links and their anchors resolve", violations);
}

#[test]
fn the_summary_names_every_page_once() {
    fn walk(folder: &Path, found: &mut BTreeSet<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|end| end == "md") {
                found.insert(path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    let mut found = BTreeSet::new();
    walk(&root().join(GUIDE), &mut found);
    found.remove(&format!("{GUIDE}/SUMMARY.md"));
    let named = guide();
    assert_eq!(named.iter().cloned().collect::<BTreeSet<_>>(), found);
    assert_eq!(named.len(), found.len());
}

/// Code in backquotes outside blocks.
fn quoted(text: &str) -> Vec<String> {
    outside_blocks(text).split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_guide_names_files_and_tests_that_exist() {
    let folders = ["client/", "config/", "proto/", "server/", "tests/", ".ci/"];
    let made = ["client/python/dist"];
    let mut violations = Vec::new();
    for page in all_pages().into_iter().filter(|page| page != "CHANGELOG.md") {
        for name in quoted(&text(&page)) {
            let is_path = folders.iter().any(|folder| name.starts_with(folder)) && !name.contains([' ', '*', '<', ':']);
            if is_path && !made.contains(&name.as_str()) && !root().join(&name).exists() {
                violations.push(format!("{page}: no file {name}"));
            }
        }
        let own = text(&page);
        let words: Vec<&str> = own.split(|c: char| c.is_whitespace() || c == '`').collect();
        for pair in words.windows(2).filter(|pair| pair[0] == "--test" || pair[0] == "--bench") {
            let folder = &pair[0][2..];
            let folder = if folder == "test" { "tests" } else { "benches" };
            let places = ["tests", "server", "server/lab", "server/fracture", "server/engine", "client", "client/cli"];
            if pair[1] != "suite"
                && !places.iter().any(|place| root().join(place).join(folder).join(format!("{}.rs", pair[1])).exists())
            {
                violations.push(format!("{page}: no {folder} {}", pair[1]));
            }
        }
        let parts = words.windows(3).filter(|words| words[..2] == ["--test", "suite"]);
        let parts = parts.filter_map(|words| words[2].strip_suffix("::"));
        let missing = parts.filter(|part| !root().join("tests/tests").join(format!("{part}.rs")).exists());
        violations.extend(missing.map(|part| format!("{page}: no part {part} of the suite")));
    }
    check("pages name files, tests and benches that exist", violations);
}

/// The support matrix: each cell of an accepted request names a test.
#[test]
fn tests_of_the_support_matrix_exist() {
    let folders = ["tests/tests", "server/tests", "server/fracture/tests"];
    let page = text(&format!("{GUIDE}/effects.md"));
    let (_, matrix) = page.split_once("\n## Support matrix\n").unwrap();
    let (matrix, refused) = matrix.split_once("\n### Refused combinations\n").unwrap();
    let rows = matrix.lines().filter(|line| line.starts_with("| `paper`"));
    let cells = rows.flat_map(|line| line.split('|').skip(4)).filter(|cell| !cell.contains("refused"));
    let last = refused.lines().filter_map(|line| line.rsplit('|').nth(1));
    let names: BTreeSet<String> = cells.chain(last).flat_map(quoted).collect();
    assert!(names.len() > 8, "{names:?}");
    let missing = names
        .into_iter()
        .filter(|name| !folders.iter().any(|folder| root().join(folder).join(format!("{name}.rs")).exists()));
    check("tests of the support matrix exist", missing.collect());
}

#[test]
fn the_program_without_a_daemon_is_the_example() {
    let block = format!("```rust\n{}```", text("server/fracture/examples/library.rs"));
    assert!(text(&format!("{GUIDE}/internals.md")).contains(&block));
}

#[test]
fn the_versions_of_the_guide_are_those_of_the_code() {
    let page = text(&format!("{GUIDE}/security.md"));
    let rows = [("protocol", PROTOCOL_VERSION.to_string()), ("database format", FORMAT.to_owned())];
    for (name, version) in rows {
        assert!(page.contains(&format!("| {name} | {version} |")), "{name} is {version}");
    }
}

#[test]
fn host_pages_begin_with_their_status() {
    let hosts: Vec<String> = guide().into_iter().filter(|page| page.contains("/hosts/")).collect();
    assert!(hosts.len() >= 6);
    let states = ["**Status: tested**", "**Status: recipe", "**Status: untested"];
    let odd = hosts.into_iter().filter(|page| {
        let text = text(page);
        let first = text.lines().skip(1).find(|line| !line.is_empty()).unwrap();
        !states.iter().any(|state| first.starts_with(state))
    });
    check("the first line of a host page says tested, recipe or untested", odd.collect());
}

/// Number of words of each sentence of the prose, without blocks, tables, headings or pictures.
fn sentences(text: &str) -> Vec<usize> {
    let outside = outside_blocks(text);
    let mut paragraphs: Vec<String> = vec![String::new()];
    for line in outside.lines().map(str::trim) {
        let is_apart = line.is_empty() || ["|", "#", "!", "<"].iter().any(|start| line.starts_with(start));
        let begins =
            is_apart || line.starts_with("- ") || line.split_once(". ").is_some_and(|(n, _)| n.parse::<u8>().is_ok());
        if begins {
            paragraphs.push(String::new());
        }
        if !is_apart {
            let last = paragraphs.last_mut().unwrap();
            *last += line;
            *last += " ";
        }
    }
    let ends = |word: &str| word.trim_end_matches(['*', ')', '"']).ends_with(['.', '?', '!']);
    let mut counts = Vec::new();
    for paragraph in paragraphs {
        let words: Vec<&str> = paragraph.split_whitespace().collect();
        counts.extend(words.split_inclusive(|word| ends(word)).map(<[&str]>::len).filter(|count| *count > 2));
    }
    counts
}

#[test]
fn sentences_are_short() {
    let mut all = Vec::new();
    let pages = all_pages().into_iter().filter(|page| page != "CHANGELOG.md" && !page.contains("/reference/"));
    for page in pages {
        let counts: Vec<f64> = sentences(&text(&page)).into_iter().map(|count| count as f64).collect();
        if counts.is_empty() {
            continue;
        }
        let long = counts.iter().filter(|count| **count > 25.0).count();
        let middle = median(&counts);
        println!("{page}: {} sentences, median {middle}, {long} longer than 25 words", counts.len());
        assert!(middle <= 20.0, "{page}: the median sentence has {middle} words");
        all.extend(counts);
    }
    assert!(all.len() > 500, "{}", all.len());
    let long = all.iter().filter(|count| **count > 25.0).count();
    println!("{} sentences, median {}, {long} longer than 25 words", all.len(), median(&all));
    assert!(long * 50 <= all.len(), "{long} of {} sentences are longer than 25 words", all.len());
}

/// The pages of the reference equal those generated from the code.
#[test]
fn the_reference_is_that_of_the_code() {
    for (name, made) in reference_pages() {
        let path = root().join(GUIDE).join("reference").join(name).with_extension("md");
        if std::env::var_os("SHATTER_WRITE_REFERENCE").is_some() {
            fs::write(&path, &made).unwrap();
        }
        let there = fs::read_to_string(&path).unwrap_or_default();
        let differs = there.lines().zip(made.lines()).position(|(a, b)| a != b);
        assert!(
            there == made,
            "{} is not up to date from line {:?} on: \
             SHATTER_WRITE_REFERENCE=1 cargo test --release --workspace --test suite documents::",
            path.display(),
            differs.map(|line| line + 1)
        );
    }
}
