//! The requests of a run with their results, written as one page that replays them without a service.

use crate::page_files::PageFiles;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use shatter_proto::{Error, ErrorKind};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A request as JSON, and the message with its result.
struct RecordedReply {
    request: String,
    message: Vec<u8>,
    /// Name of the step that the page replaces as long as its slider moves; empty for other requests.
    step: String,
}

/// Results of a recording.
#[derive(Default)]
struct Replies {
    kept: Vec<RecordedReply>,
    /// Number of results that found no place.
    left_out: usize,
}

/// A recording under way.
pub struct Recording {
    file: PathBuf,
    page: PageFiles,
    replies: Mutex<Replies>,
}

/// A recording about to be written.
pub struct PendingRecording<'a> {
    /// Its file.
    pub file: &'a Path,
    /// Number of results that it leaves out, because they are more than [`Self::BYTES_MAX`].
    pub left_out: usize,
}

impl PendingRecording<'_> {
    /// Most bytes of results of a recording.
    pub const BYTES_MAX: usize = 256 << 20;
}

impl Recording {
    /// A recording for `file`, replayed by `page`.
    #[must_use]
    pub fn new(file: &Path, page: PageFiles) -> Self {
        Self { file: file.to_owned(), page, replies: Mutex::default() }
    }

    fn replies(&self) -> MutexGuard<'_, Replies> {
        self.replies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a request in place of the earlier ones of its `step`, if it names one, unless the recording is too large.
    pub(crate) fn add(&self, request: &Value, message: &[u8]) {
        let step = request["step"].as_str().unwrap_or_default().to_owned();
        let mut replies = self.replies();
        if !step.is_empty() {
            replies.kept.retain(|reply| reply.step != step);
        }
        let bytes: usize = replies.kept.iter().map(|reply| reply.message.len()).sum();
        if bytes + message.len() <= PendingRecording::BYTES_MAX {
            replies.kept.push(RecordedReply { request: request.to_string(), message: message.to_vec(), step });
        } else {
            replies.left_out += 1;
        }
    }

    /// Whether nothing was struck.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.replies().kept.is_empty()
    }

    /// The recording as [`Self::write`] writes it.
    #[must_use]
    pub fn pending(&self) -> PendingRecording<'_> {
        PendingRecording { file: &self.file, left_out: self.replies().left_out }
    }

    /// Writes the page, and returns its path.
    ///
    /// # Errors
    /// `output` if the file cannot be written, `failed` if the page has no place for the recording.
    pub fn write(&self) -> Result<PathBuf, Error> {
        let html = self.html()?;
        shatter_export::write_whole(&self.file, html.as_bytes())
            .map_err(|error| Error::new(ErrorKind::Output, self.file.display().to_string(), error.to_string()))?;
        Ok(self.file.clone())
    }

    /// The page with its script, its style and the recorded replies in one text.
    fn html(&self) -> Result<String, Error> {
        let text = |path: &str| {
            let file = self.page.file(path).and_then(|file| std::str::from_utf8(file.bytes).ok());
            file.ok_or_else(|| Error::new(ErrorKind::Failed, path, format!("the page has no file `{path}`")))
        };
        let style = format!("<style>{}</style>", text("view.css")?);
        let replies = self.replies();
        let rows: Vec<Value> = replies
            .kept
            .iter()
            .map(|reply| serde_json::json!({ "request": reply.request, "message": STANDARD.encode(compressed(&reply.message)) }))
            .collect();
        let data = Value::Array(rows).to_string().replace('<', "\\u003c");
        // A closing tag inside the script would end it.
        let script = text("view.js")?.replace("</script", "<\\/script");
        let script = format!(
            "<script type=\"application/json\" id=\"recording\">{data}</script>\n<script type=\"module\">{script}</script>"
        );
        let page = text("")?;
        let (marks, parts) = (["<!--style-->", "<!--script-->"], [style, script]);
        let mut html = String::new();
        let mut rest = page;
        for (mark, part) in marks.iter().zip(parts) {
            let (before, after) = rest.split_once(mark).ok_or_else(|| {
                Error::new(ErrorKind::Failed, "page", format!("the page has no place `{mark}` for the recording"))
            })?;
            // The line of the mark names the separate file.
            let after = after.split_once('\n').map_or("", |(_, after)| after);
            html.push_str(before);
            html.push_str(&part);
            html.push('\n');
            rest = after;
        }
        Ok(html + rest)
    }
}

/// `message` as gzip, which browsers read by themselves.
fn compressed(message: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    // Writing to memory does not fail.
    let _ = encoder.write_all(message);
    encoder.finish().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page_files::PageFile;

    #[test]
    fn a_recording_is_one_page() {
        let file = |path, bytes: &'static [u8]| PageFile { path, media_type: "text/plain", bytes };
        let files = Box::leak(Box::new([
            file("", b"<head>\n<!--style--><link>\n</head><body>\n<!--script--><script src></script>\n</body>"),
            file("view.css", b"body{}"),
            file("view.js", b"let a = '</script>';"),
        ]));
        let recording = Recording::new(Path::new("a.html"), PageFiles(files));
        recording.add(&serde_json::json!({"op": "</script>"}), &[1, 2, 3]);
        let html = recording.html().unwrap();
        assert!(html.contains("<style>body{}</style>") && html.contains("\"message\":\"H4sI"), "{html}");
        assert!(!html.contains("<link>") && !html.contains("<script src>"), "{html}");
        assert_eq!(html.matches("</script>").count(), 2, "{html}");
    }

    #[test]
    fn a_step_is_recorded_once() {
        let recording = Recording::new(Path::new("a.html"), PageFiles(&[]));
        for (id, step) in [(1, None), (2, Some("a")), (3, Some("a")), (4, Some("b")), (5, None)] {
            recording.add(&serde_json::json!({"id": id, "step": step}), &[0]);
        }
        let ids: Vec<Value> = recording
            .replies()
            .kept
            .iter()
            .map(|reply| serde_json::from_str::<Value>(&reply.request).unwrap()["id"].clone())
            .collect();
        assert_eq!(ids, [1, 3, 4, 5]);
    }
}
