//! The visible surface of a fragment: its skin and its crack faces, in one mesh.

mod boundary_edges;
mod nearby_skin;

use crate::NO_MATERIAL;
use crate::fragment::{Fragment, FragmentSkin, Run};
use nalgebra::Vector3;
use nearby_skin::NearbySkin;
use shatter_export::{RunView, smooth_normals};
use shatter_proto::result::{FragmentSurface, OuterAttributes};

/// Normals and texture coordinates of vertices; empty where the result has none.
#[derive(Default)]
pub(crate) struct Appearance {
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
}

impl Appearance {
    /// Of a fragment's own vertices: the input's attributes outside, and on cracks those of the result, or smooth normals.
    pub fn of(fragment: &Fragment<'_>) -> Self {
        let attributes = fragment.outer_attributes();
        if attributes.is_empty() {
            return Self::default();
        }
        let is_given = |own: &OuterAttributes| own.normal != [0.0; 3];
        let normal = |(own, smooth): (&OuterAttributes, [f32; 3])| if is_given(own) { own.normal } else { smooth };
        let normals = attributes.iter().zip(normals(fragment)).map(normal).collect();
        let cracks = fragment.uvs();
        let uv = |(vertex, own): (usize, &OuterAttributes)| match is_given(own) {
            true => own.uv,
            false => cracks.get(vertex).copied().unwrap_or_default(),
        };
        let uvs: Vec<[f32; 2]> = attributes.iter().enumerate().map(uv).collect();
        Self { normals, uvs: unless_zero(uvs) }
    }
}

/// The normals of the result, or smooth ones.
fn normals(fragment: &Fragment<'_>) -> Vec<[f32; 3]> {
    let own = fragment.normals();
    if own.is_empty() { smooth_normals(fragment.positions(), fragment.indices()) } else { own.to_vec() }
}

/// Texture coordinates; empty if all are zero.
fn unless_zero(uvs: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    if uvs.iter().any(|uv| *uv != [0.0; 2]) { uvs } else { Vec::new() }
}

/// The values of the first of `count` vertices, then `other`; empty without values.
fn extended<T: Clone>(values: &[T], count: usize, other: T) -> Vec<T> {
    let mut all = values.to_vec();
    all.resize(if values.is_empty() { 0 } else { count }, other);
    all
}

/// A mesh whose vertices have normals and texture coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
struct Faces {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

impl Faces {
    /// The crack faces of a fragment.
    fn cracks(fragment: &Fragment<'_>) -> Self {
        let mut faces = Self::default();
        let normals = normals(fragment);
        for run in fragment.runs().filter(|run| run.is_crack) {
            faces.push(&run, &normals, fragment.uvs());
        }
        faces
    }

    /// The crack faces of a fragment, their rims on that of its skin; by vertex, whether it lies there.
    fn fitted(fragment: &Fragment<'_>, skin: &FragmentSkin<'_>) -> (Self, Vec<bool>) {
        let mut faces = Self::cracks(fragment);
        let fitted = match faces.is_valid() {
            true => boundary_edges::fit(&mut faces, skin),
            false => vec![false; faces.positions.len()],
        };
        (faces, fitted)
    }

    /// Appends a run. `normals` and `uvs` are of all the fragment's vertices; zeros stand where they end.
    fn push(&mut self, run: &Run<'_>, normals: &[[f32; 3]], uvs: &[[f32; 2]]) {
        let first = self.positions.len() as u32;
        let own = (run.vertex_first as usize)..run.vertex_first as usize + run.positions.len();
        self.positions.extend_from_slice(run.positions);
        self.normals.extend_from_slice(normals.get(own.clone()).unwrap_or_default());
        self.normals.resize(self.positions.len(), [0.0, 1.0, 0.0]);
        self.uvs.extend_from_slice(uvs.get(own).unwrap_or_default());
        self.uvs.resize(self.positions.len(), [0.0; 2]);
        // An index below the run's first vertex names no vertex here either: the writer refuses it.
        self.indices.extend(run.indices.iter().map(|index| index.wrapping_sub(run.vertex_first).wrapping_add(first)));
    }

    /// Whether every index names a vertex.
    fn is_valid(&self) -> bool {
        self.indices.iter().all(|&index| (index as usize) < self.positions.len())
    }
}

/// The skin of a fragment and its crack faces, whose rims lie on that of the skin.
pub(crate) struct VisibleMesh {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
    pub runs: Vec<RunView>,
    pub merges: Vec<[u32; 2]>,
    /// One per triangle; empty if the skin has no triangles or no materials.
    pub materials: Vec<u32>,
    /// One per vertex, zero on cracks; empty if the input has no second set of texture coordinates.
    pub uvs2: Vec<[f32; 2]>,
    /// One per vertex, white on cracks; empty if the input has no colors.
    pub colors: Vec<[u8; 4]>,
    pub appearance: Appearance,
}

impl VisibleMesh {
    /// The visible surfaces of `fragments`: those of one result that have a skin, be it an empty one. With the lattice's surface,
    /// cracks are fitted to the skins; with the exact one they end on them.
    pub fn all(fragments: &[(Fragment<'_>, FragmentSkin<'_>)], surface: FragmentSurface) -> Vec<Self> {
        if surface == FragmentSurface::Exact {
            return fragments.iter().map(|(own, skin)| Self::new(Faces::cracks(own), skin)).collect();
        }
        let mut cracks: Vec<(Faces, Vec<bool>)> =
            fragments.iter().map(|(own, skin)| Faces::fitted(own, skin)).collect();
        sink(&mut cracks, fragments);
        cracks.into_iter().zip(fragments).map(|((cracks, _), (_, skin))| Self::new(cracks, skin)).collect()
    }

