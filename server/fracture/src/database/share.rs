//! Shares of an object's examples: baked apart, on one machine or on many, stopped and resumed, then joined.
//!
//! Examples are independent of each other, so whatever way they were divided, what is joined has the bytes of an undivided
//! bake.

use super::DatabaseError;
use super::bake::{finish, whole};
use super::bake_error::BakeError;
use super::bake_request::{BakeRequest, few_enough};
use super::bake_step::BakeStep;
use super::object::BASE;
use crate::cancel_token::CancelToken;
use crate::pipeline::{PreparedObject, TrainingExample, sampled};
use crate::surface::RawMesh;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Most shares of one bake.
pub const SHARES_MAX: u64 = 65_536;

/// Impacts done between two looks at the token and at the clock.
const BATCH: usize = 16;

/// The ending of files with a share.
pub const SHARE_EXTENSION: &str = "share";

/// The impacts whose number, counted from the first that is new, leaves `index` when divided by `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BakeShare {
    /// Which share, below `count`.
    pub index: u64,
    /// How many there are, 1 to [`SHARES_MAX`].
    pub count: u64,
}

impl BakeShare {
    /// All of them.
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

    /// Numbers of its impacts among those from `first` up to, without, `end`.
    pub fn impacts(self, first: u64, end: u64) -> Vec<u64> {
        (first.saturating_add(self.index)..end).step_by(self.count as usize).collect()
    }

    /// How many those are of `all`.
    pub fn size(self, all: u64) -> u64 {
        all.saturating_sub(self.index).div_ceil(self.count)
    }

    /// The file of this share of object `name` in `folder`.
    pub fn file(self, folder: &Path, name: &str) -> PathBuf {
        folder.join(format!("{name}.{}-of-{}.{SHARE_EXTENSION}", self.index, self.count))
    }
}

impl fmt::Display for BakeShare {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Why something is no share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShareError {
    /// Not two numbers.
    #[error("\"{0}\" is not i/n, as in 0/8")]
    Text(String),
    /// No share, or too many.
    #[error("{count} shares: 1 to {SHARES_MAX}")]
    Count {
        /// How many.
        count: u64,
    },
    /// There is no such share.
    #[error("{index} is too large for {count} shares: they are counted from 0, the last is {}/{count}", count - 1)]
    Index {
        /// Which.
        index: u64,
        /// How many there are.
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

/// What a share is a share of, and how far it is. Metadata key "share" of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShareTask {
    /// What was asked for, but for the cracks, which are in the hash of the input; nothing where examples are added to a
    /// database that was there.
    pub request: Option<BakeRequest>,
    /// Which share.
    pub share: BakeShare,
    /// Impacts that the object knew before.
    pub first: u64,
    /// Impacts that it shall know in the end.
    pub end: u64,
    /// Impacts of this share that are done, in its order.
    pub done: u64,
}

impl ShareTask {
    /// Impacts of this share.
    pub fn impacts(&self) -> Vec<u64> {
        self.share.impacts(self.first, self.end)
    }

    /// Whether all of them are done.
    pub fn is_done(&self) -> bool {
        self.done == self.impacts().len() as u64
    }

    /// Whether both are parts of the same work, however far they are.
    pub fn same_work(&self, other: &Self) -> bool {
        let whole = |task: &Self| Self { share: BakeShare::WHOLE, done: 0, ..task.clone() };
        whole(self) == whole(other) && self.share.count == other.share.count
    }
}

/// An object with some of its examples.
pub struct PartialBake {
    /// The object; its examples are those that it had before and those of the share that are done.
    pub prepared: PreparedObject,
    /// What remains to be done.
    pub task: ShareTask,
}

impl PartialBake {
    /// Bakes everything but the examples.
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

    /// `count` more examples for an object.
    ///
    /// # Errors
    /// [`BakeError::TooManyExamples`].
    pub fn add(prepared: PreparedObject, count: u64, share: BakeShare) -> Result<Self, BakeError> {
        let first = prepared.impacts;
        let end = first.saturating_add(count);
        few_enough(end)?;
        Ok(Self { prepared, task: ShareTask { request: None, share, first, end, done: 0 } })
    }

