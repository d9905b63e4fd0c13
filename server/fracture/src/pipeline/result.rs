//! Result of a request.

use super::output::ledger::EnergyLedger;
use super::output::meshes::FractureMeshes;
use super::stages::cells::DegreeSource;
use super::stages::onset::OnsetReport;
use super::stages::termination::{StopReason, Termination};

/// Result of the threshold test, which every request runs.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdReport {
    /// Effective threshold γ, J·m².
    pub gamma_j_m2: f64,
    /// Largest E_1/γ of the struck bodies.
    pub e1_over_gamma: f64,
    /// True if the request ended before any displacement was computed, because an upper bound of E_1 is below γ.
    ///
    /// [`Self::e1_over_gamma`] is then that bound, and [`Self::impulse_factor`] a lower bound.
    pub is_bound: bool,
    /// Factor on the impulses at which the object just breaks; 0 if its weight alone breaks it. Partners do not change it.
    ///
    /// With gravity, a request with `threshold_only` searches for this factor. Other requests with gravity report the
    /// factor on all loads, weight included.
    pub impulse_factor: f64,
    /// Strain energy of the struck bodies at peak load, J: of all contacts of the request, and of the weight with gravity.
    ///
    /// At most the energy of the impactor, if that is known. With the effect `dynamics`, its largest over time. `None` without
    /// a displacement: the request ended at the bound, or the energies are those of a falloff.
    pub strain_j: Option<f64>,
    /// Energy of the bodies that strike the object; `None`: unknown.
    pub impactor: Option<ImpactorReport>,
    /// Figures of the criterion by strength and energy; `None`: the paper's criterion decided.
    pub onset: Option<OnsetReport>,
    /// Largest effective contact radius, m: that whose energy was computed.
    pub radius_m: f64,
    /// Largest estimated relative error of the elastic energy, if the displacements of all struck bodies are reduced
    /// ones.
    ///
    /// `None` if a body was solved for.
    pub reduced_error: Option<f64>,
    /// Largest estimated relative error of the elastic energy that stems from the lattice; `None`: unknown, or
    /// without the effect `elastic`.
    pub discretization_error: Option<f64>,
    /// Limit on the basis displacements used per body; `None`: no limit.
    pub rank_max: Option<u32>,
    /// Estimated relative error up to which reduced displacements are accepted.
    pub reduced_error_max: f64,
}

/// Energy of the bodies that strike an object, and how it limits the load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactorReport {
    /// Kinetic energy that the contacts can take from the motion of object and partners, J.
    pub energy_j: f64,
    /// Factor on all loads, 0 ..= 1: 1 if the strain energy of the requested impulses, with the indentations of the contacts
    /// by Hertz, does not exceed that energy.
    ///
    /// `None` without a displacement: the request ended at a bound, which holds for every factor.
    pub load_factor: Option<f64>,
}

impl ThresholdReport {
    /// Energy of the impact that the object does not store, J; `None` if either is unknown.
    pub fn remainder_j(&self) -> Option<f64> {
        Some((self.impactor?.energy_j - self.strain_j?).max(0.0))
    }
}

/// Fragments of an object and figures of the computation.
pub struct Fracture {
    /// Result of the threshold test.
    pub threshold: ThresholdReport,
    /// Total number of sites of the diagrams.
    pub sites: u32,
    /// Fracture degree that the criterion chose.
    pub fracture_degree: u32,
    /// Rule that chose the degree.
    pub degree_source: DegreeSource,
    /// Confidence in the degree, 0 ..= 1: 1 for a given, tested or optimized number, less for an estimate.
    pub confidence: f64,
    /// True if the maximum limited the degree.
    pub capped: bool,
    /// Iterations of the diagrams, the largest of all bodies.
    pub iterations: usize,
    /// Estimated relative gap between the energy of a diagram and the end of its descent, the largest; `None` without
    /// an estimate.
    pub cvd_gap: Option<f64>,
    /// Reason why the descents ended; `None` without a descent.
    pub ending: Option<Termination>,
    /// Uses of the strain energy, with the criterion by strength and energy.
    pub ledger: Option<EnergyLedger>,
    /// The fragments.
    pub meshes: FractureMeshes,
}

/// Result of one request, which knows its exact size before any mesh is written.
pub enum FractureOutcome {
    /// The object stays intact, or the request was for the threshold only.
    Intact(ThresholdReport),
    /// The object breaks.
    Fractured(Box<Fracture>),
}

impl FractureOutcome {
    /// Result of the threshold test.
    pub fn threshold(&self) -> &ThresholdReport {
        match self {
            Self::Intact(threshold) => threshold,
            Self::Fractured(fracture) => &fracture.threshold,
        }
    }

    /// Fragments and figures; `None` if the object stays intact.
    pub fn fracture(&self) -> Option<&Fracture> {
        match self {
            Self::Intact(_) => None,
            Self::Fractured(fracture) => Some(fracture),
        }
    }

    /// The fragments; `None` if the object stays intact.
    pub fn meshes(&self) -> Option<&FractureMeshes> {
        self.fracture().map(|fracture| &fracture.meshes)
    }

    /// Extracts the fragments; `None` if the object stays intact.
    pub fn into_meshes(self) -> Option<FractureMeshes> {
        match self {
            Self::Intact(_) => None,
            Self::Fractured(fracture) => Some(fracture.meshes),
        }
    }

    /// Total number of sites; 0 if the object stays intact.
    pub fn sites(&self) -> u32 {
        self.fracture().map_or(0, |fracture| fracture.sites)
    }

    /// Fracture degree that the criterion chose; 1 if the object stays intact.
    pub fn fracture_degree(&self) -> u32 {
        self.fracture().map_or(1, |fracture| fracture.fracture_degree)
    }

    /// Rule that chose the degree; [`DegreeSource::Threshold`] if the object stays intact.
    pub fn degree_source(&self) -> DegreeSource {
        self.fracture().map_or(DegreeSource::Threshold, |fracture| fracture.degree_source)
    }

    /// Confidence in the degree, 0 ..= 1; 1 if the object stays intact.
    pub fn confidence(&self) -> f64 {
        self.fracture().map_or(1.0, |fracture| fracture.confidence)
    }

    /// True if the maximum limited the degree.
    pub fn capped(&self) -> bool {
        self.fracture().is_some_and(|fracture| fracture.capped)
    }

    /// Iterations of the diagrams, the largest of all bodies; 0 without diagrams.
    pub fn iterations(&self) -> usize {
        self.fracture().map_or(0, |fracture| fracture.iterations)
    }

    /// Gap of the diagrams; see [`Fracture::cvd_gap`].
    pub fn cvd_gap(&self) -> Option<f64> {
        self.fracture().and_then(|fracture| fracture.cvd_gap)
    }

    /// Reason why the computation stopped.
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
