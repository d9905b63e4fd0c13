//! Tests of the surface lift: spectra of surfaces against closed forms, and lifts of a
//! ball and of bodies with cavities.

use super::shapes::{ball, carved, fork, nearest};
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, block};
use crate::lift::{
    BoundarySurface, Extension, LiftError, LiftKind, LiftedLattice, Spectrum, stretch, surface_diffusion,
};
use crate::random::RandomStream;
use nalgebra::{Rotation3, Vector3};

fn lift(lattice: &Lattice, carry: Extension, modes: usize) -> LiftedLattice {
    surface_diffusion(lattice, carry, modes, &CancelToken::default()).unwrap()
}

fn distance(lift: &LiftedLattice, a: usize, b: usize) -> f64 {
    lift.at(a).iter().zip(lift.at(b)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// Cube with a cubic cavity of a third of its side in the middle.
pub fn hollow() -> Lattice {
    carved(block([6; 3], 1.0), |at| at.coords.amax() > 1.0)
}

/// Largest relative error of the surface spectrum of a unit ball against l(l + 1), 2 l + 1 times each, l = 1, 2, 3.
#[track_caller]
fn check_sphere(cells: usize, bound: f64) -> f64 {
    let exact = [(2.0, 3), (6.0, 5), (12.0, 7)].map(|(value, times)| vec![value; times]).concat();
    let surface = BoundarySurface::new(&ball(cells));
    let computed = Spectrum::of_surface(&surface, exact.len(), &CancelToken::default()).unwrap().eigenvalues;
    let worst = computed.iter().zip(&exact).map(|(value, exact)| (value / exact - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst <= bound, "off by {worst:e}: {computed:?}");
    worst
}

#[test]
fn a_sphere_has_the_spectrum_of_spherical_harmonics_and_converges_with_order_two() {
    // 194 nodes: dense; 770 and 3 074: iterated.
    let errors = [(4, 0.2), (8, 0.05), (16, 0.013)].map(|(cells, bound)| check_sphere(cells, bound));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.7..2.4).contains(&order), "order {order}: {errors:?}");
    }
}

#[test]
fn the_three_lowest_functions_of_a_ball_are_its_positions() {
    // Y_1 on the sphere is the position, and so is its harmonic extension. So the lift is a similarity, up to the error
    // of a gradient. That error is of order h, and least regular at the edges of the bent cube.
    let unevenness = [4, 8].map(|cells| {
        let lattice = ball(cells);
        let lift = lift(&lattice, Extension::Harmonic, 1);
        assert_eq!((lift.kind, lift.dimension), (LiftKind::SurfaceDiffusion, 3));
        stretch(&lift, &lattice).p99 - 1.0
    });
    assert!(unevenness[0] < 0.25 && unevenness[1] < 0.5 * unevenness[0], "{unevenness:?}");
}

#[test]
fn the_carried_functions_of_a_ball_are_solid_harmonics() {
    // Σ_m |r^l Y_lm|² = (2 l + 1) r^(2 l)/4π, weighted by e^(−2 λ_l t) = e^(−l (l + 1)/8), with l = 1 and 2.
    let lattice = ball(16);
    let lift = lift(&lattice, Extension::Harmonic, 10);
    assert_eq!(lift.dimension, 8);
    let squared = |r: f64| 3.0 * (-0.25_f64).exp() * r * r + 5.0 * (-0.75_f64).exp() * r.powi(4);
    let center = nearest(&lattice, 0.0, 0.0, 0.0);
    let rim = nearest(&lattice, 1.0, 0.0, 0.0);
    let unit = distance(&lift, center, rim).powi(2) / squared(1.0);
    for x in [0.25, 0.5, 0.75] {
        let node = nearest(&lattice, 0.0, x, 0.0);
        let exact = squared((lattice.nodes[node] - lattice.nodes[center]).norm());
        let ratio = distance(&lift, center, node).powi(2) / unit / exact;
        assert!((ratio - 1.0).abs() < 0.02, "at {x}: {ratio}");
    }
}

#[test]
fn separate_shells_have_separate_spectra_and_constants() {
    let lattice = hollow();
    let surface = BoundarySurface::new(&lattice);
    let shells = surface.shells();
    assert_eq!(shells.iter().map(|shell| shell.area().round()).collect::<Vec<_>>(), [216.0, 24.0]);
    let spectrum = Spectrum::of_surface(&surface, 40, &CancelToken::default()).unwrap();
    // The inner cube is a third of the outer one: its eigenvalues are nine times as large, on a coarser surface.
    let supports: Vec<bool> = (0..40)
        .map(|k| {
            let value = |node: &u32| spectrum.function(k)[*node as usize] != 0.0;
            let [outer, inner] = [0, 1].map(|shell| shells[shell].nodes.iter().any(value));
            assert!(outer != inner);
            inner
        })
        .collect();
    let first = supports.iter().position(|inner| *inner).unwrap();
    let ratio = spectrum.eigenvalues[first] / spectrum.eigenvalues[0];
    assert!((6.0..10.0).contains(&ratio), "{ratio}");
    let lift = lift(&lattice, Extension::Harmonic, 6);
    // Two constants separate the inner shell from the outer one by at least their distance.
    let (inside, outside) = (nearest(&lattice, 1.0, 0.0, 0.0), nearest(&lattice, 3.0, 0.0, 0.0));
    let opposite = nearest(&lattice, -1.0, 0.0, 0.0);
    assert!(distance(&lift, inside, opposite) < 1e-9 * distance(&lift, inside, outside));
}

