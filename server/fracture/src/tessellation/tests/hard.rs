//! Hard cases: ties, points at the ends of edges, exterior triple and quadruple points, values that are not finite.

use super::support::*;
use crate::lattice::{Lattice, block};
use crate::lift::LiftedLattice;
use crate::tessellation::*;
use nalgebra::{Point3, Vector3};

#[test]
fn bisectors_through_nodes_are_moved_off_them() {
    let lattice = block([4, 4, 4], 0.1);
    // The bisectors x = 0, y = 0, z = 0 contain whole layers of nodes; ties go to the lower site.
    let mut sites = Vec::new();
    for corner in 0..8 {
        let side = |bit: usize| if corner >> bit & 1 == 0 { -0.1 } else { 0.1 };
        sites.push(Point3::new(side(0), side(1), side(2)));
    }
    let emitted = Voronoi::new(&lattice, &sites).check(&lattice);
    assert_eq!(emitted.properties.len(), 8);
    assert!(emitted.properties.iter().all(|properties| (properties.volume * 8.0 / 0.064 - 1.0).abs() < 0.06));
}

#[test]
fn coincident_and_symmetric_sites_stay_closed() {
    let lattice = block([3, 3, 3], 0.1);
    let center = Point3::origin();
    let twins = Voronoi::new(&lattice, &[center, center, center]);
    assert_eq!(twins.split.sites, [0], "ties to the lowest");
    twins.check(&lattice);
    // Labels with different sites at one position have no bisector.
    let labels = random_labels(lattice.nodes.len(), 3, 7);
    check(&lattice, &labels, Some(BisectorSites { of_fragment: &[0, 1, 2], ..twins.sites() }));
    let on_nodes: Vec<Point3<f64>> = lattice.nodes.clone();
    Voronoi::new(&lattice, &on_nodes).check(&lattice);
}

#[test]
fn exterior_points_are_kept_inside_by_the_margin() {
    let lattice = wobbly([2, 2, 2], 11);
    let topology = Topology::new(&lattice);
    let mut seen = 0;
    for seed in 0..20 {
        let (lift, coordinates) = random_lift(&lattice, 4, 6, seed);
        let labels = random_labels(lattice.nodes.len(), 6, seed);
        let sites =
            BisectorSites { lift: &lift, coordinates: &coordinates, of_fragment: &[0, 1, 2, 3, 4, 5], of_node: None };
        let points = crack_points(&lattice, &topology, &labels, Some(sites), &FixedPoints::default()).unwrap();
        for (tet, place) in points.to_fixed().tets {
            let [a, b, c, d] = lattice.corners(tet as usize);
            let volume =
                |a: Point3<f64>, b: Point3<f64>, c: Point3<f64>, d: Point3<f64>| (b - a).cross(&(c - a)).dot(&(d - a));
            let whole = volume(a, b, c, d);
            let weights =
                [volume(place, b, c, d), volume(a, place, c, d), volume(a, b, place, d), volume(a, b, c, place)];
            assert!(weights.iter().all(|weight| weight / whole > MARGIN - 1e-12));
            seen += usize::from(weights.iter().any(|weight| weight / whole < MARGIN + 1e-12));
        }
        check(&lattice, &labels, Some(sites));
    }
    assert!(seen > 50, "{seen} kept inside");
}

#[test]
fn nan_inputs_do_not_reach_the_result() {
    let lattice = wobbly([2, 2, 2], 4);
    let labels = random_labels(lattice.nodes.len(), 4, 4);
    for poison in [f64::NAN, f64::INFINITY, 1e300, 1e-300, 0.0] {
        let mut lift = LiftedLattice::euclidean(&lattice);
        lift.coordinates.iter_mut().step_by(5).for_each(|x| *x = poison);
        let coordinates = [0.1, poison, 0.2, 0.0, 0.0, 0.0, poison, poison, poison, 0.3, 0.1, -0.1];
        check(
            &lattice,
            &labels,
            Some(BisectorSites { lift: &lift, coordinates: &coordinates, of_fragment: &[0, 1, 2, 3], of_node: None }),
        );
    }
}

