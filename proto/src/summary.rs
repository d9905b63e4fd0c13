//! The facts of a result: as they travel, and as a host reads them.

use crate::codes::{
    DegreeMethod, DegreeOrigin, EnergySource, FractureCriterion, FragmentSurface, OverrunCause, StopCriterion,
};
use crate::convention::Convention;
use crate::in_meters::InMeters;
use crate::name::OBJECT_NAME_MAX;
use crate::output_rows::HitWire;
use crate::request::Quality;
use crate::text;
use bytemuck::{Pod, Zeroable};
use std::time::Duration;

/// The facts of a result as they travel.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SummaryWire {
    /// UTF-8.
    pub object: [u8; OBJECT_NAME_MAX],
    /// Bytes of `object` that count.
    pub object_length: u32,
    /// Number of a [`DegreeOrigin`].
    pub degree_source: u32,
    /// Sites asked of the diagram.
    pub sites: u32,
    /// n of the criterion; 1: the object stays whole.
    pub fracture_degree: u32,
    /// 1 if the object's cap on the degree was reached.
    pub capped: u32,
    /// Number of a [`StopCriterion`].
    pub stop_reason: u32,
    /// Number of an [`EnergySource`].
    pub elastic: u32,
    /// The preset, by its number in a request.
    pub quality: u32,
    /// γ used, J·m².
    pub gamma_j_m2: f64,
    /// See [`Summary::e1_over_gamma`].
    pub e1_over_gamma: f64,
    /// See [`Summary::threshold_impulse_factor`].
    pub threshold_impulse_factor: f64,
    /// 0 to 1.
    pub confidence: f64,
    /// Seed used.
    pub seed: u64,
    /// Names this result to later requests; zero: not kept.
    pub handle: u64,
    /// Largest contact radius in effect, m.
    pub radius_m: f64,
    /// See [`Summary::energy_error`].
    pub energy_error: f64,
    /// See [`Summary::cvd_gap`].
    pub cvd_gap: f64,
    /// Tolerance of the diagrams.
    pub tolerance: f64,
    /// From admission until right before the result was sent, ns.
    pub time_ns: u64,
    /// Iterations of a diagram that were allowed.
    pub iterations_max: u32,
    /// Iterations taken: the most of all bodies.
    pub iterations: u32,
    /// Displacements of a basis that were used: the most of all bodies; zero without any.
    pub rank: u32,
    /// Coordinates of the lift beside those in space: the most of all bodies.
    pub lift_modes: u32,
    /// Nodes of the object's elastic lattices.
    pub elastic_nodes: u32,
    /// Nodes of the object's crack lattices.
    pub crack_nodes: u32,
    /// Number of a [`DegreeMethod`].
    pub degree: u32,
    /// Number of an [`OverrunCause`]; zero: the time that was asked for was kept.
    pub overrun: u32,
    /// See [`Summary::reduced_error_max`].
    pub reduced_error_max: f64,
    /// Intersection of the request's ray with the object, if it had one.
    pub hit: HitWire,
    /// By how much `time_ns` exceeds the time that was asked for, ns; zero: it was kept, or none was asked for.
    pub overrun_ns: u64,
    /// Number of a [`FragmentSurface`].
    pub surface: u32,
    /// See [`Summary::elements_across`]; zero: unknown.
    pub elements_across: f32,
    /// See [`Summary::discretization_error`]; zero: unknown.
    pub discretization_error: f64,
    /// See [`Summary::strain_j`]; zero: none.
    pub strain_j: f64,
    /// Number of a [`FractureCriterion`]; the fields below are zero with the paper's.
    pub criterion: u32,
    /// 1 if `averaged_over_m` is the length of a cell of the elastic lattice.
    pub averaged_over_cell: u32,
    /// See [`Summary::stress_over_strength`].
    pub stress_over_strength: f64,
    /// See [`Summary::averaged_over_m`].
    pub averaged_over_m: f64,
    /// See [`Summary::surface_j`].
    pub surface_j: f64,
    /// See [`Summary::released_j`].
    pub released_j: f64,
    /// See [`Summary::deficit_j`].
    pub deficit_j: f64,
    /// 1 if `impactor_j` is known.
    pub has_impactor: u32,
    /// 1 if `load_factor` is known.
    pub has_load_factor: u32,
    /// See [`Summary::impactor_j`].
    pub impactor_j: f64,
    /// See [`Summary::load_factor`].
    pub load_factor: f64,
}

