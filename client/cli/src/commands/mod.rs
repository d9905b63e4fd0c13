//! Commands of `shatter`, one file each, and their common parts.

mod files;
pub mod impact;
pub mod list;
mod objects;
mod parse;
pub mod prefracture;
mod result_text;
pub mod status;
pub mod threshold;
mod time_of_day;
pub mod view;
mod wait;

use shatter_cli_common::cli_error::{CliError, document, note, out};
use shatter_client::{Contact, Deadline, Effect, FractureResult, FragmentSurface, RequestedSurface};
use shatter_proto::text::{number, quoted};
use std::time::Duration;

/// Timeout of a reply of the service.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);

/// Timeout of the result of a request.
const RESULT_TIMEOUT: Duration = Duration::from_secs(120);

/// Deadline for a reply of the service.
fn reply() -> Deadline {
    Deadline::after(REPLY_TIMEOUT)
}

/// Warns of a result whose cells were merged into one fragment, which is the whole object.
fn note_one_piece(result: &FractureResult) {
    let sites = result.summary().sites;
    let merges = result.effects().any(|cost| cost.effect == Effect::Slivers && cost.has_run);
    if merges && sites > 1 && result.fragments().len() == 1 {
        note(format_args!(
            "warning: the object is in one piece: all {sites} cells lie in a protected region of the scene or were too small for fragments of their own (effect `slivers`); shrink the region, pass --disable slivers, bake it with a smaller --crack-spacing, or lower `volume_min_m3` if the scene has it"
        ));
    }
}

/// Warns of fragments with the lattice's surface where the exact one was asked for.
fn note_other_surface(asked: Option<RequestedSurface>, is_of_fragment: bool, result: &FractureResult) {
    let summary = result.summary();
    if asked != Some(RequestedSurface::Exact) || summary.surface == FragmentSurface::Exact || result.is_whole() {
        return;
    }
    let object = quoted(&summary.object);
    let why = match is_of_fragment {
        true => "the struck fragment has it, and its fragments keep it".to_owned(),
        false => format!("`{object}` has no exact surface; `shatterd inspect {object}` prints why"),
    };
    note(format_args!("warning: the fragments have the lattice's surface, not the exact one: {why}"));
}

/// Contact duration above which a duration in milliseconds is more likely, s: hard objects touch for less.
const LONG_CONTACT_S: f64 = 0.1;

/// Warns of a long contact that left the object whole: its unit may be wrong.
fn note_long_contact(duration_s: Option<f64>, result: &FractureResult) {
    if let Some(duration_s) = duration_s.filter(|duration_s| *duration_s >= LONG_CONTACT_S && result.is_whole()) {
        note(format_args!(
            "warning: a contact of {} s spreads the impulse over a long time, so the force is small; --duration-s takes seconds (2 ms are 0.002)",
            number(duration_s)
        ));
    }
}

/// `contact` with duration and radius, if they are given.
fn with_options(contact: Contact, duration_s: Option<f64>, radius_m: Option<f64>) -> Contact {
    let contact = duration_s.map_or(contact, |duration_s| contact.duration(duration_s));
    radius_m.map_or(contact, |radius_m| contact.radius(radius_m))
}
