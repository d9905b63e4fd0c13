//! Positions of the cracks: planes, triple lines, quadruple points.

use super::support::*;
use crate::lattice::{Lattice, block};
use crate::tessellation::barycentric::edge_margin;
use crate::tessellation::*;
use nalgebra::{Matrix3, Point3, Vector3};

/// Signed distance of `place` from the bisector of `a` and `b`, positive on the side of `b`.
fn beyond(place: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    (place - nalgebra::center(a, b)).dot(&(b - a).normalize())
}

fn check_plane(lattice: &Lattice, offset: f64) {
    let sites = [Point3::new(offset - 0.1, 0.0, 0.0), Point3::new(offset + 0.1, 0.0, 0.0)];
    let emitted = Voronoi::new(lattice, &sites).check(lattice);
    let tessellation = &emitted.tessellation;
    assert_eq!(tessellation.fragments().len(), 2);
    for run in tessellation.runs().iter().filter(|run| run.neighbor.is_some()) {
        assert!(tessellation.run_vertices(run).iter().all(|vertex| (vertex.x - offset).abs() < 1e-12));
    }
    let (low, section) = (-0.3, 0.4 * 0.4);
    assert!((emitted.properties[0].volume - (offset - low) * section).abs() < 1e-12);
    assert!((emitted.properties[0].center.x - (offset + low) / 2.0).abs() < 1e-12);
}

#[test]
fn two_sites_are_parted_by_their_bisector() {
    let lattice = block([6, 4, 4], 0.1);
    for offset in [0.02, -0.13, 0.171] {
        check_plane(&lattice, offset);
    }
}

#[test]
fn unclamped_points_of_a_voronoi_diagram_lie_on_all_their_bisectors() {
    let lattice = wobbly([6, 6, 6], 1);
    let topology = Topology::new(&lattice);
    let voronoi = Voronoi::new(&lattice, &random_points(20, 0.25, 1));
    voronoi.check(&lattice);
    let labels = &voronoi.split.labels;
    let points =
        crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &FixedPoints::default()).unwrap().to_fixed();
    let free = |nodes: &[u32], place: &Point3<f64>| on_all_bisectors(&lattice, &voronoi, nodes, place);
    let free_edges = points.edges.iter().filter(|(edge, place)| free(&topology.edges[*edge as usize], place)).count();
    let free_faces = points.faces.iter().filter(|(face, place)| free(&topology.faces[*face as usize], place)).count();
    let free_tets = points.tets.iter().filter(|(tet, place)| free(&lattice.tets[*tet as usize], place)).count();
    // Most edge points, many face points and a few tetrahedron points are free.
    assert!(free_edges > points.edges.len() * 9 / 10, "{free_edges} of {}", points.edges.len());
    assert!(free_faces > points.faces.len() / 3, "{free_faces} of {}", points.faces.len());
    assert!(free_tets > 0, "none of {}", points.tets.len());
}

/// Asserts that `place` is inside its simplex by the margin and, unless it was moved inside, on the bisectors of its
/// nodes' sites.
///
/// Returns true if it was not moved.
fn on_all_bisectors(lattice: &Lattice, voronoi: &Voronoi, nodes: &[u32], place: &Point3<f64>) -> bool {
    let weights = barycentric_of(lattice, nodes, place);
    let margin = match *nodes {
        [a, b] => edge_margin((lattice.nodes[a as usize] - lattice.nodes[b as usize]).norm()),
        _ => MARGIN,
    };
    assert!(weights.iter().all(|&weight| weight > margin - 1e-12), "{weights:?}");
    let free = weights.iter().all(|&weight| weight > margin + 1e-9);
    let site = |node: u32| voronoi.site(voronoi.split.labels[node as usize]);
    for &other in &nodes[1..] {
        let away = beyond(place, &site(nodes[0]), &site(other));
        assert!(!free || away.abs() < 1e-12, "{away:e}");
    }
    free
}

