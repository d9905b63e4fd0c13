//! Presets: four trade-offs of accuracy against time, each a set of numbers.
//!
//! A bake fixes the lattices; a request chooses the rest. Numbers given explicitly take precedence over those of a
//! preset.

use super::parameters::RANK_MAX;
use crate::lattice::{CRACK_NODES_DEFAULT, ELASTIC_NODES_DEFAULT};
use crate::lift::MODES_DEFAULT;
use serde::{Deserialize, Serialize};
/// A preset, from fast to accurate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// A third of the crack nodes of `game`, for previews and distant objects.
    Draft,
    /// A request within one frame.
    #[default]
    Game,
    /// Cracks fine enough for close views.
    Film,
    /// Reference solution by which the other presets are measured.
    Reference,
}

/// Settings of a preset that a bake fixes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeSettings {
    /// Target number of elastic nodes.
    pub elastic_nodes: usize,
    /// Target number of crack nodes.
    pub crack_nodes: usize,
    /// Number of Neumann modes requested for the interior lift.
    pub modes: usize,
    /// Largest number of displacements of a body's basis.
    pub rank_max: usize,
    /// True if the crack lattice's boundary is fitted to ridges and creases.
    pub fitted: bool,
}

impl Preset {
    /// All presets, from fast to accurate.
    pub const ALL: [Self; 4] = [Self::Draft, Self::Game, Self::Film, Self::Reference];

    /// Name used in scenes, on command lines and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Game => "game",
            Self::Film => "film",
            Self::Reference => "reference",
        }
    }

    /// The preset with the given name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| quality.name() == name)
    }

    /// The next preset with finer lattices, if any.
    pub fn finer(self) -> Option<Self> {
        match self {
            Self::Draft => Some(Self::Game),
            Self::Game => Some(Self::Film),
            Self::Film | Self::Reference => None,
        }
    }

    /// The settings of a bake of this preset.
    pub fn lattices(self) -> LatticeSettings {
        let [elastic_nodes, crack_nodes] = match self {
            Self::Draft => [ELASTIC_NODES_DEFAULT / 2, 3_000],
            Self::Game => [ELASTIC_NODES_DEFAULT, CRACK_NODES_DEFAULT],
            Self::Film | Self::Reference => [4 * ELASTIC_NODES_DEFAULT, 100_000],
        };
        LatticeSettings {
            elastic_nodes,
            crack_nodes,
            modes: MODES_DEFAULT,
            rank_max: RANK_MAX,
            fitted: self >= Self::Film,
        }
    }
}
