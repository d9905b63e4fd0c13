//! Lloyd's iteration with over-relaxation, from coarse levels to fine ones.
//!
//! Based on: S. Lloyd, *Least squares quantization in PCM* (1982); Q. Du, V. Faber, M. Gunzburger, *Centroidal Voronoi
//! Tessellations* (SIAM Review 1999), section 5; Q. Du, M. Emelianenko, *Acceleration schemes for computing centroidal Voronoi
//! tessellations* (Numerical Linear Algebra with Applications 13, 2006), for the levels. A step p ← p + ω(c − p) towards the
//! centroid c changes the energy of unchanged cells by −ω(2 − ω) Σ M|c − p|², so it never rises for 0 < ω < 2, and new labels only
//! lower it further. Fixed points do not depend on ω. The last step is a plain one: it takes back what over-relaxation overshot.
//!
//! Labels are exact, so only the rounding of the f64 sums could let the energy rise, at a fixed point; such a step is not
//! taken and ends the descent.

use super::Options;
use super::assign::{Scratch, State};
use super::level::Level;
use super::vector::square_distance;
use crate::token::{Cancelled, Token};

/// ω. At the default tolerance, 50 sites on 12k nodes and m = 16, 1.8 needs 12 iterations and ends 1.1 % above the best
/// known energy, 1.0 needs 15 and ends 1.7 % above.
const RELAXATION: f64 = 1.8;

/// Iterations after which a diagram is taken as it is.
pub const ITERATIONS_MAX: usize = 200;

/// What a descent moves.
pub(super) struct Descent<'a> {
    pub scratch: &'a mut Scratch,
    /// The state reached; its sites are given.
    pub current: &'a mut State,
    /// The state tried next, or the one before.
    pub trial: &'a mut State,
    /// Sites that stay where they are: the first ones.
    pub pinned: usize,
}

impl Descent<'_> {
    /// Lowers the energy on `level`; writes the energy after each iteration to `history`, the start's first. Ends with a plain
    /// step if `plain`. Whether it ended by itself, not at [`ITERATIONS_MAX`].
    pub fn run(
        &mut self,
        level: &Level,
        options: &Options,
        plain: bool,
        history: &mut Vec<f64>,
        token: &Token,
    ) -> Result<bool, Cancelled> {
        token.check()?;
        self.scratch.assign(level, self.current);
        history.clear();
        history.push(self.current.energy);
        let mut relaxation = RELAXATION;
        for _ in 0..ITERATIONS_MAX {
            token.check()?;
            let before = self.current.energy;
            let reseeded = self.step(level, relaxation);
            self.scratch.assign(level, self.trial);
            if self.trial.energy > before {
                return Ok(true);
            }
            std::mem::swap(self.current, self.trial);
            history.push(self.current.energy);
            if relaxation == 1.0 {
                return Ok(true);
            }
            if !reseeded && before - self.current.energy <= options.tolerance * self.current.energy {
                if !plain {
                    return Ok(true);
                }
                relaxation = 1.0;
            }
        }
        Ok(false)
    }

    /// Moves every site that is not pinned by ω times its way to its centroid. Whether the site of an empty cell was put elsewhere.
    fn step(&mut self, level: &Level, relaxation: f64) -> bool {
        let (from, to) = (&*self.current, &mut *self.trial);
        to.stride = from.stride;
        to.sites.clone_from(&from.sites);
        let mut empty = false;
        for (site, place) in to.sites.chunks_exact_mut(from.stride).enumerate().skip(self.pinned) {
            let (mass, _, moment) = from.cell(site);
            empty |= mass == 0.0;
            if mass > 0.0 {
                place.iter_mut().zip(moment).for_each(|(x, moment)| *x += relaxation * moment / mass);
            }
        }
        empty && reseed(level, self.pinned, from, &mut to.sites)
    }
}

/// Puts the site of each empty cell on the point with the largest w|X − p|² > 0 of the costliest cell; each such cell
/// gives up one point. Whether any site was put anywhere.
fn reseed(level: &Level, pinned: usize, from: &State, to: &mut [f64]) -> bool {
    let mut donors: Vec<usize> = (0..from.count()).filter(|&site| from.cell(site).1 > 0.0).collect();
    donors.sort_by(|&a, &b| from.cell(b).1.total_cmp(&from.cell(a).1).then(a.cmp(&b)));
    let empty = (pinned..from.count()).filter(|&site| from.cell(site).0 == 0.0);
    let mut reseeded = false;
    for (site, donor) in empty.zip(donors) {
        if let Some(place) = costliest(level, from, donor) {
            to[site * from.stride..][..from.stride].copy_from_slice(level.row(place));
            reseeded = true;
        }
    }
    reseeded
}

/// The point of cell `donor` with the largest w|X − p|² > 0, ties to the first.
fn costliest(level: &Level, from: &State, donor: usize) -> Option<usize> {
    let site = from.site(donor);
    let (mut worst, mut at) = (0.0, None);
    for (place, _) in from.labels.iter().enumerate().filter(|(_, label)| **label as usize == donor) {
        let cost = level.mass[place] * square_distance(level.row(place), site);
        if cost > worst {
            (worst, at) = (cost, Some(place));
        }
    }
    at
}
