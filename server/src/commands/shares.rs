//! Shares of a bake: which one this is, what is kept while it runs, and how a stopped one goes on.

use super::Failure;
use super::bake::BakeArgs;
use super::bar::Bar;
use serde_json::json;
use shatter_fracture::database::{self, BakeError, BakeRequest, Partial, Share, ShareError};
use shatter_fracture::surface::{RawMesh, Surface};
use shatter_fracture::token::Token;
use std::env::{VarError, var};
use std::path::Path;
use std::time::{Duration, Instant};

/// What is done is written at most this often.
const KEPT_EVERY: Duration = Duration::from_secs(10);

/// Number of shares of an indexed Kubernetes job, which tells its pods their index only.
const SHARDS_VARIABLE: &str = "SHATTER_SHARDS";

/// The share that was asked for; in a job array, of a bake with examples, the task's own.
pub fn share(asked: Option<Share>, examples: u64) -> Result<Share, Failure> {
    let refused = |error: ShareError| Failure::refused("shard", "", error.to_string());
    match asked {
        Some(share) => Ok(share),
        None if examples == 0 => Ok(Share::WHOLE),
        None => match scheduled(&|name| number(name))? {
            None => Ok(Share::WHOLE),
            Some((index, count, scheduler)) => {
                eprintln!("share {index} of {count}, says {scheduler}; --shard 0/1 bakes everything");
                Share::new(index, count).map_err(refused)
            }
        },
    }
}

/// Index and count that the job scheduler gives by these variables, and what it is called.
fn scheduled(
    variable: &dyn Fn(&'static str) -> Result<Option<u64>, Failure>,
) -> Result<Option<(u64, u64, &'static str)>, Failure> {
    if let (Some(id), Some(count)) = (variable("SLURM_ARRAY_TASK_ID")?, variable("SLURM_ARRAY_TASK_COUNT")?) {
        let first = variable("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0);
        let step = variable("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
        return Ok(Some((id.saturating_sub(first) / step, count, "Slurm")));
    }
    match (variable("JOB_COMPLETION_INDEX")?, variable(SHARDS_VARIABLE)?) {
        (Some(index), Some(count)) => Ok(Some((index, count, "Kubernetes"))),
        (Some(_), None) => Err(Failure::refused(
            "shard",
            SHARDS_VARIABLE,
            format!(
                "JOB_COMPLETION_INDEX is set: set {SHARDS_VARIABLE} to the job's completions, or bake everything with --shard 0/1"
            ),
        )),
        (None, _) => Ok(None),
    }
}

/// A variable of the environment that is a number.
fn number(name: &'static str) -> Result<Option<u64>, Failure> {
    let refused = |why: &dyn std::fmt::Display| Failure::refused("shard", name, format!("{name}: {why}"));
    match var(name) {
        Err(VarError::NotPresent) => Ok(None),
        Err(error) => Err(refused(&error)),
        Ok(text) => text.parse().map(Some).map_err(|error| refused(&error)),
    }
}

/// What `file` kept of the same work; nothing if there is no such file.
pub fn resume(
    file: &Path,
    raw: &RawMesh,
    args: &BakeArgs,
    request: &BakeRequest,
    share: Share,
) -> Result<Option<Partial>, Failure> {
    if !file.exists() {
        eprintln!("{} is not there: baking from the beginning", file.display());
        return Ok(None);
    }
    let partial = database::load_partial(file)?;
    let task = &partial.task;
    let asked = match args.add {
        None => task.request.as_ref() == Some(request),
        Some(count) => task.request.is_none() && task.end - task.first == count,
    };
    let same_mesh = partial.prepared.report.input_hash == database::input_hash(&Surface::repair(raw.clone())?);
    if asked && same_mesh && task.share == share && partial.prepared.name == args.name {
        return Ok(Some(partial));
    }
    let message =
        format!("{} was baked from another mesh or with other flags; without --resume it is replaced", file.display());
    Err(Failure::refused("other_work", file.display().to_string(), message))
}

/// Does what remains of the share, and keeps what is done in `file`: from time to time, when interrupted, and at the end of
/// a share that others must be joined to.
pub fn work(mut partial: Partial, file: &Path, token: &Token, bar: &Bar) -> Result<Partial, Failure> {
    let mut kept = None;
    while !partial.task.is_done() {
        bar.show(partial.examples());
        if kept.is_none_or(|kept: Instant| kept.elapsed() >= KEPT_EVERY) {
            database::save_partial(&partial, file)?;
            kept = Some(Instant::now());
        }
        match partial.step(token) {
            Err(BakeError::Cancelled(_)) => {
                database::save_partial(&partial, file)?;
                return Err(interrupted(&partial, file));
            }
            step => step?,
        }
    }
    bar.show(partial.examples());
    if partial.task.share.count > 1 {
        database::save_partial(&partial, file)?;
    }
    Ok(partial)
}

fn interrupted(partial: &Partial, file: &Path) -> Failure {
    let (done, of) = (partial.task.done, partial.task.impacts().len());
    let file = file.display();
    Failure::interrupted(format!("interrupted; {done} of {of} impacts are kept in {file}: go on with --resume"))
}

/// Removes what was kept of a bake that is complete.
pub fn forget(file: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Failure::output(file, &error)),
        _ => Ok(()),
    }
}

/// What is said of a finished share.
pub fn told(partial: &Partial, file: &Path, as_json: bool) -> String {
    let (task, object) = (&partial.task, &partial.prepared.name);
    let (share, impacts) = (task.share, task.impacts().len());
    if as_json {
        let document = json!({
            "object": object,
            "file": file.display().to_string(),
            "share": { "index": share.index, "count": share.count },
            "impacts": impacts,
            "impacts_of_all": task.end - task.first,
        });
        return format!("{document}\n");
    }
    format!("{object}: share {share} with {impacts} impacts in {}; join all with `shatterd merge`\n", file.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn check(variables: &[(&'static str, u64)], wanted: Result<Option<(u64, u64)>, &str>) {
        let all: BTreeMap<_, _> = variables.iter().copied().collect();
        let found = scheduled(&|name| Ok(all.get(name).copied()));
        let found = found.as_ref().map(|found| found.map(|(index, count, _)| (index, count))).map_err(Failure::kind);
        assert_eq!(found, wanted, "{variables:?}");
    }

    #[test]
    fn a_task_of_a_job_array_knows_its_share() {
        check(&[], Ok(None));
        check(&[("SLURM_ARRAY_TASK_ID", 3), ("SLURM_ARRAY_TASK_COUNT", 8)], Ok(Some((3, 8))));
        let from_one = [("SLURM_ARRAY_TASK_ID", 5), ("SLURM_ARRAY_TASK_COUNT", 4), ("SLURM_ARRAY_TASK_MIN", 1)];
        check(&[&from_one[..], &[("SLURM_ARRAY_TASK_STEP", 2)]].concat(), Ok(Some((2, 4))));
        check(&[("SLURM_ARRAY_TASK_ID", 3)], Ok(None));
        check(&[("JOB_COMPLETION_INDEX", 2), ("SHATTER_SHARDS", 5)], Ok(Some((2, 5))));
        check(&[("JOB_COMPLETION_INDEX", 2)], Err("shard"));
        check(&[("SHATTER_SHARDS", 5)], Ok(None));
    }
}
