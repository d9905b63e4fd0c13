//! Tests of the eigenvalue iteration on operators whose spectrum is known, or that have none.

use crate::cancel_token::{CancelToken, Canceled};
use crate::lattice::block;
use crate::lift::lanczos::{BLOCK, largest};
use crate::lift::{LiftError, Spectrum, interior};

/// Runs the iteration on the operator diag(`values`), with the unit vector e_0 deflated.
fn diagonal(values: &[f64], wanted: usize, token: &CancelToken) -> Result<Vec<f64>, LiftError> {
    let mut deflated = vec![0.0; values.len()];
    deflated[0] = 1.0;
    let apply = |block: &mut [f64], width: usize| {
        assert!(width <= BLOCK && block.len() == width * values.len());
        for column in block.chunks_exact_mut(values.len()) {
            column.iter_mut().zip(values).for_each(|(entry, value)| *entry *= value);
        }
    };
    largest(&deflated, wanted, apply, token)
}

/// Checks that the Rayleigh quotients of the vectors are the largest of `values[1..]`.
#[track_caller]
fn check(values: &[f64], wanted: usize) {
    let vectors = diagonal(values, wanted, &CancelToken::default()).unwrap();
    let mut exact = values[1..].to_vec();
    exact.sort_unstable_by(|a, b| b.total_cmp(a));
    for (vector, exact) in vectors.chunks_exact(values.len()).zip(exact) {
        let quotient: f64 = vector.iter().zip(values).map(|(x, value)| x * x * value).sum();
        assert!((quotient / exact - 1.0).abs() < 1e-12, "{quotient} instead of {exact}");
        assert!(vector[0].abs() < 1e-12, "the deflated vector is left out");
    }
}

#[track_caller]
fn refused(values: &[f64], wanted: usize, expected: LiftError) {
    assert_eq!(diagonal(values, wanted, &CancelToken::default()).map(|vectors| vectors.len()), Err(expected));
}

#[test]
fn decaying_spectra_are_found() {
    check(&(0..500).map(|k| 1.0 / f64::from(1 + k)).collect::<Vec<f64>>(), 24);
    check(&(0..2000).map(|k| f64::from(1 + k).powf(-2.0 / 3.0)).collect::<Vec<f64>>(), 40);
}

#[test]
fn multiplets_are_found_whole() {
    // 1/k, repeated eight times each.
    check(&(0..800).map(|k| 1.0 / f64::from(1 + k / 8)).collect::<Vec<f64>>(), 30);
}

#[test]
fn a_spectrum_that_needs_restarts_is_found() {
    // The wanted end is spread by 2 % only.
    check(&(0..3000).map(|k| 1.0 - 1e-3 * f64::from(k).sqrt()).collect::<Vec<f64>>(), 8);
}

#[test]
fn lanczos_recovers_from_rank_loss() {
    // Forty positive eigenvalues, the rest zero: the Krylov space ends at 40.
    let values: Vec<f64> = (0..600).map(|k| if k <= 40 { 1.0 + f64::from(k) } else { 0.0 }).collect();
    check(&values, 40);
    refused(&values, 41, LiftError::NotConverged { converged: 40, wanted: 41 });
    check(&[1.0; 400], 20);
}

#[test]
fn operators_without_a_positive_spectrum_end_in_an_error() {
    refused(&[0.0; 400], 16, LiftError::NotConverged { converged: 0, wanted: 16 });
    refused(&[-1.0; 400], 16, LiftError::NotConverged { converged: 0, wanted: 16 });
    refused(&[f64::NAN; 400], 16, LiftError::NotFinite);
    refused(&[f64::INFINITY; 400], 16, LiftError::NotFinite);
    refused(&[1e300; 400], 16, LiftError::NotFinite);
    refused(&[1.0; 40], 16, LiftError::TooFewNodes { nodes: 40, wanted: 16, needed: 57 });
}

#[test]
fn a_canceled_token_stops_it_between_blocks() {
    let token = CancelToken::default();
    let mut deflated = vec![0.0; 1000];
    deflated[0] = 1.0;
    let mut applied = 0;
    let apply = |block: &mut [f64], _: usize| {
        applied += 1;
        if applied == 2 {
            token.cancel();
        }
        block.iter_mut().enumerate().for_each(|(entry, value)| *value /= 1.0 + (entry % 1000) as f64);
    };
    assert_eq!(largest(&deflated, 24, apply, &token), Err(LiftError::Canceled(Canceled)));
    assert_eq!(applied, 2);
    let lattice = block([5; 3], 0.1);
    assert_eq!(Spectrum::compute(&lattice, 4, &token), Err(LiftError::Canceled(Canceled)));
    assert_eq!(interior(&lattice, 4, 1.0, &token), Err(LiftError::Canceled(Canceled)));
}

#[test]
fn the_same_lattice_gives_the_same_bits() {
    let lattice = block([6, 5, 4], 0.1);
    let one = interior(&lattice, 12, 1.0, &CancelToken::default()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let other = pool.install(|| interior(&lattice, 12, 1.0, &CancelToken::default()).unwrap());
    assert_eq!(one, other);
}
