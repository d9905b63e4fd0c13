//! Division of triangles with long edges, without a change of the surface.
//!
//! Ours. Every edge that is too long is halved, in all of its triangles, until none is left. Needles are divided first,
//! as strips between their halved edges.

use super::PointAttributes;
use crate::needle;
use crate::surface::Surface;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Largest number of triangles.
pub(crate) const TRIANGLES_MAX: usize = 1 << 21;

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
    triangles: Vec<[RefinedCorner; 3]>,
    longest: f64,
) -> (Vec<Point3<f64>>, Vec<[RefinedCorner; 3]>, Vec<u32>) {
    let mut longest = longest;
    loop {
        let mut refined = RefinedSurface {
            points: surface.positions.clone(),
            sources: (0..triangles.len() as u32).collect(),
            triangles: triangles.clone(),
            middles: HashMap::new(),
            longest,
        };
        if refined.refine(triangles.len().max(TRIANGLES_MAX)) {
            return (refined.points, refined.triangles, refined.sources);
        }
        longest *= 2.0;
    }
}

/// Surface whose edges are halved.
struct RefinedSurface {
    points: Vec<Point3<f64>>,
    triangles: Vec<[RefinedCorner; 3]>,
    sources: Vec<u32>,
    /// Midpoint of each edge that was halved.
    middles: HashMap<[u32; 2], u32>,
    longest: f64,
}

impl RefinedSurface {
    /// Halves edges until none is too long. Returns false if that needs more than `triangles_max` triangles.
    fn refine(&mut self, triangles_max: usize) -> bool {
        for _ in 0..needle::PASSES_MAX {
            let count = self.triangles.len();
            self.divide(|own, triangle, out| own.divide_needle(triangle, out));
            if self.triangles.len() > triangles_max {
                return false;
            }
            if self.triangles.len() == count {
                break;
            }
        }
        loop {
            let halved = self.halve_edges();
            // Every halved edge adds a triangle on each of its sides.
            if halved == 0 || self.triangles.len() + 2 * halved > triangles_max {
                return halved == 0;
            }
            self.divide(|own, triangle, out| own.divide_at_middles(triangle, out));
        }
    }

    /// Replaces each triangle by the parts that `parts` appends.
    fn divide(&mut self, parts: impl Fn(&mut Self, &[RefinedCorner; 3], &mut Vec<[RefinedCorner; 3]>)) {
        let (triangles, sources) = (std::mem::take(&mut self.triangles), std::mem::take(&mut self.sources));
        let (mut finer, mut finer_sources) = (Vec::with_capacity(triangles.len()), Vec::new());
        for (triangle, &source) in triangles.iter().zip(&sources) {
            parts(self, triangle, &mut finer);
            finer_sources.resize(finer.len(), source);
        }
        (self.triangles, self.sources) = (finer, finer_sources);
    }

    /// Adds the midpoints of all edges that are too long. Returns the number of these edges.
    fn halve_edges(&mut self) -> usize {
        let mut halved = HashMap::new();
        for triangle in 0..self.triangles.len() {
            let corners = self.triangles[triangle];
            for k in 0..3 {
                let ends = edge(&corners[k], &corners[(k + 1) % 3]);
                if !halved.contains_key(&ends)
                    && let Some(middle) = self.midpoint(ends)
                {
                    halved.insert(ends, middle);
                }
            }
        }
        halved.len()
    }

    /// Midpoint of an edge that is too long.
    fn midpoint(&mut self, ends: [u32; 2]) -> Option<u32> {
        let [a, b] = ends.map(|point| self.points[point as usize]);
        if (b - a).norm() <= self.longest {
            return None;
        }
        let points = &mut self.points;
        Some(*self.middles.entry(ends).or_insert_with(|| {
            points.push(nalgebra::center(&a, &b));
            points.len() as u32 - 1
        }))
    }

    /// Appends the strip of a needle, or another triangle itself.
    fn divide_needle(&mut self, triangle: &[RefinedCorner; 3], out: &mut Vec<[RefinedCorner; 3]>) {
        let corners = triangle.map(|corner| self.points[corner.point as usize]);
        if !needle::is_needle(&corners, self.longest) {
            out.push(*triangle);
            return;
        }
        let start = needle::longest_edge_start(&corners);
        let [a, b, c] = [0, 1, 2].map(|k| triangle[(start + k) % 3]);
        let (mut outline, mut end) = (Vec::new(), 0);
        for (k, edge) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
            self.divide_edge(edge, &mut outline);
            end = if k == 0 { outline.len() } else { end };
        }
        let points: Vec<Point3<f64>> = outline.iter().map(|corner| self.points[corner.point as usize]).collect();
        out.extend(needle::strip(&points, end).into_iter().map(|part| part.map(|k| outline[k])));
    }

    /// Appends the first corner of an edge to `outline`, and those that divide it until no part is too long.
    fn divide_edge(&mut self, edge_corners: [RefinedCorner; 2], outline: &mut Vec<RefinedCorner>) {
        let mut open = vec![edge_corners];
        while let Some([a, b]) = open.pop() {
            match self.midpoint(edge(&a, &b)) {
                Some(point) => {
                    let middle = between(&a, &b, point);
                    open.extend([[middle, b], [a, middle]]);
                }
                None => outline.push(a),
            }
        }
    }

    /// Appends the parts of a triangle between the midpoints of its edges.
    fn divide_at_middles(&mut self, triangle: &[RefinedCorner; 3], out: &mut Vec<[RefinedCorner; 3]>) {
        divide(triangle, &self.middles, out);
    }
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
