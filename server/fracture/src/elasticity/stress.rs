//! Strains of tetrahedra and nodes, and the stresses that belong to them.

use super::blocks::SIDE;
use super::strain::principal_strains;
use super::{BoundaryNodes, Elasticity, ElasticityError};
use crate::lattice::Lattice;
use crate::simd::SimdLanes;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Components xx, yy, zz, xy, yz, xz of a strain.
pub type StrainComponents = [f64; 6];

impl Elasticity {
    /// Boundary of the lattice.
    pub fn boundary(&self) -> &BoundaryNodes {
        &self.boundary
    }

    /// Strains of all tetrahedra under a `displacement` of linear elements, [`Self::size`] entries; resizes `strains`.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`].
    pub fn tet_strains(
        &self,
        lattice: &Lattice,
        displacement: &[f64],
        strains: &mut Vec<StrainComponents>,
    ) -> Result<(), ElasticityError> {
        for (what, expected, found) in
            [("the displacement", self.size(), displacement.len()), ("the lattice", self.tets, lattice.tets.len())]
        {
            if expected != found {
                return Err(ElasticityError::OtherLattice { what, expected, found });
            }
        }
        strains.clear();
        for (block, tets) in self.elements.blocks.iter().zip(lattice.tets.chunks(SIDE)) {
            let strain = block.strain(tets, displacement);
            strains.extend((0..tets.len()).map(|lane| strain.map(|component| component.0[lane])));
        }
        Ok(())
    }

    /// Strains at all nodes under a `displacement` of quadratic elements, six components each; `None` for linear ones.
    ///
    /// Each is the mean over the tetrahedra around the node, by volume. It is exact where strains are linear.
    pub fn corner_strains(&self, displacement: &[f64]) -> Option<Vec<f64>> {
        Some(self.edges.as_ref()?.node_strains(&self.elements.blocks, displacement))
    }

    /// Principal stresses σ₁ ≥ σ₂ ≥ σ₃ at a strain, for Young's modulus 1: σ = λ tr ε + 2μ ε.
    pub fn principal_stresses(&self, strain: &StrainComponents) -> [f64; 3] {
        let pressure = self.lame.lambda * (strain[0] + strain[1] + strain[2]);
        let mut principal = principal_strains(&strain.map(|component| SimdLanes([component])))
            .map(|own| pressure + 2.0 * self.lame.mu * own.0[0]);
        principal.sort_by(|a, b| b.total_cmp(a));
        principal
    }
}

/// Direction of the largest principal strain, which is that of the largest principal stress. Its sign is arbitrary but
/// equal for equal strains.
pub fn tension_direction(strain: &StrainComponents) -> Vector3<f64> {
    let [xx, yy, zz, xy, yz, xz] = *strain;
    let eigen = SymmetricEigen::new(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
    eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::lattice::block;

    #[test]
    fn principal_stresses_follow_the_law_of_the_material() {
        let lattice = block([1, 1, 1], 0.5);
        let body = Elasticity::prepare(&lattice, 0.25, &CancelToken::default()).unwrap();
        // Uniaxial tension of 3 along y: ε_y = 3, others −0.25 · 3.
        let strain = [-0.75, 3.0, -0.75, 0.0, 0.0, 0.0];
        let found = body.principal_stresses(&strain);
        assert!((found[0] - 3.0).abs() < 1e-12 && found[1].abs() < 1e-7 && found[2].abs() < 1e-7, "{found:?}");
        assert!((tension_direction(&strain).y.abs() - 1.0).abs() < 1e-12);
        // A shear strain of 0.2 is a stress of ±2μ · 0.2.
        let found = body.principal_stresses(&[0.0, 0.0, 0.0, 0.2, 0.0, 0.0]);
        assert!((found[0] - 0.16).abs() < 1e-12 && (found[2] + 0.16).abs() < 1e-12, "{found:?}");
    }
}
