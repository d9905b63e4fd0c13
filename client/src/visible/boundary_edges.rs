//! Crack faces end where the skin of their fragment ends.
//!
//! Crack faces are cut out of the lattice, whose boundary lies beside the input surface, so their rims stand out of the skin or end
//! below it: hairlines between fragments that have not moved. Each vertex of a rim moves to the nearest vertex of the skin's rim, and
//! edges between them become paths along it.

use super::Faces;
use crate::fragment::FragmentSkin;
use nalgebra::Vector3;
use std::collections::HashMap;

/// The farthest that a rim vertex moves, in mean edge lengths of the rim.
const REACH_EDGES: f32 = 4.0;

/// The longest path that an edge becomes, over the distance between its ends and what these moved.
const PATH_MAX: f32 = 8.0;

/// Number of consecutive rim vertices that move to where the one before them moved, where no vertex of the skin's rim is near.
const UNMATCHED_MAX: usize = 8;

/// A directed edge between welded vertices.
type Edge = [u32; 2];

/// Moves the rim of `cracks` onto that of `skin`, as far as they are near; the rest stays as it is. By vertex of `cracks`, as they are
/// then: whether it lies on the rim of the skin.
pub(super) fn fit(cracks: &mut Faces, skin: &FragmentSkin<'_>) -> Vec<bool> {
    let skin_positions: Vec<[f32; 3]> = skin.vertices.iter().map(|vertex| vertex.position_m).collect();
    // Both surfaces run along their common rim in opposite directions.
    let target = BoundaryEdges::new(&skin_positions, skin.indices, |[from, to]| [to, from]);
    let own = BoundaryEdges::new(&cracks.positions, &cracks.indices, |edge| edge);
    if target.edges.is_empty() || own.edges.is_empty() {
        return vec![false; cracks.positions.len()];
    }
    let moved = own.matched(&target);
    let paths = own.paths(&target, &moved);
    let welded = own.welded;
    for (vertex, first) in welded.iter().enumerate() {
        if let Some(to) = moved.get(first) {
            cracks.positions[vertex] = skin_positions[*to as usize];
        }
    }
    let triangles = std::mem::take(&mut cracks.indices);
    for triangle in triangles.as_chunks::<3>().0 {
        divide(cracks, *triangle, &welded, &paths, &skin_positions);
    }
    let mut fitted: Vec<bool> = welded.iter().map(|first| moved.contains_key(first)).collect();
    fitted.resize(cracks.positions.len(), true);
    fitted
}

/// The edges of a mesh that one triangle has and no other has in the opposite direction.
struct BoundaryEdges<'a> {
    positions: &'a [[f32; 3]],
    /// By vertex: the first one at its position.
    welded: Vec<u32>,
    edges: Vec<Edge>,
    /// By welded vertex of the rim: the vertices that edges lead to from it.
    next: HashMap<u32, Vec<u32>>,
    /// By welded vertex of the rim: the direction of the rim there, of any length.
    directions: HashMap<u32, Vector3<f32>>,
}

impl<'a> BoundaryEdges<'a> {
    fn new(positions: &'a [[f32; 3]], indices: &[u32], turned: impl Fn(Edge) -> Edge) -> Self {
        let welded = welded(positions);
        let corners = indices.as_chunks::<3>().0.iter().map(|triangle| triangle.map(|index| welded[index as usize]));
        let mut counts: HashMap<Edge, i32> = HashMap::new();
        let mut all = Vec::with_capacity(indices.len());
        for [a, b, c] in corners {
            for [from, to] in [[a, b], [b, c], [c, a]].into_iter().filter(|[from, to]| from != to) {
                *counts.entry([from, to]).or_default() += 1;
                *counts.entry([to, from]).or_default() -= 1;
                all.push([from, to]);
            }
        }
        let edges: Vec<Edge> =
            all.into_iter().filter(|edge| counts.get(edge).is_some_and(|count| *count == 1)).map(turned).collect();
        let mut rim = Self { positions, welded, edges, next: HashMap::new(), directions: HashMap::new() };
        for &[from, to] in &rim.edges {
            rim.next.entry(from).or_default().push(to);
            let along = position(positions, to) - position(positions, from);
            *rim.directions.entry(from).or_default() += along;
            *rim.directions.entry(to).or_default() += along;
        }
        rim
    }

    fn length(&self, [from, to]: Edge) -> f32 {
        (position(self.positions, to) - position(self.positions, from)).norm()
    }

