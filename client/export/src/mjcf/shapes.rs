//! What MuJoCo gets of one fragment's surface: what is seen, by material, and what collides.

use super::z_up;
use crate::obj::{Part, Vertices, mesh};
use crate::{FragmentView, HullView, check, principal, smooth_normals};

/// MuJoCo refuses meshes of fewer vertices.
const VERTICES_MIN: usize = 4;

/// MuJoCo refuses meshes of next to no area, m².
const AREA_MIN_M2: f64 = 1e-12;

/// Of flatter fragments no hull is asked for: thickness over width.
const FLATNESS_MIN: f64 = 1e-5;

/// Half a side of a box at least, m.
const HALF_MIN_M: f64 = 1e-6;

/// What collides.
pub(super) enum Solid {
    /// The convex hull of a mesh, by its name.
    Mesh(String),
    /// A box, for what is too flat for a hull: center and half sides, m.
    Box([f64; 3], [f64; 3]),
}

/// One fragment.
pub(super) struct Shape {
    /// Names and texts of its mesh files.
    pub files: Vec<(String, String)>,
    /// What is seen: the class of the geometry and the name of its mesh.
    pub seen: Vec<(&'static str, String)>,
    /// What collides.
    pub solid: Solid,
}

/// The shape of the fragment called `name`; `hull` is `None` where no hulls were asked for.
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
    let looks = Vertices { points: &points, merged: &merged, normals: &normals, uvs: fragment.uvs };
    let bare = Vertices { points: &points, merged: &merged, normals: &[], uvs: &[] };
    let mut put = |ending: &str, vertices: &Vertices<'_, f32>, indices: &[u32]| {
        let (mut text, mesh_name) = (String::new(), format!("{name}_{ending}"));
        mesh(&mut text, vertices, &[Part { material: None, indices }]);
        shape.files.push((format!("{mesh_name}.obj"), text));
        mesh_name
    };
    for (class, indices) in seen(fragment, &merged) {
        shape.seen.push((class, put(class, &looks, indices)));
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

/// The outer triangles and those of cracks; all as one where MuJoCo would refuse a part.
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

/// Whether its box of equal inertia is next to flat.
fn is_flat(fragment: &FragmentView<'_>) -> bool {
    let [most, middle, least] = principal(fragment.inertia_kg_m2).moments_kg_m2;
    // Of a box of sides a ≥ b ≥ c moments are those of m/12 (a² + b²), …
    let (thin, wide) = (middle + least - most, most + middle - least);
    thin <= FLATNESS_MIN * FLATNESS_MIN * wide
}

/// The box around it.
fn bounds(fragment: &FragmentView<'_>) -> Solid {
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let points = fragment.positions.iter().map(|own| z_up(own.map(f64::from)));
    let (low, high) = points.fold(start, |(low, high), point| {
        ([0, 1, 2].map(|k| low[k].min(point[k])), [0, 1, 2].map(|k| high[k].max(point[k])))
    });
    let halves = [0, 1, 2].map(|k| (0.5 * (high[k] - low[k])).max(HALF_MIN_M));
    Solid::Box([0, 1, 2].map(|k| 0.5 * (high[k] + low[k])), halves)
}
