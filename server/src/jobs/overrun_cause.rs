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
    let solve = sum(StageKind::Load..StageKind::Degree);
    let degree = sum(StageKind::Degree..StageKind::Centroidal);
    let cells = sum(StageKind::Centroidal..StageKind::Tessellation);
    // Effects have times of their own, so the stages after the cells are not all.
    let after = ran.saturating_sub(solve + degree + cells);
    let parts = [
        (solve, solved.unwrap_or(OverrunCause::Degree)),
        (degree, OverrunCause::Degree),
        (cells, OverrunCause::Cells),
        (after, OverrunCause::AfterCells),
    ];
    let longest = parts.into_iter().reduce(|longest, part| if part.0 > longest.0 { part } else { longest });
    longest.filter(|(time, _)| *time >= waited).map_or(OverrunCause::Queue, |(_, cause)| cause)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_is_the_queue_or_what_took_longest() {
        let ms = Duration::from_millis;
        let parts = |solve: u64, degree: u64, cells: u64| {
            let times = [(StageKind::Elasticity, solve), (StageKind::Degree, degree), (StageKind::Centroidal, cells)];
            times.map(|(stage, ns)| {
                let mut cost = StageCost::idle(stage);
                cost.add(Duration::from_nanos(ns), 0);
                cost
            })
        };
        let of = |waited, solved, stages: [StageCost; 3], ran_ns| {
            reason(ms(10), ms(waited), Duration::from_nanos(ran_ns), solved, &stages)
        };
        assert_eq!(of(10, None, parts(9, 0, 1), 11), OverrunCause::Queue);
        assert_eq!(
            of(9, Some(OverrunCause::NoReducedBasis), parts(9, 0, 1), 19),
            OverrunCause::Queue,
            "the longest wait"
        );
        assert_eq!(of(0, Some(OverrunCause::NoReducedBasis), parts(9, 0, 1), 19), OverrunCause::NoReducedBasis);
        assert_eq!(of(0, Some(OverrunCause::NoReducedBasis), parts(9, 0, 1), 20), OverrunCause::AfterCells, "hulls");
        assert_eq!(of(0, Some(OverrunCause::ReducedError), parts(9, 0, 10), 20), OverrunCause::Cells);
        assert_eq!(of(0, None, parts(9, 0, 1), 11), OverrunCause::Degree);
        assert_eq!(of(0, None, parts(9, 0, 10), 30), OverrunCause::AfterCells);
        assert_eq!(
            of(0, Some(OverrunCause::NoReducedBasis), parts(7, 9, 1), 17),
            OverrunCause::Degree,
            "many diagrams"
        );
    }
}
