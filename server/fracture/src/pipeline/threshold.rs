//! Threshold: does the object break at all?
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3.1: an object breaks if its distance-weighted deformation energy
//! exceeds γ. E_1 is the energy of the whole body as one fragment.

use super::{BodyEnergy, Prepared};
use crate::centroidal::Field;
use crate::degree;

/// E_1 of every struck body against γ.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// γ, J·m².
    pub gamma_j_m2: f64,
    /// The struck bodies.
    pub bodies: Vec<usize>,
    /// γ of each struck body in units of its own share field: dimensionless, local.
    pub gammas: Vec<f64>,
    /// E_1 of each struck body, in the same units.
    pub first_moments: Vec<f64>,
}

impl Verdict {
    /// Compares each field's first moment with γ.
    pub fn new(prepared: &Prepared, gamma_j_m2: f64, energies: &[BodyEnergy], fields: &[Field]) -> Self {
        let unit = |energy: &BodyEnergy| gamma_j_m2 / energy.unit_j_m2(prepared.frame.diagonal_m);
        let gammas: Vec<f64> = energies.iter().map(unit).collect();
        let bodies = energies.iter().map(|energy| energy.body).collect();
        Self { gamma_j_m2, bodies, gammas, first_moments: fields.iter().map(degree::first_moment).collect() }
    }

    /// The largest E_1/γ; above 1 something breaks.
    pub fn e1_over_gamma(&self) -> f64 {
        self.first_moments.iter().zip(&self.gammas).map(|(first, gamma)| first / gamma).fold(0.0, f64::max)
    }

    /// Impulses times this factor just break the object; energies grow with the square of the impulse.
    pub fn impulse_factor(&self) -> f64 {
        degree::threshold_factor(self.e1_over_gamma(), 1.0)
    }
}
