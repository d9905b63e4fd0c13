//! Response of a body to a short pulse, in the modes of its reduced basis.
//!
//! The basis B is K-orthonormal. With the orthonormal eigenvectors y_k of B'MB and its eigenvalues 1/ω_k², the displacements
//! φ_k = B y_k are orthogonal in stiffness and in mass: free vibrations with the circular frequencies ω_k, approximated in
//! the span of B (Rayleigh and Ritz). Under the load f s(t), undamped and at rest before, the coordinate of φ_k is
//! y_k'B'f · D(ω_k, t). The factor D tends to s(t) for high frequencies and to 0 for low ones. So whatever the pulse is too
//! slow for answers as in statics, and no static part is subtracted from a modal one.
//!
//! Based on: A. K. Chopra, *Dynamics of Structures* (1995), section 4.8, half-cycle sine pulse; E. L. Wilson, M.-W. Yuan &
//! J. M. Dickens, *Dynamic analysis by direct superposition of Ritz vectors* (Earthquake Engineering and Structural
//! Dynamics 10, 1982), for vectors from static solutions. Their use with a basis of snapshots is ours.

use super::Elasticity;
use super::residual::dot;
use crate::dense;
use crate::lattice::Lattice;
use faer::MatRef;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of times at which a response is computed; the one of largest energy counts.
const TIMES: usize = 64;

/// Smallest relative distance from resonance. Nearer to it, the closed form would lose digits.
const RESONANCE: f64 = 1e-7;

/// Smallest eigenvalue of B'MB, over the largest, that is not rounding of a basis in single precision.
const ROUNDING: f64 = 1e-12;

/// Pulse of a contact: its force is the peak times sin(πt/τ) for 0 ≤ t ≤ τ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Duration τ, in the units of the frequencies' inverse.
    pub duration: f64,
}

impl Pulse {
    /// Force at time `t` over the peak.
    pub fn force(self, t: f64) -> f64 {
        if (0.0..=self.duration).contains(&t) { (PI * t / self.duration).sin() } else { 0.0 }
    }

    /// Displacement at time `t` of a mode of circular frequency `frequency` > 0, over that under the peak at rest.
    pub fn response(self, frequency: f64, t: f64) -> f64 {
        if t <= 0.0 {
            return 0.0;
        }
        let ratio = PI / (self.duration * frequency);
        // The response is smooth in the frequency, also in resonance, where the closed form divides by zero.
        let ratio = if (ratio - 1.0).abs() < RESONANCE { 1.0 + RESONANCE } else { ratio };
        let frequency = PI / (self.duration * ratio);
        let forced = if t < self.duration { (PI * t / self.duration).sin() } else { 0.0 };
        let delayed = (t - self.duration).max(0.0);
        let free = (frequency * t).sin() + (frequency * delayed).sin();
        (forced - ratio * free) / (1.0 - ratio * ratio)
    }
}

/// Vibrations in the span of a reduced basis.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedModes {
    /// Circular frequencies, ascending, in √(E/ρ) over the length unit.
    frequencies: Vec<f64>,
    /// Coordinates of each mode in the basis, one row per mode.
    coordinates: Vec<f64>,
}

/// Coordinates of a displacement in a basis at the time of the largest energy of a pulse.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalResponse {
    /// Time since the pulse began.
    pub time: f64,
    /// Force at that time over the peak.
    pub force: f64,
    /// Energy of the displacement, with the remaining static one.
    pub energy: f64,
    /// Coordinates in the basis.
    pub coordinates: Vec<f64>,
}

impl ReducedModes {
    /// Modes of a basis with this B'MB, `rank × rank`. `None` if it is not positive definite.
    pub fn new(mass: &[f64], rank: usize) -> Option<Self> {
        let pairs = dense::symmetric(MatRef::from_column_major_slice(mass, rank, rank)).ok()?;
        let greatest = *pairs.values.last()?;
        let is_positive = pairs.values.iter().all(|value| *value > ROUNDING * greatest);
        let order = || (0..rank).rev();
        let frequencies = order().map(|k| 1.0 / pairs.values[k].sqrt()).collect();
        let coordinates = order().flat_map(|k| (0..rank).map(move |i| (i, k))).map(|at| pairs.vectors[at]).collect();
        is_positive.then_some(Self { frequencies, coordinates })
    }

    /// Circular frequencies, ascending.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// Response to a load with these static `coordinates` in the basis, and with the energy `rest` that the basis misses.
    ///
    /// Whatever the basis misses follows the force as in statics.
    pub fn respond(&self, pulse: Pulse, coordinates: &[f64], rest: f64) -> ModalResponse {
        let rank = self.frequencies.len();
        let modal: Vec<f64> = self.coordinates.chunks_exact(rank).map(|row| dot(row, coordinates)).collect();
        let end = pulse.duration + PI / self.frequencies[0];
        let energy = |time: f64| {
            let parts = modal.iter().zip(&self.frequencies);
            let modal: f64 = parts.map(|(own, frequency)| (own * pulse.response(*frequency, time)).powi(2)).sum();
            0.5 * modal + rest * pulse.force(time).powi(2)
        };
        let times = (1..=TIMES).map(|step| end * step as f64 / TIMES as f64);
        let (time, energy) = times
            .map(|time| (time, energy(time)))
            .fold((0.0, 0.0), |best, own| if own.1 > best.1 { own } else { best });
        let mut answer = vec![0.0; rank];
        for ((own, frequency), row) in modal.iter().zip(&self.frequencies).zip(self.coordinates.chunks_exact(rank)) {
            let scale = own * pulse.response(*frequency, time);
            answer.iter_mut().zip(row).for_each(|(answer, row)| *answer += scale * row);
        }
        ModalResponse { time, force: pulse.force(time), energy, coordinates: answer }
    }
}

impl Elasticity {
    /// U'MU of displacements without their rigid motions, in the mass of unit density; symmetric, one row per displacement.
    ///
    /// `displacements` has [`Self::unknowns`] entries per displacement, and `lattice` is the one that the body was made of.
    ///
    /// # Panics
    /// If a length does not fit the body.
    pub fn mass_gram(&self, lattice: &Lattice, displacements: &[f64]) -> Vec<f64> {
        let size = self.unknowns();
        let count = displacements.len() / size;
        assert_eq!(displacements.len(), count * size, "displacements fit the elements");
        let image = |own: &[f64]| {
            let mut product = vec![0.0; size];
            self.multiply_mass(&lattice.tets, own, &mut product);
            (product, self.inertial_work(own))
        };
        let images: Vec<(Vec<f64>, [f64; 6])> = displacements.par_chunks_exact(size).map(image).collect();
        let entry = |at: usize| {
            let (row, column) = (at / count, at % count);
            // The lower triangle, mirrored.
            let (image, other) = (&images[row.max(column)], row.min(column));
            let product = dot(&image.0, &displacements[other * size..][..size]);
            product - self.inertia.rigid_product(&image.1, &images[other].1)
        };
        (0..count * count).into_par_iter().map(entry).collect()
    }
}
