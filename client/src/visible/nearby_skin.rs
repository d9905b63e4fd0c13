//! Crack faces stay inside the skin.
//!
//! The lattice reaches beyond the input surface where that bends sharply, and crack faces with it. Vertices of crack faces that lie
//! outside are moved along the surface's normal to a little below it; triangles that still stand out, across a hollow, are left out.

use nalgebra::Vector3;
use std::collections::{HashMap, HashSet};

/// Largest distance from the surface of the vertices that are examined, in mean edge lengths of the crack faces.
const REACH_EDGES: f64 = 3.0;

/// Smallest depth of vertices below the surface, in the same unit.
const DEPTH_EDGES: f64 = 0.1;

/// Smallest height above the surface of the middle of a triangle that is left out, in the same unit.
const OVER_EDGES: f64 = 0.02;

/// Distances that differ by less than this part are equal: the nearest point lies on an edge of two triangles.
const TIE: f64 = 1e-6;

/// The triangles of all skins that lie near crack faces.
pub(super) struct NearbySkin {
    reach: f64,
    cells: HashMap<[i64; 3], Vec<[Vector3<f64>; 3]>>,
}

impl NearbySkin {
    /// Of `triangles`, those that lie near `points`. `edge_m`: mean edge length of the crack faces.
    pub fn new(
        triangles: impl Iterator<Item = [Vector3<f64>; 3]>,
        points: impl Iterator<Item = Vector3<f64>>,
        edge_m: f64,
    ) -> Self {
        let reach = REACH_EDGES * edge_m;
        let mut shell = Self { reach, cells: HashMap::new() };
        if !(reach.is_finite() && reach > 0.0) {
            return shell;
        }
        let near: HashSet<[i64; 3]> = points.flat_map(|point| around(shell.cell(&point))).collect();
        for triangle in triangles {
            let [low, high] = [Vector3::inf, Vector3::sup]
                .map(|bound| shell.cell(&triangle[1..].iter().fold(triangle[0], |sum, corner| bound(&sum, corner))));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for key in (low[2]..=high[2]).map(|z| [x, y, z]).filter(|key| near.contains(key)) {
                        shell.cells.entry(key).or_default().push(triangle);
                    }
                }
            }
        }
        shell
    }

    fn cell(&self, at: &Vector3<f64>) -> [i64; 3] {
        [0, 1, 2].map(|axis| (at[axis] / self.reach).floor() as i64)
    }

    /// By how much a vertex is to be moved so that it lies below the surface; `None` where it does, or the surface is far.
    pub fn inwards(&self, vertex: &Vector3<f64>) -> Option<Vector3<f64>> {
        let depth = DEPTH_EDGES / REACH_EDGES * self.reach;
        let (height, normal) = self.height(vertex).filter(|(height, _)| *height > -depth)?;
        Some(normal * -(height + depth))
    }

    /// Whether the middle of a triangle lies above the surface.
    pub fn is_outside(&self, middle: &Vector3<f64>) -> bool {
        let over = OVER_EDGES / REACH_EDGES * self.reach;
        self.height(middle).is_some_and(|(height, _)| height > over)
    }

    /// Height of a point above the nearest triangle, and the normal of that; `None` where all are far.
    fn height(&self, point: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let mut best: Option<(f64, f64, Vector3<f64>)> = None;
        let triangles = around(self.cell(point)).filter_map(|key| self.cells.get(&key)).flatten();
        for triangle in triangles {
            let [a, b, c] = triangle;
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
            let away = point - nearest(point, triangle);
            let (distance, height) = (away.norm(), away.dot(&normal));
            let better = best.is_none_or(|(least, own, _)| {
                let tie = (distance - least).abs() <= TIE * least;
                if tie { height.abs() > own.abs() } else { distance < least }
            });
            if distance <= self.reach && better {
                best = Some((distance, height, normal));
            }
        }
        best.map(|(_, height, normal)| (height, normal))
    }
}

/// A cell and those around it.
fn around([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1])
}

/// The point of a triangle that is nearest to `point` (C. Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
fn nearest(point: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab.dot(&(point - a)), ac.dot(&(point - a))];
    let [d3, d4] = [ab.dot(&(point - b)), ac.dot(&(point - b))];
    let [d5, d6] = [ab.dot(&(point - c)), ac.dot(&(point - c))];
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        *a
    } else if d3 >= 0.0 && d4 <= d3 {
        *b
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if d6 >= 0.0 && d5 <= d6 {
        *c
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        let sum = va + vb + vc;
        a + ab * (vb / sum) + ac * (vc / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor at height zero, seen from above.
    fn floor() -> [[Vector3<f64>; 3]; 2] {
        let corner = |x: f64, z: f64| Vector3::new(x, 0.0, z);
        let [a, b, c, d] = [corner(-5.0, -5.0), corner(-5.0, 5.0), corner(5.0, 5.0), corner(5.0, -5.0)];
        [[a, b, c], [a, c, d]]
    }

    #[test]
    fn only_points_outside_the_skin_move_below_it() {
        let vertices = [0.5, 0.0, -0.05, -0.5, 4.0].map(|height| Vector3::new(0.3, height, -0.2));
        let shell = NearbySkin::new(floor().into_iter(), vertices.into_iter(), 1.0);
        let moved = vertices.map(|vertex| shell.inwards(&vertex).map(|by| vertex + by));
        let below = Some(Vector3::new(0.3, -0.1, -0.2));
        let near = |found: Option<Vector3<f64>>, wanted: Option<Vector3<f64>>| match (found, wanted) {
            (Some(found), Some(wanted)) => (found - wanted).norm() < 1e-12,
            (found, wanted) => found == wanted,
        };
        assert_eq!(vertices.map(|vertex| shell.is_outside(&vertex)), [true, false, false, false, false]);
        for (found, wanted) in moved.into_iter().zip([below, below, below, None, None]) {
            assert!(near(found, wanted), "{found:?} instead of {wanted:?}");
        }
    }

    #[test]
    fn degenerate_meshes_move_no_point() {
        for edge_m in [0.0, f64::NAN, f64::INFINITY] {
            let shell = NearbySkin::new(floor().into_iter(), std::iter::once(Vector3::zeros()), edge_m);
            assert!(shell.inwards(&Vector3::zeros()).is_none());
        }
    }

    #[test]
    fn nearest_points_of_a_triangle() {
        let [a, b, c] = [Vector3::zeros(), Vector3::x(), Vector3::y()];
        let cases = [
            (Vector3::new(-1.0, -1.0, 1.0), a),
            (Vector3::new(2.0, -0.5, 0.0), b),
            (Vector3::new(-0.5, 2.0, 0.0), c),
            (Vector3::new(0.25, -1.0, 0.0), Vector3::new(0.25, 0.0, 0.0)),
            (Vector3::new(-1.0, 0.25, 0.0), Vector3::new(0.0, 0.25, 0.0)),
            (Vector3::new(1.0, 1.0, 0.0), Vector3::new(0.5, 0.5, 0.0)),
            (Vector3::new(0.25, 0.25, 3.0), Vector3::new(0.25, 0.25, 0.0)),
        ];
        for (point, wanted) in cases {
            assert!((nearest(&point, &[a, b, c]) - wanted).norm() < 1e-15, "{point:?}");
        }
    }
}
