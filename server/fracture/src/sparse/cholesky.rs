//! Cholesky factors of sparse symmetric positive definite matrices, A = L Lᵀ, by faer.
//!
//! Based on: P. R. Amestoy, T. A. Davis & I. S. Duff, *An approximate minimum degree ordering algorithm* (SIAM J.
//! Matrix Anal. Appl. 17, 1996), applied to the graph of nodes and expanded to their components (same fill, about half
//! the time). faer computes the supernodal factorization and both triangular solves.
//!
//! A single-precision factor takes half the memory. A solve with it takes about half the time, because reading the
//! factor dominates. Its relative residual is about 1e-5; callers that need a smaller one refine the solution
//! iteratively (A. Buttari, J. Dongarra, J. Kurzak, P. Luszczek & S. Tomov, *Using mixed precision for sparse matrix
//! computations*, ACM TOMS 34, 2008).
//!
//! Every call is sequential, so results do not depend on the number of threads. Callers parallelize across right-hand
//! sides or bodies. faer selects its dense kernels by the processor's vector width and caches, so the last bits of a
//! factor can differ between machines.

use super::{SparseError, SymmetricMatrix};
use crate::dense::on_own_thread;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::RealField;
use faer::{Conj, MatMut, Par, Side, Spec};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Symbolic factorization: the ordering and the pattern of L, without numbers. Cheap to clone.
#[derive(Clone, Debug)]
pub struct SymbolicFactor {
    /// Pattern of L.
    pub(super) pattern: Arc<SymbolicCholesky<u32>>,
    /// New → old row.
    pub(super) forward: Arc<[u32]>,
}

/// Floating-point precision of the entries of a factor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Double precision.
    #[default]
    F64,
    /// Single precision.
    F32,
}

impl Precision {
    /// Bytes per entry.
    pub fn bytes(self) -> usize {
        match self {
            Self::F64 => size_of::<f64>(),
            Self::F32 => size_of::<f32>(),
        }
    }
}

/// Numeric factor L of one matrix, with its ordering. Immutable, so solves may run concurrently.
#[derive(Debug)]
pub struct Cholesky {
    symbolic: SymbolicFactor,
    values: Values,
}

#[derive(Debug)]
enum Values {
    F64(Vec<f64>),
    F32(Vec<f32>),
}

/// Working memory of solves. Reused between calls; nothing is allocated once it is large enough.
#[derive(Default)]
pub struct SolveScratch {
    buffer: Option<MemBuffer>,
    narrow: Vec<f32>,
}

fn stack(buffer: &mut Option<MemBuffer>, need: StackReq) -> &mut MemStack {
    if !buffer.as_mut().is_some_and(|buffer| MemStack::new(buffer).can_hold(need)) {
        *buffer = None;
    }
    MemStack::new(buffer.get_or_insert_with(|| MemBuffer::new(need)))
}

impl SymbolicFactor {
    /// Orders `matrix` and finds the pattern of its factor. Takes about a tenth of the time of the factor itself.
    ///
    /// # Errors
    /// [`SparseError::Empty`], [`SparseError::TooLarge`].
    pub fn analyze<const B: usize>(matrix: &SymmetricMatrix<B>) -> Result<Self, SparseError> {
        Self::of(matrix, &Lower::new(matrix))
    }

