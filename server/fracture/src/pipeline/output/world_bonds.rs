//! Bonds of fragments to the world: fragments inside anchors, and the area of their surface there.

use super::faces::faces;
use super::rows::{BondRow, WORLD};
use crate::lattice::Lattice;
use crate::pipeline::prepared::anchored::AnchoredObject;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::surface::LocalFrame;
use nalgebra::{Point3, Vector3};

/// Part of one fragment inside anchors, local.
#[derive(Clone, Copy, Default)]
struct Part {
    /// Number of nodes of the crack lattice.
    nodes: usize,
    /// Sum of their positions.
    places: Vector3<f64>,
    /// Area of outer triangles. The fields below are the sum of their area vectors and the first moment of the area.
    area: f64,
    normal: Vector3<f64>,
    moment: Vector3<f64>,
}

/// The bonds of one body's fragments to the world, by fragment; indices within the body.
///
/// A fragment has a bond if an anchor contains one of its nodes of the crack lattice or the centroid of a triangle of
/// its outer surface. The area of the bond is that of these triangles.
pub(in crate::pipeline) fn bonds(
    pieces: &BodyMeshes,
    lattice: &Lattice,
    held: &AnchoredObject,
    frame: &LocalFrame,
) -> Vec<BondRow> {
    let mut parts = vec![Part::default(); pieces.properties.len()];
    let holds = |place: &Point3<f64>| held.anchors().contains(&frame.to_meters(place));
    for (&label, node) in pieces.labels.iter().zip(&lattice.nodes).filter(|(_, node)| holds(node)) {
        let part = &mut parts[label as usize];
        (part.nodes, part.places) = (part.nodes + 1, part.places + node.coords);
    }
    for run in pieces.tessellation.runs().iter().filter(|run| run.neighbor.is_none()) {
        let part = &mut parts[run.fragment as usize];
        for face in faces(&pieces.tessellation, run) {
            let centroid = face.corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 3.0;
            if holds(&Point3::from(centroid)) {
                let area = face.area.norm();
                (part.area, part.normal) = (part.area + area, part.normal + face.area);
                part.moment += centroid * area;
            }
        }
    }
    let bond = |(fragment, part): (usize, Part)| {
        let centroid = if part.area > 0.0 { part.moment / part.area } else { part.places / part.nodes as f64 };
        BondRow {
            fragments: [fragment as u32, WORLD],
            area_m2: part.area * frame.diagonal_m * frame.diagonal_m,
            normal: part.normal.try_normalize(0.0).unwrap_or_default(),
            centroid_m: frame.to_meters(&Point3::from(centroid)),
        }
    };
    parts.into_iter().enumerate().filter(|(_, part)| part.nodes > 0 || part.area > 0.0).map(bond).collect()
}
