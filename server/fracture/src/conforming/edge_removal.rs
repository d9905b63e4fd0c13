//! Local changes of the mesh: removal of an edge, and of a face.
//!
//! Based on: J. R. Shewchuk, *Two discrete optimization algorithms for the topological improvement of tetrahedral meshes*
//! (2002); H. Si, *TetGen, a Delaunay-based quality tetrahedral mesh generator* (2015), section 4.2. Every change keeps
//! all tetrahedra positive, the segments present in the mesh, and the faces that are constraints.

use super::recovery_target::RecoveryTarget;
use super::segment_set::SegmentSet;
use super::tetrahedralization::{NONE, Ring, Tetrahedralization, unpack};
use super::work_limit::WorkLimit;

/// Largest number of tetrahedra around an edge that is removed. The search is cubic in it.
const RING_MAX: usize = 24;

/// Mesh with constraints that local changes keep.
pub(super) struct Recovery<'a, 'b> {
    /// The mesh.
    pub mesh: &'a mut Tetrahedralization,
    /// Edges of the surface. Those in the mesh stay.
    pub segments: &'a SegmentSet,
    /// Removals that may still be tried for the current target.
    pub budget: u32,
    /// Limit of all work.
    pub limit: &'a mut WorkLimit<'b>,
    /// Edges removed without a gain for the current target. They are not removed so again.
    pub removed: Vec<[u32; 2]>,
}

/// Triangulation of a ring's polygon.
struct Fill {
    cost: u32,
    triangles: Vec<[u32; 3]>,
}

impl Recovery<'_, '_> {
    /// Removes one of these edges, if `target` gains by it. Otherwise, removes one at no loss, each edge only once.
    ///
    /// Each edge comes with a tetrahedron that contains it.
    pub fn remove_one(&mut self, edges: &[([u32; 2], u32)], target: &RecoveryTarget, depth: u32) -> bool {
        if edges.iter().any(|&(edge, near)| self.remove_edge(edge, &[near], target, 1, depth)) {
            return true;
        }
        let is_new = |removed: &[[u32; 2]], [a, b]: [u32; 2]| !removed.contains(&[a, b]) && !removed.contains(&[b, a]);
        let found = edges
            .iter()
            .find(|&&(edge, near)| is_new(&self.removed, edge) && self.remove_edge(edge, &[near], target, 0, 0));
        self.removed.extend(found.map(|(edge, _)| edge));
        found.is_some()
    }

    /// Removes a flat tetrahedron, and other flat ones with it, by removing one of its edges.
    pub fn remove_flat_tet(&mut self, tet: u32, depth: u32) -> bool {
        let corners = self.mesh.tets[tet as usize];
        let mut pairs = (0..4).flat_map(|j| (0..j).map(move |i| [corners[i], corners[j]]));
        pairs.any(|edge| self.remove_edge(edge, &[tet], &RecoveryTarget::Heights, 1, depth))
    }

    /// Replaces a face by the edge between the corners opposite it, if this removes obstacles of `target`.
    pub fn remove_face(&mut self, tet: u32, corner: usize, target: &RecoveryTarget) -> bool {
        let mesh = &mut *self.mesh;
        let beyond = mesh.neighbors[tet as usize][corner];
        if beyond == NONE || mesh.is_constraint(tet, corner) {
            return false;
        }
        let (other, back) = unpack(beyond);
        let [p, q, r] = mesh.face(tet, corner);
        let (below, above) = (mesh.tets[tet as usize][corner], mesh.tets[other as usize][back]);
        let new = [[p, q], [q, r], [r, p]].map(|[u, v]| [u, v, below, above]);
        if new.iter().any(|&[u, v, below, above]| mesh.orientation(u, v, below, above) <= 0.0) {
            return false;
        }
        let old_cost = target.face_cost(mesh, [p, q, r]);
        let new_cost = target.edge_cost(mesh, [below, above])
            + [p, q, r].iter().map(|&u| target.face_cost(mesh, [u, below, above])).sum::<u32>();
        if new_cost >= old_cost {
            return false;
        }
        mesh.replace(&[tet, other], &new);
        true
    }

