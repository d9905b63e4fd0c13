//! Missing constraint that local changes of the mesh bring back, and the obstacles in its way.

use super::tetrahedralization::Tetrahedralization;
use crate::tessellation::relative_height;

/// Height of a flat tetrahedron, over its longest edge.
const FLAT: f64 = 1e-3;

/// Missing constraint of the surface, or other aim of local changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RecoveryTarget {
    /// Edge; faces of the mesh cross it.
    Segment([u32; 2]),
    /// Triangle whose edges exist; edges of the mesh cross it.
    Facet([u32; 3]),
    /// Tetrahedra with a height; flat ones are in the way.
    Heights,
}

/// Place at which a segment crosses a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Crossing {
    /// Through its inside.
    Inside,
    /// Through the edge opposite this corner of the face.
    Edge(usize),
    /// Through this corner of the face.
    Vertex(usize),
}

impl RecoveryTarget {
    /// Number of obstacles that a face is: 1 if it crosses the segment.
    #[inline]
    pub fn face_cost(&self, mesh: &Tetrahedralization, face: [u32; 3]) -> u32 {
        match *self {
            Self::Segment(segment) => u32::from(segment_crosses(mesh, segment, face).is_some()),
            Self::Facet(_) | Self::Heights => 0,
        }
    }

    /// Number of obstacles that an edge is: 1 if it crosses the facet.
    #[inline]
    pub fn edge_cost(&self, mesh: &Tetrahedralization, edge: [u32; 2]) -> u32 {
        match *self {
            Self::Segment(_) | Self::Heights => 0,
            Self::Facet(facet) => u32::from(segment_crosses(mesh, edge, facet).is_some()),
        }
    }

    /// Number of obstacles that a tetrahedron is: 1 if it is flat and has to go.
    #[inline]
    pub fn tet_cost(&self, mesh: &Tetrahedralization, corners: [u32; 4]) -> u32 {
        match *self {
            Self::Segment(_) | Self::Facet(_) => 0,
            Self::Heights => u32::from(is_flat(mesh, corners)),
        }
    }
}

/// Returns true if these corners form a flat tetrahedron.
pub(super) fn is_flat(mesh: &Tetrahedralization, corners: [u32; 4]) -> bool {
    relative_height(&corners.map(|corner| *mesh.point(corner))) < FLAT
}

/// Crossing of a segment and a face without common vertices. None if the segment misses it, or lies in its plane.
pub(super) fn segment_crosses(mesh: &Tetrahedralization, [a, b]: [u32; 2], face: [u32; 3]) -> Option<Crossing> {
    let [p, q, r] = face;
    if face.contains(&a) || face.contains(&b) {
        return None;
    }
    let sides = [mesh.orientation(p, q, r, a), mesh.orientation(p, q, r, b)];
    if !(sides[0] > 0.0 && sides[1] < 0.0 || sides[0] < 0.0 && sides[1] > 0.0) {
        return None;
    }
    let turns = [mesh.orientation(a, b, q, r), mesh.orientation(a, b, r, p), mesh.orientation(a, b, p, q)];
    if turns.iter().any(|turn| *turn > 0.0) && turns.iter().any(|turn| *turn < 0.0) {
        return None;
    }
    let zeros = turns.map(|turn| turn == 0.0);
    Some(match zeros {
        [false, false, false] => Crossing::Inside,
        [true, false, false] => Crossing::Edge(0),
        [false, true, false] => Crossing::Edge(1),
        [false, false, true] => Crossing::Edge(2),
        [true, true, _] => Crossing::Vertex(2),
        [true, _, true] => Crossing::Vertex(1),
        [_, true, true] => Crossing::Vertex(0),
    })
}
