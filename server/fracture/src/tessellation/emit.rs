//! Emission of the fragments into memory of the caller, each run into its own range.

use super::{RunRange, Tessellation, TessellationError};
use nalgebra::{Point3, Vector3};

/// Number of vertices below which one thread writes all runs.
const GRAIN: usize = 4096;

/// Transformation from local coordinates to those of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalToMeters {
    /// Meters per local unit: the object's bounding-box diagonal.
    pub meters_per_unit: f64,
}

impl LocalToMeters {
    /// `point` relative to `center`, both local, in meters.
    fn apply(&self, point: &Point3<f64>, center: &Point3<f64>) -> Vector3<f64> {
        (point - center) * self.meters_per_unit
    }
}

/// Coordinate frame in which meshes are written.
pub trait HostFrame: Sync {
    /// Converts an offset, m.
    fn offset(&self, meters: Vector3<f64>) -> [f32; 3];

    /// Converts a unit direction.
    fn direction(&self, ours: Vector3<f64>) -> [f32; 3];

    /// True if triangles are clockwise seen from outside.
    fn is_clockwise(&self) -> bool;
}

/// Meters along the axes of the mesh file, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeterFrame;

impl HostFrame for MeterFrame {
    fn offset(&self, meters: Vector3<f64>) -> [f32; 3] {
        [meters.x as f32, meters.y as f32, meters.z as f32]
    }

    fn direction(&self, ours: Vector3<f64>) -> [f32; 3] {
        self.offset(ours)
    }

    fn is_clockwise(&self) -> bool {
        false
    }
}

/// Inputs for writing the runs of a tessellation.
struct Writer<'a, H> {
    tessellation: &'a Tessellation,
    centers: &'a [Point3<f64>],
    transform: LocalToMeters,
    host: &'a H,
}

/// Ranges of the caller's memory that belong to some runs.
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
    /// Writes every fragment into the given slices.
    ///
    /// - Positions are relative to the fragment's entry of `centers` (local; the centers of mass), in meters.
    /// - Indices are relative to the fragment's first vertex, counter-clockwise seen from outside.
    /// - Merge pairs (from, to) are relative to the fragment's first vertex.
    ///
    /// The slices must have the lengths [`Self::vertex_count`], [`Self::index_count`] and [`Self::merge_count`];
    /// otherwise nothing is written. The bytes are the same for any number of threads.
    ///
    /// # Errors
    /// [`TessellationError`] for slices of other lengths.
    pub fn emit(
        &self,
        centers: &[Point3<f64>],
        transform: LocalToMeters,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), TessellationError> {
        self.emit_for(&MeterFrame, centers, transform, positions, indices, merges)
    }

    /// [`Self::emit`] in the coordinates and the winding of `host`.
    ///
    /// # Errors
    /// Those of [`Self::emit`].
    pub fn emit_for(
        &self,
        host: &impl HostFrame,
        centers: &[Point3<f64>],
        transform: LocalToMeters,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), TessellationError> {
        self.check_sizes(centers.len(), positions.len(), indices.len(), merges.len())?;
        let writer = Writer { tessellation: self, centers, transform, host };
        writer.runs(&self.runs, Sections { positions: &mut *positions, indices, merges });
        self.make_distinct(positions);
        Ok(())
    }

    fn check_sizes(
        &self,
        centers: usize,
        positions: usize,
        indices: usize,
        merges: usize,
    ) -> Result<(), TessellationError> {
        let needed = (self.fragments.len(), self.vertex_count(), self.index_count(), self.merge_count());
        if centers != needed.0 {
            return Err(TessellationError::Centers { needed: needed.0, given: centers });
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
}

impl<H: HostFrame> Writer<'_, H> {
    fn runs(&self, runs: &[RunRange], sections: Sections<'_>) {
        if runs.len() > 1 && sections.positions.len() > GRAIN {
            let (left, right) = runs.split_at(runs.len() / 2);
            let [first, middle] = [&left[0], &right[0]];
            let (left_sections, right_sections) = sections.split_at(
                middle.vertices.start - first.vertices.start,
                middle.triangles.start - first.triangles.start,
                middle.merges.start - first.merges.start,
            );
            rayon::join(|| self.runs(left, left_sections), || self.runs(right, right_sections));
            return;
        }
        let mut rest = sections;
        for run in runs {
            let (own, others) = rest.split_at(run.vertices.len(), run.triangles.len(), run.merges.len());
            self.run(run, own);
            rest = others;
        }
    }

    fn run(&self, run: &RunRange, sections: Sections<'_>) {
        let (tessellation, center) = (self.tessellation, &self.centers[run.fragment as usize]);
        for (out, vertex) in sections.positions.iter_mut().zip(tessellation.run_vertices(run)) {
            *out = self.host.offset(self.transform.apply(vertex, center));
        }
        let base = (run.vertices.start - tessellation.fragments[run.fragment as usize].vertices.start) as u32;
        let triangles = tessellation.run_triangles_wound(run, self.host.is_clockwise());
        for (out, triangle) in sections.indices.as_chunks_mut::<3>().0.iter_mut().zip(triangles) {
            *out = triangle.map(|rank| base + rank);
        }
        sections.merges.copy_from_slice(&tessellation.merges[run.merges.clone()]);
    }
}
