//! The stages of a strike, in the order in which data flows, and who watches them.

use crate::scene::EffectKind;
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

/// Told when a stage begins and ends. The science has no clock; whoever calls it may bring one.
pub trait StageObserver {
    /// Stage `stage` begins. A stage may be entered once per body.
    fn enter(&mut self, stage: Stage);
    /// Stage `stage` ends, having produced `bytes` bytes of results.
    fn leave(&mut self, stage: Stage, bytes: u64);
    /// Effect `effect` begins, within a stage or outside. What it takes is not the stage's.
    fn begin(&mut self, effect: EffectKind);
    /// Effect `effect` ends, having produced `bytes` bytes of results, or used tables of so many.
    fn end(&mut self, effect: EffectKind, bytes: u64);
    /// Effect `effect` is part of what a stage does, which uses `bytes` bytes of tables for it.
    fn part(&mut self, effect: EffectKind, bytes: u64);
    /// Seconds that are left until the answer shall be sent, less than 0 after that; infinity where it may take any time.
    fn remaining_s(&self) -> f64 {
        f64::INFINITY
    }
}

/// Watches nothing.
impl StageObserver for () {
    fn enter(&mut self, _: Stage) {}
    fn leave(&mut self, _: Stage, _: u64) {}
    fn begin(&mut self, _: EffectKind) {}
    fn end(&mut self, _: EffectKind, _: u64) {}
    fn part(&mut self, _: EffectKind, _: u64) {}
}
