//! Reasons why a descent or a request ends.

/// Reason why the descent of a diagram ended, in ascending precedence for requests with several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Termination {
    /// The tolerance was met.
    Converged,
    /// The estimated gap is at most the error allowed by the request.
    ErrorMet,
    /// The largest number of iterations was reached.
    Iterations,
    /// The time of the request ended.
    Time,
}

/// Reason why a request ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Complete, without any diagram.
    Complete,
    /// The degree was limited by its maximum.
    Capped,
    /// The diagrams met their tolerance.
    Converged,
    /// The diagrams met the error allowed by the request.
    ErrorMet,
    /// Time ended.
    Time,
    /// The largest number of iterations was reached.
    Iterations,
}

impl StopReason {
    /// Name used in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Capped => "capped",
            Self::Converged => "converged",
            Self::ErrorMet => "error_met",
            Self::Time => "time",
            Self::Iterations => "iterations",
        }
    }
}
