//! Bakes and breaks an object in this process, without a daemon, and writes its fragments to `fragments.obj`.

use shatter_fracture::nalgebra::{Point3, Vector3};
use shatter_fracture::pipeline::DegreeRequest;
use shatter_fracture::surface::shapes;
use shatter_fracture::{BakeRequest, FractureRequest, Material};
use std::io::Write;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = shapes::cuboid([0.4, 0.2, 0.2]); // m; your own: surface::read(path, unit, up)
    let block = BakeRequest::new("block", "glass", Material::named("glass")?).bake(mesh)?;

    let impact = FractureRequest::at(Point3::new(0.2, 0.01, 0.02), Vector3::new(-50.0, 3.0, 0.0)); // m, N·s
    let impact = FractureRequest { degree: DegreeRequest::Sites(12), ..impact };
    let outcome = block.strike(&impact)?;
    let meshes = outcome.meshes().ok_or("the block stays whole")?;

    let mut file = std::io::BufWriter::new(std::fs::File::create("fragments.obj")?);
    let mut first = 1; // OBJ counts vertices from 1
    for fragment in meshes.emitted()?.fragments() {
        println!("fragment {}: {:.4} kg", fragment.row.id, fragment.row.mass_kg);
        writeln!(file, "o fragment_{}", fragment.row.id)?;
        let center_m = fragment.row.center_m; // vertices are relative to it
        for vertex in fragment.positions {
            let [x, y, z] = [0, 1, 2].map(|axis| center_m[axis] + f64::from(vertex[axis]));
            writeln!(file, "v {x} {y} {z}")?;
        }
        for triangle in fragment.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|corner| first + triangle[corner]);
            writeln!(file, "f {a} {b} {c}")?;
        }
        first += fragment.positions.len() as u32;
    }
    Ok(())
}
