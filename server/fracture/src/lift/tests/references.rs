//! Spectra against closed forms and the defining equation.

use super::shapes::{ball, fork};
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, block};
use crate::lift::laplacian::Laplacian;
use crate::lift::{LiftError, Spectrum};
use std::f64::consts::PI;

fn spectrum(lattice: &Lattice, count: usize) -> Spectrum {
    Spectrum::compute(lattice, count, &CancelToken::default()).unwrap()
}

/// Checks that the eigenvalues of `lattice` differ from `exact` by at most `error`, relatively.
///
/// Returns the largest relative difference.
#[track_caller]
fn check(lattice: &Lattice, exact: &[f64], error: f64) -> f64 {
    let computed = spectrum(lattice, exact.len()).eigenvalues;
    let worst = computed.iter().zip(exact).map(|(value, exact)| (value / exact - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst <= error, "off by {worst:e}: {computed:?} instead of {exact:?}");
    worst
}

/// π²(i²/a² + j²/b² + k²/c²), ascending, without zero.
fn of_box(sides: [f64; 3], count: usize) -> Vec<f64> {
    let mut values = Vec::new();
    for index in 1..1000 {
        let modes = [index % 10, index / 10 % 10, index / 100];
        values.push((0..3).map(|axis| (PI * f64::from(modes[axis]) / sides[axis]).powi(2)).sum());
    }
    values.sort_unstable_by(f64::total_cmp);
    values.truncate(count);
    values
}

#[test]
fn a_box_has_the_spectrum_of_cosines_and_converges_with_order_two() {
    let exact = of_box([1.0, 0.8, 0.6], 12);
    let coarse = check(&block([10, 8, 6], 0.1), &exact, 0.05);
    let fine = check(&block([20, 16, 12], 0.05), &exact, 0.015);
    let order = (coarse / fine).log2();
    assert!((1.8..2.3).contains(&order), "order {order}: {coarse:e} to {fine:e}");
}

#[test]
fn dense_and_lanczos_spectra_agree() {
    let exact = of_box([1.0, 1.0, 0.5], 4);
    check(&block([4, 4, 2], 0.25), &exact, 0.1);
    check(&block([8, 8, 4], 0.125), &exact, 0.03);
}

#[test]
fn a_ball_has_the_zeros_of_the_derivatives_of_spherical_bessel_functions() {
    // First zeros of j_l' (l = 1, 2), each 2 l + 1 times; then j_0' and j_3'.
    let zeros = [(2.081_575_977_8, 3), (3.342_093_657_4, 5), (4.493_409_457_9, 1), (4.514_099_648, 7)];
    let exact: Vec<f64> = zeros.iter().flat_map(|&(zero, times)| vec![f64::powi(zero, 2); times]).collect();
    let coarse = check(&ball(6), &exact[..8], 0.1);
    let fine = check(&ball(12), &exact[..8], 0.03);
    let order = (coarse / fine).log2();
    assert!((1.7..2.4).contains(&order), "order {order}: {coarse:e} to {fine:e}");
    check(&ball(12), &exact, 0.06);
}

/// Checks that ‖Lφ − λMφ‖ is small, φᵀMφ' = δ, and every function is orthogonal to the constants.
#[track_caller]
fn check_pairs(lattice: &Lattice, count: usize) {
    let spectrum = spectrum(lattice, count);
    assert!(spectrum.residual < 1e-8, "residual {:e}", spectrum.residual);
    let mass = Laplacian::new(lattice).unwrap().mass;
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).zip(&mass).map(|((x, y), m)| x * y * m).sum() };
    let ones = vec![1.0; mass.len()];
    for i in 0..count {
        assert!(product(spectrum.function(i), &ones).abs() < 1e-10);
        for j in 0..=i {
            let expected = f64::from(u8::from(i == j));
            let found = product(spectrum.function(i), spectrum.function(j));
            assert!((found - expected).abs() < 1e-10, "<{i}, {j}> = {found}");
        }
    }
}

#[test]
fn pairs_solve_their_equation_and_are_orthonormal() {
    check_pairs(&block([2, 2, 3], 0.1), 24);
    check_pairs(&block([6; 3], 0.1), 24);
    check_pairs(&fork(), 24);
}

#[test]
fn the_units_are_inverse_square_lengths() {
    let (unit, tiny) = (spectrum(&block([5, 6, 7], 0.1), 12), spectrum(&block([5, 6, 7], 1e-7), 12));
    for (a, b) in unit.eigenvalues.iter().zip(&tiny.eigenvalues) {
        assert!((b * 1e-12 / a - 1.0).abs() < 1e-9);
    }
}

#[track_caller]
fn refused(lattice: &Lattice, count: usize, expected: LiftError) {
    assert_eq!(Spectrum::compute(lattice, count, &CancelToken::default()), Err(expected));
}

#[test]
fn what_has_no_spectrum_is_refused_by_name() {
    let cube = block([1; 3], 1.0);
    refused(&Lattice::default(), 1, LiftError::TooFewNodes { nodes: 0, wanted: 0, needed: 4 });
    refused(&cube, 15, LiftError::TooFewNodes { nodes: 15, wanted: 15, needed: 16 });
    refused(&block([5; 3], 1.0), 72, LiftError::TooManyModes { modes: 72, max: 71 });
    let mut flat = cube.clone();
    flat.nodes.iter_mut().for_each(|node| node.z = 0.0);
    refused(&flat, 3, LiftError::DegenerateTet { tet: 0 });
    let mut damaged = cube.clone();
    damaged.nodes[3].x = f64::NAN;
    assert!(matches!(Spectrum::compute(&damaged, 3, &CancelToken::default()), Err(LiftError::DegenerateTet { .. })));
    let mut stray = cube;
    stray.nodes.push(stray.nodes[0]);
    refused(&stray, 3, LiftError::Disconnected { components: 2 });
    let halves = super::shapes::carved(block([3, 1, 1], 1.0), |at| at.x.abs() > 0.5);
    refused(&halves, 3, LiftError::Disconnected { components: 2 });
}
