//! Tests of elasticity: analytic references, invariances and errors. This file holds their shared bodies and solves.

mod anchored;
mod beam;
mod closed_forms;
mod contact;
mod edge_contacts;
mod eigenvalue_bound;
mod errors;
mod invariance;
mod modes;
mod near_field;
mod patch;
mod precision;
mod quadratic;
mod quadratic_reduced;
mod recovery;
mod reduced;
mod turned;
mod walls;

use super::*;
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, block};
use crate::random::RandomStream;
use crate::reference::{bending_error, kuhn, perturbed, traction};
use nalgebra::{Matrix3, Point3, Vector3};

/// Lattice of the tetrahedra whose centroid passes `keep`, with renumbered nodes.
fn carve(lattice: &Lattice, keep: impl Fn(Point3<f64>) -> bool) -> Lattice {
    let mut carved = Lattice::default();
    let mut renumbered = std::collections::HashMap::new();
    for tet in 0..lattice.tets.len() {
        if !keep(centroid(lattice, tet)) {
            continue;
        }
        carved.tets.push(lattice.tets[tet].map(|node| {
            *renumbered.entry(node).or_insert_with(|| {
                carved.nodes.push(lattice.nodes[node as usize]);
                carved.nodes.len() as u32 - 1
            })
        }));
    }
    carved
}

fn centroid(lattice: &Lattice, tet: usize) -> Point3<f64> {
    Point3::from(lattice.corners(tet).iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0)
}

/// Free body.
fn free(lattice: &Lattice, poisson: f64) -> Elasticity {
    Elasticity::prepare(lattice, poisson, &CancelToken::default()).unwrap()
}

/// Displacement under `forces`.
fn solve(body: &Elasticity, forces: &[f64]) -> Vec<f64> {
    let mut displacement = Vec::new();
    body.solve(forces, &mut displacement, &mut ElasticWorkspace::default(), &CancelToken::default()).unwrap();
    displacement
}

/// Energies of all tetrahedra under `forces`; checks that their sum is the work of the forces.
fn energies(body: &Elasticity, lattice: &Lattice, forces: &[f64], driving: DrivingEnergy) -> Vec<f64> {
    let displacement = solve(body, forces);
    let mut energies = Vec::new();
    body.tet_energy(lattice, &displacement, driving, &mut energies, &CancelToken::default()).unwrap();
    if driving == DrivingEnergy::Total {
        let (sum, work): (f64, f64) = (energies.iter().sum(), body.elastic_energy(forces, &displacement));
        assert!((sum - work).abs() <= 1e-10 * work.abs(), "Σ W = {sum}, ½ f·u = {work}");
    }
    energies
}

/// Nodal forces of `contacts`, in equilibrium.
fn load(body: &Elasticity, contacts: &[ContactLoad]) -> NodalLoad {
    let mut load = NodalLoad::default();
    body.load(contacts, &mut load, &mut ElasticWorkspace::default()).unwrap();
    load
}

fn strike(lattice: &Lattice, contacts: &[ContactLoad], driving: DrivingEnergy) -> Vec<f64> {
    let body = free(lattice, 0.25);
    energies(&body, lattice, &load(&body, contacts).forces, driving)
}

/// Largest difference relative to the largest value.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let greatest = a.iter().fold(0.0, |greatest: f64, value| greatest.max(value.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / greatest
}
