//! Geometry of one fragment for MuJoCo: visible meshes by material, and a shape for collisions.

use super::z_up;
use crate::obj::{Part, Vertices, mesh};
use crate::{FragmentView, HullView, check, principal, smooth_normals};

/// Smallest number of vertices of a mesh; MuJoCo refuses fewer.
const VERTICES_MIN: usize = 4;

/// Smallest area of a mesh, m²; MuJoCo refuses less.
const AREA_MIN_M2: f64 = 1e-12;

/// Smallest thickness over width of a fragment with a convex hull; flatter ones get a box.
const FLATNESS_MIN: f64 = 1e-5;

/// Smallest half side of a box, m.
const HALF_MIN_M: f64 = 1e-6;

/// Shape for collisions.
pub(super) enum Solid {
    /// Convex hull of a mesh, by the name of the mesh.
    Mesh(String),
    /// Box for a fragment too flat for a hull: center and half sides, m.
    Box([f64; 3], [f64; 3]),
}

/// Geometry of one fragment.
pub(super) struct Shape {
    /// Names and texts of its mesh files.
    pub files: Vec<(String, String)>,
    /// Visible meshes: class of the geometry and name of the mesh.
    pub seen: Vec<(&'static str, String)>,
    /// Shape for collisions.
    pub solid: Solid,
}

/// Geometry of the fragment with the name `name`; `hull` is `None` if the result has no hulls.
pub(super) fn shape(name: &str, fragment: &FragmentView<'_>, hull: Option<&Option<HullView<'_>>>) -> Shape {
    let mut shape = Shape { files: Vec::new(), seen: Vec::new(), solid: bounds(fragment) };
    let points: Vec<[f32; 3]> = fragment.positions.iter().map(|own| z_up(*own)).collect();
    let made;
    let normals = match fragment.normals.is_empty() {
        true => {
            made = smooth_normals(fragment.positions, fragment.indices);
            &made
        }
        false => fragment.normals,
    };
    let normals: Vec<[f32; 3]> = normals.iter().map(|own| z_up(*own)).collect();
    let merged = check::merged(fragment);
    let attributes = Vertices { points: &points, merged: &merged, normals: &normals, uvs: fragment.uvs };
    let bare = Vertices { points: &points, merged: &merged, normals: &[], uvs: &[] };
    let mut put = |ending: &str, vertices: &Vertices<'_, f32>, indices: &[u32]| {
        let (mut text, mesh_name) = (String::new(), format!("{name}_{ending}"));
        mesh(&mut text, vertices, &[Part { material: None, indices }]);
        shape.files.push((format!("{mesh_name}.obj"), text));
        mesh_name
    };
    for (class, indices) in seen(fragment, &merged) {
        shape.seen.push((class, put(class, &attributes, indices)));
    }
    match hull {
        Some(Some(hull)) => {
            let corners: Vec<[f32; 3]> = hull.positions.iter().map(|own| z_up(*own)).collect();
            let vertices = Vertices { points: &corners, merged: &[], normals: &[], uvs: &[] };
            shape.solid = Solid::Mesh(put("hull", &vertices, hull.indices));
        }
        None if !is_flat(fragment) => shape.solid = Solid::Mesh(put("solid", &bare, fragment.indices)),
        _ => {}
    }
    shape
}

/// Outer triangles and crack triangles; all as one part if MuJoCo would refuse a part.
fn seen<'a>(fragment: &FragmentView<'a>, merged: &[u32]) -> Vec<(&'static str, &'a [u32])> {
    let (outer, crack) = fragment.indices.split_at(fragment.outer_indices());
    let fits = |indices: &[u32]| vertices(indices, merged) >= VERTICES_MIN && area_m2(fragment, indices) > AREA_MIN_M2;
    let parts = [("outer", outer), ("crack", crack)].into_iter().filter(|(_, indices)| !indices.is_empty());
    let parts: Vec<(&str, &[u32])> = parts.collect();
    let larger = if area_m2(fragment, outer) >= area_m2(fragment, crack) { "outer" } else { "crack" };
    match parts.iter().all(|(_, indices)| fits(indices)) {
        true => parts,
        false if fits(fragment.indices) => vec![(larger, fragment.indices)],
        false => Vec::new(),
    }
}

fn vertices(indices: &[u32], merged: &[u32]) -> usize {
    let mut points: Vec<u32> = indices.iter().map(|vertex| merged[*vertex as usize]).collect();
    points.sort_unstable();
    points.dedup();
    points.len()
}

fn area_m2(fragment: &FragmentView<'_>, indices: &[u32]) -> f64 {
    let corner = |vertex: u32| nalgebra::Vector3::from(fragment.positions[vertex as usize].map(f64::from));
    let area = |t: &[u32]| 0.5 * (corner(t[1]) - corner(t[0])).cross(&(corner(t[2]) - corner(t[0]))).norm();
    indices.chunks_exact(3).map(area).sum()
}

/// True if the box of equal inertia is almost flat.
fn is_flat(fragment: &FragmentView<'_>) -> bool {
    let [most, middle, least] = principal(fragment.inertia_kg_m2).moments_kg_m2;
    // A box of sides a ≥ b ≥ c has the moments m/12 (a² + b²), …
    let (thin, wide) = (middle + least - most, most + middle - least);
    thin <= FLATNESS_MIN * FLATNESS_MIN * wide
}

/// Bounding box of the fragment.
fn bounds(fragment: &FragmentView<'_>) -> Solid {
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let points = fragment.positions.iter().map(|own| z_up(own.map(f64::from)));
    let (low, high) = points.fold(start, |(low, high), point| {
        ([0, 1, 2].map(|k| low[k].min(point[k])), [0, 1, 2].map(|k| high[k].max(point[k])))
    });
    let halves = [0, 1, 2].map(|k| (0.5 * (high[k] - low[k])).max(HALF_MIN_M));
    Solid::Box([0, 1, 2].map(|k| 0.5 * (high[k] + low[k])), halves)
}
