//! Clipping of triangles and tetrahedra by planes.
//!
//! Based on: Sutherland & Hodgman, *Reentrant polygon clipping* (Communications of the ACM 17(1), 1974), and the
//! division of a prism into three tetrahedra.

use super::{ClosedTriangles, Plane};
use nalgebra::Point3;

/// The surface points of a body within planes: its points inside all planes, and the corners of its clipped triangles.
///
/// Corners of three planes deep inside the body are not included.
pub fn clipped(body: &ClosedTriangles, planes: &[Plane]) -> Vec<Point3<f64>> {
    let inside: Vec<bool> =
        body.points.iter().map(|point| planes.iter().all(|plane| plane.beyond(point) <= 0.0)).collect();
    let kept = body.points.iter().zip(&inside).filter(|(_, inside)| **inside);
    let mut points: Vec<Point3<f64>> = kept.map(|(point, _)| *point).collect();
    let (mut polygon, mut next) = (Vec::new(), Vec::new());
    for triangle in body.triangles.iter().filter(|triangle| triangle.iter().any(|&point| !inside[point as usize])) {
        polygon.clear();
        polygon.extend(triangle.map(|point| body.points[point as usize]));
        for plane in planes {
            cut(&polygon, plane, &mut next);
            std::mem::swap(&mut polygon, &mut next);
        }
        points.extend_from_slice(&polygon);
    }
    points
}

/// Writes the part of a convex polygon inside `plane` to `out`.
fn cut(polygon: &[Point3<f64>], plane: &Plane, out: &mut Vec<Point3<f64>>) {
    out.clear();
    for (k, point) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let (here, there) = (plane.beyond(point), plane.beyond(next));
        if here <= 0.0 {
            out.push(*point);
        }
        if (here <= 0.0) != (there <= 0.0) {
            out.push(crossing([point, next], [here, there]));
        }
    }
}

/// The point where a plane crosses an edge, from the signed distances of its ends.
fn crossing([from, to]: [&Point3<f64>; 2], [here, there]: [f64; 2]) -> Point3<f64> {
    from + (to - from) * (here / (here - there))
}

/// Six times the volume of a tetrahedron, not negative.
fn six_volumes([a, b, c, d]: &[Point3<f64>; 4]) -> f64 {
    (b - a).dot(&(c - a).cross(&(d - a))).abs()
}

/// Six times the volume of the part of a tetrahedron inside the `planes` whose bits are set.
pub(super) fn six_volumes_within(corners: &[Point3<f64>; 4], planes: &[Plane], bits: u64) -> f64 {
    if bits == 0 {
        return six_volumes(corners);
    }
    let (plane, rest) = (&planes[bits.trailing_zeros() as usize], bits & (bits - 1));
    let within = |corners: &[Point3<f64>; 4]| six_volumes_within(corners, planes, rest);
    let mut order = corners.map(|corner| (plane.beyond(&corner), corner));
    let inside = order.iter().filter(|corner| corner.0 <= 0.0).count();
    order.sort_by_key(|corner| corner.0 > 0.0);
    let [a, b, c, d] = order.map(|corner| corner.1);
    let cross = |from: usize, to: usize| crossing([&order[from].1, &order[to].1], [order[from].0, order[to].0]);
    let prism = |low: [Point3<f64>; 3], high: [Point3<f64>; 3]| {
        within(&[low[0], low[1], low[2], high[2]])
            + within(&[low[0], low[1], high[1], high[2]])
            + within(&[low[0], high[0], high[1], high[2]])
    };
    match inside {
        0 => 0.0,
        1 => within(&[a, cross(0, 1), cross(0, 2), cross(0, 3)]),
        2 => prism([a, cross(0, 2), cross(0, 3)], [b, cross(1, 2), cross(1, 3)]),
        3 => prism([a, b, c], [cross(0, 3), cross(1, 3), cross(2, 3)]),
        _ => within(&[a, b, c, d]),
    }
}
