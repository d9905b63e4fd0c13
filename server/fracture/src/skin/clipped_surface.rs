//! Division of the skin among fragments.
//!
//! Based on: Nielson & Franke, *Computing the separating surface for segmented data* (IEEE Visualization 1997), on
//! triangles: one point on every edge between two fragments, and one in every triangle between three. The parts tile a
//! triangle for any positions of these points, so areas add up.

use super::{PointAttributes, Skin, blended};
use crate::memory::held;
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Smallest barycentric weight of a corner at points on edges and in triangles.
const MARGIN: f64 = 0.02;

/// A vertex of a part: a weighted mean of at most three vertices of the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendedVertex {
    /// Indices into [`Skin::vertices`].
    pub of: [u32; 3],
    /// Weights, sum 1.
    pub weights: [f64; 3],
    /// The vertex among them that belongs to the same fragment as the part.
    pub own_vertex: u32,
}

impl BlendedVertex {
    /// Position in `skin`, local, and attributes.
    pub fn of(&self, skin: &Skin) -> (Point3<f64>, PointAttributes) {
        let points = self.of.map(|vertex| skin.points[skin.vertices[vertex as usize] as usize]);
        let own = self.of.map(|vertex| skin.attributes.get(vertex as usize));
        let mean = |of: &dyn Fn(usize) -> Vector3<f64>| (0..3).map(|k| of(k) * self.weights[k]).sum::<Vector3<f64>>();
        let place = points[0] + mean(&|k| points[k] - points[0]);
        let normal = mean(&|k| Vector3::from(own[k].normal).cast()).try_normalize(0.0);
        let normal = normal.map_or(own[0].normal, |normal| normal.map(|x| x as f32).into());
        (place, PointAttributes { normal, ..blended(own, self.weights) })
    }

    /// The given vertex of the skin.
    fn alone(vertex: u32) -> Self {
        Self { of: [vertex; 3], weights: [1.0, 0.0, 0.0], own_vertex: vertex }
    }
}

/// The part of the skin that belongs to one fragment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClippedSurface {
    /// Vertices, without duplicates.
    pub vertices: Vec<BlendedVertex>,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Triangle of the skin that contains each triangle.
    pub sources: Vec<u32>,
}

impl ClippedSurface {
    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { vertices, triangles, sources } = self;
        held(vertices) + held(triangles) + held(sources)
    }
}

/// Cuts `skin` into one part per fragment. `labels` has one entry per point, below `fragments`.
///
/// `rival(point, a, b)` is negative where the point belongs to a rather than b, and linear along an edge. It is NaN
/// where it is undefined.
pub fn clip(
    skin: &Skin,
    labels: &[u32],
    fragments: usize,
    rival: impl Fn(u32, u32, u32) -> f64,
) -> Vec<ClippedSurface> {
    let mut cutter = Cutter {
        skin,
        labels,
        rival,
        parts: vec![ClippedSurface::default(); fragments],
        own: vec![NONE; skin.vertices.len()],
        cuts: HashMap::new(),
    };
    for triangle in 0..skin.triangles.len() {
        cutter.cut(triangle);
    }
    cutter.parts
}

/// Marks a vertex without an index.
const NONE: u32 = u32::MAX;

/// Cuts triangles into parts. A vertex of the skin has an index in one part, a point on an edge in two.
struct Cutter<'a, F> {
    skin: &'a Skin,
    labels: &'a [u32],
    rival: F,
    parts: Vec<ClippedSurface>,
    /// Index in its part of each vertex of the skin.
    own: Vec<u32>,
    /// Indices of an edge's point in the parts of its two vertices. The vertex of the lower point comes first.
    cuts: HashMap<[u32; 2], [u32; 2]>,
}

