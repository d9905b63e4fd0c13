//! A degree searched by diagrams, as far as there is time.

use super::cells::{BodyCells, DegreeGuess, Division, diagram_bytes, guesses, source_of, tell};
use super::convergence_monitor::ConvergenceMonitor;
use super::{
    DegreeRequest, DegreeSource, FractureError, FractureRequest, PreparedObject, Stage, StageObserver, ThresholdResult,
    Workspace,
};
use crate::cancel_token::{CancelToken, Cancelled};
use crate::centroidal::{Diagram, EnergyField, diagram_until};
use crate::degree::{self, CurveOptions, SiteCount};

/// What a search of one body came to.
struct Found {
    degree: SiteCount,
    diagram: Diagram,
    /// Whether it ended by itself, and not because no time was left.
    finished: bool,
}

/// Searches the degree of each struck body by diagrams: from below, or from a guess. Where time ends it, the degree is the guess.
pub(super) fn search(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    verdict: &ThresholdResult,
    fields: &[EnergyField],
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<Division, FractureError> {
    let verified = strike.degree == DegreeRequest::Verified;
    let source = if verified { DegreeSource::Verified } else { DegreeSource::Optimised };
    let mut division = Division { source, degree: 0, capped: false, confidence: 1.0, ending: None, cells: Vec::new() };
    let guesses = guesses(prepared, strike, verdict, fields);
    tell(if verified { &guesses } else { &[] }, watch);
    for (struck, (field, guess)) in fields.iter().zip(&guesses).enumerate() {
        let gamma = verdict.gammas[struck];
        if verdict.first_moments[struck] <= gamma {
            division.degree += 1;
            continue;
        }
        watch.enter(Stage::Degree);
        let mut descent = ConvergenceMonitor::of_search(strike, guess.sites, watch);
        let found = of_body(strike, field, gamma, guess, &mut descent, workspace, token)?;
        let ending = descent.ending(&found.diagram);
        watch.leave(Stage::Degree, 0);
        watch.enter(Stage::Centroidal);
        division.degree += found.degree.sites as u32;
        division.capped |= found.degree.capped;
        division.ending = division.ending.max(Some(ending));
        if !found.finished {
            division.source = source_of(&guesses);
            division.confidence = guess.confidence.min(division.confidence);
        }
        watch.leave(Stage::Centroidal, diagram_bytes(&found.diagram));
        division.cells.push(BodyCells { struck, diagram: found.diagram });
    }
    Ok(division)
}

/// Searches the degree of `field` at `gamma`.
fn of_body(
    strike: &FractureRequest,
    field: &EnergyField,
    gamma: f64,
    guess: &DegreeGuess,
    descent: &mut ConvergenceMonitor,
    workspace: &mut Workspace,
    token: &CancelToken,
) -> Result<Found, Cancelled> {
    let options = CurveOptions {
        sites_max: strike.degree_max as usize,
        seed: strike.seed,
        tolerance: strike.tolerance,
        iterations_max: strike.iterations_max,
        ..CurveOptions::default()
    };
    let (sites, workspace) = (guess.sites as usize, &mut workspace.centroidal);
    if strike.degree == DegreeRequest::Verified {
        let found = degree::verify(field, gamma, sites, &options, descent, workspace, token)?;
        return Ok(Found { degree: found.degree, diagram: found.diagram, finished: found.finished });
    }
    if let Some(found) = degree::optimise(field, gamma, options, descent, workspace, token)? {
        return Ok(Found { degree: found.degree, diagram: found.diagram, finished: true });
    }
    let mut diagram = Diagram::default();
    diagram_until(field, &options.diagram(sites, 0), workspace, descent, token, &mut diagram)?;
    Ok(Found { degree: SiteCount { sites, capped: guess.capped }, diagram, finished: false })
}
