//! Examples in pages and doc comments.

use std::path::{Path, PathBuf};

/// Start of the comment above a block that tests do not run, before the reason.
const NOT_RUN: &str = "<!-- not run by the tests: ";

/// A fenced block of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// File and line of the fence, for messages.
    pub place: String,
    /// First word after the fence.
    pub language: String,
    /// Lines of the block.
    pub text: String,
    /// Reason why tests do not run it, if they do not.
    pub not_run: Option<String>,
}

/// Folder of the project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// Text of a file of the project.
pub fn text(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Source folder of the guide.
pub const GUIDE: &str = "client/guide/src";

/// Pages of the guide in the order of its summary, relative to the folder of the project.
pub fn guide() -> Vec<String> {
    let summary = text(&format!("{GUIDE}/SUMMARY.md"));
    let links = summary.lines().filter_map(|line| Some(line.trim().strip_prefix("- [")?.split_once("](")?.1));
    links.filter_map(|link| Some(format!("{GUIDE}/{}", link.strip_suffix(')')?))).collect()
}

/// Fenced blocks of the page `name`, in order.
pub fn blocks(name: &str) -> Vec<Block> {
    let text = text(name);
    let mut found = Vec::new();
    let (mut lines, mut above) = (text.lines().enumerate(), "");
    while let Some((number, line)) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let inside: Vec<&str> = lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```").collect();
            let not_run = above.strip_prefix(NOT_RUN).map(|reason| reason.trim_end_matches(" -->").to_owned());
            let place = format!("{name}:{}", number + 1);
            found.push(Block { place, language: language.to_owned(), text: inside.join("\n") + "\n", not_run });
        }
        above = line;
    }
    found
}

/// Code of the first block with `mark` in the documentation of a Rust crate, hidden lines included.
pub fn crate_example(name: &str, mark: &str) -> String {
    let text = text(name);
    let inner =
        text.lines().map_while(|line| line.strip_prefix("//!")).map(|line| line.strip_prefix(' ').unwrap_or(line));
    let block = inner.skip_while(|line| *line != format!("```{mark}")).skip(1).take_while(|line| *line != "```");
    block.map(|line| line.strip_prefix("# ").unwrap_or(line).to_owned() + "\n").collect()
}

/// Points and impulses of all commands in `text` that have both, each pair once.
pub fn impacts(text: &str) -> Vec<[String; 2]> {
    let mut found: Vec<[String; 2]> = Vec::new();
    for line in text.lines() {
        let after = |flag: &str| Some(line.split_once(flag)?.1.split_whitespace().next()?.to_owned());
        if let (Some(point), Some(impulse)) = (after("--point "), after("--impulse "))
            && !found.contains(&[point.clone(), impulse.clone()])
        {
            found.push([point, impulse]);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_the_guide_are_found() {
        let pages = guide();
        assert!(pages.len() > 15 && pages[0].ends_with("/getting-started.md"), "{pages:?}");
        let all: Vec<Block> = pages.iter().flat_map(|page| blocks(page)).collect();
        assert!(all.len() > 15 && all.iter().all(|block| !block.text.trim().is_empty()), "{all:?}");
        assert!(all.iter().any(|block| block.language == "sh" && block.text.contains("--shape mug")));
        assert!(all.iter().filter_map(|block| block.not_run.as_ref()).all(|reason| !reason.is_empty()));
        let example = crate_example("client/src/lib.rs", "no_run");
        assert!(example.contains("fn main()") && example.ends_with("}\n"), "{example}");
    }

    #[test]
    fn points_are_found_with_their_impulses() {
        let text = "shatter impact a --point 1,2,3 --impulse 0,0,-1 --json\nshatter threshold a --point 1,2,3\n\
                    shatter impact a --point 1,2,3 --impulse 0,0,-1\n";
        assert_eq!(impacts(text), [["1,2,3".to_owned(), "0,0,-1".to_owned()]]);
    }
}
