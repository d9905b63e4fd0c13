//! Tests of anchored bodies: references, superposition, reactions.

use super::*;
use crate::reference::{fixed_bar_error, hanging_error};
use nalgebra::{DMatrix, DVector};

/// Block anchored at its low end along x.
fn held(lattice: &Lattice, poisson: f64) -> Elasticity {
    let low = lattice.nodes.iter().map(|node| node.x).fold(f64::INFINITY, f64::min) + 1e-9;
    let nodes = (0..lattice.nodes.len() as u32).filter(|&node| lattice.nodes[node as usize].x < low).collect();
    free(lattice, poisson).anchored(nodes, &CancelToken::default()).unwrap()
}

fn anchors(body: &Elasticity) -> &[u32] {
    match body.support() {
        Support::Anchored(nodes) => nodes,
        Support::Free(_) => &[],
    }
}

/// Load of an impact on the far end.
fn impact_forces(body: &Elasticity) -> Vec<f64> {
    let contact =
        ContactLoad { point: Point3::new(0.5, 0.03, 0.02), impulse: Vector3::new(-1.0, 0.3, 0.1), radius: 0.2 };
    load(body, &[contact]).forces
}

#[test]
fn a_bar_that_hangs_by_its_weight_converges_with_order_two() {
    let errors = [1, 2, 4].map(|fine| hanging_error(fine).unwrap());
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    println!("orders {orders:?}, errors {errors:?}");
    assert!(orders.iter().all(|order| (1.8..2.2).contains(order)), "orders {orders:?}, errors {errors:?}");
    assert!(errors.iter().all(|error| *error > 0.0), "a displacement method must be too stiff: {errors:?}");
}

/// Constant stress is exact except for rounding.
#[test]
fn a_push_on_a_fixed_bar_has_its_energy() {
    for fine in [1, 2] {
        let error = fixed_bar_error(fine).unwrap();
        assert!(error.abs() < 1e-11, "{error:e}");
    }
}

/// Compares with a dense factor of the matrix without the held rows.
#[test]
fn an_impact_on_a_fixed_bar_matches_the_dense_solve() {
    let lattice = block([4, 2, 2], 0.25);
    let body = held(&lattice, 0.3);
    let forces = impact_forces(&body);
    let still = anchors(&body);
    let moving: Vec<usize> = (0..body.size()).filter(|row| !still.contains(&((row / 3) as u32))).collect();
    let column = |row: usize| {
        let (mut unit, mut product) = (vec![0.0; body.size()], vec![0.0; body.size()]);
        unit[row] = 1.0;
        body.stiffness.multiply_alone(&unit, &mut product);
        product
    };
    let columns: Vec<Vec<f64>> = moving.iter().map(|row| column(*row)).collect();
    let dense = DMatrix::from_fn(moving.len(), moving.len(), |i, j| columns[j][moving[i]]);
    let right = DVector::from_iterator(moving.len(), moving.iter().map(|row| forces[*row]));
    let exact = dense.cholesky().unwrap().solve(&right);
    let own = solve(&body, &forces);
    let own: Vec<f64> = moving.iter().map(|row| own[*row]).collect();
    assert!(difference(&own, exact.as_slice()) < 1e-10);
}

#[test]
fn loads_superpose() {
    let lattice = block([4, 2, 2], 0.25);
    let body = held(&lattice, 0.3);
    let (impact_forces, weight) = (impact_forces(&body), body.weight(&Vector3::new(0.3, -9.81, 0.0)));
    let both: Vec<f64> = impact_forces.iter().zip(&weight).map(|(a, b)| a + 0.7 * b).collect();
    let [first, second] = [&impact_forces, &weight].map(|forces| solve(&body, forces));
    let sum: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + 0.7 * b).collect();
    assert!(difference(&sum, &solve(&body, &both)) < 1e-11);
}

