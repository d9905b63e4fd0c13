//! `shatter-lab`: demonstration, studies and load generator. `shatterd demo`, `shatterd study` and `shatter load` run it.

use clap::{Parser, Subcommand};
use shatter_cli_common::cli_error::{ended, usage};
use shatter_lab::commands::{demo, examples, study};
use shatter_lab::load;
use shatter_server::commands::{CommandError, interrupt, serve};
use shatter_server::jobs::start_shared;
use std::process::ExitCode;

/// Demonstration, studies and load generator of Shatter
#[derive(Parser)]
#[command(name = "shatter-lab", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake a mug, serve it, strike it three times and write a page with the results
    Demo(demo::DemoArgs),
    /// Measure accuracy, robustness to hard cases and bad meshes, and the cost of effects
    Study(study::StudyArgs),
    /// Measure the service under requests from many client processes
    Load(Load),
    /// Run one client process of a load
    #[command(hide = true)]
    LoadClient(Service),
    /// Write a page on what a database has learned
    Examples(examples::ExamplesArgs),
    /// Run the daemon of the demonstration
    #[command(hide = true)]
    Serve(serve::ServeArgs),
}

#[derive(clap::Args)]
struct Service {
    /// Name of the service
    #[arg(long, env = "SHATTER_SERVICE", hide_env_values = true, default_value = "default")]
    service: String,
}

#[derive(clap::Args)]
struct Load {
    #[command(flatten)]
    service: Service,
    #[command(flatten)]
    load: load::LoadArgs,
}

fn main() -> ExitCode {
    shatter_cli_common::report_file_size_limit();
    let json = std::env::args_os().any(|argument| argument == "--json");
    let cli = match shatter_cli_common::arguments::<Cli>() {
        Ok(cli) => cli,
        Err(error) => return usage::<Cli>(&error, json),
    };
    match &cli.command {
        Command::Load(args) => client(load::run(&args.service.service, &args.load), json),
        Command::LoadClient(service) => client(load::work(&service.service), json),
        command => server(command, json),
    }
}

fn client(result: Result<(), shatter_cli_common::cli_error::CliError>, json: bool) -> ExitCode {
    result.map_or_else(|failure| ended::<Cli>(&failure, json), |()| ExitCode::SUCCESS)
}

fn server(command: &Command, json: bool) -> ExitCode {
    // The daemon handles signals itself.
    let own = matches!(command, Command::Serve(_));
    let begun = if own { Ok(()) } else { interrupt::watch(json).and_then(|()| Ok(start_shared(0)?)) };
    let result = begun.and_then(|()| run(command));
    if result.is_err() {
        interrupt::ending();
    }
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(shatter_proto::exit::OURS),
        Err(failure) => failure.print(json),
    }
}

/// Runs a command; returns whether all of its checks passed.
fn run(command: &Command) -> Result<bool, CommandError> {
    match command {
        Command::Demo(args) => demo::run(args).map(|()| true),
        Command::Study(args) => study::run(args),
        Command::Examples(args) => examples::run(args).map(|()| true),
        Command::Serve(args) => serve::run(args).map(|()| true),
        Command::Load(_) | Command::LoadClient(_) => Ok(true),
    }
}
