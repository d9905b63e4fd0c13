//! Generalized winding number of triangle soups, by a hierarchy of multipole moments.
//!
//! Based on: A. Jacobson, L. Kavan, O. Sorkine-Hornung, *Robust inside-outside segmentation using generalized winding
//! numbers* (2013): w(q) = Σ Ω_t(q) / 4π. G. Barill, N. Dickson, R. Schmidt, D. Levin, A. Jacobson, *Fast winding
//! numbers for soups and clouds* (2018): the Taylor expansion of far clusters, to its third term. A. Van Oosterom, J.
//! Strackee, *The solid angle of a plane triangle* (1983): the exact term nearby.

use super::tree::{STACK, TriangleTree};
use nalgebra::{Matrix3, Point3, Vector3};
use std::f64::consts::TAU;

/// Distance over cluster radius beyond which the far field is used, for errors below 0.01.
const OPEN_REACH: f64 = 2.0;

/// The same for closed surfaces, whose winding number is rounded: for errors below 0.1.
const CLOSED_REACH: f64 = 1.3;

/// Far-field moments of a cluster of triangles: ∫ n, ∫ n x and ∫ n x x, with x relative to its center.
///
/// Each is symmetrized, because the derivatives of 1/r that it is contracted with are symmetric.
#[derive(Clone, Copy, Debug)]
struct Moments {
    /// Area-weighted center.
    center: Point3<f64>,
    /// Squared distance beyond which the expansion holds.
    reach_squared: f64,
    /// Area vector, ∫ n.
    dipole: Vector3<f64>,
    /// Components xx yy zz xy xz yz.
    quadrupole: [f64; 6],
    /// Components xxx yyy zzz, xxy xxz yyx yyz zzx zzy, xyz.
    octupole: [f64; 10],
}

/// Moments of every node of a [`TriangleTree`].
#[derive(Clone, Debug)]
pub(super) struct WindingMoments {
    moments: Vec<Moments>,
}

impl WindingMoments {
    /// Computes the moments in O(n log n). A `closed` surface needs less accuracy, because
    /// its winding number is rounded.
    pub fn new(tree: &TriangleTree, closed: bool) -> Self {
        let reach = if closed { CLOSED_REACH } else { OPEN_REACH };
        Self { moments: tree.nodes.iter().map(|node| Moments::of(&tree.triangles[node.range()], reach)).collect() }
    }

    /// Winding number of the tree's triangles around each of `points`; 1 inside a closed surface that faces outward.
    ///
    /// The error is below 0.1 for a surface declared closed, else below 0.01 and 0.001 on average. On the surface
    /// itself, any value between those of its two sides may result. Points that lie close together share the work: a
    /// cluster is far if it is far from all of them.
    pub fn at<const N: usize>(&self, tree: &TriangleTree, points: &[Point3<f64>; N]) -> [f64; N] {
        if tree.nodes.is_empty() {
            return [0.0; N];
        }
        let points = Lanes::of(points);
        let mut far = [0.0; N];
        let mut near = SolidAngles::default();
        let mut stack = [0u32; STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let index = stack[top] as usize;
            let moments = &self.moments[index];
            let offsets = points.to(&moments.center);
            let distances_squared = offsets.dot(&offsets);
            if distances_squared.iter().all(|distance| *distance > moments.reach_squared) {
                moments.add_far_field(&offsets, &distances_squared, &mut far);
                continue;
            }
            let node = &tree.nodes[index];
            if node.is_leaf() {
                for triangle in &tree.triangles[node.range()] {
                    near.add(&triangle.map(|corner| points.to(&corner)));
                }
            } else {
                stack[top] = index as u32 + 1;
                stack[top + 1] = node.right;
                top += 2;
            }
        }
        let near = near.turns();
        std::array::from_fn(|lane| far[lane] / (2.0 * TAU) + near[lane])
    }
}

