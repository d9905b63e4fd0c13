//! Exact diagram of given sites on a lattice: it misses no cell and shifts no border.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014): cells
//! are nearest sites in the lift. Inside a tetrahedron the lift is linear, so cells are convex polytopes there: the
//! tetrahedron clipped by all sites that compete for it.

use super::AccuracyError;
use super::candidate_sites::CandidateSites;
use super::polytope::{BarycentricWeights, Polytope};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::lift::LiftedLattice;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Tetrahedra per parallel task and partial sum, so that sums do not depend on the number of threads.
pub(super) const CHUNK: usize = 512;

/// Exact cells of a diagram.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExactCells {
    /// Volume of each site's cell, local. They sum to the lattice's volume.
    pub volumes: Vec<f64>,
    /// Borders between cells as a triangle soup, local; neighbors are not welded.
    ///
    /// A lattice face on which two sites tie is a border, too.
    pub triangles: Vec<[Point3<f64>; 3]>,
    /// Sites on both sides of each triangle, the lower first. The triangle is counter-clockwise
    /// seen from the higher one's side.
    pub pairs: Vec<[u32; 2]>,
}

/// Computes the exact diagram of `sites` on `lattice`. Ties go to the lowest index.
///
/// `sites` is site-major, `sites × dimension` of `lift`, with at least one site.
///
/// # Errors
/// [`AccuracyError::Length`], [`AccuracyError::Canceled`].
pub fn exact(
    lattice: &Lattice,
    lift: &LiftedLattice,
    sites: &[f64],
    token: &CancelToken,
) -> Result<ExactCells, AccuracyError> {
    let rivals = CandidateSites::new(lattice, lift, sites)?;
    let chunks = (0..lattice.tets.len().div_ceil(CHUNK)).into_par_iter().map(|chunk| {
        token.check()?;
        Ok(clipped(rivals, chunk))
    });
    let parts: Vec<ExactCells> = chunks.collect::<Result<_, AccuracyError>>()?;
    let mut whole = ExactCells { volumes: vec![0.0; rivals.count()], ..ExactCells::default() };
    for part in parts {
        whole.volumes.iter_mut().zip(&part.volumes).for_each(|(sum, volume)| *sum += volume);
        whole.triangles.extend(part.triangles);
        whole.pairs.extend(part.pairs);
    }
    Ok(whole)
}

/// Exact cells within the tetrahedra of one chunk.
fn clipped(rivals: CandidateSites<'_>, chunk: usize) -> ExactCells {
    let lattice = rivals.lattice;
    let mut part = ExactCells { volumes: vec![0.0; rivals.count()], ..ExactCells::default() };
    let (mut all, mut own) = (Vec::new(), Vec::new());
    for tet in chunk * CHUNK..lattice.tets.len().min((chunk + 1) * CHUNK) {
        rivals.of(tet, &mut all, &mut own);
        let volume = lattice.tet_volume(tet);
        if let [alone] = own.as_slice() {
            part.volumes[alone.site as usize] += volume;
            continue;
        }
        let corners = lattice.corners(tet);
        for rival in &own {
            let cell = rival.cell(&own, Polytope::whole());
            part.volumes[rival.site as usize] += volume * cell.volume();
            for (other, triangle) in cell.shared().filter(|(other, _)| rival.site < *other) {
                part.triangles.push(triangle.map(|weights| placed(&corners, &weights)));
                part.pairs.push([rival.site, other]);
            }
        }
    }
    part
}

/// Position of a point given by its barycentric coordinates.
pub(super) fn placed(corners: &[Point3<f64>; 4], weights: &BarycentricWeights) -> Point3<f64> {
    let sum: Vector3<f64> = corners.iter().zip(weights).map(|(corner, weight)| corner.coords * *weight).sum();
    Point3::from(sum)
}
