//! Stress on the surface of a half-space under a tangential force.
//!
//! Cerruti's displacements of a force along the surface (Johnson, *Contact Mechanics*, 1985, section 3.6), summed over
//! tractions q(ρ) along x, have on the x axis the stresses
//!
//! ```text
//! σ_x = (Φ' + ν S')/π,   σ_y = ν (Φ' − S')/π,   τ_xz = q,   with   Φ = ∫ q/r dA   and   S' = ρ⁻³ ∫₀^ρ s² Φ'(s) ds.
//! ```
//!
//! Ahead of a force it presses, behind it it pulls. Here q is the bell of contacts. Its Φ is that of Hertz's tractions
//! p √(1 − ρ²/a²) of many radii a, into which Abel's integral equation divides the bell:
//!
//! ```text
//! p da = (2a/π) (exp(−9/2) + v exp(−a²/2) ∫₀^v exp(−u²/2) du) dv   with   v = √(9 − a²).
//! ```

use super::near_field::{SAMPLES, middle_of};
use crate::elasticity::{BELL_CUT, BELL_RADII};
use crate::memory::held;
use std::f64::consts::{FRAC_2_PI, PI};

/// Number of Hertz's tractions.
const DISCS: usize = 256;

/// Stresses ahead of a bell of unit peak traction, at samples from its middle to its rim.
#[derive(Clone, Debug, PartialEq)]
pub struct SlidingStress {
    /// Φ' and S' of each sample.
    slopes: Vec<[f64; 2]>,
}

impl SlidingStress {
    /// The stresses of the bell.
    #[expect(clippy::new_without_default, reason = "no value of a table is a default")]
    pub fn new() -> Self {
        Self::of(&bell_discs())
    }

    fn of(discs: &[[f64; 2]]) -> Self {
        let step = BELL_RADII / SAMPLES as f64;
        let slope = |t: f64| discs.iter().map(|[radius, peak]| peak * potential_slope(t, *radius)).sum::<f64>();
        let mut moment = 0.0;
        let sample = |sample: usize| {
            let t = middle_of(sample);
            let own = slope(t);
            // Half of the interval counts before its middle, half after it.
            let half = 0.5 * step * t * t * own;
            moment += half;
            let slopes = [own, moment / t.powi(3)];
            moment += half;
            slopes
        };
        Self { slopes: (0..SAMPLES).map(sample).collect() }
    }

    /// Stresses along and across the force at a sample ahead of it, per unit of the peak traction.
    pub(super) fn at(&self, sample: usize, poisson: f64) -> [f64; 2] {
        let [potential, other] = self.slopes[sample];
        [(potential + poisson * other) / PI, poisson * (potential - other) / PI]
    }

    /// Bytes of memory that they hold.
    pub fn bytes(&self) -> usize {
        held(&self.slopes)
    }
}

/// Radii and peaks of Hertz's tractions whose sum is the bell.
fn bell_discs() -> Vec<[f64; 2]> {
    let step = BELL_RADII / DISCS as f64;
    let mut integral = 0.0;
    let disc = |disc: usize| {
        let v = (disc as f64 + 0.5) * step;
        let (square, half) = (BELL_RADII * BELL_RADII - v * v, 0.5 * step * (-0.5 * v * v).exp());
        integral += half;
        let density = BELL_CUT + v * (-0.5 * square).exp() * integral;
        integral += half;
        [square.sqrt(), FRAC_2_PI * square.sqrt() * density * step]
    };
    (0..DISCS).map(disc).collect()
}

/// Φ' at `t` of Hertz's traction √(1 − ρ²/a²).
fn potential_slope(t: f64, a: f64) -> f64 {
    if t <= a {
        return -0.5 * PI * PI * t / a;
    }
    PI * ((t * t - a * a).sqrt() / t - t / a * (a / t).asin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elasticity::bell;
    use crate::strength::near_field::FORCE;

    #[test]
    fn discs_add_up_to_the_bell() {
        let discs = bell_discs();
        for t in [0.0_f64, 0.3, 1.0, 2.0, 2.9] {
            let inside = discs.iter().filter(|[radius, _]| *radius > t);
            let sum: f64 = inside.map(|[radius, peak]| peak * (1.0 - (t / radius).powi(2)).sqrt()).sum();
            assert!((sum - bell(t)).abs() < 1e-3, "{t}: {sum} for {}", bell(t));
        }
        // The force of Hertz's traction is 2πa²/3.
        let force: f64 = discs.iter().map(|[radius, peak]| peak * 2.0 * PI / 3.0 * radius * radius).sum();
        assert!((force / FORCE - 1.0).abs() < 1e-4, "{force}");
    }

    /// G. M. Hamilton & L. E. Goodman, *The stress field created by a circular sliding contact* (Journal of Applied Mechanics
    /// 33, 1966): at the rear edge of Hertz's contact, σ_x = q₀ π (4 + ν)/8.
    #[test]
    fn the_rear_edge_of_hertz_is_pulled_as_its_closed_form_says() {
        let found = SlidingStress::of(&[[BELL_RADII, 1.0]]).at(SAMPLES - 1, 0.3)[0];
        let place = middle_of(SAMPLES - 1) / BELL_RADII;
        let exact = -PI * 4.3 / 8.0 * place;
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} for {exact}");
    }

    /// Far from a force F, Cerruti has σ_x = −(1 + ν) F/(πρ²) and σ_y = 0 on its line of action.
    #[test]
    fn small_contacts_have_the_stress_of_a_point_force() {
        let radius = 0.1;
        let found = SlidingStress::of(&[[radius, 1.0]]).at(SAMPLES - 1, 0.3);
        let force = 2.0 * PI / 3.0 * radius * radius;
        let exact = -1.3 * force / (PI * middle_of(SAMPLES - 1).powi(2));
        assert!((found[0] / exact - 1.0).abs() < 0.01 && found[1].abs() < 0.01 * exact.abs(), "{found:?} for {exact}");
    }
}