/// Winding number by summing over all triangles; the reference for [`WindingMoments`].
#[cfg(test)]
pub(super) fn brute_force(triangles: &[[Point3<f64>; 3]], point: &Point3<f64>) -> f64 {
    triangles.iter().map(|triangle| triangle_winding(triangle, point)).sum()
}

/// Part of the winding number that one triangle adds.
pub(super) fn triangle_winding(triangle: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let (cosine, sine) = half_solid_angle(&a, &b, &c);
    sine.atan2(cosine) / TAU
}

impl Moments {
    fn of(triangles: &[[Point3<f64>; 3]], reach: f64) -> Self {
        let center = center(triangles);
        let (mut dipole, mut quadrupole, mut octupole) = (Vector3::zeros(), [0.0; 6], [0.0; 10]);
        let mut radius_squared: f64 = 0.0;
        for triangle in triangles {
            let corners = triangle.map(|corner| corner - center);
            radius_squared = corners.iter().map(Vector3::norm_squared).fold(radius_squared, f64::max);
            let [a, b, c] = corners;
            let n = (b - a).cross(&(c - a)) * 0.5;
            let sum = a + b + c;
            let first = sum / 3.0;
            // Mean of x xᵀ over a triangle.
            let second: Matrix3<f64> = [a, b, c, sum].iter().map(|x| x * x.transpose()).sum::<Matrix3<f64>>() / 12.0;
            dipole += n;
            for (slot, [i, j]) in quadrupole.iter_mut().zip(PAIRS) {
                *slot += 0.5 * (n[i] * first[j] + n[j] * first[i]);
            }
            for (slot, [i, j, k]) in octupole.iter_mut().zip(TRIPLES) {
                *slot += (n[i] * second[(j, k)] + n[j] * second[(k, i)] + n[k] * second[(i, j)]) / 3.0;
            }
        }
        Self { center, reach_squared: radius_squared * (reach * reach), dipole, quadrupole, octupole }
    }

    /// Adds the far field of the cluster. `offsets` = center − query. Terms of Barill et
    /// al., section 3.2, with ∇ⁿ(1/r).
    fn add_far_field<const N: usize>(&self, offsets: &Lanes<N>, distances_squared: &[f64; N], far: &mut [f64; N]) {
        let [xx, yy, zz, xy, xz, yz] = self.quadrupole;
        let [xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.octupole;
        let trace = [xxx + yyx + zzx, yyy + xxy + zzy, zzz + xxz + yyz];
        for lane in 0..N {
            let [x, y, z] = [offsets.x[lane], offsets.y[lane], offsets.z[lane]];
            let inverse_squared = 1.0 / distances_squared[lane];
            let inverse_cubed = inverse_squared * inverse_squared.sqrt();
            let first = self.dipole.x * x + self.dipole.y * y + self.dipole.z * z;
            let second = xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z);
            let third = x * x * (xxx * x + 3.0 * (xxy * y + xxz * z))
                + y * y * (yyy * y + 3.0 * (yyx * x + yyz * z))
                + z * z * (zzz * z + 3.0 * (zzx * x + zzy * y))
                + 6.0 * xyz * x * y * z;
            let traces = trace[0] * x + trace[1] * y + trace[2] * z;
            let tail = (7.5 * third * inverse_squared - 4.5 * traces - 3.0 * second) * inverse_squared;
            far[lane] += (first + xx + yy + zz + tail) * inverse_cubed;
        }
    }
}

/// `N` vectors, one array per axis.
struct Lanes<const N: usize> {
    x: [f64; N],
    y: [f64; N],
    z: [f64; N],
}

impl<const N: usize> Lanes<N> {
    fn of(points: &[Point3<f64>; N]) -> Self {
        Self { x: points.map(|point| point.x), y: points.map(|point| point.y), z: points.map(|point| point.z) }
    }

    /// Vectors from each of these points to `point`.
    fn to(&self, point: &Point3<f64>) -> Self {
        Self { x: self.x.map(|x| point.x - x), y: self.y.map(|y| point.y - y), z: self.z.map(|z| point.z - z) }
    }

