//! Working memory of the stages of an impact.

use super::force_sums::ForceSums;
use super::load_front::LoadFront;
use super::load_patch::LoadPatch;
use super::near_field::NearContact;
use super::strain::StrainRow;
use crate::sparse::SolveScratch;

/// Products of a reduced basis that are summed in parallel lanes.
pub(super) const SIDE: usize = 16;

/// Working memory of an impact's stages, reused between impacts.
///
/// After the first impact on the largest body, no memory that grows with the lattice is allocated.
#[derive(Default)]
pub struct ElasticWorkspace {
    pub(super) scratch: SolveScratch,
    pub(super) residual: Vec<f64>,
    pub(super) front: LoadFront,
    pub(super) patch: LoadPatch,
    pub(super) near: Vec<NearContact>,
    pub(super) works: Vec<f64>,
    pub(super) narrow: Vec<[f32; SIDE]>,
    pub(super) pulled: ForceSums,
    pub(super) gathered: Vec<f64>,
    pub(super) linear: Vec<f64>,
    pub(super) image: Vec<f64>,
    pub(super) strains: Vec<f64>,
    pub(super) strain_rows: Vec<StrainRow>,
}

impl ElasticWorkspace {
    /// The displacement of linear elements of the last [`ReducedBasis::complete`](super::ReducedBasis::complete).
    pub fn completion(&self) -> &[f64] {
        &self.linear
    }
}
