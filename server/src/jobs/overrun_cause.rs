//! Cause of an exceeded time budget.

use shatter_proto::result::{OverrunCause, StageWire};
use std::time::Duration;

/// Stage numbers of the first stage of the cells and of the first stage after them; the stages before `CELLS` determine the degree.
const CELLS: u32 = 4;
const AFTER_CELLS: u32 = 6;

/// Cause of exceeding a time budget by `over`: the queue if the request would have kept its budget without waiting (`waited`), else
/// the slowest part. `solved` holds the reason if displacements were solved for; `stages` holds the time of each stage.
pub(super) fn reason(
    over: Duration,
    waited: Duration,
    solved: Option<OverrunCause>,
    stages: &[StageWire],
) -> OverrunCause {
    if waited >= over {
        return OverrunCause::Queue;
    }
    let sum = |part: std::ops::Range<u32>| -> u64 {
        stages.iter().filter(|row| part.contains(&row.stage)).map(|row| row.ns).fold(0, u64::saturating_add)
    };
    let [front, cells, after] = [sum(0..CELLS), sum(CELLS..AFTER_CELLS), sum(AFTER_CELLS..u32::MAX)];
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
            [(1, front), (4, cells), (6, after)].map(|(stage, ns)| StageWire { stage, ran: 1, ns, bytes: 0 })
        };
        let of = |waited, solved, stages: [StageWire; 3]| reason(ms(10), ms(waited), solved, &stages);
        assert_eq!(of(10, None, stages(9, 1, 1)), OverrunCause::Queue);
        assert_eq!(of(9, Some(OverrunCause::NoReducedBasis), stages(9, 1, 1)), OverrunCause::NoReducedBasis);
        assert_eq!(of(9, Some(OverrunCause::ReducedError), stages(9, 10, 1)), OverrunCause::Cells);
        assert_eq!(of(0, None, stages(9, 1, 1)), OverrunCause::Degree);
        assert_eq!(of(0, None, stages(9, 10, 11)), OverrunCause::AfterCells);
    }
}
