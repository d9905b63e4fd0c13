//! Reduced elasticity against the solve.

use super::*;
use crate::elasticity::workspace::SIDE;

/// Free bar and its lattice.
fn bar() -> (Lattice, Elasticity) {
    let lattice = block([6, 3, 3], 0.15);
    let body = free(&lattice, 0.3);
    (lattice, body)
}

/// Contact at a random node of the top, in a random direction.
fn drawn(lattice: &Lattice, stream: &mut RandomStream) -> ContactLoad {
    let top = lattice.nodes.iter().map(|node| node.y).fold(f64::NEG_INFINITY, f64::max);
    let above: Vec<Point3<f64>> = lattice.nodes.iter().filter(|node| node.y == top).copied().collect();
    let point = above[stream.bits() as usize % above.len()];
    let impulse = Vector3::new(stream.uniform() - 0.5, -1.0, stream.uniform() - 0.5);
    ContactLoad { point, impulse, radius: 0.3 }
}

fn snapshots(lattice: &Lattice, body: &Elasticity, count: u64) -> Vec<NodalLoad> {
    let mut stream = RandomStream::new(1, 0);
    (0..count).map(|_| load(body, &[drawn(lattice, &mut stream)])).collect()
}

#[test]
fn many_right_hand_sides_are_solved_as_one_by_one() {
    let (lattice, body) = bar();
    let loads = snapshots(&lattice, &body, 11);
    let all = body.solve_all(&loads, &CancelToken::default()).unwrap();
    for (column, load) in all.chunks_exact(body.size()).zip(&loads) {
        let alone = solve(&body, &load.forces);
        let greatest = alone.iter().fold(0.0, |greatest: f64, u| greatest.max(u.abs()));
        let worst = column.iter().zip(&alone).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= 1e-11 * greatest, "{worst} of {greatest}");
    }
}

#[test]
fn the_basis_is_orthonormal_in_energy() {
    let (lattice, body) = bar();
    let reduced = body.reduce(&lattice, &snapshots(&lattice, &body, 40), 12, &CancelToken::default()).unwrap().unwrap();
    let rank = reduced.rank();
    assert_eq!(rank, 12);
    let column =
        |k: usize| -> Vec<f64> { reduced.basis().iter().skip(k).step_by(rank).map(|b| f64::from(*b)).collect() };
    for i in 0..rank {
        let mut stiff = vec![0.0; body.size()];
        body.stiffness.multiply(&column(i), &mut stiff);
        for j in 0..rank {
            let product: f64 = column(j).iter().zip(&stiff).map(|(a, b)| a * b).sum();
            let wanted = f64::from(u8::from(i == j));
            assert!((product - wanted).abs() < 1e-5, "{i}, {j}: {product}");
        }
    }
}

#[test]
fn the_basis_reproduces_its_snapshots() {
    let (lattice, body) = bar();
    let loads = snapshots(&lattice, &body, 30);
    let reduced = body.reduce(&lattice, &loads, 256, &CancelToken::default()).unwrap().unwrap();
    let (mut coordinates, mut displacement) = (Vec::new(), Vec::new());
    for load in &loads {
        let energy = reduced.project(load, &mut coordinates);
        reduced.expand(&coordinates, &mut displacement, &mut ElasticWorkspace::default());
        let mut own = Vec::new();
        body.tet_energy(&lattice, &displacement, DrivingEnergy::Total, &mut own, &CancelToken::default()).unwrap();
        let wanted = energies(&body, &lattice, &load.forces, DrivingEnergy::Total);
        let total: f64 = wanted.iter().sum();
        let worst = own.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!((energy / total - 1.0).abs() < 1e-5, "{energy} of {total}");
        assert!(worst < 1e-5 * total, "{worst} of {total}");
    }
}

