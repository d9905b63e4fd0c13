//! Sweeps over the stiffness, transfers between levels, and the V-cycle that they make.

use super::level::RefinedLevel;
use crate::elasticity::{ElasticWorkspace, Elasticity};
use crate::simd::{SimdLanes, widest};
use crate::sparse::{Cholesky, SymmetricMatrix};
use nalgebra::Matrix3;
use pulp::NullaryFnOnce;

/// Number of right-hand sides that are solved together.
pub(super) const WIDTH: usize = 4;

/// Three components of one node, of all right-hand sides.
pub(super) type NodeRow = [SimdLanes<WIDTH>; 3];

pub(super) const ZERO: NodeRow = [SimdLanes([0.0; WIDTH]); 3];

/// Sweep over the rows of a stiffness.
enum Sweep<'a> {
    /// K x into the second vector.
    Product(&'a [NodeRow], &'a mut [NodeRow]),
    /// Gauss-Seidel from x = 0, in ascending order: the right-hand side, then x.
    Forward(&'a [NodeRow], &'a mut [NodeRow]),
    /// Residual b − K x after [`Self::Forward`] into the second vector: what the sweep did not know, −U x.
    Residual(&'a [NodeRow], &'a mut [NodeRow]),
    /// Gauss-Seidel from x, in descending order.
    Backward(&'a [NodeRow], &'a mut [NodeRow]),
}

/// Kernel of a sweep.
struct Kernel<'a> {
    stiffness: &'a SymmetricMatrix<3>,
    inverse_diagonal: &'a [Matrix3<f64>],
    sweep: Sweep<'a>,
}

impl NullaryFnOnce for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { stiffness, inverse_diagonal, sweep } = self;
        let nodes = stiffness.nodes();
        match sweep {
            Sweep::Product(x, out) => {
                for (node, out) in out.iter_mut().enumerate() {
                    *out = sum(stiffness, node, x, |_| true, ZERO, 1.0);
                }
            }
            Sweep::Forward(right, x) => {
                for node in 0..nodes {
                    let rest = sum(stiffness, node, x, |column| column < node, right[node], -1.0);
                    x[node] = times(&inverse_diagonal[node], &rest);
                }
            }
            Sweep::Residual(x, out) => {
                for (node, out) in out.iter_mut().enumerate() {
                    *out = sum(stiffness, node, x, |column| column > node, ZERO, -1.0);
                }
            }
            Sweep::Backward(right, x) => {
                for node in (0..nodes).rev() {
                    let rest = sum(stiffness, node, x, |column| column != node, right[node], -1.0);
                    x[node] = times(&inverse_diagonal[node], &rest);
                }
            }
        }
    }
}

/// `start` plus `sign` times the products of the blocks of row `node` whose column passes `keep`.
#[inline(always)]
fn sum(
    stiffness: &SymmetricMatrix<3>,
    node: usize,
    x: &[NodeRow],
    keep: impl Fn(usize) -> bool,
    start: NodeRow,
    sign: f64,
) -> NodeRow {
    let (columns, blocks) = stiffness.row(node);
    let mut sum = ZERO;
    for (&column, block) in columns.iter().zip(blocks) {
        if keep(column as usize) {
            let own = times(block, &x[column as usize]);
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum = *sum + own);
        }
    }
    std::array::from_fn(|axis| start[axis] + sum[axis] * sign)
}

#[inline(always)]
pub(super) fn times(block: &Matrix3<f64>, x: &NodeRow) -> NodeRow {
    std::array::from_fn(|row| x[0] * block[(row, 0)] + x[1] * block[(row, 1)] + x[2] * block[(row, 2)])
}

impl RefinedLevel {
    fn sweep(&self, sweep: Sweep<'_>) {
        widest(Kernel { stiffness: &self.stiffness, inverse_diagonal: &self.inverse_diagonal, sweep });
    }