impl InMeters for SummaryWire {
    fn in_meters(&self, from: &Convention) -> Self {
        let [radius_m, averaged_over_m] = [self.radius_m, self.averaged_over_m].map(|length| from.meters(length));
        Self { radius_m, averaged_over_m, ..*self }
    }
}

impl SummaryWire {
    /// The object's name, for showing.
    pub fn object(&self) -> String {
        text::show(&self.object, self.object_length)
    }

    /// Sets the object's name.
    pub fn set_object(&mut self, name: &str) {
        self.object_length = text::put(&mut self.object, name);
    }
}

/// The facts of a result.
///
/// Lengths are in the unit of the connection's convention, meters by default.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Summary {
    /// Name of the object.
    pub object: String,
    /// Sites asked of the diagram.
    pub sites: u32,
    /// n of the criterion; 1: the object stays whole.
    pub fracture_degree: u32,
    /// Which rule produced the degree.
    pub degree_origin: DegreeOrigin,
    /// Requested source of the number of sites: the request's rule, or the preset's.
    pub degree_method: DegreeMethod,
    /// Whether the object's cap on the degree was reached.
    pub is_capped: bool,
    /// Similarity of the examples that decided the degree, 0 to 1.
    pub confidence: f64,
    /// Criterion that stopped the computation.
    pub stop_criterion: StopCriterion,
    /// Source of the strain energy.
    pub energy_source: EnergySource,
    /// The preset; `None` for a request that only aims.
    pub quality: Option<Quality>,
    /// γ used, J·m².
    pub gamma_j_m2: f64,
    /// E_1/γ; at most this where `energy_source` is a bound.
    pub e1_over_gamma: f64,
    /// Factor on the impulses at which the object just breaks, √(γ/E_1); more where `energy_source` is a bound; 0 where its weight
    /// alone breaks it. With the effect `gravity` it is searched for where only the threshold is asked for; otherwise it is the factor
    /// on all loads, weight among them.
    pub threshold_impulse_factor: f64,
    /// Seed used.
    pub seed: u64,
    /// Names this result to later requests; `None`: the service does not keep it.
    pub handle: Option<u64>,
    /// Largest contact radius in effect, m: that whose energy was computed.
    pub radius_m: f64,
    /// Estimated relative error of the elastic energy; zero after a solve, and without an energy.
    pub energy_error: f64,
    /// Estimated relative error up to which reduced displacements are accepted; beyond it the service solves.
    pub reduced_error_max: f64,
    /// Estimated relative energy of the diagrams above the end of their descents: the largest; zero without one.
    pub cvd_gap: f64,
    /// Tolerance of the diagrams.
    pub tolerance: f64,
    /// Iterations of a diagram that were allowed.
    pub iterations_max: u32,
    /// Iterations taken: the most of all bodies.
    pub iterations: u32,
    /// Displacements of a basis that were used: the most of all bodies; zero without any.
    pub rank: u32,
    /// Coordinates of the lift beside those in space: the most of all bodies.
    pub lift_modes: u32,
    /// Nodes of the object's elastic lattices.
    pub elastic_nodes: u32,
    /// Nodes of the object's crack lattices.
    pub crack_nodes: u32,
    /// Cells of the elastic lattice across the object's walls: the fewest of all bodies, 8 or less. `None`: an object that an
    /// older version baked.
    pub elements_across: Option<f32>,
    /// Relative error of the elastic energy that stems from the elastic lattice, as the bake estimated it: the median of
    /// sampled impacts; for a fragment, plus half of the share of its volume in cut cells. `None`: not estimated, or
    /// without the effect `elastic`.
    pub discretization_error: Option<f64>,
    /// Strain energy of the struck bodies at peak load, J: of all contacts of the request, and of the weight with the effect
    /// `gravity`; with the effect `dynamics`, its largest over time. `None` where `energy_source` is a bound or a falloff.
    pub strain_j: Option<f64>,
    /// Rule that decided whether the object breaks.
    pub criterion: FractureCriterion,
    /// Largest averaged equivalent stress over the tensile strength; `None` with the paper's criterion.
    pub stress_over_strength: Option<f64>,
    /// Length over which stresses are averaged, m; `None` with the paper's criterion.
    pub averaged_over_m: Option<f64>,
    /// Whether that is the length of a cell of the elastic lattice, and not the material's own, which is shorter.
    pub is_averaged_over_cell: bool,
    /// Energy of the new surface, J: toughness times the area of all cracks. `None` without fragments, and with the paper's
    /// criterion.
    pub surface_j: Option<f64>,
    /// Kinetic energy of the release velocities, J; `None` without the effect `release`, and with the paper's criterion.
    pub released_j: Option<f64>,
    /// Energy that a given number of sites lacks, J: surface and release beyond the strain energy. `None` if nothing lacks.
    pub deficit_j: Option<f64>,
    /// Kinetic energy that the contacts can take from the motion of object and partners, J; `None` without partners.
    pub impactor_j: Option<f64>,
    /// Energy of these that the object does not store, J; `None` without partners, and where `strain_j` is `None`.
    pub remainder_j: Option<f64>,
    /// Factor on all loads, 0 to 1, so that the object stores no more than `impactor_j`: 1 if nothing was lowered. `None` without
    /// partners, and where `energy_source` is a bound.
    pub load_factor: Option<f64>,
    /// Outer surface of the fragments.
    pub surface: FragmentSurface,
    /// From admission until right before the result was sent; differs between equal requests.
    pub time: Duration,
    /// By how much and why the time that was asked for was exceeded; `None`: it was kept, or none was asked for.
    pub missed_time: Option<MissedTime>,
}