    /// Does the next few impacts. Whatever the outcome, the examples are those of the impacts that are done.
    ///
    /// # Errors
    /// [`BakeError::Calibration`], [`BakeError::Cancelled`].
    pub fn step(&mut self, token: &CancelToken) -> Result<(), BakeError> {
        let impacts: Vec<u64> = self.task.impacts().into_iter().skip(self.task.done as usize).take(BATCH).collect();
        let added = sampled(&self.prepared, &impacts, token)?;
        self.prepared.examples.extend(added);
        self.task.done += impacts.len() as u64;
        Ok(())
    }

    /// Does everything that remains, and learns from it. Only of the whole.
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

    /// Impacts of its share, done or not.
    pub fn impacts(&self) -> u64 {
        self.task.share.size(self.task.end - self.task.first)
    }

    /// How far it is.
    pub fn examples(&self) -> BakeStep {
        BakeStep::Examples { done: self.task.done, of: self.impacts() }
    }

    /// Learns from the examples that are there.
    ///
    /// # Errors
    /// [`BakeError::Calibration`], [`BakeError::Cancelled`].
    pub fn learn(self, token: &CancelToken, progress: &mut dyn FnMut(BakeStep)) -> Result<PreparedObject, BakeError> {
        let Self { mut prepared, task } = self;
        prepared.impacts = task.end;
        finish(&mut prepared, task.request.as_ref(), token, progress)?;
        Ok(prepared)
    }
}

/// What joining needs of a share beside the first: no lattice is built from it.
pub(super) struct ShareRemainder {
    pub task: ShareTask,
    pub input_hash: String,
    pub examples: Vec<TrainingExample>,
    pub checksums: BTreeMap<String, String>,
}

/// Why shares cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// A file is damaged, or no share.
    #[error("{}", source.of(path))]
    Database {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        source: DatabaseError,
    },
    /// No file was given.
    #[error("no share to join")]
    Nothing,
    /// Shares of different work.
    #[error(
        "{path}: another mesh, other flags or another number of shares than {first}",
        path = .path.display(),
        first = .first.display()
    )]
    OtherWork {
        /// Which file.
        path: PathBuf,
        /// What it is compared with.
        first: PathBuf,
    },
    /// The same work with other bits.
    #[error(
        "{path}: \"{tensor}\" has other bits than in {first}: bake all shares with one program on one kind of processor",
        path = .path.display(),
        first = .first.display()
    )]
    OtherBits {
        /// Which file.
        path: PathBuf,
        /// What it is compared with.
        first: PathBuf,
        /// The tensor.
        tensor: String,
    },
    /// A share is not finished.
    #[error("{path}: {done} of {of} impacts are done; finish it with --resume", path = .path.display())]
    Unfinished {
        /// Which file.
        path: PathBuf,
        /// Impacts that are done.
        done: u64,
        /// All of its impacts.
        of: u64,
    },
    /// A share is there twice.
    #[error("{path}: share {share} is there already", path = .path.display())]
    Twice {
        /// Which file.
        path: PathBuf,
        /// Which share.
        share: BakeShare,
    },
    /// A share is missing.
    #[error("share {share} is missing")]
    Missing {
        /// Which.
        share: BakeShare,
    },
    /// Learning failed.
    #[error(transparent)]
    Bake(#[from] BakeError),
}

/// Joins all shares of one bake, given in any order, and learns from them: the bytes are those of an undivided bake.
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

/// A tensor of the object itself that differs.
fn differing(one: &BTreeMap<String, String>, other: &BTreeMap<String, String>) -> Option<String> {
    let base = |sums: &BTreeMap<String, String>| -> BTreeMap<String, String> {
        sums.iter().filter(|(name, _)| name.starts_with(BASE)).map(|(k, v)| (k.clone(), v.clone())).collect()
    };
    let (one, other) = (base(one), base(other));
    let names = one.keys().chain(other.keys());
    names.filter(|name| one.get(*name) != other.get(*name)).min().cloned()
}