    /// Removes an edge, if `gain` obstacles of `target` or more disappear with it.
    ///
    /// If the tetrahedra around the edge cannot be replaced, edges from its ends to the ring around it are removed
    /// first, `depth` levels deep. These changes stay if the edge does too. The search for the edge begins at `near`.
    fn remove_edge(&mut self, edge: [u32; 2], near: &[u32], target: &RecoveryTarget, gain: u32, depth: u32) -> bool {
        if self.segments.contains(edge) || self.budget == 0 || self.limit.is_exceeded(self.mesh) {
            return false;
        }
        self.budget -= 1;
        self.limit.count_removal();
        let Some(mut ring) = self.open_ring(edge, near) else { return false };
        if self.refill(edge, &ring, target, gain) {
            return true;
        }
        if depth == 0 || !self.limit.allows_depth() {
            return false;
        }
        for vertex in ring.vertices.clone() {
            for end in edge {
                let Some(place) = ring.vertices.iter().position(|&other| other == vertex) else { continue };
                let near = [ring.tets[place]];
                if self.remove_edge([end, vertex], &near, target, 0, depth - 1) {
                    let Some(changed) = self.open_ring(edge, &ring.tets) else { return false };
                    ring = changed;
                    if self.refill(edge, &ring, target, gain) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Ring around an edge without constraints among its faces.
    fn open_ring(&mut self, edge: [u32; 2], near: &[u32]) -> Option<Ring> {
        let [a, b] = edge;
        let contains = |tet: &u32| self.mesh.corner(*tet, a).is_some() && self.mesh.corner(*tet, b).is_some();
        let tet = near.iter().copied().find(contains).or_else(|| self.mesh.tet_of_edge(edge))?;
        let ring = self.mesh.ring(tet, edge)?;
        let mesh = &*self.mesh;
        let is_open = |&tet: &u32| {
            (0..4).all(|corner| edge.contains(&mesh.tets[tet as usize][corner]) || !mesh.is_constraint(tet, corner))
        };
        (ring.tets.len() <= RING_MAX && ring.tets.iter().all(is_open)).then_some(ring)
    }

    /// Replaces the tetrahedra around an edge by others without it.
    fn refill(&mut self, edge: [u32; 2], ring: &Ring, target: &RecoveryTarget, gain: u32) -> bool {
        let mesh = &*self.mesh;
        let [p, q] = edge;
        let old_cost = target.edge_cost(mesh, edge)
            + ring.vertices.iter().map(|&vertex| target.face_cost(mesh, [p, q, vertex])).sum::<u32>()
            + ring.tets.iter().map(|&tet| target.tet_cost(mesh, mesh.tets[tet as usize])).sum::<u32>();
        let Some(limit) = old_cost.checked_sub(gain) else { return false };
        let Some(fill) = fill_ring(mesh, edge, &ring.vertices, target) else { return false };
        if fill.cost > limit {
            return false;
        }
        let new: Vec<[u32; 4]> = fill.triangles.iter().flat_map(|&[u, v, w]| [[p, u, v, w], [u, v, w, q]]).collect();
        self.mesh.replace(&ring.tets, &new);
        true
    }
}

/// Triangulation of the polygon around an edge whose tetrahedra with both ends are positive, with the fewest obstacles.
///
/// By dynamic programming over the diagonals: G. T. Klincsek, *Minimal triangulations of polygonal domains* (1980).
fn fill_ring(mesh: &Tetrahedralization, [p, q]: [u32; 2], ring: &[u32], target: &RecoveryTarget) -> Option<Fill> {
    let count = ring.len();
    // Per pair of polygon corners: the least cost between them and the corner that attains it.
    let mut best: Vec<Option<(u32, usize)>> = vec![None; count * count];
    for first in 0..count - 1 {
        best[first * count + first + 1] = Some((0, first));
    }
    for span in 2..count {
        for first in 0..count - span {
            let last = first + span;
            let diagonal = if span == count - 1 {
                0
            } else {
                target.edge_cost(mesh, [ring[first], ring[last]])
                    + target.face_cost(mesh, [p, ring[first], ring[last]])
                    + target.face_cost(mesh, [q, ring[first], ring[last]])
            };
            for middle in first + 1..last {
                let (Some((one, _)), Some((two, _))) = (best[first * count + middle], best[middle * count + last])
                else {
                    continue;
                };
                let [u, v, w] = [first, middle, last].map(|k| ring[k]);
                if mesh.orientation(p, u, v, w) <= 0.0 || mesh.orientation(u, v, w, q) <= 0.0 {
                    continue;
                }
                let tets = target.tet_cost(mesh, [p, u, v, w]) + target.tet_cost(mesh, [u, v, w, q]);
                let cost = one + two + diagonal + tets + target.face_cost(mesh, [u, v, w]);
                let entry = &mut best[first * count + last];
                if entry.is_none_or(|(known, _)| cost < known) {
                    *entry = Some((cost, middle));
                }
            }
        }
    }
    let (cost, _) = best[count - 1]?;
    let (mut open, mut triangles) = (vec![(0, count - 1)], Vec::with_capacity(count - 2));
    while let Some((first, last)) = open.pop() {
        if last > first + 1 {
            let (_, middle) = best[first * count + last]?;
            triangles.push([ring[first], ring[middle], ring[last]]);
            open.extend([(first, middle), (middle, last)]);
        }
    }
    Some(Fill { cost, triangles })
}
