//! Energy of contacts that are narrower than the lattice resolves.
//!
//! The lattice's load has radius r, and the contact radius a < r. Near the contact the body is a half-space, and far from
//! it both loads deform it alike, so the energies differ by those of a half-space under both:
//!
//! U(a) = U_lattice(r) + U_h(a) − U_h(r), U_h = ½ Σ_cc' F_c·G(x_c − x_c', a_c, a_c') F_c'.
//!
//! All contacts of the body together make U_h, so that opposite ones cancel. For tractions F exp(−ρ²/2a²)/(2πa²), A² = (a² + a'²)/2,
//! z = d²/8A², E = 1 and tangential directions t, the compliance of the surface is
//!
//! - G_nn = (1 − ν²)/π · J₀
//! - G_tt = (1 + ν)/π · ((1 − ν/2) J₀ 1 + ν/2 J₂ (2 d dᵀ/d² − 1))
//! - G_nt = (1 + ν)(1 − 2ν)/2π · (1 − exp(−d²/4A²)) dᵀ/d² (n points into the body)
//!
//! with J_m = ∫ exp(−k²A²) J_m(kd) dk = √π/(2A) exp(−z) I_{m/2}(z). One contact has the energy
//! (F_n²(1 − ν²) + F_t²(1 + ν)(1 − ν/2))/(4√π a). What the smooth part of the body's compliance adds changes with the
//! square of the radius over the distance to the nearest edge.
//!
//! The less the body is a half-space, the less of it there is: its share falls from 1 to 0 with the evenness of the loaded patch
//! and with the thickness behind it, and a is at least (1 − share) r, whatever radius is asked for. What was measured against
//! bodies refined three times (block, a quarter to three quarters of a spacing, all directions of the force): −2 % to
//! 5 % of the energy inside faces, where it was −34 % to −83 %; pairs closer than their radii, −1 % to 8 %. Next to an edge
//! and on walls, the near field is within 9 % of the energy of the effective radius, and on a mug within 8 %. At an edge and
//! on walls of one cell there is next to none.
//!
//! Based on: K. L. Johnson, *Contact Mechanics* (1985), sections 3.2 and 3.6 (Boussinesq and Cerruti); S. Timoshenko & J.
//! N. Goodier, *Theory of Elasticity* (1951), section 123; M. Abramowitz & I. A. Stegun, *Handbook of Mathematical
//! Functions* (1964), 9.8 and 11.4. The difference of two half-spaces, and its limits, are ours.

use super::load_patch::LoadPatch;
use super::{BoundaryNodes, NearestBoundaryPoint};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::ops::Range;

/// Radius of the traction exp(−ρ²/2a²) over that of the bell with the same energy on a half-space.
const BELL: f64 = 0.954_583;

/// Local energy of a bell of this radius that presses a half-space with E = 1 and Poisson's ratio `poisson` by `force`: the
/// formula of the module for one contact.
pub(crate) fn bell_indentation(force: f64, radius: f64, poisson: f64) -> f64 {
    force * force * (1.0 - poisson * poisson) / (4.0 * PI.sqrt() * BELL * radius)
}

/// Evenness of a patch ([`super::load_patch`]) at which it is a half-space, and at which it is none.
const EVENNESS: [f64; 2] = [0.97, 0.85];

/// Thickness of the wall behind a contact, in radii of the lattice's load, at which it is a half-space, and at which it
/// is none.
const THICKNESS: [f64; 2] = [2.5, 1.25];

/// Contact whose radius may be smaller than that of its load on the lattice.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NearContact {
    /// Boundary point, local.
    pub place: nalgebra::Point3<f64>,
    /// Outward normal of the loaded patch.
    pub normal: Vector3<f64>,
    /// Force.
    pub force: Vector3<f64>,
    /// Radius of the contact and of the lattice's load, local.
    pub radii: [f64; 2],
    /// Its entries in [`super::NodalLoad::near`]; none if the radii are equal.
    pub shares: Range<usize>,
}

/// Half-space of Poisson's ratio ν and E = 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace {
    pub poisson: f64,
}

