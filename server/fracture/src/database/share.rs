//! Shares of an object's examples, baked separately on one or several machines, interrupted and resumed, then joined.
//!
//! Examples are independent of each other. The joined database therefore has the bytes of an undivided bake, for any
//! division.

use super::DatabaseError;
use super::bake::{finish, whole};
use super::bake_error::BakeError;
use super::bake_request::{BakeRequest, check_counts};
use super::bake_step::BakeStep;
use super::object::BASE;
use crate::cancel_token::CancelToken;
use crate::pipeline::{PreparedObject, TrainingExample, sampled};
use crate::scene::{brief, counted};
use crate::surface::RawMesh;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Largest number of shares of a bake.
pub const SHARES_MAX: u64 = 65_536;

/// Number of impacts between two checks of the token and of the caller's clock.
const BATCH: usize = 16;

/// Extension of files with a share.
pub const SHARE_EXTENSION: &str = "share";

/// The impacts whose number, counted from the first new one, has the remainder `index` modulo `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BakeShare {
    /// Index of the share, below `count`.
    pub index: u64,
    /// Number of shares, 1 to [`SHARES_MAX`].
    pub count: u64,
}

impl BakeShare {
    /// The only share of an undivided bake.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Share `index` of `count`.
    ///
    /// # Errors
    /// [`ShareError`].
    pub fn new(index: u64, count: u64) -> Result<Self, ShareError> {
        if !(1..=SHARES_MAX).contains(&count) {
            return Err(ShareError::Count { count });
        }
        if index >= count {
            return Err(ShareError::Index { index, count });
        }
        Ok(Self { index, count })
    }

    /// Numbers of the share's impacts in `first` .. `end`.
    pub fn impacts(self, first: u64, end: u64) -> Vec<u64> {
        (first.saturating_add(self.index)..end).step_by(self.count as usize).collect()
    }

    /// Number of the share's impacts among `all`.
    pub fn size(self, all: u64) -> u64 {
        all.saturating_sub(self.index).div_ceil(self.count)
    }

    /// Path of the file of this share of object `name` in `folder`.
    pub fn file(self, folder: &Path, name: &str) -> PathBuf {
        folder.join(format!("{name}.{}-of-{}.{SHARE_EXTENSION}", self.index, self.count))
    }
}

impl fmt::Display for BakeShare {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Errors in the description of a share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShareError {
    /// The text is not two numbers.
    #[error("\"{}\" is not i/n, as in 0/8", brief(.0))]
    Text(String),
    /// The number of shares is 0 or too large.
    #[error("{count} shares are out of range; use 1 to {SHARES_MAX}")]
    Count {
        /// Number of shares.
        count: u64,
    },
    /// The index is not below the number of shares.
    #[error("{index} is too large for {}: they are counted from 0, the last is {}/{count}", counted(*count, "share"), count - 1)]
    Index {
        /// Index of the share.
        index: u64,
        /// Number of shares.
        count: u64,
    },
}

impl FromStr for BakeShare {
    type Err = ShareError;

    fn from_str(text: &str) -> Result<Self, ShareError> {
        let wrong = || ShareError::Text(text.to_owned());
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let number = |part: &str| part.parse().map_err(|_| wrong());
        Self::new(number(index)?, number(count)?)
    }
}

/// Task of a share, with its progress. Metadata key "share" of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShareTask {
    /// Request without the cracks, which the hash of the input covers; `None` if examples are added to an existing
    /// database.
    pub request: Option<BakeRequest>,
    /// The share.
    pub share: BakeShare,
    /// Number of impacts before the task.
    pub first: u64,
    /// Number of impacts after the task.
    pub end: u64,
    /// Number of completed impacts of this share, in its order.
    pub done: u64,
}

impl ShareTask {
    /// Numbers of the impacts of this share.
    pub fn impacts(&self) -> Vec<u64> {
        self.share.impacts(self.first, self.end)
    }

    /// True if all impacts are completed.
    pub fn is_done(&self) -> bool {
        self.done == self.impacts().len() as u64
    }

