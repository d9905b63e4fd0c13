//! The guarantee of the tessellation: every fragment is closed for any input.

use super::support::*;
use crate::lattice::Lattice;
use crate::random::RandomStream;
use crate::tessellation::*;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn cells() -> impl Strategy<Value = [usize; 3]> {
    [1usize..4, 1usize..4, 1usize..4]
}

/// Labels of the connected components of random labels, as in a request.
fn split(lattice: &Lattice, labels: &[u32]) -> Components {
    components(&Topology::new(lattice), labels)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_labels_give_closed_fragments(cells in cells(), count in 2usize..21, seed: u64) {
        let lattice = wobbly(cells, seed);
        check(&lattice, &random_labels(lattice.nodes.len(), count, seed), None);
    }

    #[test]
    fn random_lifts_and_sites_give_closed_fragments(
        cells in cells(), count in 2usize..21, dimension in 3usize..9, seed: u64,
    ) {
        let lattice = wobbly(cells, seed);
        let (lift, sites) = random_lift(&lattice, dimension, count, seed);
        // Labels unrelated to the sites, so that zeros are anywhere.
        let wild = split(&lattice, &random_labels(lattice.nodes.len(), count, seed));
        check(&lattice, &wild.labels, Some(BisectorSites { lift: &lift, coordinates: &sites, of_fragment: &wild.sites, of_node: None }));
        let cells = split(&lattice, &nearest(&lift, &sites));
        check(&lattice, &cells.labels, Some(BisectorSites { lift: &lift, coordinates: &sites, of_fragment: &cells.sites, of_node: None }));
    }

    #[test]
    fn voronoi_diagrams_give_closed_fragments(cells in cells(), count in 2usize..21, seed: u64) {
        let lattice = wobbly(cells, seed);
        Voronoi::new(&lattice, &random_points(count, 0.25, seed)).check(&lattice);
    }

    #[test]
    fn lattices_with_handles_and_corners_do_too(count in 2usize..21, seed: u64) {
        let ring = carved([3, 3, 1], 0.15, |center| center.x.abs() > 0.1 || center.y.abs() > 0.1);
        check(&ring, &random_labels(ring.nodes.len(), count, seed), None);
        let bent = carved([3, 3, 2], 0.15, |center| center.x < 0.1 || center.y < 0.1 || center.z < 0.0);
        Voronoi::new(&bent, &random_points(count, 0.25, seed)).check(&bent);
    }
}

#[test]
fn a_cavity_is_closed_too() {
    let hollow = carved([3, 3, 3], 0.15, |center| center.coords.amax() > 0.1);
    let whole = check(&hollow, &vec![0; hollow.nodes.len()], None);
    assert_eq!(whole.tessellation.runs().len(), 1);
    for seed in 0..10 {
        check(&hollow, &random_labels(hollow.nodes.len(), 6, seed), None);
    }
}

#[test]
fn every_node_on_its_own_is_a_fragment() {
    let lattice = wobbly([3, 2, 2], 5);
    let labels: Vec<u32> = (0..lattice.nodes.len() as u32).collect();
    let emitted = check(&lattice, &labels, None);
    assert!(emitted.properties.iter().all(|properties| properties.volume > 0.0));
    let (lift, sites) = random_lift(&lattice, 5, labels.len(), 5);
    check(
        &lattice,
        &labels,
        Some(BisectorSites { lift: &lift, coordinates: &sites, of_fragment: &labels, of_node: None }),
    );
}

/// A point of the simplex `nodes`, inside by the margin, often in a corner.
fn extreme(lattice: &Lattice, nodes: &[u32], random: &mut RandomStream) -> Point3<f64> {
    let count = nodes.len();
    let chosen = (random.uniform() * count as f64) as usize;
    let corner = random.uniform() < 0.6;
    let raw: Vec<f64> =
        (0..count).map(|k| if corner { f64::from(u8::from(k == chosen)) } else { random.uniform() }).collect();
    let (sum, room) = (raw.iter().sum::<f64>(), 1.0 - count as f64 * MARGIN);
    let weights = raw.iter().map(|x| MARGIN + room * x / sum);
    Point3::from(
        nodes.iter().zip(weights).map(|(&node, w)| lattice.nodes[node as usize].coords * w).sum::<Vector3<f64>>(),
    )
}

#[test]
fn every_part_of_a_tetrahedron_is_positive_wherever_its_points_are() {
    let nodes = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.3, 0.2, 0.8]].map(Point3::from);
    let lattice = Lattice { nodes: nodes.to_vec(), tets: vec![[0, 1, 2, 3]] };
    let topology = Topology::new(&lattice);
    let mut random = RandomStream::new(1, 5);
    for round in 0..6000 {
        let labels = random_labels(4, 2 + round % 3, round as u64);
        let mut points = |simplices: &[&[u32]]| -> Vec<(u32, Point3<f64>)> {
            (0..).zip(simplices).map(|(index, nodes)| (index, extreme(&lattice, nodes, &mut random))).collect()
        };
        let edges: Vec<&[u32]> = topology.edges.iter().map(|edge| &edge[..]).collect();
        let faces: Vec<&[u32]> = topology.faces.iter().map(|face| &face[..]).collect();
        let fixed = FixedPoints { edges: points(&edges), faces: points(&faces), tets: points(&[&lattice.tets[0]]) };
        let points = crack_points(&lattice, &topology, &labels, None, &fixed).unwrap();
        check_emitted(&lattice, &emit(tessellate(&lattice, &topology, &labels, &points).unwrap(), 3.5));
    }
}
