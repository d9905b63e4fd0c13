//! Deviation of a lift from a similarity: the ratio of the largest to the smallest stretch.

use super::LiftedLattice;
use super::metric::metric;
use crate::lattice::Lattice;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Limit on the iterations of the 3 × 3 eigenvalue routine, which needs a handful.
const ITERATIONS_MAX: usize = 64;

/// Statistics of σ₁/σ₃ over the tetrahedra, weighted by volume.
///
/// The ratio is 1 for a similarity. It is infinite if the lift collapses a direction (above about
/// 10⁷, the accuracy of g = JᵀJ).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Median: half of the volume has a smaller ratio.
    pub median: f64,
    /// 99th percentile: 99 % of the volume has a smaller ratio.
    pub p99: f64,
    /// Largest ratio of any tetrahedron.
    pub max: f64,
}

/// Stretch ratios of `lift` on its lattice. All are 1 for a lattice without tetrahedra.
pub fn stretch(lift: &LiftedLattice, lattice: &Lattice) -> Stretch {
    let mut ratios: Vec<(f64, f64)> = (0..lattice.tets.len())
        .into_par_iter()
        .map(|tet| (ratio(lift, lattice, tet), lattice.tet_volume(tet)))
        .collect();
    ratios.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let volume: f64 = ratios.iter().map(|(_, volume)| volume).sum();
    let percentile = |share: f64| {
        let mut below = 0.0;
        let reached = ratios.iter().find(|(_, volume_of_tet)| {
            below += volume_of_tet;
            below >= share * volume
        });
        reached.or(ratios.last()).map_or(1.0, |(ratio, _)| *ratio)
    };
    Stretch { median: percentile(0.5), p99: percentile(0.99), max: ratios.last().map_or(1.0, |(ratio, _)| *ratio) }
}

/// Ratio σ₁/σ₃ of J on one tetrahedron.
fn ratio(lift: &LiftedLattice, lattice: &Lattice, tet: usize) -> f64 {
    let eigen = metric(lift, lattice, tet).try_symmetric_eigen(f64::EPSILON, ITERATIONS_MAX);
    let Some(eigen) = eigen else { return f64::INFINITY };
    let (least, largest) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    // Below this share of the largest eigenvalue, the square of σ₃ is rounding noise.
    if least <= largest * f64::EPSILON { f64::INFINITY } else { (largest / least).sqrt() }
}
