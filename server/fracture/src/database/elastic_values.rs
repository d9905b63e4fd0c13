//! Checks of an elastic lattice: alone, and against the crack lattice through the energy transfer.
//!
//! Both lattices fill the same body, but their volumes and boxes may differ: the coarser one loses thin parts. Two relations hold for
//! every lattice that a bake writes:
//!
//! - The angles of stuffed tetrahedra are bounded ([`crate::lattice::stuff`]), and those of fitted ones more tightly. Edges are not: up to
//!   3.7 spacings were measured in fitted lattices.
//! - The hat functions of the crack nodes reproduce linear functions. So the centroid of an elastic tetrahedron is the mean of the crack
//!   nodes that take its energy, weighted by their shares, if the crack lattice covers the tetrahedron.

use super::DatabaseError;
use super::stored_values::implausible;
use crate::lattice::{DihedralRange, EnergyTransfer, Lattice, LatticeStretch};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Dihedral angles of stuffed tetrahedra, degrees: 10.7 to 164.8 (Labelle and Shewchuk 2007), and a margin for rounding.
const DIHEDRAL_DEG: [f64; 2] = [10.0, 166.0];

/// Largest distance of a node from the box of the input, whose half diagonal is 0.5, in grid spacings.
const OUTSIDE_MAX: f64 = 1.0;

/// Largest distance of a covered tetrahedron's centroid from the mean of its crack nodes, in grid spacings.
///
/// Measured: 2e-13 in 206 lattices. The transfer neglects uncovered parts of a millionth of a tetrahedron.
const CENTROID_TOLERANCE: f64 = 1e-4;

/// Largest difference between a share and a quarter in a transfer from a lattice to itself.
const QUARTER_TOLERANCE: f64 = 1e-9;

/// Checks the elastic lattice `elastic.*` of the body whose tensors begin with `body`. `spacing`: larger spacing of both lattices, local,
/// where they are regular, and the stretch that makes them so.
pub(super) fn check(
    body: &str,
    elastic: &Lattice,
    crack: &Lattice,
    transfer: &EnergyTransfer,
    (spacing, stretch): (f64, Option<&LatticeStretch>),
) -> Result<(), DatabaseError> {
    let [nodes, tets] = ["nodes", "tets"].map(|part| format!("{body}.elastic.{part}"));
    check_nodes(&nodes, elastic, spacing)?;
    match stretch {
        Some(stretch) => check_angles(&tets, &stretch.regular(elastic))?,
        None => check_angles(&tets, elastic)?,
    }
    let centroids = shared_centroids(crack, transfer, elastic.tets.len());
    let is_checked = covered(elastic, crack, transfer);
    let wrong = (0..elastic.tets.len()).into_par_iter().find_first(|&tet| {
        let off = (centroids[tet] - centroid(elastic, tet)).norm();
        is_checked[tet] && (off.is_nan() || off > CENTROID_TOLERANCE * spacing)
    });
    match wrong {
        Some(tet) => Err(implausible(
            &tets,
            4 * tet,
            (centroids[tet] - centroid(elastic, tet)).norm(),
            "the distance, nearly zero, of a tetrahedron's centroid from the crack nodes that take its energy",
        )),
        None => Ok(()),
    }
}

/// Checks that every node belongs to a tetrahedron and lies within the input's box.
fn check_nodes(tensor: &str, elastic: &Lattice, spacing: f64) -> Result<(), DatabaseError> {
    let mut is_used = vec![false; elastic.nodes.len()];
    elastic.tets.iter().flatten().for_each(|node| is_used[*node as usize] = true);
    if let Some(node) = is_used.iter().position(|is_used| !is_used) {
        return Err(implausible(tensor, 3 * node, elastic.nodes[node].x, "a coordinate of a corner of a tetrahedron"));
    }
    let distance = |node: &Point3<f64>| node.coords.norm();
    match elastic.nodes.iter().position(|node| distance(node) > 0.5 + OUTSIDE_MAX * spacing) {
        Some(node) => Err(implausible(
            tensor,
            3 * node,
            distance(&elastic.nodes[node]),
            "a distance from the middle within the object's box",
        )),
        None => Ok(()),
    }
}

/// Checks angles.
fn check_angles(tensor: &str, elastic: &Lattice) -> Result<(), DatabaseError> {
    let [least, most] = DIHEDRAL_DEG;
    let fault = |tet: usize| -> Option<f64> {
        let angles = DihedralRange::of(&elastic.corners(tet))?;
        [angles.min_deg, angles.max_deg].into_iter().find(|angle| !(least..=most).contains(angle))
    };
    let first = (0..elastic.tets.len()).into_par_iter().find_map_first(|tet| Some((tet, fault(tet)?)));
    first.map_or(Ok(()), |(tet, angle)| {
        Err(implausible(tensor, 4 * tet, angle, "an angle between faces of 10 to 166 degrees"))
    })
}

fn centroid(lattice: &Lattice, tet: usize) -> Vector3<f64> {
    lattice.corners(tet).iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0
}

/// Mean of the crack nodes that take the energy of each elastic tetrahedron, weighted by their shares.
fn shared_centroids(crack: &Lattice, transfer: &EnergyTransfer, tets: usize) -> Vec<Vector3<f64>> {
    let mut means = vec![Vector3::zeros(); tets];
    for (node, row) in crack.nodes.iter().zip(transfer.offsets.windows(2)) {
        let row = row[0] as usize..row[1] as usize;
        for (tet, share) in transfer.tets[row.clone()].iter().zip(&transfer.shares[row]) {
            means[*tet as usize] += node.coords * *share;
        }
    }
    means
}

/// The elastic tetrahedra that the crack lattice covers for certain: those inside both boundaries, or all of a body with one lattice.
fn covered(elastic: &Lattice, crack: &Lattice, transfer: &EnergyTransfer) -> Vec<bool> {
    if transfer.shares.iter().all(|share| (share - 0.25).abs() <= QUARTER_TOLERANCE) {
        return vec![true; elastic.tets.len()];
    }
    let [is_rim, is_crack_rim] = [elastic, crack].map(|lattice| {
        let mut is_rim = vec![false; lattice.nodes.len()];
        lattice.boundary().iter().flat_map(|face| face.nodes).for_each(|node| is_rim[node as usize] = true);
        is_rim
    });
    let mut is_covered: Vec<bool> =
        elastic.tets.iter().map(|nodes| nodes.iter().all(|node| !is_rim[*node as usize])).collect();
    for (row, _) in transfer.offsets.windows(2).zip(is_crack_rim).filter(|(_, is_rim)| *is_rim) {
        let row = &transfer.tets[row[0] as usize..row[1] as usize];
        row.iter().for_each(|tet| is_covered[*tet as usize] = false);
    }
    is_covered
}
