//! Memory of one strike, kept from one to the next.

use super::buffer_pool::BufferPool;
use crate::centroidal;
use crate::elasticity;
use crate::tessellation;

/// What the stages write into. One per worker; after a first strike on the largest object little is allocated anew.
#[derive(Default)]
pub struct Workspace {
    pub(super) elasticity: elasticity::ElasticWorkspace,
    /// By struck body; those of an impact with more bodies stay.
    pub(super) loads: Vec<elasticity::NodalLoad>,
    pub(super) displacement: Vec<f64>,
    pub(super) coordinates: Vec<f64>,
    pub(super) tet_energy: Vec<f64>,
    pub(super) centroidal: centroidal::DiagramWorkspace,
    pub(super) tessellation: tessellation::TessellationWorkspace,
    pub(super) spare: BufferPool,
}
