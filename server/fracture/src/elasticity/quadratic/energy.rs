//! Strain energy of quadratic tetrahedra.

use super::EdgeFunctions;
use super::product::{LaneMatrix, corner_gradients, strain};
use crate::elasticity::DrivingEnergy;
use crate::elasticity::blocks::{Block, SIDE};
use crate::elasticity::element::Lame;
use crate::elasticity::strain::{Strain, StrainRow};
use crate::simd::SimdLanes;
use pulp::NullaryFnOnce;

/// Larger and smaller barycentric coordinate of the four points of a rule that integrates quadratic functions exactly
/// (P. C. Hammer & A. H. Stroud, *Numerical evaluation of multiple integrals II*, 1958).
const POINT: [f64; 2] = [0.585_410_196_624_968_5, 0.138_196_601_125_010_5];

/// Strains at the four points of the rule, from those at the corners.
#[inline(always)]
pub(super) fn at_points(corners: &[Strain<SIDE>; 4]) -> [Strain<SIDE>; 4] {
    let mut sum = corners[0];
    for corner in &corners[1..] {
        sum.iter_mut().zip(corner).for_each(|(sum, own)| *sum = *sum + *own);
    }
    corners.map(|own| std::array::from_fn(|k| sum[k] * POINT[1] + own[k] * (POINT[0] - POINT[1])))
}

/// ∫ W over [`SIDE`] tetrahedra whose strains are linear between those at the corners.
#[inline(always)]
pub(in crate::elasticity) fn energies<const TENSILE: bool>(
    lame: Lame,
    volumes: SimdLanes<SIDE>,
    corners: &[Strain<SIDE>; 4],
) -> SimdLanes<SIDE> {
    let mut sum = SimdLanes::all(0.0);
    for strain in &at_points(corners) {
        let density = if TENSILE { lame.tensile_energy_densities(strain) } else { lame.energy_densities(strain) };
        sum = sum + density;
    }
    sum * volumes * 0.25
}

/// Strains at the corners of the tetrahedra of `block`, between which they are linear.
///
/// The displacement has three components per node, then three per edge.
#[inline(always)]
pub(in crate::elasticity) fn corner_strains(
    block: &Block,
    places: (&[[u32; 4]], &[[u32; 6]]),
    displacement: (&[f64], &[f64]),
) -> [Strain<SIDE>; 4] {
    corner_gradients(&block.all_gradients(), places, displacement).each_ref().map(strain)
}

/// Kernel that computes the energies of consecutive tetrahedra.
pub(in crate::elasticity) struct QuadraticEnergies<'a> {
    pub(in crate::elasticity) lame: Lame,
    pub(in crate::elasticity) driving: DrivingEnergy,
    pub(in crate::elasticity) blocks: &'a [Block],
    pub(in crate::elasticity) corners: &'a [[u32; 4]],
    pub(in crate::elasticity) edges: &'a [[u32; 6]],
    pub(in crate::elasticity) displacement: (&'a [f64], &'a [f64]),
    pub(in crate::elasticity) energies: &'a mut [f64],
}

impl QuadraticEnergies<'_> {
    #[inline(always)]
    fn fill<const TENSILE: bool>(self) {
        let places = self.corners.chunks(SIDE).zip(self.edges.chunks(SIDE));
        let parts = places.zip(self.energies.chunks_mut(SIDE));
        for (block, (places, out)) in self.blocks.iter().zip(parts) {
            let at_corners: [LaneMatrix; 4] = corner_gradients(&block.all_gradients(), places, self.displacement);
            let strains = at_corners.each_ref().map(strain);
            let own = energies::<TENSILE>(self.lame, block.volumes, &strains);
            out.copy_from_slice(&own.0[..out.len()]);
        }
    }
}

impl NullaryFnOnce for QuadraticEnergies<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.driving {
            DrivingEnergy::Total => self.fill::<false>(),
            DrivingEnergy::Tensile => self.fill::<true>(),
        }
    }
}

/// The row of a strain of six components.
#[inline(always)]
fn strain_row(lame: Lame, strain: &[f64; 6]) -> StrainRow {
    let density = lame.energy_densities(&strain.map(|own| SimdLanes([own]))).0[0];
    let [xx, yy, zz, xy, yz, xz] = strain.map(|own| own as f32);
    [xx, yy, zz, xy, yz, xz, density as f32, 0.0]
}

/// Kernel that computes the rows of consecutive nodes from strains of six components each.
pub(in crate::elasticity) struct StrainRows<'a> {
    pub(in crate::elasticity) lame: Lame,
    pub(in crate::elasticity) strains: &'a [[f64; 6]],
    pub(in crate::elasticity) rows: &'a mut [StrainRow],
}

