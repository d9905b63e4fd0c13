//! Division of an object into fragments of equal size, without an impact.
//!
//! Fragments are small where the strain energy is high. Without the effect `elastic`, the energy density at distance d from a
//! contact is W = p²/(2E) / (1 + (d/a)²)², with p = F/(πa²) and F = (π/2)·J/τ. If the contact radius a is a thousand times the
//! object's diagonal, W is uniform to two millionths. The fragments are then the cells of a centroidal Voronoi diagram of uniform
//! density.
//!
//! The request states their number. The impulse J is chosen so that the closed form for solids, n = V·(C·W/γ)^(3/5), yields the
//! same number.
//!
//! A contact loads only the body nearest to it. For an object of several bodies, a first request returns the bodies whole. Each
//! body then gets its own contact, the largest bodies first. The closed form distributes the fragments among the bodies, in
//! proportion to their volumes if they are compact.

use crate::{Contact, Deadline, DegreeRule, Effect, Error, FractureResult, Impact, Object, ObjectFacts};
use shatter_proto::convention::Convention;
use shatter_proto::request::CONTACTS_MAX;
use std::f64::consts::{FRAC_PI_2, PI};

/// Contact radius over the object's diagonal.
const RADIUS_DIAGONALS: f64 = 1e3;

/// C of the closed form: a cell of volume v and uniform density W has a first moment of C·W·v^(5/3) about its center. C is three
/// times the normalized second moment of the body-centered cubic lattice (Barnes & Sloane, *The optimal lattice quantizer in three
/// dimensions*, 1983).
const COEFFICIENT: f64 = 3.0 * 0.0785433;

impl Object {
    /// Impact that divides the object into `pieces` fragments of equal size. A seed, effects and a preset can be added, as to any
    /// impact. If the object has more than eight bodies, the smallest ones stay whole.
    ///
    /// Waits only if the object has several bodies: it then requests their positions from the service.
    ///
    /// # Errors
    /// Those of [`Object::strike`] and [`Ticket::wait`](crate::Ticket::wait).
    pub fn even(&self, pieces: u32, deadline: Deadline) -> Result<Impact, Error> {
        let facts = self.facts();
        let even = |points_m: &[[f64; 3]], pieces| uniform(facts, &self.convention(), points_m, pieces);
        if facts.bodies <= 1 {
            return Ok(even(&[facts.center_m], pieces));
        }
        let whole = self.strike(&even(&[facts.center_m], 1))?.wait(deadline)?;
        Ok(even(&bodies(&whole), pieces))
    }
}

/// Contacts at `points_m`, one per body, that load all of these bodies alike; written in `convention`.
fn uniform(facts: &ObjectFacts, convention: &Convention, points_m: &[[f64; 3]], pieces: u32) -> Impact {
    let radius_m = RADIUS_DIAGONALS * facts.diagonal_m;
    let density_j_m3 = facts.gamma_j_m2 * (f64::from(pieces) / facts.volume_m3).powf(5.0 / 3.0) / COEFFICIENT;
    let force_n = PI * radius_m * radius_m * (2.0 * facts.young_pa * density_j_m3).sqrt();
    // Any impulse will do where facts are missing: the number of sites is given.
    let impulse_ns = Some(force_n * facts.duration_s / FRAC_PI_2).filter(|j| j.is_normal()).unwrap_or(1.0);
    let contact = |point_m: &[f64; 3]| {
        let contact = Contact::new(convention.vector(*point_m)).impulse(convention.vector([0.0, -impulse_ns, 0.0]));
        contact.radius(convention.length(radius_m))
    };
    let points_m = if points_m.is_empty() { &[facts.center_m] } else { points_m };
    let impact = Impact::new(points_m.iter().map(contact));
    impact.degree(DegreeRule::Sites(pieces)).disable(Effect::Elastic)
}

/// A point on the surface of each body (m), the largest bodies first, as many as there may be contacts.
fn bodies(whole: &FractureResult) -> Vec<[f64; 3]> {
    let mut largest: Vec<(u32, f64, [f64; 3])> = Vec::new();
    for fragment in whole.metric().fragments() {
        let Some(point) = fragment.positions().first() else { continue };
        let (body, center_m) = (fragment.body(), fragment.center_m());
        match largest.iter_mut().find(|(other, ..)| *other == body) {
            Some((_, volume_m3, _)) => *volume_m3 += fragment.volume_m3(),
            None => {
                let point_m = [0, 1, 2].map(|k| center_m[k] + f64::from(point[k]));
                largest.push((body, fragment.volume_m3(), point_m));
            }
        }
    }
    largest.sort_by(|a, b| b.1.total_cmp(&a.1));
    largest.into_iter().take(CONTACTS_MAX).map(|(_, _, point_m)| point_m).collect()
}
