//! Why a strike took longer than its time budget.

use crate::result::SummaryWire;
use std::time::Duration;

/// Names of the reasons; the numbers of [`SummaryWire::overrun`].
pub const OVERRUNS: [&str; 7] =
    ["none", "queue", "no_reduced_basis", "reduced_error", "degree", "cells", "after_cells"];

/// Why a strike took longer than its time budget: what took most of it, where it could not be had for less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum OverrunCause {
    /// It waited in the queue.
    Queue = 1,
    /// The object has no reduced basis, or a solve was asked for: the strike was solved for.
    NoReducedBasis = 2,
    /// The estimated error of the reduced displacements was too large: the strike was solved for.
    ReducedError = 3,
    /// Energy and degree took longer than that.
    Degree = 4,
    /// The cells took longer than that without an iteration.
    Cells = 5,
    /// The stages after the cells took longer than predicted.
    AfterCells = 6,
}

/// A time budget that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissedTime {
    /// By how much.
    pub by: Duration,
    /// The name of the reason, one of [`OVERRUNS`].
    pub reason: &'static str,
}

impl MissedTime {
    /// The reason for people.
    pub fn explanation(&self) -> &'static str {
        match self.reason {
            "queue" => "waited in the queue",
            "no_reduced_basis" => "no reduced basis: the strike was solved for",
            "reduced_error" => {
                "the estimated error of the reduced displacements was too large: the strike was solved for"
            }
            "degree" => "energy and fracture degree took longer",
            "cells" => "the cells took longer, without any refinement",
            "after_cells" => "the stages after the cells took longer than predicted",
            _ => "of a reason that this client does not know",
        }
    }
}

impl SummaryWire {
    /// By how much and why the time that was asked for was exceeded; `None` if it was kept, or none was.
    pub fn missed_time(&self) -> Option<MissedTime> {
        let reason = OVERRUNS.get(self.overrun as usize).copied().unwrap_or("unknown");
        (self.overrun_ns > 0).then(|| MissedTime { by: Duration::from_nanos(self.overrun_ns), reason })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn every_reason_has_a_name_and_an_explanation() {
        let mut summary = SummaryWire::zeroed();
        assert_eq!(summary.missed_time(), None);
        summary.overrun_ns = 7;
        for overrun in 1..OVERRUNS.len() as u32 {
            summary.overrun = overrun;
            let missed = summary.missed_time().unwrap();
            assert!(missed.reason == OVERRUNS[overrun as usize] && !missed.explanation().contains("know"));
        }
        assert_eq!((OverrunCause::Queue as usize, OverrunCause::AfterCells as usize), (1, OVERRUNS.len() - 1));
        summary.overrun = 99;
        assert_eq!(summary.missed_time().unwrap().reason, "unknown");
    }
}
