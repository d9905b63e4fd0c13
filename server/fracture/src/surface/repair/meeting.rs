//! A point in which two triangles meet, for messages.

use super::intersect::{Triangle, flatten, inside_flat, segment_meets, side};
use nalgebra::Point3;
use robust::orient2d;

/// Point in which two triangles meet that [`super::meet`] finds or that share an edge; `None` if they are apart.
///
/// Each is given by its vertices and their positions. The point is the mean of the corners of their common part: the
/// middle of a crossing, or the middle of the shared edge. If they share one vertex, the crossing counts, not the vertex.
pub(crate) fn meeting_point(
    (one, at_one): ([u32; 3], Triangle),
    (two, at_two): ([u32; 3], Triangle),
) -> Option<Point3<f64>> {
    let is_shared = [0, 1, 2].map(|k| two.contains(&one[k]));
    let points = match is_shared.iter().filter(|shared| **shared).count() {
        0 => [corners_inside(&at_one, [true; 3], &at_two), corners_inside(&at_two, [true; 3], &at_one)].concat(),
        1 => {
            let opposite = |own: [u32; 3], other: [u32; 3]| {
                [0, 1, 2].map(|k| !other.contains(&own[k]) && !other.contains(&own[(k + 1) % 3]))
            };
            let (of_one, of_two) = (opposite(one, two), opposite(two, one));
            [corners_inside(&at_one, of_one, &at_two), corners_inside(&at_two, of_two, &at_one)].concat()
        }
        _ => (0..3).filter(|&k| is_shared[k]).map(|k| at_one[k]).collect(),
    };
    let sum: nalgebra::Vector3<f64> = points.iter().map(|point| point.coords).sum();
    (!points.is_empty()).then(|| Point3::from(sum / points.len() as f64))
}

/// Ends of the common parts of `face` and the edges of `triangle` that are chosen; edge k begins at corner k.
fn corners_inside(triangle: &Triangle, is_chosen: [bool; 3], face: &Triangle) -> Vec<Point3<f64>> {
    let edges = (0..3).filter(|&k| is_chosen[k]).map(|k| (triangle[k], triangle[(k + 1) % 3]));
    edges.flat_map(|(p, q)| segment_points(&p, &q, face)).collect()
}

/// Ends of the common part of the segment p q and a triangle.
fn segment_points(p: &Point3<f64>, q: &Point3<f64>, face: &Triangle) -> Vec<Point3<f64>> {
    let (side_p, side_q) = (side(face, p), side(face, q));
    if !segment_meets(p, q, side_p, side_q, face) {
        return Vec::new();
    }
    match side_p == 0.0 && side_q == 0.0 {
        true => coplanar_points(p, q, face),
        false => vec![between(p, q, side_p, side_q)],
    }
}

/// Ends inside the triangle, and crossings with its edges, of a segment in its plane.
fn coplanar_points(p: &Point3<f64>, q: &Point3<f64>, face: &Triangle) -> Vec<Point3<f64>> {
    let flat_face = |axis: usize| face.map(|point| flatten(&point, axis));
    let has_area = |axis: &usize| {
        let [a, b, c] = flat_face(*axis);
        orient2d(a, b, c) != 0.0
    };
    let Some(axis) = (0..3).find(has_area) else { return Vec::new() };
    let corners = flat_face(axis);
    let (flat_p, flat_q) = (flatten(p, axis), flatten(q, axis));
    let ends = [(p, flat_p), (q, flat_q)].into_iter().filter(|(_, flat)| inside_flat(*flat, corners));
    let mut points: Vec<Point3<f64>> = ends.map(|(end, _)| *end).collect();
    for (u, v) in [0, 1, 2].map(|k| (corners[k], corners[(k + 1) % 3])) {
        let [at_p, at_q] = [flat_p, flat_q].map(|end| orient2d(u, v, end));
        let [at_u, at_v] = [u, v].map(|end| orient2d(flat_p, flat_q, end));
        if at_p * at_q < 0.0 && at_u * at_v <= 0.0 {
            points.push(between(p, q, at_p, at_q));
        }
    }
    points
}

/// Point of the segment p q at which a height vanishes that is linear along it.
fn between(p: &Point3<f64>, q: &Point3<f64>, at_p: f64, at_q: f64) -> Point3<f64> {
    p + (q - p) * (at_p / (at_p - at_q)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Triangle {
        [a, b, c].map(Point3::from)
    }

    /// Checks the point for all rotations of the corners and both orders.
    fn check(one: ([u32; 3], Triangle), two: ([u32; 3], Triangle), expected: Option<[f64; 3]>) {
        for turns in [[0, 0], [1, 0], [2, 1], [0, 2]] {
            let (mut a, mut b) = (one, two);
            a.0.rotate_left(turns[0]);
            a.1.rotate_left(turns[0]);
            b.0.rotate_left(turns[1]);
            b.1.rotate_left(turns[1]);
            for point in [meeting_point(a, b), meeting_point(b, a)] {
                assert_eq!(point.is_some(), expected.is_some());
                let distance = point.zip(expected).map_or(0.0, |(point, wanted)| (point - Point3::from(wanted)).norm());
                assert!(distance < 1e-15, "{point:?} instead of {expected:?}");
            }
        }
    }

    #[test]
    fn the_point_lies_on_both_triangles() {
        let flat = ([0, 1, 2], triangle([0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
        let apart = |corners: Triangle| ([3, 4, 5], corners);
        // Crosses from (0.5, 0.5) to the long edge.
        let upright = triangle([0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [3.0, 3.0, 0.0]);
        check(flat, apart(upright), Some([0.75, 0.75, 0.0]));
        // Touches with a corner.
        check(flat, apart(triangle([0.5, 0.25, 0.0], [0.5, 0.2, 1.0], [0.2, 0.5, 1.0])), Some([0.5, 0.25, 0.0]));
        // Lies in one plane: the common part is the triangle of (1, 0), (2, 0) and (1, 1), or the whole smaller one.
        check(
            flat,
            apart(triangle([1.0, -3.0, 0.0], [9.0, 0.0, 0.0], [1.0, 3.0, 0.0])),
            Some([4.0 / 3.0, 1.0 / 3.0, 0.0]),
        );
        check(
            flat,
            apart(triangle([0.25, 0.25, 0.0], [0.5, 0.25, 0.0], [0.25, 0.5, 0.0])),
            Some([1.0 / 3.0, 1.0 / 3.0, 0.0]),
        );
        check(flat, apart(triangle([0.5, 0.5, 0.5], [0.5, 0.5, 1.0], [3.0, 3.0, 0.5])), None);
    }

    #[test]
    fn shared_vertices_do_not_hide_the_crossing() {
        let flat = ([0, 1, 2], triangle([0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
        let through = ([0, 3, 4], triangle([0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [0.5, 0.5, -0.5]));
        check(flat, through, Some([0.5, 0.5, 0.0]));
        let folded = ([1, 0, 3], triangle([2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]));
        check(flat, folded, Some([1.0, 0.0, 0.0]));
    }
}
