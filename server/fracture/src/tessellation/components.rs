//! Fragments from cells: a cell of the diagram can be disconnected in space, and each of its components is a fragment.
//!
//! Based on: M. Sutton, T. Ben-Nun, A. Barak, *Optimizing parallel graph connectivity computation via subgraph sampling*
//! (IPDPS 2018): a few edges of each node join most of a cell, and the others are looked at only outside the largest part
//! of it. The trees are those of B. A. Galler, M. J. Fischer, *An improved equivalence algorithm* (CACM 7, 1964), with path
//! halving (R. E. Tarjan, J. van Leeuwen, 1984). The root of each tree is its lowest node.

use super::Topology;
use rayon::prelude::*;

/// Number of consecutive nodes in a part.
const PART: usize = 16_384;

/// Edges of each node to lower ones that are joined first.
const FIRST_EDGES: usize = 2;

/// Connected components of a labeling by sites.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Components {
    /// Fragment of each lattice node, from 0 without gaps.
    pub labels: Vec<u32>,
    /// Site of each fragment, ascending.
    pub sites: Vec<u32>,
    order: Vec<u32>,
    found: Vec<u32>,
    /// Edges from each part of the nodes to lower parts.
    across: Vec<Vec<[u32; 2]>>,
    /// Roots of the trees that the first edges make, ascending.
    roots: Vec<u32>,
    /// Number of nodes in the tree of each root.
    sizes: Vec<u32>,
    /// Root of the largest tree of each site.
    largest: Vec<u32>,
    /// Nodes outside the largest tree of their site.
    outside: Vec<u32>,
}

impl Components {
    /// An empty instance that reuses the given memory.
    pub(crate) fn from_memory(labels: Vec<u32>, sites: Vec<u32>) -> Self {
        Self { labels, sites, ..Self::default() }
    }

