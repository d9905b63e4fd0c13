//! What the daemon strikes, as the daemon sees it: [`crate::wire`] makes it of the science, tests make it of little.

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{RetainedFragments, StageObserver, Workspace};
use shatter_proto::control::ObjectRow;
use shatter_proto::layout::{SectionCounts, SectionsMut};
use shatter_proto::request::Request;
use shatter_proto::result::{OverrunCause, StageCost};
use shatter_proto::{Error, ErrorKind};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// An object that can be struck from several threads at once.
pub trait ServedObject: Send + Sync {
    /// What `list` says about it.
    fn row(&self) -> ObjectRow;

    /// Bytes of memory that it holds.
    fn bytes(&self) -> usize;

    /// Bytes of its largest answer: bounds the buckets.
    fn answer_bytes_max(&self) -> usize;

    /// Does what loading left for later, so that no strike has to. The error is what such strikes will be told.
    ///
    /// # Errors
    /// What requests that need it will be told: `failed`, `unsolvable`.
    fn finish(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Strikes it. `token` is polled, `observer` sees every stage and effect.
    ///
    /// # Errors
    /// What is wrong with the request or the object, with the kind of the rule; `cancelled` if `token` says so.
    fn strike(
        &self,
        strike: &Request,
        workspace: &mut Workspace,
        token: &CancelToken,
        observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error>;

    /// Strikes fragment `fragment` of one of its answers, of which `kept` was kept.
    ///
    /// # Errors
    /// Those of [`Self::strike`], and `unknown_fragment`, `fragment_size`.
    fn strike_again(
        &self,
        (_kept, fragment): (&RetainedFragments, u32),
        _strike: &Request,
        _workspace: &mut Workspace,
        _token: &CancelToken,
        _observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error> {
        let message = "the fragments of this object cannot be struck";
        Err(Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message))
    }
}

/// What a strike led to: it knows its size before a byte of it is written.
pub trait EngineResult {
    /// Elements per section.
    fn counts(&self) -> SectionCounts;

    /// What it takes to strike its fragments again; `None`: it has none.
    fn keep(&self) -> Option<RetainedFragments> {
        None
    }

    /// Why displacements were solved for; `None`: they were not.
    fn solved(&self) -> Option<OverrunCause> {
        None
    }

    /// Learns what the strike cost: the time from when its computation began until its result was written, and the stages of it.
    fn took(&self, _time: Duration, _stages: &[StageCost]) {}

    /// Writes everything but the stages and effects straight into the lent answer; `observer` sees every effect.
    ///
    /// # Errors
    /// `failed` if the sections do not fit the result.
    fn write(&self, sections: &mut SectionsMut<'_>, observer: &dyn StageObserver) -> Result<(), Error>;
}

/// Loads the database at a path, as the object of the scene that has this name if there is a scene; the error says what is wrong
/// with it.
pub type Loader = Arc<dyn Fn(&Path, Option<&str>) -> Result<Arc<dyn ServedObject>, String> + Send + Sync>;
