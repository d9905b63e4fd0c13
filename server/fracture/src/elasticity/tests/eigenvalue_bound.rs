//! Energy bound against dense eigenvalues and solves.

use super::walls::baked;
use super::*;
use crate::elasticity::element::Element;
use crate::elasticity::quadratic::ElementStiffness;
use crate::pipeline::ElementChoice;
use crate::surface::shapes;
use nalgebra::{DMatrix, Rotation3};

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
    let held = free(&lattice, 0.3).anchored(vec![0, 1, 2, 3, 4], &CancelToken::default()).unwrap();
    assert_eq!(EigenvalueLowerBound::of(&held, &CancelToken::default()).unwrap(), None);
}

/// Bounds over energies of random contacts, ascending; any place, direction and radius.
fn ratios(body: &Elasticity, floor: &EigenvalueLowerBound, count: usize) -> Vec<f64> {
    let mut stream = RandomStream::new(3, 0);
    let mut ratio = || {
        let place = body.boundary.positions[(stream.uniform() * body.boundary.positions.len() as f64) as usize];
        let impulse = Vector3::from_fn(|_, _| stream.uniform() - 0.5);
        let contact = ContactLoad { point: place, impulse, radius: 0.05 + 0.2 * stream.uniform() };
        let forces = load(body, &[contact]).forces;
        floor.energy(&forces) / body.elastic_energy(&forces, &solve(body, &forces))
    };
    let mut ratios: Vec<f64> = (0..count).map(|_| ratio()).collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

#[test]
fn no_load_stores_more_than_its_bound() {
    for (cells, spacing) in
        [([12, 2, 2], 0.08), ([5, 5, 5], 0.12), ([10, 10, 10], 0.06), ([8, 8, 1], 0.09), ([30, 2, 2], 0.033)]
    {
        let body = free(&block(cells, spacing), 0.3);
        let ratios = ratios(&body, &floor(&body), 60);
        println!("{cells:?}: bound over energy {:.1} to {:.1}, median {:.1}", ratios[0], ratios[59], ratios[30]);
        assert!(ratios[0] >= 1.0, "{ratios:?}");
    }
}

fn quadratic(lattice: &Lattice, poisson: f64) -> Elasticity {
    free(lattice, poisson).of_order(ElementOrder::Quadratic, lattice).unwrap()
}

/// Stiffness of quadratic elements, all columns by products.
fn quadratic_stiffness(body: &Elasticity) -> DMatrix<f64> {
    let (edges, size) = (body.edges.as_ref().unwrap(), body.unknowns());
    let mut stiffness = DMatrix::zeros(size, size);
    for row in 0..size {
        let (mut unit, mut product) = (vec![0.0; size], vec![0.0; size]);
        unit[row] = 1.0;
        edges.multiply(body.lame, &body.elements, &unit, &mut product);
        stiffness.column_mut(row).copy_from_slice(&product);
    }
    stiffness
}

#[test]
fn a_quadratic_tetrahedron_has_the_stiffness_of_its_products_and_its_condensation() {
    for poisson in [-0.4, 0.0, 0.3, 0.45] {
        let all = perturbed([1, 1, 1], 0.5, 0.15, 4);
        for tet in 0..all.tets.len() {
            let lattice = Lattice { nodes: all.corners(tet).to_vec(), tets: vec![[0, 1, 2, 3]] };
            let body = quadratic(&lattice, poisson);
            let own = ElementStiffness::new(&Element::new(&lattice, 0).unwrap(), body.lame);
            let mut stiffness = DMatrix::zeros(30, 30);
            stiffness.view_mut((0, 0), (12, 12)).copy_from(&own.corners);
            stiffness.view_mut((12, 0), (18, 12)).copy_from(&own.coupling);
            stiffness.view_mut((0, 12), (12, 18)).copy_from(&own.coupling.transpose());
            stiffness.view_mut((12, 12), (18, 18)).copy_from(&own.edges);
            let expected = quadratic_stiffness(&body);
            assert!((stiffness - &expected).amax() < 1e-13 * expected.amax(), "tetrahedron {tet}, ν {poisson}");
            // The minimum over the edges of one tetrahedron is no bound, but exact.
            let edges = body.edges.as_ref().unwrap();
            let weights = edges.compliance(&body.elements).into_iter().flat_map(|compliance| [1.0 / compliance; 3]);
            let weights = DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(18, weights));
            let on_edges = expected.view((12, 12), (18, 18)) - weights;
            let coupling = expected.view((12, 0), (18, 12));
            let schur =
                expected.view((0, 0), (12, 12)) - coupling.tr_mul(&on_edges.cholesky().unwrap().solve(&coupling));
            let condensed = body.condensed(edges).unwrap().unwrap();
            for (column, expected) in schur.column_iter().enumerate() {
                let (mut unit, mut product) = (vec![0.0; 12], vec![0.0; 12]);
                unit[column] = 1.0;
                condensed.stiffness.multiply_alone(&unit, &mut product);
                let error = product.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error < 1e-11 * schur.amax(), "tetrahedron {tet}, ν {poisson}: {error:e}");
            }
        }
    }
}

