//! Profiler of a request: times and tracing spans per stage. The simulation itself reads no clock.

use crate::object::EngineResult;
use shatter_fracture::pipeline::{Stage, StageObserver};
use shatter_fracture::scene::EffectKind;
use shatter_proto::Error;
use shatter_proto::layout::SectionsMut;
use shatter_proto::result::{EffectWire, STAGES, StageWire};
use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;
use tracing::span::EnteredSpan;

/// Number of the current stage of a request, readable from other threads.
pub type CurrentStage = Arc<AtomicU32>;

/// Profiler of one request.
pub struct StageProfiler {
    shown: CurrentStage,
    times: RefCell<Times>,
    /// Source of the energy, once the result is written.
    energy: Cell<Option<&'static str>>,
}

/// Measurements of a request.
struct Times {
    rows: [StageWire; STAGES.len()],
    effects: [EffectWire; EffectKind::ALL.len()],
    entered: Option<(Instant, EnteredSpan)>,
    begun: Option<Instant>,
    /// Time of effects inside the current stage, ns.
    others_ns: u64,
}

impl Default for StageProfiler {
    fn default() -> Self {
        Self::showing(CurrentStage::default())
    }
}

impl StageProfiler {
    /// Creates a profiler that publishes its current stage in `shown`.
    pub fn showing(shown: CurrentStage) -> Self {
        let rows = std::array::from_fn(|stage| StageWire { stage: stage as u32, ran: 0, ns: 0, bytes: 0 });
        let effects = std::array::from_fn(|effect| EffectWire { effect: effect as u32, ran: 0, ns: 0, bytes: 0 });
        let times = Times { rows, effects, entered: None, begun: None, others_ns: 0 };
        Self { shown, times: RefCell::new(times), energy: Cell::new(None) }
    }

    /// Writes a result into its sections as part of the last stage, whose output has `bytes` bytes, then the rows of all stages and
    /// effects.
    ///
    /// # Errors
    /// Those of the result.
    pub fn write(&self, result: &dyn EngineResult, sections: &mut SectionsMut<'_>, bytes: u64) -> Result<(), Error> {
        let observer: &dyn StageObserver = self;
        // An object that stays whole has no fragments, so the stage does not run.
        let stage = (!sections.fragments.is_empty()).then(|| observer.stage(Stage::Fragments));
        result.write(sections, observer)?;
        if let Some(stage) = stage {
            stage.produced_bytes(bytes);
        }
        self.energy.set(Some(sections.summary.elastic()));
        sections.stages.copy_from_slice(&self.rows());
        sections.effects.copy_from_slice(&self.effects());
        Ok(())
    }

    /// Source of the energy, by its name in a result; `None` before the result is written.
    pub fn energy(&self) -> Option<&'static str> {
        self.energy.get()
    }

    /// One row per effect, including those that did not run.
    pub fn effects(&self) -> [EffectWire; EffectKind::ALL.len()] {
        self.times.borrow().effects
    }

    /// One row per stage, including those that did not run.
    pub fn rows(&self) -> [StageWire; STAGES.len()] {
        self.times.borrow().rows
    }
}

impl Times {
    fn count(&mut self, effect: EffectKind, ns: u64, bytes: u64) {
        let row = &mut self.effects[effect as usize];
        (row.ran, row.ns, row.bytes) = (1, row.ns.saturating_add(ns), row.bytes.saturating_add(bytes));
        tracing::debug!(ns, bytes, "{}", effect.name());
    }
}

fn ns_since(since: Instant) -> u64 {
    u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

impl StageObserver for StageProfiler {
    fn enter(&self, stage: Stage) {
        let span = tracing::debug_span!("stage", stage = stage.name()).entered();
        self.shown.store(stage as u32, Ordering::Relaxed);
        let mut times = self.times.borrow_mut();
        (times.entered, times.others_ns) = (Some((Instant::now(), span)), 0);
    }

    fn leave(&self, stage: Stage, bytes: u64) {
        let mut times = self.times.borrow_mut();
        if let Some((since, _span)) = times.entered.take() {
            let ns = ns_since(since).saturating_sub(times.others_ns);
            let row = &mut times.rows[stage as usize];
            (row.ran, row.ns, row.bytes) = (1, row.ns.saturating_add(ns), row.bytes.saturating_add(bytes));
            tracing::debug!(ns, bytes, "{}", stage.name());
        }
    }

    fn begin(&self, _: EffectKind) {
        self.times.borrow_mut().begun = Some(Instant::now());
    }

    fn end(&self, effect: EffectKind, bytes: u64) {
        let mut times = self.times.borrow_mut();
        if let Some(since) = times.begun.take() {
            let ns = ns_since(since);
            times.others_ns = times.others_ns.saturating_add(ns);
            times.count(effect, ns, bytes);
        }
    }

    fn part(&self, effect: EffectKind, bytes: u64) {
        self.times.borrow_mut().count(effect, 0, bytes);
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
        let clock = StageProfiler::default();
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
        let clock = StageProfiler::showing(shown.clone());
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
