//! What ends a descent, and a strike.

/// What ended the descent of a diagram, in the order in which it counts where a strike has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Termination {
    /// Its tolerance.
    Converged,
    /// Its estimated gap is no more than the strike's error.
    ErrorMet,
    /// As many iterations as were allowed.
    Iterations,
    /// The strike's time.
    Time,
}

/// What stopped a strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Nothing: no diagram was made.
    Complete,
    /// The degree reached its cap.
    Capped,
    /// The diagrams' tolerance was met.
    Converged,
    /// The error that was asked for was met.
    ErrorMet,
    /// No time was left.
    Time,
    /// No more iterations were allowed.
    Iterations,
}

impl StopReason {
    /// The name used in JSON.
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
