//! Indicator of the energy that a solution misses: the distance of its strains from continuous ones.
//!
//! The strains of a solution are linear or constant in each tetrahedron, and jump between them. The recovered ones are
//! linear between their values at the nodes, the means of those in the tetrahedra around, by volume. The energy of the
//! difference is about proportional to the energy that is missing.
//!
//! Based on: O. C. Zienkiewicz & J. Z. Zhu, *A simple error estimator and adaptive procedure for practical engineering
//! analysis* (International Journal for Numerical Methods in Engineering 24, 1987), equations 11 and 17, with means
//! instead of a projection.

use super::blocks::{Block, SIDE};
use super::element::Lame;
use super::quadratic::{EdgeFunctions, corner_strains, energies};
use super::strain::Strain;
use super::{Elasticity, ElasticityError};
use crate::lattice::Lattice;
use crate::simd::{SimdLanes, widest};
use pulp::NullaryFnOnce;

/// Displacement whose strains are recovered.
#[derive(Clone, Copy)]
struct Solution<'a> {
    lame: Lame,
    blocks: &'a [Block],
    tets: &'a [[u32; 4]],
    /// Edge functions; `None`: the displacement is that of linear elements.
    edges: Option<&'a EdgeFunctions>,
    /// Three components per node, then three per edge.
    displacement: (&'a [f64], &'a [f64]),
}

impl Solution<'_> {
    /// Strains at the corners of the tetrahedra of block `index`, and the nodes of these.
    #[inline(always)]
    fn corner_strains(&self, index: usize) -> ([Strain<SIDE>; 4], &[[u32; 4]]) {
        let (block, first) = (&self.blocks[index], SIDE * index);
        let end = self.tets.len().min(first + SIDE);
        let corners = &self.tets[first..end];
        let strains = match self.edges {
            Some(edges) => corner_strains(block, (corners, &edges.tets[first..end]), self.displacement),
            None => [block.strain(corners, self.displacement.0); 4],
        };
        (strains, corners)
    }
}

/// Kernel that computes strains at the nodes, six components each.
struct NodeMeans<'a>(Solution<'a>);

impl NullaryFnOnce for NodeMeans<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let nodes = self.0.displacement.0.len() / 3;
        let (mut strains, mut volumes) = (vec![0.0; 6 * nodes], vec![0.0; nodes]);
        for (index, block) in self.0.blocks.iter().enumerate() {
            let (at_corners, corners) = self.0.corner_strains(index);
            for (lane, nodes) in corners.iter().enumerate() {
                let volume = block.volumes.0[lane];
                for (node, own) in nodes.iter().zip(&at_corners) {
                    volumes[*node as usize] += volume;
                    let sums = &mut strains[6 * *node as usize..][..6];
                    sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += volume * own.0[lane]);
                }
            }
        }
        for (strain, volume) in strains.chunks_exact_mut(6).zip(volumes) {
            strain.iter_mut().for_each(|own| *own /= volume);
        }
        strains
    }
}

/// Kernel that sums the energy of the difference from strains at the nodes.
struct Distance<'a> {
    solution: Solution<'a>,
    strains: &'a [f64],
}

impl NullaryFnOnce for Distance<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let mut sum = SimdLanes::all(0.0);
        for (index, block) in self.solution.blocks.iter().enumerate() {
            let (mut at_corners, corners) = self.solution.corner_strains(index);
            for (lane, nodes) in corners.iter().enumerate() {
                for (node, own) in nodes.iter().zip(&mut at_corners) {
                    let recovered = &self.strains[6 * *node as usize..][..6];
                    own.iter_mut().zip(recovered).for_each(|(own, recovered)| own.0[lane] -= recovered);
                }
            }
            sum = sum + energies::<false>(self.solution.lame, block.volumes, &at_corners);
        }
        sum.0.iter().sum()
    }
}

impl Elasticity {
    /// Energy of the difference between the strains of `displacement` and the recovered ones, over the whole body.
    ///
    /// `displacement` has length [`Self::unknowns`], or [`Self::size`] for one of linear elements. Runs on the calling
    /// thread alone, in a fixed order.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`].
    pub fn recovery_energy(&self, lattice: &Lattice, displacement: &[f64]) -> Result<f64, ElasticityError> {
        let is_linear = displacement.len() == self.size();
        if !is_linear {
            self.check_length("the displacement", displacement)?;
        }
        let (expected, found) = (self.tets, lattice.tets.len());
        if expected != found || lattice.nodes.len() * 3 != self.size() {
            return Err(ElasticityError::OtherLattice { what: "the lattice", expected, found });
        }
        let solution = Solution {
            lame: self.lame,
            blocks: &self.elements.blocks,
            tets: &lattice.tets,
            edges: self.edges.as_deref().filter(|_| !is_linear),
            displacement: displacement.split_at(self.size()),
        };
        let strains = widest(NodeMeans(solution));
        Ok(widest(Distance { solution, strains: &strains }))
    }
}
