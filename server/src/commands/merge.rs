//! `shatterd merge`: joins the shares of a bake into the database.

use super::bake_progress::BakeProgress;
use super::expected_file::{self, ExpectedFile};
use super::{CommandError, bake_report, interrupt, output};
use clap::Args;
use shatter_fracture::database;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `shatterd merge`.
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Share files: all of one bake, in any order
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Folder of databases, for NAME.shatter
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Joins the shares, learns from all of their examples, and writes the database. The share files stay.
///
/// # Errors
/// [`CommandError`] for shares that do not belong together, or a file that cannot be read or written.
pub fn run(args: &MergeArgs) -> Result<(), CommandError> {
    let begun = Instant::now();
    args.files.iter().try_for_each(|file| expected_file::check(file, ExpectedFile::Database))?;
    let _made = output::EmptyFolders::before(&args.out);
    output::folder(&args.out)?;
    let token = interrupt::token();
    let bar = BakeProgress::new("merge", 0);
    let prepared = database::join(&args.files, &token, &mut |step| bar.show(step))?;
    let file = args.out.join(format!("{}.{}", prepared.name, database::EXTENSION));
    bar.show_step("write");
    let writing = interrupt::writing();
    database::save(&prepared, &file).map_err(|error| CommandError::database(&file, &error))?;
    drop(writing);
    bar.finish();
    bake_report::tell(&prepared, &file, begun.elapsed(), Vec::new(), args.json)
}
