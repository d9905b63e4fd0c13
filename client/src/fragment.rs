//! Fragments of a result.

use shatter_proto::result::{FragmentVelocity, FragmentWire, OUTER, OuterAttributes, RunWire, SkinVertex};
use shatter_proto::view::ResultView;

/// The fragments of a result, in the order of their ids.
pub(crate) fn fragments(view: ResultView<'_>) -> impl ExactSizeIterator<Item = Fragment<'_>> {
    view.fragments.iter().map(move |row| Fragment { row, view })
}

/// The fragment of that id, if there is one.
pub(crate) fn fragment(view: ResultView<'_>, id: u32) -> Option<Fragment<'_>> {
    view.fragments.get(id as usize).map(|row| Fragment { row, view })
}

/// One fragment, borrowed from shared memory.
#[derive(Clone, Copy)]
pub struct Fragment<'a> {
    row: &'a FragmentWire,
    view: ResultView<'a>,
}

/// Triangles of one fragment that face one neighbor, or the outside, or a fragment of an earlier result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Run<'a> {
    /// The fragment on the other side of the crack; `None`: the outside, or a fragment of an earlier result.
    pub neighbor: Option<u32>,
    /// Whether it is a side of a crack, be it one of an earlier result.
    pub is_crack: bool,
    /// First index of the run, counted from the fragment's first.
    pub index_first: u32,
    /// Corners of the run's triangles; values count from the fragment's first vertex.
    pub indices: &'a [u32],
    /// First vertex of the run, counted from the fragment's first.
    pub vertex_first: u32,
    /// Positions of the run's own vertices, m.
    pub positions: &'a [[f32; 3]],
}

/// The convex proxy of a fragment, for collisions: at most 64 triangles, and fewer vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HullMesh<'a> {
    /// Corners, m, relative to [`Fragment::center_m`].
    pub positions: &'a [[f32; 3]],
    /// Indices into the corners, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    pub indices: &'a [u32],
    /// Volume of the part of the fragment inside the hull over that of the fragment.
    pub coverage: f64,
    /// The deepest that the surface of any other fragment lies below the hull's surface, m.
    pub margin_m: f64,
}

/// The input's own triangles that belong to a fragment, for rendering: with the crack faces of the fragment's runs they are its
/// visible surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FragmentSkin<'a> {
    /// Vertices, relative to [`Fragment::center_m`].
    pub vertices: &'a [SkinVertex],
    /// Indices into the vertices, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    pub indices: &'a [u32],
    /// One per triangle: the index of a material in the mesh file, or [`NO_MATERIAL`](crate::NO_MATERIAL); empty if the file has no
    /// materials.
    pub materials: &'a [u32],
    /// Second texture coordinates, one per vertex, v upwards; empty if the file has none.
    pub uvs2: &'a [[f32; 2]],
    /// Red, green, blue and alpha, one per vertex; empty if the file has no colors.
    pub colors: &'a [[u8; 4]],
}

/// The part of a slice that a table names. Checked when the result came; a part that no longer fits is empty.
fn part<T>(slice: &[T], first: u32, count: u32) -> &[T] {
    let first = first as usize;
    first.checked_add(count as usize).and_then(|end| slice.get(first..end)).unwrap_or(&[])
}

