//! Case of the stability study and its outcome.

use super::TrialFault;
use crate::report::significant;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Expected result of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expect {
    /// Figure of at most this value.
    AtMost(f64),
    /// Figure of at least this value.
    AtLeast(f64),
    /// Figure between these two values.
    Between(f64, f64),
    /// Error of this kind.
    Refused(&'static str),
}

/// Hard case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Unique name.
    pub name: &'static str,
    /// Item of [`super::LIST`] to which it belongs.
    pub item: &'static str,
    /// Expected result.
    pub expect: Expect,
    /// Meaning of the figure, and reason for the bound.
    pub why: &'static str,
    /// Function that computes the figure.
    pub run: fn() -> Result<f64, TrialFault>,
}

/// Outcome of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CaseOutcome {
    /// The figure is within its bound.
    Passed,
    /// Refused, as expected.
    Refused,
    /// Failed.
    Failed,
}

/// Row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseRow {
    /// Name of the case.
    pub name: String,
    /// Item of the list.
    pub item: String,
    /// Outcome.
    pub outcome: CaseOutcome,
    /// Figure, if there is one.
    pub figure: Option<f64>,
    /// Bound as a number: the upper one of two; `None` for an expected error.
    pub bound: Option<f64>,
    /// Bound as text.
    pub expected: String,
    /// Meaning of the figure, and reason for the bound.
    pub why: String,
    /// Message of the error.
    pub message: Option<String>,
}

impl CaseRow {
    /// Row for a failed part of the study that is not a case.
    pub fn failed(name: &str, fault: &TrialFault) -> Self {
        let why = "must not fail";
        compare(name, "the study itself", Expect::AtMost(0.0), why, || Err(fault.clone()))
    }
}

/// Runs a case and compares its figure with the bound; a panic fails it.
pub fn judge(case: &Case) -> CaseRow {
    compare(case.name, case.item, case.expect, case.why, case.run)
}

/// Same as [`judge`], for a case outside the table.
pub(super) fn compare(
    name: &str,
    item: &str,
    expect: Expect,
    why: &str,
    run: impl FnOnce() -> Result<f64, TrialFault>,
) -> CaseRow {
    let found =
        catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| Err(TrialFault::ours("panic", "the case panicked")));
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
