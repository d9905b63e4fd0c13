//! Solution with linear elements of a body of any order.
//!
//! The functions of the nodes are those of the linear elements, and the factor is that of their stiffness. So the part of
//! a load on them is the load of the linear elements.

use super::{ElasticWorkspace, Elasticity, ElasticityError};

impl Elasticity {
    /// Displacement of linear elements (length [`Self::size`]) under `forces` (length [`Self::unknowns`]).
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`], those of [`Self::factor`].
    pub fn linear_displacement(
        &self,
        forces: &[f64],
        workspace: &mut ElasticWorkspace,
    ) -> Result<Vec<f64>, ElasticityError> {
        self.check_length("the load", forces)?;
        let mut displacement = forces[..self.size()].to_vec();
        self.back_substitute(self.factor()?, &mut displacement, workspace);
        Ok(displacement)
    }

    /// Energy of linear elements under `forces`, from a `displacement` that solves them about.
    ///
    /// It is the work of the forces less the strain energy, f·u − ½ u·K u, to which an error of the displacement
    /// contributes by its square only.
    pub fn linear_energy(&self, forces: &[f64], displacement: &[f64]) -> f64 {
        let mut image = vec![0.0; self.size()];
        self.stiffness.multiply(displacement, &mut image);
        let works = displacement.iter().zip(forces).zip(&image);
        works.map(|((own, force), image)| own * (force - 0.5 * image)).sum()
    }
}