    fn dot(&self, other: &Self) -> [f64; N] {
        std::array::from_fn(|lane| {
            self.x[lane] * other.x[lane] + self.y[lane] * other.y[lane] + self.z[lane] * other.z[lane]
        })
    }
}

/// Axes of the entries of a quadrupole and of an octupole.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];
const TRIPLES: [[usize; 3]; 10] =
    [[0, 0, 0], [1, 1, 1], [2, 2, 2], [0, 0, 1], [0, 0, 2], [1, 1, 0], [1, 1, 2], [2, 2, 0], [2, 2, 1], [0, 1, 2]];

/// Area-weighted center of the triangles, or the mean of their centers if they have no area.
fn center(triangles: &[[Point3<f64>; 3]]) -> Point3<f64> {
    let (mut area, mut weighted, mut plain) = (0.0, Vector3::zeros(), Vector3::zeros());
    for [a, b, c] in triangles {
        let doubled = (b - a).cross(&(c - a)).norm();
        let third = (a.coords + b.coords + c.coords) / 3.0;
        area += doubled;
        weighted += third * doubled;
        plain += third;
    }
    Point3::from(if area > 0.0 { weighted / area } else { plain / triangles.len() as f64 })
}

/// Cosine and sine of half the solid angle of a triangle, up to a common positive factor.
///
/// The corners are given relative to the query point (Van Oosterom & Strackee, equation 8).
fn half_solid_angle(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> (f64, f64) {
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    (la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb, a.dot(&b.cross(c)))
}

/// Sums of half solid angles, kept as complex numbers and counts of whole turns. This
/// saves an arc tangent per triangle.
struct SolidAngles<const N: usize> {
    cosine: [f64; N],
    sine: [f64; N],
    turns: [f64; N],
}

impl<const N: usize> Default for SolidAngles<N> {
    fn default() -> Self {
        Self { cosine: [1.0; N], sine: [0.0; N], turns: [0.0; N] }
    }
}

impl<const N: usize> SolidAngles<N> {
    /// Adds the triangle with these corners, relative to each point.
    fn add(&mut self, [a, b, c]: &[Lanes<N>; 3]) {
        for lane in 0..N {
            let corner = |of: &Lanes<N>| Vector3::new(of.x[lane], of.y[lane], of.z[lane]);
            let (cosine, sine) = half_solid_angle(&corner(a), &corner(b), &corner(c));
            let scale = cosine.abs().max(sine.abs());
            // A query point on a corner of the triangle sees no angle.
            let (cosine, sine) = if scale == 0.0 { (1.0, 0.0) } else { (cosine / scale, sine / scale) };
            let old = self.sine[lane];
            // Adding 0 turns −0 into 0, so that a half turn has one representation.
            let new = old * cosine + self.cosine[lane] * sine + 0.0;
            self.cosine[lane] = self.cosine[lane] * cosine - old * sine;
            self.sine[lane] = new;
            let forward = old >= 0.0 && sine > 0.0 && new < 0.0;
            let backward = old < 0.0 && sine < 0.0 && new >= 0.0;
            self.turns[lane] += f64::from(u8::from(forward)) - f64::from(u8::from(backward));
        }
        self.rescale();
    }

    /// Keeps the magnitudes near 1. Factors lie in [1, √2], so occasional rescaling suffices.
    fn rescale(&mut self) {
        for (cosine, sine) in self.cosine.iter_mut().zip(&mut self.sine) {
            let size = cosine.abs().max(sine.abs());
            if size > 1e100 {
                *cosine /= size;
                *sine /= size;
            }
        }
    }

    /// Solid angles over 4π.
    fn turns(&self) -> [f64; N] {
        std::array::from_fn(|lane| self.sine[lane].atan2(self.cosine[lane]) / TAU + self.turns[lane])
    }
}
