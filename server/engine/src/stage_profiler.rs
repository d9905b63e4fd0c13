//! Profiler of a request: times and tracing spans per stage. The simulation itself reads no clock.

use shatter_fracture::pipeline::{Stage, StageObserver};
use shatter_fracture::scene::EffectKind;
use shatter_proto::effect::Effect;
use shatter_proto::layout::SectionsMut;
use shatter_proto::result::{EffectCost, EffectWire, StageCost, StageKind, StageWire};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use tracing::span::EnteredSpan;

/// Number of the current stage of a request, readable from other threads.
pub type CurrentStage = Arc<AtomicU32>;

/// Profiler of one request.
pub struct StageProfiler {
    shown: CurrentStage,
    times: RefCell<Times>,
}

/// Measurements of a request.
struct Times {
    stages: [StageCost; StageKind::ALL.len()],
    effects: [EffectCost; Effect::ALL.len()],
    entered: Option<(Instant, EnteredSpan)>,
    begun: Option<Instant>,
    /// Time of effects inside the current stage.
    others: Duration,
}

impl Default for StageProfiler {
    fn default() -> Self {
        Self::showing(CurrentStage::default())
    }
}

impl StageProfiler {
    /// Creates a profiler that publishes its current stage in `shown`.
    pub fn showing(shown: CurrentStage) -> Self {
        let stages = std::array::from_fn(|stage| StageCost::idle(StageKind::ALL[stage]));
        let effects = Effect::ALL.map(EffectCost::idle);
        let times = Times { stages, effects, entered: None, begun: None, others: Duration::ZERO };
        Self { shown, times: RefCell::new(times) }
    }

    /// Writes the rows of all stages and effects.
    pub fn write_costs(&self, sections: &mut SectionsMut<'_>) {
        sections.stages.copy_from_slice(&self.stages().each_ref().map(StageWire::from));
        sections.effects.copy_from_slice(&self.effects().each_ref().map(EffectWire::from));
    }

    /// Cost of each effect, including those that did not run.
    pub fn effects(&self) -> [EffectCost; Effect::ALL.len()] {
        self.times.borrow().effects
    }

    /// Cost of each stage, including those that did not run.
    pub fn stages(&self) -> [StageCost; StageKind::ALL.len()] {
        self.times.borrow().stages
    }
}

impl Times {
    fn count(&mut self, effect: EffectKind, time: Duration, bytes: u64) {
        self.effects[effect as usize].add(time, bytes);
        tracing::debug!(ns = nanoseconds(time), bytes, "{}", effect.name());
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl StageObserver for StageProfiler {
    fn enter(&self, stage: Stage) {
        let span = tracing::debug_span!("stage", stage = stage.name()).entered();
        self.shown.store(stage as u32, Ordering::Relaxed);
        let mut times = self.times.borrow_mut();
        (times.entered, times.others) = (Some((Instant::now(), span)), Duration::ZERO);
    }

    fn leave(&self, stage: Stage, bytes: u64) {
        let mut times = self.times.borrow_mut();
        if let Some((since, _span)) = times.entered.take() {
            let time = since.elapsed().saturating_sub(times.others);
            times.stages[stage as usize].add(time, bytes);
            tracing::debug!(ns = nanoseconds(time), bytes, "{}", stage.name());
        }
    }

    fn begin(&self, _: EffectKind) {
        self.times.borrow_mut().begun = Some(Instant::now());
    }

    fn end(&self, effect: EffectKind, bytes: u64) {
        let mut times = self.times.borrow_mut();
        if let Some(since) = times.begun.take() {
            let time = since.elapsed();
            times.others = times.others.saturating_add(time);
            times.count(effect, time, bytes);
        }
    }

    fn part(&self, effect: EffectKind, bytes: u64) {
        self.times.borrow_mut().count(effect, Duration::ZERO, bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::scene::EffectSet;

    #[test]
    fn stages_have_the_same_numbers_and_names_on_the_wire() {
        for (stage, wire) in Stage::ALL.into_iter().zip(StageKind::ALL) {
            assert_eq!((stage.name(), stage as u32), (wire.name(), wire.code()));
        }
        assert_eq!(Stage::ALL.len(), StageKind::ALL.len());
    }

    #[test]
    fn effects_have_the_same_numbers_and_names_on_the_wire() {
        for (effect, wire) in EffectKind::ALL.into_iter().zip(Effect::ALL) {
            assert_eq!((effect.name(), effect as u32), (wire.name(), wire as u32));
            assert_eq!(EffectSet::default().has(effect), wire.default_on());
        }
        assert_eq!(EffectKind::ALL.len(), Effect::ALL.len());
    }

    #[test]
    fn the_time_of_an_effect_is_not_counted_in_its_stage() {
        let clock = StageProfiler::default();
        clock.enter(Stage::Fragments);
        clock.begin(EffectKind::Bonds);
        std::thread::sleep(std::time::Duration::from_millis(20));
        clock.end(EffectKind::Bonds, 64);
        clock.leave(Stage::Fragments, 7);
        clock.part(EffectKind::Interior, 9);
        let [bonds, interior] =
            [EffectKind::Bonds, EffectKind::Interior].map(|effect| clock.effects()[effect as usize]);
        assert_eq!((bonds.has_run, bonds.bytes, bonds.effect), (true, 64, Effect::Bonds));
        assert_eq!((interior.has_run, interior.time, interior.bytes), (true, Duration::ZERO, 9));
        assert!(clock.stages()[7].time < bonds.time, "{:?} {bonds:?}", clock.stages()[7]);
        let idle = clock.effects().iter().filter(|cost| **cost == EffectCost::idle(cost.effect)).count();
        assert_eq!(idle, Effect::ALL.len() - 2);
    }

    #[test]
    fn a_stage_entered_twice_adds_up_and_others_did_not_run() {
        let shown = CurrentStage::default();
        let clock = StageProfiler::showing(shown.clone());
        for bytes in [3, 4] {
            clock.enter(Stage::Labels);
            clock.leave(Stage::Labels, bytes);
        }
        let stages = clock.stages();
        assert_eq!(shown.load(Ordering::Relaxed), 5);
        assert_eq!((stages[5].has_run, stages[5].bytes, stages[5].stage), (true, 7, StageKind::Labels));
        let mut others = stages.iter().filter(|cost| cost.stage != StageKind::Labels);
        assert!(others.all(|cost| *cost == StageCost::idle(cost.stage)));
    }
}
