//! A = L Lᵀ for symmetric positive definite sparse A, by faer.
//!
//! Based on: P. R. Amestoy, T. A. Davis & I. S. Duff, *An approximate minimum degree ordering algorithm* (SIAM J. Matrix
//! Anal. Appl. 17, 1996), run on the graph of nodes and expanded to their components (same fill, about half the time);
//! the supernodal factorisation and both triangular solves are faer's.
//!
//! Every call is sequential (parallelise across right-hand sides or bodies), so results do not depend on the number of
//! threads. faer picks its dense kernels by the processor's vector width and caches: between unlike machines the last
//! bits of a factor can differ.

use super::{SparseError, Symmetric};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};
use std::sync::Arc;

/// The pattern of L and the ordering of one pattern of a matrix: all of a factor but its numbers. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Symbolic {
    pub(super) pattern: Arc<SymbolicCholesky<u32>>,
    /// New → old row.
    pub(super) forward: Arc<[u32]>,
}

/// The factor L of one matrix, with its ordering. Immutable: solves may run at the same time.
#[derive(Debug)]
pub struct Cholesky {
    symbolic: Symbolic,
    values: Vec<f64>,
}

/// Memory of a solve, kept from one to the next: once it is large enough nothing is allocated.
#[derive(Default)]
pub struct SolveScratch(Option<MemBuffer>);

impl SolveScratch {
    fn stack(&mut self, need: StackReq) -> &mut MemStack {
        if !self.0.as_mut().is_some_and(|buffer| MemStack::new(buffer).can_hold(need)) {
            self.0 = None;
        }
        MemStack::new(self.0.get_or_insert_with(|| MemBuffer::new(need)))
    }
}

impl Symbolic {
    /// Orders `matrix` and finds where its factor has entries; about a tenth of the time of the factor itself.
    ///
    /// # Errors
    /// [`SparseError::Empty`], [`SparseError::TooLarge`].
    pub fn analyse<const B: usize>(matrix: &Symmetric<B>) -> Result<Self, SparseError> {
        Self::of(matrix, &Lower::new(matrix))
    }

    fn of<const B: usize>(matrix: &Symmetric<B>, lower: &Lower) -> Result<Self, SparseError> {
        let size = matrix.size();
        if size == 0 {
            return Err(SparseError::Empty);
        }
        let too_large = SparseError::TooLarge { size };
        let (forward, inverse) = order(matrix).ok_or(too_large)?;
        let pattern = factorize_symbolic_cholesky(
            lower.pattern(),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, size)),
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| too_large)?;
        Ok(Self { pattern: Arc::new(pattern), forward: forward.into() })
    }

    /// The factor of `matrix`, which has the analysed pattern. Cannot be interrupted: 3 000 nodes with B = 3 take about a
    /// tenth of a second.
    ///
    /// # Errors
    /// [`SparseError::NotPositiveDefinite`], [`SparseError::TooLarge`]. A singular matrix may pass: rounding can leave its last
    /// pivot positive.
    ///
    /// # Panics
    /// If the matrix has another size.
    pub fn factor<const B: usize>(&self, matrix: &Symmetric<B>) -> Result<Cholesky, SparseError> {
        assert_eq!(matrix.size(), self.pattern.nrows(), "the analysed pattern");
        self.numeric(&Lower::new(matrix))
    }

    fn numeric(&self, lower: &Lower) -> Result<Cholesky, SparseError> {
        let pattern = &self.pattern;
        let mut values = vec![0.0; pattern.len_val()];
        let need = pattern.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default());
        let mut memory = MemBuffer::try_new(need).map_err(|_| SparseError::TooLarge { size: lower.size })?;
        let entries = SparseColMatRef::new(lower.pattern(), &lower.values);
        pattern
            .factorize_numeric_llt(
                &mut values,
                entries,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Spec::default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| SparseError::NotPositiveDefinite {
                pivot: original_row(pattern, &self.forward, index),
            })?;
        Ok(Cholesky { symbolic: self.clone(), values })
    }

    /// Bytes that a factor holds: its entries, where they stand, and the ordering both ways. Left out are the neighbours among
    /// supernodes, which faer keeps to itself: one index per block of entries.
    pub fn factor_bytes(&self) -> usize {
        let indices = match self.pattern.raw() {
            SymbolicCholeskyRaw::Simplicial(columns) => columns.row_idx().len() + 2 * columns.col_ptr().len(),
            SymbolicCholeskyRaw::Supernodal(nodes) => {
                nodes.row_idx().len() + 3 * nodes.col_ptr_for_row_idx().len() + nodes.supernode_begin().len()
            }
        };
        let orderings = 2 * self.pattern.nrows() + self.forward.len();
        size_of::<f64>() * self.pattern.len_val() + size_of::<u32>() * (indices + orderings)
    }
}

