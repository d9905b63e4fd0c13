//! Solution of K u = f by one back-substitution, with refinement if needed.

use super::quadratic::SOLVED;
use super::{ElasticWorkspace, Elasticity, ElasticityError, RESIDUAL_MAX};
use crate::cancel_token::CancelToken;
use crate::random::RandomStream;
use crate::sparse::{Cholesky, Precision};

/// Largest accepted residual that is rounding of a slender body's large displacement, kε‖K‖‖u‖/‖f‖.
///
/// Refinement cannot remove it, and it hardly changes energies.
pub const ROUNDING_MAX: f64 = 1e-4;

/// Residual above which a sweep of iterative refinement is worth its back-substitution.
const RESIDUAL_REFINED: f64 = 1e-10;

/// Largest residual at which a single-precision factor is used. Compact bodies leave 1e-5.
pub const NARROW_RESIDUAL_MAX: f64 = 1e-3;

/// As [`RESIDUAL_REFINED`], with a single-precision factor.
const NARROW_RESIDUAL_REFINED: f64 = 1e-7;

/// Largest number of refinement sweeps.
fn sweeps_max(precision: Precision) -> usize {
    match precision {
        Precision::F64 => 1,
        Precision::F32 => 3,
    }
}

/// Residual above which another refinement sweep is worth its back-substitution.
fn residual_refined(precision: Precision) -> f64 {
    match precision {
        Precision::F64 => RESIDUAL_REFINED,
        Precision::F32 => NARROW_RESIDUAL_REFINED,
    }
}

/// Accuracy of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// ‖f − K u‖ / ‖f‖ against the true stiffness of the free body, reactions at pins included. With quadratic elements
    /// the norm is that of the preconditioner, about that of the energy.
    pub residual: f64,
    /// Number of refinement sweeps: usually 0, and 1 with a single-precision factor. With quadratic elements, the number of
    /// steps of conjugate gradients.
    pub sweeps: usize,
}

impl Elasticity {
    /// Solves for the displacement under `forces` (length [`Self::unknowns`], in equilibrium unless the body is anchored).
    ///
    /// Resizes `displacement` to the same length. The rigid motion of a free body is that of its pins and has no
    /// meaning; its strains do.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`], [`ElasticityError::Residual`], [`ElasticityError::Canceled`], those of
    /// [`Self::factor`].
    pub fn solve(
        &self,
        forces: &[f64],
        displacement: &mut Vec<f64>,
        workspace: &mut ElasticWorkspace,
        token: &CancelToken,
    ) -> Result<SolveReport, ElasticityError> {
        self.check_length("the load", forces)?;
        displacement.clear();
        displacement.extend_from_slice(forces);
        if let Some(edges) = &self.edges {
            return self.iterate(edges, displacement, SOLVED, workspace, token).map(|(report, _)| report);
        }
        let factor = self.factor()?;
        self.back_substitute(factor, displacement, workspace);
        token.check()?;
        let mut residual = self.residual(forces, displacement, &mut workspace.residual);
        let mut sweeps = 0;
        while residual > residual_refined(factor.precision()) && sweeps < sweeps_max(factor.precision()) {
            sweeps += 1;
            let mut correction = std::mem::take(&mut workspace.residual);
            self.back_substitute(factor, &mut correction, workspace);
            displacement.iter_mut().zip(&correction).for_each(|(u, du)| *u += du);
            workspace.residual = correction;
            token.check()?;
            residual = self.residual(forces, displacement, &mut workspace.residual);
        }
        if residual <= self.residual_max(forces, displacement) {
            Ok(SolveReport { residual, sweeps })
        } else {
            Err(ElasticityError::Residual { residual })
        }
    }

    /// Returns true if `displacement` balances `forces` without refinement.
    pub(super) fn balances(&self, forces: &[f64], displacement: &[f64], workspace: &mut ElasticWorkspace) -> bool {
        self.residual(forces, displacement, &mut workspace.residual) <= residual_refined(self.precision())
    }

