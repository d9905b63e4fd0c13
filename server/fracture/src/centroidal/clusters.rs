//! Nodes in small connected groups, and the groups in groups: prepared once per lattice, so that most of an assignment looks at
//! groups instead of nodes.
//!
//! Based on: P. Vaněk, J. Mandel, M. Brezina, *Algebraic multigrid by smoothed aggregation* (Computing 56, 1996), section 4: whoever
//! is free takes its free neighbors. Groups never lead across a gap that the lattice does not cross.

use crate::memory::held;

/// No coarser level has fewer groups than this.
const GROUPS_MIN: usize = 96;

/// Levels of groups, the finest first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clusters {
    levels: Vec<Groups>,
}

/// Groups of points, every point in one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Groups {
    /// Where each group begins in `members`, and their number.
    pub offsets: Vec<u32>,
    /// Points, by group, ascending within one.
    pub members: Vec<u32>,
}

/// Who touches whom, as compressed rows.
struct Graph {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl Clusters {
    /// Groups of `nodes` nodes, of which `neighbors` tells which others each touches.
    pub fn new<'a>(nodes: usize, neighbors: impl Fn(usize) -> &'a [u32]) -> Self {
        let mut graph = Graph { offsets: vec![0], neighbors: Vec::new() };
        for node in 0..nodes {
            graph.neighbors.extend_from_slice(neighbors(node));
            graph.offsets.push(graph.neighbors.len() as u32);
        }
        let mut levels = Vec::new();
        while graph.points() >= 2 * GROUPS_MIN {
            let (of, groups) = graph.gather();
            // Pieces that touch nobody cannot be gathered.
            if groups.count() < GROUPS_MIN || 2 * groups.count() > graph.points() {
                break;
            }
            graph = graph.coarser(&of, &groups);
            levels.push(groups);
        }
        Self { levels }
    }

    /// The levels, the finest first.
    pub(super) fn levels(&self) -> &[Groups] {
        &self.levels
    }

    /// Number of nodes; `None`: there are no groups.
    pub(super) fn nodes(&self) -> Option<usize> {
        self.levels.first().map(|groups| groups.members.len())
    }

    /// Bytes that they hold.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|groups| held(&groups.offsets) + held(&groups.members)).sum()
    }
}

impl Groups {
    /// Number of groups.
    pub fn count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// The points of group `group`.
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

    /// Group of each point, and the groups: in the order of points, each free one takes its free neighbors; one that finds none
    /// joins the group of its lowest neighbor.
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

    /// Which groups touch.
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
    fn too_few_and_lonely_nodes_have_none() {
        assert_eq!(Clusters::new(20, |_| &[]).nodes(), None);
        assert_eq!(Clusters::new(1000, |_| &[]).nodes(), None);
        assert_eq!(Clusters::new(0, |_| &[]).nodes(), None);
    }
}
