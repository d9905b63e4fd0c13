//! Energy bound against dense eigenvalues and solves.

use super::*;
use nalgebra::DMatrix;

fn floor(body: &Elasticity) -> EigenvalueLowerBound {
    EigenvalueLowerBound::of(body, &CancelToken::default()).unwrap().unwrap()
}

/// Diagonal of W, from the bounds ½/(wσ) of unit forces.
fn weights(floor: &EigenvalueLowerBound, size: usize) -> Vec<f64> {
    let of = |row: usize| {
        let mut unit = vec![0.0; size];
        unit[row] = 1.0;
        0.5 / (floor.energy(&unit) * floor.value())
    };
    (0..size).map(of).collect()
}

/// Smallest positive eigenvalue of (K, W), by a dense solver.
fn dense(body: &Elasticity, weights: &[f64]) -> f64 {
    let column = |row: usize| {
        let (mut unit, mut product) = (vec![0.0; body.size()], vec![0.0; body.size()]);
        unit[row] = 1.0;
        body.stiffness.multiply_alone(&unit, &mut product);
        product
    };
    let columns: Vec<Vec<f64>> = (0..body.size()).map(column).collect();
    let scaled = |i: usize, j: usize| columns[j][i] / (weights[i] * weights[j]).sqrt();
    let mut values: Vec<f64> =
        DMatrix::from_fn(body.size(), body.size(), scaled).symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    assert!(values[5].abs() < 1e-9 * values[6], "six rigid motions: {values:?}");
    values[6]
}

#[test]
fn the_eigenvalue_bound_is_below_the_lowest_eigenvalue_and_near_it() {
    for cells in [[3, 1, 1], [2, 2, 2], [1, 1, 1], [4, 2, 1], [12, 1, 1]] {
        let body = free(&block(cells, 0.2), 0.3);
        let floor = floor(&body);
        let exact = dense(&body, &weights(&floor, body.size()));
        println!("{cells:?}: floor {:.5}, exact {exact:.5}", floor.value());
        assert!(floor.value() <= exact && floor.value() > 0.75 * exact, "{} of {exact}", floor.value());
    }
}

#[test]
fn an_anchored_body_has_no_eigenvalue_bound() {
    let lattice = block([2, 1, 1], 0.2);
    let held =
        free(&lattice, 0.3).anchored(vec![0, 1, 2, 3, 4], ElementOrder::Linear, &CancelToken::default()).unwrap();
    assert_eq!(EigenvalueLowerBound::of(&held, &CancelToken::default()).unwrap(), None);
}

/// Contacts at any place, in any direction and with any radius store no more than the bound.
#[test]
fn no_load_stores_more_than_its_bound() {
    for (cells, spacing) in
        [([12, 2, 2], 0.08), ([5, 5, 5], 0.12), ([10, 10, 10], 0.06), ([8, 8, 1], 0.09), ([30, 2, 2], 0.033)]
    {
        let lattice = block(cells, spacing);
        let body = free(&lattice, 0.3);
        let floor = floor(&body);
        let mut stream = RandomStream::new(3, 0);
        let mut ratios = Vec::new();
        for _ in 0..60 {
            let place = body.boundary.positions[(stream.uniform() * body.boundary.positions.len() as f64) as usize];
            let impulse = Vector3::from_fn(|_, _| stream.uniform() - 0.5);
            let contact = ContactLoad { point: place, impulse, radius: 0.05 + 0.2 * stream.uniform() };
            let forces = load(&body, &[contact]).forces;
            let energy = body.elastic_energy(&forces, &solve(&body, &forces));
            ratios.push(floor.energy(&forces) / energy);
        }
        ratios.sort_by(f64::total_cmp);
        println!("{cells:?}: bound over energy {:.1} to {:.1}, median {:.1}", ratios[0], ratios[59], ratios[30]);
        assert!(ratios[0] >= 1.0, "{ratios:?}");
    }
}
