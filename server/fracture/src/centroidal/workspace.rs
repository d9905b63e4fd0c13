//! Working memory of diagrams.

use super::assign::{AssignScratch, AssignState};
use super::level::PointLevel;
use super::lloyd::LloydState;
use super::{Diagram, DiagramOptions, EnergyField, seeding};
use rayon::prelude::*;

/// Working memory of diagrams, reused between them.
///
/// After the largest diagram, no call allocates memory that grows with the mesh.
#[derive(Clone, Debug, Default)]
pub struct DiagramWorkspace {
    /// Memory of the assignments.
    pub(super) scratch: AssignScratch,
    /// Memory of the start.
    pub(super) start: seeding::SeedScratch,
    /// Nodes of the field, then groups of them, coarser and coarser.
    pub(super) levels: Vec<PointLevel>,
    /// Sites of the start, m each.
    pub(super) sites: Vec<f64>,
    /// State reached.
    pub(super) current: AssignState,
    /// State tried next, or the previous one.
    pub(super) trial: AssignState,
    /// Per part and cell: Σ w(X − p) b by coordinate, and Σ w m, with b and m the moments of the nodes' own cells.
    pub(super) moments: Vec<f64>,
}

/// Nodes per part in the sum of moments.
const PART: usize = 4096;

/// Points per site that a level must have for a descent to begin on it.
const POINTS_PER_SITE: usize = 12;

/// Refills the levels on which `sites` sites can begin. Returns the number of levels.
pub(super) fn load(levels: &mut Vec<PointLevel>, field: &EnergyField, sites: usize) -> usize {
    let groups = field.clusters().map_or(&[][..], |clusters| clusters.levels());
    let enough = |groups: &&super::clusters::Groups| groups.count() >= POINTS_PER_SITE * sites;
    let coarse = groups.iter().take_while(enough).count();
    let count = levels.len().max(coarse + 1);
    levels.resize_with(count, PointLevel::default);
    levels[0].load(field, groups.first());
    for index in 1..=coarse {
        let (finer, coarser) = levels.split_at_mut(index);
        coarser[0].coarsen(&finer[index - 1], groups.get(index));
    }
    coarse + 1
}

impl DiagramWorkspace {
    /// Level `index`, and the state that a descent on it changes.
    pub(super) fn descent(
        &mut self,
        index: usize,
        pinned: usize,
        options: &DiagramOptions,
    ) -> (&PointLevel, LloydState<'_>) {
        let Self { scratch, levels, current, trial, .. } = self;
        let DiagramOptions { tolerance, iterations_max, .. } = *options;
        (&levels[index], LloydState { scratch, current, trial, pinned, tolerance, iterations_max })
    }

    /// Copies the state reached to `diagram` and adds the moments of the nodes' own cells.
    pub(super) fn write_diagram(&mut self, field: &EnergyField, diagram: &mut Diagram) {
        let (current, m) = (&self.current, field.dimension());
        diagram.dimension = m;
        diagram.sites.clear();
        diagram.sites.extend((0..current.count()).flat_map(|site| &current.site(site)[..m]));
        diagram.labels.resize(current.labels.len(), 0);
        for (&label, &node) in current.labels.iter().zip(&self.levels[0].order) {
            diagram.labels[node as usize] = label;
        }
        diagram.energy = current.energy;
        diagram.cell_energy.clear();
        diagram.cell_energy.extend((0..current.count()).map(|site| current.cell(site).1));
        self.add_moments(field, diagram);
    }

    /// Adds Σ w(2 b·(X − p) + m) to each cell's energy, by coordinate and by parts of the nodes,
    /// which are added up at the end.
    fn add_moments(&mut self, field: &EnergyField, diagram: &mut Diagram) {
        let (m, lift, entries) = (field.dimension(), field.lift(), diagram.count() * (field.dimension() + 1));
        self.moments.clear();
        self.moments.resize(field.nodes().div_ceil(PART) * entries, 0.0);
        let (labels, sites) = (&diagram.labels, &diagram.sites);
        self.moments.par_chunks_mut(entries).enumerate().for_each(|(part, sums)| {
            for (node, &site) in labels.iter().enumerate().skip(part * PART).take(PART) {
                let (site, mass) = (site as usize, field.mass()[node]);
                let sums = &mut sums[site * (m + 1)..][..m + 1];
                let levers = lift.at(node).iter().zip(&sites[site * m..][..m]).zip(&lift.first_moment[node * m..][..m]);
                sums.iter_mut().zip(levers).for_each(|(sum, ((x, p), b))| *sum += mass * ((x - p) * b));
                sums[m] += mass * lift.second_moment[node];
            }
        });
        for part in self.moments.chunks_exact(entries) {
            for (energy, sums) in diagram.cell_energy.iter_mut().zip(part.chunks_exact(m + 1)) {
                *energy += 2.0 * sums[..m].iter().sum::<f64>() + sums[m];
            }
        }
    }
}
