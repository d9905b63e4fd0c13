//! Elastic bodies with closed-form solutions, for tests of [`crate::elasticity`]. Young's modulus is 1.
//!
//! Based on: S. Timoshenko and J. N. Goodier, *Theory of Elasticity* (1951), chapters 9 and 12 (pure bending of beams
//! and plates); B. M. Irons and A. Razzaque, *Experience with the patch test* (1972).

use crate::cancel_token::CancelToken;
use crate::elasticity::{DrivingEnergy, ElasticWorkspace, Elasticity, ElasticityError, PinnedNodes, Support};
use crate::lattice::{Lattice, block};
use nalgebra::{Matrix3, Point3, Vector3};

/// Consistent nodal forces (three per node) of the traction σ(x) n on the boundary. `stress`, σ, must be linear in x.
pub fn traction(lattice: &Lattice, stress: impl Fn(Point3<f64>) -> Matrix3<f64>) -> Vec<f64> {
    let mut forces = vec![0.0; 3 * lattice.nodes.len()];
    for face in lattice.boundary() {
        let [a, b, c] = face.nodes.map(|node| lattice.nodes[node as usize]);
        let area = (b - a).cross(&(c - a)) * 0.5;
        let tractions = [a, b, c].map(|place| stress(place) * area);
        let sum: Vector3<f64> = tractions.iter().sum();
        for (&node, own) in face.nodes.iter().zip(tractions) {
            let force = (sum + own) / 12.0;
            forces[3 * node as usize..][..3].iter_mut().zip(force.iter()).for_each(|(f, df)| *f += df);
        }
    }
    forces
}

/// Displacement (three per node) and strain energy (one per tetrahedron) under `forces`.
fn solved(body: &Elasticity, lattice: &Lattice, forces: &[f64]) -> Result<(Vec<f64>, Vec<f64>), ElasticityError> {
    let (mut displacement, mut energies, token) = (Vec::new(), Vec::new(), CancelToken::default());
    body.solve(forces, &mut displacement, &mut ElasticWorkspace::default(), &token)?;
    body.tet_energy(lattice, &displacement, DrivingEnergy::Total, &mut energies, &token)?;
    Ok((displacement, energies))
}

/// Patch test: largest relative error of any tetrahedron's energy over six states of constant stress.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn patch_error(lattice: &Lattice, poisson: f64) -> Result<f64, ElasticityError> {
    let body = Elasticity::prepare(lattice, poisson, &CancelToken::default())?;
    let mut worst = 0.0f64;
    for (row, column) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let mut stress = Matrix3::zeros();
        (stress[(row, column)], stress[(column, row)]) = (1.0, 1.0);
        let strain = stress * (1.0 + poisson) - Matrix3::from_diagonal_element(poisson * stress.trace());
        let density = 0.5 * stress.dot(&strain);
        let (_, energies) = solved(&body, lattice, &traction(lattice, |_| stress))?;
        for (tet, energy) in energies.iter().enumerate() {
            worst = worst.max((energy / (density * lattice.tet_volume(tet)) - 1.0).abs());
        }
    }
    Ok(worst)
}

/// Half sides of a block centered on the origin.
fn half_sides(lattice: &Lattice) -> Vector3<f64> {
    lattice.nodes.iter().fold(Vector3::zeros(), |size: Vector3<f64>, node| size.sup(&node.coords))
}

/// Solves pure bending of a free block as a beam along x, σ_xx = z.
///
/// Takes any Poisson's ratio, also one that baking rejects. The exact displacement is u = (x z,
/// −ν y z, −(x² + ν(z² − y²))/2).
fn bent(lattice: &Lattice, poisson: f64) -> Result<(Vec<f64>, Vec<f64>), ElasticityError> {
    let forces = traction(lattice, |place| Matrix3::from_diagonal(&Vector3::new(place.z, 0.0, 0.0)));
    solved(&Elasticity::with_any_law(lattice, poisson)?, lattice, &forces)
}

/// Relative energy error of the beam in pure bending: (exact − computed)/exact, with exact energy ½ ∫ z².
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn bending_error(lattice: &Lattice, poisson: f64) -> Result<f64, ElasticityError> {
    let size = half_sides(lattice) * 2.0;
    let exact = 0.5 * size.x * size.y * size.z.powi(3) / 12.0;
    Ok(1.0 - bent(lattice, poisson)?.1.iter().sum::<f64>() / exact)
}

/// Relative sagitta error of the beam in pure bending: (exact − computed)/exact.
///
/// The sagitta is the distance of the middle of the axis from the chord of its ends, L²/8. The lattice must have nodes
/// at the ends and the middle of the axis.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn bending_sagitta_error(lattice: &Lattice, poisson: f64) -> Result<f64, ElasticityError> {
    let half = half_sides(lattice).x;
    let (displacement, _) = bent(lattice, poisson)?;
    let lift = |x: f64| {
        let distance = |node: &usize| (lattice.nodes[*node] - Point3::new(x, 0.0, 0.0)).norm();
        let nearest = (0..lattice.nodes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(0.0, |node| displacement[3 * node + 2])
    };
    Ok(1.0 - (lift(0.0) - 0.5 * (lift(-half) + lift(half))) / (0.5 * half * half))
}