    fn of<const B: usize>(matrix: &SymmetricMatrix<B>, lower: &Lower) -> Result<Self, SparseError> {
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

    /// Factors `matrix`, which must have the analyzed pattern.
    ///
    /// Cannot be interrupted: 3 000 nodes with B = 3 take about a tenth of a second.
    ///
    /// # Errors
    /// [`SparseError::NotPositiveDefinite`], [`SparseError::TooLarge`]. A singular matrix may pass: rounding can leave its last
    /// pivot positive.
    ///
    /// # Panics
    /// If the matrix has another size.
    pub fn factor<const B: usize>(
        &self,
        matrix: &SymmetricMatrix<B>,
        precision: Precision,
    ) -> Result<Cholesky, SparseError> {
        assert_eq!(matrix.size(), self.pattern.nrows(), "the matrix has the analyzed pattern");
        let lower = Lower::new(matrix);
        match precision {
            Precision::F64 => self.double(&lower),
            Precision::F32 => {
                let entries: Vec<f32> = lower.values.iter().map(|value| *value as f32).collect();
                Ok(Cholesky { symbolic: self.clone(), values: Values::F32(self.numeric(&lower, &entries)?) })
            }
        }
    }

    fn double(&self, lower: &Lower) -> Result<Cholesky, SparseError> {
        Ok(Cholesky { symbolic: self.clone(), values: Values::F64(self.numeric(lower, &lower.values)?) })
    }

    /// Entries of L, for a matrix that has `entries` in the positions of `lower`.
    fn numeric<T: RealField>(&self, lower: &Lower, entries: &[T]) -> Result<Vec<T>, SparseError> {
        let pattern = &self.pattern;
        let mut values = vec![T::zero_impl(); pattern.len_val()];
        let need = pattern.factorize_numeric_llt_scratch::<T>(Par::Seq, Spec::default());
        let mut memory = MemBuffer::try_new(need).map_err(|_| SparseError::TooLarge { size: lower.size })?;
        let entries = SparseColMatRef::new(lower.pattern(), entries);
        let mut outcome = Ok(());
        on_own_thread(|| {
            outcome = pattern
                .factorize_numeric_llt(
                    &mut values,
                    entries,
                    Side::Lower,
                    LltRegularization::default(),
                    Par::Seq,
                    MemStack::new(&mut memory),
                    Spec::default(),
                )
                .map(|_| ());
        });
        outcome.map_err(|LltError::NonPositivePivot { index }| SparseError::NotPositiveDefinite {
            pivot: original_row(pattern, &self.forward, index),
        })?;
        Ok(values)
    }

    /// Multiplications and additions to compute a factor: the sum of the squared numbers of entries of its columns.
    pub fn factor_operations(&self) -> u64 {
        // Of `width` columns, the first has `height` entries, and each later one has one less.
        let columns = |width: u64, height: u64| (0..width).map(|column| (height - column).pow(2)).sum::<u64>();
        match self.pattern.raw() {
            SymbolicCholeskyRaw::Simplicial(own) => {
                own.col_ptr().windows(2).map(|ends| columns(1, u64::from(ends[1] - ends[0]))).sum()
            }
            SymbolicCholeskyRaw::Supernodal(own) => {
                let widths = own.supernode_begin().iter().zip(own.supernode_end()).map(|(begin, end)| end - begin);
                let below = own.col_ptr_for_row_idx().windows(2).map(|ends| ends[1] - ends[0]);
                widths.zip(below).map(|(width, below)| columns(width.into(), (width + below).into())).sum()
            }
        }
    }

    /// Bytes that a factor holds: its entries, their indices, and the ordering in both directions.
    ///
    /// faer keeps the adjacency of supernodes private, so it is not counted: one index per block of entries.
    pub fn factor_bytes(&self, precision: Precision) -> usize {
        let indices = match self.pattern.raw() {
            SymbolicCholeskyRaw::Simplicial(columns) => columns.row_idx().len() + 2 * columns.col_ptr().len(),
            SymbolicCholeskyRaw::Supernodal(nodes) => {
                nodes.row_idx().len() + 3 * nodes.col_ptr_for_row_idx().len() + nodes.supernode_begin().len()
            }
        };
        let orderings = 2 * self.pattern.nrows() + self.forward.len();
        precision.bytes() * self.pattern.len_val() + size_of::<u32>() * (indices + orderings)
    }
}

impl Cholesky {
    /// Orders and factors `matrix`.
    ///
    /// # Errors
    /// As [`SymbolicFactor::analyze`] and [`SymbolicFactor::factor`].
    pub fn factor<const B: usize>(matrix: &SymmetricMatrix<B>) -> Result<Self, SparseError> {
        let lower = Lower::new(matrix);
        SymbolicFactor::of(matrix, &lower)?.double(&lower)
    }

