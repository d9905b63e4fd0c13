//! Checks of a skin and of the attributes of a cutting mesh against the lattices, and of their indices against each other.
//!
//! Three relations hold for what a bake writes:
//!
//! - Vertices and attributes are numbered in the order of their first use by triangles.
//! - Edges of a skin have a largest length, except those of the walls of existing cracks.
//! - A skin point's position in the lattices is the nearest one. So along an edge, the distance to it changes by at most the edge's length.

use super::DatabaseError;
use super::stored_values::implausible;
use crate::pipeline::PreparedBody;
use crate::skin::{EDGE_SPACINGS, Skin, SkinPoint, TRIANGLES_MAX};
use crate::tessellation::OuterFace;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Rounding allowed in lengths, local and relative.
const TOLERANCE: f64 = 1e-6;

/// Number of triangles from which the edges of a skin may be longer: the division of its triangles is limited.
const LIMITED: usize = TRIANGLES_MAX / 16;

/// Checks that `indices` name each of `count` rows, in the order of their first use.
fn first_use(tensor: &str, indices: &[u32], count: usize) -> Result<(), DatabaseError> {
    let mut next = 0;
    for (index, &own) in indices.iter().enumerate() {
        if own > next {
            return Err(implausible(tensor, index, f64::from(own), "the next row, or one that was used before"));
        }
        next = next.max(own + 1);
    }
    match next as usize == count {
        true => Ok(()),
        false => Err(implausible(tensor, indices.len(), f64::from(next), "a number of used rows that is that of all")),
    }
}

/// Checks the attributes at the corners of `boundary`: each of the `count` points belongs to one node.
pub(super) fn corners(
    tensor: &str,
    corners: &[u32],
    count: usize,
    boundary: &[OuterFace],
) -> Result<(), DatabaseError> {
    first_use(tensor, corners, count)?;
    let mut owners = vec![None; count];
    let nodes = boundary.iter().flat_map(|face| face.nodes);
    for (index, (&point, node)) in corners.iter().zip(nodes).enumerate() {
        if *owners[point as usize].get_or_insert(node) != node {
            return Err(implausible(tensor, index, f64::from(point), "attributes of this corner's node"));
        }
    }
    Ok(())
}

/// Checks the triangles of a skin, its points and their positions in the lattices of `bodies`. `spacing`: that of the crack lattice, local;
/// infinite if edges may have any length.
pub(super) fn skin(skin: &Skin, bodies: &[PreparedBody], spacing: f64) -> Result<(), DatabaseError> {
    first_use("skin.triangles", skin.triangles.as_flattened(), skin.vertices.len())?;
    let distances: Vec<f64> =
        skin.points.par_iter().zip(&skin.spots).map(|(point, spot)| (point - place(spot, bodies)).norm()).collect();
    let longest = if skin.triangles.len() < LIMITED { EDGE_SPACINGS * spacing } else { f64::INFINITY };
    let points = |triangle: usize| skin.triangles[triangle].map(|vertex| skin.vertices[vertex as usize] as usize);
    let fault = |triangle: usize| {
        let own = points(triangle);
        let edges = [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|corner| own[corner]));
        edges.into_iter().find_map(|[a, b]| {
            let length = (skin.points[a] - skin.points[b]).norm();
            let jump = (distances[a] - distances[b]).abs();
            let far = if distances[a] > distances[b] { a } else { b };
            if length > longest * (1.0 + TOLERANCE) {
                Some(implausible("skin.points", 3 * a, length, "an edge of at most 0.7 crack spacings"))
            } else if jump > length + TOLERANCE {
                Some(implausible("skin.spots", 2 * far, distances[far], "the distance to the nearest lattice point"))
            } else {
                None
            }
        })
    };
    (0..skin.triangles.len()).into_par_iter().find_map_first(fault).map_or(Ok(()), Err)
}

/// Place of a position in the lattices, local.
fn place(spot: &SkinPoint, bodies: &[PreparedBody]) -> Point3<f64> {
    let corners = bodies[spot.body as usize].crack.corners(spot.place.tet as usize);
    let weighted = corners.iter().zip(spot.place.barycentric).map(|(corner, weight)| corner.coords * weight);
    Point3::from(weighted.sum::<Vector3<f64>>())
}
