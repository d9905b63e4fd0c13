//! Databases of real meshes, from the folder that SHATTER_MESHES names.

use shatter_fracture::database::{BakeRequest, Tables, load, save};
use shatter_fracture::pipeline::{DisplacementMethod, ElementChoice, SurfaceKind};
use shatter_fracture::scene::Material;
use shatter_fracture::surface::{LengthUnit, UpAxis, read};
use std::path::Path;

/// Quadratic elements have elastic lattices that are fitted to the surface. Some of their edges are three spacings long.
#[test]
fn databases_with_fitted_lattices_can_be_read() {
    let Ok(meshes) = std::env::var("SHATTER_MESHES") else {
        println!("skipped: SHATTER_MESHES is not set");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for file in ["suzanne.obj", "stanford-bunny.obj"] {
        let mesh = read(&Path::new(&meshes).join(file), LengthUnit::M, UpAxis::Y).unwrap();
        let (surface, elements) = (SurfaceKind::Lattice, ElementChoice::Quadratic);
        let tables = Tables { elastic: true, ..Tables::NONE };
        let request = BakeRequest::new("real", "glass", Material::named("glass").unwrap());
        let elastic = DisplacementMethod::Solve;
        let request = BakeRequest { surface, elements, tables, elastic, ..request };
        let path = folder.path().join("real.shatter");
        save(&request.bake(mesh).unwrap(), &path).unwrap();
        load(&path).unwrap();
    }
}
