//! Reduced elasticity: the displacement as a combination of a few, without a solve.
//!
//! Based on: L. Sirovich, *Turbulence and the dynamics of coherent structures* (Quarterly of Applied Mathematics 45, 1987),
//! method of snapshots, here in the energy inner product: with B'KB = 1 the best displacement in the span of B is B(B'f), a
//! Galerkin projection, and its energy ½|B'f|² never exceeds the true one.

use super::{Elasticity, Load, Workspace};
use crate::memory::held;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector, Vector3};

/// A basis of displacements of one free body, K-orthonormal, the most energetic first.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduced {
    rank: usize,
    /// One row of `rank` per component of a node's displacement.
    basis: Vec<f32>,
    /// Smallest contact radius that the basis has seen, local.
    radius_min: f64,
    estimate: Estimate,
    /// B'f of the inertial forces of unit accelerations: linear x, y, z, angular x, y, z.
    inertial: [Vec<f64>; 6],
}

/// Number of features that errors are estimated from.
pub const FEATURES: usize = 3;

/// ln(relative error of the energy) as an affine function of [`Captured::features`], fitted on impacts that the basis has not
/// seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The constant, then one factor per feature.
    pub coefficients: [f64; 1 + FEATURES],
}

/// What the basis says of a load before anything is expanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Captured {
    /// Elastic energy in the span of the basis, ½|B'f|².
    pub energy: f64,
    /// Logarithms of the shares of it in the last quarter and in the last sixteenth of the basis, and of the smallest contact
    /// radius.
    pub features: [f64; FEATURES],
    /// Relative error of the energy, estimated; infinite where a contact is a tenth smaller than those that the basis has seen.
    pub error: f64,
}

/// A contact may be this much smaller than the smallest that was seen: radii are drawn from the default upwards, so that the
/// default itself is a little smaller than all of them.
const RADIUS_SMALLER: f64 = 0.9;

/// Fewer pairs fit no estimate.
const PAIRS_MIN: usize = 4 * (1 + FEATURES);

/// Singular values below this are rounding: features that say the same.
const RANK_ROUNDING: f64 = 1e-9;

impl Reduced {
    /// From a basis (one row of `rank` per component, `rank` ≥ 1) of the free displacements of `body`.
    ///
    /// # Panics
    /// If the length of the basis is not `rank` times the size of the body.
    pub fn new(body: &Elasticity, rank: usize, basis: Vec<f32>, radius_min: f64, estimate: Estimate) -> Self {
        assert_eq!(basis.len(), rank * body.size(), "one row per component");
        let mut reduced = Self { rank, basis, radius_min, estimate, inertial: Default::default() };
        reduced.inertial = std::array::from_fn(|axis| {
            let mut unit = [Vector3::zeros(); 2];
            unit[axis / 3][axis % 3] = 1.0;
            let mut coordinates = vec![0.0; rank];
            for node in 0..body.size() / 3 {
                reduced.add(node, &body.inertia.force(node, &unit), &mut coordinates);
            }
            coordinates
        });
        reduced
    }

    /// Number of displacements.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The displacements, one row of [`Self::rank`] per component of a node.
    pub fn basis(&self) -> &[f32] {
        &self.basis
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        held(&self.basis) + self.inertial.iter().map(held).sum::<usize>()
    }

    /// Smallest contact radius that the basis has seen, local.
    pub fn radius_min(&self) -> f64 {
        self.radius_min
    }

    /// How errors are estimated.
    pub fn estimate(&self) -> Estimate {
        self.estimate
    }

    /// The same basis with errors estimated by `estimate`.
    pub fn estimating(self, estimate: Estimate) -> Self {
        Self { estimate, ..self }
    }

    /// B'f of `load` into `coordinates`, and what it is worth.
    pub fn project(&self, load: &Load, coordinates: &mut Vec<f64>) -> Captured {
        coordinates.clear();
        coordinates.resize(self.rank, 0.0);
        for (node, force) in &load.applied {
            self.add(*node as usize, force, coordinates);
        }
        let acceleration = load.acceleration.iter().flatten();
        for (inertial, acceleration) in self.inertial.iter().zip(acceleration) {
            coordinates.iter_mut().zip(inertial).for_each(|(own, inertial)| *own -= inertial * acceleration);
        }
        let energy = |part: &[f64]| 0.5 * part.iter().map(|q| q * q).sum::<f64>();
        let whole = energy(coordinates);
        let last = |one_of: usize| energy(&coordinates[self.rank - self.rank.div_ceil(one_of)..]) / whole;
        let smallest = load.touches.iter().map(|touch| touch.radius).fold(f64::INFINITY, f64::min);
        let features = [last(4), last(16), smallest].map(|value| value.max(f64::MIN_POSITIVE).ln());
        let seen = smallest >= self.radius_min * RADIUS_SMALLER;
        let error = if seen { self.estimate.error(&features) } else { f64::INFINITY };
        Captured { energy: whole, features, error }
    }

    /// The displacement with these coordinates, resized to the size of the body.
    pub fn expand(&self, coordinates: &[f64], displacement: &mut Vec<f64>, workspace: &mut Workspace) {
        let rows = self.basis.len() / self.rank;
        let [narrow, sums] = &mut workspace.narrow;
        narrow.clear();
        narrow.extend(coordinates.iter().map(|q| *q as f32));
        sums.resize(rows, 0.0);
        let basis = MatRef::from_row_major_slice(&self.basis, rows, self.rank);
        let column = MatRef::from_column_major_slice(narrow, self.rank, 1);
        matmul(MatMut::from_column_major_slice_mut(sums, rows, 1), Accum::Replace, basis, column, 1.0, Par::Seq);
        displacement.clear();
        displacement.extend(sums.iter().copied().map(f64::from));
    }

    /// Adds B'f of one node's force.
    fn add(&self, node: usize, force: &Vector3<f64>, coordinates: &mut [f64]) {
        let rows = self.basis[3 * node * self.rank..][..3 * self.rank].chunks_exact(self.rank);
        for (row, force) in rows.zip(force) {
            coordinates.iter_mut().zip(row).for_each(|(own, b)| *own += f64::from(*b) * force);
        }
    }
}

impl Estimate {
    /// The share of the last quarter itself.
    pub const RAW: Self = Self { coefficients: [0.0, 1.0, 0.0, 0.0] };

    /// Relative error of the energy of a load with these features.
    pub fn error(&self, features: &[f64; FEATURES]) -> f64 {
        let [constant, factors @ ..] = &self.coefficients;
        (constant + factors.iter().zip(features).map(|(factor, feature)| factor * feature).sum::<f64>()).exp()
    }

    /// By least squares of the logarithms over pairs of features and relative error; pairs without an error are left out, and
    /// of all that fit equally well the least coefficients are taken. [`Self::RAW`] where too few pairs are left.
    pub fn fit(pairs: &[([f64; FEATURES], f64)]) -> Self {
        let known: Vec<_> = pairs.iter().filter(|(_, error)| *error > 0.0).collect();
        if known.len() < PAIRS_MIN {
            return Self::RAW;
        }
        let rows = DMatrix::from_fn(known.len(), 1 + FEATURES, |row, column| match column {
            0 => 1.0,
            column => known[row].0[column - 1],
        });
        let logarithms = DVector::from_iterator(known.len(), known.iter().map(|(_, error)| error.ln()));
        let solution = rows.svd(true, true).solve(&logarithms, RANK_ROUNDING);
        solution.map_or(Self::RAW, |found| Self { coefficients: std::array::from_fn(|k| found[k]) })
    }
}
