//! Bakes and breaks an object in this process, without a daemon.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{self, DegreeRequest, FractureRequest, RequestContext, Workspace};
use shatter_fracture::scene::{MATERIALS, Materials};
use shatter_fracture::surface::shapes;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let glass = Materials::parse(MATERIALS)?.get("glass")?.clone();
    let token = CancelToken::default(); // a deadline or another thread can stop the work by it
    let mesh = shapes::cuboid([0.4, 0.2, 0.2]); // your own: surface::read(path, unit, up)
    let object = bake(mesh, &BakeRequest::new("block", "glass", glass), &token, &mut |_| {})?;

    let (point_m, impulse_ns) = (Point3::new(0.2, 0.01, 0.02), Vector3::new(-50.0, 3.0, 0.0));
    let request = FractureRequest { degree: DegreeRequest::Sites(12), ..FractureRequest::at(point_m, impulse_ns) };
    let context = RequestContext::new(&object, &request, &token, &());
    let outcome = pipeline::strike(context, &mut Workspace::default())?;
    for fragment in outcome.into_meshes().ok_or("the block stays whole")?.fragments {
        println!("fragment {}: {:.4} kg", fragment.id, fragment.mass_kg);
    }
    Ok(())
}
