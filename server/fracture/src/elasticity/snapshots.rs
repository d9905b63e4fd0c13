//! Method of snapshots: a small basis of the displacements under many loads.
//!
//! Based on: L. Sirovich (Quarterly of Applied Mathematics 45, 1987). The eigenvectors of the snapshots' Gram matrix,
//! here G_ij = u_i'Ku_j = u_i'f_j, weight the snapshots. Every snapshot is scaled to unit energy.

use super::quadratic::{EdgeFunctions, SNAPSHOT, SOLVED, SnapshotRows};
use super::{
    CompletionTables, ElasticWorkspace, Elasticity, ElasticityError, ErrorEstimate, NodalLoad, QuadraticTables,
    ReducedBasis, ScaledRows,
};
use crate::cancel_token::CancelToken;
use crate::dense;
use crate::lattice::Lattice;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::ops::Range;

/// Right-hand sides per solve.
const BLOCK: usize = 8;

/// Rows of the basis per parallel task.
const ROWS: usize = 4096;

/// Largest number of sums that are kept until all are added.
const PARTS_MAX: usize = 16;

/// Energy of a direction, over the largest, below which it is rounding.
const NOISE: f64 = 1e-11;

/// As [`NOISE`], for quadratic elements, whose residuals are kept in single precision.
const NOISE_QUADRATIC: f64 = 1e-8;

/// Snapshots with quadratic elements.
struct QuadraticSnapshots {
    /// Restrictions ([`SnapshotRows`]), column-major with one column per load.
    rows: Vec<f64>,
    /// Displacements and residuals f − K u, in the same order.
    displacements: Vec<f32>,
    residuals: Vec<f32>,
}

impl Elasticity {
    /// Displacements under `loads`, column-major with one column per load.
    ///
    /// Solved in blocks of right-hand sides on all threads of the current pool. Each is checked as in [`Self::solve`].
    ///
    /// # Errors
    /// [`ElasticityError::Residual`], [`ElasticityError::Canceled`], those of [`Self::factor`].
    pub fn solve_all(&self, loads: &[NodalLoad], token: &CancelToken) -> Result<Vec<f64>, ElasticityError> {
        let size = self.unknowns();
        let mut columns = vec![0.0; size * loads.len()];
        columns.par_chunks_mut(size * BLOCK).zip(loads.par_chunks(BLOCK)).try_for_each_init(
            || (ElasticWorkspace::default(), Vec::new()),
            |(workspace, single), (columns, loads)| self.solve_block(loads, columns, single, workspace, token),
        )?;
        Ok(columns)
    }

    /// Fills `columns` with the displacements under a few loads.
    fn solve_block(
        &self,
        loads: &[NodalLoad],
        columns: &mut [f64],
        single: &mut Vec<f64>,
        workspace: &mut ElasticWorkspace,
        token: &CancelToken,
    ) -> Result<(), ElasticityError> {
        let size = self.unknowns();
        token.check()?;
        for (column, load) in columns.chunks_exact_mut(size).zip(loads) {
            column.copy_from_slice(&load.forces);
        }
        if let Some(edges) = &self.edges {
            return self.iterate(edges, columns, SOLVED, workspace, token).map(|_| ());
        }
        self.back_substitute(self.factor()?, columns, workspace);
        for (column, load) in columns.chunks_exact_mut(size).zip(loads) {
            if !self.balances(&load.forces, column, workspace) {
                // Solved one by one, with refinement.
                self.solve(&load.forces, single, workspace, token)?;
                column.copy_from_slice(single);
            }
        }
        Ok(())
    }

    /// Bytes of one snapshot during [`Self::reduce`].
    pub fn snapshot_bytes(&self) -> usize {
        let quadratic = self.edges.as_ref().map(|_| {
            let rows = SnapshotRows::new(self.size()).count();
            size_of::<f64>() * rows + 2 * size_of::<f32>() * self.unknowns()
        });
        quadratic.unwrap_or(size_of::<f64>() * self.size())
    }

