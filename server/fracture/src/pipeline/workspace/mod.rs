//! Memory of one strike, kept from one to the next.

pub(super) mod body_meshes;
pub(super) mod buffer_pool;

use crate::{centroidal, elasticity, tessellation};
use buffer_pool::BufferPool;

/// What the stages write into. One per worker; after a first strike on the largest object little is allocated anew.
#[derive(Default)]
pub struct Workspace {
    pub(in crate::pipeline) elasticity: elasticity::ElasticWorkspace,
    /// By struck body; those of an impact with more bodies stay.
    pub(in crate::pipeline) loads: Vec<elasticity::NodalLoad>,
    pub(in crate::pipeline) displacement: Vec<f64>,
    pub(in crate::pipeline) coordinates: Vec<f64>,
    pub(in crate::pipeline) tet_energy: Vec<f64>,
    pub(in crate::pipeline) centroidal: centroidal::DiagramWorkspace,
    pub(in crate::pipeline) tessellation: tessellation::TessellationWorkspace,
    pub(in crate::pipeline) spare: BufferPool,
}
