//! Costs of stages and effects: as rows of shared memory, and as a host reads them.

use crate::codes::StageKind;
use crate::effect::Effect;
use bytemuck::{Pod, Zeroable};
use std::time::Duration;

/// Cost of one stage: a row of shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct StageWire {
    /// Number of a [`StageKind`].
    pub stage: u32,
    /// 1 if it ran.
    pub ran: u32,
    /// Time it took, ns; like those of effects it differs between equal requests.
    pub ns: u64,
    /// Bytes of results it produced.
    pub bytes: u64,
}

/// Cost of one effect: a row of shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct EffectWire {
    /// Its bit: position in [`Effect::ALL`].
    pub effect: u32,
    /// 1 if it ran.
    pub ran: u32,
    /// Time it took by itself, ns; zero where it is part of a stage.
    pub ns: u64,
    /// Bytes of results it produced, or of tables it used.
    pub bytes: u64,
}

/// Cost of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
#[non_exhaustive]
pub struct StageCost {
    /// The stage.
    pub stage: StageKind,
    /// Whether it ran; time and bytes are zero otherwise.
    pub has_run: bool,
    /// Time it took; differs between equal requests.
    pub time: Duration,
    /// Bytes of results it produced.
    pub bytes: u64,
}

/// Cost of one effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
#[non_exhaustive]
pub struct EffectCost {
    /// The effect.
    pub effect: Effect,
    /// Whether it ran; time and bytes are zero otherwise.
    pub has_run: bool,
    /// Time it took by itself; zero where it is part of a stage. Differs between equal requests.
    pub time: Duration,
    /// Bytes of results it produced, or of tables it used.
    pub bytes: u64,
}

impl StageCost {
    /// A stage that has not run.
    pub fn idle(stage: StageKind) -> Self {
        Self { stage, has_run: false, time: Duration::ZERO, bytes: 0 }
    }

    /// Adds a run of the stage.
    pub fn add(&mut self, time: Duration, bytes: u64) {
        (self.has_run, self.time) = (true, self.time.saturating_add(time));
        self.bytes = self.bytes.saturating_add(bytes);
    }
}

impl EffectCost {
    /// An effect that has not run.
    pub fn idle(effect: Effect) -> Self {
        Self { effect, has_run: false, time: Duration::ZERO, bytes: 0 }
    }

    /// Adds a run of the effect.
    pub fn add(&mut self, time: Duration, bytes: u64) {
        (self.has_run, self.time) = (true, self.time.saturating_add(time));
        self.bytes = self.bytes.saturating_add(bytes);
    }
}

impl From<&StageWire> for StageCost {
    fn from(row: &StageWire) -> Self {
        let stage = StageKind::from_code(row.stage);
        Self { stage, has_run: row.ran != 0, time: Duration::from_nanos(row.ns), bytes: row.bytes }
    }
}

impl EffectWire {
    /// Cost of the effect; `None` for a number that this version does not know.
    pub fn cost(&self) -> Option<EffectCost> {
        let effect = *Effect::ALL.get(self.effect as usize)?;
        Some(EffectCost { effect, has_run: self.ran != 0, time: Duration::from_nanos(self.ns), bytes: self.bytes })
    }
}

impl From<&StageCost> for StageWire {
    fn from(cost: &StageCost) -> Self {
        Self { stage: cost.stage.code(), ran: u32::from(cost.has_run), ns: nanoseconds(cost.time), bytes: cost.bytes }
    }
}

impl From<&EffectCost> for EffectWire {
    fn from(cost: &EffectCost) -> Self {
        Self { effect: cost.effect as u32, ran: u32::from(cost.has_run), ns: nanoseconds(cost.time), bytes: cost.bytes }
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_round_trip_and_add_up() {
        let mut stage = StageCost::idle(StageKind::Labels);
        assert_eq!(StageWire::from(&stage), StageWire { stage: 5, ran: 0, ns: 0, bytes: 0 });
        stage.add(Duration::from_nanos(3), 4);
        stage.add(Duration::from_nanos(2), 5);
        assert_eq!(StageWire::from(&stage), StageWire { stage: 5, ran: 1, ns: 5, bytes: 9 });
        assert_eq!(StageCost::from(&StageWire::from(&stage)), stage);
        let mut effect = EffectCost::idle(Effect::Bonds);
        effect.add(Duration::MAX, 64);
        assert_eq!(EffectWire::from(&effect), EffectWire { effect: 8, ran: 1, ns: u64::MAX, bytes: 64 });
        assert_eq!(EffectWire::from(&EffectCost::idle(Effect::Uv)).cost(), Some(EffectCost::idle(Effect::Uv)));
        assert_eq!(EffectWire { effect: 99, ran: 0, ns: 0, bytes: 0 }.cost(), None);
    }
}