    /// Approximate quadratic displacements under `loads`, with their residuals.
    fn snapshots(
        &self,
        edges: &EdgeFunctions,
        loads: &[NodalLoad],
        token: &CancelToken,
    ) -> Result<QuadraticSnapshots, ElasticityError> {
        let (size, count) = (self.unknowns(), SnapshotRows::new(self.size()).count());
        let mut rows = vec![0.0; count * loads.len()];
        let [mut displacements, mut residuals] = [(); 2].map(|()| vec![0.0; size * loads.len()]);
        let fine = displacements.par_chunks_mut(size * BLOCK).zip(residuals.par_chunks_mut(size * BLOCK));
        let parts = rows.par_chunks_mut(count * BLOCK).zip(fine).zip(loads.par_chunks(BLOCK));
        parts.try_for_each_init(
            || (ElasticWorkspace::default(), Vec::new()),
            |(workspace, solved), ((rows, (displacements, residuals)), loads)| {
                solved.clear();
                solved.extend(loads.iter().flat_map(|load| &load.forces));
                let (_, left) = self.iterate(edges, solved, SNAPSHOT, workspace, token)?;
                for ((rows, solved), load) in rows.chunks_exact_mut(count).zip(solved.chunks_exact(size)).zip(loads) {
                    self.restrict(edges, solved, &load.forces, rows);
                }
                narrow(solved.iter(), displacements);
                narrow(left.iter().flatten(), residuals);
                Ok::<_, ElasticityError>(())
            },
        )?;
        Ok(QuadraticSnapshots { rows, displacements, residuals })
    }

    /// Basis of at most `rank_max` displacements that spans those under `loads` best in energy, with its masses.
    /// `None` if there is no energy. `lattice` is the one that the body was made of.
    ///
    /// # Errors
    /// As [`Self::solve_all`].
    pub fn reduce(
        &self,
        lattice: &Lattice,
        loads: &[NodalLoad],
        rank_max: usize,
        token: &CancelToken,
    ) -> Result<Option<ReducedBasis>, ElasticityError> {
        if let Some(edges) = &self.edges {
            return self.reduce_quadratic((lattice, edges), loads, rank_max, token);
        }
        let (size, count) = (self.size(), loads.len());
        let columns = self.solve_all(loads, token)?;
        let snapshots = MatRef::from_column_major_slice(&columns, size, count);
        let gram = gram(snapshots, loads, |load| load.forces.clone(), token)?;
        let Some(weights) = weights(gram, rank_max, NOISE, token)? else { return Ok(None) };
        let basis = ReducedBasis::new(self, weights.ncols(), combined(snapshots, weights.as_ref()));
        Ok(Some(basis.with_mass(self.mass(lattice, snapshots, weights.as_ref(), token)?)))
    }

    /// B'MB of the basis B of displacements that `weights` make of `snapshots`.
    fn mass<T: Copy + Into<f64> + Sync>(
        &self,
        lattice: &Lattice,
        snapshots: MatRef<'_, T>,
        weights: MatRef<'_, f64>,
        token: &CancelToken,
    ) -> Result<Vec<f64>, ElasticityError> {
        let basis = weighted(snapshots, weights);
        self.mass_gram(lattice, MatRef::from_row_major_slice(&basis, self.unknowns(), weights.ncols()), token)
    }

