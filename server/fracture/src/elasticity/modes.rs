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

use super::residual::dot;
use super::{Elasticity, ElasticityError, Support};
use crate::cancel_token::CancelToken;
use crate::dense;
use crate::lattice::Lattice;
use crate::memory::held;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of times at which a response is computed; the one of largest energy counts.
const TIMES: usize = 64;

/// Smallest relative distance from resonance. Nearer to it, the closed form would lose digits.
const RESONANCE: f64 = 1e-7;

/// Displacements whose products with the mass are computed together.
const BLOCK: usize = 8;

/// Bound of a mode's displacement under a half sine, over that under its peak at rest, for all frequencies and times.
///
/// The largest one is 1.7685, of a mode with a period of 1.23 durations.
pub const RESPONSE_MAX: f64 = 1.77;

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

/// Load of contacts of one duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseLoad<'a> {
    /// Course of its forces.
    pub pulse: Pulse,
    /// Coordinates in the basis under its peak forces at rest.
    pub coordinates: &'a [f64],
}

/// Coordinates of a displacement in a basis at the time of the largest energy of pulses that begin together.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalResponse {
    /// Time since the pulses began.
    pub time: f64,
    /// Force of each load at that time over its peak.
    pub forces: Vec<f64>,
    /// Energy of the displacement, with the remaining static one.
    pub energy: f64,
    /// Coordinates in the basis.
    pub coordinates: Vec<f64>,
}

impl ReducedModes {
    /// Modes of a basis with this B'MB, `rank × rank`. `None` if it is not positive definite.
    pub fn new(mass: &[f64], rank: usize) -> Option<Self> {
        let (matrix, mut pairs) = (MatRef::from_column_major_slice(mass, rank, rank), None);
        dense::on_own_thread(|| pairs = dense::symmetric(matrix).ok());
        let pairs = pairs?;
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

    /// Bytes of memory that they hold.
    pub(super) fn bytes(&self) -> usize {
        held(&self.frequencies) + held(&self.coordinates)
    }

    /// Response to `loads` whose static energy is larger than that in the basis by the share `missed`.
    ///
    /// Whatever the basis misses follows the forces as in statics.
    pub fn respond(&self, loads: &[PulseLoad<'_>], missed: f64) -> ModalResponse {
        let rank = self.frequencies.len();
        let modal = |load: &PulseLoad<'_>| -> Vec<f64> {
            self.coordinates.chunks_exact(rank).map(|row| dot(row, load.coordinates)).collect()
        };
        let modal: Vec<Vec<f64>> = loads.iter().map(modal).collect();
        // Twice the static energy that two loads have in common.
        let shared =
            |a: &PulseLoad<'_>| -> Vec<f64> { loads.iter().map(|b| dot(a.coordinates, b.coordinates)).collect() };
        let shared: Vec<Vec<f64>> = loads.iter().map(shared).collect();
        let forces = |time: f64| -> Vec<f64> { loads.iter().map(|load| load.pulse.force(time)).collect() };
        let amplitude = |mode: usize, time: f64| -> f64 {
            let parts = loads.iter().zip(&modal);
            parts.map(|(load, modal)| modal[mode] * load.pulse.response(self.frequencies[mode], time)).sum()
        };
        let energy = |time: f64| {
            let forces = forces(time);
            let rows = forces.iter().zip(&shared);
            let at_rest: f64 = rows.map(|(force, shared)| force * dot(shared, &forces)).sum();
            0.5 * ((0..rank).map(|mode| amplitude(mode, time).powi(2)).sum::<f64>() + missed * at_rest)
        };
        let longest = loads.iter().map(|load| load.pulse.duration).fold(0.0, f64::max);
        let end = longest + PI / self.frequencies[0];
        let times = (1..=TIMES).map(|step| end * step as f64 / TIMES as f64);
        let (time, energy) = times
            .map(|time| (time, energy(time)))
            .fold((0.0, 0.0), |best, own| if own.1 > best.1 { own } else { best });
        let mut coordinates = vec![0.0; rank];
        for (mode, row) in self.coordinates.chunks_exact(rank).enumerate() {
            let scale = amplitude(mode, time);
            coordinates.iter_mut().zip(row).for_each(|(own, row)| *own += scale * row);
        }
        ModalResponse { time, forces: forces(time), energy, coordinates }
    }
}

impl Elasticity {
    /// U'MU of displacements, of a free body without their rigid motions, in the mass of unit density; symmetric, one row per displacement.
    ///
    /// `displacements` has [`Self::unknowns`] rows and one column per displacement. `lattice` is the one that the body was
    /// made of.
    ///
    /// # Errors
    /// [`ElasticityError::Canceled`].
    ///
    /// # Panics
    /// If a length does not fit the body.
    pub(super) fn mass_gram(
        &self,
        lattice: &Lattice,
        displacements: MatRef<'_, f64>,
        token: &CancelToken,
    ) -> Result<Vec<f64>, ElasticityError> {
        let (size, count) = (self.unknowns(), displacements.ncols());
        assert_eq!(displacements.nrows(), size, "displacements fit the elements");
        // Products with all displacements, and work with the inertial forces of rigid motions, of a few columns.
        let part = |first: &usize| {
            token.check()?;
            let columns = displacements.subcols(*first, BLOCK.min(count - first));
            let mut images = Mat::<f64>::zeros(size, columns.ncols());
            let (mut own, mut image, mut works) = (vec![0.0; size], vec![0.0; size], Vec::new());
            for column in 0..columns.ncols() {
                (0..size).for_each(|row| own[row] = columns[(row, column)]);
                self.multiply_mass(&lattice.tets, &own, &mut image);
                (0..size).for_each(|row| images[(row, column)] = image[row]);
                works.push(self.inertial_work(&own));
            }
            let mut products = Mat::<f64>::zeros(columns.ncols(), count);
            matmul(&mut products, Accum::Replace, images.transpose(), displacements, 1.0, Par::Seq);
            Ok::<_, ElasticityError>((products, works))
        };
        let firsts: Vec<usize> = (0..count).step_by(BLOCK).collect();
        let parts: Vec<(Mat<f64>, Vec<[f64; 6]>)> = firsts.par_iter().map(part).collect::<Result<_, _>>()?;
        let entry = |at: usize| {
            // The lower triangle, mirrored.
            let (row, column) = ((at / count).max(at % count), (at / count).min(at % count));
            let work = |place: usize| &parts[place / BLOCK].1[place % BLOCK];
            let product = parts[row / BLOCK].0[(row % BLOCK, column)];
            match self.support() {
                Support::Free(_) => product - self.inertia.rigid_product(work(row), work(column)),
                Support::Anchored(_) => product,
            }
        };
        Ok((0..count * count).map(entry).collect())
    }
}
