//! Energy transfer from the elastic lattice to the crack lattice.

use super::overlap::{Overlap, OverlapCell};
use super::tree::{Aabb, AabbTree};
use super::{Lattice, Locator};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Smallest uncovered share of a crack tetrahedron, outside the elastic lattice, that is assigned to the nearest
/// elastic tetrahedra.
const UNCOVERED: f64 = 1e-6;

/// Products of a row that are summed in parallel lanes.
const SIDE: usize = 4;

/// Rows per parallel task.
const ROWS: usize = 1024;

/// Shares of elastic tetrahedra by crack node, as compressed rows.
///
/// Conservative by construction: the shares of every elastic tetrahedron sum to 1 over all crack nodes, so the energies
/// of the nodes sum to those of the tetrahedra. A node's share of a tetrahedron is the integral of the node's hat
/// function over it, exact to rounding. So a uniform density stays uniform well inside. Parts of the crack lattice
/// outside the elastic lattice take their shares from the nearest elastic tetrahedra.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyTransfer {
    /// Start of each row; length crack nodes + 1.
    pub offsets: Vec<u32>,
    /// Elastic tetrahedra, increasing within a row.
    pub tets: Vec<u32>,
    /// Share of each tetrahedron that goes to the row's node, in (0, 1].
    pub shares: Vec<f64>,
}

/// Entry before normalization: crack node, elastic tetrahedron, volume.
type Entry = (u32, u32, f64);

/// Index that marks a node or tetrahedron outside the part in [`EnergyTransfer::part`].
pub const NO_INDEX: u32 = u32::MAX;

/// Adds `next` to `kept` and returns true if both belong to the same pair.
fn merged(next: &mut Entry, kept: &mut Entry) -> bool {
    let same = (next.0, next.1) == (kept.0, kept.1);
    if same {
        kept.2 += next.2;
    }
    same
}

impl EnergyTransfer {
    /// Builds the operator between two lattices of one body. Neither may be empty.
    pub fn between(elastic: &Lattice, crack: &Lattice) -> Self {
        let cover = Cover::new(elastic);
        let mut entries: Vec<Entry> = (0..crack.tets.len())
            .into_par_iter()
            .map_init(Overlap::default, |overlap, tet| cover.entries(crack, tet, overlap))
            .flatten_iter()
            .collect();
        entries.extend(left_out(elastic, crack, &entries));
        // The stable sort keeps the entries of one pair in the order of the crack tetrahedra, and so their sum.
        entries.par_sort_by_key(|&(node, tet, _)| (node, tet));
        entries.dedup_by(merged);
        Self::normalized(&entries, elastic.tets.len(), crack.nodes.len())
    }

    /// Operator between a lattice and itself: a quarter of each tetrahedron to each of its corners.
    pub fn identity(lattice: &Lattice) -> Self {
        let quarters = |(tet, nodes): (usize, &[u32; 4])| nodes.map(|node| (node, tet as u32, 0.25));
        let mut entries: Vec<Entry> = lattice.tets.iter().enumerate().flat_map(quarters).collect();
        entries.sort_by_key(|&(node, tet, _)| (node, tet));
        Self::normalized(&entries, lattice.tets.len(), lattice.nodes.len())
    }

    /// Operator by which each node takes the energy density of one tetrahedron, or none. Not conservative.
    ///
    /// `sources`: the tetrahedron of each node, and the node's volume over that of the tetrahedron, which may exceed 1.
    pub(crate) fn of_densities(sources: impl Iterator<Item = Option<(u32, f64)>>) -> Self {
        let mut transfer = Self { offsets: vec![0], ..Self::default() };
        for source in sources {
            let (tet, share) = source.unzip();
            transfer.tets.extend(tet);
            transfer.shares.extend(share);
            transfer.offsets.push(transfer.tets.len() as u32);
        }
        transfer
    }