#[test]
fn captured_energy_grows_with_the_rank_and_never_exceeds_the_true_one() {
    let (lattice, body) = bar();
    let loads = snapshots(&lattice, &body, 60);
    let other = load(&body, &[ContactLoad { radius: 0.35, ..drawn(&lattice, &mut RandomStream::new(2, 0)) }]);
    let truth: f64 = energies(&body, &lattice, &other.forces, DrivingEnergy::Total).iter().sum();
    let captured = |rank| {
        let reduced = body.reduce(&lattice, &loads, rank, &CancelToken::default()).unwrap().unwrap();
        reduced.project(&other, &mut Vec::new())
    };
    let found = [4, 8, 16, 32].map(captured);
    println!("{found:?} of {truth}");
    assert!(found.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-6)), "{found:?}");
    assert!(found[3] <= truth * (1.0 + 1e-6) && found[3] > 0.9 * truth, "{found:?} of {truth}");
}

/// Displacement with these coordinates in double precision, and the sums of the magnitudes of its terms.
fn combined(reduced: &ReducedBasis, coordinates: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let terms = |row: &[f32]| -> Vec<f64> { row.iter().zip(coordinates).map(|(b, q)| f64::from(*b) * q).collect() };
    let rows = reduced.basis().chunks_exact(reduced.rank()).map(terms);
    rows.map(|terms| (terms.iter().sum::<f64>(), terms.iter().map(|term| term.abs()).sum::<f64>())).unzip()
}

/// Relative residual of the reduced displacement under a load, and the share of the true energy that it misses.
fn missing(lattice: &Lattice, body: &Elasticity, reduced: &ReducedBasis, load: &NodalLoad) -> (f64, f64) {
    let mut coordinates = Vec::new();
    let energy = reduced.project(load, &mut coordinates);
    let residual = reduced.residual(body, load, &coordinates, &mut ElasticWorkspace::default());
    let (mut product, diagonal) = (vec![0.0; body.size()], body.stiffness.diagonal());
    body.stiffness.multiply(&combined(reduced, &coordinates).0, &mut product);
    let unbalanced = load.forces.iter().zip(&product).zip(&diagonal).map(|((f, ku), d)| (f - ku).powi(2) / d);
    let direct = 0.5 * unbalanced.sum::<f64>() / energy;
    // Terms of the form are below 1 here, and both sums are in double precision. They differ by up to 4e-16.
    assert!((residual - direct).abs() <= 1e-13, "{residual} by the form, {direct} by the displacement");
    let truth: f64 = energies(body, lattice, &load.forces, DrivingEnergy::Total).iter().sum();
    (residual, 1.0 - energy / truth)
}

/// Of each term the coordinate, the product, the sums in a lane after the first, and four halvings are rounded.
#[test]
fn displacements_are_expanded_in_single_precision() {
    let (lattice, body) = bar();
    let reduced = body.reduce(&lattice, &snapshots(&lattice, &body, 60), 40, &CancelToken::default()).unwrap().unwrap();
    let (mut coordinates, mut displacement) = (Vec::new(), Vec::new());
    let roundings = reduced.rank().div_ceil(SIDE) + 5;
    let bound = 0.5 * f64::from(f32::EPSILON) * roundings as f64 * 1.0001;
    for load in snapshots(&lattice, &body, 10) {
        reduced.project(&load, &mut coordinates);
        reduced.expand(&coordinates, &mut displacement, &mut ElasticWorkspace::default());
        let (exact, sizes) = combined(&reduced, &coordinates);
        for ((own, exact), size) in displacement.iter().zip(&exact).zip(&sizes) {
            assert!((own - exact).abs() <= bound * size, "{own} instead of {exact}, of terms of {size}");
        }
    }
}

