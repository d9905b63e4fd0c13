//! Recovery of the surface's triangles by local changes, once their edges exist.

use super::edge_list::EdgeList;
use super::edge_removal::Recovery;
use super::error::ConformingError;
use super::recovery_target::{RecoveryTarget, segment_crosses};
use super::search::Search;
use super::tetrahedralization::{FACES, Tetrahedralization, unpack};

/// Makes every triangle that is a face of the mesh a constraint; returns the others.
///
/// # Errors
/// Those of [`super::work_limit::WorkLimit::check`].
pub(super) fn constrain_facets(search: &mut Search, facets: &[[u32; 3]]) -> Result<Vec<[u32; 3]>, ConformingError> {
    let mut missing = Vec::new();
    for &facet in facets {
        search.limit.check(search.mesh)?;
        if !constrain_facet(search.mesh, facet) {
            missing.push(facet);
        }
    }
    Ok(missing)
}

/// Makes a face of the mesh a constraint; returns false if the mesh does not contain it.
fn constrain_facet(mesh: &mut Tetrahedralization, facet: [u32; 3]) -> bool {
    let Some(face) = mesh.face_of(facet) else { return false };
    let (tet, corner) = unpack(face);
    let (other, back) = unpack(mesh.neighbors[tet as usize][corner]);
    let [p, q, r] = FACES[corner].map(|k| mesh.tets[tet as usize][k]);
    let is_inner = [[p, q, r], [q, r, p], [r, p, q]].contains(&facet);
    for (tet, corner, is_inner) in [(tet, corner, is_inner), (other, back, !is_inner)] {
        mesh.constraints[tet as usize] |= (1 | u8::from(is_inner) << 4) << corner;
    }
    true
}

/// Recovers missing triangles whose edges exist; returns those that stay missing.
///
/// # Errors
/// [`ConformingError::PointOnSurface`], and those of [`super::work_limit::WorkLimit::check`].
pub(super) fn recover_facets(search: &mut Search, missing: Vec<[u32; 3]>) -> Result<Vec<[u32; 3]>, ConformingError> {
    search.recover(missing, |recovery, facet, depth| recovery.recover_facet(facet, depth))
}

impl Recovery<'_, '_> {
    /// Removes edges that cross a facet until the mesh contains it, and makes it a constraint.
    ///
    /// # Errors
    /// [`ConformingError::PointOnSurface`].
    fn recover_facet(&mut self, facet: [u32; 3], depth: u32) -> Result<bool, ConformingError> {
        let target = RecoveryTarget::Facet(facet);
        loop {
            if constrain_facet(self.mesh, facet) {
                return Ok(true);
            }
            let crossing = self.crossing_edges(facet);
            if self.limit.is_exceeded(self.mesh) || !self.remove_one(crossing.all(), &target, depth) {
                // A search without a gain changes the mesh, too.
                if constrain_facet(self.mesh, facet) {
                    return Ok(true);
                }
                return match self.vertex_on(facet) {
                    Some(vertex) => Err(ConformingError::PointOnSurface { at: *self.mesh.point(vertex) }),
                    None => Ok(false),
                };
            }
        }
    }

    /// Vertex that lies on a facet and forms a face of the mesh with its first edge.
    ///
    /// The facet's other edges exist and keep a face that begins like the facet inside it.
    fn vertex_on(&mut self, [a, b, c]: [u32; 3]) -> Option<u32> {
        let tet = self.mesh.tet_of_edge([a, b])?;
        let ring = self.mesh.ring(tet, [a, b])?;
        let mesh = &*self.mesh;
        let beside = ring.vertices.iter().copied().find(|&vertex| mesh.orientation(a, b, c, vertex) != 0.0)?;
        let side = mesh.orientation(a, b, beside, c);
        ring.vertices.into_iter().find(|&vertex| {
            let other = mesh.orientation(a, b, beside, vertex);
            mesh.orientation(a, b, c, vertex) == 0.0 && (side > 0.0 && other > 0.0 || side < 0.0 && other < 0.0)
        })
    }

    /// Edges of the mesh that cross a facet.
    fn crossing_edges(&mut self, facet: [u32; 3]) -> EdgeList {
        let [a, b, _] = facet;
        let mesh = &mut *self.mesh;
        let Some(tet) = mesh.tet_of_edge([a, b]) else { return EdgeList::default() };
        let Some(ring) = mesh.ring(tet, [a, b]) else { return EdgeList::default() };
        let (mut open, mut crossing) = (ring.tets, EdgeList::default());
        mesh.clear_marks();
        for &tet in &open {
            mesh.mark(tet);
        }
        let mut next = 0;
        while let Some(&tet) = open.get(next) {
            next += 1;
            let [p, q, r, s] = mesh.tets[tet as usize];
            for edge in [[p, q], [p, r], [p, s], [q, r], [q, s], [r, s]] {
                if segment_crosses(mesh, edge, facet).is_none() || !crossing.add(edge, tet) {
                    continue;
                }
                for around in mesh.ring(tet, edge).unwrap_or_default().tets {
                    if mesh.mark(around) {
                        open.push(around);
                    }
                }
            }
        }
        crossing
    }
}