    /// Splits every cell of `site_labels` into its connected components over lattice edges.
    ///
    /// `site_labels` has one site per node of the lattice of `topology`. Components are numbered by site, then by
    /// lowest node. Two components of one site never share an edge. Reuses the memory of earlier calls.
    pub fn split(&mut self, topology: &Topology, site_labels: &[u32]) {
        debug_assert_eq!(site_labels.len(), topology.nodes);
        self.labels.clear();
        self.labels.extend(0..site_labels.len() as u32);
        self.join_first_edges(topology, site_labels);
        self.find_outside(site_labels);
        let mut forest = Forest { first: 0, labels: &mut self.labels };
        for &node in &self.outside {
            for &other in topology.neighbors(node as usize) {
                if site_labels[other as usize] == site_labels[node as usize] {
                    forest.join([node.min(other), node.max(other)]);
                }
            }
        }
        self.found.clear();
        for (node, &site) in site_labels.iter().enumerate() {
            // The parent of a node is not higher, so it already has its component.
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

    /// Joins the first edges of each node inside its cell: inside each part of the nodes, in parallel, then across parts.
    fn join_first_edges(&mut self, topology: &Topology, site_labels: &[u32]) {
        self.across.resize_with(site_labels.len().div_ceil(PART), Vec::new);
        let parts = self.labels.par_chunks_mut(PART).zip(&mut self.across).enumerate();
        parts.for_each(|(part, (labels, across))| {
            across.clear();
            let first = (part * PART) as u32;
            let end = first + labels.len() as u32;
            let mut forest = Forest { first, labels };
            for node in first..end {
                let site = site_labels[node as usize];
                let lower = topology.neighbors(node as usize).iter().take_while(|other| **other < node);
                let in_cell = lower.filter(|other| site_labels[**other as usize] == site);
                for &other in in_cell.take(FIRST_EDGES) {
                    if other < first { across.push([other, node]) } else { forest.join([other, node]) }
                }
            }
        });
        let mut forest = Forest { first: 0, labels: &mut self.labels };
        self.across.iter().flatten().for_each(|&edge| forest.join(edge));
    }

    /// Finds the nodes outside the largest tree of their site, and makes every node point to its root.
    fn find_outside(&mut self, site_labels: &[u32]) {
        self.sizes.clear();
        self.sizes.resize(site_labels.len(), 0);
        self.roots.clear();
        for node in 0..site_labels.len() {
            let root = self.labels[self.labels[node] as usize];
            self.labels[node] = root;
            self.sizes[root as usize] += 1;
            if root as usize == node {
                self.roots.push(root);
            }
        }
        let site = |root: u32| site_labels[root as usize] as usize;
        let sites = self.roots.iter().map(|&root| site(root) + 1).max().unwrap_or(0);
        self.largest.clear();
        self.largest.resize(sites, NONE);
        for &root in &self.roots {
            let largest = &mut self.largest[site(root)];
            if *largest == NONE || self.sizes[root as usize] > self.sizes[*largest as usize] {
                *largest = root;
            }
        }
        self.outside.clear();
        let nodes = self.labels.iter().zip(site_labels).enumerate();
        let outside = nodes.filter(|(_, (root, site))| self.largest[**site as usize] != **root);
        self.outside.extend(outside.map(|(node, _)| node as u32));
    }

    /// Renumbers components from the order of lowest nodes to that of (site, lowest node).
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

/// No root yet.
const NONE: u32 = u32::MAX;

/// Trees of consecutive nodes, by the parent of each node, which is never higher.
struct Forest<'a> {
    /// First of the nodes.
    first: u32,
    labels: &'a mut [u32],
}

impl Forest<'_> {
    fn parent(&mut self, node: u32) -> &mut u32 {
        &mut self.labels[(node - self.first) as usize]
    }

    /// Joins the trees of an edge's ends, the lower one first, under the lower of their roots.
    #[inline]
    fn join(&mut self, [lower, higher]: [u32; 2]) {
        // Most nodes have no tree yet, or already the right one.
        let [above_lower, above_higher] = [lower, higher].map(|node| *self.parent(node));
        if above_higher == higher {
            *self.parent(higher) = above_lower;
        } else if above_higher != above_lower {
            let (a, b) = (self.root(lower), self.root(higher));
            *self.parent(a.max(b)) = a.min(b);
        }
    }

    /// The root of the tree of `node`, its lowest node.
    fn root(&mut self, mut node: u32) -> u32 {
        while *self.parent(node) != node {
            let above = *self.parent(node);
            let above = *self.parent(above);
            *self.parent(node) = above;
            node = above;
        }
        node
    }
}

/// [`Components::split`] into new memory.
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
    fn components_cross_the_parts_of_the_nodes() {
        let lattice = block([26, 26, 26], 0.03);
        let topology = Topology::new(&lattice);
        assert!(topology.nodes > 2 * PART);
        // Slabs across the order of the nodes, two of which have one site; in the middle, single nodes.
        let sites: Vec<u32> = (0..topology.nodes as u32)
            .zip(&lattice.nodes)
            .map(|(node, place)| if place.coords.norm() < 0.1 { node % 7 } else { ((place.x + 1.0) * 9.0) as u32 % 5 })
            .collect();
        let split = components(&topology, &sites);
        let mut expected = vec![u32::MAX; topology.nodes];
        let (mut count, mut open) = (0, Vec::new());
        for start in 0..topology.nodes {
            if expected[start] == u32::MAX {
                open.push(start);
                expected[start] = start as u32;
                count += 1;
            }
            while let Some(node) = open.pop() {
                for &other in topology.neighbors(node) {
                    if expected[other as usize] == u32::MAX && sites[other as usize] == sites[node] {
                        expected[other as usize] = start as u32;
                        open.push(other as usize);
                    }
                }
            }
        }
        assert_eq!(split.sites.len(), count);
        let lowest = |node: usize| split.labels.iter().position(|&label| label == split.labels[node]);
        for node in (0..topology.nodes).step_by(97) {
            assert_eq!(lowest(node), Some(expected[node] as usize), "{node}");
        }
    }

    #[test]
    fn a_reused_splitter_gives_the_same_components() {
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
