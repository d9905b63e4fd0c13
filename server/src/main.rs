//! `shatterd`: bakes objects and serves them.

use clap::{Parser, Subcommand};
use shatter_cli_common as program;
use shatter_cli_common::lab::ForwardedArgs;
use shatter_cli_common::manuals::ManualsArgs;
use shatter_server::commands::{CommandError, bake, check, inspect, interrupt, merge, serve};
use std::io::Write;
use std::process::ExitCode;

/// Bakes brittle objects and serves their fragments.
#[derive(Parser)]
#[command(name = "shatterd", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bakes a mug, serves it, strikes it three times and shows what came of it on a page.
    #[command(disable_help_flag = true)]
    Demo(ForwardedArgs),
    /// Turns a mesh into a database: names its defects, fills it with lattices, factors, calibrates.
    Bake(bake::BakeArgs),
    /// Joins the shares of a bake that was divided: the same bytes as if it had not been.
    Merge(merge::MergeArgs),
    /// Verifies a database and prints what it holds.
    Inspect(inspect::InspectArgs),
    /// Validates a scene and prints what is prepared and run for each of its objects.
    Check(check::CheckArgs),
    /// Serves the baked objects until it is ended.
    Serve(serve::ServeArgs),
    /// Shows how far the results can be trusted (hard cases, bad meshes), and what effects cost and look like.
    #[command(disable_help_flag = true)]
    Study(ForwardedArgs),
    /// Writes man pages and shell completions, for packages.
    #[command(hide = true)]
    Manuals(ManualsArgs),
}

fn main() -> ExitCode {
    let json = std::env::args_os().any(|argument| argument == "--json");
    let cli = match program::arguments::<Cli>() {
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
    // The daemon and the lab have their own ways to end.
    let own = matches!(cli.command, Command::Serve(_) | Command::Demo(_) | Command::Study(_));
    let watched = if own { Ok(()) } else { interrupt::watch(json) };
    let result = watched.and_then(|()| run(&cli.command));
    if result.is_err() {
        interrupt::ending();
    }
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(shatter_proto::exit::OURS),
        Err(failure) => failure.print(json),
    }
}

/// Runs a command; whether everything held that it looked at.
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
