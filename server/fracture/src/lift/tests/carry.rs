//! Tests of barycentric coordinates: linear functions, weights, and cases in which a formula divides by zero.

use super::shapes::{ball, fork};
use super::surface::hollow;
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, block};
use crate::lift::mean_value::MeanValueWeights;
use crate::lift::{BoundarySurface, Extension, LiftError, carry_harmonic, carry_mean_value};
use nalgebra::{Isometry3, Point3, Vector3};

const BOTH: [Extension; 2] = [Extension::Harmonic, Extension::MeanValue];

fn carried(lattice: &Lattice, carry: Extension, values: &[f64], dimension: usize) -> Vec<f64> {
    let surface = BoundarySurface::new(lattice);
    carry.carry(lattice, &surface, values, dimension, &CancelToken::default()).unwrap()
}

/// Checks that extending the boundary's own positions yields the positions.
///
/// Distances that are Euclidean on the boundary stay Euclidean inside (Rustamov et al., section 3).
#[track_caller]
fn check_positions(lattice: &Lattice) {
    let surface = BoundarySurface::new(lattice);
    let values: Vec<f64> = surface.positions.iter().flat_map(|position| [position.x, position.y, position.z]).collect();
    let size = lattice.nodes.iter().map(|node| node.coords.norm()).fold(0.0, f64::max);
    for carry in BOTH {
        let inside = carried(lattice, carry, &values, 3);
        let error = |(x, node): (&[f64], &Point3<f64>)| (Point3::from_slice(x) - node).norm();
        let worst = inside.chunks(3).zip(&lattice.nodes).map(error).fold(0.0, f64::max);
        assert!(worst < 1e-12 * size, "{carry:?}: {worst:e}");
    }
}

#[test]
fn the_boundary_s_positions_carried_inside_are_the_positions() {
    let turn = Isometry3::new(Vector3::new(0.1, 0.2, -0.3), Vector3::new(0.4, -1.1, 0.7));
    for lattice in [block([4, 3, 2], 0.25), ball(6), fork(), hollow()] {
        check_positions(&lattice);
        check_positions(&lattice.transformed(&turn));
    }
}

/// Least weight, and largest deviation of a sum of weights from 1, over all interior nodes.
fn weights(lattice: &Lattice, carry: Extension) -> (f64, f64) {
    let count = BoundarySurface::new(lattice).nodes.len();
    let identity: Vec<f64> = (0..count * count).map(|at| f64::from(u8::from(at / count == at % count))).collect();
    let weights = carried(lattice, carry, &identity, count);
    let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
    let off = weights.chunks(count).map(|row| (row.iter().sum::<f64>() - 1.0).abs()).fold(0.0, f64::max);
    (least, off)
}

#[test]
fn weights_add_up_to_one_and_harmonic_ones_are_not_negative() {
    for lattice in [block([4, 3, 2], 0.25), ball(4), fork(), hollow()] {
        for carry in BOTH {
            let (least, off) = weights(&lattice, carry);
            println!("{carry:?}: least weight {least:.3e}, sums off by {off:.1e}");
            assert!(off < 1e-11, "{carry:?}: {off:e}");
            // No dihedral angle of a block is obtuse; those of the bent ball are.
            assert!(carry == Extension::MeanValue || least > -0.1, "{least:e}");
        }
    }
    assert!(weights(&fork(), Extension::Harmonic).0 >= -1e-15);
    // Mean value coordinates of a convex body are non-negative, too. A slot makes some negative.
    assert!(weights(&block([3; 3], 0.2), Extension::MeanValue).0 >= -1e-12);
    assert!(weights(&fork(), Extension::MeanValue).0 < -1e-6);
}

/// Value of f at `point`, extended by mean value coordinates from the surface of a unit cube.
fn blended(point: [f64; 3], f: impl Fn(&Point3<f64>) -> f64) -> f64 {
    let surface = BoundarySurface::new(&block([2; 3], 0.5));
    let values: Vec<f64> = surface.positions.iter().map(f).collect();
    let (mut weights, mut value) = (MeanValueWeights::new(&surface), [0.0]);
    weights.find(&Point3::from(point));
    weights.blend(&values, &mut value);
    value[0]
}

