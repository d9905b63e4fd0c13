//! Volume, center of mass and inertia of a polyhedron from its surface.
//!
//! Based on: Mirtich, *Fast and accurate computation of polyhedral mass properties* (Journal of Graphics Tools 1(2),
//! 1996) and Eberly, *Polyhedral mass properties (revisited)* (2002). The divergence theorem turns the volume integrals
//! of 1, x_i and x_i x_j into sums over triangles, exact for polyhedra. The sums are over signed cones from a point
//! near the body, so that the body's distance from the origin costs no precision.

use crate::simd::{SimdLanes, widest};
use crate::tessellation::{FragmentRange, Tessellation};
use nalgebra::{Matrix3, Point3, Vector3};
use pulp::NullaryFnOnce;
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

/// Sums over triangles relative to a reference point.
#[derive(Clone, Copy)]
struct Sums {
    /// 24 ∫x, 24 ∫y, 24 ∫z, 6 V.
    first: SimdLanes<4>,
    /// 120 ∫xx, ∫yy, ∫zz.
    squares: SimdLanes<4>,
    /// 120 ∫xy, ∫yz, ∫zx.
    mixed: SimdLanes<4>,
}

/// A point relative to the reference point; the last lane is 0.
type Offset = SimdLanes<4>;

/// The coordinates y, z, x.
#[inline(always)]
fn turned([x, y, z, _]: [f64; 4]) -> Offset {
    SimdLanes([y, z, x, 0.0])
}

impl Sums {
    const ZERO: Self = Self { first: SimdLanes([0.0; 4]), squares: SimdLanes([0.0; 4]), mixed: SimdLanes([0.0; 4]) };

    /// Adds the cone over triangle (a, b, c), counter-clockwise seen from outside.
    #[inline(always)]
    fn add(&mut self, a: Offset, b: Offset, c: Offset) {
        let [next_a, next_b, next_c] = [a, b, c].map(|own| turned(own.0));
        let [last_b, last_c] = [next_b, next_c].map(|own| turned(own.0));
        let [x, y, z, _] = (a * (next_b * last_c - last_b * next_c)).0;
        let volume = SimdLanes::all(x + y + z);
        let mut sum = a + b + c;
        let next_sum = turned(sum.0);
        self.squares = self.squares + volume * (sum * sum + a * a + b * b + c * c);
        self.mixed = self.mixed + volume * (sum * next_sum + a * next_a + b * next_b + c * next_c);
        sum.0[3] = 1.0;
        self.first = self.first + sum * volume;
    }

    fn finish(&self, reference: Point3<f64>) -> RigidProperties {
        let [x, y, z, volume] = self.first.0;
        let volume = volume / 6.0;
        if volume == 0.0 {
            return RigidProperties { volume, center: reference, inertia: Matrix3::zeros() };
        }
        let offset = Vector3::new(x, y, z) / (24.0 * volume);
        let [[xx, yy, zz, _], [xy, yz, xz, _]] = [self.squares, self.mixed].map(|sums| sums.0.map(|sum| sum / 120.0));
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
        widest(Cones { reference, surfaces: std::iter::once((vertices, triangles)) }).finish(reference)
    }

    /// Properties of one fragment; zero volume without runs.
    pub fn of_fragment(tessellation: &Tessellation, fragment: &FragmentRange) -> Self {
        let runs = &tessellation.runs()[fragment.runs.clone()];
        let first = runs.first().and_then(|run| tessellation.run_vertices(run).first());
        let reference = first.copied().unwrap_or(Point3::origin());
        let surfaces = runs.iter().map(|run| (tessellation.run_vertices(run), tessellation.run_triangles(run)));
        widest(Cones { reference, surfaces }).finish(reference)
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
        // Sizes differ much.
        .with_max_len(1)
        .map(|fragment| RigidProperties::of_fragment(tessellation, fragment))
        .collect_into_vec(out);
}

/// Sums of the cones over triangles. `surfaces`: vertices, and triangles as indices into them.
struct Cones<S> {
    reference: Point3<f64>,
    surfaces: S,
}

impl<'a, S: Iterator<Item = (&'a [Point3<f64>], T)>, T: IntoIterator<Item = [u32; 3]>> NullaryFnOnce for Cones<S> {
    type Output = Sums;

    #[inline(always)]
    fn call(self) -> Sums {
        let Self { reference, surfaces } = self;
        let mut sums = Sums::ZERO;
        for (vertices, triangles) in surfaces {
            let offset = |vertex: u32| {
                let place = &vertices[vertex as usize];
                SimdLanes([place.x - reference.x, place.y - reference.y, place.z - reference.z, 0.0])
            };
            for [a, b, c] in triangles {
                sums.add(offset(a), offset(b), offset(c));
            }
        }
        sums
    }
}