    /// As [`Self::reduce`] for quadratic elements.
    ///
    /// With the residual r = f − K u of a snapshot, K u = f − r. So the products u'K u, by which the basis is orthonormal,
    /// are exact however far a snapshot is from the solution. The estimate of errors neglects r.
    fn reduce_quadratic(
        &self,
        (lattice, edges): (&Lattice, &EdgeFunctions),
        loads: &[NodalLoad],
        rank_max: usize,
        token: &CancelToken,
    ) -> Result<Option<ReducedBasis>, ElasticityError> {
        let parts = SnapshotRows::new(self.size());
        let QuadraticSnapshots { rows, displacements, residuals } = self.snapshots(edges, loads, token)?;
        let snapshots = MatRef::from_column_major_slice(&rows, parts.count(), loads.len());
        let products = |first: usize| {
            let rows = snapshots.subrows(first, self.size() + 6);
            gram(rows, loads, |load| self.restricted_load(load), token)
        };
        let fine = |columns| MatRef::from_column_major_slice(columns, self.unknowns(), loads.len());
        let energies = products(0)? - missing(fine(&displacements), fine(&residuals), token)?;
        let Some(weights) = weights(energies, rank_max, NOISE_QUADRATIC, token)? else { return Ok(None) };
        let residual = weights.transpose() * products(parts.weighted().start)? * &weights;
        let rank = weights.ncols();
        let residual = (0..rank * rank).map(|at| residual[(at % rank, at / rank)]).collect();
        let estimate = ErrorEstimate::RAW;
        let completion =
            Some(CompletionTables { forces: self.node_forces(loads, &residuals, weights.as_ref()), estimate });
        drop(residuals);
        let displacements = MatRef::from_column_major_slice(&displacements, self.unknowns(), loads.len());
        let mass = self.mass(lattice, displacements, weights.as_ref(), token)?;
        let rows = combined(snapshots, weights.as_ref());
        let part = |range: Range<usize>| rows[range.start * rank..range.end * rank].to_vec();
        let wide = |range: Range<usize>| part(range).into_iter().map(f64::from);
        let inertial = wide(parts.work()).chain(wide(parts.weighted_work())).collect();
        let (strains, weighted) = (ScaledRows::new(rank, &part(parts.strains())), part(parts.weighted()));
        let tables = QuadraticTables { strains, weighted, inertial, completion };
        let basis = ReducedBasis::stored_quadratic(self, part(parts.trace()), residual, tables, estimate);
        Ok(Some(basis.with_mass(mass)))
    }

    /// KB on the functions of the nodes, one row of the rank per component, from the weights of the snapshots.
    fn node_forces(&self, loads: &[NodalLoad], residuals: &[f32], weights: MatRef<'_, f64>) -> Vec<f32> {
        let size = self.size();
        let columns = loads.iter().zip(residuals.chunks_exact(self.unknowns()));
        let own = |(load, residual): (&NodalLoad, &[f32])| -> Vec<f64> {
            load.forces[..size].iter().zip(residual).map(|(force, residual)| force - f64::from(*residual)).collect()
        };
        let columns: Vec<f64> = columns.flat_map(own).collect();
        combined(MatRef::from_column_major_slice(&columns, size, loads.len()), weights)
    }
}

/// Writes `values` in single precision.
fn narrow<'a>(values: impl IntoIterator<Item = &'a f64>, to: &mut [f32]) {
    to.iter_mut().zip(values).for_each(|(to, value)| *to = *value as f32);
}

/// u_i'r_j, symmetrized.
fn missing(
    displacements: MatRef<'_, f32>,
    residuals: MatRef<'_, f32>,
    token: &CancelToken,
) -> Result<Mat<f64>, ElasticityError> {
    let (size, count) = (displacements.nrows(), displacements.ncols());
    let rows = ROWS.max(size.div_ceil(PARTS_MAX));
    let firsts: Vec<usize> = (0..size).step_by(rows).collect();
    let part = |first: &usize| {
        token.check()?;
        let rows = rows.min(size - first);
        let wide =
            |all: MatRef<'_, f32>| Mat::from_fn(rows, count, |row, column| f64::from(all[(first + row, column)]));
        let mut part = Mat::<f64>::zeros(count, count);
        let (displacements, residuals) = (wide(displacements), wide(residuals));
        matmul(&mut part, Accum::Replace, displacements.transpose(), residuals, 1.0, Par::Seq);
        Ok::<_, ElasticityError>(part)
    };
    let parts: Vec<Mat<f64>> = firsts.par_iter().map(part).collect::<Result<_, _>>()?;
    // Summed in a fixed order for any number of threads.
    let mut sum = Mat::<f64>::zeros(count, count);
    parts.iter().for_each(|part| sum += part);
    Ok(Mat::from_fn(count, count, |i, j| 0.5 * (sum[(i, j)] + sum[(j, i)])))
}

