//! Energies of the indentations under contacts, and the load that an energy allows.
//!
//! A ball indents a body by less than proportionally to its force F, since the contact grows: by Hertz, the contact radius a
//! follows F^(1/3), and the energy of the body's own indentation is 3F²(1 − ν²)/(10 E a), which follows F^(5/3). The strain
//! energy U of a load has the indentation of a bell of fixed radius instead, U_bell. With the factor s on all loads, the
//! energy of the impact is
//!
//! ```text
//! E_in = s² (U − Σ U_bell) + s^(5/3) Σ U_Hertz.
//! ```
//!
//! Based on: K. L. Johnson, *Contact Mechanics* (1985), section 4.2 (Hertz); K. N. Shivakumar, W. Elber & W. Illg,
//! *Prediction of impact force and duration due to low-velocity impact on circular composite laminates* (Journal of
//! Applied Mechanics 52, 1985), the balance. The indentation of the striking body is left out, since its material is unknown.

use crate::elasticity::{ContactLoad, NodalLoad, bell_indentation};

/// Energies of the indentations of a body under the requested load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IndentationEnergy {
    /// Of bells on a half-space: a part of the strain energy, J.
    pub bells_j: f64,
    /// By Hertz, J, with the contact radii of the request, or the distances of the lattice from its points if they are larger.
    /// Contacts count one by one, also at one place.
    pub hertz_j: f64,
}

impl IndentationEnergy {
    /// Energies of `contacts`, which `load` applied. Local energies have `unit_j` joules.
    pub(super) fn new(contacts: &[ContactLoad], load: &NodalLoad, poisson: f64, unit_j: f64) -> Self {
        let mut sum = Self::default();
        for (contact, touch) in contacts.iter().zip(&load.touches) {
            let force = (-touch.impulse.dot(&touch.normal)).max(0.0);
            sum.bells_j += unit_j * bell_indentation(force, touch.radius, poisson);
            sum.hertz_j += unit_j * 0.3 * force * force * (1.0 - poisson * poisson) / contact.radius;
        }
        sum
    }
}

/// The factor s of the module's equation, at most 1: `strain_j` is U, and `energy_j` is E_in.
pub(super) fn load_factor(energy_j: f64, strain_j: f64, indentation: IndentationEnergy) -> f64 {
    let (rest_j, hertz_j) = ((strain_j - indentation.bells_j).max(0.0), indentation.hertz_j);
    if energy_j >= rest_j + hertz_j {
        return 1.0;
    }
    // One of the terms alone allows no more. The sum is convex, so that steps from above stay above.
    let mut factor = (energy_j / rest_j).sqrt().min((energy_j / hertz_j).powf(0.6)).min(1.0);
    for _ in 0..STEPS {
        let [bulk_j, own_j] = [rest_j * factor * factor, hertz_j * factor.powf(5.0 / 3.0)];
        let excess = bulk_j + own_j - energy_j;
        if factor == 0.0 || excess <= 0.0 {
            break;
        }
        factor -= factor * excess / (2.0 * bulk_j + 5.0 / 3.0 * own_j);
    }
    factor
}

/// Steps of Newton's iteration, which doubles its digits: more than the first value needs.
const STEPS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_balance_the_energies() {
        for (strain_j, bells_j, hertz_j) in
            [(5.0, 1.0, 2.0), (5.0, 0.0, 0.0), (1.0, 1.0, 2.0), (3.0, 1e-9, 1e-9), (0.0, 0.0, 1.0)]
        {
            let indentation = IndentationEnergy { bells_j, hertz_j };
            let whole_j = strain_j - bells_j + hertz_j;
            assert_eq!(load_factor(1.001 * whole_j, strain_j, indentation), 1.0);
            assert_eq!(load_factor(0.0, strain_j, indentation), 0.0);
            for share in [1e-30, 1e-3, 0.5, 0.999] {
                let factor = load_factor(share * whole_j, strain_j, indentation);
                let found = (strain_j - bells_j) * factor * factor + hertz_j * factor.powf(5.0 / 3.0);
                assert!((found / (share * whole_j) - 1.0).abs() < 1e-12, "{factor}: {found}");
                assert!(factor * factor * strain_j <= share * whole_j * (1.0 + 1e-12) || bells_j > hertz_j);
            }
        }
    }
}