    /// By vertex of this rim: the nearest vertex of `target` where that runs in the same direction, unless it is far.
    fn matched(&self, target: &BoundaryEdges<'_>) -> HashMap<u32, u32> {
        let mean = self.edges.iter().map(|edge| self.length(*edge)).sum::<f32>() / self.edges.len() as f32;
        let reach = REACH_EDGES * mean;
        if !(reach.is_finite() && reach > 0.0) {
            return HashMap::new();
        }
        let cell = |at: Vector3<f32>| [0, 1, 2].map(|axis| (at[axis] / reach).floor() as i64);
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for &vertex in target.directions.keys() {
            cells.entry(cell(position(target.positions, vertex))).or_default().push(vertex);
        }
        let nearest = |vertex: u32, direction: &Vector3<f32>| {
            let at = position(self.positions, vertex);
            let [x, y, z] = cell(at);
            let around = (0..27).map(|k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
            around
                .filter_map(|key| cells.get(&key))
                .flatten()
                .filter(|other| target.directions[*other].dot(direction) > 0.0)
                .map(|&other| ((position(target.positions, other) - at).norm(), other))
                .filter(|(distance, _)| *distance <= reach)
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        };
        let pair = |(&vertex, direction): (&u32, &Vector3<f32>)| Some((vertex, nearest(vertex, direction)?.1));
        let mut moved: HashMap<u32, u32> = self.directions.iter().filter_map(pair).collect();
        for _ in 0..UNMATCHED_MAX {
            let behind = |&[from, to]: &Edge| Some((to, *moved.get(&from).filter(|_| !moved.contains_key(&to))?));
            let more: Vec<(u32, u32)> = self.edges.iter().filter_map(behind).collect();
            let is_near = |(vertex, other): &(u32, u32)| {
                (position(self.positions, *vertex) - position(target.positions, *other)).norm() <= reach
            };
            moved.extend(more.into_iter().filter(is_near));
        }
        moved
    }

    /// By edge of this rim: the vertices of `target` between those that its ends moved to.
    fn paths(&self, target: &BoundaryEdges<'_>, moved: &HashMap<u32, u32>) -> HashMap<Edge, Vec<u32>> {
        let path = |edge: &Edge| {
            let ends = [*moved.get(&edge[0])?, *moved.get(&edge[1])?];
            let far = |k: usize| (position(self.positions, edge[k]) - position(target.positions, ends[k])).norm();
            let most = PATH_MAX * (self.length(*edge) + far(0) + far(1));
            let (forth, back) = (target.walk(ends, most), target.walk([ends[1], ends[0]], most));
            let back = back.map(|(length, path)| (length, path.into_iter().rev().collect()));
            let (_, path) = [forth, back].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some((*edge, path))
        };
        self.edges.iter().filter_map(path).filter(|(_, path)| !path.is_empty()).collect()
    }

    /// The way between two vertices of this rim along its edges, and the vertices on it, if it is no longer than `most`.
    fn walk(&self, [from, to]: Edge, most: f32) -> Option<(f32, Vec<u32>)> {
        let (mut path, mut length, mut at) = (Vec::new(), 0.0, from);
        while at != to {
            let [next] = self.next.get(&at)?.as_slice() else { return None };
            length += self.length([at, *next]);
            if length > most || path.len() > self.edges.len() {
                return None;
            }
            at = *next;
            path.push(at);
        }
        path.pop();
        Some((length, path))
    }
}

fn position(positions: &[[f32; 3]], vertex: u32) -> Vector3<f32> {
    Vector3::from(positions[vertex as usize])
}

/// By vertex: the first one at its position.
pub(super) fn welded(positions: &[[f32; 3]]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    // Zeros of both signs are one position.
    let key = |position: &[f32; 3]| position.map(|x| (x + 0.0).to_bits());
    (0..).zip(positions).map(|(vertex, position)| *first.entry(key(position)).or_insert(vertex)).collect()
}

/// Appends a triangle of crack faces whose rim edges became paths.
fn divide(
    cracks: &mut Faces,
    triangle: [u32; 3],
    welded: &[u32],
    paths: &HashMap<Edge, Vec<u32>>,
    skin_positions: &[[f32; 3]],
) {
    let mut polygon = Vec::with_capacity(8);
    let mut divided = [false; 3];
    for k in 0..3 {
        let ends = [triangle[k], triangle[(k + 1) % 3]];
        polygon.push(ends[0]);
        let Some(path) = paths.get(&ends.map(|vertex| welded[vertex as usize])) else { continue };
        divided[k] = true;
        for (step, vertex) in path.iter().enumerate() {
            let share = (step + 1) as f32 / (path.len() + 1) as f32;
            polygon.push(between(cracks, ends, share, skin_positions[*vertex as usize]));
        }
    }
    // A fan from the corner whose edges are whole, if there is one.
    let apex = (0..3).find(|&k| !divided[k] && !divided[(k + 2) % 3]).map_or(triangle[0], |k| triangle[k]);
    let first = polygon.iter().position(|vertex| *vertex == apex).unwrap_or(0);
    polygon.rotate_left(first);
    for pair in polygon[1..].windows(2) {
        let corners = [polygon[0], pair[0], pair[1]];
        let [a, b, c] = corners.map(|vertex| cracks.positions[vertex as usize]);
        if a != b && b != c && c != a {
            cracks.indices.extend(corners);
        }
    }
}

/// A new vertex at `position` whose normal and texture coordinates are between those of two others.
fn between(cracks: &mut Faces, ends: [u32; 2], share: f32, position: [f32; 3]) -> u32 {
    let [from, to] = ends.map(|vertex| vertex as usize);
    let normal = Vector3::from(cracks.normals[from]).lerp(&Vector3::from(cracks.normals[to]), share);
    let uv = [0, 1].map(|axis| cracks.uvs[from][axis] * (1.0 - share) + cracks.uvs[to][axis] * share);
    cracks.positions.push(position);
    cracks.normals.push(normal.try_normalize(0.0).map_or(cracks.normals[from], Into::into));
    cracks.uvs.push(uv);
    cracks.positions.len() as u32 - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::result::SkinVertex;

    /// A crack face in the plane z = 0: a regular polygon of that many corners and radius, as a fan around its center.
    fn disc(corners: u32, radius: f32) -> Faces {
        let corner = |k: u32| {
            let angle = k as f32 * std::f32::consts::TAU / corners as f32;
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        };
        let positions: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain((0..corners).map(corner)).collect();
        let count = positions.len();
        let indices = (0..corners).flat_map(|k| [0, 1 + k, 1 + (k + 1) % corners]).collect();
        Faces { positions, normals: vec![[0.0, 0.0, 1.0]; count], uvs: vec![[0.0; 2]; count], indices }
    }

    /// A skin around the face: a cone below it, whose rim has that many corners.
    fn cone(corners: u32, radius: f32) -> (Vec<SkinVertex>, Vec<u32>) {
        let rim = disc(corners, radius);
        let position = |vertex: usize| if vertex == 0 { [0.0, 0.0, -2.0] } else { rim.positions[vertex] };
        let vertex = |vertex| SkinVertex { position_m: position(vertex), normal: [0.0, 0.0, -1.0], uv: [0.0; 2] };
        let indices = rim.indices.as_chunks::<3>().0.iter().flat_map(|&[a, b, c]| [a, c, b]).collect();
        ((0..rim.positions.len()).map(vertex).collect(), indices)
    }

    /// Half-edges without an opposite, of face and skin together.
    fn open(cracks: &Faces, vertices: &[SkinVertex], indices: &[u32]) -> usize {
        let first = cracks.positions.len() as u32;
        let positions: Vec<[f32; 3]> =
            cracks.positions.iter().copied().chain(vertices.iter().map(|vertex| vertex.position_m)).collect();
        let all: Vec<u32> = cracks.indices.iter().copied().chain(indices.iter().map(|index| index + first)).collect();
        BoundaryEdges::new(&positions, &all, |edge| edge).edges.len()
    }

    #[test]
    fn faces_end_at_the_skin_boundary() {
        for (own, other, radius) in [(12, 12, 1.1), (12, 31, 0.9), (31, 12, 1.1), (24, 25, 1.0), (7, 200, 1.1)] {
            let (vertices, indices) = cone(other, radius);
            let skin = FragmentSkin { vertices: &vertices, indices: &indices, materials: &[], uvs2: &[], colors: &[] };
            let mut cracks = disc(own, 1.0);
            assert!(open(&cracks, &vertices, &indices) > 0);
            let fitted = fit(&mut cracks, &skin);
            assert_eq!(open(&cracks, &vertices, &indices), 0, "{own} corners on {other}");
            assert_eq!((fitted.len(), fitted[0]), (cracks.positions.len(), false));
            assert!(fitted[1..].iter().all(|fitted| *fitted));
            assert_eq!((cracks.normals.len(), cracks.uvs.len()), (fitted.len(), fitted.len()));
        }
    }

    #[test]
    fn faces_far_from_the_skin_do_not_move() {
        let (vertices, indices) = cone(12, 20.0);
        let skin = FragmentSkin { vertices: &vertices, indices: &indices, materials: &[], uvs2: &[], colors: &[] };
        let mut cracks = disc(12, 1.0);
        let fitted = fit(&mut cracks, &skin);
        assert_eq!((cracks, fitted), (disc(12, 1.0), vec![false; 13]));
    }
}