    /// Restricts the operator to a part of the body.
    ///
    /// `nodes` and `tets` hold the new index of each crack node and elastic tetrahedron, [`NO_INDEX`] outside
    /// the part. Several nodes may share a new index. The shares that a tetrahedron had given to nodes
    /// outside go to its remaining nodes.
    pub fn part(&self, nodes: &[u32], tets: &[u32]) -> Self {
        let mut entries: Vec<Entry> = Vec::new();
        for (row, &node) in self.offsets.windows(2).zip(nodes).filter(|(_, node)| **node != NO_INDEX) {
            let row = row[0] as usize..row[1] as usize;
            let own = self.tets[row.clone()].iter().map(|&tet| tets[tet as usize]).zip(&self.shares[row]);
            entries.extend(own.filter(|(tet, _)| *tet != NO_INDEX).map(|(tet, &share)| (node, tet, share)));
        }
        entries.sort_by_key(|&(node, tet, _)| (node, tet));
        entries.dedup_by(merged);
        let count =
            |names: &[u32]| names.iter().filter(|name| **name != NO_INDEX).max().map_or(0, |&last| last as usize + 1);
        Self::normalized(&entries, count(tets), count(nodes))
    }

    /// Builds the operator from sorted, unique entries.
    fn normalized(entries: &[Entry], tet_count: usize, node_count: usize) -> Self {
        let mut totals = vec![0.0; tet_count];
        let mut offsets = vec![0u32; node_count + 1];
        for &(node, tet, volume) in entries {
            totals[tet as usize] += volume;
            offsets[node as usize + 1] += 1;
        }
        for node in 0..node_count {
            offsets[node + 1] += offsets[node];
        }
        let share = |&(_, tet, volume): &Entry| (tet, volume / totals[tet as usize]);
        let (tets, shares) = entries.iter().map(share).unzip();
        Self { offsets, tets, shares }
    }

    /// Computes the energies of the crack nodes from those of the elastic tetrahedra.
    ///
    /// Both are integrals, not densities, in the same unit. Overwrites `node_energy` (length crack nodes). The sums
    /// agree to rounding.
    pub fn apply(&self, tet_energy: &[f64], node_energy: &mut Vec<f64>) {
        node_energy.resize(self.offsets.len() - 1, 0.0);
        node_energy.par_chunks_mut(ROWS).zip(self.offsets.par_chunks(ROWS)).enumerate().for_each(
            |(chunk, (energies, starts))| {
                let ends = &self.offsets[chunk * ROWS + 1..];
                for (energy, (start, end)) in energies.iter_mut().zip(starts.iter().zip(ends)) {
                    *energy = self.row(*start as usize..*end as usize, tet_energy);
                }
            },
        );
    }

    /// Energy of one node, summed in parallel lanes.
    fn row(&self, row: std::ops::Range<usize>, tet_energy: &[f64]) -> f64 {
        let (tets, tets_rest) = self.tets[row.clone()].as_chunks::<SIDE>();
        let (shares, shares_rest) = self.shares[row].as_chunks::<SIDE>();
        let mut lanes = [0.0; SIDE];
        for (tets, shares) in tets.iter().zip(shares) {
            for lane in 0..SIDE {
                lanes[lane] += shares[lane] * tet_energy[tets[lane] as usize];
            }
        }
        let rest = tets_rest.iter().zip(shares_rest).map(|(&tet, share)| share * tet_energy[tet as usize]).sum::<f64>();
        (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
    }
}

/// Elastic lattice, prepared for intersection queries.
struct Cover {
    cells: Vec<OverlapCell>,
    tree: AabbTree,
    locator: Locator,
}

impl Cover {
    fn new(elastic: &Lattice) -> Self {
        let corners = |tet: usize| elastic.corners(tet);
        let boxes: Vec<Aabb> = (0..elastic.tets.len()).map(|tet| Aabb::around(&corners(tet))).collect();
        let cells = (0..elastic.tets.len()).map(|tet| OverlapCell::new(&corners(tet))).collect();
        Self { cells, tree: AabbTree::new(&boxes), locator: Locator::new(elastic) }
    }