/// Checks that distances between random nodes are the same on `lattice` and on its rotated, renumbered copy.
#[track_caller]
fn check_rotation(lattice: &Lattice, carry: Extension, modes: usize) {
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
    let mut turned = lattice.clone();
    turned.nodes.iter_mut().for_each(|node| *node = rotation * *node);
    turned.nodes.reverse();
    let last = lattice.nodes.len() - 1;
    turned.tets.iter_mut().flatten().for_each(|node| *node = last as u32 - *node);
    let (one, other) = (lift(lattice, carry, modes), lift(&turned, carry, modes));
    assert_eq!(one.dimension, other.dimension);
    let mut random = RandomStream::new(7, 0);
    for _ in 0..300 {
        let [a, b] = [0, 1].map(|_| (random.uniform() * lattice.nodes.len() as f64) as usize);
        let (here, there) = (distance(&one, a, b), distance(&other, last - a, last - b));
        assert!((here - there).abs() <= 1e-7 * here.max(1e-3), "{here} and {there}");
    }
}

#[test]
fn distances_do_not_depend_on_the_orientation_even_with_multiplets() {
    for carry in [Extension::Harmonic, Extension::MeanValue] {
        check_rotation(&ball(6), carry, 8);
        check_rotation(&block([4; 3], 0.1), carry, 10);
        check_rotation(&fork(), carry, 10);
        check_rotation(&hollow(), carry, 10);
    }
}

#[test]
fn the_scale_is_that_of_the_other_lifts() {
    let lattice = fork();
    for carry in [Extension::Harmonic, Extension::MeanValue] {
        let lift = lift(&lattice, carry, 10);
        let degree: f64 =
            lattice.node_volumes().iter().zip(&lift.density).map(|(volume, density)| volume * density).sum();
        let ratio = degree / lattice.volume();
        assert!((ratio - 1.0).abs() < 1e-7, "{carry:?}: {ratio}");
    }
}

#[test]
fn the_prongs_of_a_fork_are_far_apart_inside() {
    let lattice = fork();
    let tips = [nearest(&lattice, -0.05, 0.6, 0.0), nearest(&lattice, 0.05, 0.6, 0.0)];
    let solid = [nearest(&lattice, -0.25, 0.6, 0.0), nearest(&lattice, -0.15, 0.6, 0.0)];
    let lift = lift(&lattice, Extension::Harmonic, 10);
    let ratio = distance(&lift, tips[0], tips[1]) / distance(&lift, solid[0], solid[1]);
    assert!(ratio > 5.0, "{ratio}");
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let lattice = fork();
    for carry in [Extension::Harmonic, Extension::MeanValue] {
        let in_pool = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| lift(&lattice, carry, 10))
        };
        let one = in_pool(1);
        assert!(one == in_pool(2) && one == in_pool(5));
    }
}

#[test]
fn what_has_no_surface_lift_is_refused_by_name() {
    let token = CancelToken::default();
    let refused =
        |lattice: &Lattice, modes| surface_diffusion(lattice, Extension::Harmonic, modes, &token).unwrap_err();
    let cube = block([1; 3], 1.0);
    assert_eq!(refused(&cube, 65), LiftError::TooManyModes { modes: 65, max: 64 });
    assert!(matches!(refused(&Lattice::default(), 4), LiftError::TooFewNodes { .. }));
    let mut flat = cube.clone();
    flat.nodes.iter_mut().for_each(|node| *node = nalgebra::Point3::new(node.x, 0.0, 0.0));
    assert_eq!(refused(&flat, 4), LiftError::DegenerateFace { face: 0 });
    // One function of a rod, along it: the first gap is the widest.
    assert!(matches!(refused(&block([30, 2, 2], 0.1), 1), LiftError::Flat { .. }));
    let mut stray = cube;
    stray.nodes.push(stray.nodes[0]);
    assert_eq!(refused(&stray, 4), LiftError::Disconnected { components: 2 });
    token.cancel();
    assert!(matches!(refused(&block([2; 3], 1.0), 4), LiftError::Canceled(_)));
}
