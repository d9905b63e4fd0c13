//! Hierarchy of small connected groups of nodes, built once per lattice. Most of an assignment then reads groups only.
//!
//! Based on: P. Vaněk, J. Mandel, M. Brezina, *Algebraic multigrid by smoothed aggregation* (Computing 56, 1996),
//! section 4: a free point takes its free neighbors. Groups never cross a gap that the lattice does not cross.

use crate::memory::held;

/// Smallest number of groups of a coarser level.
const GROUPS_MIN: usize = 96;

/// Levels of groups, finest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clusters {
    levels: Vec<Groups>,
}

/// Partition of points into groups.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Groups {
    /// Start of each group in `members`, and the number of members.
    pub offsets: Vec<u32>,
    /// Points, by group, ascending within one.
    pub members: Vec<u32>,
}

/// Adjacency of points, as compressed rows.
struct Graph {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl Clusters {
    /// Groups `nodes` nodes. `neighbors` returns the nodes adjacent to a node.
    pub fn new<'a>(nodes: usize, neighbors: impl Fn(usize) -> &'a [u32]) -> Self {
        let mut graph = Graph { offsets: vec![0], neighbors: Vec::new() };
        for node in 0..nodes {
            graph.neighbors.extend_from_slice(neighbors(node));
            graph.offsets.push(graph.neighbors.len() as u32);
        }
        let mut levels = Vec::new();
        while graph.points() >= 2 * GROUPS_MIN {
            let (of, groups) = graph.gather();
            // Isolated points cannot be grouped.
            if groups.count() < GROUPS_MIN || 2 * groups.count() > graph.points() {
                break;
            }
            graph = graph.coarser(&of, &groups);
            levels.push(groups);
        }
        Self { levels }
    }

    /// Levels, finest first.
    pub(super) fn levels(&self) -> &[Groups] {
        &self.levels
    }

    /// Number of nodes; `None` if there are no groups.
    pub(super) fn nodes(&self) -> Option<usize> {
        self.levels.first().map(|groups| groups.members.len())
    }

    /// Bytes of memory that they hold.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|groups| held(&groups.offsets) + held(&groups.members)).sum()
    }
}

impl Groups {
    /// Number of groups.
    pub fn count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Points of group `group`.
    pub fn of(&self, group: usize) -> &[u32] {
        &self.members[self.offsets[group] as usize..self.offsets[group + 1] as usize]
    }
}

impl Graph {
    fn points(&self) -> usize {
        self.offsets.len() - 1
    }

    fn around(&self, point: usize) -> &[u32] {
        &self.neighbors[self.offsets[point] as usize..self.offsets[point + 1] as usize]
    }

    /// Groups the points: each free one, in order, takes its free neighbors. Returns the group
    /// of each point, and the groups.
    ///
    /// A point without free neighbors joins the group of its lowest neighbor that has one.
    fn gather(&self) -> (Vec<u32>, Groups) {
        const FREE: u32 = u32::MAX;
        let (mut of, mut count) = (vec![FREE; self.points()], 0);
        for point in 0..self.points() {
            if of[point] != FREE {
                continue;
            }
            let free = self.around(point).iter().filter(|other| of[**other as usize] == FREE).count();
            let joined = self.around(point).iter().map(|other| of[*other as usize]).find(|group| *group != FREE);
            match joined {
                Some(group) if free == 0 => of[point] = group,
                _ => {
                    of[point] = count;
                    for &other in self.around(point) {
                        if of[other as usize] == FREE {
                            of[other as usize] = count;
                        }
                    }
                    count += 1;
                }
            }
        }
        let mut offsets = vec![0u32; count as usize + 1];
        of.iter().for_each(|&group| offsets[group as usize + 1] += 1);
        (0..count as usize).for_each(|group| offsets[group + 1] += offsets[group]);
        let (mut next, mut members) = (offsets.clone(), vec![0; self.points()]);
        for (point, &group) in of.iter().enumerate() {
            members[next[group as usize] as usize] = point as u32;
            next[group as usize] += 1;
        }
        (of, Groups { offsets, members })
    }

    /// Adjacency of the groups.
    fn coarser(&self, of: &[u32], groups: &Groups) -> Self {
        let (mut offsets, mut neighbors, mut own) = (vec![0], Vec::new(), Vec::new());
        for group in 0..groups.count() {
            own.clear();
            own.extend(
                groups.of(group).iter().flat_map(|&point| self.around(point as usize)).map(|&other| of[other as usize]),
            );
            own.sort_unstable();
            own.dedup();
            neighbors.extend(own.iter().filter(|other| **other != group as u32));
            offsets.push(neighbors.len() as u32);
        }
        Self { offsets, neighbors }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;
    use crate::tessellation::Topology;

    #[test]
    fn every_point_is_in_one_connected_group() {
        let topology = Topology::new(&block([14, 12, 10], 0.1));
        let clusters = Clusters::new(topology.nodes, |node| topology.neighbors(node));
        assert_eq!(clusters.nodes(), Some(topology.nodes));
        assert!(clusters.levels().len() >= 2);
        let mut points = topology.nodes;
        for groups in clusters.levels() {
            let mut members = groups.members.clone();
            members.sort_unstable();
            assert!(members.iter().copied().eq(0..points as u32));
            assert!(3 * groups.count() < points, "{} groups of {points}", groups.count());
            points = groups.count();
        }
        for group in 0..clusters.levels()[0].count() {
            let own = clusters.levels()[0].of(group);
            let touches =
                |node: u32| topology.neighbors(node as usize).iter().filter(|other| own.contains(other)).count();
            assert!(own.len() == 1 || own.iter().all(|&node| touches(node) > 0));
        }
    }

    #[test]
    fn few_or_isolated_nodes_have_no_groups() {
        assert_eq!(Clusters::new(20, |_| &[]).nodes(), None);
        assert_eq!(Clusters::new(1000, |_| &[]).nodes(), None);
        assert_eq!(Clusters::new(0, |_| &[]).nodes(), None);
    }
}