impl<F: Fn(u32, u32, u32) -> f64> Cutter<'_, F> {
    fn cut(&mut self, triangle: usize) {
        let corners = self.skin.triangles[triangle];
        let labels = corners.map(|vertex| self.label(vertex));
        let alike = [0, 1, 2].map(|k| labels[k] == labels[(k + 1) % 3]);
        match alike {
            [true, true, _] => {
                let own = corners.map(|vertex| self.corner(vertex));
                self.put(labels[0], triangle, [own]);
            }
            [false, false, false] => self.cut_in_three(triangle, corners, labels),
            _ => {
                // Rotated so that the corner with its own label comes first.
                let lone = (0..3).find(|&k| alike[(k + 1) % 3]).unwrap_or(0);
                let [a, b, c] = [0, 1, 2].map(|k| corners[(lone + k) % 3]);
                let (ab, ca) = (self.between(a, b), self.between(a, c));
                let tip = [self.corner(a), ab[0], ca[0]];
                let base = [[ab[1], self.corner(b), self.corner(c)], [ab[1], self.corner(c), ca[1]]];
                self.put(self.label(a), triangle, [tip]);
                self.put(self.label(b), triangle, base);
            }
        }
    }

    fn cut_in_three(&mut self, triangle: usize, corners: [u32; 3], labels: [u32; 3]) {
        let weights = self.triple(corners, labels);
        let middles =
            [0, 1, 2].map(|k| self.push(labels[k], BlendedVertex { of: corners, weights, own_vertex: corners[k] }));
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
            let (ab, ac, own) = (self.between(a, b)[0], self.between(a, c)[0], self.corner(a));
            self.put(labels[k], triangle, [[own, ab, middles[k]], [own, middles[k], ac]]);
        }
    }

    fn label(&self, vertex: u32) -> u32 {
        self.labels[self.point(vertex) as usize]
    }

    fn point(&self, vertex: u32) -> u32 {
        self.skin.vertices[vertex as usize]
    }

    fn put<const N: usize>(&mut self, label: u32, source: usize, triangles: [[u32; 3]; N]) {
        let part = &mut self.parts[label as usize];
        part.triangles.extend(triangles);
        part.sources.extend([source as u32; N]);
    }

    fn push(&mut self, label: u32, vertex: BlendedVertex) -> u32 {
        let part = &mut self.parts[label as usize];
        part.vertices.push(vertex);
        part.vertices.len() as u32 - 1
    }

    /// Index of a vertex of the skin in the part of its fragment.
    fn corner(&mut self, vertex: u32) -> u32 {
        if self.own[vertex as usize] == NONE {
            self.own[vertex as usize] = self.push(self.label(vertex), BlendedVertex::alone(vertex));
        }
        self.own[vertex as usize]
    }

    /// Indices of the point between two vertices of different fragments, in the part of `a` and in that of `b`.
    fn between(&mut self, a: u32, b: u32) -> [u32; 2] {
        let swapped = self.point(a) > self.point(b);
        let [low, high] = if swapped { [b, a] } else { [a, b] };
        let sides = match self.cuts.get(&[low, high]) {
            Some(sides) => *sides,
            None => {
                let share = self.share(self.point(low), self.point(high));
                let weights = [1.0 - share, share, 0.0];
                let sides = [low, high].map(|own_vertex| {
                    self.push(self.label(own_vertex), BlendedVertex { of: [low, high, high], weights, own_vertex })
                });
                self.cuts.insert([low, high], sides);
                sides
            }
        };
        if swapped { [sides[1], sides[0]] } else { sides }
    }

    /// Position of the boundary between the fragments of two points, 0 at the first and 1 at the second.
    fn share(&self, low: u32, high: u32) -> f64 {
        let (a, b) = (self.labels[low as usize], self.labels[high as usize]);
        let [from, to] = [low, high].map(|point| (self.rival)(point, a, b));
        let share = from / (from - to);
        if from <= 0.0 && to >= 0.0 && share.is_finite() { share.clamp(MARGIN, 1.0 - MARGIN) } else { 0.5 }
    }

    /// Point where three fragments meet in a triangle, as barycentric weights.
    fn triple(&self, corners: [u32; 3], [a, b, c]: [u32; 3]) -> [f64; 3] {
        let points = corners.map(|vertex| self.point(vertex));
        let against = |other: u32| points.map(|point| (self.rival)(point, a, other));
        let (u, v) = (against(b), against(c));
        // Both differences vanish at the point, so its weights are orthogonal to both rows.
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let sum: f64 = cross.iter().sum();
        let weights = cross.map(|x| x / sum);
        let inside = weights.iter().all(|x| x.is_finite() && *x >= MARGIN);
        if inside { weights } else { [1.0 / 3.0; 3] }
    }
}