    fn new(cracks: Faces, skin: &FragmentSkin<'_>) -> Self {
        let mut positions: Vec<[f32; 3]> = skin.vertices.iter().map(|vertex| vertex.position_m).collect();
        let mut normals: Vec<[f32; 3]> = skin.vertices.iter().map(|vertex| vertex.normal).collect();
        let mut uvs: Vec<[f32; 2]> = skin.vertices.iter().map(|vertex| vertex.uv).collect();
        let mut indices = skin.indices.to_vec();
        let (first, outer) = (positions.len() as u32, indices.len() as u32);
        positions.extend(cracks.positions);
        normals.extend(cracks.normals);
        uvs.extend(cracks.uvs);
        indices.extend(cracks.indices.iter().map(|index| index.saturating_add(first)));
        let run = |crack, index_first, index_count| RunView { crack, index_first, index_count };
        let runs = vec![run(false, 0, outer), run(true, outer, indices.len() as u32 - outer)];
        let welded = boundary_edges::welded(&positions);
        let merges = (0..).zip(welded).filter(|(vertex, first)| vertex != first).map(|(vertex, first)| [vertex, first]);
        let merges = merges.collect();
        let mut materials = skin.materials.to_vec();
        if !materials.is_empty() {
            materials.resize(indices.len() / 3, NO_MATERIAL);
        }
        let uvs2 = extended(skin.uvs2, positions.len(), [0.0; 2]);
        let colors = extended(skin.colors, positions.len(), [u8::MAX; 4]);
        let appearance = Appearance { normals, uvs: unless_zero(uvs) };
        Self { positions, indices, runs, merges, materials, uvs2, colors, appearance }
    }
}

/// Moves vertices of crack faces that lie outside of all skins to below them, but for those on rims, which are fitted; leaves triangles
/// out that stand above the skins still.
fn sink(cracks: &mut [(Faces, Vec<bool>)], fragments: &[(Fragment<'_>, FragmentSkin<'_>)]) {
    let world = |fragment: &Fragment<'_>, position: [f32; 3]| {
        Vector3::from(fragment.center_m()) + Vector3::from(position).cast::<f64>()
    };
    let triangles = fragments.iter().flat_map(|(fragment, skin)| {
        let corner = move |index: u32| world(fragment, skin.vertices[index as usize].position_m);
        skin.indices.as_chunks::<3>().0.iter().map(move |triangle| triangle.map(corner))
    });
    let vertices = cracks
        .iter()
        .zip(fragments)
        .flat_map(|((faces, _), (fragment, _))| faces.positions.iter().map(move |position| world(fragment, *position)));
    let shell = NearbySkin::new(triangles, vertices, mean_edge_m(cracks));
    for ((faces, near), (fragment, _)) in cracks.iter_mut().zip(fragments) {
        for (position, near) in faces.positions.iter_mut().zip(near.iter_mut()).filter(|(_, fitted)| !**fitted) {
            if let Some(by) = shell.inwards(&world(fragment, *position)) {
                *position = (Vector3::from(*position) + by.cast::<f32>()).into();
                *near = true;
            }
        }
        if faces.is_valid() {
            let stays = |triangle: &[u32; 3]| {
                let corners = triangle.map(|index| world(fragment, faces.positions[index as usize]));
                let deep = triangle.iter().all(|index| !near[*index as usize]);
                deep || !shell.is_outside(&(corners.iter().sum::<Vector3<f64>>() / 3.0))
            };
            let kept: Vec<[u32; 3]> = faces.indices.as_chunks::<3>().0.iter().copied().filter(stays).collect();
            faces.indices = kept.into_flattened();
        }
    }
}

/// Mean edge length of all crack faces, m; not a number without any.
fn mean_edge_m(cracks: &[(Faces, Vec<bool>)]) -> f64 {
    let (mut sum_m, mut count) = (0.0, 0usize);
    for (faces, _) in cracks.iter().filter(|(faces, _)| faces.is_valid()) {
        for triangle in faces.indices.as_chunks::<3>().0 {
            let corners = triangle.map(|index| Vector3::from(faces.positions[index as usize]).cast::<f64>());
            sum_m += (0..3).map(|k| (corners[k] - corners[(k + 1) % 3]).norm()).sum::<f64>();
            count += 3;
        }
    }
    sum_m / count as f64
}
