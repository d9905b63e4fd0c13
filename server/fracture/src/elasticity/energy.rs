//! Strain energy per tetrahedron.

use super::element::{Lame, strain};
use super::{Elasticity, ElasticityError};
use crate::lattice::Lattice;
use crate::token::Token;
use nalgebra::Matrix3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Tetrahedra between two looks at the token.
const CHUNK: usize = 4096;

/// Which part of the strain energy drives cracks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Driving {
    /// All of it, ½ σ:ε.
    #[default]
    Total,
    /// The tensile part of the spectral split (Miehe et al. 2010): compression drives nothing.
    Tensile,
}

impl Elasticity {
    /// ∫ W over each tetrahedron into `energies` (length `lattice.tets.len()`), from `displacement` (length 3 · nodes).
    /// With [`Driving::Total`] their sum is ½ f·u.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`], [`ElasticityError::Cancelled`].
    pub fn tet_energy(
        &self,
        lattice: &Lattice,
        displacement: &[f64],
        driving: Driving,
        energies: &mut Vec<f64>,
        token: &Token,
    ) -> Result<(), ElasticityError> {
        self.check_length("the displacement", displacement)?;
        let (expected, found) = (self.tets, lattice.tets.len());
        if expected != found || lattice.nodes.len() * 3 != self.size() {
            return Err(ElasticityError::OtherLattice { what: "the lattice", expected, found });
        }
        energies.resize(found, 0.0);
        let density: fn(Lame, &Matrix3<f64>) -> f64 = match driving {
            Driving::Total => Lame::energy_density,
            Driving::Tensile => Lame::tensile_energy_density,
        };
        energies.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, energies)| {
            token.check()?;
            for (offset, energy) in energies.iter_mut().enumerate() {
                let (strain, volume) = strain(lattice, chunk * CHUNK + offset, displacement);
                *energy = density(self.lame, &strain) * volume;
            }
            Ok(())
        })
    }
}
