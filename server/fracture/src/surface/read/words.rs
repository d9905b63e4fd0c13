//! Words and numbers of a text file, with their lines.

use super::common::{malformed, within_limit};
use crate::surface::SurfaceError;
use nalgebra::Point3;
use std::fmt::Display;
use std::str::FromStr;

/// Unread part of a text.
#[derive(Clone, Copy)]
pub(super) struct Words<'a> {
    format: &'static str,
    rest: &'a str,
    /// Line of the last word, from 1.
    line: usize,
    has_comments: bool,
    is_row: bool,
}

impl<'a> Words<'a> {
    /// Starts at the beginning of a file. A byte-order mark is skipped.
    pub fn new(format: &'static str, text: &'a str) -> Self {
        let rest = text.strip_prefix('\u{feff}').unwrap_or(text);
        Self { format, rest, line: 1, has_comments: false, is_row: false }
    }

    /// As [`Self::new`]. A comment begins with `#` and ends with its line.
    pub fn with_comments(format: &'static str, text: &'a str) -> Self {
        Self { has_comments: true, ..Self::new(format, text) }
    }

    /// Line of the last word, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// Error that names the line of the last word.
    pub fn wrong(&self, reason: impl Display) -> SurfaceError {
        malformed(self.format, format!("line {}", self.line), reason)
    }

    /// Next word; `None` at the end.
    pub fn next_word(&mut self) -> Option<&'a str> {
        self.skip_blank().then(|| {
            let ends = |c: char| c.is_ascii_whitespace() || self.has_comments && c == '#';
            let (word, rest) = self.rest.split_at(self.rest.find(ends).unwrap_or(self.rest.len()));
            self.rest = rest;
            word
        })
    }

    /// Next word. The error says that `name` is missing.
    pub fn word(&mut self, name: &str) -> Result<&'a str, SurfaceError> {
        self.next_word().ok_or_else(|| self.missing(name))
    }

    /// Next word as a number. Errors say what it stands for: `name`.
    pub fn number<T: FromStr>(&mut self, name: &str) -> Result<T, SurfaceError> {
        let word = self.word(name)?;
        word.parse().map_err(|_| self.wrong(format!("'{word}' is not a valid {name}")))
    }

    /// Next word as the number of `name` that follow. At least one byte of the text is left for each.
    pub fn count(&mut self, name: &str) -> Result<usize, SurfaceError> {
        let count = self.number(&format!("number of {name}"))?;
        if count > self.rest.len() {
            let reason = format!("{count} {name} are announced, and the file ends before: copy or export it again");
            return Err(self.wrong(reason));
        }
        within_limit(count)?;
        Ok(count)
    }

    /// Next three words as the position of `vertex`, counted from 0.
    pub fn point(&mut self, vertex: usize) -> Result<Point3<f64>, SurfaceError> {
        let mut point = Point3::origin();
        for axis in 0..3 {
            point[axis] = self.number::<f64>("coordinate")?;
            if !point[axis].is_finite() {
                return Err(SurfaceError::NonFiniteVertex { vertex: vertex as u64, line: Some(self.line) });
            }
        }
        Ok(point)
    }

    /// Next line with a word, or the rest of the present one, as words of their own.
    pub fn next_row(&mut self) -> Option<Self> {
        self.skip_blank().then(|| {
            let row = self.rest_of_line();
            Self { rest: row, is_row: true, ..*self }
        })
    }

    /// As [`Self::next_row`]. The error says that `name` is missing.
    pub fn row(&mut self, name: &str) -> Result<Self, SurfaceError> {
        self.next_row().ok_or_else(|| self.missing(name))
    }

    /// Skips to the end of the present line, and returns what was skipped.
    pub fn rest_of_line(&mut self) -> &'a str {
        let end = self.rest.find('\n').unwrap_or(self.rest.len());
        let (skipped, rest) = self.rest.split_at(end);
        self.rest = rest;
        skipped
    }

    /// Skips to the end of the next line, which may be blank.
    pub fn skip_next_line(&mut self) {
        self.rest_of_line();
        if let Some(rest) = self.rest.strip_prefix('\n') {
            self.rest = rest;
            self.line += 1;
            self.rest_of_line();
        }
    }

    /// Moves to the next word. Returns false at the end, with the line unchanged.
    fn skip_blank(&mut self) -> bool {
        let mut ahead = *self;
        loop {
            let text = ahead.rest.trim_ascii_start();
            let blank = &ahead.rest[..ahead.rest.len() - text.len()];
            ahead.line += blank.bytes().filter(|&byte| byte == b'\n').count();
            ahead.rest = text;
            if self.has_comments && text.starts_with('#') {
                ahead.rest_of_line();
                continue;
            }
            if !text.is_empty() {
                *self = ahead;
            }
            return !text.is_empty();
        }
    }

    fn missing(&self, name: &str) -> SurfaceError {
        let end = if self.is_row { "line" } else { "file" };
        let advice = if self.is_row { "" } else { ": copy or export it again" };
        self.wrong(format!("the {end} ends before the {name}{advice}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(result: Result<impl Sized, SurfaceError>) -> String {
        result.err().map(|error| error.to_string()).unwrap_or_default()
    }

    #[test]
    fn words_know_their_lines() {
        let mut words = Words::new("msh", "\u{feff}a  b\r\n\n c # d\n\n");
        let mut found = Vec::new();
        while let Some(word) = words.next_word() {
            found.push((word, words.line()));
        }
        assert_eq!(found, [("a", 1), ("b", 1), ("c", 3), ("#", 3), ("d", 3)]);
        let mut words = Words::with_comments("mesh", "# a b\nc# d\n#\n e");
        assert_eq!([words.next_word(), words.next_word(), words.next_word()], [Some("c"), Some("e"), None]);
        assert_eq!(words.line(), 4);
    }

    #[test]
    fn rows_end_with_their_lines() {
        let mut words = Words::new("msh", "a 1\n\n2 3\n4");
        assert_eq!(words.next_word(), Some("a"));
        let mut rows = Vec::new();
        while let Some(mut row) = words.next_row() {
            rows.push((row.line(), std::iter::from_fn(|| row.next_word()).collect::<Vec<_>>()));
        }
        assert_eq!(rows, [(1, vec!["1"]), (3, vec!["2", "3"]), (4, vec!["4"])]);
        let mut words = Words::new("vtk", "a b\r\n\nc");
        assert_eq!(words.next_word(), Some("a"));
        words.skip_next_line();
        assert_eq!((words.next_word(), words.line()), (Some("c"), 3));
    }

    #[test]
    fn errors_name_the_line() {
        let mut words = Words::new("msh", "1 x\n");
        assert_eq!(words.number::<u32>("tag").unwrap(), 1);
        assert_eq!(message(words.number::<u32>("tag")), "malformed msh, line 1: 'x' is not a valid tag");
        assert!(message(words.word("tag")).contains("line 1: the file ends before the tag: copy"));
        let mut row = Words::new("msh", "\n7\n8").row("node").unwrap();
        assert_eq!(
            (row.next_word(), message(row.word("tag"))),
            (Some("7"), "malformed msh, line 2: the line ends before the tag".to_owned())
        );
        assert!(message(Words::new("msh", "9 1 2").count("nodes")).contains("9 nodes are announced"));
        assert!(message(Words::new("msh", "-9 1 2").count("nodes")).contains("'-9' is not a valid number of nodes"));
        let infinite = Words::new("msh", "\n1 2 1e999").point(4);
        assert!(matches!(infinite, Err(SurfaceError::NonFiniteVertex { vertex: 4, line: Some(2) })));
    }
}