impl Cholesky {
    /// Orders and factors `matrix`.
    ///
    /// # Errors
    /// As [`Symbolic::analyse`] and [`Symbolic::factor`].
    pub fn factor<const B: usize>(matrix: &Symmetric<B>) -> Result<Self, SparseError> {
        let lower = Lower::new(matrix);
        Symbolic::of(matrix, &lower)?.numeric(&lower)
    }

    /// Number of scalar rows, n.
    pub fn size(&self) -> usize {
        self.symbolic.pattern.nrows()
    }

    /// Number of stored entries of L, explicit zeros of its supernodes included; 8 bytes each.
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// x ← A⁻¹ x for each of the `k` columns of `x` (n × k, column-major). Eight columns at once cost two to three times one.
    ///
    /// # Panics
    /// If `x` is not of length n · k.
    pub fn solve_in_place(&self, x: &mut [f64], k: usize, scratch: &mut SolveScratch) {
        let size = self.size();
        assert_eq!(x.len(), size * k, "n × k column-major");
        if k == 0 {
            return;
        }
        let stack = scratch.stack(self.symbolic.pattern.solve_in_place_scratch::<f64>(k, Par::Seq));
        let columns = MatMut::from_column_major_slice_mut(x, size, k);
        LltRef::new(&self.symbolic.pattern, &self.values).solve_in_place_with_conj(Conj::No, columns, Par::Seq, stack);
    }
}

/// The scalar lower triangle, columns compressed, rows ascending.
pub(super) struct Lower {
    pub(super) size: usize,
    offsets: Vec<u32>,
    rows: Vec<u32>,
    pub(super) values: Vec<f64>,
}

impl Lower {
    pub(super) fn new<const B: usize>(matrix: &Symmetric<B>) -> Self {
        let size = matrix.size();
        let mut lower = Self { size, offsets: vec![0], rows: Vec::new(), values: Vec::new() };
        for node in 0..matrix.nodes() {
            let (columns, blocks) = matrix.row(node);
            for component in 0..B {
                // By symmetry, column (node, component) is that row, read from the diagonal on.
                let own = (node * B + component) as u32;
                for (&column, block) in columns.iter().zip(blocks) {
                    for other in 0..B {
                        let row = column * B as u32 + other as u32;
                        if row >= own {
                            lower.rows.push(row);
                            lower.values.push(block[(component, other)]);
                        }
                    }
                }
                lower.offsets.push(lower.rows.len() as u32);
            }
        }
        lower
    }

    pub(super) fn pattern(&self) -> SymbolicSparseColMatRef<'_, u32> {
        SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.offsets, None, &self.rows)
    }
}

/// Approximate minimum degree on the node graph, expanded to components: (new → old, old → new).
fn order<const B: usize>(matrix: &Symmetric<B>) -> Option<(Vec<u32>, Vec<u32>)> {
    let nodes = matrix.nodes();
    let (mut offsets, mut rows) = (vec![0], Vec::new());
    for node in 0..nodes {
        rows.extend(matrix.row(node).0.iter().filter(|&&column| column as usize > node));
        offsets.push(rows.len() as u32);
    }
    let graph = SymbolicSparseColMatRef::new_checked(nodes, nodes, &offsets, None, &rows);
    let (mut forward, mut inverse) = (vec![0; nodes], vec![0; nodes]);
    let mut memory = MemBuffer::try_new(amd::order_scratch::<u32>(nodes, rows.len())).ok()?;
    let control = amd::Control::default();
    amd::order(&mut forward, &mut inverse, graph, control, MemStack::new(&mut memory)).ok()?;
    let expand = |order: Vec<u32>| -> Vec<u32> {
        order.iter().flat_map(|&node| (0..B as u32).map(move |component| node * B as u32 + component)).collect()
    };
    Some((expand(forward), expand(inverse)))
}

/// The caller's row of pivot `index`; faer counts from 1 in its simplicial code and from 0 in its supernodal code.
fn original_row(symbolic: &SymbolicCholesky<u32>, forward: &[u32], index: usize) -> usize {
    let position = match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(_) => index.saturating_sub(1),
        SymbolicCholeskyRaw::Supernodal(_) => index,
    };
    forward.get(position).map_or(index, |&row| row as usize)
}