    fn residual_max(&self, forces: &[f64], displacement: &[f64]) -> f64 {
        RESIDUAL_MAX.max(self.rounding(forces, displacement).min(ROUNDING_MAX))
    }

    /// Rounding error of a residual, kε‖K‖‖u‖/‖f‖ in Euclidean norms; 0 without forces.
    fn rounding(&self, forces: &[f64], displacement: &[f64]) -> f64 {
        let greatest = forces.iter().fold(0.0, |greatest: f64, f| greatest.max(f.abs()));
        if greatest == 0.0 {
            return 0.0;
        }
        let norm = |vector: &[f64]| vector.iter().map(|v| (v / greatest).powi(2)).sum::<f64>().sqrt();
        self.row_rounding * norm(displacement) / norm(forces)
    }

    /// Elastic energy of the whole body, ½ f·u.
    pub fn elastic_energy(&self, forces: &[f64], displacement: &[f64]) -> f64 {
        0.5 * forces.iter().zip(displacement).map(|(f, u)| f * u).sum::<f64>()
    }

    /// Solves for any number of columns in place, in the frames of the support.
    pub(super) fn back_substitute(&self, factor: &Cholesky, columns: &mut [f64], workspace: &mut ElasticWorkspace) {
        let size = self.size();
        columns.chunks_exact_mut(size).for_each(|column| self.support.enter(column));
        factor.solve_in_place(columns, columns.len() / size, &mut workspace.scratch);
        columns.chunks_exact_mut(size).for_each(|column| self.support.leave(column));
    }

    /// Fills `residual` with f − K u and returns its norm relative to that of f; 0 without forces.
    fn residual(&self, forces: &[f64], displacement: &[f64], residual: &mut Vec<f64>) -> f64 {
        residual.resize(forces.len(), 0.0);
        self.stiffness.multiply(displacement, residual);
        self.unbalanced(forces, residual)
    }

    /// Turns K u in `product` into f − K u and returns its norm relative to that of f; 0 without forces.
    fn unbalanced(&self, forces: &[f64], product: &mut [f64]) -> f64 {
        let residual = product;
        residual.iter_mut().zip(forces).for_each(|(r, f)| *r = f - *r);
        self.support.drop_reactions(residual);
        let greatest = forces.iter().fold(0.0, |greatest: f64, f| greatest.max(f.abs()));
        if greatest == 0.0 {
            return 0.0;
        }
        // Scaled by the largest force before squaring, so that loads of any magnitude neither overflow nor underflow.
        let norm = |vector: &[f64]| vector.iter().map(|v| (v / greatest).powi(2)).sum::<f64>().sqrt();
        norm(residual) / norm(forces)
    }

    /// Fails if `array` does not have [`Self::unknowns`] entries. `what` names it in the error.
    pub(super) fn check_length(&self, what: &'static str, array: &[f64]) -> Result<(), ElasticityError> {
        match array.len() {
            found if found == self.unknowns() => Ok(()),
            found => Err(ElasticityError::OtherLattice { what, expected: self.unknowns(), found }),
        }
    }
}

/// Relative residual under a fixed pseudo-random load in equilibrium, and the displacement.
///
/// The load excites every mode. So a mechanism (a part connected by an edge or a node only, or not at all) shows even
/// if rounding let the factorization pass. Runs on the calling thread alone, because other threads may wait for it.
pub(super) fn probe(body: &Elasticity, factor: &Cholesky) -> (f64, Vec<f64>) {
    let mut stream = RandomStream::new(0, 0);
    let mut forces: Vec<f64> = (0..body.size()).map(|_| stream.uniform() - 0.5).collect();
    body.inertia.relieve(&mut forces);
    let mut displacement = forces.clone();
    body.back_substitute(factor, &mut displacement, &mut ElasticWorkspace::default());
    let mut product = vec![0.0; forces.len()];
    body.stiffness.multiply_alone(&displacement, &mut product);
    (body.unbalanced(&forces, &mut product), displacement)
}
