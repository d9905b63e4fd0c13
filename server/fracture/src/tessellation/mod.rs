//! Tessellation: closed fragment meshes from labels on a lattice.
//!
//! [`Topology`] is prepared once per body. [`components`] divides cells into connected fragments, and [`crack_points`]
//! computes the points at which their boundaries cross the lattice. [`tessellate`] counts vertices and triangles and
//! connects them. [`Tessellation::emit`] writes the result into the caller's memory. Every step has a variant that
//! reuses the memory of earlier calls.
//!
//! Guarantee: for any labels and lift, every fragment is a closed, oriented 2-manifold of positive volume, provided
//! that the lattice's own boundary is a 2-manifold.
//!
//! - The connectivity depends only on the labels.
//! - No two crack points coincide, because each stays inside its simplex by a margin. Positions that single precision
//!   would make equal are separated when they are written.
//! - Quadrilaterals are split so that, in each tetrahedron, the volume of each label is positive for any positions of
//!   its crack points.
//! - Each crack polygon is computed once for both of its fragments, so the fragments' volumes add up to the
//!   lattice's.
//!
//! The guarantee does not cover positions that the caller supplies as fixed points.

mod barycentric;
mod components;
mod cut;
mod distinct;
mod emit;
mod error;
mod flat_quads;
mod flat_simplices;
mod fragment_faces;
mod index_selection;
mod outer;
mod outer_copies;
mod pattern;
mod points;
mod polygon;
mod rank;
mod runs;
mod seam;
mod sheet;
mod span;
mod topology;

#[cfg(test)]
mod tests;

pub use barycentric::{MARGIN, edge_margin, preference, relative_height};
pub use components::{Components, components};
pub use emit::{HostFrame, LocalToMeters, MeterFrame};
pub use error::TessellationError;
pub use fragment_faces::fragment_faces;
pub use outer::{OuterVertex, outer_sources, outer_vertices};
pub use outer_copies::OuterCopies;
pub use points::{BisectorSites, CrackPoints, FixedPoints, crack_points};
use runs::Laid;
pub use runs::{FragmentRange, RunRange};
pub use seam::{EarlierCracks, seam, seam_among};
pub use topology::{FACE_EDGES, OuterFace, Topology};

use crate::lattice::Lattice;
use nalgebra::Point3;
use polygon::CrackPolygons;
use rank::{Input, MergePair, Ranks};
use sheet::CrackSheetIndex;

/// Scratch memory of [`Tessellation::build`], without meaning between calls.
#[derive(Debug, Default)]
pub struct TessellationWorkspace {
    sheets: CrackSheetIndex,
    ranks: Ranks,
    polygons: CrackPolygons,
    listed: Vec<MergePair>,
    /// Number of merges of each crack's two runs.
    counts: Vec<[u32; 2]>,
    cursors: Vec<usize>,
}

/// Surfaces of the fragments in local coordinates, ready to be measured and emitted.
///
/// Vertices belong to runs. A point on the rim of two runs appears in both, and a merge pair maps the later vertex to
/// the earlier. A crack is stored once for its two runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    fragments: Vec<FragmentRange>,
    runs: Vec<RunRange>,
    merges: Vec<[u32; 2]>,
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    vertex_offsets: Vec<usize>,
    triangle_offsets: Vec<usize>,
    /// Vertices that can have the position of another point in single precision, ascending.
    close_vertices: Vec<u32>,
}

impl Tessellation {
    /// Tessellates `labels` (one per node, below the number of nodes) with the crack points computed for the same
    /// labels.
    ///
    /// A label without nodes yields a fragment without runs. Reuses the memory of earlier calls.
    ///
    /// # Errors
    /// [`TessellationError`] for labels or crack points that do not fit the lattice.
    pub fn build(
        &mut self,
        lattice: &Lattice,
        topology: &Topology,
        labels: &[u32],
        points: &CrackPoints,
        workspace: &mut TessellationWorkspace,
    ) -> Result<(), TessellationError> {
        let fragments = topology.fragment_count(labels)?;
        points.fit(topology, labels).then_some(()).ok_or(TessellationError::Points)?;
        let TessellationWorkspace { sheets, ranks, polygons, listed, counts, cursors } = workspace;
        sheets.find(topology, fragments, points);
        let input = Input { lattice, topology, labels, fragments, points, sheets };
        ranks.count(input);
        prefix_sums(&ranks.vertices, &mut self.vertex_offsets);
        self.vertices.resize(total(&self.vertex_offsets), Point3::origin());
        let (vertex_offsets, vertices, close) = (&self.vertex_offsets, &mut self.vertices, &mut self.close_vertices);
        // The two tasks are independent.
        rayon::join(
            || polygons.find(input, ranks),
            || {
                ranks.write_vertices(input, vertex_offsets, vertices);
                ranks.list_close_vertices(input, vertex_offsets, close);
                ranks.list_merges(input, listed, counts);
            },
        );
        prefix_sums(&polygons.triangles, &mut self.triangle_offsets);
        self.triangles.resize(total(&self.triangle_offsets), [0; 3]);
        self.lay_out_runs(input, &ranks.vertices, counts, cursors);
        let Self { runs, fragments: rows, merges, triangles, .. } = self;
        let laid = Laid { fragments: rows, runs };
        rayon::join(|| polygons.write(triangles), || laid.write_merges(input, listed, cursors, merges));
        Ok(())
    }

