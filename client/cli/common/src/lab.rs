//! Commands that the program `shatter-lab` runs: studies, the demonstration, the load generator.

use super::is_closed;
use shatter_proto::{Error, ErrorKind};
use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

/// Name of the program.
pub const PROGRAM: &str = "shatter-lab";

/// Environment variable that names the calling program to `shatter-lab`.
pub(crate) const CALLED_AS: &str = "SHATTER_CALLED_AS";

/// Arguments that are passed on unchanged.
#[derive(clap::Args, Debug)]
pub struct ForwardedArgs {
    /// Arguments of the command; --help lists them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

impl ForwardedArgs {
    /// Replaces this process by `shatter-lab command …`, called by the program `caller`, with these variables in its environment. Returns
    /// only if that cannot be started.
    pub fn run(&self, caller: &str, command: &str, variables: &[(&str, &str)]) -> Error {
        // Rust has opened `/dev/null` in its place, which the next program would use as standard output.
        if is_closed() {
            return Error::new(ErrorKind::Output, "stdout", "cannot write to stdout: it is closed");
        }
        let variables = variables.iter().copied().chain([(CALLED_AS, caller)]);
        start(program().arg(command).args(&self.arguments).envs(variables))
    }
}

/// The program beside this one, else the one on the search path of the shell.
pub fn program() -> Command {
    let beside: Option<PathBuf> = std::env::current_exe().ok().map(|own| own.with_file_name(PROGRAM));
    Command::new(beside.filter(|program| program.exists()).unwrap_or_else(|| PROGRAM.into()))
}

fn start(command: &mut Command) -> Error {
    absent(&command.exec())
}

/// Error for a `shatter-lab` that cannot be started.
pub fn absent(error: &std::io::Error) -> Error {
    let message = format!(
        "cannot start {PROGRAM}, which runs this command: {error}; build it by `cargo build --release` and put it beside this program"
    );
    Error::new(ErrorKind::Configuration, PROGRAM, message)
}
