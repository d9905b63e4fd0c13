//! Sheets: the crack between two fragments, stored once for both, and the outer surface of each fragment.
//!
//! Sheets 0 .. fragments are the outer ones, by fragment. The cracks follow, by (lower, upper) fragment.

use super::cut::NONE;
use super::points::CrackPoints;
use super::topology::Topology;
use std::ops::Range;

/// Pairs of adjacent fragments, and the sheet of every cut edge.
#[derive(Debug, Default)]
pub(super) struct CrackSheetIndex {
    /// Lower and upper fragment of each crack; crack k is sheet `fragments + k`.
    pub pairs: Vec<[u32; 2]>,
    /// Sheet of each cut edge.
    pub of_edge: Vec<u32>,
    /// Sheets of the three edges of each cut face, in the order of `Topology::face_edges`.
    pub of_face: Vec<[u32; 3]>,
    /// Cut edges grouped by lower fragment.
    grouped: Vec<u32>,
    offsets: Vec<u32>,
    /// Latest crack with each fragment on its upper side.
    last: Vec<u32>,
    uppers: Vec<u32>,
}

impl CrackSheetIndex {
    /// Fills all fields for the crack points of `points`.
    pub fn find(&mut self, topology: &Topology, fragments: usize, points: &CrackPoints) {
        let sides = |slot: u32| {
            let [a, b] = points.sides[slot as usize];
            [a.min(b), a.max(b)]
        };
        let count = points.edges.simplices.len() as u32;
        self.group(count, fragments, |slot| sides(slot)[0]);
        self.pairs.clear();
        self.last.clear();
        self.last.resize(fragments, NONE);
        self.of_edge.clear();
        self.of_edge.resize(count as usize, 0);
        for lower in 0..fragments {
            let slots = self.offsets[lower] as usize..self.offsets[lower + 1] as usize;
            self.name_pairs(lower as u32, slots.clone(), |slot| sides(slot)[1]);
            for &slot in &self.grouped[slots] {
                self.of_edge[slot as usize] = fragments as u32 + self.last[sides(slot)[1] as usize];
            }
        }
        self.of_face.clear();
        self.of_face.extend(points.faces.simplices.iter().map(|&face| {
            let edges = topology.face_edges[face as usize];
            edges.map(|edge| self.of_edge[points.edges.slots[edge as usize] as usize])
        }));
    }

    /// Appends the pairs of `lower`, whose cut edges are `grouped[slots]`, in ascending order, and records them in
    /// `last`.
    fn name_pairs(&mut self, lower: u32, slots: Range<usize>, upper: impl Fn(u32) -> u32) {
        let first = self.pairs.len() as u32;
        self.uppers.clear();
        for &slot in &self.grouped[slots] {
            let last = &mut self.last[upper(slot) as usize];
            if *last == NONE || *last < first {
                *last = first; // met; its own number follows
                self.uppers.push(upper(slot));
            }
        }
        self.uppers.sort_unstable();
        for &upper in &self.uppers {
            self.last[upper as usize] = self.pairs.len() as u32;
            self.pairs.push([lower, upper]);
        }
    }

    /// Sorts the cut edges by lower fragment (counting sort).
    fn group(&mut self, count: u32, fragments: usize, lower: impl Fn(u32) -> u32) {
        self.offsets.clear();
        self.offsets.resize(fragments + 2, 0);
        (0..count).for_each(|slot| self.offsets[lower(slot) as usize + 2] += 1);
        (0..fragments).for_each(|fragment| self.offsets[fragment + 2] += self.offsets[fragment + 1]);
        self.grouped.clear();
        self.grouped.resize(count as usize, 0);
        for slot in 0..count {
            let next = &mut self.offsets[lower(slot) as usize + 1];
            self.grouped[*next as usize] = slot;
            *next += 1;
        }
    }
}
