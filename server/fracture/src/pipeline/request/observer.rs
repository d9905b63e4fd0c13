//! Observation of a request: its stages and effects, as spans.

use super::stage::Stage;
use crate::scene::EffectKind;

/// Observer of the beginnings and ends of stages and effects.
///
/// This crate has no clock; the caller may bring one. Stages and effects are spans: [`stage`](StageSpan) and
/// [`effect`](EffectSpan) of `dyn StageObserver` begin one, which ends when it is dropped.
pub trait StageObserver {
    /// Stage `stage` begins; it may begin once per body.
    fn enter(&self, stage: Stage);
    /// Stage `stage` ends and has produced `bytes` bytes of results.
    fn leave(&self, stage: Stage, bytes: u64);
    /// Effect `effect` begins, inside or outside a stage, whose time excludes that of the effect.
    fn begin(&self, effect: EffectKind);
    /// Effect `effect` ends and has produced `bytes` bytes of results, or used tables of that size.
    fn end(&self, effect: EffectKind, bytes: u64);
    /// Effect `effect` is part of a stage, which uses `bytes` bytes of tables for it.
    fn part(&self, effect: EffectKind, bytes: u64);
}

/// The observer that ignores all events.
impl StageObserver for () {
    fn enter(&self, _: Stage) {}
    fn leave(&self, _: Stage, _: u64) {}
    fn begin(&self, _: EffectKind) {}
    fn end(&self, _: EffectKind, _: u64) {}
    fn part(&self, _: EffectKind, _: u64) {}
}

impl<'a> dyn StageObserver + 'a {
    /// Begins `stage`, which ends when the span is dropped.
    pub fn stage(&self, stage: Stage) -> StageSpan<'_> {
        self.enter(stage);
        StageSpan { observer: self, stage, bytes: 0 }
    }

    /// Begins `effect`, which ends when the span is dropped.
    pub fn effect(&self, effect: EffectKind) -> EffectSpan<'_> {
        self.begin(effect);
        EffectSpan { observer: self, effect, bytes: 0 }
    }
}

/// A running stage, which ends when this is dropped.
#[must_use]
pub struct StageSpan<'a> {
    observer: &'a (dyn StageObserver + 'a),
    stage: Stage,
    bytes: u64,
}

impl StageSpan<'_> {
    /// Ends the stage, which has produced all of `results`.
    pub fn produced<T>(self, results: &[T]) {
        self.produced_bytes(size_of_val(results) as u64);
    }

    /// Ends the stage, which has produced `bytes` bytes of results.
    pub fn produced_bytes(mut self, bytes: u64) {
        self.bytes = bytes;
    }
}

impl Drop for StageSpan<'_> {
    fn drop(&mut self) {
        self.observer.leave(self.stage, self.bytes);
    }
}

/// A running effect, which ends when this is dropped.
#[must_use]
pub struct EffectSpan<'a> {
    observer: &'a (dyn StageObserver + 'a),
    effect: EffectKind,
    bytes: u64,
}

impl EffectSpan<'_> {
    /// Ends the effect, which has produced all of `results` or used them as a table.
    pub fn produced<T>(self, results: &[T]) {
        self.produced_bytes(size_of_val(results) as u64);
    }

    /// Ends the effect, which has produced `bytes` bytes of results, or used tables of that size.
    pub fn produced_bytes(mut self, bytes: u64) {
        self.bytes = bytes;
    }
}

impl Drop for EffectSpan<'_> {
    fn drop(&mut self) {
        self.observer.end(self.effect, self.bytes);
    }
}
