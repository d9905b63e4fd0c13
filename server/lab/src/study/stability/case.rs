//! One case and its verdict.

use super::TrialFault;
use crate::report::significant;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What must come of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expect {
    /// A figure of at most this.
    AtMost(f64),
    /// A figure of at least this.
    AtLeast(f64),
    /// A figure between these two.
    Between(f64, f64),
    /// A refusal of this kind.
    Refused(&'static str),
}

/// A hard case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name, unique.
    pub name: &'static str,
    /// The item of [`super::LIST`] that it stands for.
    pub item: &'static str,
    /// What must come of it.
    pub expect: Expect,
    /// What the figure is, and why the bound is what it is.
    pub why: &'static str,
    /// Does it.
    pub run: fn() -> Result<f64, TrialFault>,
}

/// What came of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CaseOutcome {
    /// The figure is within its bound.
    Passed,
    /// Refused, as it must be.
    Refused,
    /// Anything else.
    Failed,
}

/// A line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseRow {
    /// Name of the case.
    pub name: String,
    /// Item of the list.
    pub item: String,
    /// What came of it.
    pub outcome: CaseOutcome,
    /// The figure, if there is one.
    pub figure: Option<f64>,
    /// The bound as a number: the upper one where there are two; none for a refusal.
    pub bound: Option<f64>,
    /// The bound in words.
    pub expected: String,
    /// What the figure is and why the bound is what it is.
    pub why: String,
    /// The refusal, or what went wrong.
    pub message: Option<String>,
}

impl CaseRow {
    /// What a part of the study that is no case leaves when it fails.
    pub fn failed(name: &str, fault: &TrialFault) -> Self {
        let why = "must not fail";
        compare(name, "the study itself", Expect::AtMost(0.0), why, || Err(fault.clone()))
    }
}

/// Runs a case and compares; a panic fails it.
pub fn judge(case: &Case) -> CaseRow {
    compare(case.name, case.item, case.expect, case.why, case.run)
}

/// As [`judge`], for a case that is not in the table.
pub(super) fn compare(
    name: &str,
    item: &str,
    expect: Expect,
    why: &str,
    run: impl FnOnce() -> Result<f64, TrialFault>,
) -> CaseRow {
    let found = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| Err(TrialFault::ours("panic", "it panicked")));
    let outcome = match (&found, expect) {
        (Ok(figure), Expect::AtMost(bound)) if *figure <= bound => CaseOutcome::Passed,
        (Ok(figure), Expect::AtLeast(bound)) if *figure >= bound => CaseOutcome::Passed,
        (Ok(figure), Expect::Between(low, high)) if (low..=high).contains(figure) => CaseOutcome::Passed,
        (Err(fault), Expect::Refused(kind)) if fault.kind == kind => CaseOutcome::Refused,
        _ => CaseOutcome::Failed,
    };
    CaseRow {
        name: name.to_owned(),
        item: item.to_owned(),
        outcome,
        figure: found.as_ref().ok().copied(),
        bound: match expect {
            Expect::AtMost(bound) | Expect::AtLeast(bound) | Expect::Between(_, bound) => Some(bound),
            Expect::Refused(_) => None,
        },
        expected: match expect {
            Expect::AtMost(bound) => format!("≤ {}", significant(bound, 2)),
            Expect::AtLeast(bound) => format!("≥ {}", significant(bound, 3)),
            Expect::Between(low, high) => format!("{} … {}", significant(low, 3), significant(high, 3)),
            Expect::Refused(kind) => format!("refused: {kind}"),
        },
        why: why.to_owned(),
        message: found.err().map(|fault| format!("{}: {}", fault.kind, fault.message)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(expect: Expect, run: fn() -> Result<f64, TrialFault>) -> CaseOutcome {
        judge(&Case { name: "it", item: "it", expect, why: "", run }).outcome
    }

    #[test]
    fn cases_pass_and_fail_as_they_should() {
        assert_eq!(outcome(Expect::AtMost(1.0), || Ok(1.0)), CaseOutcome::Passed);
        assert_eq!(outcome(Expect::AtMost(1.0), || Ok(1.5)), CaseOutcome::Failed);
        assert_eq!(outcome(Expect::AtMost(1.0), || Ok(f64::NAN)), CaseOutcome::Failed);
        assert_eq!(outcome(Expect::AtLeast(3.0), || Ok(2.0)), CaseOutcome::Failed);
        assert_eq!(outcome(Expect::Between(1.0, 2.0), || Ok(1.5)), CaseOutcome::Passed);
        assert_eq!(outcome(Expect::Refused("why"), || Err(TrialFault::ours("why", ""))), CaseOutcome::Refused);
        assert_eq!(outcome(Expect::Refused("why"), || Err(TrialFault::ours("other", ""))), CaseOutcome::Failed);
        assert_eq!(outcome(Expect::Refused("why"), || Ok(0.0)), CaseOutcome::Failed);
        assert_eq!(outcome(Expect::AtMost(1.0), || panic!("on purpose")), CaseOutcome::Failed);
    }
}
