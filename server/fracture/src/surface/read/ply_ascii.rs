//! Reader of ASCII bodies of PLY files, one row per line.
//!
//! `ply-rs-bw` does not read them, because its grammar rejects `.5`, `5.` and `nan`: it fails on valid files and hides
//! the fault of invalid ones.

use super::common::malformed;
use super::ply::{Meaning, PlyRow, color_max_of, meaning};
use crate::surface::SurfaceError;
use ply_rs_bw::ply::{ElementDef, PropertyType};

/// Unread lines of a body.
pub(super) struct Rows<'a> {
    rest: &'a [u8],
    lines_read: usize,
}

impl<'a> Rows<'a> {
    /// Starts at `rest`, which follows `lines_read` lines of the file.
    pub fn new(rest: &'a [u8], lines_read: usize) -> Self {
        Self { rest, lines_read }
    }

    /// Bytes after the lines read so far.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Number of lines of the file read so far.
    pub fn lines_read(&self) -> usize {
        self.lines_read
    }

    /// Reads all rows of an element.
    pub fn read(&mut self, element: &ElementDef) -> Result<Vec<PlyRow>, SurfaceError> {
        self.read_with(element, meaning)
    }

    /// As [`Self::read`], with the meanings of properties by `meaning`.
    pub fn read_with(
        &mut self,
        element: &ElementDef,
        meaning: impl Fn(&str) -> Meaning,
    ) -> Result<Vec<PlyRow>, SurfaceError> {
        let meanings: Vec<_> =
            element.properties.values().map(|property| (meaning(&property.name), &property.data_type)).collect();
        let mut rows = Vec::new();
        while rows.len() < element.count {
            let Some(line) = self.next_line() else {
                let reason = format!("ends after {} of {} rows of {}", rows.len(), element.count, element.name);
                return Err(malformed("ply", format!("line {}", self.lines_read), reason));
            };
            let text = String::from_utf8_lossy(line);
            let mut words = text.split_whitespace().peekable();
            if words.peek().is_some() {
                let is_cut = self.rest.is_empty();
                let wrong = |reason: String| {
                    let is_short = reason == TOO_SHORT && is_cut;
                    let reason = if is_short {
                        format!("{reason}: the file ends there: copy or export it again")
                    } else {
                        reason
                    };
                    malformed("ply", format!("line {}", self.lines_read), reason)
                };
                let row = row(words, &meanings).map_err(wrong)?;
                if element.name == "vertex" && !row.point.coords.iter().all(|x| x.is_finite()) {
                    let (vertex, line) = (rows.len() as u64, Some(self.lines_read));
                    return Err(SurfaceError::NonFiniteVertex { vertex, line });
                }
                rows.push(row);
            }
        }
        Ok(rows)
    }

    fn next_line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.lines_read += 1;
        Some(line)
    }
}

/// Defect of a row with too few words.
const TOO_SHORT: &str = "the row is too short";

fn row<'a>(mut words: impl Iterator<Item = &'a str>, meanings: &[(Meaning, &PropertyType)]) -> Result<PlyRow, String> {
    let mut row = PlyRow::default();
    let mut next = || words.next().ok_or(TOO_SHORT);
    for (meaning, kind) in meanings {
        match kind {
            PropertyType::Scalar(kind) => {
                let word = next()?;
                match *meaning {
                    Meaning::Axis(axis) => {
                        row.point[axis] = word.parse().map_err(|_| format!("'{word}' is not a number"))?;
                    }
                    Meaning::Value => row.value = word.parse().map_err(|_| format!("'{word}' is not a number"))?,
                    // Invalid attributes do not invalidate the mesh; they are dropped later.
                    Meaning::Normal(axis) => row.normal[axis] = word.parse().unwrap_or(f64::NAN),
                    Meaning::Uv(axis) => row.uv[axis] = word.parse().unwrap_or(f64::NAN),
                    Meaning::Color(channel) => {
                        row.color[channel] = word.parse().map_or(f64::NAN, |x: f64| x / color_max_of(kind));
                    }
                    Meaning::Indices | Meaning::Nothing => {}
                }
            }
            PropertyType::List(..) => {
                let word = next()?;
                let length: usize = word.parse().map_err(|_| format!("'{word}' is not a length"))?;
                for _ in 0..length {
                    let word = next()?;
                    if *meaning == Meaning::Indices {
                        row.indices.push(word.parse().map_err(|_| format!("'{word}' is not an index"))?);
                    }
                }
            }
        }
    }
    Ok(row)
}
