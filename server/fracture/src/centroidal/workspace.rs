//! Memory that diagrams are made in.

use super::assign::{Scratch, State};
use super::kernel::LANES;
use super::level::Level;
use super::lloyd::Descent;
use super::{Diagram, Field, start};

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
    pub(super) fn descent(&mut self, index: usize, pinned: usize) -> (&Level, Descent<'_>) {
        let Self { scratch, levels, current, trial, .. } = self;
        (&levels[index], Descent { scratch, current, trial, pinned })
    }

    /// Copies the state reached into `diagram` and adds the moments of the nodes' own cells.
    pub(super) fn hand_over(&self, field: &Field, diagram: &mut Diagram) {
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

    /// Adds Σ w(2 b·(X − p) + m) to each cell's energy.
    fn add_moments(&self, field: &Field, diagram: &mut Diagram) {
        let (m, lift) = (field.dimension(), field.lift());
        let nodes = lift.coordinates.chunks_exact(m).zip(lift.first_moment.chunks_exact(m)).zip(&lift.second_moment);
        for (((place, offset), second), (&label, &mass)) in nodes.zip(diagram.labels.iter().zip(field.mass())) {
            let site = &diagram.sites[label as usize * m..][..m];
            diagram.cell_energy[label as usize] += mass * (2.0 * lever(place, site, offset) + second);
        }
    }
}

/// (X − p)·b, summed in [`LANES`] interleaved parts.
fn lever(place: &[f64], site: &[f64], offset: &[f64]) -> f64 {
    let mut parts = [0.0; LANES];
    let (places, place_rest) = place.as_chunks::<LANES>();
    let (sites, site_rest) = site.as_chunks::<LANES>();
    let (offsets, offset_rest) = offset.as_chunks::<LANES>();
    for ((x, p), b) in places.iter().zip(sites).zip(offsets) {
        (0..LANES).for_each(|lane| parts[lane] += (x[lane] - p[lane]) * b[lane]);
    }
    for ((part, (x, p)), b) in parts.iter_mut().zip(place_rest.iter().zip(site_rest)).zip(offset_rest) {
        *part += (x - p) * b;
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3])
}
