//! The object of the demonstration: a generated mug, baked once.

use super::DemoError;
use super::progress::DemoProgress;
use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, BakeRequest, BakeStep};
use shatter_fracture::pipeline::PreparedObject;
use shatter_fracture::scene::Material;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_server::commands::interrupt;
use std::path::Path;

/// Name of the object in the service.
pub const NAME: &str = "mug";

/// Material of the object.
pub const MATERIAL: &str = "ceramic";

/// Reference fragment size d, m.
const FRAGMENT_SIZE_M: f64 = 0.018;

/// Number of example impacts: enough that requests with radius [`RADIUS_M`] need no solve. Each takes a third of a second of one core.
const EXAMPLES: u64 = 48;

/// Contact radius of the requests, m: about that of a marble.
pub(super) const RADIUS_M: f64 = 0.012;

/// Direction from the axis to the struck place: the outer wall away from the handle, two thirds up.
const STRUCK_FROM: [f64; 3] = [-0.45, 0.0, 0.9];
const STRUCK_HEIGHT_M: f64 = 0.062;

/// Object and place of its impact.
pub(super) struct DemoTarget {
    /// Prepared object, the same as in the daemon.
    pub prepared: PreparedObject,
    /// Point of the surface, m.
    pub point_m: Point3<f64>,
    /// Unit direction of the impulse: inward.
    pub direction: Vector3<f64>,
    /// Whether an existing database was reused.
    pub reused: bool,
}

/// Loads the database if it was baked from this mesh with these parameters; otherwise bakes it.
pub(super) fn prepare(databases: &Path, progress: &DemoProgress) -> Result<DemoTarget, DemoError> {
    progress.step("generate a mug");
    let mesh = shapes::mug();
    let (point_m, direction) = struck(&mesh);
    let request = request()?;
    let file = databases.join(format!("{NAME}.{}", database::EXTENSION));
    progress.step("look for its database");
    let stored = database::stored(&file, mesh.clone(), &request, &CancelToken::default(), &mut |_| ())?;
    if let Some(prepared) = stored {
        progress.step("reuse the database of an earlier run");
        return Ok(DemoTarget { prepared, point_m, direction, reused: true });
    }
    let mut on_step = |step| progress.step(describe(step));
    let prepared = database::bake(mesh, &request, &CancelToken::default(), &mut on_step)?;
    progress.step("write the database");
    let _writing = interrupt::writing();
    database::save(&prepared, &file).map_err(|source| DemoError::Database { path: file.clone(), source })?;
    Ok(DemoTarget { prepared, point_m, direction, reused: false })
}

fn request() -> Result<BakeRequest, DemoError> {
    Ok(BakeRequest {
        fragment_size_m: Some(FRAGMENT_SIZE_M),
        examples: EXAMPLES,
        ..BakeRequest::new(NAME, MATERIAL, Material::named(MATERIAL)?)
    })
}

/// Outermost vertex in the direction of the impact at its height, and the direction inward from there.
fn struck(mesh: &RawMesh) -> (Point3<f64>, Vector3<f64>) {
    let outward = Vector3::from(STRUCK_FROM).normalize();
    let reach = |p: &Point3<f64>| p.coords.dot(&outward) - (p.y - STRUCK_HEIGHT_M).abs();
    let farthest = mesh.positions_m.iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
    (farthest.copied().unwrap_or_else(Point3::origin), -outward)
}

fn describe(step: BakeStep) -> &'static str {
    match step {
        BakeStep::Surface => "bake: surface",
        BakeStep::Volume => "bake: winding numbers",
        BakeStep::Lattices | BakeStep::Sized(_) => "bake: lattices",
        BakeStep::Lift(_) => "bake: lift",
        BakeStep::ExactSurface { .. } => "bake: input surface",
        BakeStep::Elasticity(_) => "bake: elasticity",
        BakeStep::Reduction => "bake: reduced elasticity",
        BakeStep::Calibration => "bake: calibration of the degree",
        BakeStep::Examples { .. } => "bake: examples",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_demo_contact_is_on_the_outer_wall() {
        let (point_m, direction) = struck(&shapes::mug());
        assert!((point_m.y - STRUCK_HEIGHT_M).abs() < 0.003 && (point_m.x.hypot(point_m.z) - 0.04).abs() < 0.001);
        assert!(direction.dot(&point_m.coords) < -0.039 && (direction.norm() - 1.0).abs() < 1e-12);
    }
}
