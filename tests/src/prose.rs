//! The prose of the project: documents, comments and messages, passage by passage.

use crate::sources::{root, tracked};
use std::fs;

/// Place of a passage in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A paragraph of a Markdown file, without its code blocks.
    Document,
    /// The first line of the documentation of an item or a module.
    FirstDocLine,
    /// Any other comment line, or a string literal.
    Text,
}

/// A passage of prose, with its position.
#[derive(Debug)]
pub struct Passage {
    /// Path from the root.
    pub file: String,
    /// Number of its first line, from 1.
    pub line: usize,
    /// Kind of the passage.
    pub kind: Kind,
    /// Text of the passage.
    pub text: String,
}

/// Words of a text in lower case. Code between backticks and placeholders are left out.
pub fn words(text: &str) -> Vec<String> {
    let mut plain: String = text.split('`').step_by(2).collect::<Vec<_>>().join(" code ");
    while let Some((start, length)) = plain.find('{').and_then(|start| Some((start, plain[start..].find('}')?))) {
        plain.replace_range(start..=start + length, "");
    }
    let split =
        plain.split(|letter: char| !(letter.is_alphanumeric() || letter == '\'' || letter == '_' || letter == '-'));
    split.filter(|word| !word.is_empty()).map(str::to_lowercase).collect()
}

/// All passages of tracked files. The rules themselves, recordings and licenses are left out.
pub fn passages() -> Vec<Passage> {
    let mut found = Vec::new();
    for path in tracked().unwrap_or_default() {
        let name = path.to_string_lossy().into_owned();
        let left_out = name.starts_with("LICENSE") || name.ends_with("tests/prose.rs") || name == "CHANGELOG.md";
        let Ok(text) = fs::read_to_string(root().join(&path)) else { continue };
        let passages = match path.extension().and_then(|ending| ending.to_str()) {
            _ if left_out => continue,
            Some("md") => document(&text),
            Some("rs" | "h" | "hpp" | "c" | "cpp") => source(&text),
            Some("py" | "pyi" | "toml") => hashes(&text),
            _ => continue,
        };
        found.extend(passages.into_iter().map(|(line, kind, text)| Passage { file: name.clone(), line, kind, text }));
    }
    found
}

type Found = Vec<(usize, Kind, String)>;

/// Paragraphs and rows of tables of a Markdown file.
fn document(text: &str) -> Found {
    let (mut found, mut in_code) = (Found::new(), false);
    let mut open: Option<(usize, String)> = None;
    for (at, line) in text.lines().enumerate() {
        let fence = line.trim_start().starts_with("```");
        in_code ^= fence;
        let ends = fence || in_code || line.trim().is_empty() || line.starts_with(['#', '|', '-', '*']);
        if ends {
            found.extend(open.take().map(|(line, text)| (line, Kind::Document, text)));
        }
        if !(fence || in_code || line.trim().is_empty()) {
            let (_, paragraph) = open.get_or_insert((at + 1, String::new()));
            paragraph.push_str(line);
            paragraph.push(' ');
        }
    }
    found.extend(open.map(|(line, text)| (line, Kind::Document, text)));
    found
}

/// Comments and string literals of a Rust, C or C++ file.
fn source(text: &str) -> Found {
    let (mut found, mut documented) = (Found::new(), false);
    for (at, line) in text.lines().enumerate() {
        let trimmed = line.trim_start();
        let comment = ["///", "//!", "//", "/*", "* "]
            .iter()
            .find_map(|mark| trimmed.strip_prefix(mark).map(|rest| (*mark, rest)));
        match comment {
            Some(("///" | "//!", rest)) => {
                let kind = if documented { Kind::Text } else { Kind::FirstDocLine };
                documented = true;
                found.push((at + 1, kind, rest.to_owned()));
            }
            Some((_, rest)) => {
                documented = false;
                found.push((at + 1, Kind::Text, rest.to_owned()));
            }
            None => {
                documented = false;
                found.extend(literals(trimmed).into_iter().map(|text| (at + 1, Kind::Text, text)));
            }
        }
    }
    found
}

/// The string literals of a line that have more than one word, and the comment at its end.
fn literals(line: &str) -> Vec<String> {
    let (mut found, mut rest) = (Vec::new(), line);
    while let Some(start) = rest.find(['"', '/']) {
        if rest[start..].starts_with("// ") {
            found.push(rest[start + 3..].to_owned());
            return found;
        }
        let after = &rest[start + 1..];
        if rest[start..].starts_with('/') {
            rest = after;
            continue;
        }
        let mut escaped = false;
        let end = after.find(|letter| {
            let ends = letter == '"' && !escaped;
            escaped = letter == '\\' && !escaped;
            ends
        });
        let Some(end) = end else { return found };
        if after[..end].contains(' ') {
            found.push(after[..end].to_owned());
        }
        rest = &after[end + 1..];
    }
    found
}

/// Comments of a file in which they begin with a number sign.
fn hashes(text: &str) -> Found {
    let lines = text.lines().enumerate();
    lines
        .filter_map(|(at, line)| line.split_once("# ").map(|(_, rest)| (at + 1, Kind::Text, rest.to_owned())))
        .collect()
}