/// Least positive eigenvalue of K against the weights of the energy bound, at least 1: 3.3 to 5.1.
#[test]
fn the_eigenvalue_bound_of_quadratic_elements_is_below_the_lowest_eigenvalue() {
    for (lattice, poisson) in [
        (block([3, 1, 1], 0.2), 0.3),
        (block([2, 2, 2], 0.2), 0.3),
        (block([3, 3, 1], 0.2), 0.45),
        (perturbed([2, 2, 1], 0.5, 0.1, 3), -0.4),
        (perturbed([5, 1, 1], 0.2, 0.04, 6), 0.2),
    ] {
        let body = quadratic(&lattice, poisson);
        let floor = floor(&body);
        let weight = |row: usize| {
            let mut unit = vec![0.0; body.unknowns()];
            unit[row] = 1.0;
            0.5 / floor.energy(&unit)
        };
        let roots: Vec<f64> = (0..body.unknowns()).map(|row| weight(row).sqrt()).collect();
        let mut scaled = quadratic_stiffness(&body);
        (0..roots.len()).for_each(|i| (0..roots.len()).for_each(|j| scaled[(i, j)] /= roots[i] * roots[j]));
        let mut values: Vec<f64> = scaled.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        println!("{} tetrahedra, ν {poisson}: least eigenvalue {:.2} bounds", lattice.tets.len(), values[6]);
        assert!(values[5].abs() < 1e-9 * values[6], "six rigid motions: {values:?}");
        assert!((1.0..10.0).contains(&values[6]), "{}", values[6]);
        assert!(floor.value() < EigenvalueLowerBound::most(&body));
    }
}

/// As for linear elements. The medians are 3.7 to 7 times theirs.
#[test]
fn no_load_on_quadratic_elements_stores_more_than_its_bound() {
    for (cells, spacing, most) in
        [([12, 2, 2], 0.08, 120.0), ([5, 5, 5], 0.12, 60.0), ([8, 8, 1], 0.09, 200.0), ([20, 20, 1], 0.04, 220.0)]
    {
        let lattice = block(cells, spacing);
        let body = quadratic(&lattice, 0.3);
        let start = std::time::Instant::now();
        let floor = floor(&body);
        let (took, ratios) = (start.elapsed(), ratios(&body, &floor, 40));
        let (least, median, greatest) = (ratios[0], ratios[20], ratios[39]);
        println!("{cells:?}: bound over energy {least:.1} to {greatest:.1}, median {median:.1}, in {took:?}");
        assert!(least >= 1.0 && median < most, "{ratios:?}");
    }
}

/// A mug as it is baked, with boundary tetrahedra of many shapes: median 320, and 65 with linear elements.
#[test]
fn no_load_on_a_quadratic_mug_stores_more_than_its_bound() {
    let mug = baked(&shapes::mug(), Rotation3::identity(), ElementChoice::Quadratic);
    let body = &mug.bodies[0].solid.as_ref().unwrap().elasticity;
    let start = std::time::Instant::now();
    let floor = floor(body);
    let (took, ratios) = (start.elapsed(), ratios(body, &floor, 20));
    let (least, median, greatest) = (ratios[0], ratios[10], ratios[19]);
    println!(
        "{} tetrahedra: bound over energy {least:.1} to {greatest:.1}, median {median:.1}, in {took:?}",
        body.tets
    );
    assert!(least >= 1.0 && median < 450.0, "{ratios:?}");
}

#[test]
fn the_bound_of_quadratic_elements_has_the_same_bits_on_any_number_of_threads() {
    let body = quadratic(&perturbed([6, 4, 1], 0.2, 0.04, 5), 0.3);
    let found =
        |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| floor(&body));
    assert_eq!(found(1), found(3));
}
