//! Counting verdicts.

use super::{FuzzDefect, FuzzVerdict, Mutant};
use serde::Serialize;

/// How often what happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FuzzCounts {
    /// Mutants judged.
    pub tried: u64,
    /// Answered, and everything held.
    pub checked: u64,
    /// Refused with a reason.
    pub refused: u64,
    /// Those of the refused that should have been accepted.
    pub unjustified: u64,
    /// Neither answered nor refused.
    pub failed: u64,
}

impl FuzzCounts {
    /// Share of those tried that were answered; 1 of none.
    pub fn accept_rate(&self) -> f64 {
        if self.tried == 0 { 1.0 } else { self.checked as f64 / self.tried as f64 }
    }

    fn add(&mut self, verdict: &FuzzVerdict) {
        self.tried += 1;
        match verdict {
            FuzzVerdict::Checked { .. } => self.checked += 1,
            FuzzVerdict::Refused { justified, .. } => {
                self.refused += 1;
                self.unjustified += u64::from(!justified);
            }
            FuzzVerdict::Failed(_) => self.failed += 1,
        }
    }
}

/// The counts of one mesh or one defect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedCounts {
    /// The mesh or the defect.
    pub name: String,
    /// All its mutants.
    pub all: FuzzCounts,
    /// Those that must be accepted.
    pub must_accept: FuzzCounts,
}

/// A mutant and what is to be said of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FuzzReport {
    /// Which one.
    pub mutant: Mutant,
    /// What happened.
    pub message: String,
}

/// What became of many mutants. Follows from the plan alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FuzzTally {
    /// All mutants.
    pub all: FuzzCounts,
    /// Those that must be accepted.
    pub must_accept: FuzzCounts,
    /// Share of those that must be accepted that were.
    pub must_accept_rate: f64,
    /// By base mesh, in the plan's order.
    pub per_mesh: Vec<NamedCounts>,
    /// By defect, in the order of [`FuzzDefect::ALL`].
    pub per_defect: Vec<NamedCounts>,
    /// Every failure.
    pub failures: Vec<FuzzReport>,
    /// Every refusal that should have been an answer.
    pub unjustified: Vec<FuzzReport>,
}

impl FuzzTally {
    pub(super) fn new<'a>(meshes: impl Iterator<Item = &'a str>) -> Self {
        let named = |name: String| NamedCounts { name, all: FuzzCounts::default(), must_accept: FuzzCounts::default() };
        Self {
            all: FuzzCounts::default(),
            must_accept: FuzzCounts::default(),
            must_accept_rate: 1.0,
            per_mesh: meshes.map(|name| named(name.to_owned())).collect(),
            per_defect: FuzzDefect::ALL.iter().map(|defect| named(defect.to_string())).collect(),
            failures: Vec::new(),
            unjustified: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, mutant: Mutant, verdict: &FuzzVerdict) {
        let defect = mutant.defect.to_string();
        let rows = self.per_mesh.iter_mut().filter(|row| row.name == mutant.mesh);
        let rows = rows.chain(self.per_defect.iter_mut().filter(|row| row.name == defect));
        for (all, must_accept) in rows
            .map(|row| (&mut row.all, &mut row.must_accept))
            .chain(std::iter::once((&mut self.all, &mut self.must_accept)))
        {
            all.add(verdict);
            if mutant.defect.must_accept() {
                must_accept.add(verdict);
            }
        }
        self.must_accept_rate = self.must_accept.accept_rate();
        match verdict {
            FuzzVerdict::Failed(fault) => self.failures.push(FuzzReport { mutant, message: fault.to_string() }),
            FuzzVerdict::Refused { message, justified: false, .. } => {
                self.unjustified.push(FuzzReport { mutant, message: message.clone() });
            }
            FuzzVerdict::Checked { .. } | FuzzVerdict::Refused { .. } => {}
        }
    }
}
