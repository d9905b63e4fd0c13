//! The clock that the science does not have: times and spans per stage.

use crate::object::EngineResult;
use shatter_fracture::pipeline::{Stage, StageObserver};
use shatter_fracture::scene::EffectKind;
use shatter_proto::Error;
use shatter_proto::layout::SectionsMut;
use shatter_proto::result::{EffectWire, STAGES, StageWire};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;
use tracing::span::EnteredSpan;

/// The stage that a strike is in, for those who ask: its number.
pub type CurrentStage = Arc<AtomicU32>;

/// Watches one strike.
pub struct StageProfiler {
    rows: [StageWire; STAGES.len()],
    effects: [EffectWire; EffectKind::ALL.len()],
    shown: CurrentStage,
    entered: Option<(Instant, EnteredSpan)>,
    begun: Option<Instant>,
    /// What effects took of the stage that is entered.
    others_ns: u64,
    /// Where the energy came from, once that is written.
    energy: Option<&'static str>,
    /// When the answer shall be sent.
    due: Option<Instant>,
}

impl Default for StageProfiler {
    fn default() -> Self {
        Self::showing(CurrentStage::default())
    }
}

impl StageProfiler {
    /// One that shows the stage that it is in.
    pub fn showing(shown: CurrentStage) -> Self {
        let rows = std::array::from_fn(|stage| StageWire { stage: stage as u32, ran: 0, ns: 0, bytes: 0 });
        let effects = std::array::from_fn(|effect| EffectWire { effect: effect as u32, ran: 0, ns: 0, bytes: 0 });
        Self { rows, effects, shown, entered: None, begun: None, others_ns: 0, energy: None, due: None }
    }

    /// The answer shall be sent by then.
    pub fn until(&mut self, due: Option<Instant>) {
        self.due = due;
    }

    /// Writes an outcome into its sections as part of the last stage, whose results are `bytes` long, and then what every stage and
    /// effect did.
    pub fn write(
        &mut self,
        outcome: &dyn EngineResult,
        sections: &mut SectionsMut<'_>,
        bytes: u64,
    ) -> Result<(), Error> {
        // An object that stays whole has no fragments: the stage does not run.
        let broken = !sections.fragments.is_empty();
        if broken {
            self.enter(Stage::Fragments);
        }
        let written = outcome.write(sections, self);
        if broken {
            self.leave(Stage::Fragments, bytes);
        }
        written?;
        self.energy = Some(sections.summary.elastic());
        sections.stages.copy_from_slice(&self.rows());
        sections.effects.copy_from_slice(&self.effects());
        Ok(())
    }

    fn count(&mut self, effect: EffectKind, ns: u64, bytes: u64) {
        let row = &mut self.effects[effect as usize];
        (row.ran, row.ns, row.bytes) = (1, row.ns.saturating_add(ns), row.bytes.saturating_add(bytes));
        tracing::debug!(ns, bytes, "{}", effect.name());
    }

    /// Where the energy of the strike came from, by its name in an answer; `None` without one.
    pub fn energy(&self) -> Option<&'static str> {
        self.energy
    }

    /// One row per effect, also for those that did not run.
    pub fn effects(&self) -> [EffectWire; EffectKind::ALL.len()] {
        self.effects
    }

    /// One row per stage, also for those that did not run.
    pub fn rows(&self) -> [StageWire; STAGES.len()] {
        self.rows
    }
}

fn ns_since(since: Instant) -> u64 {
    u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

impl StageObserver for StageProfiler {
    fn enter(&mut self, stage: Stage) {
        let span = tracing::debug_span!("stage", stage = stage.name()).entered();
        self.shown.store(stage as u32, Ordering::Relaxed);
        (self.entered, self.others_ns) = (Some((Instant::now(), span)), 0);
    }

    fn leave(&mut self, stage: Stage, bytes: u64) {
        if let Some((since, _span)) = self.entered.take() {
            let ns = ns_since(since).saturating_sub(self.others_ns);
            let row = &mut self.rows[stage as usize];
            (row.ran, row.ns, row.bytes) = (1, row.ns.saturating_add(ns), row.bytes.saturating_add(bytes));
            tracing::debug!(ns, bytes, "{}", stage.name());
        }
    }

    fn begin(&mut self, _: EffectKind) {
        self.begun = Some(Instant::now());
    }

    fn end(&mut self, effect: EffectKind, bytes: u64) {
        if let Some(since) = self.begun.take() {
            let ns = ns_since(since);
            self.others_ns = self.others_ns.saturating_add(ns);
            self.count(effect, ns, bytes);
        }
    }

    fn part(&mut self, effect: EffectKind, bytes: u64) {
        self.count(effect, 0, bytes);
    }

    fn remaining_s(&self) -> f64 {
        let now = Instant::now();
        self.due.map_or(f64::INFINITY, |due| {
            due.saturating_duration_since(now).as_secs_f64() - now.saturating_duration_since(due).as_secs_f64()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::scene::EffectSet;

    #[test]
    fn stages_have_the_same_numbers_and_names_on_the_wire() {
        for (stage, name) in Stage::ALL.into_iter().zip(STAGES) {
            assert_eq!((stage.name(), STAGES[stage as usize]), (name, name));
        }
    }

    #[test]
    fn effects_have_the_same_numbers_and_names_on_the_wire() {
        for (effect, wire) in EffectKind::ALL.into_iter().zip(shatter_proto::effect::Effect::ALL) {
            assert_eq!((effect.name(), effect as u32), (wire.name(), wire as u32));
            assert_eq!(EffectSet::default().has(effect), wire.default_on());
        }
        assert_eq!(EffectKind::ALL.len(), shatter_proto::effect::Effect::ALL.len());
    }

    #[test]
    fn what_an_effect_takes_is_not_its_stages() {
        let mut clock = StageProfiler::default();
        clock.enter(Stage::Fragments);
        clock.begin(EffectKind::Bonds);
        std::thread::sleep(std::time::Duration::from_millis(20));
        clock.end(EffectKind::Bonds, 64);
        clock.leave(Stage::Fragments, 7);
        clock.part(EffectKind::Interior, 9);
        let [bonds, interior] =
            [EffectKind::Bonds, EffectKind::Interior].map(|effect| clock.effects()[effect as usize]);
        assert_eq!((bonds.ran, bonds.bytes, bonds.name()), (1, 64, "bonds"));
        assert_eq!((interior.ran, interior.ns, interior.bytes), (1, 0, 9));
        assert!(clock.rows()[7].ns < bonds.ns, "{:?} {bonds:?}", clock.rows()[7]);
        assert_eq!(clock.effects().iter().filter(|row| row.ran == 0 && (row.ns, row.bytes) == (0, 0)).count(), 14);
    }

    #[test]
    fn a_stage_entered_twice_adds_up_and_others_did_not_run() {
        let shown = CurrentStage::default();
        let mut clock = StageProfiler::showing(shown.clone());
        for bytes in [3, 4] {
            clock.enter(Stage::Labels);
            clock.leave(Stage::Labels, bytes);
        }
        let rows = clock.rows();
        assert_eq!(shown.load(Ordering::Relaxed), 5);
        assert_eq!((rows[5].ran, rows[5].bytes, rows[5].name()), (1, 7, "labels"));
        assert!(rows.iter().filter(|row| row.stage != 5).all(|row| (row.ran, row.ns, row.bytes) == (0, 0, 0)));
    }
}