impl<'a> Fragment<'a> {
    /// Its position among the fragments of the result.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.row.id
    }

    /// The body (component of the object) that it comes from.
    #[must_use]
    pub fn body(&self) -> u32 {
        self.row.body
    }

    /// Positions, m, relative to [`Self::center_m`].
    #[must_use]
    pub fn positions(&self) -> &'a [[f32; 3]] {
        part(self.view.positions, self.row.vertex_first, self.row.vertex_count)
    }

    /// Normals, one per position; empty unless `normals` is on.
    #[must_use]
    pub fn normals(&self) -> &'a [[f32; 3]] {
        part(self.view.normals, self.row.vertex_first, self.row.vertex_count)
    }

    /// Texture coordinates, m, one per position; zero on the outside; empty unless `uv` is on.
    #[must_use]
    pub fn uvs(&self) -> &'a [[f32; 2]] {
        part(self.view.uvs, self.row.vertex_first, self.row.vertex_count)
    }

    /// Its velocity once it is free, in addition to the object's motion; `None` unless `release` is on.
    #[must_use]
    pub fn velocity(&self) -> Option<FragmentVelocity> {
        self.view.velocities.get(self.row.id as usize).copied()
    }

    /// Its convex proxy; `None` unless `hulls` is on, and for a fragment too flat for one.
    #[must_use]
    pub fn hull(&self) -> Option<HullMesh<'a>> {
        let row = self.view.hulls.get(self.row.id as usize).filter(|row| row.vertex_count > 0)?;
        let positions = part(self.view.hull_positions, row.vertex_first, row.vertex_count);
        let indices = part(self.view.hull_indices, row.index_first, row.index_count);
        Some(HullMesh { positions, indices, coverage: row.coverage, margin_m: row.margin_m })
    }

    /// The input's normals and texture coordinates on outer faces, one per position, zero on cracks; empty unless `attributes` is on.
    #[must_use]
    pub fn outer_attributes(&self) -> &'a [OuterAttributes] {
        part(self.view.outer_attributes, self.row.vertex_first, self.row.vertex_count)
    }

    /// The input's second texture coordinates (`TEXCOORD_1` of glTF) on outer faces, v upwards, one per position, zero on cracks;
    /// empty unless `attributes` is on and the input has them.
    #[must_use]
    pub fn outer_uvs2(&self) -> &'a [[f32; 2]] {
        part(self.view.outer_uvs2, self.row.vertex_first, self.row.vertex_count)
    }

    /// The input's colors on outer faces, red, green, blue and alpha, one per position, white on cracks; empty unless `attributes` is
    /// on and the input has any. Colors of glTF are linear; those of PLY and OBJ are as in the file.
    #[must_use]
    pub fn outer_colors(&self) -> &'a [[u8; 4]] {
        part(self.view.outer_colors, self.row.vertex_first, self.row.vertex_count)
    }

    /// The input's materials, one per triangle, [`NO_MATERIAL`](crate::NO_MATERIAL) on cracks; empty unless
    /// `attributes` is on and the input has any.
    #[must_use]
    pub fn materials(&self) -> &'a [u32] {
        part(self.view.materials, self.row.index_first / 3, self.row.index_count / 3)
    }

    /// Its part of the input's surface; `None` unless `skin` is on.
    #[must_use]
    pub fn skin(&self) -> Option<FragmentSkin<'a>> {
        let row = self.view.skins.get(self.row.id as usize)?;
        Some(FragmentSkin {
            vertices: part(self.view.skin_vertices, row.vertex_first, row.vertex_count),
            indices: part(self.view.skin_indices, row.index_first, row.index_count),
            materials: part(self.view.skin_materials, row.index_first / 3, row.index_count / 3),
            uvs2: part(self.view.skin_uvs2, row.vertex_first, row.vertex_count),
            colors: part(self.view.skin_colors, row.vertex_first, row.vertex_count),
        })
    }

    /// Indices into [`Self::positions`], three per triangle, counter-clockwise from outside unless the convention is clockwise.
    #[must_use]
    pub fn indices(&self) -> &'a [u32] {
        part(self.view.indices, self.row.index_first, self.row.index_count)
    }

    /// Pairs (from, to) of vertices that are the same point.
    #[must_use]
    pub fn merges(&self) -> &'a [[u32; 2]] {
        part(self.view.merges, self.row.merge_first, self.row.merge_count)
    }

    /// The runs: the outer one first, if there is one, then one per neighbor, then those on cracks of earlier results.
    pub fn runs(&self) -> impl ExactSizeIterator<Item = Run<'a>> {
        let (view, fragment) = (self.view, self.row);
        let rows: &'a [RunWire] = part(view.runs, fragment.run_first, fragment.run_count);
        rows.iter().map(move |run| Run {
            neighbor: (run.neighbor != OUTER).then_some(run.neighbor),
            is_crack: run.material != 0,
            index_first: run.index_first.saturating_sub(fragment.index_first),
            indices: part(view.indices, run.index_first, run.index_count),
            vertex_first: run.vertex_first.saturating_sub(fragment.vertex_first),
            positions: part(view.positions, run.vertex_first, run.vertex_count),
        })
    }

    /// Volume, m³.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        self.row.volume_m3
    }

    /// Mass, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.row.mass_kg
    }

    /// Center of mass in the coordinates of the object, m.
    #[must_use]
    pub fn center_m(&self) -> [f64; 3] {
        self.row.center_m
    }

    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    #[must_use]
    pub fn inertia_kg_m2(&self) -> [f64; 6] {
        self.row.inertia_kg_m2
    }

    /// Distance-weighted strain energy of the cell that it belongs to, J·m².
    #[must_use]
    pub fn energy_j_m2(&self) -> f64 {
        self.row.energy_j_m2
    }

    /// Whether its surface is closed and oriented: after welding bitwise equal positions, every edge has exactly two
    /// opposite half-edges.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        is_closed(self.positions(), self.indices())
    }
}