    /// Entries for the corners of crack tetrahedron `tet`.
    fn entries(&self, crack: &Lattice, tet: usize, overlap: &mut Overlap) -> Vec<Entry> {
        let (corners, volume) = (crack.corners(tet), crack.tet_volume(tet));
        let cell = OverlapCell::new(&corners);
        let (mut entries, mut covered) = (Vec::new(), 0.0);
        self.tree.overlapping(&Aabb::around(&corners), |other| {
            if let Some((common, centroid)) = overlap.of(&cell, &self.cells[other as usize]) {
                covered += common;
                let weights = cell.barycentric(&centroid).map(|weight| weight * common);
                entries.extend(positive(crack.tets[tet], other, weights));
            }
        });
        let uncovered = 1.0 - covered / volume;
        if uncovered > UNCOVERED {
            self.add_nearest(crack.tets[tet], &corners, uncovered * volume, &mut entries);
        }
        entries
    }

    /// Assigns `volume`, the uncovered part of a crack tetrahedron, to the nearest elastic tetrahedra.
    ///
    /// These are the nearest to those of its corners, face centroids and centroid that lie outside;
    /// if none does, to its centroid.
    fn add_nearest(&self, nodes: [u32; 4], corners: &[Point3<f64>; 4], volume: f64, entries: &mut Vec<Entry>) {
        const THIRD: f64 = 1.0 / 3.0;
        let mut samples = vec![[0.25; 4]];
        for corner in 0..4 {
            samples.push([0, 1, 2, 3].map(|k| if k == corner { 0.0 } else { THIRD }));
            samples.push([0, 1, 2, 3].map(|k| if k == corner { 1.0 } else { 0.0 }));
        }
        let place = |weights: &[f64; 4]| {
            Point3::from(
                corners.iter().zip(weights).map(|(corner, weight)| corner.coords * *weight).sum::<Vector3<f64>>(),
            )
        };
        let outside: Vec<[f64; 4]> = samples
            .iter()
            .copied()
            .filter(|weights| self.locator.containing(&place(weights), None).is_none())
            .collect();
        let outside = if outside.is_empty() { vec![samples[0]] } else { outside };
        let each = volume / outside.len() as f64;
        for weights in &outside {
            if let Some(nearest) = self.locator.locate(&place(weights), None) {
                entries.extend(positive(nodes, nearest.tet, weights.map(|weight| weight * each)));
            }
        }
    }
}

/// Entries of one pair of tetrahedra, without those that rounding left at 0 or below.
fn positive(nodes: [u32; 4], tet: u32, volumes: [f64; 4]) -> impl Iterator<Item = Entry> {
    let pairs = nodes.into_iter().zip(volumes);
    pairs.filter(|(_, volume)| *volume > 0.0).map(move |(node, volume)| (node, tet, volume))
}

/// Entries for elastic tetrahedra that no crack tetrahedron meets. They go to the crack
/// tetrahedron nearest to their centroid.
fn left_out(elastic: &Lattice, crack: &Lattice, entries: &[Entry]) -> Vec<Entry> {
    let mut missing = vec![true; elastic.tets.len()];
    entries.iter().for_each(|&(_, tet, _)| missing[tet as usize] = false);
    let missing: Vec<usize> = (0..missing.len()).filter(|&tet| missing[tet]).collect();
    if missing.is_empty() {
        return Vec::new();
    }
    let locator = Locator::new(crack);
    let shared = |tet: usize| {
        let centroid = elastic.corners(tet).iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0;
        let place = locator.locate(&Point3::from(centroid), None);
        place.into_iter().flat_map(move |place| positive(crack.tets[place.tet as usize], tet as u32, place.barycentric))
    };
    missing.into_iter().flat_map(shared).collect()
}

#[cfg(test)]
#[path = "energy_transfer_tests.rs"]
mod tests;
