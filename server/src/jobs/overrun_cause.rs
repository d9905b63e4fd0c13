//! Cause of an exceeded time budget.

use shatter_proto::result::{OverrunCause, StageCost, StageKind};
use std::time::Duration;

/// Cause of exceeding a time budget by `over`: the queue if the request would have kept its budget without waiting (`waited`), else
/// what took most of the time. `ran`: time since then, all of which follows the cells but for the stages up to them, whose times `stages` holds.
/// `solved` holds the reason if displacements were solved for.
pub(super) fn reason(
    over: Duration,
    waited: Duration,
    ran: Duration,
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
    // Effects have times of their own, so the stages after the cells are not all.
    let after = ran.saturating_sub(front + cells);
    if waited > front.max(cells).max(after) {
        OverrunCause::Queue
    } else if front >= cells.max(after) {
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
        let stages = |front: u64, cells: u64| {
            [(StageKind::Elasticity, front), (StageKind::Centroidal, cells)].map(|(stage, ns)| {
                let mut cost = StageCost::idle(stage);
                cost.add(Duration::from_nanos(ns), 0);
                cost
            })
        };
        let of = |waited, solved, stages: [StageCost; 2], ran_ns| {
            reason(ms(10), ms(waited), Duration::from_nanos(ran_ns), solved, &stages)
        };
        assert_eq!(of(10, None, stages(9, 1), 11), OverrunCause::Queue);
        assert_eq!(
            of(9, Some(OverrunCause::NoReducedBasis), stages(9, 1), 19),
            OverrunCause::Queue,
            "the longest wait"
        );
        assert_eq!(of(0, Some(OverrunCause::NoReducedBasis), stages(9, 1), 19), OverrunCause::NoReducedBasis);
        assert_eq!(of(0, Some(OverrunCause::NoReducedBasis), stages(9, 1), 20), OverrunCause::AfterCells, "hulls");
        assert_eq!(of(0, Some(OverrunCause::ReducedError), stages(9, 10), 20), OverrunCause::Cells);
        assert_eq!(of(0, None, stages(9, 1), 11), OverrunCause::Degree);
        assert_eq!(of(0, None, stages(9, 10), 30), OverrunCause::AfterCells);
    }
}