impl From<&SummaryWire> for Summary {
    fn from(row: &SummaryWire) -> Self {
        let missed =
            MissedTime { by: Duration::from_nanos(row.overrun_ns), cause: OverrunCause::from_code(row.overrun) };
        let positive = |value: f64| (value > 0.0).then_some(value);
        let impactor_j = (row.has_impactor != 0).then_some(row.impactor_j);
        let load_factor = (row.has_load_factor != 0).then_some(row.load_factor);
        // A load that was lowered to nothing has an energy: none.
        let strain_j = positive(row.strain_j).or(load_factor.map(|_| 0.0));
        let is_by_strength = row.criterion == FractureCriterion::Strength.code();
        Self {
            object: row.object(),
            sites: row.sites,
            fracture_degree: row.fracture_degree,
            degree_origin: DegreeOrigin::from_code(row.degree_source),
            degree_method: DegreeMethod::from_code(row.degree),
            is_capped: row.capped != 0,
            confidence: row.confidence,
            stop_criterion: StopCriterion::from_code(row.stop_reason),
            energy_source: EnergySource::from_code(row.elastic),
            quality: Quality::by_number(row.quality),
            gamma_j_m2: row.gamma_j_m2,
            e1_over_gamma: row.e1_over_gamma,
            threshold_impulse_factor: row.threshold_impulse_factor,
            seed: row.seed,
            handle: (row.handle != 0).then_some(row.handle),
            radius_m: row.radius_m,
            energy_error: row.energy_error,
            reduced_error_max: row.reduced_error_max,
            cvd_gap: row.cvd_gap,
            tolerance: row.tolerance,
            iterations_max: row.iterations_max,
            iterations: row.iterations,
            rank: row.rank,
            lift_modes: row.lift_modes,
            elastic_nodes: row.elastic_nodes,
            crack_nodes: row.crack_nodes,
            elements_across: (row.elements_across > 0.0).then_some(row.elements_across),
            discretization_error: (row.discretization_error > 0.0).then_some(row.discretization_error),
            strain_j,
            criterion: FractureCriterion::from_code(row.criterion),
            stress_over_strength: is_by_strength.then_some(row.stress_over_strength),
            averaged_over_m: positive(row.averaged_over_m),
            is_averaged_over_cell: row.averaged_over_cell != 0,
            surface_j: positive(row.surface_j),
            released_j: positive(row.released_j),
            deficit_j: positive(row.deficit_j),
            impactor_j,
            remainder_j: impactor_j.zip(strain_j).map(|(energy_j, strain_j)| (energy_j - strain_j).max(0.0)),
            load_factor,
            surface: FragmentSurface::from_code(row.surface),
            time: Duration::from_nanos(row.time_ns),
            missed_time: (row.overrun_ns > 0).then_some(missed),
        }
    }
}

