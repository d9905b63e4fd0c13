//! Memory that diagrams are made in.

use super::assign::{Scratch, State};
use super::level::Level;
use super::lloyd::Descent;
use super::{Diagram, Field, Options, start};

/// Reused from diagram to diagram: after the largest one, no call allocates anything that grows with the mesh.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(super) scratch: Scratch,
    pub(super) start: start::Scratch,
    /// The nodes of the field, then groups of them, coarser and coarser.
    pub(super) levels: Vec<Level>,
    /// The start's sites, m each.
    pub(super) sites: Vec<f64>,
    /// The state reached.
    pub(super) current: State,
    /// The state tried next, or the one before.
    pub(super) trial: State,
    /// Σ w(X − p) b of each cell by coordinate, b the first moments of the nodes' own cells.
    pub(super) moments: Vec<f64>,
}

/// Points per site that a level needs, to begin on.
const POINTS_PER_SITE: usize = 12;

impl Workspace {
    /// Refills as many levels as `sites` sites can begin on; their number.
    pub(super) fn load(&mut self, field: &Field, sites: usize) -> usize {
        let groups = field.clusters().map_or(&[][..], |clusters| clusters.levels());
        let enough = |groups: &&super::clusters::Groups| groups.count() >= POINTS_PER_SITE * sites;
        let coarse = groups.iter().take_while(enough).count();
        let count = self.levels.len().max(coarse + 1);
        self.levels.resize_with(count, Level::default);
        self.levels[0].load(field, groups.first());
        for index in 1..=coarse {
            let (finer, coarser) = self.levels.split_at_mut(index);
            coarser[0].coarsen(&finer[index - 1], groups.get(index));
        }
        coarse + 1
    }

    /// Level `index`, and what a descent on it moves.
    pub(super) fn descent(&mut self, index: usize, pinned: usize, options: &Options) -> (&Level, Descent<'_>) {
        let Self { scratch, levels, current, trial, .. } = self;
        let Options { tolerance, iterations_max, .. } = *options;
        (&levels[index], Descent { scratch, current, trial, pinned, tolerance, iterations_max })
    }

    /// Copies the state reached into `diagram` and adds the moments of the nodes' own cells.
    pub(super) fn hand_over(&mut self, field: &Field, diagram: &mut Diagram) {
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

    /// Adds Σ w(2 b·(X − p) + m) to each cell's energy: by coordinate, and these added up at the end.
    fn add_moments(&mut self, field: &Field, diagram: &mut Diagram) {
        let (m, lift) = (field.dimension(), field.lift());
        self.moments.clear();
        self.moments.resize(diagram.count() * m, 0.0);
        let nodes = lift.coordinates.chunks_exact(m).zip(lift.first_moment.chunks_exact(m)).zip(&lift.second_moment);
        for (((place, offset), second), (&label, mass)) in nodes.zip(diagram.labels.iter().zip(field.mass())) {
            let sums = &mut self.moments[label as usize * m..][..m];
            let levers = place.iter().zip(&diagram.sites[label as usize * m..][..m]).zip(offset);
            sums.iter_mut().zip(levers).for_each(|(sum, ((x, p), b))| *sum += mass * ((x - p) * b));
            diagram.cell_energy[label as usize] += mass * second;
        }
        for (energy, sums) in diagram.cell_energy.iter_mut().zip(self.moments.chunks_exact(m)) {
            *energy += 2.0 * sums.iter().sum::<f64>();
        }
    }
}
