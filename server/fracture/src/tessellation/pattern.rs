//! Crack polygons of a tetrahedron by the set of its cut edges.
//!
//! Based on: Nielson & Franke, *Computing the separating surface for segmented data* (IEEE Visualization 1997), and
//! Bronson, Levine & Whitaker, *Lattice cleaving* (IEEE TVCG 20, 2014). With s_l the sum of the barycentric coordinates
//! over the nodes with label l, the polygons bound the regions {s_l largest}. Connectivity follows from labels only, so
//! no geometry can open a fragment.

use crate::lattice::{EDGES, FACES};

/// First corner code of face points: `FACE_CODE + k` is the point on the face opposite node k. Lower codes are edges.
pub const FACE_CODE: u8 = 6;

/// Corner code of the point inside the tetrahedron.
pub const TET_CODE: u8 = 10;

/// Split of a polygon into triangles.
///
/// With these rules, the part of every label in every tetrahedron is positive for any positions of the points inside
/// their simplices. Other splits of quadrilaterals can invert a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolygonSplit {
    /// A triangle; the last corner repeats the first.
    Triangle,
    /// A quadrilateral, split along either diagonal.
    Either,
    /// A quadrilateral, split from its first to its third corner.
    ///
    /// In tetrahedra with four labels, this diagonal joins the edge point and the inner point. The quadrilateral, seen
    /// from either node of the edge, is star-shaped about both.
    First,
    /// One of two quadrilaterals of a tetrahedron with three labels, which meet in the segment between its two face
    /// points.
    ///
    /// Both diagonals start at the same face point: both join first and third corners, or both join second and fourth.
    Joint,
}

/// A part of the crack between the labels of an edge's two nodes.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    /// Index in [`EDGES`] of an edge between the two labels.
    pub edge: u8,
    /// Corner codes, counter-clockwise seen from the edge's second node; the normal points from the first to the
    /// second.
    pub corners: [u8; 4],
    /// Split into triangles.
    pub split: PolygonSplit,
}

/// The polygons of one pattern.
#[derive(Clone, Copy, Debug)]
pub struct LabelPattern {
    polygons: [Polygon; 6],
    count: usize,
}

impl LabelPattern {
    /// All polygons.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons[..self.count]
    }
}

/// Set of cut edges: bit e is set if edge e of [`EDGES`] joins two labels.
pub fn mask(labels: [u32; 4]) -> u8 {
    let [a, b, c, d] = labels;
    if (a ^ b) | (a ^ c) | (a ^ d) == 0 {
        return 0; // most tetrahedra
    }
    EDGES.iter().enumerate().fold(0, |mask, (edge, &[i, j])| mask | (u8::from(labels[i] != labels[j]) << edge))
}

/// The mask of a tetrahedron with four labels.
pub const ALL_CUT: u8 = 63;

/// Edges of the face opposite each node. A face with all of them cut has three labels.
pub const FACE_MASKS: [u8; 4] = {
    let (mut masks, mut node) = ([0; 4], 0);
    while node < 4 {
        masks[node] = ALL_CUT & !edges_at(node);
        node += 1;
    }
    masks
};

/// The edges at `node`.
const fn edges_at(node: usize) -> u8 {
    let (mut edges, mut edge) = (0, 0);
    while edge < 6 {
        if EDGES[edge][0] == node || EDGES[edge][1] == node {
            edges |= 1 << edge;
        }
        edge += 1;
    }
    edges
}

/// Patterns by [`mask`]. Only the fifteen masks of possible labelings have polygons.
pub static PATTERNS: [LabelPattern; 64] = {
    let mut patterns = [EMPTY; 64];
    let mut mask = 0;
    while mask < 64 {
        patterns[mask] = pattern(mask as u8);
        mask += 1;
    }
    patterns
};

const EMPTY: LabelPattern =
    LabelPattern { polygons: [Polygon { edge: 0, corners: [0; 4], split: PolygonSplit::Triangle }; 6], count: 0 };

