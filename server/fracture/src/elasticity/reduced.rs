//! Reduced elasticity: the displacement as a combination of a few, without a solve.
//!
//! Based on: L. Sirovich, *Turbulence and the dynamics of coherent structures* (Quarterly of Applied Mathematics 45, 1987),
//! method of snapshots, here in the energy inner product: with B'KB = 1 the best displacement in the span of B is B(B'f), a
//! Galerkin projection, and its energy ½|B'f|² never exceeds the true one. The energy that it misses is ½ r'K⁻¹r, r = f − K u
//! the residual; with the diagonal of K in the place of K it is cheap, and proportional to the true one over impacts of one
//! body (a residual estimator: R. Verfürth, *A Review of A Posteriori Error Estimation*, 1996; the proportion, fitted, is ours).

use super::residual::{self, ResidualForm, Sums};
use super::{ElasticWorkspace, Elasticity, NodalLoad};
use crate::memory::held;
use crate::simd::widest;
use nalgebra::Vector3;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// A basis of displacements of one free body, K-orthonormal, the most energetic first.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedBasis {
    rank: usize,
    /// One row of `rank` per component of a node's displacement.
    basis: Vec<f32>,
    estimate: ErrorEstimate,
    residual: ResidualForm,
    /// B'f of the inertial forces of unit accelerations: linear x, y, z, angular x, y, z.
    inertial: [Vec<f64>; 6],
}

/// Relative error of the energy from the relative residual ρ of [`ReducedBasis::residual`]: factor · ρ^power, fitted on impacts that
/// the basis has not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Positive.
    pub factor: f64,
    /// Positive; 1 where missing energy and residual are proportional.
    pub power: f64,
}

/// Products that are summed side by side.
pub(super) const SIDE: usize = 16;

/// Rows of a basis that a thread takes at once.
const ROWS: usize = 1024;

/// Rows of a basis times coordinates, filled up with zeros: what a row is read beyond its end, to be read by whole lanes, does not count.
struct Products<'a> {
    rank: usize,
    basis: &'a [f32],
    coordinates: &'a [[f32; SIDE]],
    sums: &'a mut [f64],
}

impl NullaryFnOnce for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let length = SIDE * self.coordinates.len();
        for (row, sum) in self.sums.iter_mut().enumerate() {
            let rest = &self.basis[row * self.rank..];
            let mut lanes = [0.0; SIDE];
            let (chunks, end) = rest[..length.min(rest.len())].as_chunks::<SIDE>();
            for (chunk, coordinates) in chunks.iter().zip(self.coordinates) {
                for lane in 0..SIDE {
                    lanes[lane] += chunk[lane] * coordinates[lane];
                }
            }
            // Empty but in the last rows.
            for ((lane, b), q) in lanes.iter_mut().zip(end).zip(self.coordinates.last().into_iter().flatten()) {
                *lane += b * q;
            }
            *sum = f64::from(halved(halved(halved(halved(lanes, 8), 4), 2), 1)[0]);
        }
    }
}

/// Rows of a basis times forces, added up.
struct Gather<'a, F> {
    rank: usize,
    basis: &'a [f32],
    forces: F,
    coordinates: &'a mut [f64],
}

impl<F: Iterator<Item = (usize, Vector3<f64>)>> NullaryFnOnce for Gather<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (node, force) in self.forces {
            let (x, others) = self.basis[3 * node * self.rank..][..3 * self.rank].split_at(self.rank);
            let (y, z) = others.split_at(self.rank);
            for (own, ((x, y), z)) in self.coordinates.iter_mut().zip(x.iter().zip(y).zip(z)) {
                *own += f64::from(*x) * force.x + f64::from(*y) * force.y + f64::from(*z) * force.z;
            }
        }
    }
}

/// The first `half` lanes take the next ones in.
#[inline(always)]
fn halved(mut lanes: [f32; SIDE], half: usize) -> [f32; SIDE] {
    for lane in 0..half {
        lanes[lane] += lanes[lane + half];
    }
    lanes
}

/// Fewer pairs fit no estimate.
const PAIRS_MIN: usize = 8;

/// Powers beyond this are an accident of few pairs.
const POWER_RANGE: [f64; 2] = [0.5, 2.0];

impl ReducedBasis {
    /// From a basis (one row of `rank` per component, `rank` ≥ 1) of the free displacements of `body`.
    ///
    /// # Panics
    /// If the length of the basis is not `rank` times the size of the body.
    pub fn new(body: &Elasticity, rank: usize, basis: Vec<f32>) -> Self {
        assert_eq!(basis.len(), rank * body.size(), "one row per component");
        let gram = residual::gram(body, rank, &basis);
        Self::stored(body, rank, basis, gram, ErrorEstimate::RAW)
    }

    /// From what [`Self::basis`], [`Self::gram`] and [`Self::estimate`] said of a basis of `body`.
    ///
    /// # Panics
    /// If the length of the basis is not `rank` times the size of the body, or that of the gram matrix not `rank²`.
    pub fn stored(body: &Elasticity, rank: usize, basis: Vec<f32>, gram: Vec<f64>, estimate: ErrorEstimate) -> Self {
        assert_eq!(basis.len(), rank * body.size(), "one row per component");
        assert_eq!(gram.len(), rank * rank, "rank × rank");
        let residual = ResidualForm::new(body, rank, &basis, gram);
        let mut reduced = Self { rank, basis, estimate, residual, inertial: Default::default() };
        reduced.inertial = std::array::from_fn(|axis| {
            let mut coordinates = vec![0.0; rank];
            let forces = (0..body.size() / 3).map(|node| (node, body.inertia.force(node, &residual::unit(axis))));
            reduced.gather(forces, &mut coordinates);
            coordinates
        });
        reduced
    }

