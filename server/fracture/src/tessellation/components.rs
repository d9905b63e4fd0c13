//! Cells to fragments: a cell of the diagram can be disconnected in space, and its components are pieces of their own.

use super::Topology;

const UNSEEN: u32 = u32::MAX;

/// The connected components of a site labelling.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Components {
    /// Fragment of each lattice node; dense from 0.
    pub labels: Vec<u32>,
    /// Site of each fragment; ascending.
    pub sites: Vec<u32>,
    stack: Vec<u32>,
    order: Vec<u32>,
    found: Vec<u32>,
}

impl Components {
    /// Splits every cell of `site_labels` (one site per node of the lattice that `topology` was made from) into its
    /// components over lattice edges, numbered by site, then by lowest node. Two components of one site never share an
    /// edge. Reuses what an earlier call allocated.
    pub fn split(&mut self, topology: &Topology, site_labels: &[u32]) {
        debug_assert_eq!(site_labels.len(), topology.nodes);
        self.labels.clear();
        self.labels.resize(site_labels.len(), UNSEEN);
        self.found.clear();
        for node in 0..site_labels.len() {
            if self.labels[node] == UNSEEN {
                self.flood(topology, site_labels, node);
                self.found.push(site_labels[node]);
            }
        }
        self.renumber();
    }

    /// Labels everything reachable from `start` within its cell with the number of components found so far.
    fn flood(&mut self, topology: &Topology, site_labels: &[u32], start: usize) {
        let component = self.found.len() as u32;
        self.labels[start] = component;
        self.stack.push(start as u32);
        while let Some(node) = self.stack.pop() {
            for &next in topology.neighbours(node as usize) {
                if self.labels[next as usize] == UNSEEN && site_labels[next as usize] == site_labels[start] {
                    self.labels[next as usize] = component;
                    self.stack.push(next);
                }
            }
        }
    }

    /// From the order of lowest nodes to the order of (site, lowest node).
    fn renumber(&mut self) {
        self.order.clear();
        self.order.extend(0..self.found.len() as u32);
        let found = &self.found;
        self.order.sort_unstable_by_key(|&component| (found[component as usize], component));
        self.sites.clear();
        self.sites.extend(self.order.iter().map(|&component| found[component as usize]));
        for (fragment, &component) in self.order.iter().enumerate() {
            self.found[component as usize] = fragment as u32;
        }
        self.labels.iter_mut().for_each(|label| *label = self.found[*label as usize]);
    }
}

/// [`Components::split`] into fresh memory.
pub fn components(topology: &Topology, site_labels: &[u32]) -> Components {
    let mut components = Components::default();
    components.split(topology, site_labels);
    components
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    #[test]
    fn disconnected_cells_split_and_keep_their_site() {
        let lattice = block([6, 1, 1], 0.1);
        let topology = Topology::new(&lattice);
        // Two ends of site 7 around a middle of site 3: the middle comes first, then the end with the lowest node.
        let sites: Vec<u32> = lattice.nodes.iter().map(|node| if node.x.abs() < 0.08 { 3 } else { 7 }).collect();
        let split = components(&topology, &sites);
        assert_eq!(split.sites, [3, 7, 7]);
        for (node, place) in lattice.nodes.iter().enumerate() {
            let low_end = (lattice.nodes[0].x < 0.0) == (place.x < 0.0);
            let expected = if sites[node] == 3 {
                0
            } else if low_end {
                1
            } else {
                2
            };
            assert_eq!(split.labels[node], expected);
        }
    }

    #[test]
    fn a_reused_splitter_answers_as_a_fresh_one() {
        let lattice = block([3, 3, 3], 0.1);
        let topology = Topology::new(&lattice);
        let mut reused = Components::default();
        for modulus in [5, 2, 9, 1] {
            let sites: Vec<u32> =
                (0..topology.nodes as u32).map(|node| node.wrapping_mul(2_654_435_761) % modulus).collect();
            reused.split(&topology, &sites);
            let fresh = components(&topology, &sites);
            assert_eq!((&reused.labels, &reused.sites), (&fresh.labels, &fresh.sites));
            for &[a, b] in &topology.edges {
                let [a, b] = [a as usize, b as usize];
                assert_eq!(sites[a] == sites[b], fresh.labels[a] == fresh.labels[b]);
            }
        }
    }
}
