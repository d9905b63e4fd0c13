//! Energy-weighted centroidal Voronoi diagrams in the lift.
//!
//! Minimizes F(p) = Σ_v w_v min_i |X_v − p_i|² over sites p_i in R^m, from a start that is deterministic in (seed,
//! start, number of sites). Results have the same bits for any number of threads and on any machine.

mod assign;
mod clusters;
mod diagram;
mod field;
mod kernel;
mod level;
mod lloyd;
mod power;
mod seeding;
mod stop_condition;
#[cfg(test)]
mod tests;
mod vector;
mod workspace;

pub use clusters::Clusters;
pub use diagram::{Diagram, DiagramOptions, TOLERANCE};
pub use field::{EnergyField, FLOOR, FieldError};
pub use lloyd::ITERATIONS_MAX;
pub(crate) use power::{cube_root, three_fifths};
pub use stop_condition::{GAP_CERTAIN, GAP_MIN, StepDecision, StopCondition, gap};
pub use workspace::DiagramWorkspace;

use crate::cancel_token::{CancelToken, Canceled};
use crate::random::RandomStream;

/// Computes the diagram of `field` with these `options`. Polls `token` once per iteration.
///
/// # Errors
/// [`Canceled`] once the token is.
pub fn diagram(
    field: &EnergyField,
    options: &DiagramOptions,
    workspace: &mut DiagramWorkspace,
    token: &CancelToken,
) -> Result<Diagram, Canceled> {
    let mut diagram = Diagram::default();
    diagram_into(field, options, workspace, token, &mut diagram)?;
    Ok(diagram)
}

/// As [`diagram`], into an existing diagram whose memory is reused. After an error its contents are unspecified.
///
/// # Errors
/// [`Canceled`] once the token is.
pub fn diagram_into(
    field: &EnergyField,
    options: &DiagramOptions,
    workspace: &mut DiagramWorkspace,
    token: &CancelToken,
    diagram: &mut Diagram,
) -> Result<(), Canceled> {
    diagram_until(field, options, workspace, &mut &*token, diagram)
}

/// As [`diagram_into`], with a condition that may end the descent before it converges.
///
/// # Errors
/// [`Canceled`] once the token of `stop` is.
pub fn diagram_until(
    field: &EnergyField,
    options: &DiagramOptions,
    workspace: &mut DiagramWorkspace,
    stop: &mut dyn StopCondition,
    diagram: &mut Diagram,
) -> Result<(), Canceled> {
    let sites = options.sites.clamp(1, field.nodes());
    let mut stream = RandomStream::new(options.seed, u64::from(options.start) << 32 | sites as u64);
    let DiagramWorkspace { start, sites: drawn, levels, current, .. } = &mut *workspace;
    // Levels and start are independent, so they are computed in parallel.
    let (levels, ()) = rayon::join(
        || workspace::load(levels, field, sites),
        || {
            start.draw(field, sites, &mut stream, drawn);
            current.set_sites(drawn, field.dimension());
        },
    );
    diagram.coarse_iterations = 0;
    for index in (1..levels).rev() {
        let (level, mut descent) = workspace.descent(index, field.pins().len(), options);
        diagram.coarse_iterations += descent.coarse(level, &mut diagram.history, stop.cancel())?;
    }
    let (level, mut descent) = workspace.descent(0, field.pins().len(), options);
    diagram.converged = descent.finest(level, &mut diagram.history, stop)?;
    workspace.write_diagram(field, diagram);
    Ok(())
}

/// Exact labels of given sites (site-major, m each, at least one) and their energies E_i. The sites do not move.
pub fn assign(field: &EnergyField, sites: &[f64], workspace: &mut DiagramWorkspace) -> Diagram {
    let mut diagram = Diagram::default();
    workspace::load(&mut workspace.levels, field, field.nodes());
    workspace.current.set_sites(sites, field.dimension());
    workspace.scratch.assign(&workspace.levels[0], &mut workspace.current);
    diagram.history.push(workspace.current.energy);
    diagram.converged = true;
    workspace.write_diagram(field, &mut diagram);
    diagram
}