    /// Number of scalar rows, n.
    pub fn size(&self) -> usize {
        self.symbolic.pattern.nrows()
    }

    /// Precision of the entries.
    pub fn precision(&self) -> Precision {
        match self.values {
            Values::F64(_) => Precision::F64,
            Values::F32(_) => Precision::F32,
        }
    }

    /// Solves A x = b in place for each of the `k` columns of `x` (n × k, column-major).
    ///
    /// Accuracy is that of the factor's precision. Eight columns at once take two to three times as long as one.
    ///
    /// # Panics
    /// If `x` is not of length n · k.
    pub fn solve_in_place(&self, x: &mut [f64], k: usize, scratch: &mut SolveScratch) {
        let size = self.size();
        assert_eq!(x.len(), size * k, "x is n × k, column-major");
        if k == 0 {
            return;
        }
        let SolveScratch { buffer, narrow } = scratch;
        match &self.values {
            Values::F64(values) => self.substitute(values, x, k, buffer),
            Values::F32(values) => {
                narrow.clear();
                // Scaled by the largest entry, so that right-hand sides of any magnitude neither
                // overflow nor underflow in f32.
                let greatest = x.iter().fold(0.0, |greatest: f64, x| greatest.max(x.abs()));
                if greatest > 0.0 {
                    narrow.extend(x.iter().map(|x| (x / greatest) as f32));
                    self.substitute(values, narrow, k, buffer);
                    x.iter_mut().zip(narrow).for_each(|(x, narrow)| *x = f64::from(*narrow) * greatest);
                }
            }
        }
    }

    fn substitute<T: RealField>(&self, values: &[T], x: &mut [T], k: usize, buffer: &mut Option<MemBuffer>) {
        let pattern = &self.symbolic.pattern;
        let stack = stack(buffer, pattern.solve_in_place_scratch::<T>(k, Par::Seq));
        let columns = MatMut::from_column_major_slice_mut(x, self.size(), k);
        LltRef::new(pattern, values).solve_in_place_with_conj(Conj::No, columns, Par::Seq, stack);
    }
}

/// Scalar lower triangle of a matrix in compressed columns, rows ascending.
pub(super) struct Lower {
    /// Number of scalar rows.
    pub(super) size: usize,
    offsets: Vec<u32>,
    rows: Vec<u32>,
    /// Entries of the triangle, column by column.
    pub(super) values: Vec<f64>,
}

impl Lower {
    /// Extracts the lower triangle of `matrix`.
    pub(super) fn new<const B: usize>(matrix: &SymmetricMatrix<B>) -> Self {
        let size = matrix.size();
        let mut lower = Self { size, offsets: vec![0], rows: Vec::new(), values: Vec::new() };
        for node in 0..matrix.nodes() {
            let (columns, blocks) = matrix.row(node);
            for component in 0..B {
                // By symmetry, column (node, component) equals row (node, component) from the diagonal on.
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

    /// Pattern of the triangle, as faer reads it.
    pub(super) fn pattern(&self) -> SymbolicSparseColMatRef<'_, u32> {
        SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.offsets, None, &self.rows)
    }
}

/// Approximate minimum degree order of the node graph, expanded to components: (new → old, old → new).
fn order<const B: usize>(matrix: &SymmetricMatrix<B>) -> Option<(Vec<u32>, Vec<u32>)> {
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

/// The caller's row of pivot `index`.
///
/// faer counts pivots from 1 in its simplicial code and from 0 in its supernodal code.
fn original_row(symbolic: &SymbolicCholesky<u32>, forward: &[u32], index: usize) -> usize {
    let position = match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(_) => index.saturating_sub(1),
        SymbolicCholeskyRaw::Supernodal(_) => index,
    };
    forward.get(position).map_or(index, |&row| row as usize)
}
