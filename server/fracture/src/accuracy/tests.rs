use super::*;
use crate::cancel_token::CancelToken;
use crate::centroidal::{self, DiagramWorkspace, EnergyField};
use crate::lattice::{Lattice, LatticePoint, Locator, block};
use crate::lift::{LiftedLattice, interior};
use crate::random::RandomStream;
use crate::reference::perturbed;
use crate::tessellation::Topology;
use nalgebra::{Isometry3, Point3, Vector3};

/// Sites of the Euclidean lift of `lattice` at these positions.
fn sites(lift: &LiftedLattice, lattice: &Lattice, places: &[[f64; 3]]) -> Vec<f64> {
    // The lift of a lattice is scaled to mean 1, up to rounding.
    let scale = lift.at(0)[0] / lattice.nodes[0].x;
    places.iter().flatten().map(|x| x * scale).collect()
}

fn area(exact: &ExactCells) -> f64 {
    exact.triangles.iter().map(|triangle| crate::lattice::area_vector(triangle).norm()).sum()
}

/// Cube of side 1 with perturbed inner nodes.
fn cube() -> Lattice {
    perturbed([5; 3], 0.2, 0.1, 3)
}

/// Checks the exact cells of a cube for sites at these positions: volumes and area of the cracks.
#[track_caller]
fn check(places: &[[f64; 3]], volumes: &[f64], cracks: f64) {
    let lattice = cube();
    let lift = LiftedLattice::euclidean(&lattice);
    let found = exact(&lattice, &lift, &sites(&lift, &lattice, places), &CancelToken::default()).unwrap();
    for (volume, wanted) in found.volumes.iter().zip(volumes) {
        assert!((volume - wanted).abs() < 1e-12, "{:?}", found.volumes);
    }
    assert!((area(&found) - cracks).abs() < 1e-12, "{} of {cracks}", area(&found));
    assert!((found.volumes.iter().sum::<f64>() - lattice.volume()).abs() < 1e-12);
    assert!(found.pairs.iter().all(|[low, high]| low < high));
}

#[test]
fn cells_of_a_cube_are_what_geometry_says() {
    check(&[[0.1, 0.2, 0.3]], &[1.0], 0.0);
    // A plane at x = 0.11.
    check(&[[-0.18, 0.1, 0.2], [0.4, 0.1, 0.2]], &[0.61, 0.39], 1.0);
    // Four quarters about one line, off the nodes; the two planes cross each other.
    let quarters = [[-0.2, -0.2], [0.26, -0.2], [-0.2, 0.22], [0.26, 0.22]].map(|[x, y]| [x, y, 0.1]);
    let (low, high) = ([0.53, 0.51], [0.47, 0.49]);
    check(&quarters, &[low[0] * low[1], high[0] * low[1], low[0] * high[1], high[0] * high[1]], 2.0);
    let octant = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|side| if side == 0 { -0.2 } else { 0.26 });
    let side = |bit: usize| if bit == 0 { 0.53 } else { 0.47 };
    let octants: Vec<[f64; 3]> = (0..8).map(octant).collect();
    let volumes: Vec<f64> = (0..8).map(|k| side(k & 1) * side(k >> 1 & 1) * side(k >> 2)).collect();
    check(&octants, &volumes, 3.0);
}

#[test]
fn a_plane_through_nodes_counts_once_and_coincident_sites_do_not_share() {
    let lattice = block([4; 3], 0.25);
    let lift = LiftedLattice::euclidean(&lattice);
    let places = [[-0.25, 0.0, 0.0], [0.25, 0.0, 0.0], [0.25, 0.0, 0.0]];
    let found = exact(&lattice, &lift, &sites(&lift, &lattice, &places), &CancelToken::default()).unwrap();
    assert!((found.volumes[0] - 0.5).abs() < 1e-12 && (found.volumes[1] - 0.5).abs() < 1e-12);
    assert_eq!(found.volumes[2], 0.0);
    assert!((area(&found) - 1.0).abs() < 1e-12, "{}", area(&found));
}

#[test]
fn a_cell_without_a_node_appears() {
    let lattice = block([2; 3], 0.5);
    let lift = LiftedLattice::euclidean(&lattice);
    // A thin slab between node planes.
    let places = [[0.02, 0.0, 0.0], [0.12, 0.0, 0.0], [0.22, 0.0, 0.0]];
    let sites = sites(&lift, &lattice, &places);
    let labels = labels(&lattice, &lift, &sites);
    assert!(!labels.contains(&1), "no node is nearest to it");
    let found = exact(&lattice, &lift, &sites, &CancelToken::default()).unwrap();
    assert!((found.volumes[1] - 0.1).abs() < 1e-12, "{:?}", found.volumes);
    let topology = Topology::new(&lattice);
    let regions = Regions::new(&lattice, &topology, &lift, &sites, &labels).unwrap();
    let misplaced = misplaced(&regions, &lift, &sites, &CancelToken::default()).unwrap();
    assert!(misplaced.fraction >= 0.1 - 1e-12 && misplaced.volumes[1] == 0.0);
}

