//! Volume, center of mass and inertia of a polyhedron from its surface.
//!
//! Based on: Mirtich, *Fast and accurate computation of polyhedral mass properties* (Journal of Graphics Tools 1(2),
//! 1996) and Eberly, *Polyhedral mass properties (revisited)* (2002). The divergence theorem turns the volume integrals
//! of 1, x_i and x_i x_j into sums over triangles, exact for polyhedra. The sums are over signed cones from a point
//! near the body, so that the body's distance from the origin costs no precision.

use crate::tessellation::{FragmentRange, Tessellation};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

/// A fragment as a rigid body of unit density, in local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidProperties {
    /// Volume, local length cubed; the mass at density 1.
    pub volume: f64,
    /// Center of mass, local.
    pub center: Point3<f64>,
    /// Inertia tensor about the center at density 1, local length to the fifth: ∫ (|r|² I − r rᵀ).
    pub inertia: Matrix3<f64>,
}

/// Reason why a body cannot be simulated as rigid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotRigid {
    /// The volume is not positive or not finite.
    #[error("volume {volume} is not positive and finite")]
    Volume {
        /// Volume, local length cubed.
        volume: f64,
    },
    /// The center is not finite.
    #[error("the center of mass is not finite")]
    Center,
    /// The inertia is not finite or not positive definite.
    #[error("the inertia is not finite or not positive definite")]
    Inertia,
    /// One principal moment exceeds the sum of the other two, which no mass distribution allows.
    #[error("principal moments of inertia violate the triangle inequality")]
    Moments,
}

/// Sums over triangles relative to a reference point: 6 V, 24 ∫x, 120 ∫xxᵀ.
#[derive(Clone, Copy)]
struct Sums {
    volume: f64,
    first: Vector3<f64>,
    /// Second moments: xx, yy, zz, xy, xz, yz.
    second: [f64; 6],
}

impl Sums {
    const ZERO: Self = Self { volume: 0.0, first: Vector3::new(0.0, 0.0, 0.0), second: [0.0; 6] };

    /// Adds the cone over triangle (a, b, c), counter-clockwise seen from outside.
    fn add(&mut self, a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) {
        let volume = a.dot(&b.cross(&c));
        let sum = a + b + c;
        let product = |i: usize, j: usize| sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j];
        self.volume += volume;
        self.first += sum * volume;
        for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
            self.second[k] += volume * product(i, j);
        }
    }

    fn finish(&self, reference: Point3<f64>) -> RigidProperties {
        let volume = self.volume / 6.0;
        if volume == 0.0 {
            return RigidProperties { volume, center: reference, inertia: Matrix3::zeros() };
        }
        let offset = self.first / (24.0 * volume);
        let [xx, yy, zz, xy, xz, yz] = self.second.map(|sum| sum / 120.0);
        let second = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - offset * offset.transpose() * volume;
        let inertia = Matrix3::identity() * second.trace() - second;
        RigidProperties { volume, center: reference + offset, inertia }
    }
}

impl RigidProperties {
    /// Properties of the polyhedron with these triangles (indices into `vertices`), closed and counter-clockwise seen
    /// from outside.
    pub fn of_surface(vertices: &[Point3<f64>], triangles: impl IntoIterator<Item = [u32; 3]>) -> Self {
        let reference = vertices.first().copied().unwrap_or(Point3::origin());
        let mut sums = Sums::ZERO;
        add_surface(&mut sums, reference, vertices, triangles);
        sums.finish(reference)
    }

    /// Properties of one fragment; zero volume without runs.
    pub fn of_fragment(tessellation: &Tessellation, fragment: &FragmentRange) -> Self {
        let runs = &tessellation.runs()[fragment.runs.clone()];
        let first = runs.first().and_then(|run| tessellation.run_vertices(run).first());
        let reference = first.copied().unwrap_or(Point3::origin());
        let mut sums = Sums::ZERO;
        for run in runs {
            add_surface(&mut sums, reference, tessellation.run_vertices(run), tessellation.run_triangles(run));
        }
        sums.finish(reference)
    }

    /// Checks that a physics engine can simulate the body: finite, positive volume, and a positive definite inertia
    /// that some mass distribution has.
    ///
    /// # Errors
    /// [`NotRigid`]: the first property that is not.
    pub fn rigid(&self) -> Result<(), NotRigid> {
        if !(self.volume > 0.0 && self.volume.is_finite()) {
            return Err(NotRigid::Volume { volume: self.volume });
        }
        if !self.center.coords.iter().all(|x| x.is_finite()) {
            return Err(NotRigid::Center);
        }
        if !self.inertia.iter().all(|x| x.is_finite()) || self.inertia.cholesky().is_none() {
            return Err(NotRigid::Inertia);
        }
        // Principal moments are I_k = ∫|r|² − λ_k, so the inequality means that the second moments λ are not negative.
        let second = Matrix3::identity() * (0.5 * self.inertia.trace()) - self.inertia;
        if second.cholesky().is_none() { Err(NotRigid::Moments) } else { Ok(()) }
    }
}

/// Writes the properties of every fragment, in order, to `out`; parallel over fragments.
pub fn properties(tessellation: &Tessellation, out: &mut Vec<RigidProperties>) {
    tessellation
        .fragments()
        .par_iter()
        .map(|fragment| RigidProperties::of_fragment(tessellation, fragment))
        .collect_into_vec(out);
}

fn add_surface(
    sums: &mut Sums,
    reference: Point3<f64>,
    vertices: &[Point3<f64>],
    triangles: impl IntoIterator<Item = [u32; 3]>,
) {
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize] - reference);
        sums.add(a, b, c);
    }
}