/// Barycentric coordinates of a point of an edge, face or tetrahedron, by least squares.
fn barycentric_of(lattice: &Lattice, nodes: &[u32], place: &Point3<f64>) -> Vec<f64> {
    let base = lattice.nodes[nodes[0] as usize];
    let spans: Vec<Vector3<f64>> = nodes[1..].iter().map(|&node| lattice.nodes[node as usize] - base).collect();
    let matrix = nalgebra::Matrix3xX::from_columns(&spans);
    let rest = (matrix.transpose() * &matrix).cholesky().unwrap().solve(&(matrix.transpose() * (place - base)));
    assert!((&matrix * &rest - (place - base)).norm() < 1e-14, "in its simplex");
    std::iter::once(1.0 - rest.sum()).chain(rest.iter().copied()).collect()
}

#[test]
fn three_sites_meet_on_their_triple_line() {
    let lattice = block([5, 5, 2], 0.1);
    // Equidistant from all three: the line x = 0.013, y = −0.021.
    let sites: Vec<Point3<f64>> = [0.3f64, 2.2, 4.4]
        .iter()
        .map(|angle| Point3::new(0.013 + 0.2 * angle.cos(), -0.021 + 0.2 * angle.sin(), 0.0))
        .collect();
    let voronoi = Voronoi::new(&lattice, &sites);
    let emitted = voronoi.check(&lattice);
    assert_eq!(emitted.tessellation.fragments().len(), 3);
    let topology = Topology::new(&lattice);
    let labels = &voronoi.split.labels;
    let points = crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &FixedPoints::default()).unwrap();
    let faces = points.to_fixed().faces;
    let on_line = |place: &Point3<f64>| (place.x - 0.013).hypot(place.y + 0.021) < 1e-12;
    let free = faces.iter().filter(|(_, place)| on_line(place)).count();
    assert!(free >= 4, "{free} of {}", faces.len());
    // Every fragment has one outer run and one run per other fragment.
    assert!(emitted.tessellation.fragments().iter().all(|fragment| fragment.runs.len() == 3));
}

#[test]
fn four_sites_meet_in_their_quadruple_point() {
    let lattice = block([2, 2, 2], 0.2);
    let corners = lattice.corners(7);
    let center = Point3::from(corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0);
    let aim = center + (corners[0] - center) * 0.2;
    // Four points at equal distance from `aim`, each in the direction of a node.
    let sites: Vec<Point3<f64>> = corners.iter().map(|corner| aim + (corner - aim).normalize() * 0.05).collect();
    let rows = [1, 2, 3].map(|k| (sites[k] - sites[0]).transpose());
    assert!(Matrix3::from_rows(&rows).determinant().abs() > 1e-6);
    let voronoi = Voronoi::new(&lattice, &sites);
    voronoi.check(&lattice);
    let topology = Topology::new(&lattice);
    let labels = &voronoi.split.labels;
    let points = crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &FixedPoints::default()).unwrap();
    let tets = points.to_fixed().tets;
    assert!(tets.iter().any(|(tet, place)| *tet == 7 && (place - aim).norm() < 1e-12), "{tets:?} {aim}");
}

#[test]
fn a_single_label_gives_the_lattices_boundary() {
    let lattice = wobbly([3, 2, 2], 9);
    let emitted = check(&lattice, &vec![0; lattice.nodes.len()], None);
    let [run] = emitted.tessellation.runs() else { panic!("one run") };
    assert_eq!((run.neighbor, emitted.merges.len()), (None, 0));
    let vertices = emitted.tessellation.run_vertices(run);
    let found: Vec<[Point3<f64>; 3]> = emitted
        .tessellation
        .run_triangles(run)
        .map(|triangle| triangle.map(|vertex| vertices[vertex as usize]))
        .collect();
    let expected: Vec<[Point3<f64>; 3]> =
        lattice.boundary().iter().map(|face| face.nodes.map(|node| lattice.nodes[node as usize])).collect();
    assert_eq!(found, expected);
}
