//! A guess of the degree, made to hold: from the guess up or down the curve's own grid to where γ is passed.

use super::criterion::Degree;
use super::curve::{CurveOptions, grid};
use crate::centroidal::{self, Diagram, Field, Workspace};
use crate::token::{Cancelled, Token};

/// A number of sites whose diagram passes, next to one whose does not.
#[derive(Clone, Debug, PartialEq)]
pub struct Verified {
    /// The degree; capped where even the cap does not pass.
    pub degree: Degree,
    /// The diagram that passed, or the cap's.
    pub diagram: Diagram,
}

/// The smallest n of the curve's grid from `guess` downwards whose best diagram passes γ, or from `guess` upwards the first that
/// does. E_1 > γ is taken for granted: at least 2.
///
/// It may differ from the optimised degree where E_max(n) is not monotone: that one is the first to pass from below.
///
/// # Errors
/// [`Cancelled`] once the token is.
pub fn verify(
    field: &Field,
    gamma: f64,
    guess: usize,
    options: &CurveOptions,
    workspace: &mut Workspace,
    token: &Token,
) -> Result<Verified, Cancelled> {
    let grid: Vec<usize> = grid(options.sites_max.clamp(1, field.nodes())).skip(1).collect();
    let Some(last) = grid.len().checked_sub(1) else {
        let diagram = centroidal::diagram(field, &options.diagram(1, 0), workspace, token)?;
        return Ok(Verified { degree: Degree { sites: 1, capped: true }, diagram });
    };
    let best = |place: usize, workspace: &mut Workspace| -> Result<Diagram, Cancelled> {
        let mut best: Option<Diagram> = None;
        for start in 0..options.starts.max(1) {
            let next = centroidal::diagram(field, &options.diagram(grid[place], start), workspace, token)?;
            if best.as_ref().is_none_or(|best| next.energy_max() < best.energy_max()) {
                best = Some(next);
            }
        }
        Ok(best.unwrap_or_default())
    };
    let mut place = grid.partition_point(|sites| *sites < guess).min(last);
    let mut diagram = best(place, workspace)?;
    if diagram.energy_max() <= gamma {
        while place > 0 {
            let fewer = best(place - 1, workspace)?;
            if fewer.energy_max() > gamma {
                break;
            }
            (place, diagram) = (place - 1, fewer);
        }
    } else {
        while place < last && diagram.energy_max() > gamma {
            place += 1;
            diagram = best(place, workspace)?;
        }
    }
    let degree = Degree { sites: grid[place], capped: diagram.energy_max() > gamma };
    Ok(Verified { degree, diagram })
}