fn labels(lattice: &Lattice, lift: &LiftedLattice, sites: &[f64]) -> Vec<u32> {
    let (volumes, mut mass) = (lattice.node_volumes(), lattice.node_volumes());
    let field = EnergyField::new(lift, &volumes, &mut mass).unwrap();
    centroidal::assign(&field, sites, &mut DiagramWorkspace::default()).labels
}

/// Random sites near nodes of the lift, slightly off the body.
fn scattered(lift: &LiftedLattice, count: usize, seed: u64) -> Vec<f64> {
    let (mut stream, nodes) = (RandomStream::new(seed, 0), lift.second_moment.len());
    let mut site = || {
        let node = (stream.uniform() * nodes as f64) as usize;
        lift.at(node).iter().map(|x| x + 0.02 * (stream.uniform() - 0.5)).collect::<Vec<f64>>()
    };
    (0..count).flat_map(|_| site()).collect()
}

#[test]
fn volumes_add_up_and_do_not_depend_on_threads_or_the_frame() {
    let lattice = perturbed([6, 5, 4], 0.1, 0.1, 1);
    let lift = interior(&lattice, 8, 1.0, &CancelToken::default()).unwrap();
    let sites = scattered(&lift, 60, 2);
    let run = |threads: usize, lattice: &Lattice| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| exact(lattice, &lift, &sites, &CancelToken::default()).unwrap())
    };
    let found = run(1, &lattice);
    assert!((found.volumes.iter().sum::<f64>() / lattice.volume() - 1.0).abs() < 1e-12);
    assert_eq!(found, run(3, &lattice));
    let isometry = Isometry3::new(Vector3::new(0.1, -0.2, 0.05), Vector3::new(0.4, 1.1, -0.3));
    // The lift is the same function on the moved body.
    let moved = run(2, &lattice.transformed(&isometry));
    assert_eq!(moved.pairs, found.pairs);
    assert!(moved.volumes.iter().zip(&found.volumes).all(|(a, b)| (a - b).abs() < 1e-14));
    assert!((area(&moved) - area(&found)).abs() < 1e-12);
    let apart = |(a, b): (&Point3<f64>, &Point3<f64>)| (isometry * b - a).norm();
    let corners = moved.triangles.iter().flatten().zip(found.triangles.iter().flatten());
    assert!(corners.map(apart).all(|distance| distance < 1e-14));
}

/// Regions of the nodes' labels for random sites, with the exact diagram of the same sites.
fn compared(spacings: usize) -> (LabelErrors, f64, ExactCells, CrackDistance) {
    let h = 0.6 / spacings as f64;
    let lattice = perturbed([spacings; 3], h, 0.1, 5);
    let (lift, topology) = (LiftedLattice::euclidean(&lattice), Topology::new(&lattice));
    let mut stream = RandomStream::new(4, 0);
    let sites: Vec<f64> = (0..36).map(|_| 0.6 * (stream.uniform() - 0.5)).collect();
    let labels = labels(&lattice, &lift, &sites);
    let regions = Regions::new(&lattice, &topology, &lift, &sites, &labels).unwrap();
    let token = CancelToken::default();
    let exact = exact(&lattice, &lift, &sites, &token).unwrap();
    let given = |place: &LatticePoint| regions.label(place);
    let sampled = label_fraction(&lattice, &given, &lattice, &lift, &sites, &token).unwrap();
    let own = |place: &LatticePoint| nearest(&lattice, &lift, &sites, place).unwrap();
    assert_eq!(label_fraction(&lattice, &own, &lattice, &lift, &sites, &token).unwrap(), 0.0);
    let distance = crack_distance(&regions.cracks().unwrap(), &exact.triangles);
    (misplaced(&regions, &lift, &sites, &token).unwrap(), sampled, exact, distance)
}

#[test]
fn node_labels_err_less_on_finer_lattices_and_both_measures_agree() {
    let runs = [6, 12, 24].map(compared);
    for (misplaced, sampled, exact, distance) in &runs {
        assert!((misplaced.volumes.iter().sum::<f64>() / 0.216 - 1.0).abs() < 1e-10);
        assert!(misplaced.fraction > 0.0 && misplaced.fraction < 0.2);
        // One point per tetrahedron estimates it within a factor of two.
        assert!((0.5..2.0).contains(&(sampled / misplaced.fraction)), "{sampled} {}", misplaced.fraction);
        let l1 = volume_l1(&misplaced.volumes, &exact.volumes).unwrap();
        assert!(l1 <= 2.0 * misplaced.fraction + 1e-12, "misplaced volume is lost by one site and gained by another");
        assert!(distance.mean <= distance.max);
    }
    // Only tetrahedra around the triple lines have errors, which are of second order.
    let fall = |k: usize| runs[k].0.fraction / runs[k + 1].0.fraction;
    assert!(fall(0) > 2.5 && fall(1) > 2.5, "{} {}", fall(0), fall(1));
    assert!(runs[2].3.mean < runs[1].3.mean && runs[1].3.mean < runs[0].3.mean);
}

