//! Shares of a bake: selection, checkpoints and resumption.

use super::CommandError;
use super::bake::{BakeArgs, input_hash};
use super::bake_progress::BakeProgress;
use super::{interrupt, output};
use serde_json::json;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, BakeError, BakeRequest, BakeShare, PartialBake, ShareError};
use shatter_fracture::surface::RawMesh;
use shatter_proto::text::{counted, quoted};
use std::env::{VarError, var};
use std::path::Path;
use std::time::{Duration, Instant};

/// Minimum interval between checkpoints.
const KEPT_EVERY: Duration = Duration::from_secs(10);

/// Variable for the number of shares: an indexed Kubernetes job gives its pods only their index, and a Slurm array that repeats
/// some tasks counts only those.
const SHARDS_VARIABLE: &str = "SHATTER_SHARDS";

/// Variable for the number of a task in a Slurm job array.
const SLURM_ID: &str = "SLURM_ARRAY_TASK_ID";

/// Variable for the number of a pod in an indexed Kubernetes job.
const KUBERNETES_INDEX: &str = "JOB_COMPLETION_INDEX";

/// The share that was given, or the task's own share in a job array if the bake has examples.
pub fn share(asked: Option<BakeShare>, examples: u64) -> Result<BakeShare, CommandError> {
    match asked {
        Some(share) if share.count > 1 && examples == 0 => {
            let message =
                format!("--shard {share} divides examples, but the bake has none; set their number with --examples");
            Err(CommandError::refused("shard", "--shard", message))
        }
        Some(share) => Ok(share),
        None if examples == 0 => Ok(BakeShare::WHOLE),
        None => Ok(scheduled(&|name| number(name))?.map_or(BakeShare::WHOLE, |(share, scheduler)| {
            let (index, count) = (share.index, share.count);
            output::note(&format!("share {index} of {count} (from {scheduler}); --shard 0/1 bakes everything"));
            share
        })),
    }
}

