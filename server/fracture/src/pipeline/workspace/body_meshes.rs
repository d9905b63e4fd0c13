//! The meshes of one body, whose memory goes back to where it came from.

use super::buffer_pool::BufferPool;
use crate::fragment::RigidProperties;
use crate::tessellation::{Components, CrackPoints, Tessellation};
use nalgebra::Point3;
use std::mem::take;
/// The meshes of one body, whole or broken, or of one fragment that was struck again.
pub(in crate::pipeline) struct BodyMeshes {
    pub(in crate::pipeline) body: usize,
    pub(in crate::pipeline) tessellation: Tessellation,
    /// Fragment of each node of the body; those that are answered come first.
    pub(in crate::pipeline) labels: Vec<u32>,
    /// The crack points of these labels.
    pub(in crate::pipeline) points: CrackPoints,
    pub(in crate::pipeline) properties: Vec<RigidProperties>,
    /// Site of each fragment.
    pub(in crate::pipeline) sites: Vec<u32>,
    pub(in crate::pipeline) centers: Vec<Point3<f64>>,
    pub(in crate::pipeline) energies_j_m2: Vec<f64>,
    /// Where its memory goes.
    spare: BufferPool,
}

impl Drop for BodyMeshes {
    fn drop(&mut self) {
        let components = Components::from_memory(take(&mut self.labels), take(&mut self.sites));
        let (points, tessellation) = (take(&mut self.points), take(&mut self.tessellation));
        self.spare.give(CutBuffers { components, points, tessellation, measured: take(&mut self.properties) });
    }
}

/// What cutting one body works on.
#[derive(Default)]
pub(in crate::pipeline) struct CutBuffers {
    pub components: Components,
    pub points: CrackPoints,
    pub tessellation: Tessellation,
    pub measured: Vec<RigidProperties>,
}

impl CutBuffers {
    /// The pieces of body `body`, by the energy of a site, J·m².
    pub fn into_pieces(self, body: usize, spare: &BufferPool, energy_j_m2: impl Fn(u32) -> f64) -> BodyMeshes {
        let Self { components, points, tessellation, measured } = self;
        let energies_j_m2 = components.sites.iter().take(measured.len()).map(|&site| energy_j_m2(site)).collect();
        BodyMeshes {
            body,
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