    /// True if both are shares of the same task, at any progress.
    pub fn same_work(&self, other: &Self) -> bool {
        let whole = |task: &Self| Self { share: BakeShare::WHOLE, done: 0, ..task.clone() };
        whole(self) == whole(other) && self.share.count == other.share.count
    }
}

/// An object with some of its examples.
pub struct PartialBake {
    /// The object, with its earlier examples and the completed ones of the share.
    pub prepared: PreparedObject,
    /// The task, with its progress.
    pub task: ShareTask,
}

impl PartialBake {
    /// Bakes everything except the examples.
    ///
    /// # Errors
    /// See [`BakeError`].
    pub fn begin(
        raw: RawMesh,
        request: &BakeRequest,
        share: BakeShare,
        token: &CancelToken,
        progress: &mut dyn FnMut(BakeStep),
    ) -> Result<Self, BakeError> {
        let prepared = whole(raw, request, token, progress)?;
        let task =
            ShareTask { request: Some(request.without_cracks()), share, first: 0, end: request.examples, done: 0 };
        Ok(Self { prepared, task })
    }

    /// Prepares the task of adding `count` examples to an object.
    ///
    /// # Errors
    /// [`BakeError::TooManyExamples`].
    pub fn add(prepared: PreparedObject, count: u64, share: BakeShare) -> Result<Self, BakeError> {
        let first = prepared.impacts;
        let end = first.saturating_add(count);
        check_counts(end)?;
        Ok(Self { prepared, task: ShareTask { request: None, share, first, end, done: 0 } })
    }

    /// Computes the examples of the next few impacts. In every outcome, the examples match the progress.
    ///
    /// # Errors
    /// [`BakeError::Calibration`], [`BakeError::Canceled`].
    pub fn step(&mut self, token: &CancelToken) -> Result<(), BakeError> {
        let impacts: Vec<u64> = self.task.impacts().into_iter().skip(self.task.done as usize).take(BATCH).collect();
        let added = sampled(&self.prepared, &impacts, token)?;
        self.prepared.examples.extend(added);
        self.task.done += impacts.len() as u64;
        Ok(())
    }

    /// Computes all remaining examples and trains on them. Only for an undivided bake.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn complete(
        mut self,
        token: &CancelToken,
        progress: &mut dyn FnMut(BakeStep),
    ) -> Result<PreparedObject, BakeError> {
        while !self.task.is_done() {
            progress(self.examples());
            self.step(token)?;
        }
        progress(self.examples());
        self.learn(token, progress)
    }

    /// Number of impacts of the share, completed or not.
    pub fn impacts(&self) -> u64 {
        self.task.share.size(self.task.end - self.task.first)
    }

    /// Progress of the examples.
    pub fn examples(&self) -> BakeStep {
        BakeStep::Examples { done: self.task.done, of: self.impacts() }
    }

    /// Trains on the existing examples.
    ///
    /// # Errors
    /// [`BakeError::Calibration`], [`BakeError::Canceled`].
    pub fn learn(self, token: &CancelToken, progress: &mut dyn FnMut(BakeStep)) -> Result<PreparedObject, BakeError> {
        let Self { mut prepared, task } = self;
        prepared.impacts = task.end;
        finish(&mut prepared, task.request.as_ref(), token, progress)?;
        Ok(prepared)
    }
}

/// Data of a share that joining needs beside the first share, without lattices.
pub(super) struct ShareRemainder {
    pub task: ShareTask,
    pub input_hash: String,
    pub examples: Vec<TrainingExample>,
    pub checksums: BTreeMap<String, String>,
}