impl NullaryFnOnce for StrainRows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.rows.iter_mut().zip(self.strains).for_each(|(row, strain)| *row = strain_row(self.lame, strain));
    }
}

/// Kernel that computes the energies of consecutive tetrahedra from the rows of the nodes.
///
/// Strains ε_i at the corners and linear between them have the energy V/20 (W(Σ ε_i) + Σ W(ε_i)) with the density W, because
/// W is quadratic and ∫ λ_i λ_j = V (1 + δ_ij) / 20.
pub(in crate::elasticity) struct StrainEnergies<'a> {
    pub(in crate::elasticity) lame: Lame,
    pub(in crate::elasticity) volumes: &'a [f64],
    pub(in crate::elasticity) corners: &'a [[u32; 4]],
    pub(in crate::elasticity) rows: &'a [StrainRow],
    pub(in crate::elasticity) energies: &'a mut [f64],
}

impl NullaryFnOnce for StrainEnergies<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for ((nodes, volume), energy) in self.corners.iter().zip(self.volumes).zip(self.energies) {
            let mut sum = [0.0; 8];
            for node in nodes {
                let row = &self.rows[*node as usize];
                for component in 0..8 {
                    sum[component] += row[component];
                }
            }
            let [xx, yy, zz, xy, yz, xz, densities, _] = sum.map(f64::from);
            let whole = self.lame.energy_densities(&[xx, yy, zz, xy, yz, xz].map(|own| SimdLanes([own])));
            *energy = (whole.0[0] + densities) * volume * 0.05;
        }
    }
}

/// Kernel that computes the tensile energies of consecutive tetrahedra from strains at the nodes.
pub(in crate::elasticity) struct TensileStrainEnergies<'a> {
    pub(in crate::elasticity) lame: Lame,
    pub(in crate::elasticity) blocks: &'a [Block],
    pub(in crate::elasticity) corners: &'a [[u32; 4]],
    pub(in crate::elasticity) strains: &'a [[f64; 6]],
    pub(in crate::elasticity) energies: &'a mut [f64],
}

impl NullaryFnOnce for TensileStrainEnergies<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let parts = self.corners.chunks(SIDE).zip(self.energies.chunks_mut(SIDE));
        for (block, (corners, out)) in self.blocks.iter().zip(parts) {
            let mut strains = [[SimdLanes::all(0.0); 6]; 4];
            for (lane, nodes) in corners.iter().enumerate().take(SIDE) {
                for (own, node) in strains.iter_mut().zip(nodes) {
                    let values = &self.strains[*node as usize];
                    own.iter_mut().zip(values).for_each(|(own, value)| own.0[lane] = *value);
                }
            }
            let own = energies::<true>(self.lame, block.volumes, &strains);
            out.copy_from_slice(&own.0[..out.len()]);
        }
    }
}

impl EdgeFunctions {
    /// Strains at the nodes, six components each: the mean of those at the corner in the tetrahedra around, by volume.
    pub(in crate::elasticity) fn node_strains(&self, blocks: &[Block], displacement: &[f64]) -> Vec<f64> {
        let nodes = displacement.len() - 3 * self.count();
        let displacement = displacement.split_at(nodes);
        let (mut strains, mut volumes) = (vec![0.0; 2 * nodes], vec![0.0; nodes / 3]);
        let places = self.corners.chunks(SIDE).zip(self.tets.chunks(SIDE));
        for (block, (corners, edges)) in blocks.iter().zip(places) {
            let at_corners = corner_gradients(&block.all_gradients(), (corners, edges), displacement);
            for (corner, h) in at_corners.iter().enumerate() {
                let own = strain(h);
                for (lane, nodes) in corners.iter().enumerate() {
                    let (node, volume) = (nodes[corner] as usize, block.volumes.0[lane]);
                    volumes[node] += volume;
                    let sums = &mut strains[6 * node..][..6];
                    sums.iter_mut().zip(&own).for_each(|(sum, own)| *sum += volume * own.0[lane]);
                }
            }
        }
        for (strain, volume) in strains.chunks_exact_mut(6).zip(volumes) {
            strain.iter_mut().for_each(|own| *own /= volume);
        }
        strains
    }

    /// Adds the strains of a displacement of linear elements times volumes to the sums of all nodes, six components each.
    pub(in crate::elasticity) fn add_linear_strains(&self, blocks: &[Block], displacement: &[f64], sums: &mut [f64]) {
        for (block, corners) in blocks.iter().zip(self.corners.chunks(SIDE)) {
            let strain = block.strain(corners, displacement).map(|own| own * block.volumes);
            for (lane, nodes) in corners.iter().enumerate() {
                for node in nodes {
                    let sums = &mut sums[6 * *node as usize..][..6];
                    sums.iter_mut().zip(&strain).for_each(|(sum, own)| *sum += own.0[lane]);
                }
            }
        }
    }
}
