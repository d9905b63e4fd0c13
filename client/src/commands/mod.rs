//! What the commands share: vectors as arguments, printing, exit codes.

mod files;
pub mod impact;
pub mod list;
pub mod load;
mod objects;
pub mod prefracture;
pub mod status;
pub mod threshold;
mod when;

use shatter_client::{Deadline, Impact, Refusal};
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
    /// Nobody reads stdout any more.
    Closed,
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

/// Writes to stdout; a reader that went away ends the command in peace.
fn out(text: Arguments<'_>) -> Result<(), Failure> {
    std::io::stdout().write_fmt(text).map_err(|_| Failure::Closed)
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

/// `X,Y,Z` as an argument.
fn vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, z] = parts.as_slice() else {
        return Err("three numbers X,Y,Z are wanted".to_owned());
    };
    let number = |part: &str| part.trim().parse::<f64>().map_err(|_| format!("`{part}` is not a number"));
    Ok([number(x)?, number(y)?, number(z)?])
}

/// Ends with a usage error, or with the help that was asked for.
pub fn usage(error: &clap::Error, json: bool) -> ExitCode {
    if json && error.use_stderr() {
        let message = error.to_string();
        // Up to the usage that follows; what is missing stands on lines of its own.
        let lines = message.lines().take_while(|line| !line.is_empty()).map(str::trim);
        let first = lines.collect::<Vec<_>>().join(" ");
        let first = first.trim_start_matches("error: ");
        let document = serde_json::json!({"error": {
            "kind": "usage", "message": first, "fault": "caller", "retry": false, "retry_after_ms": null, "at": "",
        }});
        // A reader that went away cannot be told.
        let _ = out(format_args!("{document:#}\n"));
    }
    let _ = error.print();
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// Ends with a refusal.
pub fn refused(refusal: &Refusal, json: bool) -> ExitCode {
    if json {
        let _ = document(&refusal.document());
    }
    let _ = writeln!(std::io::stderr(), "shatter: {refusal}");
    ExitCode::from(refusal.kind.exit_code())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_three_numbers() {
        assert_eq!(vector("-1,0.5, 0"), Ok([-1.0, 0.5, 0.0]));
        for text in ["", "1,2", "1,2,3,4", "1,x,3"] {
            assert!(vector(text).is_err(), "{text}");
        }
    }
}
