//! Generated closed meshes in meters, y up, for tests, references and the demonstration.
//!
//! Every body is one closed surface, consistently wound, facing outward, without self-intersections.

mod head;
mod implicit;
mod objects;
mod solids;
mod sweep;
#[cfg(test)]
mod tests;

pub use head::head;
pub use implicit::implicit;
pub use objects::{arch, dumbbell, horseshoe, mug, scanned_statue, statue, statue_on, vase};
pub use solids::{cuboid, ellipsoid, sphere, torus};

use super::RawMesh;
use std::path::Path;

/// Names of the shapes that [`by_name`] generates.
pub const NAMES: [&str; 7] = ["arch", "dumbbell", "head", "horseshoe", "mug", "statue", "vase"];

/// Generates the shape of that name; `None` for a name outside [`NAMES`].
pub fn by_name(name: &str) -> Option<RawMesh> {
    match name {
        "arch" => Some(arch()),
        "dumbbell" => Some(dumbbell()),
        "head" => Some(head()),
        "horseshoe" => Some(horseshoe()),
        "mug" => Some(mug()),
        "statue" => Some(statue()),
        "vase" => Some(vase()),
        _ => None,
    }
}

/// Mesh as Wavefront OBJ text, in meters. Reading it returns the same bits.
pub fn obj(mesh: &RawMesh) -> String {
    let mut text = String::new();
    for point in &mesh.positions_m {
        text += &format!("v {} {} {}\n", point.x, point.y, point.z);
    }
    for [a, b, c] in &mesh.triangles {
        // The mesh may be unchecked, so its indices may be u32::MAX.
        let [a, b, c] = [a, b, c].map(|&index| u64::from(index) + 1);
        text += &format!("f {a} {b} {c}\n");
    }
    text
}

/// Writes a mesh as Wavefront OBJ, in the format of [`obj`].
///
/// # Errors
/// Those of the file system.
pub fn write_obj(mesh: &RawMesh, path: &Path) -> std::io::Result<()> {
    std::fs::write(path, obj(mesh))
}
