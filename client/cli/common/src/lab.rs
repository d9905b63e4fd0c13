//! Commands that `shatter-lab` carries out: studies, the demonstration, the load generator.

use super::is_closed;
use shatter_proto::{Error, ErrorKind};
use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

/// The program.
pub const PROGRAM: &str = "shatter-lab";

/// Variable that tells `shatter-lab` which program handed its arguments over.
pub(crate) const CALLED_AS: &str = "SHATTER_CALLED_AS";

/// Arguments that are handed over as they are.
#[derive(clap::Args, Debug)]
pub struct ForwardedArgs {
    /// The command's own arguments; --help lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

impl ForwardedArgs {
    /// Goes on as `shatter-lab command …` for the program `caller`, with these variables in its environment; comes back only when that
    /// cannot be started.
    pub fn run(&self, caller: &str, command: &str, variables: &[(&str, &str)]) -> Error {
        // Rust has opened `/dev/null` in its place, which the next program would take for a standard output.
        if is_closed() {
            return Error::new(ErrorKind::Output, "stdout", "cannot write to stdout: it is closed");
        }
        let variables = variables.iter().copied().chain([(CALLED_AS, caller)]);
        start(program().arg(command).args(&self.arguments).envs(variables))
    }
}

/// The program beside this one, else the one that the shell would find.
pub fn program() -> Command {
    let beside: Option<PathBuf> = std::env::current_exe().ok().map(|own| own.with_file_name(PROGRAM));
    Command::new(beside.filter(|program| program.exists()).unwrap_or_else(|| PROGRAM.into()))
}

fn start(command: &mut Command) -> Error {
    absent(&command.exec())
}

/// The refusal of what the program would have carried out, which could not be started.
pub fn absent(error: &std::io::Error) -> Error {
    let message = format!(
        "cannot start {PROGRAM}, which carries this out: {error}; it is built by `cargo build --release` and belongs beside this program"
    );
    Error::new(ErrorKind::Configuration, PROGRAM, message)
}
