//! Order of the search for missing constraints: short searches for all of them come before long ones.

use super::edge_removal::Recovery;
use super::error::ConformingError;
use super::segment_set::SegmentSet;
use super::tetrahedralization::Tetrahedralization;
use super::work_limit::WorkLimit;

/// Depths of removal tried in turn, and the removals tried per missing constraint in each.
const SEARCHES: [(u32, u32); 5] = [(0, 200), (1, 400), (2, 1000), (3, 3000), (5, 3000)];

/// Mesh in which constraints are recovered, and the limit of this.
pub(super) struct Search<'a, 'b> {
    /// The mesh.
    pub mesh: &'a mut Tetrahedralization,
    /// Edges of the surface.
    pub segments: &'a SegmentSet,
    /// Limit of all work.
    pub limit: &'a mut WorkLimit<'b>,
}

impl<'b> Search<'_, 'b> {
    /// Recovers missing constraints, each by `recover` with a depth of removal. Returns those that stay missing.
    ///
    /// # Errors
    /// Those of `recover` and of [`WorkLimit::check`].
    pub fn recover<T: Copy>(
        &mut self,
        mut missing: Vec<T>,
        recover: impl Fn(&mut Recovery<'_, 'b>, T, u32) -> Result<bool, ConformingError>,
    ) -> Result<Vec<T>, ConformingError> {
        for (depth, budget) in SEARCHES {
            loop {
                let before = missing.len();
                let mut left = Vec::new();
                for &constraint in &missing {
                    self.limit.check(self.mesh)?;
                    let Self { mesh, segments, limit } = self;
                    let mut recovery = Recovery { mesh, segments, limit, budget, removed: Vec::new() };
                    if !recover(&mut recovery, constraint, depth)? {
                        left.push(constraint);
                    }
                }
                missing = left;
                // Each recovery may have opened the way for another, unless the search is a long one.
                if missing.is_empty() || missing.len() == before || depth > 1 {
                    break;
                }
            }
        }
        self.limit.check(self.mesh)?;
        Ok(missing)
    }
}
