//! The stages of a request, in the order of data flow.

use serde::{Deserialize, Serialize};

/// A stage of a request, named as in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Converts contacts to nodal forces and removes the rigid acceleration.
    Load,
    /// Computes displacements by one back-substitution or from the reduced basis, and strain energies.
    Elasticity,
    /// Compares the first moment of the strain energy to γ.
    Threshold,
    /// Chooses the number of sites.
    Degree,
    /// Computes the energy-weighted centroidal Voronoi diagram in the lift.
    Centroidal,
    /// Splits cells into connected fragments.
    Labels,
    /// Computes the crack polygons and counts the output.
    Tessellation,
    /// Computes masses and emits the meshes.
    Fragments,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Self; 8] = [
        Self::Load,
        Self::Elasticity,
        Self::Threshold,
        Self::Degree,
        Self::Centroidal,
        Self::Labels,
        Self::Tessellation,
        Self::Fragments,
    ];

    /// Name used in JSON, logs and metrics.
    pub fn name(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Elasticity => "elasticity",
            Self::Threshold => "threshold",
            Self::Degree => "degree",
            Self::Centroidal => "centroidal",
            Self::Labels => "labels",
            Self::Tessellation => "tessellation",
            Self::Fragments => "fragments",
        }
    }
}
