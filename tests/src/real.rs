//! Real test meshes, which the project does not contain: found through `SHATTER_MESHES`; otherwise the test prints that it skips them.

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{ElementChoice, PreparedObject, SurfaceKind};
use shatter_fracture::scene::{Material, Materials};
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis};
use std::path::PathBuf;

/// The file `name` in the folder that `SHATTER_MESHES` names, or `None` after a line that CI counts.
pub fn mesh(name: &str) -> Option<PathBuf> {
    let found = std::env::var_os("SHATTER_MESHES").map(|folder| PathBuf::from(folder).join(name));
    match found {
        Some(path) if path.is_file() => Some(path),
        Some(path) => {
            println!("skipped: {} is not there", path.display());
            None
        }
        None => {
            println!("skipped: SHATTER_MESHES is not set ({name})");
            None
        }
    }
}

/// A material that ships with the program.
pub fn material(name: &str) -> Material {
    let table = shatter_fracture::scene::MATERIALS;
    Materials::parse(table).and_then(|materials| materials.get(name).cloned()).unwrap()
}

/// A bake with all defaults except the surface, which is the lattice's, and the elements, which are linear, for an object
/// `name` of the material `material_name`. So objects without examples have no basis of displacements.
pub fn request(name: &str, material_name: &str) -> BakeRequest {
    let (surface, elements) = (SurfaceKind::Lattice, ElementChoice::Linear);
    BakeRequest { surface, elements, ..BakeRequest::new(name, material_name, material(material_name)) }
}

/// A real mesh, coordinates as in its file.
pub fn raw(file: &str) -> Option<RawMesh> {
    Some(surface::read(&mesh(file)?, LengthUnit::M, UpAxis::Y).unwrap())
}

/// A real mesh baked at default spacing.
pub fn baked(file: &str) -> Option<PreparedObject> {
    let name = file.split('.').next().unwrap();
    Some(bake(raw(file)?, &request(name, "glass"), &CancelToken::default(), &mut |_| ()).unwrap())
}
