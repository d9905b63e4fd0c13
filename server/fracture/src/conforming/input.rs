//! Checks of the input: a closed, oriented 2-manifold that does not intersect itself.

use super::error::ConformingError;
use super::predicates::{is_exact, orientation};
use crate::surface::crossings;
use nalgebra::{Point2, Point3};
use robust::{Coord, orient2d};

/// Input of the mesher: vertices and outward triangles, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Input<'a> {
    /// Vertices of the surface.
    pub positions: &'a [Point3<f64>],
    /// Triangles of the surface.
    pub triangles: &'a [[u32; 3]],
    /// Points inside the surface.
    pub interior: &'a [Point3<f64>],
}

/// Directed edges of triangles in ascending order, each with its triangle.
pub(super) fn directed_edges(triangles: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let edges = |(triangle, &[a, b, c]): (u32, &[u32; 3])| [[a, b], [b, c], [c, a]].map(|edge| (edge, triangle));
    let mut edges: Vec<([u32; 2], u32)> = (0_u32..).zip(triangles).flat_map(edges).collect();
    edges.sort_unstable();
    edges
}

/// Checks coordinates, triangles, edges, vertices and intersections, in this order.
pub(super) fn check(input: &Input) -> Result<(), ConformingError> {
    let Input { positions, triangles, interior } = *input;
    if let Some(point) = positions.iter().chain(interior).position(|point| !is_exact(point)) {
        return Err(ConformingError::InvalidPoint { point });
    }
    if let Some(&point) = triangles.iter().flatten().find(|&&vertex| vertex as usize >= positions.len()) {
        return Err(ConformingError::InvalidPoint { point: point as usize });
    }
    for (triangle, corners) in (0..).zip(triangles) {
        let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
        if is_flat(&a, &b, &c) {
            return Err(ConformingError::DegenerateTriangle { triangle });
        }
    }
    let edges = directed_edges(triangles);
    check_edges(&edges)?;
    check_vertices(positions.len(), triangles, &edges)?;
    check_intersections(positions, triangles, &edges)
}

/// Returns true if three points lie on a line; exact.
pub(super) fn is_flat(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>) -> bool {
    (0..3).all(|axis| turn(axis, a, b, c) == 0.0)
}

/// Sign of the area of three points projected along an axis; exact.
fn turn(axis: usize, a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>) -> f64 {
    let flat = |point: &Point3<f64>| Point2::new(point[(axis + 1) % 3], point[(axis + 2) % 3]);
    let [a, b, c] = [a, b, c].map(flat).map(|point| Coord { x: point.x, y: point.y });
    orient2d(a, b, c)
}

fn check_edges(edges: &[([u32; 2], u32)]) -> Result<(), ConformingError> {
    let open = |edge: [u32; 2]| Err(ConformingError::OpenEdge { edge });
    if let Some(pair) = edges.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return open(pair[0].0);
    }
    match edges.iter().find(|([a, b], _)| edges.binary_search_by_key(&[*b, *a], |(edge, _)| *edge).is_err()) {
        Some(&(edge, _)) => open(edge),
        None => Ok(()),
    }
}

/// Checks that the triangles around each vertex form one fan.
fn check_vertices(count: usize, triangles: &[[u32; 3]], edges: &[([u32; 2], u32)]) -> Result<(), ConformingError> {
    let mut degrees = vec![0_u32; count];
    triangles.iter().flatten().for_each(|&vertex| degrees[vertex as usize] += 1);
    let mut start = 0;
    for (vertex, &degree) in (0_u32..).zip(&degrees) {
        let fan = start..start + degree as usize;
        start = fan.end;
        let Some(&(first, _)) = edges.get(fan.start).filter(|_| degree > 0) else { continue };
        let (mut edge, mut length) = (first, 0);
        while let Ok(place) = edges.binary_search_by_key(&edge, |(edge, _)| *edge) {
            let corners = triangles[edges[place].1 as usize];
            let Some(own) = corners.iter().position(|&corner| corner == vertex) else { break };
            edge = [vertex, corners[(own + 2) % 3]];
            length += 1;
            if edge == first || length > degree {
                break;
            }
        }
        if length != degree {
            return Err(ConformingError::NonManifoldVertex { vertex });
        }
    }
    Ok(())
}

fn check_intersections(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    edges: &[([u32; 2], u32)],
) -> Result<(), ConformingError> {
    for &([a, b], triangle) in edges.iter().filter(|([a, b], _)| a < b) {
        let Ok(place) = edges.binary_search_by_key(&[b, a], |(edge, _)| *edge) else { continue };
        let other = edges[place].1;
        let apex = |triangle: u32| triangles[triangle as usize].into_iter().find(|&vertex| vertex != a && vertex != b);
        if let (Some(c), Some(d)) = (apex(triangle), apex(other))
            && is_folded([a, b, c, d].map(|vertex| &positions[vertex as usize]))
        {
            return Err(ConformingError::SelfIntersection { first: triangle.min(other), second: triangle.max(other) });
        }
    }
    let all: Vec<u32> = (0..triangles.len() as u32).collect();
    match crossings(positions, triangles, &all).into_iter().map(|[own, other]| [own.min(other), own.max(other)]).min() {
        Some([first, second]) => Err(ConformingError::SelfIntersection { first, second }),
        None => Ok(()),
    }
}

/// Returns true if the triangles (a, b, c) and (b, a, d) lie in one plane and overlap.
fn is_folded([a, b, c, d]: [&Point3<f64>; 4]) -> bool {
    orientation(a, b, c, d) == 0.0 && (0..3).any(|axis| turn(axis, a, b, c) * turn(axis, a, b, d) > 0.0)
}
