//! Intersecting pairs of triangles.
//!
//! Based on: P. Guigue, O. Devillers, *Fast and robust triangle-triangle overlap test using orientation predicates*
//! (2003), in the simpler form of edge against triangle. Signs by J. R. Shewchuk, *Adaptive precision floating-point
//! arithmetic and fast robust geometric predicates* (1997), through `robust`.

use super::super::tree::{BoundingBox, TriangleTree};
use super::clean::is_flat;
use super::shared_space::share_space;
use nalgebra::Point3;
use rayon::prelude::*;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Triangles tested per parallel batch.
const BATCH: usize = 1024;
/// Pairs with overlapping boxes after which the search stops. Many triangles in one place would take quadratic time.
const PAIRS_MAX: u64 = 100_000_000;

/// Result of the search for intersecting pairs.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Crossings {
    /// Number of intersecting pairs.
    pub count: u64,
    /// Lowest triangle of all pairs.
    pub first: Option<u32>,
    /// True if the search tested all pairs.
    pub complete: bool,
    /// Pairs of shells that overlap or touch along a face, lower index first, sorted.
    pub joined: Vec<[u32; 2]>,
}

/// Intersecting pairs of triangles that share no vertex. Triangles without area are skipped; touching counts.
///
/// `shell_of` is the shell of each triangle.
pub(super) fn intersections(positions: &[Point3<f64>], triangles: &[[u32; 3]], shell_of: &[u32]) -> Crossings {
    let solid: Vec<u32> =
        (0..triangles.len() as u32).filter(|&t| !is_flat(positions, &triangles[t as usize])).collect();
    let corners = |&t: &u32| triangles[t as usize].map(|vertex| positions[vertex as usize]);
    let tree = TriangleTree::new(&solid.iter().map(corners).collect::<Vec<_>>());
    let original = |place: usize| solid[tree.order[place] as usize];
    let search = |place: usize| {
        let own = &triangles[original(place) as usize];
        let (mut pairs, mut count, mut first, mut joined) = (0, 0, None, Vec::new());
        tree.overlapping(&BoundingBox::of(&tree.triangles[place]), place + 1, |other| {
            pairs += 1;
            let [a, b] = [place, other].map(|place| shell_of[original(place) as usize]);
            if a != b && share_space(&tree.triangles[place], &tree.triangles[other]) {
                joined.push([a.min(b), a.max(b)]);
            }
            let shares = triangles[original(other) as usize].iter().any(|vertex| own.contains(vertex));
            if !shares && intersect(&tree.triangles[place], &tree.triangles[other]) {
                count += 1;
                first = lower(first, Some(original(place).min(original(other))));
            }
        });
        joined.sort_unstable();
        joined.dedup();
        (pairs, count, first, joined)
    };
    let (mut crossings, mut pairs) = (Crossings { complete: true, ..Crossings::default() }, 0);
    for start in (0..solid.len()).step_by(BATCH) {
        if pairs > PAIRS_MAX {
            crossings.complete = false;
            break;
        }
        let batch: Vec<_> = (start..solid.len().min(start + BATCH)).into_par_iter().map(search).collect();
        for (looked_at, count, first, joined) in batch {
            pairs += looked_at;
            crossings.count += count;
            crossings.first = lower(crossings.first, first);
            crossings.joined.extend(joined);
        }
        crossings.joined.sort_unstable();
        crossings.joined.dedup();
    }
    crossings
}

