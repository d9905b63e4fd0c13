//! `shatterd`: bakes objects and serves them.

use clap::{Parser, Subcommand};
use shatter_cli_common as program;
use shatter_cli_common::lab::ForwardedArgs;
use shatter_cli_common::manuals::ManualsArgs;
use shatter_server::commands::{CommandError, bake, check, expected_file, inspect, interrupt, merge, serve};
use shatter_server::jobs::start_shared;
use std::io::Write;
use std::process::ExitCode;

/// Bake brittle objects and serve their fragments
#[derive(Parser)]
#[command(name = "shatterd", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake a mug, serve it, strike it three times and write a page with the results
    #[command(disable_help_flag = true)]
    Demo(ForwardedArgs),
    /// Turn a mesh into a database: repair, build lattices, factor, calibrate
    Bake(bake::BakeArgs),
    /// Join the shares of a bake into a database, with the same bytes as an undivided bake
    Merge(merge::MergeArgs),
    /// Verify a database and print its contents
    Inspect(inspect::InspectArgs),
    /// Validate a scene and print, for each object, what is prepared and run
    Check(check::CheckArgs),
    /// Serve the baked objects until SIGINT or SIGTERM
    Serve(serve::ServeArgs),
    /// Measure accuracy, robustness to hard cases and bad meshes, and the cost of effects
    #[command(disable_help_flag = true)]
    Study(ForwardedArgs),
    /// Writes man pages and shell completions, for packages.
    #[command(hide = true)]
    Manuals(ManualsArgs),
}

fn main() -> ExitCode {
    program::report_file_size_limit();
    let json = std::env::args_os().any(|argument| argument == "--json");
    let arguments = program::arguments::<Cli>().map_err(|mut error| {
        expected_file::explain_missing(&mut error, std::env::args_os().skip(1));
        error
    });
    let cli = match arguments {
        Ok(cli) => cli,
        Err(error) if json && error.use_stderr() => return CommandError::usage(&error).print(true),
        Err(error) if error.use_stderr() => {
            let _ = write!(std::io::stderr(), "{}", program::usage_text::<Cli>(&error));
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
        Err(help) => {
            let printed = program::print_help(&help);
            return printed.map_or_else(|error| CommandError::from(error).print(false), |()| ExitCode::SUCCESS);
        }
    };
    // The daemon and the lab handle signals themselves.
    let own = matches!(cli.command, Command::Serve(_) | Command::Demo(_) | Command::Study(_));
    let begun = if own { Ok(()) } else { begin(&cli.command, json) };
    let result = begun.and_then(|()| run(&cli.command));
    if result.is_err() {
        interrupt::ending();
    }
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(shatter_proto::exit::OURS),
        Err(failure) => failure.print(json),
    }
}

/// Starts the threads of a command: one that waits for signals, and those that compute.
fn begin(command: &Command, json: bool) -> Result<(), CommandError> {
    interrupt::watch(json)?;
    // Each thread keeps its own free memory, which `inspect --memory` does not count.
    let count = if matches!(command, Command::Inspect(args) if args.memory) { 1 } else { 0 };
    Ok(start_shared(count)?)
}

/// Runs a command; returns whether all of its checks passed.
fn run(command: &Command) -> Result<bool, CommandError> {
    match command {
        Command::Demo(arguments) => Err(arguments.run("shatterd", "demo", &[]).into()),
        Command::Bake(args) => bake::run(args).map(|()| true),
        Command::Merge(args) => merge::run(args).map(|()| true),
        Command::Inspect(args) => inspect::run(args).map(|()| true),
        Command::Check(args) => check::run(args).map(|()| true),
        Command::Serve(args) => serve::run(args).map(|()| true),
        Command::Study(arguments) => Err(arguments.run("shatterd", "study", &[]).into()),
        Command::Manuals(args) => Ok(args.run::<Cli>().map(|()| true)?),
    }
}
