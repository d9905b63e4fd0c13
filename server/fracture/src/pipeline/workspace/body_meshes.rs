//! Meshes of one body, whose buffers return to a pool.

use super::buffer_pool::BufferPool;
use crate::fragment::RigidProperties;
use crate::tessellation::{Components, CrackPoints, Tessellation};
use nalgebra::Point3;
use std::mem::take;
/// Meshes of one body, intact or fractured, or of the children of one fragment.
pub(in crate::pipeline) struct BodyMeshes {
    pub(in crate::pipeline) body: usize,
    pub(in crate::pipeline) tessellation: Tessellation,
    /// Fragment of each node of the body. Fragments of the result come first.
    pub(in crate::pipeline) labels: Vec<u32>,
    /// Crack points for these labels.
    pub(in crate::pipeline) points: CrackPoints,
    pub(in crate::pipeline) properties: Vec<RigidProperties>,
    /// Site of each fragment.
    pub(in crate::pipeline) sites: Vec<u32>,
    pub(in crate::pipeline) centers: Vec<Point3<f64>>,
    pub(in crate::pipeline) energies_j_m2: Vec<f64>,
    /// Memory of [`CutBuffers::carried`].
    carried: Vec<u32>,
    /// Pool that receives the buffers.
    spare: BufferPool,
}

impl Drop for BodyMeshes {
    fn drop(&mut self) {
        let components = Components::from_memory(take(&mut self.labels), take(&mut self.sites));
        let (points, tessellation) = (take(&mut self.points), take(&mut self.tessellation));
        let (measured, carried) = (take(&mut self.properties), take(&mut self.carried));
        self.spare.give(CutBuffers { components, points, tessellation, measured, carried });
    }
}

/// Buffers for cutting one body.
#[derive(Default)]
pub(in crate::pipeline) struct CutBuffers {
    /// Fragments of the nodes, and sites of the fragments.
    pub components: Components,
    /// Crack points.
    pub points: CrackPoints,
    /// Surfaces of the fragments.
    pub tessellation: Tessellation,
    /// Rigid-body properties of the fragments.
    pub measured: Vec<RigidProperties>,
    /// Sites of the nodes of a mesh of the input surface.
    pub carried: Vec<u32>,
}

impl CutBuffers {
    /// The fragments of body `body`; `energy_j_m2` returns the energy of a site, J·m².
    pub fn into_pieces(self, body: usize, spare: &BufferPool, energy_j_m2: impl Fn(u32) -> f64) -> BodyMeshes {
        let Self { components, points, tessellation, measured, carried } = self;
        let energies_j_m2 = components.sites.iter().take(measured.len()).map(|&site| energy_j_m2(site)).collect();
        BodyMeshes {
            body,
            carried,
            spare: spare.clone(),
            tessellation,
            points,
            energies_j_m2,
            centers: measured.iter().map(|measured| measured.center).collect(),
            labels: components.labels,
            properties: measured,
            sites: components.sites,
        }
    }
}
