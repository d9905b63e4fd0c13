//! Pictures of the page.

use super::DemoError;
use super::energy::SurfaceEnergy;
use super::object::DemoTarget;
use crate::picture::{
    Backdrop, CREASE_DEG, Camera, Color, DrawnMesh, ENERGY, PictureSize, Projection, RenderStyle, Spread, arrow, draw,
    pieces,
};
use crate::report::Scale;
use nalgebra::{Point3, Vector3};
use shatter_export::FragmentView;

const SIZE: PictureSize = PictureSize { width: 1000, height: 800 };

/// Direction from the object to the camera: above, on the struck side, with the handle in view.
const FROM: [f32; 3] = [0.18, 0.55, 1.0];

/// Long lens, which hardly shortens distant objects.
const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// Displacement of fragments over their distance from the center.
const SPREAD: f64 = 0.42;

/// Length of the arrow over the object's diagonal.
const ARROW: f64 = 0.26;

/// Intact object, colored by strain energy density on a logarithmic scale, with an arrow at the contact.
pub(super) fn intact(energy: &SurfaceEnergy, scale: &Scale, target: &DemoTarget) -> Result<Vec<u8>, DemoError> {
    let decades = (scale.high / scale.low).ln();
    let shares: Vec<f32> =
        energy.density_j_m3.iter().map(|density| ((density / scale.low).ln() / decades) as f32).collect();
    let paint = |_, vertex: u32| ENERGY.at(shares[vertex as usize]);
    let mut mesh = DrawnMesh::paint(energy.positions.clone(), energy.triangles.clone(), CREASE_DEG, paint);
    let frame = &target.prepared.frame;
    let tip: Point3<f32> = Point3::from(target.point_m - frame.center_m).cast();
    let length = (ARROW * frame.diagonal_m) as f32;
    let ground = mesh.bounds().0.y;
    mesh.append(arrow(tip, target.direction.cast(), length, Color::oklch(0.52, 0.12, 248.0)));
    picture(&mesh, RenderStyle::CHART, ground)
}

/// Fragments, moved apart from the center of the object.
pub(super) fn fragments_figure(fragments: &[FragmentView<'_>], target: &DemoTarget) -> Result<Vec<u8>, DemoError> {
    let hub_m = target.prepared.frame.center_m.coords.into();
    let mesh = pieces(fragments, Spread { hub_m, factor: SPREAD });
    let ground = mesh.bounds().0.y;
    picture(&mesh, RenderStyle::STUDIO, ground)
}

fn picture(mesh: &DrawnMesh, style: RenderStyle, ground: f32) -> Result<Vec<u8>, DemoError> {
    let camera = Camera::fit(&mesh.positions, Vector3::from(FROM), LENS, SIZE.width as f32 / SIZE.height as f32);
    Ok(draw(mesh, &camera, SIZE, style, Some(ground), Backdrop::Clear).png()?)
}
