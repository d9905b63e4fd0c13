//! `shatterd serve`.

use super::CommandError;
use super::expected_file::{self, ExpectedFile};
use super::log::LineWriter;
use super::stdin;
use crate::config::{Config, LogFormat};
use crate::serve::{ServeOptions, run as serve};
use shatter_cli_common::{self as program, StdoutError, whole_number};
use shatter_engine::scene::Scene;
use shatter_engine::wire::loader;
use shatter_proto::name::ServiceName;
use shatter_proto::text::quoted;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::paths::ServicePaths;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio::sync::Notify;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

/// Arguments of `shatterd serve`.
#[derive(clap::Args)]
pub struct ServeArgs {
    /// Name of the service; daemons with different names run side by side
    #[arg(long, env = "SHATTER_SERVICE")]
    service: Option<String>,
    /// Configuration file; keys that it omits keep their defaults
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Folder of databases: every file NAME.shatter, except hidden ones (with a leading dot)
    #[arg(long, value_name = "DIR")]
    databases: Option<PathBuf>,
    /// Scene file: which objects are served and what is simulated of each [default: all databases of the folder, whole]
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Worker threads, at most 1024; 0: one per core
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(0..=1024))]
    threads: Option<usize>,
    /// Log filter: error, warn, info, debug, trace, off, or tracing directives
    #[arg(long, value_name = "FILTER")]
    log: Option<String>,
    /// End when standard input ends, as at SIGTERM: for a program that starts a daemon of its own and holds the other end of a pipe
    #[arg(long)]
    end_with_stdin: bool,
}

/// Serves until SIGINT or SIGTERM, or until standard input ends if that is wanted.
///
/// # Errors
/// [`CommandError`] for a configuration, scene, folder or transport that cannot be used.
pub fn run(args: &ServeArgs) -> Result<(), CommandError> {
    args.config.as_deref().map_or(Ok(()), |file| expected_file::check(file, ExpectedFile::Configuration))?;
    args.scene.as_deref().map_or(Ok(()), |file| expected_file::check(file, ExpectedFile::Scene))?;
    let config = configured(args)?;
    log(&config)?;
    // Files that are created from here on are closed to other users, including files that libraries create.
    rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
    let name = ServiceName::new(&config.service.name)?;
    let runtime = std::env::var_os("XDG_RUNTIME_DIR");
    let paths = ServicePaths::new(&name, runtime.as_deref().map(Path::new), rustix::process::geteuid().as_raw());
    let ready = Box::new(|| {
        match program::print(format_args!("ready\n")) {
            // The process that started the daemon may have closed stdout; the daemon serves all the same.
            Ok(()) | Err(StdoutError::Closed) => Ok(()),
            Err(_) if program::is_closed() => Ok(()),
            Err(StdoutError::Failed(error)) => Err(error),
        }
    });
    let scene = args.scene.as_deref().map(Scene::load).transpose()?;
    let only = scene.as_ref().map(Scene::databases);
    let stop = Arc::new(Notify::new());
    if args.end_with_stdin {
        let stop = stop.clone();
        stdin::at_end(move || stop.notify_one())?;
    }
    serve(ServeOptions { paths, config, loader: loader(scene), only, ready, stop })?;
    Ok(())
}

/// Merges defaults, configuration file and flags.
fn configured(args: &ServeArgs) -> Result<Config, Error> {
    let mut config = Config::load(args.config.as_deref())?;
    if let Some(service) = &args.service {
        config.service.name.clone_from(service);
    }
    if let Some(databases) = &args.databases {
        config.databases.folder.clone_from(databases);
    }
    if let Some(threads) = args.threads {
        config.compute.threads = threads;
    }
    if let Some(filter) = &args.log {
        config.log.filter.clone_from(filter);
    }
    config.checked("command line")
}

/// Sends log messages to stderr.
fn log(config: &Config) -> Result<(), Error> {
    let wrong = |why: String| Error::new(ErrorKind::Configuration, "log.filter", format!("log.filter: {why}"));
    // A bare word that is no level would name a module, and the filter would drop every message.
    let level = |word: &&str| word.contains(['=', '[', ':', '_']) || word.parse::<LevelFilter>().is_ok();
    if let Some(word) = config.log.filter.split(',').map(str::trim).find(|word| !level(word)) {
        return Err(wrong(format!("`{}` is not a level; use error, warn, info, debug, trace or off", quoted(word))));
    }
    let filter = EnvFilter::try_new(&config.log.filter).map_err(|error| wrong(quoted(&error.to_string())))?;
    let builder = tracing_subscriber::fmt().with_env_filter(filter);
    // If the reader of stderr is gone, the daemon keeps serving and drops the messages.
    // Messages may contain text from files: the daemon writes no escape sequences, not even colors.
    let builder = builder.with_ansi(false).log_internal_errors(false);
    let started = match config.log.format {
        LogFormat::Text => builder.with_writer(|| LineWriter::new(std::io::stderr())).try_init(),
        // JSON strings escape control characters.
        LogFormat::Json => builder.with_writer(std::io::stderr).json().try_init(),
    };
    started.map_err(|error| Error::new(ErrorKind::Failed, "log", error.to_string()))
}
