use super::*;
use crate::cancel_token::CancelToken;
use crate::lattice::Spacings;
use crate::lattice::shapes::{ball, cuboid};
use crate::lattice::{BodyLattice, SignedDistance, block, levels, stuff};
use nalgebra::Isometry3;

fn body(shape: &dyn SignedDistance, spacing: f64) -> Lattice {
    stuff(shape, spacing, None, &CancelToken::default()).unwrap().bodies.remove(0)
}

/// Ball of radius 0.3 at two levels of equal volume, as from [`crate::lattice::levels`].
fn pair(spacing: f64) -> BodyLattice {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.3f64.powi(3);
    let mut both = levels(
        &ball(0.3),
        Spacings { elastic: spacing, crack: 0.63 * spacing, refine: false, fits_elastic: false },
        volume,
        &CancelToken::default(),
    )
    .unwrap();
    both.bodies.remove(0)
}

/// Energy of each elastic tetrahedron for a density linear in space: volume times density at the centroid.
fn energies(lattice: &Lattice, density: &dyn Fn(Vector3<f64>) -> f64) -> Vec<f64> {
    let centroid = |tet| lattice.corners(tet).iter().map(|c| c.coords).sum::<Vector3<f64>>() / 4.0;
    (0..lattice.tets.len()).map(|tet| lattice.tet_volume(tet) * density(centroid(tet))).collect()
}

/// Nodes well inside a ball of radius 0.3 at all spacings used here.
fn interior(lattice: &Lattice) -> Vec<usize> {
    (0..lattice.nodes.len()).filter(|&node| lattice.nodes[node].coords.norm() < 0.12).collect()
}

/// Errors of the transferred density on interior nodes.
///
/// Returns its mean and largest relative error, and the error of sampling the density of the
/// elastic tetrahedron at the node.
fn errors(pair: &BodyLattice, density: &dyn Fn(Vector3<f64>) -> f64) -> [f64; 3] {
    let mut nodes = Vec::new();
    pair.transfer.apply(&energies(&pair.elastic, density), &mut nodes);
    let volumes = pair.crack.node_volumes();
    let locator = Locator::new(&pair.elastic);
    let coarse = energies(&pair.elastic, density);
    let (mut mean, mut largest, mut sampled) = (0.0, 0.0f64, 0.0);
    let interior = interior(&pair.crack);
    for &node in &interior {
        let place = pair.crack.nodes[node];
        let exact = density(place.coords);
        let error = (nodes[node] / volumes[node] / exact - 1.0).abs();
        let tet = locator.locate(&place, None).unwrap().tet as usize;
        sampled += (coarse[tet] / pair.elastic.tet_volume(tet) / exact - 1.0).abs();
        mean += error;
        largest = largest.max(error);
    }
    let count = interior.len() as f64;
    [mean / count, largest, sampled / count]
}

fn check(transfer: &EnergyTransfer, elastic: &Lattice, crack: &Lattice) {
    let mut totals = vec![0.0; elastic.tets.len()];
    for (&tet, share) in transfer.tets.iter().zip(&transfer.shares) {
        assert!(*share > 0.0 && *share <= 1.0);
        totals[tet as usize] += share;
    }
    assert!(totals.iter().all(|total| (total - 1.0).abs() < 1e-14));
    assert_eq!(transfer.offsets.len(), crack.nodes.len() + 1);
    for row in transfer.offsets.windows(2) {
        assert!(transfer.tets[row[0] as usize..row[1] as usize].windows(2).all(|pair| pair[0] < pair[1]));
    }
    let energy: Vec<f64> = (0..elastic.tets.len()).map(|tet| 10f64.powi(tet as i32 % 9 - 4)).collect();
    let mut nodes = vec![7.0; 3];
    transfer.apply(&energy, &mut nodes);
    let (from, to): (f64, f64) = (energy.iter().sum(), nodes.iter().sum());
    assert!((to / from - 1.0).abs() < 1e-12);
}

#[test]
fn the_energy_is_conserved_whatever_the_lattices() {
    let shape = ball(0.3);
    let turned = cuboid(Vector3::new(0.4, 0.08, 0.2), Isometry3::rotation(Vector3::new(0.4, 0.2, 0.9)));
    let lattices = [body(&shape, 0.1), body(&shape, 0.06), body(&turned, 0.06), block([2, 2, 2], 0.1)];
    for elastic in &lattices {
        for crack in &lattices {
            check(&EnergyTransfer::between(elastic, crack), elastic, crack);
        }
        check(&EnergyTransfer::identity(elastic), elastic, elastic);
    }
}

#[test]
fn a_uniform_density_stays_nearly_uniform() {
    let pair = pair(0.08);
    let [mean, largest, _] = errors(&pair, &|_| 1.0);
    println!("uniform: mean {mean:.4} largest {largest:.4}");
    assert!(mean < 1e-6 && largest < 1e-4, "{mean} {largest}");
}

#[test]
fn a_linear_density_converges_and_beats_sampling() {
    let density = |x: Vector3<f64>| 1.0 + 2.0 * x.x - x.z;
    let mut before = f64::INFINITY;
    for spacing in [0.1, 0.05, 0.025] {
        let [mean, largest, sampled] = errors(&pair(spacing), &density);
        println!("linear, spacing {spacing}: mean {mean:.4} largest {largest:.4} sampled {sampled:.4}");
        assert!(mean < 0.5 * sampled && mean < 0.7 * before);
        before = mean;
    }
}

#[test]
fn identity_gives_each_corner_a_quarter() {
    let lattice = block([2, 1, 1], 0.5);
    let transfer = EnergyTransfer::identity(&lattice);
    let volumes: Vec<f64> = (0..lattice.tets.len()).map(|tet| lattice.tet_volume(tet)).collect();
    let mut nodes = Vec::new();
    transfer.apply(&volumes, &mut nodes);
    assert!(nodes.iter().zip(lattice.node_volumes()).all(|(a, b)| (a - b).abs() < 1e-15));
}

#[test]
fn nodes_take_the_density_of_one_tetrahedron() {
    let lattice = block([2, 2, 2], 0.1);
    let [density, volumes] = [7.0, 0.3].map(|scale| move |node: usize| scale * (1.0 + node as f64));
    let energies: Vec<f64> = (0..lattice.tets.len()).map(|tet| density(tet) * lattice.tet_volume(tet)).collect();
    let sources = [Some(3), None, Some(0), Some(3)];
    let source =
        |(node, tet): (usize, Option<usize>)| tet.map(|tet| (tet as u32, volumes(node) / lattice.tet_volume(tet)));
    let transfer = EnergyTransfer::of_densities(sources.into_iter().enumerate().map(source));
    let mut found = Vec::new();
    transfer.apply(&energies, &mut found);
    for ((node, tet), found) in sources.into_iter().enumerate().zip(found) {
        let wanted = tet.map_or(0.0, |tet| density(tet) * volumes(node));
        assert!((found - wanted).abs() <= 1e-12 * wanted, "node {node}: {found} for {wanted}");
    }
}
