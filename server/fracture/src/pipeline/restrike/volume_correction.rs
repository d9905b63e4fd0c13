//! Correction of the children's volumes, which must add up to their parent's.
//!
//! Needed where an earlier crack is not quite flat: new points on it are moved until the sum is right.
//!
//! Ours. An earlier crack that halves a tetrahedron is a quadrilateral. It is flat unless one of its edge points is
//! moved to keep its distance from a node. A new crack that ends on it folds it along a line other than its diagonal.
//!
//! The sum of volumes is affine in each point. Its gradient is a third of the area vector around the point. One small
//! step along all gradients together therefore removes the difference up to its square.

use crate::lattice::Lattice;
use crate::tessellation::{FixedPoints, Tessellation, Topology};
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Moves new points on earlier cracks so that the volume of the children grows by `missing`; returns whether there is
/// such a point.
///
/// The moved points are those of `fixed` that are not in `old` but lie on its cracks inside the body. `tessellation`
/// was built with `fixed`.
pub(in crate::pipeline) fn correct_volume(
    fixed: &mut FixedPoints,
    old: &FixedPoints,
    lattice: &Lattice,
    topology: &Topology,
    tessellation: &Tessellation,
    missing: f64,
) -> bool {
    let mut slots = HashMap::new();
    let (faces, tets) = (new(&fixed.faces, &old.faces), new(&fixed.tets, &old.tets));
    let inner = |slot: &usize| !topology.boundary_face[fixed.faces[*slot].0 as usize];
    let faces: Vec<usize> = faces.into_iter().filter(inner).collect();
    let places = faces.iter().map(|&slot| fixed.faces[slot].1).chain(tets.iter().map(|&slot| fixed.tets[slot].1));
    slots.extend(places.enumerate().map(|(index, place)| (key(&place), index)));
    let mut gradients = gradients(tessellation, &slots);
    for (gradient, &slot) in gradients.iter_mut().zip(&faces) {
        // Points of a face stay in its plane.
        let [a, b, c] = topology.faces[fixed.faces[slot].0 as usize].map(|node| lattice.nodes[node as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
        *gradient -= normal * normal.dot(gradient);
    }
    let step = missing / gradients.iter().map(Vector3::norm_squared).sum::<f64>();
    if !step.is_finite() {
        return false;
    }
    let (of_faces, of_tets) = gradients.split_at(faces.len());
    faces.iter().zip(of_faces).for_each(|(&slot, gradient)| fixed.faces[slot].1 += gradient * step);
    tets.iter().zip(of_tets).for_each(|(&slot, gradient)| fixed.tets[slot].1 += gradient * step);
    true
}

/// Positions in `fixed` of the simplices that are not in `old`; both ascend.
fn new(fixed: &[(u32, Point3<f64>)], old: &[(u32, Point3<f64>)]) -> Vec<usize> {
    let is_new = |slot: &usize| old.binary_search_by_key(&fixed[*slot].0, |(simplex, _)| *simplex).is_err();
    (0..fixed.len()).filter(is_new).collect()
}

fn key(place: &Point3<f64>) -> [u64; 3] {
    [place.x.to_bits(), place.y.to_bits(), place.z.to_bits()]
}

/// Gradient of the children's volume by point. Cracks between children cancel, so only earlier cracks contribute.
fn gradients(tessellation: &Tessellation, slots: &HashMap<[u64; 3], usize>) -> Vec<Vector3<f64>> {
    let mut gradients = vec![Vector3::zeros(); slots.len()];
    for run in tessellation.runs().iter().filter(|run| run.crack && run.neighbor.is_none()) {
        let points = tessellation.run_vertices(run);
        for triangle in tessellation.run_triangles(run) {
            let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
            let third = (b - a).cross(&(c - a)) / 6.0;
            for slot in [a, b, c].iter().filter_map(|place| slots.get(&key(place))) {
                gradients[*slot] += third;
            }
        }
    }
    gradients
}
