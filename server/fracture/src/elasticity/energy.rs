//! Strain energy of tetrahedra.

use super::element::{Element, Lame};
use super::quadratic::{EdgeFunctions, QuadraticEnergies, StrainEnergies};
use super::strain::Strain;
use super::{Elasticity, ElasticityError};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::memory::held;
use crate::simd::{SimdLanes, widest};
use pulp::NullaryFnOnce;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of tetrahedra per SIMD block.
pub(super) const SIDE: usize = 4;

/// Number of tetrahedra between two checks of the token; a multiple of [`SIDE`].
const CHUNK: usize = 2048;

/// Part of the strain energy that drives cracks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrivingEnergy {
    /// The whole energy, ½ σ:ε.
    #[default]
    Total,
    /// The tensile part of the spectral split (Miehe et al. 2010). Compression does not drive cracks.
    Tensile,
}

/// Gradients and volumes of all tetrahedra, computed once so that a request inverts no matrix.
#[derive(Debug)]
pub(super) struct Elements {
    pub(super) blocks: Vec<Block>,
}

/// Three vectors of each of [`SIDE`] tetrahedra.
pub(super) type Triple = [[SimdLanes<SIDE>; 3]; 3];

/// Block of [`SIDE`] tetrahedra. Missing ones in the last block are zero.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// ∇φ of the second, third and fourth node, in 1/local length. That of the first is minus their sum.
    gradients: Triple,
    /// Volumes, local.
    pub(super) volumes: SimdLanes<SIDE>,
}

impl Elements {
    /// Packs the elements into SIMD blocks.
    pub(super) fn new(elements: &[Element]) -> Self {
        Self { blocks: elements.chunks(SIDE).map(Block::new).collect() }
    }

    /// Bytes of memory that they hold.
    pub(super) fn bytes(&self) -> usize {
        held(&self.blocks)
    }
}

impl Block {
    fn new(elements: &[Element]) -> Self {
        let lanes = |of: &dyn Fn(&Element) -> f64| {
            let mut lanes = SimdLanes::all(0.0);
            lanes.0.iter_mut().zip(elements).for_each(|(lane, element)| *lane = of(element));
            lanes
        };
        let gradients = [1, 2, 3].map(|node| [0, 1, 2].map(|axis| lanes(&|element| element.gradients[node][axis])));
        Self { gradients, volumes: lanes(&|element| element.volume) }
    }

    /// ∇φ of all four nodes, in 1/local length.
    #[inline(always)]
    pub(super) fn all_gradients(&self) -> [[SimdLanes<SIDE>; 3]; 4] {
        let [a, b, c] = self.gradients;
        let first = std::array::from_fn(|axis| (a[axis] + b[axis] + c[axis]) * -1.0);
        [first, a, b, c]
    }

    /// Strains ε of the tetrahedra `tets`.
    #[inline(always)]
    fn strain(&self, tets: &[[u32; 4]], displacement: &[f64]) -> Strain<SIDE> {
        // Indexed by edge, then by component.
        let mut edges = [[SimdLanes::all(0.0); 3]; 3];
        for (lane, tet) in tets.iter().enumerate().take(SIDE) {
            let first = &displacement[3 * tet[0] as usize..][..3];
            for edge in 0..3 {
                let other = &displacement[3 * tet[edge + 1] as usize..][..3];
                for axis in 0..3 {
                    edges[edge][axis].0[lane] = other[axis] - first[axis];
                }
            }
        }
        let g = &self.gradients;
        let sheared = |i, j| (derivative(&edges, g, i, j) + derivative(&edges, g, j, i)) * 0.5;
        let stretched = |i| derivative(&edges, g, i, i);
        [stretched(0), stretched(1), stretched(2), sheared(0, 1), sheared(1, 2), sheared(0, 2)]
    }
}

/// ∂u_i/∂x_j from the displacements along the edges and the gradients of their ends.
#[inline(always)]
fn derivative(edges: &Triple, gradients: &Triple, i: usize, j: usize) -> SimdLanes<SIDE> {
    edges[0][i] * gradients[0][j] + edges[1][i] * gradients[1][j] + edges[2][i] * gradients[2][j]
}

/// Kernel that computes the energies of consecutive tetrahedra.
struct Energies<'a> {
    lame: Lame,
    driving: DrivingEnergy,
    blocks: &'a [Block],
    tets: &'a [[u32; 4]],
    displacement: &'a [f64],
    energies: &'a mut [f64],
}

impl Energies<'_> {
    #[inline(always)]
    fn fill<const TENSILE: bool>(self) {
        let parts = self.tets.chunks(SIDE).zip(self.energies.chunks_mut(SIDE));
        for (block, (tets, energies)) in self.blocks.iter().zip(parts) {
            let strain = block.strain(tets, self.displacement);
            let lame = self.lame;
            let density = if TENSILE { lame.tensile_energy_densities(&strain) } else { lame.energy_densities(&strain) };
            energies.copy_from_slice(&(density * block.volumes).0[..energies.len()]);
        }
    }
}

