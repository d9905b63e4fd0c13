//! Errors of the commands of a client, and their output.

use super::stdout::{StdoutError, print};
use super::{print_help, usage_message, usage_text};
use clap::CommandFactory;
use shatter_proto::{Error, exit, text};
use std::fmt::Arguments;
use std::io::Write;
use std::process::ExitCode;

/// Reason why a command ended early.
pub enum CliError {
    /// Arguments that do not go together.
    Usage(String),
    /// An error of the client or the service.
    Refused(Error),
    /// The command printed an incomplete result; the error is the reason.
    Reported(Error),
    /// The reader of stdout went away.
    Closed,
}

impl From<StdoutError> for CliError {
    fn from(error: StdoutError) -> Self {
        match error {
            StdoutError::Closed => Self::Closed,
            StdoutError::Failed(error) => Self::Refused(error),
        }
    }
}

impl From<Error> for CliError {
    fn from(error: Error) -> Self {
        Self::Refused(error)
    }
}

/// Writes to stdout.
///
/// # Errors
/// `output` if stdout cannot be written; [`CliError::Closed`] if its reader went away.
pub fn out(text: Arguments<'_>) -> Result<(), CliError> {
    Ok(print(text)?)
}

/// Writes a note beside the result to stderr. A note that cannot be written is lost.
pub fn note(note: Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "shatter: {}", text::message(&note.to_string()));
}

/// Prints one JSON document.
///
/// # Errors
/// Those of [`out`].
pub fn document(value: &serde_json::Value) -> Result<(), CliError> {
    out(format_args!("{value:#}\n"))
}

/// Ends with a usage error, or with the help that was requested.
pub fn usage<C: CommandFactory>(error: &clap::Error, json: bool) -> ExitCode {
    if !error.use_stderr() {
        return print_help(error).map_or_else(|error| ended::<C>(&error.into(), false), |()| ExitCode::SUCCESS);
    }
    if json {
        let message = usage_message(error);
        failed_document(&serde_json::json!({"error": {
            "kind": "usage", "message": message, "fault": "caller", "retry": false, "retry_after_ms": null, "at": "",
        }}));
    }
    let _ = write!(std::io::stderr(), "{}", usage_text::<C>(error));
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// Ends with the error of a command that ended early.
pub fn ended<C: CommandFactory>(failure: &CliError, json: bool) -> ExitCode {
    match failure {
        CliError::Closed => ExitCode::from(exit::CLOSED),
        CliError::Usage(message) => {
            let message = text::message(message) + "\n";
            usage::<C>(&clap::Error::raw(clap::error::ErrorKind::ValueValidation, message), json)
        }
        CliError::Refused(error) => {
            if json {
                failed_document(&error.document());
            }
            print_error(error);
            ExitCode::from(error.kind.exit_code())
        }
        CliError::Reported(error) => {
            print_error(error);
            ExitCode::from(error.kind.exit_code())
        }
    }
}

/// Prints an error as a document. If stdout cannot be written, stderr reports that; the exit code stays that of the first error.
fn failed_document(document: &serde_json::Value) {
    if let Err(StdoutError::Failed(error)) = print(format_args!("{document:#}\n")) {
        print_error(&error);
    }
}

fn print_error(error: &Error) {
    note(format_args!("{}: {error}", error.kind.name()));
}

/// A number of bytes with a unit, for people.
pub fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 * 1e-3),
        _ => format!("{:.1} MB", bytes as f64 * 1e-6),
    }
}
