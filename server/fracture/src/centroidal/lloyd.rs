//! Lloyd's iteration with over-relaxation.
//!
//! Based on: S. Lloyd, *Least squares quantization in PCM* (1982); Q. Du, V. Faber, M. Gunzburger, *Centroidal Voronoi
//! Tessellations* (SIAM Review 1999), section 5. A step p ← p + ω(c − p) towards the centroid c changes the energy of
//! unchanged cells by −ω(2 − ω) Σ M|c − p|², so it never rises for 0 < ω < 2, and new labels only lower it further.
//! Fixed points do not depend on ω. The last step is a plain one: it takes back what over-relaxation overshot.
//!
//! Labels are exact, so only the rounding of the f64 sums could let the energy rise, at a fixed point; such a step is not
//! taken and ends the descent.

use super::assign::State;
use super::kernel::square_distance;
use super::workspace::Workspace;
use super::{Field, Options, Pace, Stop};
use crate::token::{Cancelled, Token};

/// ω. At the default tolerance, 50 sites on 12k nodes and m = 16, 1.8 needs 12 iterations and ends 1.1 % above the best
/// known energy, 1.0 needs 15 and ends 1.7 % above.
const RELAXATION: f64 = 1.8;

/// Iterations after which a diagram is taken as it is, unless fewer are asked for.
pub const ITERATIONS_MAX: usize = 200;

/// Lowers the energy of `workspace.current`, whose sites are given; writes the energy after each iteration to
/// `history`, the start's first. Whether it ended by itself: neither at `options.iterations_max` nor by `stop`.
pub(super) fn descend(
    field: &Field,
    options: &Options,
    workspace: &mut Workspace,
    history: &mut Vec<f64>,
    stop: &mut dyn Stop,
    token: &Token,
) -> Result<bool, Cancelled> {
    token.check()?;
    workspace.scratch.assign(field, &mut workspace.current);
    history.clear();
    let start = workspace.current.energy;
    history.push(start);
    let (mut relaxation, mut converged) = (RELAXATION, false);
    match stop.pace(0, start, start) {
        Pace::On => {}
        Pace::Last => relaxation = 1.0,
        Pace::End => return Ok(false),
    }
    for iteration in 1..=options.iterations_max {
        token.check()?;
        if iteration == options.iterations_max {
            relaxation = 1.0;
        }
        let before = workspace.current.energy;
        let reseeded = step(field, &workspace.current, relaxation, &mut workspace.trial);
        workspace.scratch.assign(field, &mut workspace.trial);
        if workspace.trial.energy > before {
            return Ok(true);
        }
        std::mem::swap(&mut workspace.current, &mut workspace.trial);
        history.push(workspace.current.energy);
        if relaxation == 1.0 {
            return Ok(converged);
        }
        let after = workspace.current.energy;
        converged = !reseeded && before - after <= options.tolerance * after;
        if converged || stop.pace(iteration, before, after) != Pace::On {
            relaxation = 1.0;
        }
    }
    Ok(false)
}

/// Moves every site of `from` that is not pinned by ω times its way to its centroid. Whether the site of an empty cell was put
/// elsewhere.
fn step(field: &Field, from: &State, relaxation: f64, to: &mut State) -> bool {
    to.stride = from.stride;
    to.sites.clone_from(&from.sites);
    let mut empty = false;
    for (site, place) in to.sites.chunks_exact_mut(from.stride).enumerate().skip(field.pins().len()) {
        let (mass, _, moment) = from.cell(site);
        empty |= mass == 0.0;
        if mass > 0.0 {
            place.iter_mut().zip(moment).for_each(|(x, moment)| *x += relaxation * moment / mass);
        }
    }
    empty && reseed(field, from, &mut to.sites)
}

/// Puts the site of each empty cell on the node with the largest w|X − p|² > 0 of the costliest cell; each such cell
/// gives up one node. Whether any site was put anywhere.
fn reseed(field: &Field, from: &State, to: &mut [f64]) -> bool {
    let mut donors: Vec<usize> = (0..from.count()).filter(|&site| from.cell(site).1 > 0.0).collect();
    donors.sort_by(|&a, &b| from.cell(b).1.total_cmp(&from.cell(a).1).then(a.cmp(&b)));
    let free = field.pins().len()..from.count();
    let empty = free.filter(|&site| from.cell(site).0 == 0.0);
    let mut reseeded = false;
    for (site, donor) in empty.zip(donors) {
        if let Some(node) = costliest(field, from, donor) {
            to[site * from.stride..][..field.dimension()].copy_from_slice(field.lift().at(node));
            reseeded = true;
        }
    }
    reseeded
}

/// The node of cell `donor` with the largest w|X − p|² > 0, ties to the lowest index.
fn costliest(field: &Field, from: &State, donor: usize) -> Option<usize> {
    let site = &from.site(donor)[..field.dimension()];
    let (mut worst, mut at) = (0.0, None);
    for (node, _) in from.labels.iter().enumerate().filter(|(_, label)| **label as usize == donor) {
        let cost = field.mass()[node] * square_distance(field.lift().at(node), site);
        if cost > worst {
            (worst, at) = (cost, Some(node));
        }
    }
    at
}
