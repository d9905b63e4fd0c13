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

use super::assign::{AssignScratch, AssignState};
use super::level::PointLevel;
use super::vector::square_distance;
use super::{StepDecision, StopCondition};
use crate::cancel_token::{CancelToken, Cancelled};

/// ω. At the default tolerance, 50 sites on 12k nodes and m = 16, 1.8 needs 12 iterations and ends 1.1 % above the best
/// known energy, 1.0 needs 15 and ends 1.7 % above.
const RELAXATION: f64 = 1.8;

/// Where the descent on a coarse level ends, whatever ends the one on the nodes. An iteration there costs half of one on the nodes and
/// gains less and less of what counts on these: of eight tolerances from 1e-3 to 1 this one brings the gap to 10, 5, 3 and 2 % earliest
/// (five objects, 6 to 150 sites).
const COARSE_TOLERANCE: f64 = 5e-2;

/// Iterations after which a diagram is taken as it is, unless fewer are asked for.
pub const ITERATIONS_MAX: usize = 200;

/// What a descent moves.
pub(super) struct LloydState<'a> {
    pub scratch: &'a mut AssignScratch,
    /// The state reached; its sites are given.
    pub current: &'a mut AssignState,
    /// The state tried next, or the one before.
    pub trial: &'a mut AssignState,
    /// Sites that stay where they are: the first ones.
    pub pinned: usize,
    /// See [`DiagramOptions`](super::Options).
    pub tolerance: f64,
    /// See [`DiagramOptions`](super::Options).
    pub iterations_max: usize,
}

impl LloydState<'_> {
    /// Lowers the energy on a level that is not the last; how many iterations that took.
    pub fn coarse(
        &mut self,
        level: &PointLevel,
        history: &mut Vec<f64>,
        token: &CancelToken,
    ) -> Result<usize, Cancelled> {
        self.begin(level, history, token)?;
        for iteration in 1..=ITERATIONS_MAX {
            let (before, reseeded) = (self.current.energy, self.iterate(level, RELAXATION, token)?);
            let Some(reseeded) = reseeded else { return Ok(iteration) };
            history.push(self.current.energy);
            if !reseeded && before - self.current.energy <= COARSE_TOLERANCE * self.current.energy {
                return Ok(iteration);
            }
        }
        Ok(ITERATIONS_MAX)
    }

    /// Lowers the energy on the last level; writes the energy after each iteration to `history`, the start's first. Whether it
    /// ended by itself: neither at the last iteration that is allowed nor by `stop`.
    pub fn finest(
        &mut self,
        level: &PointLevel,
        history: &mut Vec<f64>,
        stop: &mut dyn StopCondition,
    ) -> Result<bool, Cancelled> {
        self.begin(level, history, stop.cancel())?;
        let (mut relaxation, mut converged) = (RELAXATION, false);
        match stop.decide(0, self.current.energy, self.current.energy) {
            StepDecision::On => {}
            StepDecision::Last => relaxation = 1.0,
            StepDecision::End => return Ok(false),
        }
        for iteration in 1..=self.iterations_max {
            if iteration == self.iterations_max {
                relaxation = 1.0;
            }
            let (before, reseeded) = (self.current.energy, self.iterate(level, relaxation, stop.cancel())?);
            let Some(reseeded) = reseeded else { return Ok(true) };
            history.push(self.current.energy);
            if relaxation == 1.0 {
                return Ok(converged);
            }
            let after = self.current.energy;
            converged = !reseeded && before - after <= self.tolerance * after;
            if converged || stop.decide(iteration, before, after) != StepDecision::On {
                relaxation = 1.0;
            }
        }
        Ok(false)
    }

    /// Assigns the start.
    fn begin(&mut self, level: &PointLevel, history: &mut Vec<f64>, token: &CancelToken) -> Result<(), Cancelled> {
        token.check()?;
        self.scratch.assign(level, self.current);
        history.clear();
        history.push(self.current.energy);
        Ok(())
    }

    /// One iteration. Whether the site of an empty cell was put elsewhere; `None`: the energy does not fall any more, and nothing was
    /// changed.
    fn iterate(&mut self, level: &PointLevel, relaxation: f64, token: &CancelToken) -> Result<Option<bool>, Cancelled> {
        token.check()?;
        let reseeded = self.step(level, relaxation);
        self.scratch.assign(level, self.trial);
        if self.trial.energy > self.current.energy {
            return Ok(None);
        }
        std::mem::swap(self.current, self.trial);
        Ok(Some(reseeded))
    }

    /// Moves every site that is not pinned by ω times its way to its centroid. Whether the site of an empty cell was put elsewhere.
    fn step(&mut self, level: &PointLevel, relaxation: f64) -> bool {
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
fn reseed(level: &PointLevel, pinned: usize, from: &AssignState, to: &mut [f64]) -> bool {
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
fn costliest(level: &PointLevel, from: &AssignState, donor: usize) -> Option<usize> {
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
