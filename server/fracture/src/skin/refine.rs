//! Division of triangles with long edges, without a change of the surface.
//!
//! Ours. Every edge that is too long is halved, in all of its triangles, until none is left.

use super::PointAttributes;
use crate::surface::Surface;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Largest number of triangles.
const TRIANGLES_MAX: usize = 1 << 21;

/// A corner of a triangle: its point with attributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RefinedCorner {
    /// Point of the surface.
    pub point: u32,
    /// Attributes in this triangle.
    pub attributes: PointAttributes,
}

/// Refined points, triangles, and the triangle of `surface` that contains each.
///
/// No edge is longer than `longest`, unless that needs more than [`TRIANGLES_MAX`] triangles.
pub(super) fn refine(
    surface: &Surface,
    mut triangles: Vec<[RefinedCorner; 3]>,
    longest: f64,
) -> (Vec<Point3<f64>>, Vec<[RefinedCorner; 3]>, Vec<u32>) {
    let mut points = surface.positions.clone();
    let mut sources: Vec<u32> = (0..triangles.len() as u32).collect();
    loop {
        let middles = split_edge(&mut points, &triangles, longest);
        // Every halved edge adds a triangle on each of its sides.
        if middles.is_empty() || triangles.len() + 2 * middles.len() > TRIANGLES_MAX {
            return (points, triangles, sources);
        }
        let (mut finer, mut finer_sources) = (Vec::with_capacity(2 * triangles.len()), Vec::new());
        for (triangle, &source) in triangles.iter().zip(&sources) {
            divide(triangle, &middles, &mut finer);
            finer_sources.resize(finer.len(), source);
        }
        (triangles, sources) = (finer, finer_sources);
    }
}

/// Adds the midpoints of all edges longer than `longest`. Returns the point of each edge.
fn split_edge(points: &mut Vec<Point3<f64>>, triangles: &[[RefinedCorner; 3]], longest: f64) -> HashMap<[u32; 2], u32> {
    let mut middles = HashMap::new();
    for triangle in triangles {
        for k in 0..3 {
            let ends = edge(&triangle[k], &triangle[(k + 1) % 3]);
            let [a, b] = ends.map(|point| points[point as usize]);
            if (b - a).norm() > longest && !middles.contains_key(&ends) {
                middles.insert(ends, points.len() as u32);
                points.push(nalgebra::center(&a, &b));
            }
        }
    }
    middles
}

fn edge(a: &RefinedCorner, b: &RefinedCorner) -> [u32; 2] {
    [a.point.min(b.point), a.point.max(b.point)]
}

/// Appends the parts of a triangle to `out`.
fn divide(triangle: &[RefinedCorner; 3], middles: &HashMap<[u32; 2], u32>, out: &mut Vec<[RefinedCorner; 3]>) {
    let middle = |k: usize| {
        let (a, b) = (&triangle[k], &triangle[(k + 1) % 3]);
        middles.get(&edge(a, b)).map(|&point| between(a, b, point))
    };
    let halves = [middle(0), middle(1), middle(2)];
    let [a, b, c] = *triangle;
    match halves {
        [None, None, None] => out.push(*triangle),
        [Some(ab), Some(bc), Some(ca)] => out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
        _ => {
            // Rotated so that the first edge has the only midpoint, or the first of two.
            let first = (0..3).find(|&k| halves[k].is_some() && halves[(k + 2) % 3].is_none()).unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|k| triangle[(first + k) % 3]);
            match (halves[first], halves[(first + 1) % 3]) {
                (Some(ab), None) => out.extend([[a, ab, c], [ab, b, c]]),
                (Some(ab), Some(bc)) => out.extend([[a, ab, c], [ab, b, bc], [ab, bc, c]]),
                _ => out.push(*triangle),
            }
        }
    }
}

/// Midpoint of two corners of a triangle.
fn between(a: &RefinedCorner, b: &RefinedCorner, point: u32) -> RefinedCorner {
    let (a, b) = (&a.attributes, &b.attributes);
    let sum = Vector3::from(a.normal) + Vector3::from(b.normal);
    let attributes = PointAttributes {
        normal: sum.try_normalize(0.0).map_or(a.normal, Into::into),
        uvs: [0, 1].map(|set| [0, 1].map(|k| 0.5 * (a.uvs[set][k] + b.uvs[set][k]))),
        color: [0, 1, 2, 3].map(|k| 0.5 * (a.color[k] + b.color[k])),
    };
    RefinedCorner { point, attributes }
}