const fn edge_between(a: usize, b: usize) -> usize {
    let mut edge = 0;
    while !(EDGES[edge][0] == a && EDGES[edge][1] == b || EDGES[edge][0] == b && EDGES[edge][1] == a) {
        edge += 1;
    }
    edge
}

const fn edge_code(a: usize, b: usize) -> u8 {
    edge_between(a, b) as u8
}

/// The point on the face opposite `node`.
const fn face_code(node: usize) -> u8 {
    FACE_CODE + node as u8
}

/// (c, d) such that (a, b, c, d) is an even permutation of the nodes.
const fn complete(a: usize, b: usize) -> (usize, usize) {
    let face = FACES[a];
    let mut k = 0;
    while face[k] != b {
        k += 1;
    }
    (face[(k + 1) % 3], face[(k + 2) % 3])
}

impl LabelPattern {
    /// Adds a polygon whose normal points from the label of node `from` to that of node `to`.
    const fn with(mut self, from: usize, to: usize, corners: [u8; 4], split: PolygonSplit) -> Self {
        let [p, q, r, s] = corners;
        let corners = match (from < to, split) {
            (true, _) => corners,
            (false, PolygonSplit::Triangle) => [p, r, q, p],
            (false, _) => [p, s, r, q],
        };
        self.polygons[self.count] = Polygon { edge: edge_code(from, to), corners, split };
        self.count += 1;
        self
    }

    const fn triangle(self, from: usize, to: usize, [p, q, r]: [u8; 3]) -> Self {
        self.with(from, to, [p, q, r, p], PolygonSplit::Triangle)
    }
}

const fn pattern(mask: u8) -> LabelPattern {
    match mask.count_ones() {
        3 => one_against_three(mask),
        4 => two_against_two(mask),
        5 => two_and_one_and_one(mask),
        6 => all_different(),
        _ => EMPTY,
    }
}

const fn one_against_three(mask: u8) -> LabelPattern {
    let mut a = 0;
    while a < 4 {
        if mask == edges_at(a) {
            let [b, c, d] = FACES[a];
            return EMPTY.triangle(a, b, [edge_code(a, b), edge_code(a, c), edge_code(a, d)]);
        }
        a += 1;
    }
    EMPTY
}

const fn two_against_two(mask: u8) -> LabelPattern {
    let (a, mut b) = (0, 1);
    while b < 4 {
        let (c, d) = complete(a, b);
        if mask >> edge_between(a, b) & 1 == 0 && mask >> edge_between(c, d) & 1 == 0 {
            let corners = [edge_code(a, c), edge_code(a, d), edge_code(b, d), edge_code(b, c)];
            return EMPTY.with(a, c, corners, PolygonSplit::Either);
        }
        b += 1;
    }
    EMPTY
}

const fn two_and_one_and_one(mask: u8) -> LabelPattern {
    let mut edge = 0;
    while mask >> edge & 1 == 1 {
        edge += 1;
    }
    let [a, b] = EDGES[edge];
    let (c, d) = complete(a, b);
    let (near_a, near_b) = (face_code(b), face_code(a)); // the three-label faces (a, c, d) and (b, c, d)
    EMPTY
        .with(a, c, [near_a, near_b, edge_code(b, c), edge_code(a, c)], PolygonSplit::Joint)
        .with(a, d, [edge_code(b, d), near_b, near_a, edge_code(a, d)], PolygonSplit::Joint)
        .triangle(c, d, [edge_code(c, d), near_a, near_b])
}

