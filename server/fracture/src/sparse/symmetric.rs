//! Symmetric block-sparse matrices with a fixed order of summation.

use super::SparseError;
use crate::memory::held;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

/// Minimum number of block rows per parallel task. Smaller matrices are not worth splitting.
const ROWS_PER_TASK_MIN: usize = 1024;

/// Symmetric matrix of B × B blocks, one block row per node.
///
/// Both triangles are stored in compressed rows with ascending columns. The diagonal block is always present. Scalar
/// row = node · B + component.
///
/// Every entry is summed in the order of the elements, so the bits do not depend on the number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricMatrix<const B: usize = 1> {
    /// First block of each block row, and the total: length `nodes + 1`.
    offsets: Vec<u32>,
    /// Node index of each block, ascending within a row.
    columns: Vec<u32>,
    /// The blocks, parallel to `columns`.
    blocks: Vec<SMatrix<f64, B, B>>,
}

/// One block row under construction: columns and blocks.
type Row<const B: usize> = (Vec<u32>, Vec<SMatrix<f64, B, B>>);

impl<const B: usize> SymmetricMatrix<B> {
    /// Assembles the sum of element matrices.
    ///
    /// `block(tet, i, j)` is the B × B block that tetrahedron `tet` adds between its local nodes `i` and `j` (0..4). It
    /// must be the transpose of `block(tet, j, i)`.
    ///
    /// # Errors
    /// [`SparseError::IndexOutOfRange`] and [`SparseError::NonFinite`].
    pub fn assemble(
        nodes: usize,
        tets: &[[u32; 4]],
        block: impl Fn(usize, usize, usize) -> SMatrix<f64, B, B> + Sync,
    ) -> Result<Self, SparseError> {
        if let Some(&index) = tets.iter().flatten().find(|&&node| node as usize >= nodes) {
            return Err(SparseError::IndexOutOfRange { index: index as usize, nodes });
        }
        let (starts, incident) = incidence(nodes, tets);
        let rows: Vec<Row<B>> = (0..nodes)
            .into_par_iter()
            .with_min_len(256)
            .map(|node| {
                let around = &incident[starts[node] as usize..starts[node + 1] as usize];
                assemble_row(node as u32, around, tets, &block)
            })
            .collect();
        Self::from_rows(rows)
    }

    fn from_rows(rows: Vec<Row<B>>) -> Result<Self, SparseError> {
        let total = rows.iter().map(|row| row.0.len()).sum();
        let (mut offsets, mut columns) = (vec![0], Vec::with_capacity(total));
        let mut blocks = Vec::with_capacity(total);
        for (row_columns, row_blocks) in rows {
            columns.extend(row_columns);
            blocks.extend(row_blocks);
            offsets.push(columns.len() as u32);
        }
        let matrix = Self { offsets, columns, blocks };
        matrix.check_finite()?;
        Ok(matrix)
    }

    fn check_finite(&self) -> Result<(), SparseError> {
        for node in 0..self.nodes() {
            let (columns, blocks) = self.row(node);
            for (&column, block) in columns.iter().zip(blocks) {
                if let Some(at) = block.iter().position(|entry| !entry.is_finite()) {
                    let (row, column) = (node * B + at % B, column as usize * B + at / B);
                    return Err(SparseError::NonFinite { row, column });
                }
            }
        }
        Ok(())
    }

    /// Number of block rows.
    pub fn nodes(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Number of scalar rows, n = `nodes · B`.
    pub fn size(&self) -> usize {
        self.nodes() * B
    }

    /// Bytes of memory that the matrix holds.
    pub fn bytes(&self) -> usize {
        held(&self.offsets) + held(&self.columns) + held(&self.blocks)
    }

    /// Block row `node`: columns (ascending node indices) and their blocks.
    pub fn row(&self, node: usize) -> (&[u32], &[SMatrix<f64, B, B>]) {
        let range = self.range(node);
        (&self.columns[range.clone()], &self.blocks[range])
    }

    fn range(&self, node: usize) -> std::ops::Range<usize> {
        self.offsets[node] as usize..self.offsets[node + 1] as usize
    }

    /// Position of block (`node`, `column`), or `None` if it is not stored.
    fn find(&self, node: usize, column: u32) -> Option<usize> {
        let range = self.range(node);
        self.columns[range.clone()].binary_search(&column).ok().map(|at| range.start + at)
    }

    /// The scalar diagonal, length n.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = Vec::with_capacity(self.size());
        for node in 0..self.nodes() {
            if let Some(at) = self.find(node, node as u32) {
                diagonal.extend((0..B).map(|component| self.blocks[at][(component, component)]));
            }
        }
        diagonal
    }

    /// Adds diag(`shift`) to the matrix. `shift` has length n.
    pub fn add_diagonal(&mut self, shift: &[f64]) {
        debug_assert_eq!(shift.len(), self.size());
        for node in 0..self.nodes() {
            if let Some(at) = self.find(node, node as u32) {
                for component in 0..B {
                    self.blocks[at][(component, component)] += shift[node * B + component];
                }
            }
        }
    }

    /// Changes the basis of one node: A ← Qᵀ A Q.
    ///
    /// Q is the identity except for the block of `node`, which is `basis` (its columns are the new axes).
    pub fn rotate(&mut self, node: usize, basis: &SMatrix<f64, B, B>) {
        for at in self.range(node) {
            self.blocks[at] = basis.transpose() * self.blocks[at];
        }
        for at in self.range(node) {
            if let Some(mirror) = self.find(self.columns[at] as usize, node as u32) {
                self.blocks[mirror] *= basis;
            }
        }
    }

