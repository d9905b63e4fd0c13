//! The meshes of all fragments in memory of their own, for callers that bring none.

use super::meshes::FractureMeshes;
use super::rows::FragmentRow;
use crate::pipeline::error::FractureError;

/// Triangle meshes of all fragments.
#[derive(Clone, Debug)]
pub struct EmittedMeshes<'a> {
    rows: &'a [FragmentRow],
    /// Vertices of all fragments, each relative to its fragment's center of mass, m.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex numbers per triangle, counter-clockwise seen from outside, relative to the fragment's first vertex.
    pub indices: Vec<u32>,
    /// Pairs of vertices that are one point of the closed surface, relative to the fragment's first vertex.
    pub merges: Vec<[u32; 2]>,
}

/// The closed triangle mesh of one fragment.
#[derive(Clone, Copy, Debug)]
pub struct FragmentMesh<'a> {
    /// Its mass, center, inertia and place in the tables.
    pub row: &'a FragmentRow,
    /// Vertices relative to [`FragmentRow::center_m`], m. Each run has its own.
    pub positions: &'a [[f32; 3]],
    /// Three numbers of [`Self::positions`] per triangle, counter-clockwise seen from outside.
    pub indices: &'a [u32],
    /// Pairs of [`Self::positions`] that are one point of the closed surface.
    pub merges: &'a [[u32; 2]],
}

impl EmittedMeshes<'_> {
    /// The fragments in the order of their ids.
    pub fn fragments(&self) -> impl ExactSizeIterator<Item = FragmentMesh<'_>> {
        self.rows.iter().map(|row| FragmentMesh {
            row,
            positions: &self.positions[row.vertex_first as usize..][..row.vertex_count as usize],
            indices: &self.indices[row.index_first as usize..][..row.index_count as usize],
            merges: &self.merges[row.merge_first as usize..][..row.merge_count as usize],
        })
    }
}

impl FractureMeshes {
    /// Allocates memory for all meshes and writes them. Callers with memory of their own call [`Self::emit`].
    ///
    /// # Errors
    /// Those of [`Self::emit`].
    pub fn emitted(&self) -> Result<EmittedMeshes<'_>, FractureError> {
        let mut positions = vec![[0.0; 3]; self.counts.vertices];
        let mut indices = vec![0; self.counts.indices];
        let mut merges = vec![[0; 2]; self.counts.merges];
        self.emit(&mut positions, &mut indices, &mut merges)?;
        Ok(EmittedMeshes { rows: &self.fragments, positions, indices, merges })
    }
}