/// See [`Fragment::is_closed`]; the merge pairs are not consulted.
fn is_closed(positions: &[[f32; 3]], indices: &[u32]) -> bool {
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    let key = |vertex: &u32| positions[*vertex as usize].map(f32::to_bits);
    order.sort_unstable_by_key(key);
    let mut welded = vec![0u32; positions.len()];
    for same in order.chunk_by(|a, b| key(a) == key(b)) {
        for vertex in same {
            welded[*vertex as usize] = same[0];
        }
    }
    let mut edges = Vec::with_capacity(indices.len());
    for triangle in indices.chunks_exact(3) {
        let Some(corners) = corners(triangle, &welded) else { return false };
        for k in 0..3 {
            edges.push((corners[k], corners[(k + 1) % 3]));
        }
    }
    edges.sort_unstable();
    let unique = edges.windows(2).all(|pair| pair[0] != pair[1]);
    let paired = |&(a, b): &(u32, u32)| a != b && edges.binary_search(&(b, a)).is_ok();
    !indices.is_empty() && indices.len().is_multiple_of(3) && unique && edges.iter().all(paired)
}

fn corners(triangle: &[u32], welded: &[u32]) -> Option<[u32; 3]> {
    let corner = |k: usize| welded.get(triangle[k] as usize).copied();
    Some([corner(0)?, corner(1)?, corner(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const FACES: [u32; 12] = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];

    #[test]
    fn a_tetrahedron_is_closed_shared_or_split() {
        assert!(is_closed(&CORNERS, &FACES));
        let split: Vec<[f32; 3]> = FACES.iter().map(|corner| CORNERS[*corner as usize]).collect();
        let indices: Vec<u32> = (0..12).collect();
        assert!(is_closed(&split, &indices));
    }

    #[test]
    fn holes_flips_duplicates_and_empty_meshes_are_not_closed() {
        assert!(!is_closed(&CORNERS, &FACES[3..]));
        let mut flipped = FACES;
        flipped.swap(0, 1);
        assert!(!is_closed(&CORNERS, &flipped));
        assert!(!is_closed(&CORNERS, &[FACES, FACES].concat()));
        assert!(!is_closed(&CORNERS, &[]));
        assert!(!is_closed(&CORNERS, &[0, 1, 9]));
        let mut moved = FACES.map(|corner| CORNERS[corner as usize]);
        moved[0][0] += f32::EPSILON;
        assert!(!is_closed(&moved, &(0..12).collect::<Vec<u32>>()));
    }

    #[test]
    fn inconsistent_sections_are_empty() {
        assert_eq!(part(&[1, 2, 3], 1, 2), [2, 3]);
        assert!(part(&[1, 2, 3], 2, 2).is_empty() && part(&[1], u32::MAX, u32::MAX).is_empty());
    }
}
