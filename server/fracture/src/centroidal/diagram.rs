//! A Voronoi diagram of the lattice nodes, and the options of its computation.

use super::lloyd::ITERATIONS_MAX;
use super::stop_condition::gap_of;
use crate::lift::LiftedLattice;

/// Default of [`DiagramOptions::tolerance`].
///
/// The energy ends about 0.4 % above that of the same descent run to its end, which is less than the difference of two
/// descents from different starts.
pub const TOLERANCE: f64 = 1e-3;

/// Options of a diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagramOptions {
    /// Number of sites; clamped to 1 ..= nodes.
    pub sites: usize,
    /// Seed. All random numbers follow from (seed, start, sites).
    pub seed: u64,
    /// Number of the start among independent ones of one seed; 0 unless starts are compared.
    pub start: u32,
    /// Relative decrease of F per iteration below which the descent ends.
    ///
    /// Smaller is more accurate. At 0 it runs to a fixed point or to `iterations_max`.
    pub tolerance: f64,
    /// Largest number of iterations on the nodes, of which the last is a plain one.
    ///
    /// With 0 the sites remain those of the start, or of the last coarser level.
    pub iterations_max: usize,
}

impl DiagramOptions {
    /// Options for `sites` sites, with start 0 and default tolerance.
    pub fn new(sites: usize, seed: u64) -> Self {
        Self { sites, seed, start: 0, tolerance: TOLERANCE, iterations_max: ITERATIONS_MAX }
    }
}

/// Voronoi diagram of the lattice nodes, centroidal up to the tolerance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagram {
    /// Dimension m.
    pub dimension: usize,
    /// Sites p_i, site-major, `sites × m`, lifted coordinates. The labels belong to exactly these sites.
    pub sites: Vec<f64>,
    /// argmin_i |X_v − p_i|² per node in f64; ties go to the lowest index. A cell may be empty if nodes coincide.
    pub labels: Vec<u32>,
    /// E_i = Σ_v w_v(|X_v − p_i|² + 2 b_v·(X_v − p_i) + m_v) per site; unit of the masses times local length squared.
    ///
    /// b_v and m_v are the moments of node v's own cell, so E_i is the integral of W|X −
    /// p_i|² over the cells of the nodes.
    pub cell_energy: Vec<f64>,
    /// F = Σ_v w_v|X_v − p|², without the moments of the nodes' own cells.
    pub energy: f64,
    /// F of the start, or of the sites from coarse levels, and after each iteration on the nodes. Never rises.
    pub history: Vec<f64>,
    /// Number of iterations on coarser levels.
    pub coarse_iterations: usize,
    /// True if the tolerance was met before the iteration limit.
    pub converged: bool,
}

impl Diagram {
    /// Number of sites.
    pub fn count(&self) -> usize {
        self.cell_energy.len()
    }

    /// Site p_i, length m.
    pub fn site(&self, site: usize) -> &[f64] {
        &self.sites[site * self.dimension..][..self.dimension]
    }

    /// Nearest node to each site; ties go to the lowest index. `lift` is that of the field.
    ///
    /// The node belongs to the site's own cell if the cell has one.
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

    /// Number of iterations on the nodes.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }

    /// Estimated [`gap`](super::gap) of the diagram, from its history or from its coarse levels.
    pub fn gap(&self) -> f64 {
        gap_of(self)
    }

    /// Largest cell energy, max_i E_i.
    pub fn energy_max(&self) -> f64 {
        self.cell_energy.iter().copied().fold(0.0, f64::max)
    }
}
