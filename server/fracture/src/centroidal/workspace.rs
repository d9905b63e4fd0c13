//! Memory that diagrams are made in.

use super::assign::{Scratch, State};
use super::{Diagram, Field, start};

/// Reused from diagram to diagram: after the largest one, no call allocates anything that grows with the mesh.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(super) scratch: Scratch,
    pub(super) start: start::Scratch,
    /// The start's sites, m each.
    pub(super) sites: Vec<f64>,
    /// The state reached.
    pub(super) current: State,
    /// The state tried next, or the one before.
    pub(super) trial: State,
}

impl Workspace {
    /// Copies the state reached into `diagram` and adds the moments of the nodes' own cells.
    pub(super) fn hand_over(&self, field: &Field, diagram: &mut Diagram) {
        let (current, m) = (&self.current, field.dimension());
        diagram.dimension = m;
        diagram.sites.clear();
        diagram.sites.extend((0..current.count()).flat_map(|site| &current.site(site)[..m]));
        diagram.labels.clone_from(&current.labels);
        diagram.energy = current.energy;
        diagram.cell_energy.clear();
        diagram.cell_energy.extend((0..current.count()).map(|site| current.cell(site).1));
        for (node, (&label, mass)) in current.labels.iter().zip(field.mass()).enumerate() {
            let site = &current.site(label as usize)[..m];
            diagram.cell_energy[label as usize] += mass * field.cell_moment(node, site);
        }
    }
}
