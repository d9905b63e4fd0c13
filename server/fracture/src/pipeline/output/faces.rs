//! The triangles of a run, with their areas.

use crate::tessellation::{RunRange, Tessellation};
use nalgebra::{Point3, Vector3};
/// A triangle of a run: corners and area vector, local.
pub(in crate::pipeline) struct Face {
    /// Corners, local.
    pub corners: [Point3<f64>; 3],
    /// Area vector, local.
    pub area: Vector3<f64>,
}

/// The triangles of `run`, with area vectors out of its fragment.
pub(in crate::pipeline) fn faces<'a>(
    tessellation: &'a Tessellation,
    run: &'a RunRange,
) -> impl Iterator<Item = Face> + 'a {
    let points = tessellation.run_vertices(run);
    tessellation.run_triangles(run).map(|triangle| {
        let corners = triangle.map(|vertex| points[vertex as usize]);
        Face { corners, area: (corners[1] - corners[0]).cross(&(corners[2] - corners[0])) * 0.5 }
    })
}
