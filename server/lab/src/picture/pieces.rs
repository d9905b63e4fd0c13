//! Fragments as colored meshes, moved apart so that the cracks show.

use super::color::{Color, crack_color, fragment_color};
use super::mesh::DrawnMesh;
use nalgebra::{Point3, Vector3};
use shatter_export::FragmentView;

/// Edges that bend by less than this are shaded smooth, degrees.
pub const CREASE_DEG: f32 = 40.0;

/// Displacement of fragments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Fixed point, m.
    pub hub_m: [f64; 3],
    /// Displacement over a fragment's distance from the hub; 0: none.
    pub factor: f64,
}

/// Colors fragments: a muted color for the outer faces of each, a warmer and paler one for its crack faces.
///
/// Positions in meters relative to the hub.
pub fn pieces(fragments: &[FragmentView<'_>], spread: Spread) -> DrawnMesh {
    let mut scene = DrawnMesh::default();
    for fragment in fragments {
        let from_hub = Vector3::from(fragment.center_m) - Vector3::from(spread.hub_m);
        let place: Vector3<f32> = (from_hub * (1.0 + spread.factor)).cast();
        scene.append(piece(fragment, fragment_color(fragment.id), crack_color(fragment.id)).moved(place));
    }
    scene
}

/// One fragment around its center. Runs have separate vertices, so their rims stay sharp.
fn piece(fragment: &FragmentView<'_>, outer: Color, crack: Color) -> DrawnMesh {
    let positions = fragment.positions.iter().map(|&position| Point3::from(position)).collect();
    let triangles: Vec<[u32; 3]> = fragment.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let outer_count: u32 = fragment.runs.iter().filter(|run| !run.crack).map(|run| run.index_count / 3).sum();
    let paint = |triangle: usize, _| if (triangle as u32) < outer_count { outer } else { crack };
    DrawnMesh::paint(positions, triangles, CREASE_DEG, paint)
}