const fn all_different() -> LabelPattern {
    let (mut pattern, mut edge) = (EMPTY, 0);
    while edge < 6 {
        let [a, b] = EDGES[edge];
        let (c, d) = complete(a, b);
        pattern = pattern.with(a, b, [edge as u8, face_code(d), TET_CODE, face_code(c)], PolygonSplit::First);
        edge += 1;
    }
    pattern
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    fn corner(code: u8) -> Vector3<f64> {
        let nodes: [Vector3<f64>; 4] = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
        match code {
            TET_CODE => nodes.iter().sum::<Vector3<f64>>() / 4.0,
            FACE_CODE.. => FACES[(code - FACE_CODE) as usize].iter().map(|&k| nodes[k]).sum::<Vector3<f64>>() / 3.0,
            _ => EDGES[code as usize].iter().map(|&k| nodes[k]).sum::<Vector3<f64>>() / 2.0,
        }
    }

    fn labelings() -> impl Iterator<Item = [u32; 4]> {
        (0..256).map(|code| [code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6 & 3])
    }

    #[test]
    fn every_polygon_separates_the_labels_of_its_edge() {
        for labels in labelings() {
            for polygon in PATTERNS[mask(labels) as usize].polygons() {
                let [from, to] = EDGES[polygon.edge as usize];
                assert_ne!(labels[from], labels[to]);
                let [p, q, r, s] = polygon.corners.map(corner);
                let normal = (q - p).cross(&(r - p)) + (r - p).cross(&(s - p));
                for (node, &label) in labels.iter().enumerate() {
                    let place = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()][node];
                    let side = normal.dot(&(place - (p + r) / 2.0));
                    assert!(label != labels[from] || side < 0.0, "{labels:?} {polygon:?}");
                    assert!(label != labels[to] || side > 0.0, "{labels:?} {polygon:?}");
                }
            }
        }
    }

    #[test]
    fn the_polygons_border_each_label_without_gaps() {
        for labels in labelings() {
            let pattern = &PATTERNS[mask(labels) as usize];
            let distinct = (0..4).filter(|&k| !labels[..k].contains(&labels[k])).count();
            assert_eq!(pattern.polygons().is_empty(), distinct == 1);
            // For one label, every half-edge inside the tetrahedron (to its inner point or between two face points) has
            // an opposite. Half-edges on a face of the tetrahedron have none here.
            for own in labels {
                let mut half_edges = Vec::new();
                for polygon in pattern.polygons() {
                    let [from, to] = EDGES[polygon.edge as usize].map(|node| labels[node]);
                    let size = if polygon.split == PolygonSplit::Triangle { 3 } else { 4 };
                    for k in 0..size {
                        let (p, q) = (polygon.corners[k], polygon.corners[(k + 1) % size]);
                        half_edges.extend((from == own).then_some((p, q)));
                        half_edges.extend((to == own).then_some((q, p)));
                    }
                }
                let inside = |p: u8, q: u8| p.max(q) == TET_CODE || p.min(q) >= FACE_CODE;
                for &(p, q) in &half_edges {
                    assert_eq!(half_edges.iter().filter(|&&other| other == (p, q)).count(), 1);
                    assert_eq!(half_edges.contains(&(q, p)), inside(p, q), "{labels:?} {own} {p} {q}");
                }
            }
        }
    }

    #[test]
    fn joint_diagonals_share_a_face_point() {
        for pattern in PATTERNS {
            let quads: Vec<[u8; 4]> =
                pattern.polygons().iter().filter(|p| p.split == PolygonSplit::Joint).map(|p| p.corners).collect();
            assert!(quads.is_empty() || quads.len() == 2);
            for (i, j) in [(0, 2), (1, 3)] {
                let ends: Vec<[u8; 2]> = quads.iter().map(|corners| [corners[i], corners[j]]).collect();
                let of_faces: Vec<u8> = ends.iter().flatten().copied().filter(|&code| code >= FACE_CODE).collect();
                assert!(quads.is_empty() || of_faces.len() == 2 && of_faces[0] == of_faces[1], "{ends:?}");
            }
        }
    }

    #[test]
    fn faces_and_edges_name_the_points_they_should() {
        let center = Point3::from(corner(TET_CODE));
        assert_eq!(center, Point3::new(0.25, 0.25, 0.25));
        for a in 0..4 {
            for b in (0..4).filter(|&b| b != a) {
                let (c, d) = complete(a, b);
                let nodes: [Vector3<f64>; 4] = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
                let [a, b, c, d] = [a, b, c, d].map(|k| nodes[k]);
                assert!((b - a).cross(&(c - a)).dot(&(d - a)) > 0.0);
            }
        }
    }
}