impl HalfSpace {
    /// Displacement at `own` under the force of `other`, if the radii of kind `kind` apply: 0 for those of the contacts, 1
    /// for those of the lattice.
    fn displacement(&self, own: &NearContact, other: &NearContact, kind: usize) -> Vector3<f64> {
        let nu = self.poisson;
        let width = BELL * (0.5 * (own.radii[kind].powi(2) + other.radii[kind].powi(2))).sqrt();
        let normal = (own.normal + other.normal).try_normalize(f64::EPSILON).unwrap_or(own.normal);
        let apart = own.place - other.place;
        let flat = apart - normal * apart.dot(&normal);
        let (inward, along) = (-other.force.dot(&normal), other.force - normal * other.force.dot(&normal));
        let square = flat.norm_squared() / (4.0 * width * width);
        let [zeroth, first] = bessel(0.5 * square).map(|own| own * PI.sqrt() / (2.0 * width));
        let mut found = -normal * ((1.0 - nu * nu) / PI * zeroth * inward);
        found += along * ((1.0 + nu) / PI * ((1.0 - 0.5 * nu) * zeroth - 0.5 * nu * first));
        if square > 0.0 {
            // The double angle of the direction vanishes with the square of the distance.
            let shift = flat / flat.norm_squared();
            found += shift * ((1.0 + nu) / PI * nu * first * along.dot(&flat));
            let tilt = (1.0 + nu) * (1.0 - 2.0 * nu) / (2.0 * PI) * -(-square).exp_m1();
            found -= shift * (tilt * inward) + normal * (tilt * along.dot(&shift));
        }
        found
    }

    /// Writes half the work of each contact's force on what its displacement grows by from the lattice's radii to those of
    /// the contacts; the sum is what the energy grows by.
    pub fn works(&self, contacts: &[NearContact], works: &mut Vec<f64>) {
        works.clear();
        works.extend(contacts.iter().map(|own| {
            let grown = |other: &NearContact| {
                // Contacts on opposite sides of a wall do not load the same half-space.
                let facing = own.normal.dot(&other.normal).max(0.0);
                (self.displacement(own, other, 0) - self.displacement(own, other, 1)) * facing
            };
            0.5 * own.force.dot(&contacts.iter().map(grown).sum::<Vector3<f64>>())
        }));
    }
}

/// exp(−z) I₀(z) and exp(−z) I₁(z) for z ≥ 0, to 2e-7.
fn bessel(z: f64) -> [f64; 2] {
    let sum = |terms: &[f64], t: f64| terms.iter().rev().fold(0.0, |sum, own| sum * t + own);
    if z < 3.75 {
        let t = (z / 3.75).powi(2);
        let zeroth = [1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813];
        let first = [0.5, 0.87890594, 0.51498869, 0.15084934, 0.02658733, 0.00301532, 0.00032411];
        return [sum(&zeroth, t), sum(&first, t) * z].map(|own| own * (-z).exp());
    }
    let t = 3.75 / z;
    let zeroth =
        [0.39894228, 0.01328592, 0.00225319, -0.00157565, 0.00916281, -0.02057706, 0.02635537, -0.01647633, 0.00392377];
    let first = [
        0.39894228,
        -0.03988024,
        -0.00362018,
        0.00163801,
        -0.01031555,
        0.02282967,
        -0.02895312,
        0.01787654,
        -0.00420059,
    ];
    [sum(&zeroth, t), sum(&first, t)].map(|own| own / z.sqrt())
}

/// Share, 0 to 1, to which the body near a contact is a half-space.
///
/// `patch`: that of a load of radius `spread`.
pub(super) fn half_space_share(
    boundary: &BoundaryNodes,
    nearest: &NearestBoundaryPoint,
    patch: &LoadPatch,
    spread: f64,
) -> f64 {
    let ([whole, none], normal) = (EVENNESS, patch.normal);
    let even = ((patch.evenness - none) / (whole - none)).clamp(0.0, 1.0);
    if even == 0.0 {
        return 0.0;
    }
    // Starts inside, so that the touched face is not hit.
    let start = nearest.place - normal * (START * spread);
    let thickness = boundary.search().first_hit(&start, &-normal);
    let thickness = thickness.map_or(f64::INFINITY, |hit| START * spread + hit.distance);
    let [whole, none] = THICKNESS;
    even * ((thickness / spread - none) / (whole - none)).clamp(0.0, 1.0)
}

/// Depth, in radii of the lattice's load, at which the search for the other side of a wall starts.
const START: f64 = 0.01;

