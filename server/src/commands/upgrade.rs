//! `shatterd upgrade`: databases of older formats are converted, in place. Lattices and lifts are taken over, examples and what
//! is learned from them are made again, from the same impacts.

use super::bar::Bar;
use super::{Failure, interrupt, out};
use clap::Args;
use serde_json::json;
use shatter_fracture::database;
use shatter_fracture::token::Token;
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

/// Converts each file; one that has the newest format already is left as it is. The first that fails ends it: those before
/// it are converted, it and those after it are as they were.
pub fn run(args: &UpgradeArgs) -> Result<(), Failure> {
    let token = interrupt::token()?;
    let converted = args.files.iter().map(|file| Ok((file, upgrade(file, &token)?)));
    let converted = converted.collect::<Result<Vec<_>, Failure>>()?;
    if args.json {
        let files: Vec<_> = converted
            .iter()
            .map(|(file, from)| json!({ "file": file.display().to_string(), "from": from, "to": database::FORMAT }))
            .collect();
        return out::print(&format!("{}\n", json!({ "files": files })));
    }
    let line =
        |(file, from): &(&PathBuf, String)| format!("{}: format {from} → {}\n", file.display(), database::FORMAT);
    out::print(&converted.iter().map(line).collect::<String>())
}

/// Converts one file and says which format it had.
fn upgrade(file: &Path, token: &Token) -> Result<String, Failure> {
    let (partial, from) = database::load_older(file)?;
    if from != database::FORMAT {
        let bar = Bar::new();
        let prepared = partial.complete(token, &mut |step| bar.show(step))?;
        bar.say("write");
        database::save(&prepared, file)?;
        bar.finish();
    }
    Ok(from)
}
