//! The energy-weighted centroidal Voronoi diagram in the lift.
//!
//! Minimises F(p) = Σ_v w_v min_i |X_v − p_i|² over sites p_i in R^m, from a start that is deterministic in (seed, start,
//! number of sites). Results have the same bits for any number of threads and on any machine.

mod assign;
mod clusters;
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
pub use field::{EnergyField, FLOOR, FieldError};
pub use lloyd::ITERATIONS_MAX;
pub(crate) use power::{cube_root, three_fifths};
pub use stop_condition::{GAP_CERTAIN, GAP_MIN, StepDecision, StopCondition, gap};
pub use workspace::DiagramWorkspace;

use crate::cancel_token::{CancelToken, Cancelled};
use crate::lift::LiftedLattice;
use crate::random::RandomStream;

/// The default of [`DiagramOptions::tolerance`]: the energy ends about 0.4 % above that of the same descent run to its end, less
/// than two descents from different starts differ.
pub const TOLERANCE: f64 = 1e-3;

/// What diagram is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagramOptions {
    /// Number of sites; clamped to 1 ..= nodes.
    pub sites: usize,
    /// Everything random follows from (seed, start, sites).
    pub seed: u64,
    /// Which of several independent starts of one seed; 0 unless they are compared.
    pub start: u32,
    /// The descent ends when an iteration lowers F by less than this fraction of itself. Smaller is more accurate; at 0 it
    /// runs to a fixed point or to `iterations_max`.
    pub tolerance: f64,
    /// Iterations on the nodes at most, of which the last is a plain one; with 0 the sites stay where the start, or the last of the
    /// coarser levels, puts them.
    pub iterations_max: usize,
}

impl DiagramOptions {
    /// `sites` sites, start 0, default tolerance.
    pub fn new(sites: usize, seed: u64) -> Self {
        Self { sites, seed, start: 0, tolerance: TOLERANCE, iterations_max: ITERATIONS_MAX }
    }
}

/// A Voronoi diagram of the lattice nodes, centroidal up to the tolerance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagram {
    /// m.
    pub dimension: usize,
    /// p_i, site-major, `sites × m`, lifted coordinates; the very sites that the labels belong to.
    pub sites: Vec<f64>,
    /// argmin_i |X_v − p_i|² per node in f64, ties to the lowest index. A cell may be empty when nodes coincide.
    pub labels: Vec<u32>,
    /// E_i = Σ_v w_v(|X_v − p_i|² + 2 b_v·(X_v − p_i) + m_v) per site, b_v and m_v the moments of node v's own cell: the
    /// integral of W|X − p_i|² over the cells of the nodes; unit of the masses times local length squared.
    pub cell_energy: Vec<f64>,
    /// F = Σ_v w_v|X_v − p|², without the moments of the nodes' own cells.
    pub energy: f64,
    /// F of the start, or of the sites that coarse levels ended with, and after each iteration on the nodes; never rises.
    pub history: Vec<f64>,
    /// Iterations on coarser levels before that.
    pub coarse_iterations: usize,
    /// Whether the tolerance was met before the last iteration that was allowed.
    pub converged: bool,
}

impl Diagram {
    /// Number of sites.
    pub fn count(&self) -> usize {
        self.cell_energy.len()
    }

    /// p_i, length m.
    pub fn site(&self, site: usize) -> &[f64] {
        &self.sites[site * self.dimension..][..self.dimension]
    }

    /// The node nearest to each site, of its own cell if it has one, ties to the lowest index; `lift` is the field's.
    pub fn site_nodes(&self, lift: &LiftedLattice) -> Vec<u32> {
        let square = |node: usize, site: usize| -> f64 {
            lift.at(node).iter().zip(self.site(site)).map(|(x, p)| (x - p) * (x - p)).sum()
        };
        let mut nearest = vec![(f64::INFINITY, 0); self.count()];
        let mut try_ = |node: usize, site: usize| {
            let distance = square(node, site);
            if distance < nearest[site].0 {
                nearest[site] = (distance, node as u32);
            }
        };
        self.labels.iter().enumerate().for_each(|(node, &site)| try_(node, site as usize));
        let mut inhabited = vec![false; self.count()];
        self.labels.iter().for_each(|&site| inhabited[site as usize] = true);
        for site in (0..self.count()).filter(|&site| !inhabited[site]) {
            (0..self.labels.len()).for_each(|node| try_(node, site));
        }
        nearest.into_iter().map(|(_, node)| node).collect()
    }

    /// Iterations taken on the nodes.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }

    /// [`gap`] of its history, or of where coarser levels left it.
    pub fn gap(&self) -> f64 {
        stop_condition::gap_of(self)
    }

    /// max_i E_i.
    pub fn energy_max(&self) -> f64 {
        self.cell_energy.iter().copied().fold(0.0, f64::max)
    }
}

/// The diagram of `field` that `options` asks for. Polls `token` once per iteration.
///
/// # Errors
/// [`Cancelled`] once the token is.
pub fn diagram(
    field: &EnergyField,
    options: &DiagramOptions,
    workspace: &mut DiagramWorkspace,
    token: &CancelToken,
) -> Result<Diagram, Cancelled> {
    let mut diagram = Diagram::default();
    diagram_into(field, options, workspace, token, &mut diagram)?;
    Ok(diagram)
}

/// [`diagram`] into one that exists, whose memory is reused. After an error its contents are of no use.
///
/// # Errors
/// [`Cancelled`] once the token is.
pub fn diagram_into(
    field: &EnergyField,
    options: &DiagramOptions,
    workspace: &mut DiagramWorkspace,
    token: &CancelToken,
    diagram: &mut Diagram,
) -> Result<(), Cancelled> {
    diagram_until(field, options, workspace, &mut &*token, diagram)
}

/// [`diagram_into`], whose descent `stop` may end before it converges.
///
/// # Errors
/// [`Cancelled`] once the token of `stop` is.
pub fn diagram_until(
    field: &EnergyField,
    options: &DiagramOptions,
    workspace: &mut DiagramWorkspace,
    stop: &mut dyn StopCondition,
    diagram: &mut Diagram,
) -> Result<(), Cancelled> {
    let sites = options.sites.clamp(1, field.nodes());
    let mut stream = RandomStream::new(options.seed, u64::from(options.start) << 32 | sites as u64);
    let DiagramWorkspace { start, sites: drawn, levels, current, .. } = &mut *workspace;
    // Neither waits for the other.
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
    workspace.hand_over(field, diagram);
    Ok(())
}

/// Exact labels of given sites (site-major, m each, at least one) and their energies E_i, without moving them.
pub fn assign(field: &EnergyField, sites: &[f64], workspace: &mut DiagramWorkspace) -> Diagram {
    let mut diagram = Diagram::default();
    workspace::load(&mut workspace.levels, field, field.nodes());
    workspace.current.set_sites(sites, field.dimension());
    workspace.scratch.assign(&workspace.levels[0], &mut workspace.current);
    diagram.history.push(workspace.current.energy);
    diagram.converged = true;
    workspace.hand_over(field, &mut diagram);
    diagram
}
