//! The program `shatter`: list, strike and watch the objects of a running `shatterd`.

mod commands;

use clap::{Parser, Subcommand};
use commands::{impact, list, prefracture, status, threshold, view};
use shatter_cli_common::cli_error::{CliError, ended, usage};
use shatter_cli_common::lab::ForwardedArgs;
use shatter_cli_common::manuals::ManualsArgs;
use std::process::ExitCode;

/// Strike brittle objects and fetch the fragments from a running shatterd
#[derive(Parser)]
#[command(name = "shatter", version, max_term_width = 100)]
struct Cli {
    /// Name of the service
    #[arg(long, global = true, env = "SHATTER_SERVICE", hide_env_values = true, default_value = "default")]
    service: String,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List the objects of the service
    List(list::Args),
    /// Print the state of the service
    Status(status::Args),
    /// Strike an object
    Impact(Box<impact::Args>),
    /// Divide an object evenly ahead of time, without an impact
    Prefracture(prefracture::Args),
    /// Print the impulse that just breaks an object
    Threshold(threshold::Args),
    /// Open a page on this machine in which the objects are struck with the mouse
    View(view::Args),
    /// Measure the service under many impacts from many processes
    #[command(disable_help_flag = true)]
    Load(ForwardedArgs),
    /// Write man pages and shell completions, for packages
    #[command(hide = true)]
    Manuals(ManualsArgs),
}

fn main() -> ExitCode {
    shatter_cli_common::report_file_size_limit();
    let json = std::env::args_os().any(|argument| argument == "--json");
    let cli = match shatter_cli_common::arguments::<Cli>() {
        Ok(cli) => cli,
        Err(error) => return usage::<Cli>(&error, json),
    };
    let result = match &cli.command {
        Command::List(args) => list::run(&cli.service, args),
        Command::Status(args) => status::run(&cli.service, args),
        Command::Impact(args) => impact::run(&cli.service, args),
        Command::Prefracture(args) => prefracture::run(&cli.service, args),
        Command::Threshold(args) => threshold::run(&cli.service, args),
        Command::View(args) => view::run(&cli.service, args),
        Command::Load(arguments) => {
            Err(CliError::Refused(arguments.run("shatter", "load", &[("SHATTER_SERVICE", &cli.service)])))
        }
        Command::Manuals(args) => args.run::<Cli>().map_err(CliError::from),
    };
    result.map_or_else(|failure| ended::<Cli>(&failure, json), |()| ExitCode::SUCCESS)
}
