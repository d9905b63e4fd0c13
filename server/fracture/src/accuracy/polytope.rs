//! Convex polytopes inside one tetrahedron, clipped by planes.
//!
//! Based on: Sutherland & Hodgman, *Reentrant polygon clipping* (Communications of the ACM 17(1), 1974), face by face.
//! The chain of the edges that the faces lose closes the cut. All coordinates are barycentric. In them, functions that
//! are linear on the tetrahedron are sums of four products, and the tetrahedron has volume 1.

use crate::lattice::FACES;
use nalgebra::Vector3;

/// Barycentric coordinates of a point in a tetrahedron.
pub(super) type BarycentricWeights = [f64; 4];

/// Neighbor of a face that no plane made: none.
pub(super) const NO_NEIGHBOR: u32 = u32::MAX;

/// Convex polytope; empty if it has no faces.
#[derive(Clone, Debug, Default)]
pub(super) struct Polytope {
    vertices: Vec<BarycentricWeights>,
    faces: Vec<Face>,
}

/// Face: the site on its other side, and its vertices, counter-clockwise seen from outside.
#[derive(Clone, Debug)]
struct Face {
    other: u32,
    rim: Vec<u32>,
}

impl Polytope {
    /// The whole tetrahedron.
    pub(super) fn whole() -> Self {
        let corner = |k: usize| std::array::from_fn(|axis| f64::from(u8::from(axis == k)));
        Self::spanned([0, 1, 2, 3].map(corner))
    }

    /// Tetrahedron of four points with positive volume.
    pub(super) fn spanned(corners: [BarycentricWeights; 4]) -> Self {
        let face = |rim: [usize; 3]| Face { other: NO_NEIGHBOR, rim: rim.map(|corner| corner as u32).to_vec() };
        Self { vertices: corners.to_vec(), faces: FACES.map(face).to_vec() }
    }

    /// Keeps the part on which a linear function is not positive. `values` holds it at the tetrahedron's corners.
    ///
    /// The new face has `other` on its other side, and so do faces on which the function vanishes.
    pub(super) fn clip(&mut self, values: &[f64; 4], other: u32) {
        let heights: Vec<f64> = self.vertices.iter().map(|weights| at(values, weights)).collect();
        if heights.iter().all(|height| *height <= 0.0) {
            return self.tie(&heights, other);
        }
        if heights.iter().all(|height| *height >= 0.0) {
            self.faces.clear();
            return;
        }
        let mut cuts = Cuts { heights, made: Vec::new() };
        let mut lost = Vec::new();
        for face in &mut self.faces {
            lost.extend(cuts.clip(face, &mut self.vertices));
        }
        self.faces.retain(|face| face.rim.len() >= 3);
        let rim = chain(&lost);
        if rim.len() >= 3 {
            self.faces.push(Face { other, rim });
        }
    }

    /// Marks faces on which two sites tie as borders between them.
    fn tie(&mut self, heights: &[f64], other: u32) {
        let free = self.faces.iter_mut().filter(|face| face.other == NO_NEIGHBOR);
        for face in free.filter(|face| face.rim.iter().all(|&vertex| heights[vertex as usize] == 0.0)) {
            face.other = other;
        }
    }

    /// Volume over that of the tetrahedron.
    pub(super) fn volume(&self) -> f64 {
        let Some(apex) = self.faces.first().and_then(|face| face.rim.first()) else { return 0.0 };
        let apex = point(&self.vertices[*apex as usize]);
        let corner = |vertex: u32| point(&self.vertices[vertex as usize]) - apex;
        let fan = |face: &Face| {
            let first = corner(face.rim[0]);
            face.rim[1..].windows(2).map(|pair| first.dot(&corner(pair[0]).cross(&corner(pair[1])))).sum::<f64>()
        };
        self.faces.iter().map(fan).sum()
    }

    /// Faces with a site on their other side, as fans of triangles.
    pub(super) fn shared(&self) -> impl Iterator<Item = (u32, [BarycentricWeights; 3])> {
        self.faces.iter().filter(|face| face.other != NO_NEIGHBOR).flat_map(|face| {
            let corner = |vertex: u32| self.vertices[vertex as usize];
            face.rim[1..].windows(2).map(move |pair| (face.other, [face.rim[0], pair[0], pair[1]].map(corner)))
        })
    }
}

/// Value of a linear function, given at the corners.
pub(super) fn at(values: &[f64; 4], weights: &BarycentricWeights) -> f64 {
    values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
}

/// Position in coordinates in which the tetrahedron's edge matrix is the identity.
pub(super) fn point(weights: &BarycentricWeights) -> Vector3<f64> {
    Vector3::new(weights[1], weights[2], weights[3])
}

/// Intersections of one plane with edges. Each edge is cut once, also if several faces share it.
struct Cuts {
    /// Height of each vertex over the plane. New vertices lie on the plane and are not looked up.
    heights: Vec<f64>,
    /// Edge, directed away from the kept side, and the vertex on it.
    made: Vec<([u32; 2], u32)>,
}

impl Cuts {
    /// Clips one face. Returns the edge that closes the hole it leaves, if it is cut.
    fn clip(&mut self, face: &mut Face, vertices: &mut Vec<BarycentricWeights>) -> Option<[u32; 2]> {
        let (mut leaves, mut enters) = (None, None);
        let mut rim = Vec::with_capacity(face.rim.len() + 1);
        for (k, &here) in face.rim.iter().enumerate() {
            let there = face.rim[(k + 1) % face.rim.len()];
            let [inside, next] = [here, there].map(|vertex| self.heights[vertex as usize] <= 0.0);
            if inside {
                rim.push(here);
            }
            if inside != next {
                let cut = self.cut(if inside { [here, there] } else { [there, here] }, vertices);
                rim.push(cut);
                *(if inside { &mut leaves } else { &mut enters }) = Some(cut);
            }
        }
        face.rim = rim;
        Some([enters?, leaves?])
    }

    /// Vertex on an edge.
    fn cut(&mut self, edge: [u32; 2], vertices: &mut Vec<BarycentricWeights>) -> u32 {
        if let Some((_, vertex)) = self.made.iter().find(|(known, _)| *known == edge) {
            return *vertex;
        }
        let [low, high] = edge.map(|vertex| self.heights[vertex as usize]);
        let t = low / (low - high);
        let [from, to] = edge.map(|vertex| vertices[vertex as usize]);
        let vertex = vertices.len() as u32;
        vertices.push(std::array::from_fn(|k| from[k] + t * (to[k] - from[k])));
        self.made.push((edge, vertex));
        vertex
    }
}

/// Loop formed by directed edges.
fn chain(edges: &[[u32; 2]]) -> Vec<u32> {
    let mut rim = Vec::with_capacity(edges.len());
    let Some(&[start, mut at]) = edges.first() else { return rim };
    rim.push(start);
    while at != start && rim.len() < edges.len() {
        rim.push(at);
        let Some(next) = edges.iter().find(|edge| edge[0] == at) else { break };
        at = next[1];
    }
    rim
}
