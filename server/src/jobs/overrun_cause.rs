//! Cause of an exceeded time budget.

use shatter_proto::result::{OverrunCause, StageCost, StageKind};
use std::time::Duration;

/// Cause of exceeding a time budget by `over`: the queue if the request would have kept its budget without waiting (`waited`), else
/// the slowest part. `solved` holds the reason if displacements were solved for; `stages` holds the time of each stage.
pub(super) fn reason(
    over: Duration,
    waited: Duration,
    solved: Option<OverrunCause>,
    stages: &[StageCost],
) -> OverrunCause {
    if waited >= over {
        return OverrunCause::Queue;
    }
    let sum = |part: std::ops::Range<StageKind>| -> Duration {
        let part = part.start.code()..part.end.code();
        let times = stages.iter().filter(|cost| part.contains(&cost.stage.code())).map(|cost| cost.time);
        times.fold(Duration::ZERO, Duration::saturating_add)
    };
    let front = sum(StageKind::Load..StageKind::Centroidal);
    let cells = sum(StageKind::Centroidal..StageKind::Tessellation);
    let after = sum(StageKind::Tessellation..StageKind::Unknown);
    if front >= cells.max(after) {
        solved.unwrap_or(OverrunCause::Degree)
    } else if cells >= after {
        OverrunCause::Cells
    } else {
        OverrunCause::AfterCells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_is_the_queue_or_what_took_longest() {
        let ms = Duration::from_millis;
        let stages = |front: u64, cells: u64, after: u64| {
            let times =
                [(StageKind::Elasticity, front), (StageKind::Centroidal, cells), (StageKind::Tessellation, after)];
            times.map(|(stage, ns)| {
                let mut cost = StageCost::idle(stage);
                cost.add(Duration::from_nanos(ns), 0);
                cost
            })
        };
        let of = |waited, solved, stages: [StageCost; 3]| reason(ms(10), ms(waited), solved, &stages);
        assert_eq!(of(10, None, stages(9, 1, 1)), OverrunCause::Queue);
        assert_eq!(of(9, Some(OverrunCause::NoReducedBasis), stages(9, 1, 1)), OverrunCause::NoReducedBasis);
        assert_eq!(of(9, Some(OverrunCause::ReducedError), stages(9, 10, 1)), OverrunCause::Cells);
        assert_eq!(of(0, None, stages(9, 1, 1)), OverrunCause::Degree);
        assert_eq!(of(0, None, stages(9, 10, 11)), OverrunCause::AfterCells);
    }
}
