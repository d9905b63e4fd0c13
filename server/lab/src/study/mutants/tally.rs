//! Counting verdicts.

use super::{Defect, Mutant, Verdict};
use serde::Serialize;

/// How often what happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
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

impl Counts {
    /// Share of those tried that were answered; 1 of none.
    pub fn accept_rate(&self) -> f64 {
        if self.tried == 0 { 1.0 } else { self.checked as f64 / self.tried as f64 }
    }

    fn add(&mut self, verdict: &Verdict) {
        self.tried += 1;
        match verdict {
            Verdict::Checked { .. } => self.checked += 1,
            Verdict::Refused { justified, .. } => {
                self.refused += 1;
                self.unjustified += u64::from(!justified);
            }
            Verdict::Failed(_) => self.failed += 1,
        }
    }
}

/// The counts of one mesh or one defect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Named {
    /// The mesh or the defect.
    pub name: String,
    /// All its mutants.
    pub all: Counts,
    /// Those that must be accepted.
    pub must_accept: Counts,
}

/// A mutant and what is to be said of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Told {
    /// Which one.
    pub mutant: Mutant,
    /// What happened.
    pub message: String,
}

/// What became of many mutants. Follows from the plan alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tally {
    /// All mutants.
    pub all: Counts,
    /// Those that must be accepted.
    pub must_accept: Counts,
    /// Share of those that must be accepted that were.
    pub must_accept_rate: f64,
    /// By base mesh, in the plan's order.
    pub per_mesh: Vec<Named>,
    /// By defect, in the order of [`Defect::ALL`].
    pub per_defect: Vec<Named>,
    /// Every failure.
    pub failures: Vec<Told>,
    /// Every refusal that should have been an answer.
    pub unjustified: Vec<Told>,
}

impl Tally {
    pub(super) fn new<'a>(meshes: impl Iterator<Item = &'a str>) -> Self {
        let named = |name: String| Named { name, all: Counts::default(), must_accept: Counts::default() };
        Self {
            all: Counts::default(),
            must_accept: Counts::default(),
            must_accept_rate: 1.0,
            per_mesh: meshes.map(|name| named(name.to_owned())).collect(),
            per_defect: Defect::ALL.iter().map(|defect| named(defect.to_string())).collect(),
            failures: Vec::new(),
            unjustified: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, mutant: Mutant, verdict: &Verdict) {
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
            Verdict::Failed(fault) => self.failures.push(Told { mutant, message: fault.to_string() }),
            Verdict::Refused { message, justified: false, .. } => {
                self.unjustified.push(Told { mutant, message: message.clone() });
            }
            Verdict::Checked { .. } | Verdict::Refused { .. } => {}
        }
    }
}
