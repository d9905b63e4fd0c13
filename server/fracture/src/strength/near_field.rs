//! Stress on the surface around a contact, as on a half-space.
//!
//! Lattices do not resolve contacts, so that the stress around one is not theirs. Under axially symmetric pressure p(ρ) the
//! surface of a half-space has the stresses
//!
//! ```text
//! σ_ρ = (1 − 2ν) P(ρ)/(2πρ²) − p(ρ),   σ_θ = −(1 − 2ν) P(ρ)/(2πρ²) − 2ν p(ρ),   σ_z = −p(ρ),
//! ```
//!
//! with P(ρ) the force within ρ. For Hertz's pressure these are equations 3.44 and 3.45 of Johnson, *Contact Mechanics*
//! (1985), with the tension (1 − 2ν)p₀/3 at the rim. Here p is the bell by which forces are applied,
//! p = p₀ (exp(−t²/2) − exp(−9/2)) with t = ρ/r up to 3, so that P = 2πp₀r² (1 − exp(−t²/2) − exp(−9/2) t²/2). Its tension
//! is largest near t = 3, where it is (1 − 2ν) p₀/10: a soft edge pulls less than that of Hertz. A tangential force adds
//! the stresses of [`SlidingStress`].

use super::sliding::SlidingStress;
use super::stress::equivalent_of;
use crate::elasticity::{BELL_CUT, BELL_RADII, bell};
use std::f64::consts::TAU;

/// Samples from the center to the rim.
pub(super) const SAMPLES: usize = 96;

/// Force of the bell over p₀r².
pub(super) const FORCE: f64 = TAU * (1.0 - BELL_CUT * (1.0 + 0.5 * BELL_RADII * BELL_RADII));

/// Contact on a half-space.
#[derive(Clone, Copy, Debug)]
pub struct NearField<'a> {
    /// Force into the surface; negative if it pulls.
    pub force: f64,
    /// Force along the surface.
    pub tangential: f64,
    /// Contact radius r.
    pub radius: f64,
    /// Poisson's ratio ν.
    pub poisson: f64,
    /// Stresses under a tangential force.
    pub sliding: &'a SlidingStress,
}

