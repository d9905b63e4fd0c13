//! `shatterd demo`.

use crate::demo::{self, DemoError, DemoOptions};
use shatter_proto::{Error, ErrorKind, exit};
use shatter_server::commands::{CommandError, output};
use shatter_server::config::data_folder;
use std::path::PathBuf;

/// Arguments of `shatterd demo`.
#[derive(clap::Args)]
pub struct DemoArgs {
    /// Folder for the page and the fragments
    #[arg(long, value_name = "DIR", default_value = "shatter-demo")]
    out: PathBuf,
    /// Folder for the baked object [default: demo in the platform's data folder]
    #[arg(long, value_name = "DIR")]
    databases: Option<PathBuf>,
    /// Name of the service that the demonstration's daemon opens [default: demo-PID]
    #[arg(long)]
    service: Option<String>,
}

/// Runs the demonstration and prints the names of its files.
pub fn run(args: &DemoArgs) -> Result<(), CommandError> {
    output::folder(&args.out)?;
    let databases = match &args.databases {
        Some(folder) => folder.clone(),
        None => data_folder()?.join("demo"),
    };
    let program = std::env::current_exe()
        .map_err(|error| Error::new(ErrorKind::Failed, "daemon", format!("cannot find this program: {error}")))?;
    let service = args.service.clone().unwrap_or_else(|| format!("demo-{}", std::process::id()));
    let database = databases.join(format!("{}.shatter", demo::NAME));
    let options = DemoOptions { out: args.out.clone(), databases, service, program };
    let made = demo::run(&options)?;
    let mut text = made.lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    let files: String = made.files.iter().chain([&database]).map(|file| format!("{}\n", file.display())).collect();
    text.push_str(&format!("\nFiles:\n{files}\nOpen {} in a browser.\n", made.page.display()));
    output::print(&text)
}

impl From<DemoError> for CommandError {
    fn from(error: DemoError) -> Self {
        let message = error.to_string();
        match error {
            DemoError::Refused(error) => error.into(),
            DemoError::Export(error) => error.into(),
            DemoError::Material(error) => error.into(),
            DemoError::Surface(error) => error.into(),
            DemoError::Bake(error) => error.into(),
            DemoError::Database { path, source } => Self::database(&path, &source),
            // The daemon has said on stderr what it refused.
            DemoError::DaemonEnded(status) if status.code() == Some(exit::REFUSED.into()) => {
                Self::refused("demo", "daemon", message)
            }
            DemoError::Process(_) | DemoError::DaemonEnded(_) | DemoError::DaemonSilent { .. } => {
                Self::ours("demo", message)
            }
            DemoError::StayedWhole { .. } | DemoError::Energy(_) | DemoError::Picture(_) => Self::ours("demo", message),
        }
    }
}
