//! Limits of time and memory, in units that are equal on every machine.

use super::error::ConformingError;
use super::tetrahedralization::Tetrahedralization;
use crate::cancel_token::CancelToken;

/// Largest number of tetrahedra per point allowed. Surfaces and lattices have about 7; the worst sets of points have
/// half as many as there are points.
const TETS_PER_POINT_MAX: usize = 16;
/// Largest number of tetrahedra, because a packed face has 32 bits.
const TETS_MAX: usize = 1 << 29;
/// Removals of edges tried in all rounds before the search narrows.
const REMOVALS_MAX: u64 = 1_000_000;
/// Part of the removals left that one round may use: 1 / 4, so that later rounds keep some.
const REMOVALS_DIVISOR: u64 = 4;

/// Work that the mesher may still do. Its unit is a step: a sign computed or a tetrahedron visited.
#[derive(Debug)]
pub(super) struct WorkLimit<'a> {
    /// Cancellation.
    pub token: &'a CancelToken,
    steps: u64,
    steps_max: u64,
    tets_max: usize,
    removals_after: u64,
    removals: u64,
}

impl<'a> WorkLimit<'a> {
    /// Limits for a mesh of at most `points_max` points and `steps_max` steps.
    pub fn new(points_max: usize, steps_max: u64, token: &'a CancelToken) -> Self {
        let tets_max = points_max.saturating_mul(TETS_PER_POINT_MAX).min(TETS_MAX);
        Self { token, steps: 0, steps_max, tets_max, removals_after: REMOVALS_MAX, removals: 0 }
    }

    /// Gives the next repair round its part of the removals.
    pub fn begin_round(&mut self) {
        let left = self.removals_after + self.removals;
        self.removals = left / REMOVALS_DIVISOR;
        self.removals_after = left - self.removals;
    }

    /// Counts the removal of an edge.
    pub fn count_removal(&mut self) {
        self.removals = self.removals.saturating_sub(1);
    }

    /// Returns true if edges in the way of an edge may be removed, too.
    pub fn allows_depth(&self) -> bool {
        self.removals > 0
    }

    /// Returns true if [`Self::check`] would fail.
    pub fn is_exceeded(&self, mesh: &Tetrahedralization) -> bool {
        self.steps + mesh.steps() > self.steps_max || mesh.tets.len() > self.tets_max || self.token.is_canceled()
    }

    /// Takes over the steps of the mesh.
    ///
    /// # Errors
    /// [`ConformingError::Canceled`], [`ConformingError::TooManyTets`], [`ConformingError::TooManySteps`].
    pub fn check(&mut self, mesh: &Tetrahedralization) -> Result<(), ConformingError> {
        self.steps += mesh.take_steps();
        self.token.check()?;
        if mesh.tets.len() > self.tets_max {
            return Err(ConformingError::TooManyTets { tets_max: self.tets_max });
        }
        if self.steps > self.steps_max {
            return Err(ConformingError::TooManySteps { steps_max: self.steps_max });
        }
        Ok(())
    }

    /// Steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_round_has_a_quarter_of_the_removals_left() {
        let token = CancelToken::default();
        let mut limit = WorkLimit::new(1, 1, &token);
        assert!(!limit.allows_depth());
        limit.begin_round();
        for _ in 0..REMOVALS_MAX / 4 {
            assert!(limit.allows_depth());
            limit.count_removal();
        }
        assert!(!limit.allows_depth());
        limit.begin_round();
        assert_eq!(limit.removals, REMOVALS_MAX * 3 / 16);
    }
}
