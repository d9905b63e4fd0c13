//! Verification of an estimated degree: a search from the estimate up or down the curve's grid until γ is passed.

use super::criterion::SiteCount;
use super::curve::{CurveOptions, grid};
use crate::cancel_token::Canceled;
use crate::centroidal::{self, Diagram, DiagramWorkspace, EnergyField, StopCondition};

/// A number of sites whose diagram passes γ, next to one whose diagram does not.
#[derive(Clone, Debug, PartialEq)]
pub struct VerifiedDegree {
    /// The degree, `capped` if even the maximum does not pass.
    pub degree: SiteCount,
    /// The diagram that passed, that of the maximum, or the last computed in time.
    pub diagram: Diagram,
    /// True if the search completed in time.
    pub finished: bool,
}

/// Searches the curve's grid: down from `guess` to the smallest n that still passes γ, or up from `guess` to the first
/// n that passes.
///
/// Requires E_1 > γ; the degree is at least 2. `stop` observes every descent. Once it has no time for another one, the
/// degree is the last one tried, at first `guess`. The result may differ from the optimized degree if E_max(n) is not
/// monotone, because that is the first n from below that passes.
///
/// # Errors
/// [`Canceled`] once the token is.
pub fn verify(
    field: &EnergyField,
    gamma: f64,
    guess: usize,
    options: &CurveOptions,
    stop: &mut dyn StopCondition,
    workspace: &mut DiagramWorkspace,
) -> Result<VerifiedDegree, Canceled> {
    let grid: Vec<usize> = grid(options.sites_max.clamp(1, field.nodes())).skip(1).collect();
    let Some(last) = grid.len().checked_sub(1) else {
        let diagram = centroidal::diagram(field, &options.diagram(1, 0), workspace, stop.cancel())?;
        return Ok(VerifiedDegree { degree: SiteCount { sites: 1, capped: true }, diagram, finished: true });
    };
    let mut best = |place: usize, stop: &mut dyn StopCondition| -> Result<Diagram, Canceled> {
        let mut best: Option<Diagram> = None;
        for start in 0..options.starts.max(1) {
            if best.is_some() && stop.is_out_of_time() {
                break;
            }
            let (options, mut next) = (options.diagram(grid[place], start), Diagram::default());
            centroidal::diagram_until(field, &options, workspace, stop, &mut next)?;
            if best.as_ref().is_none_or(|best| next.energy_max() < best.energy_max()) {
                best = Some(next);
            }
        }
        Ok(best.unwrap_or_default())
    };
    let mut place = grid.partition_point(|sites| *sites < guess).min(last);
    let mut diagram = best(place, stop)?;
    if diagram.energy_max() <= gamma {
        while place > 0 && !stop.is_out_of_time() {
            let fewer = best(place - 1, stop)?;
            if stop.is_out_of_time() || fewer.energy_max() > gamma {
                break;
            }
            (place, diagram) = (place - 1, fewer);
        }
    } else {
        while place < last && diagram.energy_max() > gamma && !stop.is_out_of_time() {
            place += 1;
            diagram = best(place, stop)?;
        }
    }
    let capped = place == last && diagram.energy_max() > gamma;
    Ok(VerifiedDegree { degree: SiteCount { sites: grid[place], capped }, diagram, finished: !stop.is_out_of_time() })
}
