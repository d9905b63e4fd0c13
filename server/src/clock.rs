//! The clock that the science does not have: times and spans per stage.

use shatter_fracture::pipeline::{Stage, Watch};
use shatter_proto::answer::{STAGES, StageWire};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;
use tracing::span::EnteredSpan;

/// The stage that a strike is in, for those who ask: its number.
pub type Shown = Arc<AtomicU32>;

/// Watches one strike.
pub struct Clock {
    rows: [StageWire; STAGES.len()],
    shown: Shown,
    entered: Option<(Instant, EnteredSpan)>,
}

impl Default for Clock {
    fn default() -> Self {
        Self::showing(Shown::default())
    }
}

impl Clock {
    /// One that shows the stage that it is in.
    pub fn showing(shown: Shown) -> Self {
        let rows = std::array::from_fn(|stage| StageWire { stage: stage as u32, ran: 0, ns: 0, bytes: 0 });
        Self { rows, shown, entered: None }
    }

    /// One row per stage, also for those that did not run.
    pub fn rows(&self) -> [StageWire; STAGES.len()] {
        self.rows
    }
}

impl Watch for Clock {
    fn enter(&mut self, stage: Stage) {
        let span = tracing::debug_span!("stage", stage = stage.name()).entered();
        self.shown.store(stage as u32, Ordering::Relaxed);
        self.entered = Some((Instant::now(), span));
    }

    fn leave(&mut self, stage: Stage, bytes: u64) {
        if let Some((since, _span)) = self.entered.take() {
            let ns = u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX);
            let row = &mut self.rows[stage as usize];
            (row.ran, row.ns, row.bytes) = (1, row.ns.saturating_add(ns), row.bytes.saturating_add(bytes));
            tracing::debug!(ns, bytes, "{}", stage.name());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_have_the_same_numbers_and_names_on_the_wire() {
        for (stage, name) in Stage::ALL.into_iter().zip(STAGES) {
            assert_eq!((stage.name(), STAGES[stage as usize]), (name, name));
        }
    }

    #[test]
    fn a_stage_entered_twice_adds_up_and_others_did_not_run() {
        let shown = Shown::default();
        let mut clock = Clock::showing(shown.clone());
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
