//! Mean value coordinates of a point with respect to a closed triangle surface.
//!
//! Based on: T. Ju, S. Schaefer & J. Warren, *Mean value coordinates for closed triangular meshes* (ACM Transactions on
//! Graphics 24, 2005), figure 4, for the special cases; M. S. Floater, G. Kós & M. Reimers, *Mean value coordinates in
//! 3D* (Computer Aided Geometric Design 22, 2005), for the weights.
//!
//! Seen from x, a triangle with corners v_i at distances d_i projects to a spherical triangle, with unit
//! corners u_i and mean vector m = ½ Σ θ_i n_i, with θ_i the angle of edge i and n_i the unit normal of its plane.
//! The weights of the corners are w_i = λ_i/d_i with Σ λ_i u_i = m. The terms of m cancel in pairs at the edges of a
//! closed surface, so Σ w_i (v_i − x) = 0.
//!
//! Here λ is found by elimination, which keeps that sum small for any x. The formula of figure 4 loses half of the
//! digits.

use super::boundary::BoundarySurface;
use nalgebra::{Matrix3, Point3, Vector3};

/// Distance from a corner, over the triangle's size, below which the point counts as that corner.
const AT_CORNER: f64 = 1e-10;
/// Sine of an angle below which a point counts as in a triangle's plane, or on an edge's line.
///
/// It applies to the point's elevation over the plane, and to the angle that the edge subtends. There the weights of a
/// triangle that does not contain the point vanish with its solid angle.
const IN_PLANE: f64 = 1e-10;
/// Tolerance of the sum 2π of the three angles of an in-plane triangle that contains the point.
const AROUND: f64 = 1e-6;

/// Weights of one point, and the memory to compute them.
pub(super) struct MeanValueWeights<'a> {
    surface: &'a BoundarySurface,
    /// Unit vectors to the surface's nodes, and distances.
    seen: Vec<(Vector3<f64>, f64)>,
    /// Weights of the surface's nodes, not normalized.
    weights: Vec<f64>,
}

/// Contribution of one triangle to the weights of a point.
enum View {
    /// Weights of its corners, to be added to those of all other triangles.
    Weights([f64; 3]),
    /// None: the point is in the triangle's plane, but not on the triangle.
    Edgewise,
    /// The point lies on the triangle, so only these weights count.
    Holds([f64; 3]),
}

impl<'a> MeanValueWeights<'a> {
    /// Allocates memory for the weights of points in `surface`.
    pub(super) fn new(surface: &'a BoundarySurface) -> Self {
        let count = surface.nodes.len();
        Self { surface, seen: Vec::with_capacity(count), weights: vec![0.0; count] }
    }

    /// Computes the weights of `point`, anywhere in or on the surface.
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

    /// Weighted mean of `values` (node-major, `surface nodes × target.len()`) with the weights computed last.
    pub(super) fn blend(&self, values: &[f64], target: &mut [f64]) {
        let total: f64 = self.weights.iter().sum();
        target.fill(0.0);
        for (weight, value) in self.weights.iter().zip(values.chunks_exact(target.len())) {
            target.iter_mut().zip(value).for_each(|(sum, x)| *sum += weight * x);
        }
        target.iter_mut().for_each(|sum| *sum /= total);
    }
}

/// Contribution of a triangle, given by its corners as (unit vector, distance).
fn view(corners: [(Vector3<f64>, f64); 3]) -> View {
    let (u, d) = (corners.map(|corner| corner.0), corners.map(|corner| corner.1));
    let size = d[0].max(d[1]).max(d[2]);
    if let Some(at) = (0..3).find(|&i| d[i] <= AT_CORNER * size) {
        return View::Holds([0, 1, 2].map(|i| f64::from(u8::from(i == at))));
    }
    let next = |i: usize| (i + 1) % 3;
    let last = |i: usize| (i + 2) % 3;
    // Edge i, opposite corner i: its chord triangle's doubled area vector, and its angle.
    let cross = [0, 1, 2].map(|i| u[next(i)].cross(&u[last(i)]));
    let sine = cross.map(|cross| cross.norm());
    let angle = [0, 1, 2].map(|i| sine[i].atan2(u[next(i)].dot(&u[last(i)])));
    let elevation = u[0].dot(&cross[0]).abs() / (cross[0] + cross[1] + cross[2]).norm();
    // On the line of an edge the chord triangle has no area, and the elevation is meaningless.
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