#[test]
fn two_sites_are_cut_exactly() {
    let lattice = cube();
    let (lift, topology) = (LiftedLattice::euclidean(&lattice), Topology::new(&lattice));
    let sites = sites(&lift, &lattice, &[[-0.19, 0.1, 0.2], [0.36, -0.11, 0.07]]);
    let labels = labels(&lattice, &lift, &sites);
    let regions = Regions::new(&lattice, &topology, &lift, &sites, &labels).unwrap();
    let exact = exact(&lattice, &lift, &sites, &CancelToken::default()).unwrap();
    let misplaced = misplaced(&regions, &lift, &sites, &CancelToken::default()).unwrap();
    // Except for points that the margin keeps off the nodes.
    assert!(misplaced.fraction < 1e-3, "{}", misplaced.fraction);
    assert!(volume_l1(&misplaced.volumes, &exact.volumes).unwrap() < 1e-3);
    assert!(crack_distance(&regions.cracks().unwrap(), &exact.triangles).mean < 1e-3);
}

#[test]
fn a_linear_lift_is_carried_exactly() {
    let (fine, coarse) = (block([8; 3], 0.1), block([4; 3], 0.2));
    let lift = LiftedLattice::euclidean(&fine);
    let found = carried(&lift, &fine, &Locator::new(&fine), &coarse);
    let own = LiftedLattice::euclidean(&coarse);
    assert!(found.coordinates.iter().zip(&own.coordinates).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn numbers_are_compared_as_their_formulas_say() {
    assert_eq!(energy_error(1.5, 2.0), 0.25);
    assert_eq!(degree_error(60.0, 48.0), 0.25);
    assert_eq!(cvd_gap(1.5, 1.0), 0.5);
    assert_eq!(density_error(&[1.0, 2.0, 3.0], &[2.0, 2.0, 4.0]).unwrap(), 0.25);
    assert_eq!(volume_l1(&[1.0, 3.0], &[2.0, 2.0]).unwrap(), 0.5);
    assert!(volume_l1(&[1.0], &[2.0, 2.0]).is_err() && density_error(&[], &[1.0]).is_err());
    // The order does not matter. A common shift of all sizes is the distance.
    assert_eq!(size_distance(&[3.0, 1.0], &[1.0, 3.0]), 0.0);
    assert_eq!(size_distance(&[2.0, 4.0], &[1.0, 3.0]), 0.5);
    // Twice the number of fragments of half the size: quantile functions 1 and 2.
    assert_eq!(size_distance(&[1.0; 6], &[2.0; 3]), 0.5);
    // [0, ½): 1 against 1, [½, ⅔): 3 against 1, [⅔, 1): 3 against 4, mean 2.
    assert!((size_distance(&[1.0, 3.0], &[1.0, 1.0, 4.0]) - (2.0 / 6.0 + 1.0 / 3.0) / 2.0).abs() < 1e-15);
    assert!(size_distance(&[], &[1.0]).is_infinite());
}

#[test]
fn distances_of_cracks_are_those_of_planes() {
    let square = |z: f64| {
        let at = |x: f64, y: f64| Point3::new(x, y, z);
        vec![[at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]]
    };
    let apart = crack_distance(&square(0.0), &square(0.25));
    assert!((apart.mean - 0.25).abs() < 1e-15 && (apart.max - 0.25).abs() < 1e-15);
    // One surface has an additional crack, of equal area, 0.5 above.
    let mut more = square(0.0);
    more.extend(square(0.5));
    let more = crack_distance(&more, &square(0.0));
    assert!((more.mean - 0.125).abs() < 1e-15 && (more.max - 0.5).abs() < 1e-15);
    assert!(crack_distance(&[], &square(0.0)).mean.is_infinite());
    assert_eq!(crack_distance(&[], &[]), CrackDistance::default());
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let lattice = block([2; 3], 0.5);
    let lift = LiftedLattice::euclidean(&lattice);
    let refused = |sites: &[f64]| exact(&lattice, &lift, sites, &CancelToken::default()).unwrap_err();
    assert_eq!(refused(&[]), AccuracyError::Length { array: "sites", expected: 3, found: 0 });
    assert_eq!(refused(&[0.0; 4]), AccuracyError::Length { array: "sites", expected: 3, found: 4 });
    let other = LiftedLattice::euclidean(&block([3; 3], 0.3));
    assert!(exact(&lattice, &other, &[0.0; 3], &CancelToken::default()).is_err());
}
