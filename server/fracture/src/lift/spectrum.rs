//! Lowest eigenpairs L φ = λ M φ of a lattice (Neumann) or of its boundary surface, without the constants.
//!
//! Based on: T. Ericsson & A. Ruhe, *The spectral transformation Lanczos method for the numerical solution of large
//! sparse generalized symmetric eigenvalue problems* (Mathematics of Computation 35, 1980). The pairs (λ, φ) are those
//! of C = M^½ (L + σM)⁻¹ M^½ with θ = 1/(λ + σ) and M^½ φ, which are well separated at the low end.

use super::boundary::BoundarySurface;
use super::laplacian::Laplacian;
use super::{LiftError, MODES_MAX, gap, lanczos};
use crate::cancel_token::CancelToken;
use crate::dense;
use crate::lattice::Lattice;
use crate::sparse::{Cholesky, SolveScratch};
use faer::Mat;
use rayon::prelude::*;

/// Largest number of nodes whose eigenpairs are computed densely: as fast, and without a limit on the number of pairs.
const DENSE_MAX: usize = 300;
/// Shift σ as a share of an upper bound of the smallest eigenvalue.
///
/// With it, L + σM is as well conditioned as L on the complement of the constants, and the low end
/// of the spectrum stays spread.
const SHIFT: f64 = 0.05;
/// Largest residual of an accepted pair; see [`Spectrum::residual`].
const RESIDUAL_MAX: f64 = 1e-6;

/// Eigenpairs of a lattice or a surface, without the constants.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Eigenvalues λ_k, ascending, positive; local length⁻².
    pub eigenvalues: Vec<f64>,
    /// Eigenfunctions φ_k, function-major, `eigenvalues.len() × nodes`.
    ///
    /// φᵀ M φ = 1 with M the lumped volumes or areas. The sign and, within an eigenspace, the basis are arbitrary but
    /// always the same for the same lattice.
    pub functions: Vec<f64>,
    /// True if the last eigenvalue ends the spectrum.
    pub whole: bool,
    /// Largest ‖L φ − λ M φ‖ / λ over the pairs, in the norm of M⁻¹.
    ///
    /// It bounds the relative distance of each λ to an exact eigenvalue.
    pub residual: f64,
}

impl Spectrum {
    /// Computes the `count` lowest pairs of a lattice.
    ///
    /// # Errors
    /// [`LiftError::TooFewNodes`] if the lattice has no more than `count` nodes, [`LiftError::TooManyModes`],
    /// [`LiftError::DegenerateTet`], [`LiftError::Disconnected`], [`LiftError::Sparse`], [`LiftError::NotConverged`],
    /// [`LiftError::NotFinite`], [`LiftError::Canceled`].
    pub fn compute(lattice: &Lattice, count: usize, token: &CancelToken) -> Result<Self, LiftError> {
        token.check()?;
        Self::of(&Laplacian::new(lattice)?, count, token)
    }

