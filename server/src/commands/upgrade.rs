//! `shatterd upgrade`: databases of older formats are converted, in place. Lattices and lifts are taken over, examples and what
//! is learned from them are made again, from the same impacts.

use super::bake_progress::BakeProgress;
use super::expected_file::{self, ExpectedFile};
use super::{CommandError, interrupt, output};
use clap::Args;
use serde_json::{Value, json};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, DatabaseError};
use shatter_proto::text;
use std::path::{Path, PathBuf};

/// Flags of `shatterd upgrade`.
#[derive(Args, Debug)]
pub struct UpgradeArgs {
    /// Database files
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Converts each file; one that has the newest format already is left as it is. One that fails is as it was, and the others are
/// converted all the same; an interruption ends it.
pub fn run(args: &UpgradeArgs) -> Result<(), CommandError> {
    let token = interrupt::token();
    let (mut files, mut failures) = (Vec::new(), Vec::new());
    for file in &args.files {
        match upgrade(file, &token) {
            Err(failure) if failure.is_interrupted() => return Err(failure.with_files(Value::Array(files))),
            Err(failure) => {
                files.push(json!({ "file": shown(file), "error": failure.document()["error"] }));
                failures.push(failure);
            }
            Ok(from) => {
                if !args.json {
                    output::print(&format!("{}: format {from} → {}\n", text::message(&shown(file)), database::FORMAT))?;
                }
                files.push(json!({ "file": shown(file), "from": from, "to": database::FORMAT }));
            }
        }
    }
    let files = Value::Array(files);
    match CommandError::of_files(&failures) {
        Some(failure) => Err(failure.with_files(files)),
        None if args.json => output::print(&format!("{}\n", json!({ "files": files }))),
        None => Ok(()),
    }
}

fn shown(file: &Path) -> String {
    file.display().to_string()
}

/// Converts one file and says which format it had.
fn upgrade(file: &Path, token: &CancelToken) -> Result<String, CommandError> {
    expected_file::check(file, ExpectedFile::Database)?;
    let damaged = |error: DatabaseError| CommandError::database(file, &error);
    let (partial, from) = database::load_older(file).map_err(damaged)?;
    if from != database::FORMAT {
        let bar = BakeProgress::new(&shown(file), partial.impacts());
        let failed = |error| CommandError::from(error).of_file(file);
        let prepared = partial.complete(token, &mut |step| bar.show(step)).map_err(failed)?;
        bar.say("write");
        // A link stays one: what it points at is replaced.
        let target = file.canonicalize().map_err(|error| CommandError::output(file, &error))?;
        let writing = interrupt::writing();
        database::save(&prepared, &target).map_err(damaged)?;
        drop(writing);
        bar.finish();
    }
    Ok(from)
}
