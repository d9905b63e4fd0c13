//! Conversion of a lattice to tensors, and back.

use super::container::{ContainerContents, Tensors};
use super::{DatabaseError, stored_values};
use crate::conforming::is_positive;
use crate::lattice::{Lattice, check_manifold};

/// Largest number of nodes of a lattice.
pub const NODES_MAX: usize = 4_000_000;

/// Adds the tensors of a lattice.
pub(super) fn put_lattice(tensors: &mut Tensors, name: &str, lattice: &Lattice) {
    let nodes: Vec<f64> = lattice.nodes.iter().flat_map(|node| [node.x, node.y, node.z]).collect();
    tensors.f64(format!("{name}.nodes"), &[lattice.nodes.len(), 3], &nodes);
    tensors.u32(format!("{name}.tets"), &[lattice.tets.len(), 4], lattice.tets.as_flattened());
}

/// The lattice whose tensors begin with `name`.
pub(super) fn lattice(contents: &ContainerContents, name: &str) -> Result<Lattice, DatabaseError> {
    let nodes = format!("{name}.nodes");
    let coordinates = contents.f64(&nodes, None, 3)?;
    stored_values::coordinates(&nodes, &coordinates)?;
    let (nodes, _) = coordinates.as_chunks::<3>();
    if nodes.len() > NODES_MAX {
        return Err(DatabaseError::TooLarge { what: "nodes of a lattice", found: nodes.len(), cap: NODES_MAX });
    }
    let tensor = format!("{name}.tets");
    let indices = contents.u32(&tensor, None, 4, nodes.len() as u64)?;
    let (tets, _) = indices.as_chunks::<4>();
    let lattice = Lattice { nodes: nodes.iter().map(|node| (*node).into()).collect(), tets: tets.to_vec() };
    match (0..lattice.tets.len()).find(|&tet| !is_positive(&lattice.corners(tet))) {
        Some(index) => Err(DatabaseError::Folded { tensor, index }),
        None => match check_manifold(&lattice) {
            Ok(()) => Ok(lattice),
            Err(source) => Err(DatabaseError::Pinched { tensor, source }),
        },
    }
}