/// Radius whose energy is computed for a contact of radius `asked`, if the body is a half-space to the share `share`.
///
/// A contact with that radius keeps it.
pub(super) fn effective_radius(asked: f64, spread: f64, share: f64) -> f64 {
    asked.max(spread * (1.0 - share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elasticity::load_patch::{BELL_RADII, bell};
    use nalgebra::Point3;

    fn contact(place: [f64; 3], force: [f64; 3], radius: f64) -> NearContact {
        let normal = Vector3::z();
        NearContact {
            place: Point3::from(place),
            normal,
            force: Vector3::from(force),
            radii: [radius, 1e12],
            shares: 0..0,
        }
    }

    fn energy(contacts: &[NearContact], poisson: f64) -> f64 {
        let mut works = Vec::new();
        HalfSpace { poisson }.works(contacts, &mut works);
        works.iter().sum()
    }

    /// The energy of the bell on a half-space by quadrature of its transform.
    #[test]
    fn the_bell_has_the_energy_of_its_gaussian() {
        let count = 600;
        let places: Vec<f64> = (0..count).map(|own| BELL_RADII * (f64::from(own) + 0.5) / f64::from(count)).collect();
        let total: f64 = places.iter().map(|own| bell(*own) * own).sum();
        let bessel =
            |x: f64| (0..200).map(|own| (x * (PI * (f64::from(own) + 0.5) / 200.0).sin()).cos()).sum::<f64>() / 200.0;
        let transform = |k: f64| places.iter().map(|own| bell(*own) * own * bessel(k * own)).sum::<f64>() / total;
        let step = 0.05;
        let integral: f64 = (0..400).map(|own| transform(step * (f64::from(own) + 0.5)).powi(2) * step).sum();
        assert!((PI.sqrt() / 2.0 / integral / BELL - 1.0).abs() < 1e-4, "{}", PI.sqrt() / 2.0 / integral);
    }

    #[test]
    fn single_contacts_have_the_energies_of_the_formulas() {
        let (nu, radius) = (0.3, 0.2);
        let unit = 4.0 * PI.sqrt() * radius * BELL;
        let normal = energy(&[contact([0.0; 3], [0.0, 0.0, -2.0], radius)], nu);
        assert!((normal / (4.0 * (1.0 - nu * nu) / unit) - 1.0).abs() < 1e-6);
        let tangential = energy(&[contact([0.0; 3], [0.0, 3.0, 0.0], radius)], nu);
        assert!((tangential / (9.0 * (1.0 + nu) * (1.0 - nu / 2.0) / unit) - 1.0).abs() < 1e-6);
    }

    /// Far from a load, displacements are those of a point force (Boussinesq, Cerruti).
    #[test]
    fn distant_displacements_are_those_of_point_forces() {
        let (nu, distance) = (0.25, 40.0);
        let half_space = HalfSpace { poisson: nu };
        let at = |force: [f64; 3]| {
            let [own, other] = [[distance, 0.0, 0.0], [0.0; 3]].map(|place| contact(place, force, 0.5));
            half_space.displacement(&own, &other, 0) * distance * PI
        };
        let tilt = 0.5 * (1.0 + nu) * (1.0 - 2.0 * nu);
        let expected = [
            ([0.0, 0.0, -1.0], [-tilt, 0.0, -(1.0 - nu * nu)]),
            ([1.0, 0.0, 0.0], [1.0 + nu, 0.0, -tilt]),
            ([0.0, 1.0, 0.0], [0.0, (1.0 + nu) * (1.0 - nu), 0.0]),
        ];
        for (force, expected) in expected {
            let found = at(force);
            assert!((found - Vector3::from(expected)).norm() < 1e-3, "{force:?}: {found:?} for {expected:?}");
        }
    }

    #[test]
    fn opposite_contacts_have_no_energy_and_close_ones_act_as_one() {
        let at = |x: f64, force: [f64; 3]| contact([x, 0.0, 0.0], force, 0.1);
        assert_eq!(energy(&[at(0.3, [1.0, -0.3, 2.0]), at(0.3, [-1.0, 0.3, -2.0])], 0.3), 0.0);
        let one = energy(&[at(0.0, [0.0, 0.0, -2.0])], 0.3);
        let two = energy(&[at(0.0, [0.0, 0.0, -1.0]), at(1e-6, [0.0, 0.0, -1.0])], 0.3);
        assert!((two / one - 1.0).abs() < 1e-6);
        // Forces of any direction never lower the energy.
        for x in [0.01, 0.1, 0.2, 0.5, 2.0] {
            for force in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]] {
                for other in [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 1.0]] {
                    assert!(energy(&[at(0.0, force), at(x, other)], 0.3) > 0.0);
                }
            }
        }
    }
}
