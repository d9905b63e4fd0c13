//! The program `shatterd`, which bakes, checks scenes and serves.

use shatter_proto::{Error, ErrorKind};
use std::path::PathBuf;
use std::process::Command;

/// Name of the program.
const PROGRAM: &str = "shatterd";

/// The program beside this one, else the one on the search path of the shell.
#[must_use]
pub fn daemon_program() -> Command {
    let beside: Option<PathBuf> = std::env::current_exe().ok().map(|own| own.with_file_name(PROGRAM));
    Command::new(beside.filter(|program| program.exists()).unwrap_or_else(|| PROGRAM.into()))
}

/// Error for a `shatterd` that cannot be started.
pub(crate) fn absent(error: &std::io::Error) -> Error {
    let message = format!(
        "cannot start {PROGRAM}: {error}; build it by `cargo build --release` and put it beside this program, or start a daemon first"
    );
    Error::new(ErrorKind::Configuration, PROGRAM, message)
}
