//! Cases: lifts of symmetric and broken lattices.

use super::super::trial::TrialFault;
use nalgebra::{Rotation3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::lattice::{Lattice, block, stuff};
use shatter_fracture::lift::{
    ALPHA_DEFAULT, BoundarySurface, Extension, LiftError, LiftedLattice, MODES_DEFAULT, SURFACE_MODES_DEFAULT,
    interior, surface_diffusion,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::reference::ball;
use shatter_fracture::surface::{InsideTest, Surface, shapes};

fn lift(lattice: &Lattice, modes: usize) -> Result<LiftedLattice, LiftError> {
    interior(lattice, modes, ALPHA_DEFAULT, &CancelToken::default())
}

fn distance(lift: &LiftedLattice, a: usize, b: usize) -> f64 {
    lift.at(a).iter().zip(lift.at(b)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// Largest relative change of an interior distance when the lattice is rotated and its node order reversed.
fn turned(lattice: &Lattice, modes: usize) -> Result<f64, TrialFault> {
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
    let mut other = lattice.clone();
    other.nodes.iter_mut().for_each(|node| *node = rotation * *node);
    other.nodes.reverse();
    let last = lattice.nodes.len() - 1;
    other.tets.iter_mut().flatten().for_each(|node| *node = last as u32 - *node);
    let (one, two) = (lift(lattice, modes)?, lift(&other, modes)?);
    let mut stream = RandomStream::new(7, 0);
    let mut worst = 0.0f64;
    for _ in 0..500 {
        let [a, b] = [0, 1].map(|_| (stream.uniform() * lattice.nodes.len() as f64) as usize);
        let (here, there) = (distance(&one, a, b), distance(&two, last - a, last - b));
        worst = worst.max((here - there).abs() / here.max(1e-3));
    }
    Ok(worst)
}

pub fn cube() -> Result<f64, TrialFault> {
    turned(&block([6; 3], 0.1), MODES_DEFAULT)
}

pub fn cube_cut_inside_a_multiplet() -> Result<f64, TrialFault> {
    turned(&block([6; 3], 0.1), 4)
}

pub fn sphere() -> Result<f64, TrialFault> {
    turned(&ball(6), MODES_DEFAULT)
}

pub fn torus() -> Result<f64, TrialFault> {
    let surface = Surface::repair(shapes::torus(1.0, 0.35, [64, 32]))?;
    let level = stuff(&InsideTest::new(&surface), 0.06, None, &CancelToken::default())?;
    turned(&level.bodies[0], MODES_DEFAULT)
}

pub fn disconnected() -> Result<f64, TrialFault> {
    let (mut two, other) = (block([2; 3], 0.1), block([2; 3], 0.1));
    let first = two.nodes.len() as u32;
    two.nodes.extend(other.nodes.iter().map(|node| node + Vector3::x()));
    two.tets.extend(other.tets.iter().map(|tet| tet.map(|node| node + first)));
    Ok(lift(&two, MODES_DEFAULT)?.density.len() as f64)
}

pub fn tiny_lattice() -> Result<f64, TrialFault> {
    let lift = lift(&block([1; 3], 1.0), MODES_DEFAULT)?;
    let finite = lift.coordinates.iter().chain(&lift.density).all(|number| number.is_finite());
    Ok(if finite { 0.0 } else { f64::INFINITY })
}

/// Largest difference between interior and straight distance of two nodes, over the body's size, when the distances on the boundary are
/// straight: the coordinates of the boundary are extended inside.
fn straight(carry: Extension) -> Result<f64, TrialFault> {
    let lattice = ball(6);
    let (surface, token) = (BoundarySurface::new(&lattice), CancelToken::default());
    let own: Vec<f64> = surface.positions.iter().flat_map(|place| [place.x, place.y, place.z]).collect();
    let carried = carry.carry(&lattice, &surface, &own, 3, &token)?;
    let at = |node: usize| Vector3::from_column_slice(&carried[3 * node..][..3]);
    let mut stream = RandomStream::new(9, 0);
    let mut worst = 0.0f64;
    for _ in 0..500 {
        let [a, b] = [0, 1].map(|_| (stream.uniform() * lattice.nodes.len() as f64) as usize);
        worst = worst.max(((at(a) - at(b)).norm() - (lattice.nodes[a] - lattice.nodes[b]).norm()).abs() / 2.0);
    }
    Ok(worst)
}

pub fn straight_by_harmonic() -> Result<f64, TrialFault> {
    straight(Extension::Harmonic)
}

pub fn straight_by_mean_value() -> Result<f64, TrialFault> {
    straight(Extension::MeanValue)
}

pub fn flat_surface_lift() -> Result<f64, TrialFault> {
    let lift = surface_diffusion(
        &block([300, 1, 1], 0.003),
        Extension::Harmonic,
        SURFACE_MODES_DEFAULT,
        &CancelToken::default(),
    )?;
    Ok(lift.dimension as f64)
}
