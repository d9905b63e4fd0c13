//! What the commands share: printing, exit codes.

mod files;
pub mod impact;
pub mod list;
pub mod load;
mod objects;
mod parse;
pub mod prefracture;
pub mod status;
pub mod threshold;
mod when;

use clap::CommandFactory;
use shatter_client::program::{self, StdoutError};
use shatter_client::{Deadline, Impact, Refusal, exit};
use std::fmt::Arguments;
use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

/// How long a command waits for a reply of the service.
const REPLY: Duration = Duration::from_secs(5);

/// How long a command waits for the answer to a strike.
const ANSWER: Duration = Duration::from_secs(120);

/// Why a command ended early.
pub enum Failure {
    /// The arguments do not go together.
    Usage(String),
    /// Client or service refused.
    Refused(Refusal),
    /// The result is told, and why it is not whole.
    Told(Refusal),
    /// The reader of stdout went away.
    Closed,
}

impl From<StdoutError> for Failure {
    fn from(error: StdoutError) -> Self {
        match error {
            StdoutError::Closed => Self::Closed,
            StdoutError::Failed(refusal) => Self::Refused(refusal),
        }
    }
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

/// The deadline for a reply of the service.
fn reply() -> Deadline {
    Deadline::after(REPLY)
}

/// Writes to stdout.
fn out(text: Arguments<'_>) -> Result<(), Failure> {
    Ok(program::print(text)?)
}

/// Tells something beside the result, on stderr. A note that cannot be written is lost.
fn note(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "shatter: {}", shatter_proto::text::message(&text.to_string()));
}

/// Prints one JSON document.
fn document(value: &serde_json::Value) -> Result<(), Failure> {
    out(format_args!("{value:#}\n"))
}

/// `impact` with the duration and the radius of its last contact, where they were given.
fn with_contact(impact: Impact, duration_s: Option<f64>, radius_m: Option<f64>) -> Impact {
    let impact = duration_s.map_or(impact.clone(), |duration_s| impact.duration(duration_s));
    radius_m.map_or(impact.clone(), |radius_m| impact.radius(radius_m))
}

/// Ends with a usage error, or with the help that was asked for.
pub fn usage<C: CommandFactory>(error: &clap::Error, json: bool) -> ExitCode {
    if !error.use_stderr() {
        return program::print_help(error)
            .map_or_else(|error| ended::<C>(&error.into(), false), |()| ExitCode::SUCCESS);
    }
    if json {
        let message = program::usage_message(error);
        failed_document(&serde_json::json!({"error": {
            "kind": "usage", "message": message, "fault": "caller", "retry": false, "retry_after_ms": null, "at": "",
        }}));
    }
    let _ = write!(std::io::stderr(), "{}", program::usage_text::<C>(error));
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// Ends with why a command ended early.
pub fn ended<C: CommandFactory>(failure: &Failure, json: bool) -> ExitCode {
    match failure {
        Failure::Closed => ExitCode::from(exit::CLOSED),
        Failure::Usage(message) => {
            usage::<C>(&clap::Error::raw(clap::error::ErrorKind::ValueValidation, format!("{message}\n")), json)
        }
        Failure::Refused(refusal) => {
            if json {
                failed_document(&refusal.document());
            }
            complain(refusal);
            ExitCode::from(refusal.kind.exit_code())
        }
        Failure::Told(refusal) => {
            complain(refusal);
            ExitCode::from(refusal.kind.exit_code())
        }
    }
}

/// Prints the document of a failure. Where stdout cannot be written stderr says so; the exit code stays that of the failure.
fn failed_document(document: &serde_json::Value) {
    if let Err(StdoutError::Failed(refusal)) = program::print(format_args!("{document:#}\n")) {
        complain(&refusal);
    }
}

fn complain(refusal: &Refusal) {
    note(format_args!("{refusal}"));
}