/// Weights of the snapshots in a basis of at most `rank_max` displacements, from their products; `None` without energy.
fn weights(
    mut gram: Mat<f64>,
    rank_max: usize,
    noise: f64,
    token: &CancelToken,
) -> Result<Option<Mat<f64>>, ElasticityError> {
    let count = gram.ncols();
    let scales: Vec<f64> = (0..count).map(|k| gram[(k, k)].max(0.0).sqrt()).map(inverse).collect();
    for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
        gram[(i, j)] *= scales[i] * scales[j];
    }
    let Ok(pairs) = dense::symmetric(gram.as_ref()) else { return Ok(None) };
    token.check()?;
    let greatest = pairs.values.last().copied().unwrap_or(0.0);
    let kept = pairs.values.iter().rev().take_while(|value| **value > noise * greatest).take(rank_max);
    let inverse_roots: Vec<f64> = kept.map(|value| 1.0 / value.sqrt()).collect();
    if inverse_roots.is_empty() {
        return Ok(None);
    }
    Ok(Some(Mat::from_fn(count, inverse_roots.len(), |row, column| {
        scales[row] * pairs.vectors[(row, count - 1 - column)] * inverse_roots[column]
    })))
}

fn inverse(value: f64) -> f64 {
    if value > 0.0 { 1.0 / value } else { 0.0 }
}

/// u_i'f_j, symmetrized.
fn gram(
    snapshots: MatRef<'_, f64>,
    loads: &[NodalLoad],
    forces: impl Fn(&NodalLoad) -> Vec<f64> + Sync,
    token: &CancelToken,
) -> Result<Mat<f64>, ElasticityError> {
    let (size, count) = (snapshots.nrows(), loads.len());
    let mut products = vec![0.0; count * count];
    products.par_chunks_mut(count * BLOCK).zip(loads.par_chunks(BLOCK)).try_for_each(|(products, loads)| {
        token.check()?;
        let forces: Vec<f64> = loads.iter().flat_map(&forces).collect();
        let forces = MatRef::from_column_major_slice(&forces, size, loads.len());
        let products = MatMut::from_column_major_slice_mut(products, count, loads.len());
        matmul(products, Accum::Replace, snapshots.transpose(), forces, 1.0, Par::Seq);
        Ok::<_, ElasticityError>(())
    })?;
    let products = MatRef::from_column_major_slice(&products, count, count);
    Ok(Mat::from_fn(count, count, |i, j| 0.5 * (products[(i, j)] + products[(j, i)])))
}

/// Snapshots times weights, row-major, in single precision.
fn combined(snapshots: MatRef<'_, f64>, weights: MatRef<'_, f64>) -> Vec<f32> {
    let (size, count, rank) = (snapshots.nrows(), snapshots.ncols(), weights.ncols());
    let mut basis = vec![0.0; size * rank];
    basis.par_chunks_mut(ROWS * rank).enumerate().for_each(|(chunk, narrow)| {
        let rows = narrow.len() / rank;
        let mut wide = vec![0.0; narrow.len()];
        let snapshots = snapshots.submatrix(chunk * ROWS, 0, rows, count);
        let product = MatMut::from_row_major_slice_mut(&mut wide, rows, rank);
        matmul(product, Accum::Replace, snapshots, weights, 1.0, Par::Seq);
        narrow.iter_mut().zip(wide).for_each(|(narrow, wide)| *narrow = wide as f32);
    });
    basis
}

/// As [`combined`], in double precision.
fn weighted<T: Copy + Into<f64> + Sync>(snapshots: MatRef<'_, T>, weights: MatRef<'_, f64>) -> Vec<f64> {
    let (size, count, rank) = (snapshots.nrows(), snapshots.ncols(), weights.ncols());
    let mut basis = vec![0.0; size * rank];
    basis.par_chunks_mut(ROWS * rank).enumerate().for_each(|(chunk, wide)| {
        let rows = wide.len() / rank;
        let own = Mat::<f64>::from_fn(rows, count, |row, column| snapshots[(chunk * ROWS + row, column)].into());
        let product = MatMut::from_row_major_slice_mut(wide, rows, rank);
        matmul(product, Accum::Replace, &own, weights, 1.0, Par::Seq);
    });
    basis
}