#[test]
fn fixed_points_are_taken_as_they_are() {
    let lattice = wobbly([3, 3, 2], 6);
    let topology = Topology::new(&lattice);
    let voronoi = Voronoi::new(&lattice, &random_points(6, 0.2, 6));
    let labels = &voronoi.split.labels;
    let middles = crack_points(&lattice, &topology, labels, None, &FixedPoints::default()).unwrap();
    let mut fixed = middles.to_fixed();
    let kept = crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &fixed).unwrap();
    assert_eq!(kept, middles, "all fixed: the sites have no effect");
    fixed.edges.truncate(10);
    fixed.faces.clear();
    let mixed = crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &fixed).unwrap().to_fixed();
    assert_eq!(mixed.edges[..10], fixed.edges[..]);
    assert_eq!(mixed.tets, fixed.tets);
    assert_ne!(mixed.edges[10..], middles.to_fixed().edges[10..]);
    let points = crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &fixed).unwrap();
    check_emitted(&lattice, &emit(tessellate(&lattice, &topology, labels, &points).unwrap(), 3.5));
}

#[test]
fn a_second_generation_keeps_the_edge_points_of_the_first() {
    let lattice = wobbly([4, 4, 4], 8);
    let topology = Topology::new(&lattice);
    let parents = Voronoi::new(&lattice, &random_points(3, 0.2, 8));
    let none = FixedPoints::default();
    let first = crack_points(&lattice, &topology, &parents.split.labels, Some(parents.sites()), &none).unwrap();
    let first = first.to_fixed();
    // Children: the labels of the parents and of a second diagram combined.
    let second = Voronoi::new(&lattice, &random_points(5, 0.2, 9));
    let both: Vec<u32> =
        parents.split.labels.iter().zip(&second.split.labels).map(|(parent, child)| parent * 100 + child).collect();
    let children = components(&topology, &both);
    let points = crack_points(&lattice, &topology, &children.labels, None, &first).unwrap();
    let kept = points.to_fixed();
    assert!(first.edges.iter().all(|point| kept.edges.contains(point)));
    check_emitted(&lattice, &emit(tessellate(&lattice, &topology, &children.labels, &points).unwrap(), 3.5));
}

#[test]
fn fixed_points_that_do_not_fit_are_refused_by_name() {
    let lattice = block([1, 1, 1], 0.5);
    let topology = Topology::new(&lattice);
    let labels = random_labels(topology.nodes, 4, 2);
    let attempt = |fixed: &FixedPoints| crack_points(&lattice, &topology, &labels, None, fixed).map(|_| ());
    let far = u32::MAX - 1;
    let (fine, not_finite) = (Point3::origin(), Point3::new(0.0, f64::NAN, 0.0));
    for (index, place) in [(far, fine), (3, not_finite)] {
        let point = vec![(index, place)];
        let edges = FixedPoints { edges: point.clone(), ..FixedPoints::default() };
        assert_eq!(attempt(&edges), Err(TessellationError::FixedEdge { edge: index }));
        let faces = FixedPoints { faces: point.clone(), ..FixedPoints::default() };
        assert_eq!(attempt(&faces), Err(TessellationError::FixedFace { face: index }));
        let tets = FixedPoints { tets: point, ..FixedPoints::default() };
        assert_eq!(attempt(&tets), Err(TessellationError::FixedTet { tet: index }));
    }
}

#[test]
fn any_scale_stays_closed() {
    let lattice = wobbly([3, 3, 3], 2);
    let topology = Topology::new(&lattice);
    let labels = random_labels(topology.nodes, 5, 2);
    let points = crack_points(&lattice, &topology, &labels, None, &FixedPoints::default()).unwrap();
    for meters_per_unit in [1e-6, 1.0, 1e6] {
        let emitted = emit(tessellate(&lattice, &topology, &labels, &points).unwrap(), meters_per_unit);
        for fragment in emitted.tessellation.fragments() {
            let indices = &emitted.indices[3 * fragment.triangles.start..3 * fragment.triangles.end];
            crate::fragment::closed(&emitted.positions[fragment.vertices.clone()], indices).unwrap();
        }
    }
}

/// An octahedron whose two halves touch in an almost flat tetrahedron, with an edge of each half as its diagonals.
fn octahedron_around_a_flat_tetrahedron(half_height: f64, stretch: f64) -> Lattice {
    let nodes = [
        [0.3, 0.0, half_height],
        [0.0, 0.3 * stretch, -half_height],
        [-0.3 * stretch, 0.0, half_height],
        [0.0, -0.3, -half_height],
        [0.01, 0.02, 0.4],
        [0.0, 0.03, -0.4],
    ];
    let [above, below] = [4, 5];
    oriented(nodes, &[[0, 1, 2, 3], [0, 2, 1, above], [0, 2, 3, above], [1, 3, 0, below], [1, 3, 2, below]])
}