/// Reader of an environment variable; `None` if it is not set.
type Variable<'a> = &'a dyn Fn(&'static str) -> Result<Option<u64>, CommandError>;

/// The share that the job scheduler assigns by these variables, and the scheduler's name.
fn scheduled(variable: Variable) -> Result<Option<(BakeShare, &'static str)>, CommandError> {
    let shards = variable(SHARDS_VARIABLE)?;
    if let Some(id) = variable(SLURM_ID)? {
        let share = shards.map_or_else(|| of_array(id, variable), |count| of_shards(SLURM_ID, id, count))?;
        return Ok(Some((share, "Slurm")));
    }
    match (variable(KUBERNETES_INDEX)?, shards) {
        (None, _) => Ok(None),
        (Some(index), Some(count)) => Ok(Some((of_shards(KUBERNETES_INDEX, index, count)?, "Kubernetes"))),
        (Some(_), None) => Err(unknown_count(&format!("{KUBERNETES_INDEX} is set"), "the job's completions")),
    }
}

/// Share `index` from the variable `name`, of the number of shares in [`SHARDS_VARIABLE`].
fn of_shards(name: &'static str, index: u64, count: u64) -> Result<BakeShare, CommandError> {
    BakeShare::new(index, count).map_err(|error| match error {
        ShareError::Count { .. } => {
            CommandError::refused("shard", SHARDS_VARIABLE, format!("{SHARDS_VARIABLE}: {error}"))
        }
        _ => CommandError::refused("shard", name, format!("{name} is {index}, {SHARDS_VARIABLE} is {count}: {error}")),
    })
}

/// Share of task `id` of a Slurm array without [`SHARDS_VARIABLE`]. An array with gaps may repeat some tasks of an earlier one; its
/// own count would divide the examples differently, so it is refused.
fn of_array(id: u64, variable: Variable) -> Result<BakeShare, CommandError> {
    let [count, first, last] = ["SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX"].map(variable);
    let (Some(count), Some(first), Some(last)) = (count?, first?, last?) else {
        return Err(unknown_count(
            &format!("{SLURM_ID} is set without the array's count, first and last task"),
            ALL_TASKS,
        ));
    };
    let contiguous = last.checked_sub(first).and_then(|span| span.checked_add(1)) == Some(count);
    match id.checked_sub(first).map(|index| BakeShare::new(index, count)) {
        Some(Ok(share)) if contiguous => Ok(share),
        _ => Err(unknown_count(&format!("the Slurm array has {count} tasks from {first} to {last}"), ALL_TASKS)),
    }
}

/// Advice on [`SHARDS_VARIABLE`] for users of Slurm.
const ALL_TASKS: &str = "the number of shares of the whole bake, number the tasks from 0";

fn unknown_count(found: &str, wanted: &str) -> CommandError {
    let message = format!("{found}; set {SHARDS_VARIABLE} to {wanted}, or bake everything with --shard 0/1");
    CommandError::refused("shard", SHARDS_VARIABLE, message)
}

/// Reads an environment variable as a number.
fn number(name: &'static str) -> Result<Option<u64>, CommandError> {
    match var(name) {
        Err(VarError::NotPresent) => Ok(None),
        Err(VarError::NotUnicode(text)) => whole(name, &text.to_string_lossy()).map(Some),
        Ok(text) => whole(name, &text).map(Some),
    }
}

/// The value `text` of the environment variable `name`.
fn whole(name: &'static str, text: &str) -> Result<u64, CommandError> {
    text.parse().map_err(|_| {
        let message = format!("{name} is `{}`; it must be a whole number from 0 to {}", quoted(text), u64::MAX);
        CommandError::refused("shard", name, message)
    })
}

/// Refuses to start again if `file` holds a checkpoint, which may be hours of work.
pub fn nothing_kept(file: &Path) -> Result<(), CommandError> {
    if !file.exists() {
        return Ok(());
    }
    let task = database::load_task(file)
        .map_err(|error| CommandError::database(file, &error).advised("remove it, or discard it with --restart"))?;
    let (done, of, shown) = (task.done, task.impacts().len(), file.display());
    let message = format!(
        "{}; continue with --resume, or discard them with --restart",
        kept_impacts(done, of, &shown.to_string())
    );
    Err(CommandError::refused("kept_share", shown.to_string(), message))
}

/// Loads the checkpoint `file` of the same work; `None` if there is no such file.
pub fn resume(
    file: &Path,
    raw: &RawMesh,
    args: &BakeArgs,
    request: &BakeRequest,
    share: BakeShare,
) -> Result<Option<PartialBake>, CommandError> {
    if !file.exists() {
        output::note(&format!("{} does not exist; baking from the beginning", file.display()));
        return Ok(None);
    }
    let partial = database::load_partial(file).map_err(|error| {
        CommandError::database(file, &error).advised("remove it, or bake with --restart instead of --resume")
    })?;
    let task = &partial.task;
    let asked = match args.add {
        None => task.request.as_ref() == Some(&request.without_cracks()),
        Some(count) => task.request.is_none() && task.end - task.first == count,
    };
    let same_mesh = partial.prepared.report.input_hash == input_hash(raw.clone(), request)?;
    if asked && same_mesh && task.share == share && partial.prepared.name == request.name {
        return Ok(Some(partial));
    }
    let message = format!(
        "{} was baked from another mesh, other cracks or with other flags; replace it with --restart instead of --resume",
        file.display()
    );
    Err(CommandError::refused("other_work", file.display().to_string(), message))
}

/// Computes the rest of the share and writes checkpoints to `file`: from time to time, when interrupted, and at the end of a share
/// that must be merged.
pub fn work(
    mut partial: PartialBake,
    file: &Path,
    token: &CancelToken,
    bar: &BakeProgress,
) -> Result<PartialBake, CommandError> {
    let keep = |partial: &PartialBake| {
        let _writing = interrupt::writing();
        database::save_partial(partial, file).map_err(|error| CommandError::database(file, &error))
    };
    let _keeping = interrupt::keeping();
    let mut kept = None;
    while !partial.task.is_done() {
        bar.show(partial.examples());
        if kept.is_none_or(|kept: Instant| kept.elapsed() >= KEPT_EVERY) {
            keep(&partial)?;
            kept = Some(Instant::now());
        }
        match partial.step(token) {
            Err(BakeError::Canceled(_)) => {
                keep(&partial)?;
                return Err(interrupted(&partial, file));
            }
            step => step?,
        }
    }
    bar.show(partial.examples());
    if partial.task.share.count > 1 {
        keep(&partial)?;
    }
    Ok(partial)
}

fn interrupted(partial: &PartialBake, file: &Path) -> CommandError {
    let (done, of) = (partial.task.done, partial.task.impacts().len());
    let file = file.display();
    CommandError::interrupted(format!("{}; continue with --resume", kept_impacts(done, of, &file.to_string())))
}

/// The part of the impacts that a checkpoint keeps.
fn kept_impacts(done: u64, of: usize, file: &str) -> String {
    let verb = if done == 1 { "is" } else { "are" };
    format!("{done} of {} {verb} kept in {file}", counted(of as u64, "impact"))
}

/// Removes the checkpoint of a complete bake.
pub fn forget(file: &Path) -> Result<(), CommandError> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(CommandError::output(file, &error)),
        _ => Ok(()),
    }
}

