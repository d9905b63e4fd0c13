//! Whether the solids behind two triangles share space: they overlap, or touch along a face.

use super::intersect::{Triangle, side};
use nalgebra::{Point2, Point3, Vector3};

/// Heights over a plane that count as none, local: coordinates are rounded.
const FLAT: f64 = 1e-9;

/// Smallest common area that counts, over that of the smaller triangle.
const SHARE_MIN: f64 = 1e-6;

/// Returns true if the solids behind two triangles of different shells share space there. An edge or a corner that touches is not
/// enough.
///
/// Faces in one plane do if they have a common area: the solids touch there, or lie on the same side. Other faces do if an
/// edge of one passes through the inside of the other.
pub(super) fn share_space(one: &Triangle, two: &Triangle) -> bool {
    let [heights_one, heights_two] = [heights(two, one), heights(one, two)];
    if heights_one.iter().chain(&heights_two).all(|height| height.abs() <= FLAT) {
        return common_area(one, two) > SHARE_MIN * normal(one).norm().min(normal(two).norm()) * 0.5;
    }
    pierces(one, &heights_one, two) || pierces(two, &heights_two, one)
}

/// Twice the area, along the normal.
fn normal([a, b, c]: &Triangle) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Heights of the corners of `triangle` over the plane of `base`; the sign tells the side.
fn heights(base: &Triangle, triangle: &Triangle) -> [f64; 3] {
    let size = normal(base).norm();
    triangle.map(|corner| side(base, &corner) / size)
}

/// Returns true if an edge of `triangle`, whose corners have these heights over `face`, passes through its inside.
fn pierces(triangle: &Triangle, heights: &[f64; 3], face: &Triangle) -> bool {
    (0..3).any(|k| {
        let (from, to) = (k, (k + 1) % 3);
        let crosses = heights[from].min(heights[to]) < -FLAT && heights[from].max(heights[to]) > FLAT;
        let turns = || [0, 1, 2].map(|k| side(&[triangle[from], triangle[to], face[k]], &face[(k + 1) % 3]));
        crosses && {
            let turns = turns();
            turns.iter().all(|turn| *turn > 0.0) || turns.iter().all(|turn| *turn < 0.0)
        }
    })
}

/// Area that two triangles in one plane have in common.
fn common_area(one: &Triangle, two: &Triangle) -> f64 {
    let normal = normal(one);
    let axis = normal.iamax();
    let flat = |point: &Point3<f64>| Point2::new(point[(axis + 1) % 3], point[(axis + 2) % 3]);
    let turn = |a: Point2<f64>, b: Point2<f64>, p: Point2<f64>| (b - a).perp(&(p - a));
    let clip = one.each_ref().map(flat);
    let sign = turn(clip[0], clip[1], clip[2]).signum();
    let mut polygon = two.each_ref().map(flat).to_vec();
    for k in 0..3 {
        let inside = |p: Point2<f64>| sign * turn(clip[k], clip[(k + 1) % 3], p);
        let mut kept = Vec::new();
        for (place, &from) in polygon.iter().enumerate() {
            let to = polygon[(place + 1) % polygon.len()];
            let (at_from, at_to) = (inside(from), inside(to));
            if at_from >= 0.0 {
                kept.push(from);
            }
            if (at_from < 0.0) != (at_to < 0.0) {
                kept.push(from + (to - from) * (at_from / (at_from - at_to)));
            }
        }
        polygon = kept;
    }
    let Some(&first) = polygon.first() else { return 0.0 };
    let twice: f64 = polygon.windows(2).map(|edge| turn(first, edge[0], edge[1])).sum();
    0.5 * twice.abs() * normal.norm() / normal[axis].abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(one: [[f64; 3]; 3], two: [[f64; 3]; 3], expected: bool) {
        let [one, mut two] = [one, two].map(|corners| corners.map(Point3::from));
        for _ in 0..3 {
            two.rotate_left(1);
            assert_eq!(share_space(&one, &two), expected, "{one:?} {two:?}");
            assert_eq!(share_space(&two, &one), expected);
            let mut turned = two;
            turned.swap(0, 1);
            assert_eq!(share_space(&one, &turned), expected);
        }
    }

    #[test]
    fn only_areas_and_crossings_share_space() {
        let flat = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        check(flat, [[0.5, 0.5, 0.0], [3.0, 0.5, 0.0], [0.5, 3.0, 0.0]], true);
        check(flat, flat, true);
        // Rounded, or moved by more than rounding.
        check(flat, [[0.5, 0.5, 1e-12], [3.0, 0.5, 0.0], [0.5, 3.0, 0.0]], true);
        check(flat, [[0.5, 0.5, 1e-6], [3.0, 0.5, 1e-6], [0.5, 3.0, 1e-6]], false);
        // Along an edge, and in a corner.
        check(flat, [[0.5, 0.0, 0.0], [1.5, 0.0, 0.0], [1.0, -1.0, 0.0]], false);
        check(flat, [[2.0, 0.0, 0.0], [3.0, 1.0, 0.0], [3.0, -1.0, 0.0]], false);
        // Upright: through the inside, on the plane, on an edge.
        check(flat, [[0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [3.0, 3.0, 0.5]], true);
        check(flat, [[0.5, 0.5, 0.0], [0.6, 0.5, 0.0], [0.5, 0.5, 1.0]], false);
        check(flat, [[0.5, 0.0, -1.0], [0.5, 0.0, 1.0], [0.5, -1.0, 0.5]], false);
    }
}
