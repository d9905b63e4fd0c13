//! Presets: four points on the curve of accuracy over time, each a bundle of numbers.
//!
//! A bake fixes the lattices, a strike chooses among what is left. Numbers that are given by themselves go before those of a preset.

use super::parameters::RANK_MAX;
use crate::lattice::{CRACK_NODES_DEFAULT, ELASTIC_NODES_DEFAULT};
use crate::lift::MODES_DEFAULT;
use serde::{Deserialize, Serialize};
/// A preset, from fast to accurate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// A third of everything, to try things out and for what is far away.
    Draft,
    /// A strike within a frame.
    #[default]
    Game,
    /// Cracks as fine as they are seen close up.
    Film,
    /// What the others are measured by.
    Reference,
}

/// What a bake fixes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeSettings {
    /// Elastic nodes aimed at.
    pub elastic_nodes: usize,
    /// Crack nodes aimed at.
    pub crack_nodes: usize,
    /// Neumann modes asked of the interior lift.
    pub modes: usize,
    /// Displacements of a body's basis at most.
    pub rank_max: usize,
    /// Whether the crack lattice's boundary is fitted to ridges and creases.
    pub fitted: bool,
}

impl Preset {
    /// All of them, from fast to accurate.
    pub const ALL: [Self; 4] = [Self::Draft, Self::Game, Self::Film, Self::Reference];

    /// The name used in scenes, on command lines and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Game => "game",
            Self::Film => "film",
            Self::Reference => "reference",
        }
    }

    /// The preset of that name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quality| quality.name() == name)
    }

    /// The next preset whose lattices are finer.
    pub fn finer(self) -> Option<Self> {
        match self {
            Self::Draft => Some(Self::Game),
            Self::Game => Some(Self::Film),
            Self::Film | Self::Reference => None,
        }
    }

    /// What a bake of it fixes.
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
