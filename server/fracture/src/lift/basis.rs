//! Growing orthonormal basis, extended block by block.
//!
//! Based on: J. W. Daniel, W. B. Gragg, L. Kaufman & G. W. Stewart, *Reorthogonalization and stable algorithms for
//! updating the Gram–Schmidt QR factorization* (Mathematics of Computation 30, 1976). Every projection is done twice. A
//! column that vanishes is replaced by a random one and its factor by zero, so rank loss does no harm.

use super::LiftError;
use crate::random::RandomStream;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Length of a column after the projections, over that before, below which it lies in the span of the basis.
const VANISHED: f64 = 1e-13;
/// Length of a column after the projection within its block, over that before, below which it is
/// projected on the whole basis again.
///
/// Such a column lost digits against the whole basis, too.
const CANCELED: f64 = 1e-3;
/// Random replacements tried for a vanished column. One fails only if the basis spans the whole space.
const REPLACEMENTS_MAX: usize = 3;

/// Orthonormal columns of length `order`, column-major in one allocation.
pub(super) struct Basis {
    order: usize,
    columns: Vec<f64>,
    random: RandomStream,
}

impl Basis {
    /// Creates a basis of the unit vector `first`, with memory for `capacity` columns.
    pub(super) fn new(first: &[f64], capacity: usize) -> Self {
        let mut columns = Vec::with_capacity(first.len() * capacity);
        columns.extend_from_slice(first);
        Self { order: first.len(), columns, random: RandomStream::new(0, 0) }
    }

    /// Length of a column.
    pub(super) fn order(&self) -> usize {
        self.order
    }

    /// Columns from `from` to the end, column-major.
    pub(super) fn tail(&self, from: usize) -> &[f64] {
        &self.columns[from * self.order..]
    }

    /// Columns `from .. from + count` as a matrix, `order × count`.
    pub(super) fn view(&self, from: usize, count: usize) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.columns[from * self.order..][..count * self.order], self.order, count)
    }

    /// Number of columns.
    pub(super) fn len(&self) -> usize {
        self.columns.len() / self.order
    }

    /// Removes the span of the basis from `block` (column-major, `order × width`), twice. Returns
    /// the coefficients, `len × width`.
    pub(super) fn project(&self, block: &mut [f64]) -> Mat<f64> {
        let width = block.len() / self.order;
        let basis = self.view(0, self.len());
        let mut sum = Mat::<f64>::zeros(self.len(), width);
        for _ in 0..2 {
            let mut block = MatMut::from_column_major_slice_mut(block, self.order, width);
            let mut coefficients = Mat::<f64>::zeros(self.len(), width);
            matmul(&mut coefficients, Accum::Replace, basis.transpose(), block.as_ref(), 1.0, Par::Seq);
            matmul(block.as_mut(), Accum::Add, basis, &coefficients, -1.0, Par::Seq);
            sum += coefficients;
        }
        sum
    }

    /// Appends an orthonormal basis Q of `block` and returns R with block = Q R, `width × width`.
    ///
    /// `block` must have passed [`Self::project`]. `lengths` are its columns' lengths before the projection; rounding
    /// errors are relative to them.
    ///
    /// # Errors
    /// [`LiftError::NotFinite`].
    pub(super) fn append(&mut self, block: &mut [f64], lengths: &[f64]) -> Result<Mat<f64>, LiftError> {
        let (start, width) = (self.len(), lengths.len());
        let mut factor = Mat::<f64>::zeros(width, width);
        for (index, column) in block.chunks_exact_mut(self.order).enumerate() {
            let before = length(column);
            let within = self.remove(start, column);
            within.iter().enumerate().for_each(|(row, value)| factor[(row, index)] = *value);
            if length(column) <= CANCELED * before {
                self.remove(0, column);
            }
            let after = length(column);
            if !after.is_finite() {
                return Err(LiftError::NotFinite);
            }
            if after > VANISHED * lengths[index] {
                factor[(index, index)] = after;
                column.iter_mut().for_each(|value| *value /= after);
                self.columns.extend_from_slice(column);
            } else {
                self.append_random()?;
            }
        }
        Ok(factor)
    }

    /// Appends a random unit column that is orthogonal to the basis.
    ///
    /// It depends only on the number of random columns drawn before from this basis.
    ///
    /// # Errors
    /// [`LiftError::TooFewNodes`] if the basis spans all of the space.
    pub(super) fn append_random(&mut self) -> Result<(), LiftError> {
        for _ in 0..REPLACEMENTS_MAX {
            let mut column: Vec<f64> = (0..self.order).map(|_| self.random.uniform() - 0.5).collect();
            let before = length(&column);
            self.remove(0, &mut column);
            let after = length(&column);
            if after > 1e-6 * before {
                column.iter_mut().for_each(|value| *value /= after);
                self.remove(0, &mut column);
                self.columns.extend_from_slice(&column);
                return Ok(());
            }
        }
        Err(LiftError::TooFewNodes { nodes: self.order, wanted: self.len(), needed: self.len() + 1 })
    }

    /// Replaces the columns `1 .. 1 + combination.nrows()` by their combinations, and drops all
    /// others but the last `kept` ones.
    pub(super) fn restart(&mut self, combination: MatRef<'_, f64>, kept: usize) {
        let width = combination.ncols();
        let mut combined = vec![0.0; self.order * width];
        let target = MatMut::from_column_major_slice_mut(&mut combined, self.order, width);
        matmul(target, Accum::Replace, self.view(1, combination.nrows()), combination, 1.0, Par::Seq);
        let last = self.columns.split_off((self.len() - kept) * self.order);
        self.columns.truncate(self.order);
        self.columns.extend_from_slice(&combined);
        self.columns.extend_from_slice(&last);
    }

    /// Removes columns `from ..` from one column, twice. Returns the coefficients.
    fn remove(&self, from: usize, column: &mut [f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.len() - from];
        for _ in 0..2 {
            for (total, own) in sum.iter_mut().zip(self.tail(from).chunks_exact(self.order)) {
                let coefficient: f64 = dot(own, column);
                column.iter_mut().zip(own).for_each(|(value, unit)| *value -= coefficient * unit);
                *total += coefficient;
            }
        }
        sum
    }
}

/// Euclidean length of a column.
pub(super) fn length(column: &[f64]) -> f64 {
    dot(column, column).sqrt()
}

/// Dot product by four interleaved partial sums: a fixed order that the compiler may vectorize.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_four, b_four) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a_four.remainder().iter().zip(b_four.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_four.zip(b_four) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}
