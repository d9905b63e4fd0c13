//! Mutants that failed once.

/// Mutants that failed before a fix, each with a comment on the fault; the tests judge all of them.
pub const REGRESSIONS: [&str; 0] = [];
