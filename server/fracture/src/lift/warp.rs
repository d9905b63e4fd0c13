//! Warped reference spaces: the lattice, mapped to a space in which an artist controls distances.
//!
//! A lift that is computed on the warped lattice and used on the original has cells that are straight in the reference
//! space and bent in the original.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014),
//! for cells in another space than the object's; Q. Du & D. Wang, *Anisotropic centroidal Voronoi tessellations
//! and their applications* (SIAM Journal on Scientific Computing 26, 2005) for a metric as the control; M.
//! Shinozuka & G. Deodatis, *Simulation of stochastic processes by spectral representation* (Applied Mechanics
//! Reviews 44, 1991) for random waves.

use crate::lattice::Lattice;
use crate::random::RandomStream;
use nalgebra::{Point3, Unit, Vector3};
use std::f64::consts::TAU;

/// Number of waves in a displacement: few enough to be smooth, enough to have no preferred direction.
const WAVES: usize = 8;

/// Smallest accepted volume of a warped tetrahedron, over its expected volume.
const SQUEEZE_MIN: f64 = 0.05;

/// Random stream of the waves.
const STREAM: u64 = 0x7761_7665;

/// Map of local space to a reference space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpaceWarp {
    grain: Option<(Unit<Vector3<f64>>, f64)>,
    waves: Vec<Wave>,
}

/// Wave of the displacement: amplitude, wave vector, phase.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    amplitude: Vector3<f64>,
    vector: Vector3<f64>,
    phase: f64,
}

impl SpaceWarp {
    /// Adds a grain: distances along `axis` count `ratio` times less than across it, so cells are that much longer.
    #[must_use]
    pub fn grain(mut self, axis: Unit<Vector3<f64>>, ratio: f64) -> Self {
        self.grain = Some((axis, ratio));
        self
    }

    /// Adds random waves of length `length` (local) and root mean square slope `slope`, drawn from `seed`.
    ///
    /// They bend planes of the reference space. Every wave displaces space perpendicular to its own direction: a shear,
    /// which keeps all volumes, so space folds only at large slopes. With K waves of amplitude A the mean square of a
    /// directional derivative is K·(2πA/λ)²/6: a third for the direction, half for the phase.
    #[must_use]
    pub fn waves(mut self, length: f64, slope: f64, seed: u64) -> Self {
        let amplitude = slope * length / TAU * (6.0 / WAVES as f64).sqrt();
        let mut random = RandomStream::new(seed, STREAM);
        let wave = |_| {
            let (along, other) = (direction(&mut random), direction(&mut random));
            let across = along.cross(&other).try_normalize(0.0).unwrap_or_default();
            Wave { amplitude: across * amplitude, vector: along * (TAU / length), phase: TAU * random.uniform() }
        };
        self.waves = (0..WAVES).map(wave).collect();
        self
    }

    /// Returns true if the map is the identity.
    pub fn is_identity(&self) -> bool {
        self.grain.is_none() && self.waves.is_empty()
    }

    /// Position of `point` in the reference space.
    pub fn map(&self, point: &Point3<f64>) -> Point3<f64> {
        let mut to = *point;
        for wave in &self.waves {
            to += wave.amplitude * (wave.vector.dot(&point.coords) + wave.phase).sin();
        }
        if let Some((axis, ratio)) = &self.grain {
            to -= axis.as_ref() * (axis.dot(&to.coords) * (1.0 - 1.0 / ratio));
        }
        to
    }

    /// Lattice in the reference space.
    ///
    /// Errors: the first tetrahedron that is inverted or squeezed to nothing, because space folds there.
    ///
    /// # Errors
    /// The first tetrahedron that is turned over or squeezed to nothing: space folds there.
    pub fn lattice(&self, lattice: &Lattice) -> Result<Lattice, usize> {
        let warped =
            Lattice { nodes: lattice.nodes.iter().map(|node| self.map(node)).collect(), tets: lattice.tets.clone() };
        let scale = self.grain.map_or(1.0, |(_, ratio)| ratio.recip());
        let squeezed = |tet: &usize| {
            let volume = warped.tet_volume(*tet) / (lattice.tet_volume(*tet) * scale);
            volume.is_nan() || volume < SQUEEZE_MIN
        };
        match (0..lattice.tets.len()).find(squeezed) {
            Some(tet) => Err(tet),
            None => Ok(warped),
        }
    }
}

/// Random direction, uniform on the sphere (Archimedes: its height is uniform).
fn direction(random: &mut RandomStream) -> Vector3<f64> {
    let height = 2.0 * random.uniform() - 1.0;
    let (sine, cosine) = (TAU * random.uniform()).sin_cos();
    let radius = (1.0 - height * height).sqrt();
    Vector3::new(radius * cosine, radius * sine, height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    #[test]
    fn a_grain_shortens_its_axis_alone() {
        let axis = Unit::new_normalize(Vector3::new(1.0, 2.0, 2.0));
        let warp = SpaceWarp::default().grain(axis, 4.0);
        let (along, across) = (Point3::from(axis.into_inner()), Point3::new(2.0, -2.0, 1.0));
        assert!((warp.map(&along).coords - along.coords / 4.0).norm() < 1e-15);
        assert!((warp.map(&across) - across).norm() < 1e-15);
    }

    #[test]
    fn waves_have_the_slope_that_was_asked_for() {
        let slope = |seed: u64| {
            let warp = SpaceWarp::default().waves(0.2, 0.5, seed);
            let mut random = RandomStream::new(seed, 1);
            let step = 1e-5;
            let mut sum = 0.0;
            for _ in 0..2000 {
                let at = Point3::new(random.uniform(), random.uniform(), random.uniform());
                let to = direction(&mut random) * step;
                let moved = (warp.map(&(at + to)) - warp.map(&at) - to) / step;
                sum += moved.norm_squared() / 2000.0;
            }
            sum.sqrt()
        };
        let mean = (0..20).map(slope).sum::<f64>() / 20.0;
        assert!((mean - 0.5).abs() < 0.03, "{mean}");
    }

    #[test]
    fn folding_warps_are_rejected() {
        let lattice = block([6, 6, 6], 1.0 / 6.0);
        assert!(SpaceWarp::default().waves(0.5, 0.3, 1).lattice(&lattice).is_ok());
        assert!(SpaceWarp::default().waves(0.5, 5.0, 1).lattice(&lattice).is_err());
        assert!(SpaceWarp::default().grain(Vector3::y_axis(), 8.0).lattice(&lattice).is_ok());
        assert!(SpaceWarp::default().waves(f64::NAN, 0.3, 1).lattice(&lattice).is_err());
    }
}
