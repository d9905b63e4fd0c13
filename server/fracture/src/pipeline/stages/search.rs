//! Search for the degree by diagrams, within the remaining time.

use super::cells::{BodyCells, CellPartition, DegreeGuess, DegreeSource, diagram_bytes, observe, source_of};
use super::convergence_monitor::ConvergenceMonitor;
use super::threshold::ThresholdResult;
use crate::cancel_token::Canceled;
use crate::centroidal::{Diagram, EnergyField, diagram_until};
use crate::degree::{self, CurveOptions, SiteCount};
use crate::pipeline::error::FractureError;
use crate::pipeline::request::budget::TimeBudget;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::fracture_request::{DegreeRequest, FractureRequest};
use crate::pipeline::request::stage::Stage;
use crate::pipeline::workspace::Workspace;

/// Result of the search of one body.
struct Found {
    degree: SiteCount,
    diagram: Diagram,
    /// True if the search completed; false if time ended it.
    finished: bool,
}

/// Searches the degree of each struck body by diagrams, upward from the smallest or around its estimate.
///
/// If time ends the search, the degree is the estimate.
pub(in crate::pipeline) fn search(
    context: RequestContext<'_>,
    budget: Option<TimeBudget>,
    threshold: &ThresholdResult,
    fields: &[EnergyField],
    guesses: &[DegreeGuess],
    workspace: &mut Workspace,
) -> Result<CellPartition, FractureError> {
    let RequestContext { request, cancel, observer, .. } = context;
    let verified = request.degree == DegreeRequest::Verified;
    let source = if verified { DegreeSource::Verified } else { DegreeSource::Optimized };
    let mut division =
        CellPartition { source, degree: 0, capped: false, confidence: 1.0, ending: None, cells: Vec::new() };
    if verified {
        observe(guesses, observer);
    }
    for (struck, (field, guess)) in fields.iter().zip(guesses).enumerate() {
        let gamma = threshold.gammas[struck];
        if threshold.first_moments[struck] <= gamma {
            division.degree += 1;
            continue;
        }
        // Each degree that is tried has a diagram: their time is the search's, and only the memory that stays is the
        // next stage's.
        let degree = observer.stage(Stage::Degree);
        let mut monitor = ConvergenceMonitor::of_search(request, budget, guess.sites, cancel);
        let found = of_body(request, field, gamma, guess, &mut monitor, workspace)?;
        let ending = monitor.ending(&found.diagram);
        drop(degree);
        let centroidal = observer.stage(Stage::Centroidal);
        division.degree += found.degree.sites as u32;
        division.capped |= found.degree.capped;
        division.ending = division.ending.max(Some(ending));
        if !found.finished {
            division.source = source_of(guesses);
            division.confidence = guess.confidence.min(division.confidence);
        }
        centroidal.produced_bytes(diagram_bytes(&found.diagram));
        division.cells.push(BodyCells { struck, diagram: found.diagram });
    }
    Ok(division)
}

/// Searches the degree of `field` at `gamma`.
fn of_body(
    request: &FractureRequest,
    field: &EnergyField,
    gamma: f64,
    guess: &DegreeGuess,
    monitor: &mut ConvergenceMonitor,
    workspace: &mut Workspace,
) -> Result<Found, Canceled> {
    let options = CurveOptions {
        sites_max: request.degree_max as usize,
        seed: request.seed,
        tolerance: request.tolerance,
        iterations_max: request.iterations_max,
        ..CurveOptions::default()
    };
    let (sites, workspace) = (guess.sites as usize, &mut workspace.centroidal);
    if request.degree == DegreeRequest::Verified {
        let found = degree::verify(field, gamma, sites, &options, monitor, workspace)?;
        return Ok(Found { degree: found.degree, diagram: found.diagram, finished: found.finished });
    }
    if let Some(found) = degree::optimize(field, gamma, options, monitor, workspace)? {
        return Ok(Found { degree: found.degree, diagram: found.diagram, finished: true });
    }
    let mut diagram = Diagram::default();
    diagram_until(field, &options.diagram(sites, 0), workspace, monitor, &mut diagram)?;
    Ok(Found { degree: SiteCount { sites, capped: guess.capped }, diagram, finished: false })
}
