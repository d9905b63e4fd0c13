//! Memory of one request, reused by the next.

pub(super) mod body_meshes;
pub(super) mod buffer_pool;

use crate::{centroidal, elasticity, tessellation};
use buffer_pool::BufferPool;

/// Buffers that the stages write into.
///
/// One per worker. After a first request on the largest object, later ones allocate little.
#[derive(Default)]
pub struct Workspace {
    pub(in crate::pipeline) elasticity: elasticity::ElasticWorkspace,
    /// Loads by struck body; entries beyond the current number of bodies are left over from earlier requests.
    pub(in crate::pipeline) loads: Vec<elasticity::NodalLoad>,
    pub(in crate::pipeline) displacement: Vec<f64>,
    pub(in crate::pipeline) coordinates: Vec<f64>,
    pub(in crate::pipeline) tet_energy: Vec<f64>,
    pub(in crate::pipeline) tet_energy_total: Vec<f64>,
    pub(in crate::pipeline) centroidal: centroidal::DiagramWorkspace,
    pub(in crate::pipeline) tessellation: tessellation::TessellationWorkspace,
    pub(in crate::pipeline) spare: BufferPool,
}
