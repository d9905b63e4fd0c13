//! Mesh file of the intact object, for hosts that replace it by its fragments when it breaks.

use super::{CommandError, output};
use nalgebra::Point3;
use shatter_export::{ExportError, FragmentView, RunView, glb_bytes};
use shatter_fracture::pipeline::{IntactBody, PreparedObject};
use shatter_fracture::surface::{RawMesh, shapes};
use std::path::Path;

/// Writes the boundary of every body to `path`, whole or not at all: one mesh in `.obj`, one node per body in `.glb`.
///
/// Coordinates of the object: meters, +Y up.
pub fn write(prepared: &PreparedObject, path: &Path) -> Result<(), CommandError> {
    let bodies = prepared.intact();
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    let bytes = match ending.as_str() {
        "obj" => shapes::obj(&joined(&bodies)).into_bytes(),
        "glb" => glb(&bodies).map_err(|error| CommandError::output(path, &error))?,
        _ => return Err(CommandError::output(path, &"unknown mesh format; use the extension .obj or .glb")),
    };
    output::whole(path, &bytes)
}

/// Joins all bodies into one mesh.
fn joined(bodies: &[IntactBody]) -> RawMesh {
    let mut all = RawMesh::new(Vec::new(), Vec::new());
    for IntactBody { mesh, .. } in bodies {
        let first = all.positions_m.len() as u32;
        all.positions_m.extend_from_slice(&mesh.positions_m);
        all.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
    }
    all
}

/// Buffers of a body's node.
struct Sections {
    positions: Vec<[f32; 3]>,
    runs: [RunView; 1],
}

fn sections(own: &IntactBody) -> Sections {
    let relative = |place: &Point3<f64>| [0, 1, 2].map(|k| (place[k] - own.center_m[k]) as f32);
    let index_count = 3 * own.mesh.triangles.len() as u32;
    Sections {
        positions: own.mesh.positions_m.iter().map(relative).collect(),
        runs: [RunView { crack: false, index_first: 0, index_count }],
    }
}

fn view<'a>(body: usize, own: &'a IntactBody, sections: &'a Sections) -> FragmentView<'a> {
    FragmentView {
        normals: &[],
        uvs: &[],
        uvs2: &[],
        colors: &[],
        materials: &[],
        id: body as u32,
        body: body as u32,
        positions: &sections.positions,
        indices: own.mesh.triangles.as_flattened(),
        runs: &sections.runs,
        merges: &[],
        center_m: own.center_m,
        volume_m3: own.volume_m3,
        mass_kg: own.mass_kg,
        inertia_kg_m2: own.inertia_kg_m2,
    }
}

/// One node per body, in the layout of fragments.
fn glb(bodies: &[IntactBody]) -> Result<Vec<u8>, ExportError> {
    let sections: Vec<Sections> = bodies.iter().map(sections).collect();
    let views = bodies.iter().zip(&sections).enumerate();
    let views: Vec<FragmentView<'_>> = views.map(|(body, (own, sections))| view(body, own, sections)).collect();
    glb_bytes(&views).map(|(bytes, _)| bytes)
}
