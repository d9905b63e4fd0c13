//! Cells to fragments: a cell of the diagram can be disconnected in space, and its components are pieces of their own.
//!
//! Based on: B. A. Galler, M. J. Fischer, *An improved equivalence algorithm* (CACM 7, 1964), over the sorted edges, with the paths
//! halved (R. E. Tarjan, J. van Leeuwen, 1984). Roots are lowest nodes.

use super::Topology;

/// The connected components of a site labelling.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Components {
    /// Fragment of each lattice node; dense from 0.
    pub labels: Vec<u32>,
    /// Site of each fragment; ascending.
    pub sites: Vec<u32>,
    order: Vec<u32>,
    found: Vec<u32>,
}

impl Components {
    /// None yet, in memory that was of use before.
    pub(crate) fn from_memory(labels: Vec<u32>, sites: Vec<u32>) -> Self {
        Self { labels, sites, ..Self::default() }
    }

    /// Splits every cell of `site_labels` (one site per node of the lattice that `topology` was made from) into its
    /// components over lattice edges, numbered by site, then by lowest node. Two components of one site never share an
    /// edge. Reuses what an earlier call allocated.
    pub fn split(&mut self, topology: &Topology, site_labels: &[u32]) {
        debug_assert_eq!(site_labels.len(), topology.nodes);
        self.labels.clear();
        self.labels.extend(0..site_labels.len() as u32);
        for &[lower, higher] in &topology.edges {
            if site_labels[lower as usize] == site_labels[higher as usize] {
                self.join(lower, higher);
            }
        }
        self.found.clear();
        for (node, &site) in site_labels.iter().enumerate() {
            // What a node points to is no higher, and has its component already.
            let parent = self.labels[node] as usize;
            if parent == node {
                self.labels[node] = self.found.len() as u32;
                self.found.push(site);
            } else {
                self.labels[node] = self.labels[parent];
            }
        }
        self.renumber();
    }

    /// Makes the trees of two nodes one, whose root is the lower of theirs.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.labels[a.max(b) as usize] = a.min(b);
    }

    /// The lowest node of the tree of `node`.
    fn root(&mut self, mut node: u32) -> u32 {
        while self.labels[node as usize] != node {
            let above = self.labels[self.labels[node as usize] as usize];
            self.labels[node as usize] = above;
            node = above;
        }
        node
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