#[test]
fn on_a_face_an_edge_or_a_corner_mean_values_are_those_of_the_triangle() {
    // Linear on every triangle except near the corners; kinked between triangles.
    let f = |p: &Point3<f64>| p.x.abs() + 2.0 * p.y.abs() + 5.0 * f64::from(u8::from(p.z == 0.5 && p.x == 0.0));
    let corner = [0.5, 0.5, 0.5];
    assert!((blended(corner, f) - 1.5).abs() < 1e-15);
    // The surface's nodes are the corners and centers of squares of half the side.
    let on_edge: [f64; 3] = [0.5, 0.5, 0.4];
    let on_face: [f64; 3] = [0.5, 0.27, 0.21];
    for (point, bound) in [(on_edge, 1e-12), (on_face, 1e-12)] {
        let exact = point[0].abs() + 2.0 * point[1].abs();
        assert!((blended(point, f) - exact).abs() < bound, "{point:?}");
        // The value is approached continuously: the weights diverge on the way, their ratios do not.
        for depth in [1e-4, 1e-7, 1e-9, 1e-12, 1e-15] {
            let near = [point[0] - depth, point[1], point[2]];
            let error = (blended(near, f) - exact).abs();
            assert!(error < 10.0 * depth.max(1e-9), "{depth:e} below {point:?}: {error:e}");
        }
    }
}

#[test]
fn a_cube_s_center_sees_all_its_faces_alike() {
    let center = blended([0.0; 3], |p| f64::from(u8::from(p.z == 0.5)));
    let edges = blended([0.0; 3], |p| f64::from(u8::from(p.z == 0.5 && p.coords.xy().amax() == 0.5)));
    // A face has all of the weight of its inner nodes and half of that of its rim.
    let faces = blended([0.0; 3], |p| f64::from(u8::from(p.z == 0.5 && p.coords.xy().amax() < 0.5)));
    assert!((center - edges - faces).abs() < 1e-15 && center > 1.0 / 6.0);
    let square = blended([0.0; 3], |p| p.coords.norm_squared());
    let axes = [0, 1, 2].map(|axis| blended([0.0; 3], |p| p[axis] * p[axis]));
    assert!((square - axes.iter().sum::<f64>()).abs() < 1e-14);
    assert!((axes[0] - axes[1]).abs() < 1e-14 && (axes[1] - axes[2]).abs() < 1e-14);
}

#[test]
fn a_body_without_an_inside_keeps_its_boundary() {
    let tet = Lattice {
        nodes: vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(0.0, 0.0, 1.0),
        ],
        tets: vec![[0, 1, 2, 3]],
    };
    for carry in BOTH {
        assert_eq!(carried(&tet, carry, &[4.0, 3.0, 2.0, 1.0], 1), [4.0, 3.0, 2.0, 1.0]);
    }
}

#[test]
fn values_that_are_not_finite_and_canceled_work_are_refused() {
    let lattice = block([2; 3], 0.5);
    let surface = BoundarySurface::new(&lattice);
    let (mut values, token) = (vec![1.0; surface.nodes.len()], CancelToken::default());
    values[3] = f64::NAN;
    assert_eq!(carry_harmonic(&lattice, &surface, &values, 1, &token), Err(LiftError::NotFinite));
    assert_eq!(carry_mean_value(&lattice, &surface, &values, 1, &token), Err(LiftError::NotFinite));
    values[3] = 1.0;
    token.cancel();
    assert!(matches!(carry_harmonic(&lattice, &surface, &values, 1, &token), Err(LiftError::Canceled(_))));
    assert!(matches!(carry_mean_value(&lattice, &surface, &values, 1, &token), Err(LiftError::Canceled(_))));
}
