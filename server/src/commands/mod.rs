//! The commands of `shatterd`, one file each.

pub mod serve;

use shatter_proto::Refusal;
use std::io::Write;
use std::process::ExitCode;

/// Why a command ended early: what is printed, and the exit code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The error as both programs print it under `--json`.
    pub document: serde_json::Value,
    /// One sentence for people.
    pub message: String,
    /// See `shatter_proto::exit`.
    pub exit_code: u8,
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        let (document, exit_code) = (refusal.document(), refusal.kind.exit_code());
        Self { document, message: refusal.message, exit_code }
    }
}

impl Failure {
    /// Prints it and gives the exit code.
    pub fn print(&self, json: bool) -> ExitCode {
        if json {
            // A reader that went away cannot be told.
            let _ = writeln!(std::io::stdout(), "{:#}", self.document);
        }
        let _ = writeln!(std::io::stderr(), "shatterd: {}", self.message);
        ExitCode::from(self.exit_code)
    }
}
