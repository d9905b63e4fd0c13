//! What a strike answers.

use super::{FractureMeshes, StopReason, Termination};
use serde::{Deserialize, Serialize};

/// Which rule produced the fracture degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DegreeSource {
    /// E_1 ≤ γ: the object stays whole.
    Threshold,
    /// The calibrated closed form.
    ClosedForm,
    /// A network that was trained on the object's examples.
    Inferred,
    /// A guess that was made to hold.
    Verified,
    /// The full optimisation.
    Optimised,
    /// The caller's number.
    Forced,
}

/// Neighbor of an outer run, and of a run on an earlier crack: nobody.
pub const OUTER: u32 = u32::MAX;

/// One fragment. Offsets point into the sections; index values are relative to the fragment's first vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentRow {
    /// Position in the table; dense from 0.
    pub id: u32,
    /// Body (component of the object) it comes from.
    pub body: u32,
    /// First vertex in the positions section.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the indices section.
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// First run in the runs section; the outer run, if any, comes first.
    pub run_first: u32,
    /// Number of runs.
    pub run_count: u32,
    /// First pair in the merge section.
    pub merge_first: u32,
    /// Number of merge pairs.
    pub merge_count: u32,
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Center of mass in the coordinates of the mesh file, m. Positions are relative to it.
    pub center_m: [f64; 3],
    /// Inertia about the center, axes of the mesh file, kg·m²: xx, yy, zz, xy, xz, yz (tensor entries, so off-diagonal
    /// ones carry their minus sign).
    pub inertia_kg_m2: [f64; 6],
    /// Distance-weighted energy E_i of the cell it belongs to, J·m².
    pub energy_j_m2: f64,
}

/// Triangles of one fragment that face one neighbor, or the outside. The fragment of an earlier answer on the other side of an
/// earlier crack is not told of: such runs follow those with neighbors, one per fragment that was there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunRow {
    /// The fragment it belongs to.
    pub fragment: u32,
    /// The fragment on the other side, or [`OUTER`]: the outside, or a fragment of an earlier answer.
    pub neighbor: u32,
    /// Whether it is a side of a crack, be it an earlier one.
    pub crack: bool,
    /// First vertex in the positions section.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the indices section.
    pub index_first: u32,
    /// Number of indices.
    pub index_count: u32,
}

/// Lengths of the bulk sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BulkCounts {
    /// Vertices: three f32 each.
    pub vertices: usize,
    /// Indices: one u32 each.
    pub indices: usize,
    /// Merge pairs: two u32 each.
    pub merges: usize,
    /// Bonds.
    pub bonds: usize,
    /// Points of debris.
    pub debris: usize,
}

/// The answer to one strike. It knows its exact size before any mesh is written.
pub struct FractureOutcome {
    /// The threshold in effect, J·m².
    pub gamma_j_m2: f64,
    /// E_1/γ of the body that is nearest to breaking, or broke most.
    pub e1_over_gamma: f64,
    /// Whether the strike ended before anything was solved for, since a bound of E_1 is below γ: [`Self::e1_over_gamma`] is that
    /// bound, and [`Self::impulse_factor`] one from below.
    pub bounded: bool,
    /// Impulses times this factor just break the object; 0 where its weight alone does. With gravity it is searched for where
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
    /// Sites of the diagrams; 0 where the object stays whole.
    pub sites: u32,
    /// Fracture degree of the criterion; 1 where the object stays whole.
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
    /// The fragments; `None` where the object stays whole.
    pub pieces: Option<FractureMeshes>,
}

impl FractureOutcome {
    /// What stopped the strike.
    pub fn stop_reason(&self) -> StopReason {
        match self.ending {
            Some(Termination::Time) => StopReason::Time,
            _ if self.capped => StopReason::Capped,
            Some(Termination::ErrorMet) => StopReason::ErrorMet,
            Some(Termination::Iterations) => StopReason::Iterations,
            Some(Termination::Converged) => StopReason::Converged,
            None => StopReason::Complete,
        }
    }
}