/// Report of a finished share.
pub fn resume_message(partial: &PartialBake, file: &Path, as_json: bool) -> String {
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
    format!(
        "{object}: share {share} with {} in {}; join all shares with `shatterd merge`\n",
        counted(impacts as u64, "impact"),
        file.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn a_variable_that_is_no_number_is_named_with_its_value() {
        assert_eq!(whole(SHARDS_VARIABLE, "8").ok(), Some(8));
        for text in ["x", "", "-1", "1.5", "99999999999999999999"] {
            let error = whole(SHARDS_VARIABLE, text).unwrap_err();
            let wanted =
                format!("SHATTER_SHARDS is `{text}`; it must be a whole number from 0 to 18446744073709551615");
            assert_eq!((error.kind(), error.message()), ("shard", wanted.as_str()));
        }
    }

    #[test]
    fn kept_impacts_are_counted_in_words() {
        assert_eq!(kept_impacts(1, 1, "a.share"), "1 of 1 impact is kept in a.share");
        assert_eq!(kept_impacts(0, 40, "a.share"), "0 of 40 impacts are kept in a.share");
    }

    fn check(variables: &[(&'static str, u64)], wanted: Result<Option<&str>, &str>) {
        let all: BTreeMap<_, _> = variables.iter().copied().collect();
        let found = scheduled(&|name| Ok(all.get(name).copied()));
        let found = found.map(|found| found.map(|(share, _)| share.to_string())).map_err(|refused| {
            assert!(refused.message().contains("SHATTER_SHARDS"), "{refused:?}");
            refused.document()["error"]["at"].as_str().unwrap().to_owned()
        });
        assert_eq!(found.as_ref().map(Option::as_deref).map_err(String::as_str), wanted, "{variables:?}");
    }

    /// Variables that Slurm sets for task `id` of an array.
    fn array(id: u64, count: u64, first: u64, last: u64) -> [(&'static str, u64); 4] {
        let [id, count] = [("SLURM_ARRAY_TASK_ID", id), ("SLURM_ARRAY_TASK_COUNT", count)];
        [id, count, ("SLURM_ARRAY_TASK_MIN", first), ("SLURM_ARRAY_TASK_MAX", last)]
    }

    #[test]
    fn a_task_of_a_job_array_knows_its_share() {
        check(&[], Ok(None));
        check(&[("SHATTER_SHARDS", 5)], Ok(None));
        check(&array(3, 8, 0, 7), Ok(Some("3/8")));
        check(&array(3, 4, 1, 4), Ok(Some("2/4")));
        check(&[("JOB_COMPLETION_INDEX", 2), ("SHATTER_SHARDS", 5)], Ok(Some("2/5")));
    }

    #[test]
    fn tasks_that_are_repeated_bake_the_share_that_they_had() {
        let of_8 = |array: [(&'static str, u64); 4]| [&array[..], &[("SHATTER_SHARDS", 8)]].concat();
        check(&of_8(array(3, 1, 3, 3)), Ok(Some("3/8")));
        check(&of_8(array(1, 2, 1, 3)), Ok(Some("1/8")));
        check(&[("SLURM_ARRAY_TASK_ID", 3), ("SHATTER_SHARDS", 8)], Ok(Some("3/8")));
        check(&of_8(array(8, 1, 8, 8)), Err("SLURM_ARRAY_TASK_ID"));
        check(&[("JOB_COMPLETION_INDEX", 5), ("SHATTER_SHARDS", 5)], Err("JOB_COMPLETION_INDEX"));
        check(&[("JOB_COMPLETION_INDEX", 0), ("SHATTER_SHARDS", 0)], Err("SHATTER_SHARDS"));
    }

    #[test]
    fn a_task_that_cannot_know_its_share_is_refused() {
        check(&array(1, 2, 1, 3), Err("SHATTER_SHARDS"));
        check(&array(5, 4, 1, 7), Err("SHATTER_SHARDS"));
        check(&[("SLURM_ARRAY_TASK_ID", 3)], Err("SHATTER_SHARDS"));
        check(&array(3, 8, 0, 7)[..2], Err("SHATTER_SHARDS"));
        check(&[("JOB_COMPLETION_INDEX", 2)], Err("SHATTER_SHARDS"));
    }
}
