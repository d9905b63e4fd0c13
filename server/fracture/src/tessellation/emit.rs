//! Emit: the answer into memory that the caller owns, each run into its own part of it.

use super::{Run, Tessellation, TessellationError};
use nalgebra::Point3;

/// Runs with fewer vertices than this together are written by one thread.
const GRAIN: usize = 4096;

/// From local coordinates to the answer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Metres per local unit: the object's bounding-box diagonal.
    pub metres_per_unit: f64,
}

impl Transform {
    /// `point` relative to `centre`, both local, in metres.
    fn apply(&self, point: &Point3<f64>, centre: &Point3<f64>) -> [f32; 3] {
        let offset = (point - centre) * self.metres_per_unit;
        [offset.x as f32, offset.y as f32, offset.z as f32]
    }
}

/// The parts of the caller's memory that belong to some runs.
struct Sections<'a> {
    positions: &'a mut [[f32; 3]],
    indices: &'a mut [u32],
    merges: &'a mut [[u32; 2]],
}

impl<'a> Sections<'a> {
    fn split_at(self, vertices: usize, triangles: usize, merges: usize) -> (Self, Self) {
        let (left_positions, positions) = self.positions.split_at_mut(vertices);
        let (left_indices, indices) = self.indices.split_at_mut(3 * triangles);
        let (left_merges, merges) = self.merges.split_at_mut(merges);
        let left = Self { positions: left_positions, indices: left_indices, merges: left_merges };
        (left, Self { positions, indices, merges })
    }
}

impl Tessellation {
    /// Writes every fragment: positions relative to its entry of `centres` (local; the centres of mass), in metres;
    /// indices relative to its first vertex, counter-clockwise seen from outside; merge pairs (from, to) relative to
    /// its first vertex. Slices have exactly the lengths [`Self::vertex_count`], [`Self::index_count`] and
    /// [`Self::merge_count`]; otherwise nothing is written. Same bytes for any number of threads.
    pub fn emit(
        &self,
        centres: &[Point3<f64>],
        transform: Transform,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), TessellationError> {
        self.check_sizes(centres.len(), positions.len(), indices.len(), merges.len())?;
        self.emit_runs(&self.runs, centres, transform, Sections { positions, indices, merges });
        Ok(())
    }

    fn check_sizes(
        &self,
        centres: usize,
        positions: usize,
        indices: usize,
        merges: usize,
    ) -> Result<(), TessellationError> {
        let needed = (self.fragments.len(), self.vertex_count(), self.index_count(), self.merge_count());
        if centres != needed.0 {
            return Err(TessellationError::Centres { needed: needed.0, given: centres });
        }
        if positions != needed.1 {
            return Err(TessellationError::Positions { needed: needed.1, given: positions });
        }
        if indices != needed.2 {
            return Err(TessellationError::Indices { needed: needed.2, given: indices });
        }
        if merges != needed.3 {
            return Err(TessellationError::Merges { needed: needed.3, given: merges });
        }
        Ok(())
    }

    fn emit_runs(&self, runs: &[Run], centres: &[Point3<f64>], transform: Transform, sections: Sections<'_>) {
        if runs.len() > 1 && sections.positions.len() > GRAIN {
            let (left, right) = runs.split_at(runs.len() / 2);
            let [first, middle] = [&left[0], &right[0]];
            let (left_sections, right_sections) = sections.split_at(
                middle.vertices.start - first.vertices.start,
                middle.triangles.start - first.triangles.start,
                middle.merges.start - first.merges.start,
            );
            rayon::join(
                || self.emit_runs(left, centres, transform, left_sections),
                || self.emit_runs(right, centres, transform, right_sections),
            );
            return;
        }
        let mut rest = sections;
        for run in runs {
            let (own, others) = rest.split_at(run.vertices.len(), run.triangles.len(), run.merges.len());
            self.emit_run(run, &centres[run.fragment as usize], transform, own);
            rest = others;
        }
    }

    fn emit_run(&self, run: &Run, centre: &Point3<f64>, transform: Transform, sections: Sections<'_>) {
        for (out, vertex) in sections.positions.iter_mut().zip(self.run_vertices(run)) {
            *out = transform.apply(vertex, centre);
        }
        let base = (run.vertices.start - self.fragments[run.fragment as usize].vertices.start) as u32;
        for (out, triangle) in sections.indices.as_chunks_mut::<3>().0.iter_mut().zip(self.run_triangles(run)) {
            *out = triangle.map(|rank| base + rank);
        }
        sections.merges.copy_from_slice(&self.merges[run.merges.clone()]);
    }
}