/// Relative energy error of a plate bent to a sphere, σ_xx = σ_yy = z.
///
/// (exact − computed)/exact with exact energy (1 − ν) A t³/12.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn plate_error(lattice: &Lattice, poisson: f64) -> Result<f64, ElasticityError> {
    let forces = traction(lattice, |place| Matrix3::from_diagonal(&Vector3::new(place.z, place.z, 0.0)));
    let body = Elasticity::prepare(lattice, poisson, &CancelToken::default())?;
    let size = half_sides(lattice) * 2.0;
    let exact = (1.0 - poisson) * size.x * size.y * size.z.powi(3) / 12.0;
    Ok(1.0 - solved(&body, lattice, &forces)?.1.iter().sum::<f64>() / exact)
}

/// Relative energy error of an anchored cantilever, 8:1, under a transverse end load, ν = 0.
///
/// (theory − computed)/theory with the energy F²L³/(6EI) + F²L/(2κGA), κ = 5/6, of Timoshenko's beam.
/// `fine` cubes span the height.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn cantilever_error(fine: usize) -> Result<f64, ElasticityError> {
    let lattice = block([8 * fine, fine, fine], 1.0 / fine as f64);
    let clamped = (0..lattice.nodes.len() as u32).filter(|&node| lattice.nodes[node as usize].x < -3.999).collect();
    let body = Elasticity::supported(&lattice, 0.0, Support::Anchored(clamped), &CancelToken::default())?;
    let forces = traction(&lattice, |place| {
        let mut stress = Matrix3::zeros();
        stress[(2, 0)] = if place.x > 3.999 { 1.0 } else { 0.0 };
        stress
    });
    let theory = 8.0_f64.powi(3) / (6.0 / 12.0) + 8.0 / (2.0 * 5.0 / 6.0 * 0.5);
    Ok(1.0 - solved(&body, &lattice, &forces)?.1.iter().sum::<f64>() / theory)
}

/// Relative energy error of a free bar, 4:1, pushed at one end, ν = 0.
///
/// (exact − computed)/exact with exact energy A L/6: the bar accelerates as a whole, and the stress falls linearly to
/// zero at the far end. `fine` cubes span the height.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn bar_error(fine: usize) -> Result<f64, ElasticityError> {
    let lattice = block([4 * fine, fine, fine], 0.25 / fine as f64);
    let body = Elasticity::prepare(&lattice, 0.0, &CancelToken::default())?;
    let push = |place: Point3<f64>| if place.x > 0.499 { -1.0 } else { 0.0 };
    let mut forces = traction(&lattice, |place| Matrix3::from_diagonal(&Vector3::new(push(place), 0.0, 0.0)));
    body.relieve(&mut forces);
    Ok(1.0 - solved(&body, &lattice, &forces)?.1.iter().sum::<f64>() / (0.0625 / 6.0))
}

/// Bar along x, 4:1, of length 1, ν = 0, anchored at its low end. `fine` cubes span the height.
fn fixed_bar(fine: usize) -> Result<(Lattice, Elasticity), ElasticityError> {
    let lattice = block([4 * fine, fine, fine], 0.25 / fine as f64);
    let end = (0..lattice.nodes.len() as u32).filter(|&node| lattice.nodes[node as usize].x < -0.499).collect();
    let token = CancelToken::default();
    let body = Elasticity::assembled(&lattice, 0.0, &token)?.anchored(end, &token)?;
    Ok((lattice, body))
}

/// Relative energy error of an anchored bar that hangs by its weight, ρg = 1.
///
/// (exact − computed)/exact with exact energy A L³/6: the stress falls linearly to zero at the free end.
/// `fine` cubes span the height.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn hanging_error(fine: usize) -> Result<f64, ElasticityError> {
    let (lattice, body) = fixed_bar(fine)?;
    Ok(1.0 - solved(&body, &lattice, &body.weight(&Vector3::x()))?.1.iter().sum::<f64>() / (0.0625 / 6.0))
}

/// Relative energy error of an anchored bar pushed with stress 1 at its free end.
///
/// (exact − computed)/exact with exact energy A L/2. `fine` cubes span the height.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn fixed_bar_error(fine: usize) -> Result<f64, ElasticityError> {
    let (lattice, body) = fixed_bar(fine)?;
    let push = |place: Point3<f64>| if place.x > 0.499 { -1.0 } else { 0.0 };
    let forces = traction(&lattice, |place| Matrix3::from_diagonal(&Vector3::new(push(place), 0.0, 0.0)));
    Ok(1.0 - solved(&body, &lattice, &forces)?.1.iter().sum::<f64>() / (0.0625 / 2.0))
}

/// Effect of the choice of pinned nodes on the energies of a free block.
///
/// Returns the largest difference of any tetrahedron's energy between two choices of the three nodes, relative to the
/// largest energy. The load is the traction of a smooth stress.
///
/// # Errors
/// [`ElasticityError`] for a lattice that cannot be solved.
pub fn pin_difference(lattice: &Lattice) -> Result<f64, ElasticityError> {
    let forces = traction(lattice, |place| Matrix3::from_diagonal(&Vector3::new(place.z, 1.0, 0.0)));
    let last = lattice.nodes.len() as u32 - 1;
    let near = PinnedNodes::on(lattice, [0, 1, last / 2]).or_else(|| PinnedNodes::far_apart(lattice));
    let supports = [near, PinnedNodes::far_apart(lattice)];
    let mut energies = Vec::new();
    for pins in supports.into_iter().flatten() {
        let body = Elasticity::supported(lattice, 0.3, Support::Free(pins), &CancelToken::default())?;
        energies.push(solved(&body, lattice, &forces)?.1);
    }
    let largest = energies.iter().flatten().copied().fold(0.0, f64::max);
    let pairs = energies.windows(2).flat_map(|pair| pair[0].iter().zip(&pair[1]));
    Ok(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest)
}
