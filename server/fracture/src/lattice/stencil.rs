//! Part of a grid tetrahedron inside the surface: up to three tetrahedra.
//!
//! Based on: Labelle & Shewchuk (2007), section 3.3 and figure 3, with the parity rule for quadrilaterals between two
//! short edges. The rule depends only on the face, so both tetrahedra at a face split its quadrilateral alike.

/// Side of the level set on which a node lies. A warped node lies on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum LevelSetSide {
    /// Negative distance.
    Inside,
    /// On the level set.
    On,
    /// Positive distance.
    Outside,
}

/// Corner of a stencil: a grid node, or the cut on the edge between two of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StencilCorner {
    /// A grid node.
    Node(u32),
    /// Cut between two grid nodes.
    Cut(u32, u32),
}

/// Corners of a grid tetrahedron sorted by side.
struct Sorted<'a> {
    nodes: [u32; 4],
    sides: [LevelSetSide; 4],
    /// Index of each corner before sorting. Long edges join the original corners 0 and 1, and 2 and 3.
    original: [usize; 4],
    /// Twice the cube coordinates of a node, for the parity rule.
    twice: &'a dyn Fn(u32) -> [i32; 3],
}

/// Calls `emit` with every tetrahedron of the part of `tet` inside, oriented positively as `tet` is.
///
/// `tet` lists the ends of one long edge, then those of the other. `twice` returns twice
/// the cube coordinates of a node.
pub(super) fn clip(
    tet: [u32; 4],
    sides: [LevelSetSide; 4],
    twice: &dyn Fn(u32) -> [i32; 3],
    mut emit: impl FnMut([StencilCorner; 4]),
) {
    let (sorted, odd) = sort(tet, sides, twice);
    // An odd permutation reverses the orientation; swapping two corners of each part restores it.
    let mut emit = |[a, b, c, d]: [StencilCorner; 4]| emit(if odd { [a, b, d, c] } else { [a, b, c, d] });
    let node = |i: usize| StencilCorner::Node(sorted.nodes[i]);
    let inside = sorted.sides.iter().filter(|side| **side == LevelSetSide::Inside).count();
    let outside = sorted.sides.iter().filter(|side| **side == LevelSetSide::Outside).count();
    match (inside, outside) {
        (0, _) => {}
        (_, 0) => emit([0, 1, 2, 3].map(node)),
        (1, _) => emit([node(0), sorted.rim(0, 1), sorted.rim(0, 2), sorted.rim(0, 3)]),
        (2, 1) => sorted.pyramid(&mut emit),
        (2, _) => {
            let order = |i, j| match (i, j) {
                (0, j) => sorted.adjoins(0, 1, j + 1),
                // The other two diagonals start at different corners, so only one diagonal on
                // the level set closes no cycle.
                _ => !sorted.adjoins(0, 1, 2),
            };
            let top = [node(0), sorted.rim(0, 2), sorted.rim(0, 3)];
            prism(top, [node(1), sorted.rim(1, 2), sorted.rim(1, 3)], order, &mut emit);
        }
        _ => {
            let cuts = [0, 1, 2].map(|i| sorted.rim(i, 3));
            prism([0, 1, 2].map(node), cuts, |i, j| sorted.adjoins(i, j, 3), &mut emit);
        }
    }
}

fn sort(tet: [u32; 4], sides: [LevelSetSide; 4], twice: &dyn Fn(u32) -> [i32; 3]) -> (Sorted<'_>, bool) {
    let (mut original, mut odd) = ([0, 1, 2, 3], false);
    // Insertion sort that tracks the parity of its swaps.
    for end in 1..4 {
        for k in (0..end).rev() {
            if sides[original[k]] > sides[original[k + 1]] {
                original.swap(k, k + 1);
                odd = !odd;
            }
        }
    }
    (Sorted { nodes: original.map(|k| tet[k]), sides: original.map(|k| sides[k]), original, twice }, odd)
}

impl Sorted<'_> {
    /// Point where the level set leaves the edge from inside corner `i` to `j`: the cut, or `j`
    /// itself if it lies on the level set.
    fn rim(&self, i: usize, j: usize) -> StencilCorner {
        if self.sides[j] == LevelSetSide::On {
            StencilCorner::Node(self.nodes[j])
        } else {
            StencilCorner::Cut(self.nodes[i], self.nodes[j])
        }
    }

    fn long(&self, i: usize, j: usize) -> bool {
        self.original[i] ^ 1 == self.original[j]
    }

    /// Returns true if the diagonal of a quadrilateral starts at i, not at j. Cutting k off face (i, j, k) leaves it.
    ///
    /// The diagonal ends at the cut on the face's long edge if that is cut. Otherwise both cuts are on short edges, and
    /// it starts at the end of the long edge that exceeds k in an even number of coordinates (the parity rule).
    fn adjoins(&self, i: usize, j: usize, k: usize) -> bool {
        if self.long(i, k) || self.long(j, k) {
            return self.long(j, k);
        }
        let (own, cut) = ((self.twice)(self.nodes[i]), (self.twice)(self.nodes[k]));
        (0..3).filter(|&axis| own[axis] > cut[axis]).count() % 2 == 0
    }

    /// Emits the part with corners 0 and 1 inside, 2 on the level set, 3 outside.
    fn pyramid(&self, emit: &mut impl FnMut([StencilCorner; 4])) {
        let [a, b, apex] = [0, 1, 2].map(|i| StencilCorner::Node(self.nodes[i]));
        let (cut_a, cut_b) = (self.rim(0, 3), self.rim(1, 3));
        if self.adjoins(0, 1, 3) {
            emit([a, b, apex, cut_b]);
            emit([a, cut_b, apex, cut_a]);
        } else {
            emit([a, b, apex, cut_a]);
            emit([cut_a, b, apex, cut_b]);
        }
    }
}

/// Emits a prism as three tetrahedra.
///
/// `before(i, j)`, i < j, returns true if the diagonal of quadrilateral (i, j) runs from top i to bottom j. The three
/// diagonals must not form a cycle. (top, any bottom) is positively oriented.
fn prism(
    top: [StencilCorner; 3],
    bottom: [StencilCorner; 3],
    before: impl Fn(usize, usize) -> bool,
    emit: &mut impl FnMut([StencilCorner; 4]),
) {
    let rank = |i: usize| (0..3).filter(|&j| j != i && if j < i { before(j, i) } else { !before(i, j) }).count();
    let ranks = [rank(0), rank(1), rank(2)];
    let mut order = [0, 1, 2];
    order.sort_by_key(|&i| ranks[i]);
    let [i, j, k] = order;
    let even = (j + 3 - i) % 3 == 1;
    let mut turn = |[a, b, c, d]: [StencilCorner; 4]| emit(if even { [a, b, c, d] } else { [a, b, d, c] });
    turn([top[i], top[j], top[k], bottom[k]]);
    turn([top[i], top[j], bottom[k], bottom[j]]);
    turn([top[i], bottom[i], bottom[j], bottom[k]]);
}

#[cfg(test)]
#[path = "stencil_tests.rs"]
mod tests;
