//! Common parts of the daemon's tests: a place of their own, a toy engine, daemons in this process and in others.

#![allow(dead_code, unused_imports, reason = "every test file uses another part")]

mod bar;
mod daemon;
mod place;
mod raw;
mod toy;

pub use bar::bar;
pub use daemon::{Child, InProcess, play, role, shatter, shatter_program, shatterd, under};
pub use place::{TestPlace, within};
pub use raw::{RawPeer, Sent};
pub use toy::{addresses, loader, order};

use shatter_client::Deadline;

/// Long enough for a loaded machine; a test that waits for it has failed.
pub fn patience() -> Deadline {
    Deadline::ms(60_000)
}