/// Reason why shares cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// A file is damaged, or not a share.
    #[error("{}", source.of(path))]
    Database {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: DatabaseError,
    },
    /// No file was given.
    #[error("no share to join")]
    Nothing,
    /// The shares belong to different tasks.
    #[error(
        "{path}: the mesh, flags or number of shares differ from those of {first}",
        path = .path.display(),
        first = .first.display()
    )]
    OtherWork {
        /// Path of the file.
        path: PathBuf,
        /// Path of the file to which it was compared.
        first: PathBuf,
    },
    /// The shares have the same task but different bits.
    #[error(
        "{path}: \"{tensor}\" has other bits than in {first}: bake all shares with one program on one kind of processor",
        path = .path.display(),
        first = .first.display()
    )]
    OtherBits {
        /// Path of the file.
        path: PathBuf,
        /// Path of the file to which it was compared.
        first: PathBuf,
        /// Name of the tensor.
        tensor: String,
    },
    /// A share is not complete.
    #[error("{path}: {done} of {} done; finish it with --resume", counted(*of, "impact"), path = .path.display())]
    Unfinished {
        /// Path of the file.
        path: PathBuf,
        /// Number of completed impacts.
        done: u64,
        /// Number of its impacts.
        of: u64,
    },
    /// A share was given twice.
    #[error("{path}: share {share} was given already", path = .path.display())]
    Twice {
        /// Path of the file.
        path: PathBuf,
        /// The share.
        share: BakeShare,
    },
    /// A share is missing.
    #[error("share {share} (counted from 0) is missing; bake it with --shard {share}")]
    Missing {
        /// The share.
        share: BakeShare,
    },
    /// Training failed.
    #[error(transparent)]
    Bake(#[from] BakeError),
}

/// Joins all shares of one bake, given in any order, and trains on them. The bytes are those of an undivided bake.
///
/// # Errors
/// See [`JoinError`].
pub fn join(
    paths: &[PathBuf],
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<PreparedObject, JoinError> {
    let (first, others) = paths.split_first().ok_or(JoinError::Nothing)?;
    let damaged = |path: &Path| {
        let path = path.to_owned();
        move |source| JoinError::Database { path, source }
    };
    let own = super::object::load_rest(first).map_err(damaged(first))?;
    check_done(first, &own.task)?;
    let mut shares = BTreeMap::from([(own.task.share.index, new_examples(&own.task, own.examples))]);
    for path in others {
        let rest = super::object::load_rest(path).map_err(damaged(path))?;
        let (path, first) = (path.clone(), first.clone());
        if !rest.task.same_work(&own.task) || rest.input_hash != own.input_hash {
            return Err(JoinError::OtherWork { path, first });
        }
        if let Some(tensor) = differing(&own.checksums, &rest.checksums) {
            return Err(JoinError::OtherBits { path, first, tensor });
        }
        check_done(&path, &rest.task)?;
        let share = rest.task.share;
        if shares.insert(share.index, new_examples(&rest.task, rest.examples)).is_some() {
            return Err(JoinError::Twice { path, share });
        }
    }
    let count = own.task.share.count;
    if let Some(index) = (0..count).find(|index| !shares.contains_key(index)) {
        return Err(JoinError::Missing { share: BakeShare { index, count } });
    }
    let mut partial = super::object::load_partial(first).map_err(damaged(first))?;
    let known = |example: &TrainingExample| example.impact < partial.task.first;
    partial.prepared.examples.retain(known);
    let mut new: Vec<TrainingExample> = shares.into_values().flatten().collect();
    new.sort_by_key(|example| (example.impact, example.body));
    partial.prepared.examples.extend(new);
    Ok(partial.learn(token, progress)?)
}

fn new_examples(task: &ShareTask, examples: Vec<TrainingExample>) -> Vec<TrainingExample> {
    examples.into_iter().filter(|example| example.impact >= task.first).collect()
}

fn check_done(path: &Path, task: &ShareTask) -> Result<(), JoinError> {
    let of = task.impacts().len() as u64;
    if task.is_done() { Ok(()) } else { Err(JoinError::Unfinished { path: path.to_owned(), done: task.done, of }) }
}

/// The name of a tensor of the object itself that differs.
fn differing(one: &BTreeMap<String, String>, other: &BTreeMap<String, String>) -> Option<String> {
    let base = |sums: &BTreeMap<String, String>| -> BTreeMap<String, String> {
        sums.iter().filter(|(name, _)| name.starts_with(BASE)).map(|(k, v)| (k.clone(), v.clone())).collect()
    };
    let (one, other) = (base(one), base(other));
    let names = one.keys().chain(other.keys());
    names.filter(|name| one.get(*name) != other.get(*name)).min().cloned()
}