/// Pairs of one of the `chosen` triangles and any other that meet outside their shared vertices.
///
/// The chosen one comes first; pairs of two chosen ones occur twice. Neighbors across an edge do not count.
pub(crate) fn crossings(positions: &[Point3<f64>], triangles: &[[u32; 3]], chosen: &[u32]) -> Vec<[u32; 2]> {
    let corners = |triangle: u32| triangles[triangle as usize].map(|vertex| positions[vertex as usize]);
    let tree = TriangleTree::new(&(0..triangles.len() as u32).map(corners).collect::<Vec<_>>());
    let search = |&own: &u32| {
        let (own_corners, mut met) = (corners(own), Vec::new());
        tree.overlapping(&BoundingBox::of(&own_corners), 0, |place| {
            let other = tree.order[place];
            let [one, two] = [own, other].map(|triangle| triangles[triangle as usize]);
            if meet((one, own_corners), (two, tree.triangles[place])) {
                met.push([own, other]);
            }
        });
        met
    };
    let found: Vec<Vec<[u32; 2]>> = chosen.par_iter().map(search).collect();
    found.concat()
}

/// Returns true if two triangles have a common point that no shared vertex or edge explains.
///
/// Each is given by its vertices and their positions. If they share one vertex, the edge opposite it in one of them
/// must meet the other triangle. Neighbors across an edge do not count.
pub(crate) fn meet((one, at_one): ([u32; 3], Triangle), (two, at_two): ([u32; 3], Triangle)) -> bool {
    let shared = |k: &usize| two.contains(&one[*k]);
    match (0..3).filter(shared).count() {
        0 => intersect(&at_one, &at_two),
        1 => {
            let opposite = |own: [u32; 3], at: Triangle, other: [u32; 3], face: Triangle| {
                let mut ends = (0..3).filter(|&k| !other.contains(&own[k])).map(|k| at[k]);
                let (Some(p), Some(q)) = (ends.next(), ends.next()) else { return false };
                segment_meets(&p, &q, side(&face, &p), side(&face, &q), &face)
            };
            opposite(one, at_one, two, at_two) || opposite(two, at_two, one, at_one)
        }
        _ => false,
    }
}

fn lower(a: Option<u32>, b: Option<u32>) -> Option<u32> {
    a.into_iter().chain(b).min()
}

/// Corners of a triangle.
pub(super) type Triangle = [Point3<f64>; 3];

/// Returns true if two triangles with areas have a common point; exact.
fn intersect(one: &Triangle, two: &Triangle) -> bool {
    let (above_one, above_two) = (two.map(|p| side(one, &p)), one.map(|p| side(two, &p)));
    if apart(&above_one) || apart(&above_two) {
        return false;
    }
    let crosses = |edge: &Triangle, sides: &[f64; 3], face: &Triangle| {
        (0..3).any(|k| {
            let next = (k + 1) % 3;
            segment_meets(&edge[k], &edge[next], sides[k], sides[next], face)
        })
    };
    crosses(two, &above_one, one) || crosses(one, &above_two, two)
}

/// Side of a triangle's plane on which a point lies, as the sign of its height.
pub(super) fn side([a, b, c]: &Triangle, point: &Point3<f64>) -> f64 {
    orient3d(coord(a), coord(b), coord(c), coord(point))
}

fn coord(point: &Point3<f64>) -> Coord3D<f64> {
    Coord3D { x: point.x, y: point.y, z: point.z }
}

fn apart(sides: &[f64; 3]) -> bool {
    sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
}

/// Returns true if the segment p q meets the triangle. `side_p` and `side_q` are the sides of its ends.
pub(super) fn segment_meets(p: &Point3<f64>, q: &Point3<f64>, side_p: f64, side_q: f64, triangle: &Triangle) -> bool {
    if side_p == 0.0 && side_q == 0.0 {
        return coplanar_segment_meets(p, q, triangle);
    }
    if (side_p > 0.0 && side_q > 0.0) || (side_p < 0.0 && side_q < 0.0) {
        return false;
    }
    let turns = [0, 1, 2].map(|k| side(&[*p, *q, triangle[k]], &triangle[(k + 1) % 3]));
    turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
}