    /// Computes the `count` lowest pairs of the cotangent Laplacian of a closed surface.
    ///
    /// Its shells are independent: every function lives on one shell and vanishes on the others. The constant of each
    /// shell is left out.
    ///
    /// # Errors
    /// As [`Self::compute`], with [`LiftError::DegenerateFace`] instead of a tetrahedron's.
    pub fn of_surface(surface: &BoundarySurface, count: usize, token: &CancelToken) -> Result<Self, LiftError> {
        let (nodes, shells) = (surface.nodes.len(), surface.shells());
        if count + shells.len() > nodes || shells.is_empty() {
            return Err(LiftError::TooFewNodes { nodes, wanted: count, needed: count + shells.len().max(1) });
        }
        let mut spectra = Vec::with_capacity(shells.len());
        for shell in &shells {
            token.check()?;
            let laplacian = Laplacian::of_triangles(&shell.positions, &shell.triangles)?;
            spectra.push(Self::of(&laplacian, count.min(shell.positions.len() - 1), token)?);
        }
        let mut order: Vec<(f64, usize, usize)> = Vec::new();
        for (shell, spectrum) in spectra.iter().enumerate() {
            order.extend(spectrum.eigenvalues.iter().enumerate().map(|(k, value)| (*value, shell, k)));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        order.truncate(count);
        let mut functions = vec![0.0; count * nodes];
        for (row, &(_, shell, k)) in functions.chunks_exact_mut(nodes).zip(&order) {
            for (&node, value) in shells[shell].nodes.iter().zip(spectra[shell].function(k)) {
                row[node as usize] = *value;
            }
        }
        let residual = spectra.iter().fold(0.0, |worst: f64, spectrum| worst.max(spectrum.residual));
        let eigenvalues = order.iter().map(|entry| entry.0).collect();
        Ok(Self { eigenvalues, functions, whole: count + shells.len() == nodes, residual })
    }

    /// Computes the `count` lowest pairs of a connected Laplacian.
    fn of(laplacian: &Laplacian<'_>, count: usize, token: &CancelToken) -> Result<Self, LiftError> {
        let nodes = laplacian.order();
        if count >= nodes {
            return Err(LiftError::TooFewNodes { nodes, wanted: count, needed: count + 1 });
        }
        if count > MODES_MAX + gap::WINDOW + 1 {
            return Err(LiftError::TooManyModes { modes: count, max: MODES_MAX + gap::WINDOW + 1 });
        }
        let functions =
            if nodes <= DENSE_MAX { by_dense(laplacian, count)? } else { by_lanczos(laplacian, count, token)? };
        Self::verified(laplacian, functions, count)
    }

    /// Values of φ_k on the nodes.
    pub fn function(&self, k: usize) -> &[f64] {
        let nodes = self.functions.len() / self.eigenvalues.len();
        &self.functions[k * nodes..][..nodes]
    }

    /// Computes eigenvalues as Rayleigh quotients of functions of unit mass, and checks their residuals.
    fn verified(laplacian: &Laplacian<'_>, functions: Vec<f64>, count: usize) -> Result<Self, LiftError> {
        let pairs: Vec<(f64, f64)> =
            functions.par_chunks_exact(laplacian.order()).map(|function| quotient(laplacian, function)).collect();
        let converged = pairs.iter().take_while(|(value, residual)| *value > 0.0 && *residual <= RESIDUAL_MAX).count();
        if converged < count {
            return Err(LiftError::NotConverged { converged, wanted: count });
        }
        let residual = pairs.iter().fold(0.0, |worst: f64, pair| worst.max(pair.1));
        let eigenvalues = pairs.into_iter().map(|pair| pair.0).collect();
        Ok(Self { eigenvalues, functions, whole: count + 1 == laplacian.order(), residual })
    }
}

/// λ = φᵀ L φ, and ‖L φ − λ M φ‖ / λ in the norm of M⁻¹.
fn quotient(laplacian: &Laplacian<'_>, function: &[f64]) -> (f64, f64) {
    let mut image = vec![0.0; function.len()];
    laplacian.stiffness.multiply(function, &mut image);
    let value: f64 = function.iter().zip(&image).map(|(x, y)| x * y).sum();
    let entries = function.iter().zip(&image).zip(&laplacian.mass);
    let squared: f64 = entries.map(|((x, y), mass)| (y - value * mass * x).powi(2) / mass).sum();
    (value, squared.sqrt() / value)
}

/// Lowest pairs of M^-½ L M^-½ by a dense solver, without the constant; function-major.
fn by_dense(laplacian: &Laplacian<'_>, count: usize) -> Result<Vec<f64>, LiftError> {
    let roots: Vec<f64> = laplacian.mass.iter().map(|mass| mass.sqrt()).collect();
    let mut matrix = Mat::<f64>::zeros(roots.len(), roots.len());
    for row in 0..roots.len() {
        let (columns, entries) = laplacian.stiffness.row(row);
        for (&column, entry) in columns.iter().zip(entries) {
            matrix[(row, column as usize)] = entry.x / (roots[row] * roots[column as usize]);
        }
    }
    let pairs = dense::symmetric(matrix.as_ref())?;
    let columns = (1..=count).flat_map(|k| pairs.vectors.col(k).iter().zip(&roots).map(|(x, root)| x / root));
    Ok(columns.collect())
}

/// Lowest pairs by shift-inverted Lanczos; function-major.
fn by_lanczos(laplacian: &Laplacian<'_>, count: usize, token: &CancelToken) -> Result<Vec<f64>, LiftError> {
    let roots: Vec<f64> = laplacian.mass.iter().map(|mass| mass.sqrt()).collect();
    let length = roots.iter().map(|root| root * root).sum::<f64>().sqrt();
    let constant: Vec<f64> = roots.iter().map(|root| root / length).collect();
    let shift = SHIFT * laplacian.smallest_bound();
    let mut shifted = laplacian.stiffness.clone();
    shifted.add_diagonal(&laplacian.mass.iter().map(|mass| shift * mass).collect::<Vec<f64>>());
    let cholesky = Cholesky::factor(&shifted)?;
    let mut scratch = SolveScratch::default();
    let apply = |block: &mut [f64], width: usize| {
        scale(block, &roots);
        cholesky.solve_in_place(block, width, &mut scratch);
        scale(block, &roots);
    };
    let mut functions = lanczos::largest(&constant, count, apply, token)?;
    let inverse: Vec<f64> = roots.iter().map(|root| 1.0 / root).collect();
    scale(&mut functions, &inverse);
    Ok(functions)
}

/// Multiplies every column of a column-major block by a diagonal.
fn scale(block: &mut [f64], diagonal: &[f64]) {
    for column in block.chunks_exact_mut(diagonal.len()) {
        column.iter_mut().zip(diagonal).for_each(|(value, factor)| *value *= factor);
    }
}
