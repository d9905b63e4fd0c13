//! What a strike results in.

use super::output::meshes::FractureMeshes;
use super::stages::cells::DegreeSource;
use super::stages::termination::{StopReason, Termination};

/// What every strike finds out, whether the object breaks or not.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdReport {
    /// The threshold in effect, J·m².
    pub gamma_j_m2: f64,
    /// E_1/γ of the body that is nearest to breaking, or broke most.
    pub e1_over_gamma: f64,
    /// Whether the strike ended before anything was solved for, since a bound of E_1 is below γ: [`Self::e1_over_gamma`] is that
    /// bound, and [`Self::impulse_factor`] one from below.
    pub is_bound: bool,
    /// Impulses times this factor just break the object; 0 where its weight alone does. With gravity it is searched for if
    /// nothing but the threshold is asked for; else it is the factor on all loads, the weight among them.
    pub impulse_factor: f64,
    /// Contact radius in effect, m: the largest, after raising it to what the elastic lattice resolves.
    pub radius_m: f64,
    /// Relative error of the elastic energy, estimated, if the displacements of all struck bodies are reduced ones: the
    /// largest. `None`: solved for.
    pub reduced_error: Option<f64>,
    /// Displacements of a body's basis that were used at most, if that was bounded.
    pub rank_max: Option<u32>,
    /// Estimated relative error up to which reduced displacements would stand, or did.
    pub reduced_error_max: f64,
}

/// What an object broke into, and how.
pub struct Fracture {
    /// What the strike found out before anything broke.
    pub threshold: ThresholdReport,
    /// Sites of the diagrams.
    pub sites: u32,
    /// Fracture degree of the criterion.
    pub fracture_degree: u32,
    /// Which rule produced it.
    pub degree_source: DegreeSource,
    /// Trust in the degree, 0 ..= 1: 1 for a number given, tested or optimised, less for an estimate.
    pub confidence: f64,
    /// Whether the cap cut the degree.
    pub capped: bool,
    /// Iterations of the diagrams: the most of all bodies.
    pub iterations: usize,
    /// How far the energy of the diagrams is above the end of their descents, relative, estimated: the largest; `None` without one.
    pub cvd_gap: Option<f64>,
    /// What ended the descents, if there were any.
    pub ending: Option<Termination>,
    /// The fragments.
    pub meshes: FractureMeshes,
}

/// The result of one strike. It knows its exact size before any mesh is written.
pub enum FractureOutcome {
    /// The object stays whole, or nothing but the threshold was asked for.
    Intact(ThresholdReport),
    /// The object breaks.
    Fractured(Box<Fracture>),
}

impl FractureOutcome {
    /// What the strike found out before anything broke.
    pub fn threshold(&self) -> &ThresholdReport {
        match self {
            Self::Intact(threshold) => threshold,
            Self::Fractured(fracture) => &fracture.threshold,
        }
    }

    /// What the object broke into; `None` if it stays whole.
    pub fn fracture(&self) -> Option<&Fracture> {
        match self {
            Self::Intact(_) => None,
            Self::Fractured(fracture) => Some(fracture),
        }
    }

    /// The fragments; `None` if the object stays whole.
    pub fn meshes(&self) -> Option<&FractureMeshes> {
        self.fracture().map(|fracture| &fracture.meshes)
    }

    /// The fragments; `None` if the object stays whole.
    pub fn into_meshes(self) -> Option<FractureMeshes> {
        match self {
            Self::Intact(_) => None,
            Self::Fractured(fracture) => Some(fracture.meshes),
        }
    }

    /// Sites of the diagrams; 0 if the object stays whole.
    pub fn sites(&self) -> u32 {
        self.fracture().map_or(0, |fracture| fracture.sites)
    }

    /// Fracture degree of the criterion; 1 if the object stays whole.
    pub fn fracture_degree(&self) -> u32 {
        self.fracture().map_or(1, |fracture| fracture.fracture_degree)
    }

    /// Which rule produced the degree; [`DegreeSource::Threshold`] if the object stays whole.
    pub fn degree_source(&self) -> DegreeSource {
        self.fracture().map_or(DegreeSource::Threshold, |fracture| fracture.degree_source)
    }

    /// Trust in the degree, 0 ..= 1; 1 if the object stays whole.
    pub fn confidence(&self) -> f64 {
        self.fracture().map_or(1.0, |fracture| fracture.confidence)
    }

    /// Whether the cap cut the degree.
    pub fn capped(&self) -> bool {
        self.fracture().is_some_and(|fracture| fracture.capped)
    }

    /// Iterations of the diagrams: the most of all bodies; 0 without diagrams.
    pub fn iterations(&self) -> usize {
        self.fracture().map_or(0, |fracture| fracture.iterations)
    }

    /// Gap of the diagrams, see [`Fracture::cvd_gap`].
    pub fn cvd_gap(&self) -> Option<f64> {
        self.fracture().and_then(|fracture| fracture.cvd_gap)
    }

    /// What stopped the strike.
    pub fn stop_reason(&self) -> StopReason {
        match self.fracture().and_then(|fracture| fracture.ending) {
            Some(Termination::Time) => StopReason::Time,
            _ if self.capped() => StopReason::Capped,
            Some(Termination::ErrorMet) => StopReason::ErrorMet,
            Some(Termination::Iterations) => StopReason::Iterations,
            Some(Termination::Converged) => StopReason::Converged,
            None => StopReason::Complete,
        }
    }
}
