//! Lloyd's iteration with over-relaxation, from coarse levels to fine ones.
//!
//! Based on: S. Lloyd, *Least squares quantization in PCM* (1982); Q. Du, V. Faber, M. Gunzburger, *Centroidal Voronoi
//! Tessellations* (SIAM Review 1999), section 5; Q. Du, M. Emelianenko, *Acceleration schemes for computing centroidal
//! Voronoi tessellations* (Numerical Linear Algebra with Applications 13, 2006), for the levels.
//!
//! A step p ← p + ω(c − p) toward the centroid c changes the energy of unchanged cells by −ω(2 − ω) Σ M|c − p|². So the
//! energy never rises for 0 < ω < 2, and new labels lower it further. Fixed points do not depend on ω. The last step
//! uses ω = 1, which corrects the overshoot of over-relaxation.
//!
//! Labels are exact, so the energy can rise only at a fixed point, by rounding of the f64 sums. Such a step is
//! rejected and ends the descent.

use super::assign::{AssignScratch, AssignState};
use super::level::PointLevel;
use super::vector::square_distance;
use super::{StepDecision, StopCondition};
use crate::cancel_token::{CancelToken, Canceled};

/// Over-relaxation factor ω.
///
/// At the default tolerance, 50 sites on 12k nodes and m = 16, 1.8 needs 12 iterations and ends 1.1 % above the best
/// known energy; 1.0 needs 15 and ends 1.7 % above.
const RELAXATION: f64 = 1.8;

/// Tolerance on coarse levels, whatever ends the descent on the nodes.
///
/// An iteration there costs half of one on the nodes, and its gain on the nodes diminishes. Chosen among eight
/// tolerances from 1e-3 to 1: this one reaches gaps of 10, 5, 3 and 2 % earliest (five objects, 6 to 150 sites).
const COARSE_TOLERANCE: f64 = 5e-2;

/// Default limit on the iterations of a diagram.
pub const ITERATIONS_MAX: usize = 200;

/// State that a descent changes.
pub(super) struct LloydState<'a> {
    /// Memory of the assignments.
    pub scratch: &'a mut AssignScratch,
    /// State reached. Its sites are the input.
    pub current: &'a mut AssignState,
    /// State tried next, or the previous one.
    pub trial: &'a mut AssignState,
    /// Number of pinned sites, which are the first ones.
    pub pinned: usize,
    /// As [`DiagramOptions::tolerance`](super::DiagramOptions::tolerance).
    pub tolerance: f64,
    /// As [`DiagramOptions::iterations_max`](super::DiagramOptions::iterations_max).
    pub iterations_max: usize,
}

impl LloydState<'_> {
    /// Lowers the energy on a level that is not the last. Returns the number of iterations.
    pub fn coarse(
        &mut self,
        level: &PointLevel,
        history: &mut Vec<f64>,
        token: &CancelToken,
    ) -> Result<usize, Canceled> {
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

    /// Lowers the energy on the last level. Writes the energy of the start and after each iteration to `history`.
    ///
    /// Returns true if the descent converged, and false if the iteration limit or `stop` ended it.
    pub fn finest(
        &mut self,
        level: &PointLevel,
        history: &mut Vec<f64>,
        stop: &mut dyn StopCondition,
    ) -> Result<bool, Canceled> {
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
    fn begin(&mut self, level: &PointLevel, history: &mut Vec<f64>, token: &CancelToken) -> Result<(), Canceled> {
        token.check()?;
        self.scratch.assign(level, self.current);
        history.clear();
        history.push(self.current.energy);
        Ok(())
    }

    /// Runs one iteration. Returns true if the site of an empty cell was moved to another cell.
    ///
    /// Returns `None`, with nothing changed, if the energy no longer falls.
    fn iterate(&mut self, level: &PointLevel, relaxation: f64, token: &CancelToken) -> Result<Option<bool>, Canceled> {
        token.check()?;
        let reseeded = self.step(level, relaxation);
        self.scratch.assign(level, self.trial);
        if self.trial.energy > self.current.energy {
            return Ok(None);
        }
        std::mem::swap(self.current, self.trial);
        Ok(Some(reseeded))
    }

    /// Moves every unpinned site by ω times its offset to its centroid. Returns true if the site
    /// of an empty cell was reseeded.
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

/// Moves the site of each empty cell to the point with the largest w|X − p|² > 0 of the costliest cell.
///
/// Each costly cell loses at most one point. Returns true if any site was moved.
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

/// Point of cell `donor` with the largest w|X − p|² > 0; ties go to the first.
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