    /// Removes all but the first `count` fragments. Runs that they share with removed ones remain cracks, without a
    /// neighbor.
    pub fn keep_first(&mut self, count: usize) {
        self.fragments.truncate(count);
        let last = self.fragments.last();
        let (runs, merges) = last.map_or((0, 0), |last| (last.runs.end, last.merges.end));
        self.runs.truncate(runs);
        self.merges.truncate(merges);
        for run in &mut self.runs {
            run.neighbor = run.neighbor.filter(|neighbor| (*neighbor as usize) < count);
        }
    }

    /// All fragments, by label.
    pub fn fragments(&self) -> &[FragmentRange] {
        &self.fragments
    }

    /// All runs by fragment, each fragment's outer run first, then by ascending neighbor.
    pub fn runs(&self) -> &[RunRange] {
        &self.runs
    }

    /// Length of the positions that [`Self::emit`] writes.
    pub fn vertex_count(&self) -> usize {
        self.fragments.last().map_or(0, |last| last.vertices.end)
    }

    /// Length of the indices that [`Self::emit`] writes, three per triangle.
    pub fn index_count(&self) -> usize {
        3 * self.fragments.last().map_or(0, |last| last.triangles.end)
    }

    /// Length of the merge pairs that [`Self::emit`] writes.
    pub fn merge_count(&self) -> usize {
        self.merges.len()
    }

    /// The vertices of `run`, local.
    pub fn run_vertices(&self, run: &RunRange) -> &[Point3<f64>] {
        &self.vertices[self.vertex_offsets[run.sheet]..self.vertex_offsets[run.sheet + 1]]
    }

    /// Calls `work` with each run and its part of `out`, one element per emitted vertex, in parallel.
    pub fn each_run<T: Send>(&self, out: &mut [T], work: impl Fn(&RunRange, &mut [T]) + Sync) {
        let starts = self.runs.iter().map(|run| run.vertices.start);
        let offsets: Vec<usize> = starts.chain([self.vertex_count()]).collect();
        span::each_span(&offsets, out, &|run, out| work(&self.runs[run], out));
    }

    /// The triangles of `run` as indices into its vertices, counter-clockwise seen from outside its fragment.
    pub fn run_triangles(&self, run: &RunRange) -> impl Iterator<Item = [u32; 3]> {
        self.run_triangles_wound(run, false)
    }

    /// [`Self::run_triangles`], or the same triangles clockwise.
    fn run_triangles_wound(&self, run: &RunRange, clockwise: bool) -> impl Iterator<Item = [u32; 3]> {
        let stored = &self.triangles[self.triangle_offsets[run.sheet]..self.triangle_offsets[run.sheet + 1]];
        let flipped = run.flipped != clockwise;
        stored.iter().map(move |&[a, b, c]| if flipped { [a, c, b] } else { [a, b, c] })
    }
}

/// [`Tessellation::build`] into new memory.
///
/// # Errors
/// Those of [`Tessellation::build`].
pub fn tessellate(
    lattice: &Lattice,
    topology: &Topology,
    labels: &[u32],
    points: &CrackPoints,
) -> Result<Tessellation, TessellationError> {
    let mut tessellation = Tessellation::default();
    tessellation.build(lattice, topology, labels, points, &mut TessellationWorkspace::default())?;
    Ok(tessellation)
}

/// The offset of each of `counts`, and the total at the end.
fn prefix_sums(counts: &[u32], offsets: &mut Vec<usize>) {
    offsets.clear();
    offsets.push(0);
    let mut sum = 0;
    offsets.extend(counts.iter().map(|&count| {
        sum += count as usize;
        sum
    }));
}

fn total(offsets: &[usize]) -> usize {
    offsets.last().copied().unwrap_or(0)
}
