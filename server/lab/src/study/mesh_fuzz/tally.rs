//! Counts of outcomes.

use super::{FuzzDefect, FuzzVerdict, Mutant};
use serde::Serialize;
use std::collections::BTreeMap;

/// Counts by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FuzzCounts {
    /// Number of mutants judged.
    pub tried: u64,
    /// Number with a result that passed all checks.
    pub checked: u64,
    /// Number of these whose fragments end on the input surface.
    pub exact: u64,
    /// Number refused with an error.
    pub refused: u64,
    /// Number refused that should have been accepted.
    pub unjustified: u64,
    /// Number that failed.
    pub failed: u64,
}

impl FuzzCounts {
    /// Share of the judged mutants with a result; 1 without mutants.
    pub fn accept_rate(&self) -> f64 {
        if self.tried == 0 { 1.0 } else { self.checked as f64 / self.tried as f64 }
    }

    fn add(&mut self, verdict: &FuzzVerdict) {
        self.tried += 1;
        match verdict {
            FuzzVerdict::Checked { reason, .. } => {
                self.checked += 1;
                self.exact += u64::from(reason.is_none());
            }
            FuzzVerdict::Refused { justified, .. } => {
                self.refused += 1;
                self.unjustified += u64::from(!justified);
            }
            FuzzVerdict::Failed(_) => self.failed += 1,
        }
    }
}

/// Counts of one mesh or one defect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedCounts {
    /// Name of the mesh or the defect.
    pub name: String,
    /// Counts of all mutants.
    pub all: FuzzCounts,
    /// Counts of those that must be accepted.
    pub must_accept: FuzzCounts,
}

/// Mutant with a message.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FuzzReport {
    /// The mutant.
    pub mutant: Mutant,
    /// The message.
    pub message: String,
}

/// Tally of a run; depends on the plan only.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FuzzTally {
    /// Counts of all mutants.
    pub all: FuzzCounts,
    /// Counts of those that must be accepted.
    pub must_accept: FuzzCounts,
    /// Accepted share of those that must be accepted.
    pub must_accept_rate: f64,
    /// Counts by base mesh, in the plan's order.
    pub per_mesh: Vec<NamedCounts>,
    /// Counts by defect, in the order of [`FuzzDefect::ALL`].
    pub per_defect: Vec<NamedCounts>,
    /// Number of mutants with the lattice's surface, by the beginning of the reason.
    pub lattice_reasons: BTreeMap<String, u64>,
    /// All failures.
    pub failures: Vec<FuzzReport>,
    /// All unjustified errors.
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
            lattice_reasons: BTreeMap::new(),
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
            FuzzVerdict::Checked { reason: Some(reason), .. } => {
                let kind = reason.split([';', ',', ':', '(']).next().unwrap_or(reason);
                let kind = kind.split(" near").next().and_then(|kind| kind.split(" at ").next()).unwrap_or(kind);
                let kind = kind.trim_end_matches(|c: char| c.is_ascii_digit());
                *self.lattice_reasons.entry(kind.trim().to_owned()).or_default() += 1;
            }
            FuzzVerdict::Checked { reason: None, .. } | FuzzVerdict::Refused { .. } => {}
        }
    }
}
