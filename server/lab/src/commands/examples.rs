//! `shatter-lab examples`: page on what a database has learned.

use crate::{report, study::examples};
use shatter_fracture::database;
use shatter_server::commands::{CommandError, output};
use std::path::PathBuf;

/// Arguments of `shatter-lab examples`.
#[derive(clap::Args)]
pub struct ExamplesArgs {
    /// Database file
    file: PathBuf,
    /// Folder for the page, NAME.html
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Writes the page.
///
/// # Errors
/// The database is damaged or has no examples, the page cannot be written.
pub fn run(args: &ExamplesArgs) -> Result<(), CommandError> {
    output::folder(&args.out)?;
    let prepared = database::load(&args.file).map_err(|error| CommandError::database(&args.file, &error))?;
    let page = args.out.join(format!("{}.html", prepared.name));
    output::whole(&page, report::study(&examples::page(&prepared)?).as_bytes())
}
