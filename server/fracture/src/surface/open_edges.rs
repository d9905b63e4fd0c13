//! Open edges of crack sheets, and the slots around the sheets.
//!
//! A slot of half width w along a whole sheet would reach w beyond the sheet's end and lengthen the crack by as much.
//! Where a sheet ends inside the body, the slot therefore follows the sheet less a strip of width w along that end.

use super::closest;
use super::tree::TriangleTree;
use super::{CrackSheets, InsideTest};
use crate::triangle::closest_point;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Distance from a sheet, in half widths, up to which the ends of slots are examined.
const REACH: f64 = 2.0;

/// Clearance that marks the end of a sheet.
///
/// A sheet ends at an edge if, one half width away from it, every other triangle is at least
/// this share of a half width away.
const CLEAR: f64 = 0.9;

/// Edges that belong to one triangle only.
#[derive(Clone, Debug, Default)]
pub(super) struct OpenEdges {
    tree: TriangleTree,
    edges: Vec<Edge>,
}

/// Edge of a triangle: its ends, the triangle's unit normal, and the unit direction in its
/// plane away from the triangle.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [Point3<f64>; 2],
    normal: Vector3<f64>,
    outward: Vector3<f64>,
}

impl OpenEdges {
    /// Collects the open edges of `triangles`, whose corners are in lexicographic order.
    pub fn new(triangles: &[[Point3<f64>; 3]]) -> Self {
        // The two ends and the third corner of each edge.
        let edges = |&[a, b, c]: &[Point3<f64>; 3]| [([a, b], c), ([a, c], b), ([b, c], a)];
        let key = |ends: &[Point3<f64>; 2]| ends.map(|end| end.coords.map(f64::to_bits));
        let mut count: HashMap<_, u32> = HashMap::new();
        triangles.iter().flat_map(edges).for_each(|(ends, _)| *count.entry(key(&ends)).or_default() += 1);
        let single = triangles.iter().flat_map(edges).filter(|(ends, _)| count[&key(ends)] == 1);
        let edges: Vec<Edge> = single.filter_map(|(ends, third)| Edge::new(ends, third)).collect();
        let flat: Vec<[Point3<f64>; 3]> = edges.iter().map(|Edge { ends: [a, b], .. }| [*a, *b, *b]).collect();
        Self { tree: TriangleTree::new(&flat), edges }
    }

    /// Nearest edge to a point, and the closest point on it.
    fn nearest(&self, point: &Point3<f64>) -> Option<(&Edge, Point3<f64>)> {
        let edge = self.edges.get(closest::nearest(&self.tree, point).1 as usize)?;
        let [a, b] = edge.ends;
        Some((edge, closest_point(&[a, b, b], point)))
    }
}

impl Edge {
    fn new(ends: [Point3<f64>; 2], third: Point3<f64>) -> Option<Self> {
        let along = ends[1] - ends[0];
        let normal = along.cross(&(third - ends[0])).try_normalize(0.0)?;
        let outward = along.cross(&normal).try_normalize(0.0)?;
        Some(Self { ends, normal, outward })
    }
}

impl CrackSheets {
    /// Depth of a local point inside the slots around the sheets; positive inside, local.
    ///
    /// The slots have half width `half` (local).
    pub fn slot_depth(&self, inside: &InsideTest, point: &Point3<f64>, half: f64) -> f64 {
        let distance = self.distance(point);
        if distance >= REACH * half {
            return half - distance;
        }
        let Some((edge, end)) = self.rim.nearest(point) else { return half - distance };
        // Distance of the point's foot on the sheet from the end of the sheet; 0 beyond the end.
        let foot = ((point - end).norm_squared() - distance * distance).max(0.0).sqrt();
        // An end at the surface leaves the slot open, because the crack is open there.
        let strip = (-inside.signed_distance(&end)).clamp(0.0, half);
        if foot >= strip || !self.ends(edge, &end, half) {
            return half - distance;
        }
        half - distance.hypot(strip - foot)
    }

    /// Returns true if the sheet of `edge` ends at `place`.
    ///
    /// That holds if no triangle is near in any direction: neither a continuation, welded or not, nor another sheet.
    fn ends(&self, edge: &Edge, place: &Point3<f64>, half: f64) -> bool {
        let diagonal = |side: f64| (edge.outward + edge.normal * side).normalize();
        let around = [edge.outward, diagonal(1.0), diagonal(-1.0), edge.normal, -edge.normal];
        around.iter().all(|direction| self.distance(&(place + direction * half)) >= CLEAR * half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{RawMesh, Surface, shapes};

    /// Checks the slot depth at `at`, for half width 0.05 in a cube of side 1.
    fn check(rectangles: &[[[f64; 3]; 4]], at: [f64; 3], depth: f64) {
        let points = rectangles.as_flattened().iter().map(|at| Point3::from(*at)).collect();
        let pair = |k: u32| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]];
        let raw = RawMesh::new(points, (0..rectangles.len() as u32).flat_map(pair).collect());
        let surface = Surface::repair(shapes::cuboid([1.0; 3])).unwrap();
        let inside = InsideTest::new(&surface);
        let scale = surface.frame.diagonal_m;
        let sheets = CrackSheets::new(&raw, &surface.frame).unwrap();
        let found = sheets.slot_depth(&inside, &Point3::from(at.map(|x| x / scale)), 0.05 / scale) * scale;
        assert!((found - depth).abs() < 1e-9, "{found} instead of {depth} at {at:?}");
    }

    /// Rectangle in the plane z = `z` over the given ranges of x and y.
    fn flat(x: [f64; 2], y: [f64; 2], z: f64) -> [[f64; 3]; 4] {
        [[x[0], y[0], z], [x[1], y[0], z], [x[1], y[1], z], [x[0], y[1], z]]
    }

    #[test]
    fn a_slot_ends_where_its_sheet_ends_within_the_body() {
        let half = [flat([-0.6, 0.0], [-0.6, 0.6], 0.0)];
        check(&half, [0.0, 0.0, 0.0], 0.0);
        check(&half, [-0.05, 0.0, 0.0], 0.05);
        check(&half, [-0.02, 0.0, 0.04], 0.05 - 0.03f64.hypot(0.04));
        check(&half, [0.03, 0.0, 0.04], 0.05 - 0.05f64.hypot(0.05));
        check(&half, [-0.2, 0.0, 0.04], 0.01);
        check(&half, [-0.2, 0.0, 0.3], -0.25);
    }

    #[test]
    fn a_slot_is_open_where_its_sheet_ends_at_the_surface() {
        let whole = [flat([-0.5, 0.5], [-0.5, 0.5], 0.0)];
        for at in [[0.49, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.5, 0.01]] {
            check(&whole, at, 0.05 - at[2]);
        }
    }

    #[test]
    fn seams_and_junctions_are_not_open_edges() {
        let (left, right) = (flat([-0.6, 0.0], [-0.6, 0.6], 0.0), flat([0.0, 0.6], [-0.7, 0.5], 0.0));
        check(&[left, right], [0.0, 0.1, 0.02], 0.03);
        let upright = [[0.0, -0.6, -0.6], [0.0, 0.6, -0.6], [0.0, 0.6, 0.6], [0.0, -0.6, 0.6]];
        check(&[left, upright], [0.01, 0.1, 0.02], 0.04);
        check(&[left, upright], [-0.02, 0.1, 0.01], 0.04);
    }
}
