//! The commands of `shatter`, one file each, and what they share.

mod files;
pub mod impact;
pub mod list;
mod objects;
mod parse;
pub mod prefracture;
pub mod status;
pub mod threshold;
mod time_of_day;
mod wait;

use shatter_cli_common::cli_error::{CliError, document, note, out};
use shatter_client::{Contact, Deadline};
use std::time::Duration;

/// How long a command waits for a reply of the service.
const REPLY: Duration = Duration::from_secs(5);

/// How long a command waits for the answer to a strike.
const ANSWER: Duration = Duration::from_secs(120);

/// The deadline for a reply of the service.
fn reply() -> Deadline {
    Deadline::after(REPLY)
}

/// `contact` with the duration and the radius, where they were given.
fn with_options(contact: Contact, duration_s: Option<f64>, radius_m: Option<f64>) -> Contact {
    let contact = duration_s.map_or(contact, |duration_s| contact.duration(duration_s));
    radius_m.map_or(contact, |radius_m| contact.radius(radius_m))
}
