//! Bounds of an object, for `list`.

use nalgebra::Point3;
use shatter_fracture::pipeline::PreparedObject;

/// Lowest and highest corner of the mesh, m; of the lattice's surface if neither the skin nor an exact surface is loaded.
pub(super) fn of_mesh(prepared: &PreparedObject) -> [Point3<f64>; 2] {
    let exact = prepared.bodies.iter().map(|body| body.cutting.as_ref().map(|cutting| &cutting.mesh.nodes));
    let exact: Option<Vec<_>> = exact.collect();
    let points: Vec<&Point3<f64>> = match (exact, &prepared.skin) {
        (Some(bodies), _) => bodies.into_iter().flatten().collect(),
        (None, Some(skin)) => skin.points.iter().collect(),
        (None, None) => return prepared.bounds_m(),
    };
    let corners = points.into_iter().map(|local| prepared.frame.to_meters(local));
    let empty = [f64::INFINITY, f64::NEG_INFINITY].map(|end| Point3::new(end, end, end));
    corners.fold(empty, |[low, high], corner| [low.inf(&corner), high.sup(&corner)])
}
