//! Recovery of the surface's edges by local changes.
//!
//! Based on: P. L. George, F. Hecht, E. Saltel, *Automatic mesh generator with specified boundary* (1991). Each change must
//! lower the number of faces that cross the missing edge, so the recovery ends.

use super::edge_list::EdgeList;
use super::edge_removal::Recovery;
use super::error::ConformingError;
use super::recovery_target::{Crossing, RecoveryTarget, segment_crosses};
use super::search::Search;
use super::segment_set::SegmentSet;
use super::tetrahedralization::{NONE, Tetrahedralization};

/// Path between the ends of an edge of the surface.
enum Path {
    /// The edge is in the mesh.
    Present,
    /// This vertex lies on the edge.
    Blocked(u32),
    /// These faces (tetrahedron and corner) and edges cross it, those near its first end first.
    Crossed { faces: Vec<(u32, usize)>, edges: EdgeList },
}

/// Edges of the surface that are not in the mesh, in ascending order.
pub(super) fn missing_segments(mesh: &mut Tetrahedralization, segments: &SegmentSet, count: usize) -> Vec<[u32; 2]> {
    let mut missing = Vec::new();
    let mut near: Vec<u32> = Vec::new();
    for vertex in 0..count as u32 {
        if !segments.of(vertex).iter().any(|&end| end > vertex) {
            continue;
        }
        near.clear();
        near.extend(mesh.star(vertex).into_iter().flat_map(|tet| mesh.tets[tet as usize]));
        near.sort_unstable();
        let is_missing = |end: &&u32| **end > vertex && near.binary_search(end).is_err();
        missing.extend(segments.of(vertex).iter().filter(is_missing).map(|&end| [vertex, end]));
    }
    missing
}

/// Recovers missing edges; returns those that stay missing.
///
/// # Errors
/// [`ConformingError::PointOnSurface`], and those of [`super::work_limit::WorkLimit::check`].
pub(super) fn recover_segments(search: &mut Search, missing: Vec<[u32; 2]>) -> Result<Vec<[u32; 2]>, ConformingError> {
    search.recover(missing, |recovery, segment, depth| recovery.recover_segment(segment, depth))
}

impl Recovery<'_, '_> {
    /// Removes faces and edges that cross a segment until the mesh contains it.
    ///
    /// # Errors
    /// [`ConformingError::PointOnSurface`].
    fn recover_segment(&mut self, [a, b]: [u32; 2], depth: u32) -> Result<bool, ConformingError> {
        loop {
            let is_changed = [[a, b], [b, a]].into_iter().any(|segment| self.clear_path(segment, depth));
            if !is_changed {
                return match self.path([a, b]) {
                    Path::Present => Ok(true),
                    Path::Crossed { .. } => Ok(false),
                    Path::Blocked(vertex) => Err(ConformingError::PointOnSurface { at: *self.mesh.point(vertex) }),
                };
            }
        }
    }

    /// Removes one obstacle of a segment.
    fn clear_path(&mut self, segment: [u32; 2], depth: u32) -> bool {
        let target = RecoveryTarget::Segment(segment);
        if self.limit.is_exceeded(self.mesh) {
            return false;
        }
        let Path::Crossed { faces, edges } = self.path(segment) else { return false };
        if faces.iter().any(|&(tet, corner)| self.remove_face(tet, corner, &target)) {
            return true;
        }
        let mut candidates = edges;
        for (tet, corner) in faces {
            let [p, q, r] = self.mesh.face(tet, corner);
            for side in [[p, q], [q, r], [r, p]] {
                candidates.add(side, tet);
            }
        }
        self.remove_one(candidates.all(), &target, depth)
    }

    /// Faces and edges that cross a segment.
    fn path(&mut self, [a, b]: [u32; 2]) -> Path {
        let mesh = &mut *self.mesh;
        let mut open = mesh.star(a);
        if open.iter().any(|&tet| mesh.corner(tet, b).is_some()) {
            return Path::Present;
        }
        let (mut faces, mut edges) = (Vec::new(), EdgeList::default());
        let mut next = 0;
        while let Some(&tet) = open.get(next) {
            next += 1;
            for corner in 0..4 {
                let face = mesh.face(tet, corner);
                let Some(crossing) = segment_crosses(mesh, [a, b], face) else { continue };
                let beyond = mesh.neighbors[tet as usize][corner];
                match crossing {
                    Crossing::Vertex(corner) => return Path::Blocked(face[corner]),
                    Crossing::Inside => {
                        if beyond != NONE && mesh.mark(beyond >> 2) {
                            faces.push((tet, corner));
                            open.push(beyond >> 2);
                        }
                    }
                    Crossing::Edge(opposite) => {
                        let edge = [face[(opposite + 1) % 3], face[(opposite + 2) % 3]];
                        if edges.add(edge, tet) {
                            let ring = mesh.ring(tet, edge).unwrap_or_default();
                            for around in ring.tets {
                                if mesh.mark(around) {
                                    open.push(around);
                                }
                            }
                        }
                    }
                }
            }
        }
        Path::Crossed { faces, edges }
    }
}
