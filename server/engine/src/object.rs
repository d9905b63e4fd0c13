//! Interface of served objects, implemented by the engine adapter [`crate::wire`] and by test doubles.

use crate::stage_profiler::StageProfiler;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{RetainedFragments, Stage, StageObserver, Workspace};
use shatter_proto::control::ObjectRow;
use shatter_proto::layout::{SectionCounts, SectionsMut};
use shatter_proto::request::Request;
use shatter_proto::result::{EnergySource, OverrunCause, StageCost};
use shatter_proto::{Error, ErrorKind};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// An object that several threads can strike at once.
pub trait ServedObject: Send + Sync {
    /// Row for `list`.
    fn row(&self) -> ObjectRow;

    /// Memory of the object, bytes.
    fn bytes(&self) -> usize;

    /// Size of its largest result, bytes; bounds the buckets.
    fn result_bytes_max(&self) -> usize;

    /// Does the work that loading deferred, so that no request has to. Requests that need this work receive the error.
    ///
    /// # Errors
    /// What requests that need it will be told: `failed`, `unsolvable`.
    fn finish(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Strikes the object. Polls `token` and reports every stage and effect to `observer`.
    ///
    /// # Errors
    /// What is wrong with the request or the object, with the kind of the rule; `canceled` if `token` says so.
    fn strike(
        &self,
        strike: &Request,
        workspace: &mut Workspace,
        token: &CancelToken,
        observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error>;

    /// Strikes fragment `fragment` of a result of this object; `kept` is the retained part of that result.
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
        let message = "the fragments of this object cannot be struck; strike the object itself";
        Err(Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message))
    }
}

/// Energies of a result, for logs and metrics. Numbers are zero if they are unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResultEnergies {
    /// Source of the strain energy.
    pub source: EnergySource,
    /// Energy of the bodies that struck, J.
    pub impactor_j: f64,
    /// Strain energy of the struck bodies, J.
    pub strain_j: f64,
    /// Energy of the new cracks, with the criterion by strength, J.
    pub surface_j: f64,
    /// Kinetic energy of the release velocities, with the criterion by strength, J.
    pub released_j: f64,
    /// Energy by which surface and release exceed the strain energy, J.
    pub deficit_j: f64,
    /// Peak stress over the strength, with the criterion by strength.
    pub stress_over_strength: f64,
}

impl ResultEnergies {
    /// Energies of which only the source is known.
    pub fn unknown(source: EnergySource) -> Self {
        let [impactor_j, strain_j, surface_j, released_j, deficit_j, stress_over_strength] = [0.0; 6];
        Self { source, impactor_j, strain_j, surface_j, released_j, deficit_j, stress_over_strength }
    }
}

/// Result of a request, which knows its size before a byte is written.
pub trait EngineResult {
    /// Number of elements per section.
    fn counts(&self) -> SectionCounts;

    /// Data for striking its fragments later; `None`: it has no fragments.
    fn keep(&self) -> Option<RetainedFragments> {
        None
    }

    /// Reason for which displacements were solved for; `None`: no solve was needed.
    fn solved(&self) -> Option<OverrunCause> {
        None
    }

    /// Its energies; `None` if it only aimed. Numbers are zero if it told a threshold, since no impact has them.
    fn energies(&self) -> Option<ResultEnergies> {
        None
    }

    /// Records the time from the start of the computation until the result was written, and its stages.
    fn took(&self, _time: Duration, _stages: &[StageCost]) {}

    /// Writes all sections but the stages and effects into the loaned buffer; reports every effect to `observer`.
    ///
    /// # Errors
    /// `failed` if the sections do not fit the result.
    fn write(&self, sections: &mut SectionsMut<'_>, observer: &dyn StageObserver) -> Result<(), Error>;
}

/// Writes `result` into its sections as part of the last stage, whose output has `bytes` bytes, and then the costs that `profiler`
/// measured.
///
/// # Errors
/// Those of [`EngineResult::write`].
pub fn write_profiled(
    result: &dyn EngineResult,
    sections: &mut SectionsMut<'_>,
    bytes: u64,
    profiler: &StageProfiler,
) -> Result<(), Error> {
    let observer: &dyn StageObserver = profiler;
    // An object that stays whole has no fragments, so the stage does not run.
    let stage = (!sections.fragments.is_empty()).then(|| observer.stage(Stage::Fragments));
    result.write(sections, observer)?;
    if let Some(stage) = stage {
        stage.produced_bytes(bytes);
    }
    profiler.write_costs(sections);
    Ok(())
}

/// Loads the database at a path; with a scene, as the scene object of the given name. The error describes the defect of the database.
pub type Loader = Arc<dyn Fn(&Path, Option<&str>) -> Result<Arc<dyn ServedObject>, String> + Send + Sync>;
