//! Number of negative eigenvalues of a symmetric matrix, without computing eigenvalues.
//!
//! Based on: J. J. Sylvester's law of inertia (*A demonstration of the theorem that every homogeneous quadratic
//! polynomial is reducible by real orthogonal substitutions …*, Philosophical Magazine 4, 1852); N. J. Higham,
//! *Accuracy and Stability of Numerical Algorithms* (2002), theorem 9.3.
//!
//! By that theorem, elimination without pivoting yields the exact factors of A + E with |E| ≤ γ |L||D||Lᵀ| entry by
//! entry. Here γ is the number of terms in the longest row times the unit roundoff. Let W be a diagonal matrix of
//! weights and B = W^(−½)|L||D|^½. Then ‖W^(−½) E W^(−½)‖ ≤ γ ‖B‖² ≤ γ ‖B‖₁ ‖B‖_∞. One pass over the factor computes
//! both norms and the signs of the pivots.

use super::cholesky::Lower;
use super::{SymbolicFactor, SymmetricMatrix};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::{Par, Side, Spec};

/// Rounding errors per entry of a factor in addition to those of its inner product.
const MORE_TERMS: usize = 4;

/// Number of negative eigenvalues, and the perturbation of the matrix that they belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signature {
    /// Number of negative eigenvalues of A + E.
    pub negative: usize,
    /// Upper bound of |λ| over all E x = λ W x.
    pub rounding: f64,
}

impl SymbolicFactor {
    /// Signature of `matrix`, from the pivots of A = L D Lᵀ.
    ///
    /// `matrix` has the analyzed pattern and may be indefinite. `weights` is the positive diagonal of W, one entry per
    /// scalar row. Returns `None` if a pivot is zero or memory does not suffice.
    ///
    /// # Panics
    /// If the matrix has another size.
    pub fn signature<const B: usize>(&self, matrix: &SymmetricMatrix<B>, weights: &[f64]) -> Option<Signature> {
        assert_eq!(matrix.size(), self.pattern.nrows(), "the matrix has the analyzed pattern");
        let (pattern, lower) = (&self.pattern, Lower::new(matrix));
        let mut values = vec![0.0; pattern.len_val()];
        let need = pattern.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default());
        let mut memory = MemBuffer::try_new(need).ok()?;
        let entries = SparseColMatRef::new(lower.pattern(), &lower.values);
        let regularization = LdltRegularization::default();
        let stack = MemStack::new(&mut memory);
        pattern
            .factorize_numeric_ldlt(&mut values, entries, Side::Lower, regularization, Par::Seq, stack, Spec::default())
            .ok()?;
        let roots = self.forward.iter().map(|&row| weights[row as usize].sqrt()).collect();
        let mut pass =
            Pass { roots, negative: 0, rows: vec![0.0; lower.size], terms: vec![0; lower.size], widest: 0.0 };
        match pattern.raw() {
            SymbolicCholeskyRaw::Simplicial(columns) => {
                for (column, ends) in columns.col_ptr().windows(2).enumerate() {
                    let own = ends[0] as usize..ends[1] as usize;
                    let rows = columns.row_idx()[own.clone()].iter().map(|&row| row as usize);
                    pass.column(column, values[own.start], rows.zip(values[own].iter().copied()).skip(1));
                }
            }
            SymbolicCholeskyRaw::Supernodal(nodes) => {
                let factor = SupernodalLdltRef::new(nodes, &values);
                for node in (0..nodes.n_supernodes()).map(|node| factor.supernode(node)) {
                    let (start, block) = (node.start(), node.val());
                    let row = |k: usize| match k.checked_sub(block.ncols()) {
                        None => start + k,
                        Some(below) => node.pattern()[below] as usize,
                    };
                    for k in 0..block.ncols() {
                        let below = (k + 1..block.nrows()).map(|below| (row(below), block[(below, k)]));
                        pass.column(start + k, block[(k, k)], below);
                    }
                }
            }
        }
        Some(pass.signature())
    }
}

/// Accumulator of one pass over the columns of L and D.
struct Pass {
    /// W^½, in elimination order.
    roots: Vec<f64>,
    negative: usize,
    /// Sum of each row of B so far.
    rows: Vec<f64>,
    /// Number of entries of each row of L so far.
    terms: Vec<usize>,
    /// ‖B‖₁ so far.
    widest: f64,
}

impl Pass {
    /// Adds a pivot and the entries of L below it.
    fn column(&mut self, column: usize, pivot: f64, below: impl Iterator<Item = (usize, f64)>) {
        self.negative += usize::from(pivot < 0.0);
        let (root, mut sum) = (pivot.abs().sqrt(), 0.0);
        for (row, entry) in std::iter::once((column, 1.0)).chain(below) {
            let own = entry.abs() * root / self.roots[row];
            sum += own;
            self.rows[row] += own;
            self.terms[row] += 1;
        }
        self.widest = self.widest.max(sum);
    }

    fn signature(self) -> Signature {
        let longest = self.terms.into_iter().max().unwrap_or(0) + MORE_TERMS;
        let tallest = self.rows.into_iter().fold(0.0, f64::max);
        Signature { negative: self.negative, rounding: longest as f64 * f64::EPSILON * self.widest * tallest }
    }
}
