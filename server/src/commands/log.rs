//! Log lines, which may contain text from files and file names.

use shatter_proto::text;
use std::io::{Result, Write};

/// Writer that turns each buffer (one log event) into one line of bounded length without control characters.
pub struct LineWriter<W>(W);

impl<W: Write> LineWriter<W> {
    /// Creates a writer over `output`.
    pub fn new(output: W) -> Self {
        Self(output)
    }
}

impl<W: Write> Write for LineWriter<W> {
    fn write(&mut self, event: &[u8]) -> Result<usize> {
        let line = String::from_utf8_lossy(event.strip_suffix(b"\n").unwrap_or(event));
        // A single write keeps the lines of several threads apart.
        self.0.write_all(format!("{}\n", text::message(&line)).as_bytes())?;
        Ok(event.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing_subscriber::fmt::MakeWriter;

    /// Collects what is logged.
    #[derive(Clone, Default)]
    struct Collected(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);

    impl Write for Collected {
        fn write(&mut self, bytes: &[u8]) -> Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> Result<()> {
            Ok(())
        }
    }

    impl<'a> MakeWriter<'a> for Collected {
        type Writer = LineWriter<Self>;

        fn make_writer(&'a self) -> Self::Writer {
            LineWriter::new(self.clone())
        }
    }

    #[test]
    fn an_event_is_one_line_without_escapes_whatever_it_holds() {
        let collected = Collected::default();
        let subscriber = tracing_subscriber::fmt().with_ansi(false).with_writer(collected.clone()).finish();
        let (path, why) = ("a\u{1b}]0;b\u{7}\nready\u{9b}31m", "x".repeat(5_000_000));
        tracing::subscriber::with_default(subscriber, || tracing::error!(path, %why, "cannot {path} be loaded"));
        let text = String::from_utf8(collected.0.lock().unwrap().clone()).unwrap();
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(!text.trim_end_matches('\n').chars().any(char::is_control), "{text:?}");
        assert!(text.len() < 20_000 && text.contains("ready"), "{}", text.len());
    }
}
