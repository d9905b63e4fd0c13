//! Mean value coordinates of a point with respect to a closed triangle surface.
//!
//! Based on: T. Ju, S. Schaefer & J. Warren, *Mean value coordinates for closed triangular meshes* (ACM Transactions on
//! Graphics 24, 2005), figure 4, for the special cases; M. S. Floater, G. Kós & M. Reimers, *Mean value coordinates in
//! 3D* (Computer Aided Geometric Design 22, 2005), for the weights. A triangle seen from x projects to a spherical
//! triangle with unit corners u_i and mean vector m = ½ Σ θ_i n_i (θ_i the angle of edge i, n_i the unit normal of its
//! plane); its corners' weights are λ_i/d_i with Σ λ_i u_i = m. The vectors m of a closed surface cancel in pairs of
//! edges, so Σ w_i (v_i − x) = 0. To solve for λ by elimination keeps that sum small wherever x lies, while the
//! formula of figure 4 loses half of the digits.

use super::boundary::BoundarySurface;
use nalgebra::{Matrix3, Point3, Vector3};

/// Distance from a corner, over the triangle's size, below which the point is that corner.
const AT_CORNER: f64 = 1e-10;
/// Elevation of the point over the triangle's plane (sine of the angle under which it is seen) below which the point is in
/// that plane; and sine of the angle under which an edge is seen, below which it is on that edge's line. There the weights of a triangle that does not hold the point vanish with its solid angle.
const IN_PLANE: f64 = 1e-10;
/// How far from 2π the three angles of an in-plane triangle may add up if it holds the point.
const AROUND: f64 = 1e-6;

/// The weights of one point, and the memory to find them in.
pub(super) struct MeanValueWeights<'a> {
    surface: &'a BoundarySurface,
    /// Unit vectors to the surface's nodes, and distances.
    seen: Vec<(Vector3<f64>, f64)>,
    /// Not normalised; length of the surface's nodes.
    weights: Vec<f64>,
}

/// What one triangle says of the point.
enum View {
    /// Weights of its corners, to be added to those of all others.
    Weights([f64; 3]),
    /// Nothing: the point is in its plane, but not on it.
    Edgewise,
    /// The point lies on it: only these weights count.
    Holds([f64; 3]),
}

impl<'a> MeanValueWeights<'a> {
    pub(super) fn new(surface: &'a BoundarySurface) -> Self {
        let count = surface.nodes.len();
        Self { surface, seen: Vec::with_capacity(count), weights: vec![0.0; count] }
    }

    /// Finds the weights of `point`, anywhere in or on the surface.
    pub(super) fn find(&mut self, point: &Point3<f64>) {
        let seen = |position: &Point3<f64>| {
            let offset = position - point;
            let distance = offset.norm();
            (offset / distance, distance)
        };
        self.seen.clear();
        self.seen.extend(self.surface.positions.iter().map(seen));
        self.weights.fill(0.0);
        for corners in &self.surface.triangles {
            match view(corners.map(|node| self.seen[node as usize])) {
                View::Edgewise => {}
                View::Weights(weights) => self.add(corners, weights),
                View::Holds(weights) => {
                    self.weights.fill(0.0);
                    return self.add(corners, weights);
                }
            }
        }
    }

    fn add(&mut self, corners: &[u32; 3], weights: [f64; 3]) {
        corners.iter().zip(weights).for_each(|(&node, weight)| self.weights[node as usize] += weight);
    }

    /// The mean of `values` (node-major, `surface nodes × target.len()`) by the weights found last.
    pub(super) fn blend(&self, values: &[f64], target: &mut [f64]) {
        let total: f64 = self.weights.iter().sum();
        target.fill(0.0);
        for (weight, value) in self.weights.iter().zip(values.chunks_exact(target.len())) {
            target.iter_mut().zip(value).for_each(|(sum, x)| *sum += weight * x);
        }
        target.iter_mut().for_each(|sum| *sum /= total);
    }
}

/// A triangle, its corners as (unit vector, distance).
fn view(corners: [(Vector3<f64>, f64); 3]) -> View {
    let (u, d) = (corners.map(|corner| corner.0), corners.map(|corner| corner.1));
    let size = d[0].max(d[1]).max(d[2]);
    if let Some(at) = (0..3).find(|&i| d[i] <= AT_CORNER * size) {
        return View::Holds([0, 1, 2].map(|i| f64::from(u8::from(i == at))));
    }
    let next = |i: usize| (i + 1) % 3;
    let last = |i: usize| (i + 2) % 3;
    // Edge i, opposite corner i: twice the area of its chord triangle, and its angle.
    let cross = [0, 1, 2].map(|i| u[next(i)].cross(&u[last(i)]));
    let sine = cross.map(|cross| cross.norm());
    let angle = [0, 1, 2].map(|i| sine[i].atan2(u[next(i)].dot(&u[last(i)])));
    let elevation = u[0].dot(&cross[0]).abs() / (cross[0] + cross[1] + cross[2]).norm();
    // On the line of an edge the chord triangle has no area, and its elevation no meaning.
    if elevation > IN_PLANE && sine.iter().all(|sine| *sine > IN_PLANE) {
        let mean: Vector3<f64> = (0..3).map(|i| cross[i] * (0.5 * angle[i] / sine[i])).sum();
        let lambda = Matrix3::from_columns(&u).full_piv_lu().solve(&mean).unwrap_or_default();
        View::Weights([0, 1, 2].map(|i| lambda[i] / d[i]))
    } else if angle.iter().sum::<f64>() > std::f64::consts::TAU - AROUND {
        // Areas of the parts opposite the corners.
        View::Holds([0, 1, 2].map(|i| sine[i] * d[next(i)] * d[last(i)]))
    } else {
        View::Edgewise
    }
}