    /// K x.
    pub(super) fn multiply(&self, x: &[NodeRow], out: &mut [NodeRow]) {
        self.sweep(Sweep::Product(x, out));
    }

    /// Sums of the forces `fine` by node of the coarser level.
    fn restrict(&self, fine: &[NodeRow], coarse: &mut [NodeRow]) {
        let (own, midpoints) = fine.split_at(coarse.len());
        coarse.copy_from_slice(own);
        for (ends, force) in self.refined.parents.iter().zip(midpoints) {
            for &end in ends {
                add(&mut coarse[end as usize], force, 0.5);
            }
        }
    }

    /// Adds the displacement `coarse` of the coarser level.
    fn prolong(&self, coarse: &[NodeRow], fine: &mut [NodeRow]) {
        let (own, midpoints) = fine.split_at_mut(coarse.len());
        own.iter_mut().zip(coarse).for_each(|(own, more)| add(own, more, 1.0));
        for (ends, place) in self.refined.parents.iter().zip(midpoints) {
            ends.iter().for_each(|end| add(place, &coarse[*end as usize], 0.5));
        }
    }
}

#[inline(always)]
fn add(sum: &mut NodeRow, more: &NodeRow, factor: f64) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum = *sum + *more * factor);
}

/// V-cycle over the levels up to one of them, with the vectors that it needs.
pub(super) struct Cycle<'a> {
    coarse: &'a Elasticity,
    factor: &'a Cholesky,
    levels: &'a [RefinedLevel],
    /// Residual on each refined level, then right-hand side and displacement on the level below it.
    vectors: Vec<[Vec<NodeRow>; 3]>,
    columns: Vec<f64>,
    workspace: ElasticWorkspace,
}

impl<'a> Cycle<'a> {
    pub(super) fn new(coarse: &'a Elasticity, factor: &'a Cholesky, levels: &'a [RefinedLevel]) -> Self {
        let vectors = |level: &RefinedLevel| {
            let fine = level.stiffness.nodes();
            let below = fine - level.refined.parents.len();
            [fine, below, below].map(|count| vec![ZERO; count])
        };
        let vectors = levels.iter().map(vectors).collect();
        Self { coarse, factor, levels, vectors, columns: Vec::new(), workspace: ElasticWorkspace::default() }
    }

    /// Approximates the displacement `x` of the finest level under the forces `right`, which are in equilibrium.
    pub(super) fn apply(&mut self, right: &[NodeRow], x: &mut [NodeRow]) {
        self.descend(self.levels.len(), right, x);
    }

    fn descend(&mut self, level: usize, right: &[NodeRow], x: &mut [NodeRow]) {
        let Some(below) = level.checked_sub(1) else { return self.solve_coarsest(right, x) };
        let own = &self.levels[below];
        let [mut residual, mut forces, mut correction] = std::mem::take(&mut self.vectors[below]);
        own.sweep(Sweep::Forward(right, x));
        own.sweep(Sweep::Residual(x, &mut residual));
        own.restrict(&residual, &mut forces);
        self.descend(below, &forces, &mut correction);
        own.prolong(&correction, x);
        own.sweep(Sweep::Backward(right, x));
        self.vectors[below] = [residual, forces, correction];
    }

    fn solve_coarsest(&mut self, right: &[NodeRow], x: &mut [NodeRow]) {
        self.columns.clear();
        for column in 0..WIDTH {
            self.columns.extend(right.iter().flat_map(|row| row.map(|lanes| lanes.0[column])));
        }
        self.coarse.back_substitute(self.factor, &mut self.columns, &mut self.workspace);
        for (column, own) in self.columns.chunks_exact(3 * x.len()).enumerate() {
            for (row, own) in x.iter_mut().zip(own.chunks_exact(3)) {
                row.iter_mut().zip(own).for_each(|(lanes, own)| lanes.0[column] = *own);
            }
        }
    }
}
