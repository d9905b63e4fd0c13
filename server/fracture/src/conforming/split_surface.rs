//! The surface with its long edges split: the constraints of the mesh.
//!
//! Every vertex lies in a triangle of the input, up to the rounding of its coordinates. The rounded coordinates are final:
//! the triangles between them are the constraints.

use super::input::directed_edges;
use crate::needle;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Passes over the surface in which the longest edges are split.
const SPLIT_PASSES_MAX: usize = 64;
/// Passes over the surface in which edges inside input triangles are flipped.
const FLIP_PASSES_MAX: usize = 32;
/// Least gain of a flip, as the sum of the cotangents of the two angles opposite the edge. Above rounding errors.
const FLIP_GAIN_MIN: f64 = 1e-6;

/// Place of a boundary node on the input surface: a weighted mean of up to three vertices of one triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePlace {
    /// Vertices of the input in ascending order. Those with weight 0 repeat the first.
    pub vertices: [u32; 3],
    /// Weights; they sum to 1.
    pub weights: [f64; 3],
}

impl SurfacePlace {
    /// Place of a vertex of the input.
    fn vertex(vertex: u32) -> Self {
        Self { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// Place between two places of one triangle, at `t` from `self` to `other`.
    fn between(&self, other: &Self, t: f64) -> Self {
        let mut terms: Vec<(u32, f64)> = Vec::with_capacity(6);
        for (place, factor) in [(self, 1.0 - t), (other, t)] {
            for (&vertex, &weight) in place.vertices.iter().zip(&place.weights).filter(|(_, weight)| **weight > 0.0) {
                match terms.iter_mut().find(|(known, _)| *known == vertex) {
                    Some((_, sum)) => *sum += weight * factor,
                    None => terms.push((vertex, weight * factor)),
                }
            }
        }
        terms.sort_unstable_by_key(|&(vertex, _)| vertex);
        let first = terms.first().map_or(0, |&(vertex, _)| vertex);
        let mut place = Self { vertices: [first; 3], weights: [0.0; 3] };
        for (k, (vertex, weight)) in terms.into_iter().take(3).enumerate() {
            (place.vertices[k], place.weights[k]) = (vertex, weight);
        }
        place
    }

    /// Position on the input, rounded.
    fn position(&self, positions: &[Point3<f64>]) -> Point3<f64> {
        let [a, b, c] = self.vertices.map(|vertex| positions[vertex as usize]);
        a + (b - a) * self.weights[1] + (c - a) * self.weights[2]
    }

    /// Distance of a point from this place, which bounds its distance from the edge or triangle.
    fn deviation(&self, positions: &[Point3<f64>], point: &Point3<f64>) -> f64 {
        let [a, b, c] = self.vertices.map(|vertex| positions[vertex as usize]);
        ((point - a) - (b - a) * self.weights[1] - (c - a) * self.weights[2]).norm()
    }
}

/// Surface whose edges may be split. The first vertices are those of the input.
#[derive(Clone, Debug)]
pub(super) struct SplitSurface {
    /// Position of each vertex; final.
    pub positions: Vec<Point3<f64>>,
    /// Place of each vertex on the input.
    pub places: Vec<SurfacePlace>,
    /// Triangles, outward.
    pub triangles: Vec<[u32; 3]>,
    /// Input triangle of each triangle.
    pub sources: Vec<u32>,
    input_count: usize,
    length_max: f64,
}

impl SplitSurface {
    /// Surface without split edges. Its edges should not be longer than `length_max`.
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]], length_max: f64) -> Self {
        Self {
            positions: positions.to_vec(),
            places: (0..positions.len() as u32).map(SurfacePlace::vertex).collect(),
            triangles: triangles.to_vec(),
            sources: (0..triangles.len() as u32).collect(),
            input_count: positions.len(),
            length_max,
        }
    }

    /// Length of an edge.
    pub fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.positions[a as usize] - self.positions[b as usize]).norm()
    }

    /// Splits edges that are too long at their midpoints: those of needles all at once, then the longest of each triangle.
    ///
    /// Returns false if the surface would have more than `vertices_max` vertices.
    pub fn split_long_edges(&mut self, vertices_max: usize) -> bool {
        let mut middles = HashMap::new();
        for _ in 0..needle::PASSES_MAX {
            match self.divide_needles(&mut middles, vertices_max) {
                Some(true) => {}
                Some(false) => break,
                None => return false,
            }
        }
        for _ in 0..SPLIT_PASSES_MAX {
            let mut marked = Vec::new();
            for triangle in &self.triangles {
                let (length, edge) = self.longest_edge(triangle);
                if length > self.length_max {
                    marked.push((edge, 0.5));
                }
            }
            if marked.is_empty() {
                break;
            }
            self.split_edges_at(&marked, &middles);
            if self.positions.len() > vertices_max {
                return false;
            }
        }
        true
    }

    /// Divides needles into strips between the halves of halves of their edges. Adds the middle vertices to `middles`.
    ///
    /// The passes that follow split every other long edge at the same vertices. Returns true if there were needles; none
    /// if the surface would have more than `vertices_max` vertices.
    fn divide_needles(&mut self, middles: &mut HashMap<[u32; 2], u32>, vertices_max: usize) -> Option<bool> {
        let mut any = false;
        for triangle in 0..self.triangles.len() {
            let own = self.triangles[triangle];
            let corners = own.map(|vertex| self.positions[vertex as usize]);
            if !needle::is_needle(&corners, self.length_max) {
                continue;
            }
            let start = needle::longest_edge_start(&corners);
            let [a, b, c] = [0, 1, 2].map(|k| own[(start + k) % 3]);
            let (mut outline, mut end) = (Vec::new(), 0);
            for (k, edge) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                self.divide_edge(edge, middles, &mut outline);
                end = if k == 0 { outline.len() } else { end };
            }
            if self.positions.len() > vertices_max {
                return None;
            }
            if outline.len() == 3 {
                continue;
            }
            any = true;
            let points: Vec<Point3<f64>> = outline.iter().map(|&vertex| self.positions[vertex as usize]).collect();
            let mut parts = needle::strip(&points, end).into_iter().map(|part| part.map(|k| outline[k]));
            self.triangles[triangle] = parts.next()?;
            self.triangles.extend(parts);
            self.sources.resize(self.triangles.len(), self.sources[triangle]);
        }
        Some(any)
    }

    /// Appends the first end of an edge to `outline`, and the vertices that divide it until no part is too long.
    fn divide_edge(&mut self, edge: [u32; 2], middles: &mut HashMap<[u32; 2], u32>, outline: &mut Vec<u32>) {
        let mut open = vec![edge];
        while let Some([a, b]) = open.pop() {
            let is_long = self.length([a, b]) > self.length_max;
            let known = middles.get(&ascending([a, b])).copied();
            match if is_long { known.or_else(|| self.add_vertex(ascending([a, b]), 0.5)) } else { None } {
                Some(middle) => {
                    middles.insert(ascending([a, b]), middle);
                    open.extend([[middle, b], [a, middle]]);
                }
                None => outline.push(a),
            }
        }
    }

    /// Adds a vertex on an edge, at `t` from its first end; none if it would coincide with an end.
    fn add_vertex(&mut self, [a, b]: [u32; 2], t: f64) -> Option<u32> {
        let place = self.places[a as usize].between(&self.places[b as usize], t);
        let position = place.position(&self.positions[..self.input_count]);
        if position == self.positions[a as usize] || position == self.positions[b as usize] {
            return None;
        }
        self.places.push(place);
        self.positions.push(position);
        Some(self.positions.len() as u32 - 1)
    }

    /// Longest edge of a triangle and its length. Of equal edges the one with the lowest vertices.
    pub fn longest_edge(&self, &[a, b, c]: &[u32; 3]) -> (f64, [u32; 2]) {
        let edges = [[a, b], [b, c], [c, a]].map(ascending);
        let [one, two, three] = edges.map(|edge| (self.length(edge), edge));
        let longer = |one: (f64, [u32; 2]), two: (f64, [u32; 2])| {
            if two.0 > one.0 || two.0 == one.0 && two.1 < one.1 { two } else { one }
        };
        longer(longer(one, two), three)
    }

    /// Splits edges, each at a fraction of its length from its lower vertex, together with their triangles.
    ///
    /// Edges that occur twice are split once. Edges whose middle rounds to one of their ends stay.
    pub fn split_edges(&mut self, edges: &[([u32; 2], f64)]) {
        self.split_edges_at(edges, &HashMap::new());
    }

    /// Splits edges like [`Self::split_edges`], those in `known` at these vertices.
    fn split_edges_at(&mut self, edges: &[([u32; 2], f64)], known: &HashMap<[u32; 2], u32>) {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::with_capacity(edges.len());
        for &(edge, t) in edges {
            if !middles.contains_key(&edge)
                && let Some(middle) = known.get(&edge).copied().or_else(|| self.add_vertex(edge, t))
            {
                middles.insert(edge, middle);
            }
        }
        let mut parts = Vec::with_capacity(4);
        for triangle in 0..self.triangles.len() {
            let [a, b, c] = self.triangles[triangle];
            let middle = [[a, b], [b, c], [c, a]].map(|edge| middles.get(&ascending(edge)).copied());
            self.parts([a, b, c], middle, &mut parts);
            let source = self.sources[triangle];
            for (k, part) in parts.drain(..).enumerate() {
                if k == 0 {
                    self.triangles[triangle] = part;
                } else {
                    self.triangles.push(part);
                    self.sources.push(source);
                }
            }
        }
    }

    /// Parts of a triangle whose edges (a, b), (b, c), (c, a) have these middle vertices.
    fn parts(&self, [a, b, c]: [u32; 3], middle: [Option<u32>; 3], parts: &mut Vec<[u32; 3]>) {
        match middle {
            [None, None, None] => parts.push([a, b, c]),
            [Some(m), None, None] => parts.extend([[a, m, c], [m, b, c]]),
            [Some(m), Some(n), None] => {
                parts.push([m, b, n]);
                let (to_a, to_m) = (self.length([a, n]), self.length([m, c]));
                parts.extend(if to_a <= to_m { [[a, m, n], [a, n, c]] } else { [[a, m, c], [m, n, c]] });
            }
            [Some(m), Some(n), Some(o)] => parts.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]),
            _ => self.parts([b, c, a], [middle[1], middle[2], middle[0]], parts),
        }
    }

    /// Flips edges inside input triangles until they are locally Delaunay there. No edge becomes too long.
    pub fn flip_inside_triangles(&mut self) {
        for _ in 0..FLIP_PASSES_MAX {
            let edges = directed_edges(&self.triangles);
            let mut is_changed = vec![false; self.triangles.len()];
            let mut any = false;
            for &([a, b], one) in edges.iter().filter(|([a, b], _)| a < b) {
                let Ok(found) = edges.binary_search_by_key(&[b, a], |(edge, _)| *edge) else { continue };
                let two = edges[found].1;
                let pair = [one, two].map(|triangle| triangle as usize);
                if self.sources[pair[0]] == self.sources[pair[1]]
                    && !pair.iter().any(|&triangle| is_changed[triangle])
                    && let Some(flipped) = self.flipped([a, b], pair)
                {
                    for (triangle, corners) in pair.into_iter().zip(flipped) {
                        self.triangles[triangle] = corners;
                        is_changed[triangle] = true;
                    }
                    any = true;
                }
            }
            if !any {
                break;
            }
        }
    }

    /// The two triangles at the edge (a, b) after a flip, if it makes them locally Delaunay.
    fn flipped(&self, [a, b]: [u32; 2], pair: [usize; 2]) -> Option<[[u32; 3]; 2]> {
        let apex = |triangle: usize| self.triangles[triangle].into_iter().find(|&vertex| vertex != a && vertex != b);
        let [c, d] = [apex(pair[0])?, apex(pair[1])?];
        let at = |vertex: u32| self.positions[vertex as usize];
        let cotangent = |apex: u32| {
            let (to_a, to_b) = (at(a) - at(apex), at(b) - at(apex));
            to_a.dot(&to_b) / to_a.cross(&to_b).norm()
        };
        let normal = |[a, b, c]: [u32; 3]| -> Vector3<f64> { (at(b) - at(a)).cross(&(at(c) - at(a))) };
        let flipped = [[a, d, c], [d, b, c]];
        let total = normal([a, b, c]) + normal([b, a, d]);
        let is_convex = flipped.iter().all(|&corners| normal(corners).dot(&total) > 1e-9 * total.norm_squared());
        let is_short = self.length([c, d]) <= self.length_max;
        (is_convex && is_short && cotangent(c) + cotangent(d) < -FLIP_GAIN_MIN).then_some(flipped)
    }

    /// Largest distance of a vertex from its place on the input.
    pub fn deviation(&self) -> f64 {
        let input = &self.positions[..self.input_count];
        let split = self.places.iter().zip(&self.positions).skip(self.input_count);
        split.map(|(place, position)| place.deviation(input, position)).fold(0.0, f64::max)
    }
}

/// Vertices of an edge in ascending order.
pub(super) fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
