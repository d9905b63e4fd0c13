//! Separation of the inside from the outside, and the resulting mesh.

use super::error::ConformingError;
use super::split_surface::SplitSurface;
use super::tetrahedralization::{NONE, Tetrahedralization};
use super::{ConformingMesh, ConstraintKind};

/// Winding number of a tetrahedron that the search has not reached.
const UNKNOWN: i8 = i8::MIN;

/// Winding number of each tetrahedron: 0 outside, 1 inside.
///
/// # Errors
/// [`ConformingError::WrongOrientation`] if another number occurs.
pub(super) fn winding_numbers(mesh: &Tetrahedralization) -> Result<Vec<i8>, ConformingError> {
    let mut winding = vec![UNKNOWN; mesh.tets.len()];
    let start = mesh.incident[mesh.points.len() - 1];
    winding[start as usize] = 0;
    let mut open = vec![start];
    while let Some(tet) = open.pop() {
        let own = winding[tet as usize];
        for corner in 0..4 {
            let beyond = mesh.neighbors[tet as usize][corner];
            if beyond == NONE || winding[(beyond >> 2) as usize] != UNKNOWN {
                continue;
            }
            let next = match mesh.constraints[tet as usize] >> corner & 0x11 {
                0x11 => own - 1,
                0x01 => own + 1,
                _ => own,
            };
            if !(0..=1).contains(&next) {
                let at = *mesh.point(mesh.tets[(beyond >> 2) as usize][0]);
                return Err(ConformingError::WrongOrientation { winding: next.into(), at });
            }
            winding[(beyond >> 2) as usize] = next;
            open.push(beyond >> 2);
        }
    }
    Ok(winding)
}

/// Keeps the tetrahedra inside the surface.
///
/// The points of the mesh are the vertices of the surface and then the interior points.
///
/// # Errors
/// [`ConformingError::WrongOrientation`]; [`ConformingError::Unrecovered`] if the faces between inside and outside are
/// not the triangles of the surface, or a tetrahedron is not positive.
pub(super) fn extract(
    mesh: &Tetrahedralization,
    surface: SplitSurface,
    rounds: u32,
) -> Result<ConformingMesh, ConformingError> {
    let winding = winding_numbers(mesh)?;
    let boundary_count = surface.positions.len();
    let mut tets = Vec::new();
    let mut nodes = vec![NONE; mesh.points.len()];
    let mut faces = 0;
    for (tet, corners) in mesh.tets.iter().enumerate().filter(|(tet, _)| winding[*tet] == 1) {
        let unsound = || {
            let at = *mesh.point(corners[0]);
            Err(ConformingError::Unrecovered { kind: ConstraintKind::Facet, at, rounds, missing: 1 })
        };
        if mesh.orientation(corners[0], corners[1], corners[2], corners[3]) <= 0.0 {
            return unsound();
        }
        for corner in 0..4 {
            let beyond = mesh.neighbors[tet][corner];
            let is_boundary = beyond == NONE || winding[(beyond >> 2) as usize] == 0;
            if is_boundary != (mesh.constraints[tet] >> corner & 0x11 == 0x11) {
                return unsound();
            }
            faces += usize::from(is_boundary);
        }
        corners.iter().for_each(|&corner| nodes[corner as usize] = 0);
        tets.push(*corners);
    }
    if let Some(vertex) = nodes[..boundary_count].iter().position(|&node| node == NONE) {
        let at = surface.positions[vertex];
        return Err(ConformingError::Unrecovered { kind: ConstraintKind::Facet, at, rounds, missing: 1 });
    }
    if faces != surface.triangles.len() {
        let at = surface.positions[0];
        let missing = surface.triangles.len().abs_diff(faces);
        return Err(ConformingError::Unrecovered { kind: ConstraintKind::Facet, at, rounds, missing });
    }
    let deviation = surface.deviation();
    let mut positions = surface.positions;
    (0..boundary_count).for_each(|vertex| nodes[vertex] = vertex as u32);
    let mut interior_sources = Vec::new();
    for (vertex, node) in nodes.iter_mut().enumerate().skip(boundary_count).filter(|(_, node)| **node != NONE) {
        *node = positions.len() as u32;
        positions.push(mesh.points[vertex]);
        interior_sources.push((vertex - boundary_count) as u32);
    }
    tets.iter_mut().flatten().for_each(|corner| *corner = nodes[*corner as usize]);
    Ok(ConformingMesh {
        nodes: positions,
        tets,
        boundary: surface.triangles,
        boundary_sources: surface.sources,
        places: surface.places,
        interior_sources,
        steiner_count: 0,
        rounds,
        steps: 0,
        deviation,
    })
}