impl NearField<'_> {
    /// Largest average of the equivalent stress over lines of half length `length`, in force per area.
    ///
    /// The lines are on the surface, along the tangential force, and their middles within the contact. `ratio` is σ_t/σ_c;
    /// see `equivalent_of`.
    pub fn largest(&self, length: f64, ratio: f64) -> f64 {
        let step = BELL_RADII / SAMPLES as f64;
        // In the direction of the tangential force, and against it, where it pulls.
        let [ahead, behind] = [1.0, -1.0].map(|side| {
            let mut sums = [0.0; SAMPLES + 1];
            for sample in 0..SAMPLES {
                sums[sample + 1] = sums[sample] + step * self.equivalent(sample, side, ratio);
            }
            // Beyond the rim, stresses fall with the inverse square.
            (sums, self.equivalent(SAMPLES - 1, side, ratio) * middle_of(SAMPLES - 1).powi(2))
        });
        let integral = |t: f64| {
            let ((sums, tail), distance) = (if t < 0.0 { &behind } else { &ahead }, t.abs());
            let (place, index) = (distance / step, ((distance / step) as usize).min(SAMPLES));
            let inside = match sums.get(index + 1) {
                Some(next) => sums[index] + (place - index as f64) * (next - sums[index]),
                None => sums[SAMPLES] + tail * (1.0 / BELL_RADII - 1.0 / distance),
            };
            t.signum() * inside
        };
        let half = length / self.radius;
        let average = |t: f64| (integral(t + half) - integral(t - half)) / (2.0 * half);
        let samples = -(SAMPLES as isize)..=SAMPLES as isize;
        samples.map(|sample| average(sample as f64 * step)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Equivalent stress at a sample from the middle to the rim, ahead of it (`side` 1) or behind it (−1).
    fn equivalent(&self, sample: usize, side: f64, ratio: f64) -> f64 {
        let t = middle_of(sample);
        let area = FORCE * self.radius * self.radius;
        let (peak, traction) = (self.force / area, self.tangential / area);
        let pressure = peak * bell(t);
        // P/(2πρ²).
        let within = peak * (1.0 - (-0.5 * t * t).exp() - 0.5 * BELL_CUT * t * t) / (t * t);
        let stretch = (1.0 - 2.0 * self.poisson) * within;
        let [along, across] = self.sliding.at(sample, self.poisson).map(|stress| side * traction * stress);
        let (along, across) = (stretch - pressure + along, -stretch - 2.0 * self.poisson * pressure + across);
        let (mean, half) = (0.5 * (along - pressure), 0.5 * (along + pressure));
        let radius = half.hypot(traction * bell(t));
        let mut principal = [mean + radius, across, mean - radius];
        principal.sort_by(|a, b| b.total_cmp(a));
        equivalent_of(&principal, ratio)
    }
}

/// Distance of the middle of an interval between samples, over the contact radius.
pub(super) fn middle_of(sample: usize) -> f64 {
    (sample as f64 + 0.5) * BELL_RADII / SAMPLES as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bell_has_the_force_that_it_is_given() {
        let step = 1e-4;
        let sum: f64 = (0..30_000).map(|k| (k as f64 + 0.5) * step).map(|t| TAU * t * step * bell(t)).sum();
        assert!((sum / FORCE - 1.0).abs() < 1e-7);
    }

    fn contact(force: f64, tangential: f64, sliding: &SlidingStress) -> NearField<'_> {
        NearField { force, tangential, radius: 1.0, poisson: 0.22, sliding }
    }

    #[test]
    fn the_rim_of_a_pressed_contact_is_under_tension_and_its_middle_is_not() {
        let sliding = SlidingStress::new();
        let contact = contact(FORCE, 0.0, &sliding);
        // p₀ = 1; σ_t/σ_c so small that compression does not count.
        let most = contact.largest(1e-3, 0.0);
        assert!((0.05..0.06).contains(&most), "{most}");
        assert!(contact.equivalent(3, 1.0, 0.05) < 0.0);
        // At the rim: (1 − 2ν) F/(2π·9) under tension, and as much compression across it.
        let rim = contact.equivalent(SAMPLES - 1, 1.0, 0.0);
        assert!((rim - 0.56 * FORCE / (TAU * 9.0)).abs() < 1e-3, "{rim}");
    }

    #[test]
    fn a_pulled_contact_has_its_peak_traction_in_the_middle() {
        let sliding = SlidingStress::new();
        let contact = contact(-FORCE, 0.0, &sliding);
        assert!((contact.largest(1e-2, 0.05) - (1.0 - BELL_CUT)).abs() < 1e-2);
        // Long averages fall: a pebble is nothing to a length that is much larger.
        let averages = [1.0, 10.0, 100.0].map(|length| contact.largest(length, 0.05));
        assert!(
            averages[0] < 1.0 && averages[1] < 0.3 * averages[0] && averages[2] < 0.2 * averages[1],
            "{averages:?}"
        );
    }

    /// Friction moves the tension of a pressed contact behind it and multiplies it.
    #[test]
    fn a_sliding_contact_is_pulled_behind_and_pressed_ahead() {
        let sliding = SlidingStress::new();
        let at = |friction: f64| contact(FORCE, friction * FORCE, &sliding);
        let most = [0.0, 0.1, 0.5].map(|friction| at(friction).largest(1e-3, 0.0));
        assert!(most[1] > 1.5 * most[0] && most[2] > 5.0 * most[0], "{most:?}");
        let rim = [1.0, -1.0].map(|side| at(0.5).equivalent(SAMPLES - 1, side, 0.0));
        assert!(rim[1] > 3.0 * rim[0].max(0.0), "{rim:?}");
        // In the middle, its traction shears the surface alone.
        assert!((contact(0.0, FORCE, &sliding).equivalent(0, 1.0, 0.0) - bell(middle_of(0))).abs() < 0.02);
        // Without pressure, both sides differ in sign alone, and a force that slides back changes nothing.
        let alone = contact(0.0, FORCE, &sliding);
        let back = contact(0.0, -FORCE, &sliding);
        assert!((alone.largest(1e-2, 0.05) - back.largest(1e-2, 0.05)).abs() < 1e-12);
    }
}