/// A lattice of these tetrahedra, with their nodes in the order that makes their volumes positive.
fn oriented(nodes: [[f64; 3]; 6], tets: &[[u32; 4]]) -> Lattice {
    let nodes = nodes.map(Point3::from).to_vec();
    let volume = |[a, b, c, d]: [u32; 4]| {
        let [a, b, c, d] = [a, b, c, d].map(|node| nodes[node as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a))
    };
    let turned = |&[a, b, c, d]: &[u32; 4]| if volume([a, b, c, d]) > 0.0 { [a, b, c, d] } else { [b, a, c, d] };
    let tets = tets.iter().map(turned).collect();
    Lattice { nodes, tets }
}

#[test]
fn crack_points_on_the_crossing_edges_of_a_flat_tetrahedron_stay_apart() {
    for (half_height, stretch) in [(1e-9, 1.0), (1e-7, 1.0), (1e-6, 1.0), (4e-6, 1.0), (1e-8, 0.5), (1e-8, 0.9)] {
        let lattice = octahedron_around_a_flat_tetrahedron(half_height, stretch);
        // All labelings with up to three labels.
        for code in 0..3_u32.pow(6) {
            let labels: Vec<u32> = (0..6).map(|node| code / 3_u32.pow(node) % 3).collect();
            check(&lattice, &labels, None);
        }
        // The bisector between the first two sites passes through the crossing.
        let center = lattice.nodes[..4].iter().map(|node| node.coords).sum::<Vector3<f64>>() / 4.0;
        for k in 0..200 {
            let angle = 0.1 * f64::from(k);
            let aside = Vector3::new(angle.cos(), angle.sin(), 0.0) * 0.2;
            let sites = [Point3::from(center + aside), Point3::from(center - aside)];
            Voronoi::new(&lattice, &sites).check(&lattice);
        }
    }
}

/// Two halves that touch in two needles: three nodes lie almost on a line, and the edge between the outer two is inside.
fn halves_around_needles(height: f64) -> Lattice {
    let nodes = [
        [-0.3, 0.0, 0.0],
        [0.02, 0.0, height],
        [0.3, 0.0, 0.0],
        [0.01, 0.3, 0.0],
        [0.02, -0.3, 0.0],
        [0.0, 0.02, -0.4],
    ];
    oriented(nodes, &[[0, 1, 2, 3], [0, 1, 2, 4], [0, 2, 3, 5], [0, 2, 4, 5]])
}

#[test]
fn crack_points_on_the_overlapping_edges_of_a_needle_stay_apart() {
    for height in [1e-12, 1e-9, 1e-7, 1e-6] {
        let lattice = halves_around_needles(height);
        for k in -28..=28 {
            // The bisector crosses the long edge and one of the short ones in one place.
            let center = Vector3::new(0.01 * f64::from(k), 0.003, 0.0);
            let aside = Vector3::new(0.2, 0.01, 0.0);
            let sites = [Point3::from(center + aside), Point3::from(center - aside)];
            Voronoi::new(&lattice, &sites).check(&lattice);
        }
    }
}

/// A short tetrahedron with small angles at its first node, beside large ones, from whose center that node is far.
#[test]
fn crack_points_near_a_node_with_small_angles_stay_apart() {
    for angle in [1e-4, 1e-3, 0.01] {
        let nodes = [
            [0.0, 0.0, 0.0],
            [0.02, 0.0, 0.0],
            [0.02, 0.02 * angle, 0.0],
            [0.02, 0.01 * angle, 0.015 * angle],
            [0.3, 0.0, -0.4],
            [0.3, -0.5, 0.1],
        ];
        let lattice = oriented(nodes, &[[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 4, 5]]);
        for k in -20..20 {
            // The bisector passes the first node at a distance that is less than that of crack points.
            let center = Vector3::new(1e-7 * f64::from(k), 0.0, 0.0);
            let aside = Vector3::new(0.2, -0.1, -0.1);
            let sites = [Point3::from(center + aside), Point3::from(center - aside)];
            Voronoi::new(&lattice, &sites).check(&lattice);
        }
    }
}