/// A time budget that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MissedTime {
    /// By how much.
    pub by: Duration,
    /// Part that took most of the time.
    pub cause: OverrunCause,
}

impl MissedTime {
    /// The cause as a clause for people.
    #[must_use]
    pub fn explanation(&self) -> &'static str {
        match self.cause {
            OverrunCause::Queue => "waited in the queue",
            OverrunCause::NoReducedBasis => "no reduced basis: the displacements were solved for",
            OverrunCause::ReducedError => {
                "the estimated error of the reduced displacements was too large: the displacements were solved for"
            }
            OverrunCause::Degree => "energy and fracture degree took most of the time",
            OverrunCause::Cells => "the cells took most of the time, without any refinement",
            OverrunCause::AfterCells => {
                "what follows the cells (tessellation, fragments, effects) took most of the time"
            }
            OverrunCause::Unknown => "of a reason that this client does not know",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cause_of_an_overrun_has_an_explanation() {
        let mut row = SummaryWire::zeroed();
        assert_eq!(Summary::from(&row).missed_time, None);
        row.overrun_ns = 7;
        for cause in OverrunCause::ALL {
            row.overrun = cause.code();
            let missed = Summary::from(&row).missed_time.unwrap();
            assert_eq!((missed.by, missed.cause), (Duration::from_nanos(7), *cause));
            assert!(!missed.explanation().contains("know"), "{cause}");
        }
        row.overrun = 99;
        let missed = Summary::from(&row).missed_time.unwrap();
        assert!(missed.cause == OverrunCause::Unknown && missed.explanation().contains("does not know"));
    }

    #[test]
    fn zeros_in_the_row_mean_absent() {
        let mut row =
            SummaryWire { degree_source: 5, quality: 2, handle: 9, capped: 1, time_ns: 3, ..SummaryWire::zeroed() };
        row.set_object("Bär");
        let summary = Summary::from(&row);
        assert_eq!((summary.object.as_str(), summary.degree_origin), ("Bär", DegreeOrigin::Forced));
        assert_eq!((summary.quality, summary.handle, summary.is_capped), (Some(Quality::Game), Some(9), true));
        assert_eq!(summary.time, Duration::from_nanos(3));
        let empty = Summary::from(&SummaryWire::zeroed());
        assert_eq!((empty.quality, empty.handle, empty.is_capped), (None, None, false));
        assert_eq!((empty.impactor_j, empty.remainder_j, empty.load_factor, empty.strain_j), (None, None, None, None));
    }

    #[test]
    fn energies_of_impactors_may_be_zero() {
        let known = SummaryWire { has_impactor: 1, ..SummaryWire::zeroed() };
        let of = |row: &SummaryWire| {
            let own = Summary::from(row);
            [own.impactor_j, own.strain_j, own.remainder_j, own.load_factor]
        };
        assert_eq!(of(&SummaryWire { impactor_j: 3.0, ..known }), [Some(3.0), None, None, None]);
        let lowered = SummaryWire { has_load_factor: 1, ..known };
        assert_eq!(of(&lowered), [Some(0.0), Some(0.0), Some(0.0), Some(0.0)]);
        let stored = SummaryWire { impactor_j: 3.0, strain_j: 2.0, load_factor: 1.0, ..lowered };
        assert_eq!(of(&stored), [Some(3.0), Some(2.0), Some(1.0), Some(1.0)]);
    }
}