#[test]
fn the_residual_estimates_the_missing_energy() {
    let (lattice, body) = bar();
    let reduced = body.reduce(&lattice, &snapshots(&lattice, &body, 30), 20, &CancelToken::default()).unwrap().unwrap();
    let mut stream = RandomStream::new(3, 0);
    let mut pairs = |radius| -> Vec<(f64, f64)> {
        let mut drawn = || load(&body, &[ContactLoad { radius, ..drawn(&lattice, &mut stream) }]);
        (0..20).map(|_| missing(&lattice, &body, &reduced, &drawn())).collect()
    };
    let estimate = ErrorEstimate::fit(&pairs(0.3));
    println!("{estimate:?}");
    for radius in [0.25, 0.3, 0.4, 0.5] {
        let others = pairs(radius);
        let ratios: Vec<f64> = others.iter().map(|(residual, missing)| estimate.error(*residual) / missing).collect();
        println!("radius {radius}: {ratios:.2?}");
        assert!(ratios.iter().all(|ratio| (1.0 / 3.0..=3.0).contains(ratio)), "radius {radius}: {ratios:?}");
    }
}

#[test]
fn contacts_that_touch_the_same_nodes_count_together() {
    let (lattice, body) = bar();
    let reduced = body.reduce(&lattice, &snapshots(&lattice, &body, 30), 20, &CancelToken::default()).unwrap().unwrap();
    let one = drawn(&lattice, &mut RandomStream::new(5, 0));
    let aside = ContactLoad { impulse: one.impulse.yzx(), ..one };
    let [(alone, _), (twice, _), _] =
        [vec![one], vec![one, one], vec![one, aside]].map(|all| missing(&lattice, &body, &reduced, &load(&body, &all)));
    assert!((alone - twice).abs() <= 1e-9 * alone, "{alone} {twice}");
}

#[test]
fn estimates_are_fitted_to_the_power() {
    let truth = ErrorEstimate { factor: 0.3, power: 1.25, ..ErrorEstimate::RAW };
    let mut stream = RandomStream::new(4, 0);
    let mut drawn = || (-12.0 * stream.uniform()).exp();
    let pairs: Vec<_> = (0..40).map(|_| drawn()).map(|residual| (residual, truth.error(residual))).collect();
    let found = ErrorEstimate::fit(&pairs);
    assert!((found.factor - truth.factor).abs() < 1e-9 && (found.power - truth.power).abs() < 1e-9, "{found:?}");
    let bounded = ErrorEstimate { error_max: 0.1, ..truth };
    assert_eq!([0.1, 1.0].map(|residual| bounded.error(residual)), [truth.error(0.1), 0.1]);
    assert_eq!(ErrorEstimate::fit(&pairs[..7]), ErrorEstimate::RAW);
    assert_eq!(ErrorEstimate::fit(&vec![(0.1, 0.2); 40]), ErrorEstimate::RAW, "equal pairs determine no power");
    let without_error: Vec<_> = pairs.iter().copied().chain([(0.1, 0.0), (0.0, 0.1)]).collect();
    assert_eq!(ErrorEstimate::fit(&without_error), found);
    // Contacts of sheets and beside anchors miss far more than those of the fit: errors grow at least in proportion there.
    let slow = ErrorEstimate { factor: 0.3, power: 0.6, ..ErrorEstimate::RAW };
    let pairs: Vec<_> = pairs.iter().map(|(residual, _)| (*residual, slow.error(*residual))).collect();
    let powers = [ErrorEstimate::fit, ErrorEstimate::fit_steep].map(|fit| fit(&pairs).power);
    assert!((powers[0] - 0.6).abs() < 1e-9 && powers[1] == 1.0, "{powers:?}");
}

#[test]
fn wide_instructions_do_not_change_a_bit_of_a_projection() {
    let (lattice, body) = bar();
    let loads = snapshots(&lattice, &body, 30);
    let reduced = body.reduce(&lattice, &loads, 19, &CancelToken::default()).unwrap().unwrap();
    for load in &loads[..3] {
        crate::simd::tests::same_on_every_path(|| {
            let (mut coordinates, mut displacement) = (Vec::new(), Vec::new());
            let energy = reduced.project(load, &mut coordinates);
            reduced.expand(&coordinates, &mut displacement, &mut ElasticWorkspace::default());
            let residual = reduced.residual(&body, load, &coordinates, &mut ElasticWorkspace::default());
            (energy, residual, coordinates, displacement)
        });
    }
}