impl NullaryFnOnce for Energies<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        match self.driving {
            DrivingEnergy::Total => self.fill::<false>(),
            DrivingEnergy::Tensile => self.fill::<true>(),
        }
    }
}

impl Elasticity {
    /// Computes ∫ W over each tetrahedron.
    ///
    /// `displacement` has length [`Self::unknowns`]. `energies` is resized to `lattice.tets.len()`. With
    /// [`DrivingEnergy::Total`] the energies sum to ½ f·u.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`], [`ElasticityError::Canceled`].
    pub fn tet_energy(
        &self,
        lattice: &Lattice,
        displacement: &[f64],
        driving: DrivingEnergy,
        energies: &mut Vec<f64>,
        token: &CancelToken,
    ) -> Result<(), ElasticityError> {
        self.check_length("the displacement", displacement)?;
        let (expected, found) = (self.tets, lattice.tets.len());
        if expected != found || lattice.nodes.len() * 3 != self.size() {
            return Err(ElasticityError::OtherLattice { what: "the lattice", expected, found });
        }
        energies.resize(found, 0.0);
        if let Some(edges) = &self.edges {
            return self.quadratic_energy(edges, displacement, driving, energies, token);
        }
        let blocks = self.elements.blocks.par_chunks(CHUNK / SIDE);
        let chunks = lattice.tets.par_chunks(CHUNK).zip(energies.par_chunks_mut(CHUNK));
        blocks.zip(chunks).try_for_each(|(blocks, (tets, energies))| {
            token.check()?;
            widest(Energies { lame: self.lame, driving, blocks, tets, displacement, energies });
            Ok(())
        })
    }

    /// Computes ∫ W over each tetrahedron from strains at the nodes, six components each, in proportion to a whole energy.
    ///
    /// The sum of the energies of all parts is `whole`; with [`DrivingEnergy::Tensile`], that of the tensile parts is
    /// their share of it.
    ///
    /// # Errors
    /// [`ElasticityError::Canceled`].
    pub(super) fn strain_energy(
        &self,
        lattice: &Lattice,
        strains: &[f64],
        (driving, whole): (DrivingEnergy, f64),
        energies: &mut Vec<f64>,
        token: &CancelToken,
    ) -> Result<(), ElasticityError> {
        energies.resize(lattice.tets.len(), 0.0);
        let fill = |driving, energies: &mut [f64]| {
            let chunks = lattice.tets.par_chunks(CHUNK).zip(energies.par_chunks_mut(CHUNK));
            self.elements.blocks.par_chunks(CHUNK / SIDE).zip(chunks).try_for_each(|(blocks, (corners, energies))| {
                token.check()?;
                widest(StrainEnergies { lame: self.lame, driving, blocks, corners, strains, energies });
                Ok::<_, ElasticityError>(())
            })
        };
        fill(DrivingEnergy::Total, energies)?;
        let sum: f64 = energies.iter().sum();
        if driving == DrivingEnergy::Tensile {
            fill(driving, energies)?;
        }
        if sum > 0.0 {
            energies.iter_mut().for_each(|energy| *energy *= whole / sum);
        }
        Ok(())
    }

    fn quadratic_energy(
        &self,
        edges: &EdgeFunctions,
        displacement: &[f64],
        driving: DrivingEnergy,
        energies: &mut [f64],
        token: &CancelToken,
    ) -> Result<(), ElasticityError> {
        let (lame, displacement) = (self.lame, displacement.split_at(self.size()));
        let blocks = self.elements.blocks.par_chunks(CHUNK / SIDE);
        let places = edges.corners.par_chunks(CHUNK).zip(edges.tets.par_chunks(CHUNK));
        blocks.zip(places.zip(energies.par_chunks_mut(CHUNK))).try_for_each(|(blocks, ((corners, edges), energies))| {
            token.check()?;
            widest(QuadraticEnergies { lame, driving, blocks, corners, edges, displacement, energies });
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;
    use crate::random::RandomStream;
    use crate::simd::tests::same_on_every_path;

    #[test]
    fn wide_and_plain_instructions_give_the_same_bits() {
        let lattice = block([3, 2, 3], 0.1);
        let body = Elasticity::prepare(&lattice, 0.3, &CancelToken::default()).unwrap();
        let mut stream = RandomStream::new(5, 0);
        let displacement: Vec<f64> = (0..body.size()).map(|_| stream.uniform() - 0.5).collect();
        for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
            let plain = same_on_every_path(|| {
                let mut energies = Vec::new();
                body.tet_energy(&lattice, &displacement, driving, &mut energies, &CancelToken::default()).unwrap();
                energies
            });
            assert!(plain.iter().all(|energy| *energy >= 0.0 && energy.is_finite()) && plain[0] > 0.0);
        }
    }
}