    /// B'KD⁻¹KB, `rank × rank`, D the diagonal of K: what the residual's estimate needs beside the basis.
    pub fn gram(&self) -> &[f64] {
        self.residual.gram()
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
        held(&self.basis) + self.residual.bytes() + self.inertial.iter().map(held).sum::<usize>()
    }

    /// How errors are estimated.
    pub fn estimate(&self) -> ErrorEstimate {
        self.estimate
    }

    /// The same basis with errors estimated by `estimate`.
    pub fn estimating(self, estimate: ErrorEstimate) -> Self {
        Self { estimate, ..self }
    }

    /// B'f of `load` into `coordinates`; the elastic energy in the span of the basis, ½|B'f|².
    pub fn project(&self, load: &NodalLoad, coordinates: &mut Vec<f64>) -> f64 {
        coordinates.clear();
        coordinates.resize(self.rank, 0.0);
        self.gather(load.applied.iter().map(|(node, force)| (*node as usize, *force)), coordinates);
        let acceleration = load.acceleration.iter().flatten();
        for (inertial, acceleration) in self.inertial.iter().zip(acceleration) {
            coordinates.iter_mut().zip(inertial).for_each(|(own, inertial)| *own -= inertial * acceleration);
        }
        0.5 * coordinates.iter().map(|q| q * q).sum::<f64>()
    }

    /// How many of the displacements are used where `most` are asked for: at least one, at most all.
    pub fn used(&self, most: Option<u32>) -> usize {
        most.map_or(self.rank, |most| (most as usize).clamp(1, self.rank))
    }

    /// Relative error of the energy of the first `used` of `coordinates`, all of which have the error `whole`. The basis is
    /// orthonormal, so what the others capture is missing on top.
    pub fn truncated_error(coordinates: &[f64], used: usize, whole: f64) -> f64 {
        let square = |part: &[f64]| part.iter().map(|q| q * q).sum::<f64>();
        whole + (1.0 - whole) * square(&coordinates[used..]) / square(coordinates)
    }

    /// The displacement with these coordinates, of the first displacements where they are fewer than the rank; resized to the size of
    /// the body.
    pub fn expand(&self, coordinates: &[f64], displacement: &mut Vec<f64>, workspace: &mut ElasticWorkspace) {
        let narrow = &mut workspace.narrow;
        narrow.clear();
        narrow.resize(coordinates.len().div_ceil(SIDE), [0.0; SIDE]);
        narrow.as_flattened_mut().iter_mut().zip(coordinates).for_each(|(narrow, q)| *narrow = *q as f32);
        displacement.resize(self.basis.len() / self.rank, 0.0);
        displacement.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, sums)| {
            let basis = &self.basis[chunk * ROWS * self.rank..];
            widest(Products { rank: self.rank, basis, coordinates: narrow, sums });
        });
    }

    /// ρ = ½ r'D⁻¹r over ½|q|², r = f − K u the residual of the displacement with coordinates `q` under `load`, D the diagonal
    /// of K. Not a number where there is no energy.
    ///
    /// # Panics
    /// If `body`, the load or the coordinates are another body's.
    pub fn residual(&self, body: &Elasticity, load: &NodalLoad, q: &[f64], workspace: &mut ElasticWorkspace) -> f64 {
        let gather = |forces: &Sums, gathered: &mut [f64]| self.gather(forces.iter(), gathered);
        let missed = self.residual.energy(body, load, q, gather, workspace);
        missed / (0.5 * q.iter().map(|q| q * q).sum::<f64>())
    }

    /// Adds B'f of the forces on some nodes.
    fn gather(&self, forces: impl Iterator<Item = (usize, Vector3<f64>)>, coordinates: &mut [f64]) {
        widest(Gather { rank: self.rank, basis: &self.basis, forces, coordinates });
    }
}

impl ErrorEstimate {
    /// The residual itself.
    pub const RAW: Self = Self { factor: 1.0, power: 1.0 };

    /// Relative error of the energy of a displacement with this relative residual.
    pub fn error(&self, residual: f64) -> f64 {
        self.factor * residual.powf(self.power)
    }

    /// By least squares of the logarithms over pairs of residual and relative error, both positive; others are left out.
    /// [`Self::RAW`] where too few pairs are left, or all are alike.
    pub fn fit(pairs: &[(f64, f64)]) -> Self {
        let known = pairs.iter().filter(|(residual, error)| *residual > 0.0 && *error > 0.0);
        let logarithms: Vec<[f64; 2]> = known.map(|(residual, error)| [residual.ln(), error.ln()]).collect();
        let count = logarithms.len() as f64;
        let mean = |axis: usize| logarithms.iter().map(|pair| pair[axis]).sum::<f64>() / count;
        let [x, y] = [mean(0), mean(1)];
        let covariance: f64 = logarithms.iter().map(|pair| (pair[0] - x) * (pair[1] - y)).sum();
        let variance: f64 = logarithms.iter().map(|pair| (pair[0] - x).powi(2)).sum();
        if logarithms.len() < PAIRS_MIN || variance <= f64::EPSILON * count {
            return Self::RAW;
        }
        let power = (covariance / variance).clamp(POWER_RANGE[0], POWER_RANGE[1]);
        Self { factor: (y - power * x).exp(), power }
    }
}
