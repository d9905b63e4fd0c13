//! Conversion of the meshes of the input surface to tensors, and back.

use super::container::{ContainerContents, FLAT, Tensors};
use super::lattice_tensors::{lattice, put_lattice};
use super::stored_values::implausible;
use super::{DatabaseError, Tables, skins};
use crate::cutting::CuttingMesh;
use crate::lattice::Lattice;

/// Tensors of a body's mesh; optional.
const MESH: &str = "cutting";

/// Tensor of the tetrahedra of the crack lattice that carry the nodes of that mesh.
const CARRIERS: &str = "cutting.carriers";

/// Adds the tensors of a mesh. `name` returns the name of a tensor of its body.
pub(super) fn put(tensors: &mut Tensors, name: &dyn Fn(&str) -> String, cutting: &CuttingMesh) {
    put_lattice(tensors, &name(MESH), &cutting.mesh);
    let tets: Vec<u32> = cutting.carriers.iter().map(|carrier| carrier.tet).collect();
    tensors.u32(name(CARRIERS), &[tets.len()], &tets);
    if let Some(outer) = &cutting.outer {
        skins::put_corners(tensors, &name(MESH), outer);
    }
}

/// The mesh of a body with the lattice `crack`; `None` if the file has none. `materials`: number of material names.
pub(super) fn read(
    contents: &ContainerContents,
    name: &dyn Fn(&str) -> String,
    crack: &Lattice,
    tables: Tables,
    materials: usize,
) -> Result<Option<CuttingMesh>, DatabaseError> {
    if !contents.holds(&name(CARRIERS)) {
        return Ok(None);
    }
    let mesh = lattice(contents, &name(MESH))?;
    let carriers = contents.u32(&name(CARRIERS), Some(mesh.nodes.len()), FLAT, crack.tets.len() as u64)?;
    let mut cutting = CuttingMesh::new(mesh, crack, &carriers);
    if let Some(node) = cutting.misplaced(crack) {
        let wanted = "the tetrahedron that carries this node";
        return Err(implausible(&name(CARRIERS), node, f64::from(carriers[node]), wanted));
    }
    if tables.attributes || tables.skin {
        cutting.outer = skins::corners(contents, &name(MESH), &cutting.topology.boundary, materials)?;
    }
    Ok(Some(cutting))
}