#[test]
fn anchors_bear_the_load() {
    let lattice = block([4, 2, 2], 0.25);
    let body = held(&lattice, 0.3);
    let volume = lattice.volume();
    for (forces, sum) in [
        (impact_forces(&body), Vector3::new(-1.0, 0.3, 0.1)),
        (body.weight(&Vector3::new(0.0, -9.81, 0.0)), Vector3::new(0.0, -9.81 * volume, 0.0)),
    ] {
        let mut reactions = vec![0.0; body.size()];
        body.stiffness.multiply(&solve(&body, &forces), &mut reactions);
        reactions.iter_mut().zip(&forces).for_each(|(r, f)| *r -= f);
        let (borne, torque) = body.inertia.net(&reactions);
        let (_, asked) = body.inertia.net(&forces);
        assert!((borne + sum).norm() < 1e-11 * sum.norm(), "{borne} of {sum}");
        assert!((torque + asked).norm() < 1e-11 * sum.norm(), "{torque} of {asked}");
        let moving =
            reactions.chunks_exact(3).enumerate().filter(|(node, _)| !anchors(&body).contains(&(*node as u32)));
        let left = moving.flat_map(|(_, own)| own).fold(0.0, |most: f64, r| most.max(r.abs()));
        assert!(left < 1e-11 * sum.norm(), "other nodes must not carry load: {left:e}");
    }
}

#[test]
fn insufficient_anchors_are_rejected() {
    let lattice = block([4, 2, 2], 0.25);
    let body = free(&lattice, 0.3);
    let edge: Vec<u32> = (0..lattice.nodes.len() as u32)
        .filter(|&node| {
            let place = lattice.nodes[node as usize];
            place.y < -0.24 && place.z < -0.24
        })
        .collect();
    assert!(edge.len() >= 5);
    for nodes in [vec![], vec![3], vec![3, 7], edge] {
        let (count, error) = (nodes.len(), body.anchored(nodes, &CancelToken::default()).err());
        assert_eq!(error, Some(ElasticityError::AnchorsInLine { nodes: count }));
    }
    let error = body.anchored(vec![0, 4000], &CancelToken::default()).err();
    assert_eq!(error, Some(ElasticityError::UnknownAnchor { node: 4000 }));
}

/// A block of quadratic elements, anchored at its low end along x.
fn quadratic_held(lattice: &Lattice) -> Elasticity {
    let body = free(lattice, 0.3).of_order(ElementOrder::Quadratic, lattice).unwrap();
    body.anchored(anchors(&held(lattice, 0.3)).to_vec(), &CancelToken::default()).unwrap()
}

#[test]
fn residuals_leave_out_what_anchors_carry() {
    let lattice = block([4, 2, 2], 0.25);
    let body = quadratic_held(&lattice);
    let is_held = |node: &u32| anchors(&body).contains(node);
    let nodes = (0..lattice.nodes.len() as u32).map(|node| is_held(&node));
    let edges = body.edges.as_ref().unwrap().ends.iter().map(|ends| ends.iter().all(is_held));
    let carried: Vec<bool> = nodes.chain(edges).flat_map(|is_held| [is_held; 3]).collect();
    let found: Vec<bool> = body.inverse_diagonal().iter().map(|inverse| *inverse == 0.0).collect();
    assert!(found == carried && carried.iter().filter(|own| **own).count() > 3 * anchors(&body).len());
}

/// Weight is a load by an acceleration, alone and beside contacts, in forces and in the coordinates of a basis.
#[test]
fn a_basis_holds_contacts_and_weight_together() {
    let lattice = block([4, 2, 2], 0.25);
    let (body, gravity, token) = (quadratic_held(&lattice), Vector3::new(0.3, -9.81, 0.0), CancelToken::default());
    let contact =
        ContactLoad { point: Point3::new(0.5, 0.03, 0.02), impulse: Vector3::new(-1.0, 0.3, 0.1), radius: 0.2 };
    let (alone, weight) = (load(&body, &[contact]), body.weight_load(&gravity));
    let mut both = NodalLoad { forces: Vec::new(), acceleration: weight.acceleration, ..alone.clone() };
    body.balance(&mut both);
    let sum: Vec<f64> = alone.forces.iter().zip(&weight.forces).map(|(a, b)| a + b).collect();
    assert!(difference(&sum, &both.forces) < 1e-12);
    let basis = body.reduce(&lattice, &[alone, weight.clone()], 2, &token).unwrap().unwrap();
    for load in [weight, both] {
        let exact = body.elastic_energy(&load.forces, &solve(&body, &load.forces));
        let own = basis.project(&load, &mut Vec::new());
        assert!((own / exact - 1.0).abs() < 1e-2, "{own} of {exact}");
    }
}
