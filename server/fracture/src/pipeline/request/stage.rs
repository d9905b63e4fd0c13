//! The stages of a strike, in the order in which data flows.

use serde::{Deserialize, Serialize};

/// A stage of a strike; names as in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Contacts to nodal forces, rigid acceleration taken out.
    Load,
    /// One back-substitution.
    Elasticity,
    /// First moment of the strain energy against γ.
    Threshold,
    /// The number of sites.
    Degree,
    /// Energy-weighted centroidal Voronoi diagram in the lift.
    Centroidal,
    /// Cells to connected fragments.
    Labels,
    /// Crack polygons: count.
    Tessellation,
    /// Masses, and the emission of the meshes.
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

    /// The name used in JSON, logs and metrics.
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
