//! Strains at boundary nodes from those of the tetrahedra around them.
//!
//! Based on: O. C. Zienkiewicz & J. Z. Zhu, *The superconvergent patch recovery and a posteriori error estimates*
//! (International Journal for Numerical Methods in Engineering 33, 1992): a linear polynomial is fitted to the strains
//! at the centroids of a patch and evaluated at its node. Linear fields are reproduced exactly, so bending stresses are
//! extrapolated from the centroids to the surface. The fit depends on the lattice only; it is one weight per tetrahedron.

use crate::elasticity::{BoundaryNodes, StrainComponents};
use crate::lattice::{Lattice, NodeStars};
use crate::memory::held;
use nalgebra::{Matrix4, Point3, Vector3, Vector4};

/// Largest sum of the absolute weights of a patch, the factor by which it may amplify errors of single tetrahedra.
///
/// Patches of one ring of tetrahedra at a plane face have about 2, those at an edge 3 to 5.
const AMPLIFICATION_MAX: f64 = 4.0;

/// Largest number of rings of tetrahedra around a node.
const RINGS_MAX: usize = 2;

/// Weights of the tetrahedra of each boundary node's patch.
#[derive(Clone, Debug)]
pub struct PatchRecovery {
    /// Start of each boundary node's entries; length boundary nodes + 1.
    starts: Vec<u32>,
    /// Tetrahedron and weight of each entry; the weights of a node sum to 1.
    entries: Vec<(u32, f64)>,
}

impl PatchRecovery {
    /// Fits the patches of all nodes of `boundary`, the boundary of `lattice`.
    pub fn new(lattice: &Lattice, boundary: &BoundaryNodes, stars: &NodeStars) -> Self {
        let centroids: Vec<Point3<f64>> = (0..lattice.tets.len()).map(|tet| centroid(lattice, tet)).collect();
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for &node in &boundary.nodes {
            entries.extend(patch_weights(lattice, stars, &centroids, node));
            starts.push(entries.len() as u32);
        }
        Self { starts, entries }
    }

    /// Strain at boundary node `node` from the `strains` of all tetrahedra.
    pub fn at(&self, node: usize, strains: &[StrainComponents]) -> StrainComponents {
        let mut sum = [0.0; 6];
        for (tet, weight) in &self.entries[self.starts[node] as usize..self.starts[node + 1] as usize] {
            sum.iter_mut().zip(&strains[*tet as usize]).for_each(|(sum, own)| *sum += weight * own);
        }
        sum
    }

    /// Bytes of memory that it holds.
    pub fn bytes(&self) -> usize {
        held(&self.starts) + held(&self.entries)
    }
}

fn centroid(lattice: &Lattice, tet: usize) -> Point3<f64> {
    let corners = lattice.corners(tet);
    Point3::from(corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0)
}

/// Weights of the smallest patch around `node` whose fit amplifies errors little; their mean by volume without one.
fn patch_weights(lattice: &Lattice, stars: &NodeStars, centroids: &[Point3<f64>], node: u32) -> Vec<(u32, f64)> {
    let origin = lattice.nodes[node as usize];
    let mut patch = stars.of(node).to_vec();
    for ring in 0..RINGS_MAX {
        if ring > 0 {
            let nodes = patch.iter().flat_map(|tet| lattice.tets[*tet as usize]);
            let wider: Vec<u32> = nodes.flat_map(|node| stars.of(node).iter().copied()).collect();
            patch.extend(wider);
            patch.sort_unstable();
            patch.dedup();
        }
        let weights = fit(patch.iter().map(|tet| centroids[*tet as usize] - origin));
        if let Some(weights) =
            weights.filter(|own| own.iter().map(|weight| weight.abs()).sum::<f64>() <= AMPLIFICATION_MAX)
        {
            return patch.into_iter().zip(weights).collect();
        }
    }
    let star = stars.of(node);
    let total: f64 = star.iter().map(|tet| lattice.tet_volume(*tet as usize)).sum();
    star.iter().map(|tet| (*tet, lattice.tet_volume(*tet as usize) / total)).collect()
}

/// Weights by which values at `points` yield that of the fitted linear polynomial at the origin: w_i = p_iᵀ M⁻¹ e₁ with
/// p = (1, x, y, z) and M = Σ p pᵀ. `None` if the points do not determine a polynomial.
fn fit(points: impl Iterator<Item = Vector3<f64>> + Clone) -> Option<Vec<f64>> {
    let scale = points.clone().map(|point| point.norm()).fold(0.0, f64::max);
    let basis = points.map(|point| (point / scale).insert_row(0, 1.0));
    let moments: Matrix4<f64> = basis.clone().map(|own| own * own.transpose()).sum();
    let coefficients: Vector4<f64> = moments.cholesky()?.solve(&Vector4::x());
    let weights: Vec<f64> = basis.map(|own| own.dot(&coefficients)).collect();
    // Rounding may let singular moments pass.
    let sum: f64 = weights.iter().sum();
    ((sum - 1.0).abs() < 1e-9).then_some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;
    use crate::reference::perturbed;

    fn check(lattice: &Lattice) {
        let boundary = BoundaryNodes::new(lattice);
        let recovery = PatchRecovery::new(lattice, &boundary, &lattice.stars());
        let field = |point: &Point3<f64>| {
            let [x, y, z] = [point.x, point.y, point.z];
            [1.0 + x, 2.0 * y - z, 0.5 - x + y, 3.0 * z, x + y + z, -2.0]
        };
        let strains: Vec<StrainComponents> =
            (0..lattice.tets.len()).map(|tet| field(&centroid(lattice, tet))).collect();
        for (node, position) in boundary.positions.iter().enumerate() {
            let (found, exact) = (recovery.at(node, &strains), field(position));
            for (found, exact) in found.iter().zip(exact) {
                assert!((found - exact).abs() < 1e-9, "{position}: {found} for {exact}");
            }
        }
    }

    #[test]
    fn linear_fields_are_reproduced_exactly_at_every_boundary_node() {
        check(&block([4, 4, 4], 0.2));
        check(&block([6, 2, 3], 0.1));
        check(&perturbed([4, 3, 5], 0.2, 0.15, 7));
    }

    #[test]
    fn weights_without_a_fit_are_those_of_the_volumes() {
        let lattice = Lattice {
            nodes: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from).to_vec(),
            tets: vec![[0, 1, 2, 3]],
        };
        let recovery = PatchRecovery::new(&lattice, &BoundaryNodes::new(&lattice), &lattice.stars());
        assert_eq!(recovery.at(2, &[[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }
}