/// Returns true if a segment in the triangle's plane meets the triangle.
///
/// Both are projected along an axis along which the triangle keeps an area.
fn coplanar_segment_meets(p: &Point3<f64>, q: &Point3<f64>, triangle: &Triangle) -> bool {
    for axis in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| flatten(&triangle[k], axis));
        if orient2d(a, b, c) == 0.0 {
            continue;
        }
        let (p, q) = (flatten(p, axis), flatten(q, axis));
        return inside_flat(p, [a, b, c]) || [(a, b), (b, c), (c, a)].iter().any(|&(u, v)| cross_flat(p, q, u, v));
    }
    false
}

/// A point projected along an axis.
pub(super) fn flatten(point: &Point3<f64>, axis: usize) -> Coord<f64> {
    Coord { x: point[(axis + 1) % 3], y: point[(axis + 2) % 3] }
}

/// Returns true if a point in the plane lies in a triangle with an area, or on its edges.
pub(super) fn inside_flat(p: Coord<f64>, [a, b, c]: [Coord<f64>; 3]) -> bool {
    let turns = [orient2d(a, b, p), orient2d(b, c, p), orient2d(c, a, p)];
    turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
}

/// Returns true if two segments in the plane have a common point. Neither may be degenerate.
///
/// Their boxes decide where an end of one lies on the line of the other.
fn cross_flat(p: Coord<f64>, q: Coord<f64>, u: Coord<f64>, v: Coord<f64>) -> bool {
    let opposed = |a: f64, b: f64| !((a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0));
    let overlap = |a: f64, b: f64, c: f64, d: f64| a.min(b) <= c.max(d) && c.min(d) <= a.max(b);
    opposed(orient2d(p, q, u), orient2d(p, q, v))
        && opposed(orient2d(u, v, p), orient2d(u, v, q))
        && overlap(p.x, q.x, u.x, v.x)
        && overlap(p.y, q.y, u.y, v.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Triangle {
        [a, b, c].map(Point3::from)
    }

    fn check(one: Triangle, two: Triangle, expected: bool) {
        for turn_one in 0..3 {
            for turn_two in 0..3 {
                let (mut a, mut b) = (one, two);
                a.rotate_left(turn_one);
                b.rotate_left(turn_two);
                assert_eq!(intersect(&a, &b), expected);
                assert_eq!(intersect(&b, &a), expected);
                a.swap(0, 1);
                assert_eq!(intersect(&a, &b), expected);
            }
        }
    }

    #[test]
    fn a_fan_that_folds_through_itself_crosses() {
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        let triangles = [[0, 1, 2], [0, 3, 4], [0, 2, 3]];
        let met = |three: Point3<f64>| {
            let positions = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), three, at(0.3, 0.3, 0.5)];
            crossings(&positions, &triangles, &[0])
        };
        assert_eq!(met(at(-1.0, 0.2, 0.3)), Vec::<[u32; 2]>::new());
        assert_eq!(met(at(0.4, 0.2, -0.5)), [[0, 1]]);
    }

    #[test]
    fn triangles_meet_or_not() {
        let flat = triangle([0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        check(flat, triangle([0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [3.0, 3.0, 0.5]), true);
        check(flat, triangle([1.5, 1.5, -1.0], [1.5, 1.5, 1.0], [3.0, 3.0, 0.5]), false);
        check(flat, triangle([0.2, 0.2, 1e-300], [0.5, 0.2, 1.0], [0.2, 0.5, 1.0]), false);
        check(flat, triangle([0.2, 0.2, 0.0], [0.5, 0.2, 1.0], [0.2, 0.5, 1.0]), true);
        check(flat, triangle([0.2, 0.2, 0.0], [0.5, 0.2, 0.0], [0.2, 0.5, 0.0]), true);
        check(flat, triangle([3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 1.0, 0.0]), false);
        check(flat, triangle([2.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, -1.0, 0.0]), true);
        check(flat, triangle([-1.0, 0.5, 0.0], [3.0, 0.5, 0.0], [1.0, 0.5, 3.0]), true);
        check(flat, triangle([-1.0, 2.5, 0.0], [3.0, 2.5, 0.0], [1.0, 2.5, 3.0]), false);
    }
}
