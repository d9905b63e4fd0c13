//! Removal of tetrahedra without height.
//!
//! The recovery leaves them between vertices of the surface that lie in one plane or on one line: the surface divides a
//! quadrilateral by one diagonal, the mesh below it by the other, or the surface divides an edge and the mesh does not.
//! Such tetrahedra are positive by rounding only. Cracks run across both of their sides, on each by itself, so parts of the
//! cracks would lie in the surface. Without one of its edges inside, such a tetrahedron disappears, and the surface stays.
//!
//! Based on: L. A. Freitag, C. Ollivier-Gooch, *Tetrahedral mesh improvement using swapping and smoothing* (1997). The
//! aim, as few flat tetrahedra as possible, is ours.

use super::edge_removal::Recovery;
use super::error::ConformingError;
use super::inside::winding_numbers;
use super::recovery_target::is_flat;
use super::search::Search;

/// Depth of removal in each pass over all tetrahedra. Each pass may open the way for the next.
const DEPTHS: [u32; 4] = [0, 0, 1, 2];

/// Edges whose removal is tried per flat tetrahedron.
const BUDGET: u32 = 200;

/// Removes flat tetrahedra inside the surface, all of whose triangles are constraints. Some may stay.
///
/// It takes steps only while some are left, and does not count them.
///
/// # Errors
/// [`ConformingError::WrongOrientation`].
pub(super) fn remove_flat_tets(search: &mut Search) -> Result<(), ConformingError> {
    for depth in DEPTHS {
        let mut flat = Vec::new();
        for (tet, winding) in (0..).zip(winding_numbers(search.mesh)?) {
            let corners = search.mesh.tets[tet as usize];
            if winding == 1 && is_flat(search.mesh, corners) {
                flat.push((tet, corners));
            }
        }
        for (tet, corners) in flat {
            // An earlier removal may have replaced it.
            if search.mesh.tets[tet as usize] == corners {
                let Search { mesh, segments, limit } = search;
                Recovery { mesh, segments, limit, budget: BUDGET, removed: Vec::new() }.remove_flat_tet(tet, depth);
            }
        }
    }
    Ok(())
}
