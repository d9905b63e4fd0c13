//! Layout of fragments, runs and merges in the result, by prefix sums.

use super::Tessellation;
use super::rank::{Input, MergePair, RunVertex};
use std::ops::Range;

/// Ranges of one fragment in the sections of the result.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FragmentRange {
    /// Runs of the fragment.
    pub runs: Range<usize>,
    /// Vertices of the fragment; index values are relative to the first.
    pub vertices: Range<usize>,
    /// Triangles of the fragment; its range of indices is three times this one.
    pub triangles: Range<usize>,
    /// Merge pairs of the fragment.
    pub merges: Range<usize>,
}

/// Triangles of one fragment that face one neighbor, or the outside.
///
/// Vertices, triangles and merges of a fragment's runs are consecutive without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunRange {
    /// Fragment of the run.
    pub fragment: u32,
    /// Fragment on the other side; `None`: the outside, or a removed fragment ([`Tessellation::keep_first`]).
    pub neighbor: Option<u32>,
    /// True on a crack, false on the lattice's own boundary.
    pub crack: bool,
    /// Vertices in the result.
    pub vertices: Range<usize>,
    /// Triangles in the result.
    pub triangles: Range<usize>,
    /// Merge pairs whose first entry is a vertex of the run.
    pub merges: Range<usize>,
    /// Sheet that stores the geometry.
    pub(super) sheet: usize,
    /// True if the sheet stores the triangles in the opposite orientation.
    pub(super) flipped: bool,
}

impl Tessellation {
    /// Fills `fragments` and `runs` from the counts; `slots` is scratch memory.
    pub(super) fn lay_out_runs(
        &mut self,
        input: Input<'_>,
        vertices: &[u32],
        merges: &[[u32; 2]],
        slots: &mut Vec<usize>,
    ) {
        let (fragments, pairs) = (input.fragments, &input.sheets.pairs);
        let has_outer = |fragment: usize| usize::from(vertices[fragment] > 0);
        slots.clear();
        slots.resize(fragments + 1, 0);
        pairs.iter().flatten().for_each(|&fragment| slots[fragment as usize + 1] += 1);
        (0..fragments).for_each(|fragment| slots[fragment + 1] += slots[fragment] + has_outer(fragment));
        self.runs.clear();
        self.runs.resize(slots[fragments], EMPTY);
        self.fragments.clear();
        self.fragments
            .extend((0..fragments).map(|k| FragmentRange { runs: slots[k]..slots[k + 1], ..Default::default() }));
        let mut put = |fragment: u32, neighbor: Option<u32>, sheet: usize, merges: u32| {
            let slot = &mut slots[fragment as usize];
            let flipped = neighbor.is_some_and(|neighbor| neighbor < fragment);
            let merges = 0..merges as usize;
            let crack = neighbor.is_some();
            self.runs[*slot] = RunRange { fragment, neighbor, crack, sheet, flipped, merges, ..EMPTY };
            *slot += 1;
        };
        (0..fragments).filter(|&k| has_outer(k) > 0).for_each(|k| put(k as u32, None, k, 0));
        // Pairs ascend by (lower, upper), so every fragment gets its lower neighbors in ascending order, then its upper
        // ones.
        for (crack, (&[lower, upper], merges)) in pairs.iter().zip(merges).enumerate() {
            put(lower, Some(upper), fragments + crack, merges[0]);
            put(upper, Some(lower), fragments + crack, merges[1]);
        }
        self.lay_out_ranges();
    }

    /// Turns the lengths of all runs into consecutive ranges.
    fn lay_out_ranges(&mut self) {
        let (mut vertices, mut triangles, mut merges) = (0, 0, 0);
        let append = |end: &mut usize, length: usize| {
            let start = *end;
            *end += length;
            start..*end
        };
        for fragment in &mut self.fragments {
            let start = (vertices, triangles, merges);
            for run in &mut self.runs[fragment.runs.clone()] {
                let length = |offsets: &[usize]| offsets[run.sheet + 1] - offsets[run.sheet];
                run.vertices = append(&mut vertices, length(&self.vertex_offsets));
                run.triangles = append(&mut triangles, length(&self.triangle_offsets));
                run.merges = append(&mut merges, run.merges.len());
            }
            fragment.vertices = start.0..vertices;
            fragment.triangles = start.1..triangles;
            fragment.merges = start.2..merges;
        }
    }
}

/// Fragments and runs whose merges are not written yet.
pub(super) struct Laid<'a> {
    pub fragments: &'a [FragmentRange],
    pub runs: &'a [RunRange],
}

impl Laid<'_> {
    /// Writes the merge pairs of `listed`; `cursors` is scratch memory.
    pub fn write_merges(
        &self,
        input: Input<'_>,
        listed: &[MergePair],
        cursors: &mut Vec<usize>,
        merges: &mut Vec<[u32; 2]>,
    ) {
        // Two entries for each crack and side: first vertex of the run within its fragment, and index of its next
        // merge.
        cursors.clear();
        cursors.resize(4 * input.sheets.pairs.len(), 0);
        for run in self.runs.iter().filter(|run| run.neighbor.is_some()) {
            let place = 4 * (run.sheet - input.fragments) + 2 * usize::from(run.flipped);
            cursors[place] = run.vertices.start - self.fragments[run.fragment as usize].vertices.start;
            cursors[place + 1] = run.merges.start;
        }
        merges.clear();
        merges.resize(listed.len(), [0; 2]);
        for merge in listed {
            let cursor = |place: RunVertex| 4 * (place.sheet as usize - input.fragments) + 2 * place.side;
            let outer = (merge.to.sheet as usize) < input.fragments; // the fragment's first run
            let to = if outer { 0 } else { cursors[cursor(merge.to)] };
            let from = cursor(merge.from);
            merges[cursors[from + 1]] = [cursors[from] as u32 + merge.from.rank, to as u32 + merge.to.rank];
            cursors[from + 1] += 1;
        }
    }
}

const EMPTY: RunRange = RunRange {
    fragment: 0,
    neighbor: None,
    crack: false,
    vertices: 0..0,
    triangles: 0..0,
    merges: 0..0,
    sheet: 0,
    flipped: false,
};
