//! Mutants that failed once.

/// Each failed before it was mended, and is judged by the tests ever after; beside it what was wrong.
pub const REGRESSIONS: [&str; 0] = [];
