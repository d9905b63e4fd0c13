//! Strain energy of tetrahedra.

use super::blocks::{Block, SIDE};
use super::element::Lame;
use super::quadratic::{EdgeFunctions, QuadraticEnergies, StrainEnergies, StrainRows, TensileStrainEnergies};
use super::{ElasticWorkspace, Elasticity, ElasticityError, NodalLoad};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::simd::widest;
use pulp::NullaryFnOnce;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

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

    /// Adds the energy of the near field of `load`, times `share`, to that of tetrahedra.
    pub fn add_near_field(&self, load: &NodalLoad, share: f64, energies: &mut [f64]) {
        self.near_field(load).for_each(|(tet, energy)| energies[tet] += share * energy);
    }

    /// Sum of values of tetrahedra, weighted by the energy of the near field of `load`.
    pub fn near_field_sum(&self, load: &NodalLoad, values: &[f64]) -> f64 {
        self.near_field(load).map(|(tet, energy)| values[tet] * energy).sum()
    }

    /// Energy of the near field by tetrahedra behind the faces around the loaded nodes, in proportion to their areas.
    fn near_field(&self, load: &NodalLoad) -> impl Iterator<Item = (usize, f64)> {
        let boundary = &self.boundary;
        load.near.iter().filter(|(_, energy)| *energy > 0.0).flat_map(move |&(node, energy)| {
            let unit = energy / (3.0 * boundary.areas[node as usize]);
            let faces = boundary.around(node).iter().map(|&face| face as usize);
            faces.map(move |face| (boundary.tets[face] as usize, unit * boundary.area(face)))
        })
    }

    /// Tetrahedron of `lattice` with the most energy under the test load that the factor failed: it is in the joint about which parts
    /// move freely. `None` if the factor did not fail so, or the elements are quadratic.
    pub fn weakest_tet(&self, lattice: &Lattice) -> Option<usize> {
        let (displacement, mut energies) = (self.failed.get()?, Vec::new());
        self.tet_energy(lattice, displacement, DrivingEnergy::Total, &mut energies, &CancelToken::default()).ok()?;
        energies.iter().enumerate().max_by(|one, other| one.1.total_cmp(other.1)).map(|(tet, _)| tet)
    }

    /// Computes ∫ W over each quadratic tetrahedron from strains at the nodes, six components each, in proportion to a whole
    /// energy.
    ///
    /// The sum of the energies of all parts is `whole`; with [`DrivingEnergy::Tensile`], that of the tensile parts is
    /// their share of it.
    ///
    /// # Errors
    /// [`ElasticityError::Canceled`].
    pub(super) fn strain_energy(
        &self,
        edges: &EdgeFunctions,
        strains: &[f64],
        (driving, whole): (DrivingEnergy, f64),
        (energies, workspace): (&mut Vec<f64>, &mut ElasticWorkspace),
        token: &CancelToken,
    ) -> Result<(), ElasticityError> {
        energies.resize(self.tets, 0.0);
        let (lame, strains) = (self.lame, strains.as_chunks().0);
        let rows = &mut workspace.strain_rows;
        rows.resize(strains.len(), Default::default());
        rows.par_chunks_mut(CHUNK).zip(strains.par_chunks(CHUNK)).for_each(|(rows, strains)| {
            widest(StrainRows { lame, strains, rows });
        });
        let chunks = edges.corners.par_chunks(CHUNK).zip(edges.volumes.par_chunks(CHUNK));
        chunks.zip(energies.par_chunks_mut(CHUNK)).try_for_each(|((corners, volumes), energies)| {
            token.check()?;
            widest(StrainEnergies { lame, volumes, corners, rows, energies });
            Ok::<_, ElasticityError>(())
        })?;
        let sum: f64 = energies.iter().sum();
        if driving == DrivingEnergy::Tensile {
            let chunks = self.elements.blocks.par_chunks(CHUNK / SIDE).zip(edges.corners.par_chunks(CHUNK));
            chunks.zip(energies.par_chunks_mut(CHUNK)).try_for_each(|((blocks, corners), energies)| {
                token.check()?;
                widest(TensileStrainEnergies { lame, blocks, corners, strains, energies });
                Ok::<_, ElasticityError>(())
            })?;
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
    use crate::elasticity::ElementOrder;
    use crate::elasticity::quadratic::energies as energies_at_points;
    use crate::lattice::block;
    use crate::random::RandomStream;
    use crate::simd::SimdLanes;
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
        let body = body.of_order(ElementOrder::Quadratic, &lattice).unwrap();
        let edges = body.edges.as_ref().unwrap();
        let strains: Vec<f64> = (0..2 * body.size()).map(|_| stream.uniform() - 0.5).collect();
        for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
            same_on_every_path(|| {
                let (mut energies, mut workspace) = (Vec::new(), ElasticWorkspace::default());
                let parts = (&mut energies, &mut workspace);
                body.strain_energy(edges, &strains, (driving, 1.0), parts, &CancelToken::default()).unwrap();
                energies
            });
        }
    }

    /// Strains that are linear between the corners: the energies of their kernels, and of the rule of four points.
    #[test]
    fn energies_of_node_strains_are_those_of_the_quadrature() {
        let lattice = block([3, 2, 3], 0.1);
        let body = Elasticity::assembled(&lattice, 0.3, &CancelToken::default()).unwrap();
        let body = body.of_order(ElementOrder::Quadratic, &lattice).unwrap();
        let mut stream = RandomStream::new(6, 0);
        let strains: Vec<f64> = (0..2 * body.size()).map(|_| stream.uniform() - 0.5).collect();
        let (mut energies, mut workspace) = (Vec::new(), ElasticWorkspace::default());
        let parts = (&mut energies, &mut workspace);
        let edges = body.edges.as_ref().unwrap();
        body.strain_energy(edges, &strains, (DrivingEnergy::Total, 1.0), parts, &CancelToken::default()).unwrap();
        let of_tet = |tet: usize| {
            let at = |node: u32| std::array::from_fn(|k| SimdLanes::all(strains[6 * node as usize + k]));
            energies_at_points::<false>(body.lame, SimdLanes::all(lattice.tet_volume(tet)), &lattice.tets[tet].map(at))
                .0[0]
        };
        let expected: Vec<f64> = (0..lattice.tets.len()).map(of_tet).collect();
        let sum: f64 = expected.iter().sum();
        let far = |(own, expected): (&f64, &f64)| (own - expected / sum).abs() > 1e-6 * expected / sum;
        assert!(!energies.iter().zip(&expected).any(far));
    }
}