    /// Fixes one unknown: clears its row and column and sets its diagonal entry.
    ///
    /// The equation of `component` of `node` becomes `diagonal` · x = right-hand side, and x
    /// no longer occurs in the others.
    pub fn fix(&mut self, node: usize, component: usize, diagonal: f64) {
        for at in self.range(node) {
            self.blocks[at].row_mut(component).fill(0.0);
            if let Some(mirror) = self.find(self.columns[at] as usize, node as u32) {
                self.blocks[mirror].column_mut(component).fill(0.0);
            }
        }
        if let Some(at) = self.find(node, node as u32) {
            self.blocks[at][(component, component)] = diagonal;
        }
    }

    /// Computes y = A x for each column of `x` and `y` (n × k, column-major), on all threads of the current pool.
    ///
    /// # Panics
    /// If the lengths differ or are no multiple of n.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let size = self.size();
        assert!(x.len() == y.len() && x.len().is_multiple_of(size), "x and y are n × k, column-major");
        for (x, y) in x.chunks_exact(size).zip(y.chunks_exact_mut(size)) {
            let rows = y.par_chunks_exact_mut(B).with_min_len(ROWS_PER_TASK_MIN).enumerate();
            rows.for_each(|(node, y)| self.multiply_row(node, x, y));
        }
    }

    /// Computes y = A x for one column on the calling thread alone, for callers that hold a lock.
    ///
    /// The bits equal those of [`Self::multiply`].
    ///
    /// # Panics
    /// If a length is not n.
    pub fn multiply_alone(&self, x: &[f64], y: &mut [f64]) {
        assert!(x.len() == self.size() && y.len() == self.size(), "x and y are one column each");
        y.chunks_exact_mut(B).enumerate().for_each(|(node, y)| self.multiply_row(node, x, y));
    }

    fn multiply_row(&self, node: usize, x: &[f64], y: &mut [f64]) {
        let (columns, blocks) = self.row(node);
        let mut sum = SVector::<f64, B>::zeros();
        for (&column, block) in columns.iter().zip(blocks) {
            sum += block * SVector::<f64, B>::from_column_slice(&x[column as usize * B..][..B]);
        }
        y.copy_from_slice(sum.as_slice());
    }
}

impl SymmetricMatrix<1> {
    /// Builds a scalar matrix from entries (row, column, value).
    ///
    /// An off-diagonal entry is given once, in either triangle. Repeated entries are summed in the given order.
    ///
    /// # Errors
    /// [`SparseError::IndexOutOfRange`] and [`SparseError::NonFinite`].
    pub fn from_triplets(size: usize, triplets: &[(u32, u32, f64)]) -> Result<Self, SparseError> {
        let outside = triplets.iter().flat_map(|&(row, column, _)| [row, column]).find(|&i| i as usize >= size);
        if let Some(index) = outside {
            return Err(SparseError::IndexOutOfRange { index: index as usize, nodes: size });
        }
        let mut entries: Vec<(u32, u32, f64)> = (0..size as u32).map(|i| (i, i, 0.0)).collect();
        for &(row, column, value) in triplets {
            entries.push((row, column, value));
            if row != column {
                entries.push((column, row, value));
            }
        }
        entries.sort_by_key(|&(row, column, _)| (row, column));
        let mut rows: Vec<Row<1>> = vec![Default::default(); size];
        for same in entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (columns, blocks) = &mut rows[same[0].0 as usize];
            columns.push(same[0].1);
            blocks.push(SMatrix::<f64, 1, 1>::new(same.iter().map(|entry| entry.2).sum()));
        }
        Self::from_rows(rows)
    }
}

/// Tetrahedra around each node, ascending: offsets (length `nodes + 1`) and tetrahedra.
fn incidence(nodes: usize, tets: &[[u32; 4]]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0; nodes + 1];
    for &node in tets.iter().flatten() {
        starts[node as usize + 1] += 1;
    }
    for node in 0..nodes {
        starts[node + 1] += starts[node];
    }
    let mut next = starts.clone();
    let mut incident = vec![0; tets.len() * 4];
    for (tet, corners) in tets.iter().enumerate() {
        for &node in corners {
            incident[next[node as usize] as usize] = tet as u32;
            next[node as usize] += 1;
        }
    }
    (starts, incident)
}

/// Sums the block row of `node` over the tetrahedra `around` it.
fn assemble_row<const B: usize>(
    node: u32,
    around: &[u32],
    tets: &[[u32; 4]],
    block: &(impl Fn(usize, usize, usize) -> SMatrix<f64, B, B> + Sync),
) -> Row<B> {
    let mut columns: Vec<u32> = around.iter().flat_map(|&tet| tets[tet as usize]).chain([node]).collect();
    columns.sort_unstable();
    columns.dedup();
    let mut blocks = vec![SMatrix::<f64, B, B>::zeros(); columns.len()];
    for &tet in around {
        let corners = tets[tet as usize];
        let own = corners.iter().position(|&corner| corner == node).unwrap_or(0);
        for (other, corner) in corners.iter().enumerate() {
            let at = columns.partition_point(|column| column < corner);
            blocks[at] += block(tet as usize, own, other);
        }
    }
    (columns, blocks)
}
