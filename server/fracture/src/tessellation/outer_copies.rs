//! Copies of outer vertices on seams of attributes, where a vertex has one set of attributes for each side.

use super::Tessellation;

/// Copies of vertices of one fragment's outer run, and the triangles that use them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OuterCopies {
    /// Vertex of the run that each copy repeats. Copies have the numbers after the run's own vertices.
    pub vertices: Vec<u32>,
    /// Triangles and corners that take a copy, with its number.
    pub corners: Vec<(u32, u8, u32)>,
}

impl Tessellation {
    /// Adds copies to the outer runs, by fragment. Each is joined to its vertex by a merge pair, so that every fragment
    /// stays closed.
    pub fn copy_outer(&mut self, copies: &[OuterCopies]) {
        if copies.iter().all(|own| own.vertices.is_empty()) {
            return;
        }
        self.copy_vertices(copies);
        self.copy_merges(copies);
        let mut added = 0;
        for (range, copies) in self.fragments.iter_mut().zip(copies) {
            let start = range.vertices.start + added;
            for run in &mut self.runs[range.runs.clone()] {
                let own = if run.crack { 0 } else { copies.vertices.len() };
                run.vertices = run.vertices.start + added..run.vertices.end + added + own;
                added += own;
            }
            range.vertices = start..range.vertices.end + added;
        }
    }

    /// Inserts the copies into the outer sheets, and writes them into the triangles. The sheet of a fragment's outer run
    /// has the fragment's number.
    fn copy_vertices(&mut self, copies: &[OuterCopies]) {
        let mut vertices =
            Vec::with_capacity(self.vertices.len() + copies.iter().map(|own| own.vertices.len()).sum::<usize>());
        let (mut offsets, mut close) = (vec![0], Vec::new());
        for (sheet, range) in self.vertex_offsets.windows(2).enumerate() {
            let own = &self.vertices[range[0]..range[1]];
            let is_close = |vertex: u32| self.close_vertices.binary_search(&(range[0] as u32 + vertex)).is_ok();
            close.extend(
                (0..own.len() as u32).filter(|vertex| is_close(*vertex)).map(|vertex| vertices.len() as u32 + vertex),
            );
            vertices.extend_from_slice(own);
            if let Some(copies) = copies.get(sheet) {
                let close_copies = (0..).zip(&copies.vertices).filter(|(_, vertex)| is_close(**vertex));
                close.extend(close_copies.map(|(copy, _): (u32, _)| vertices.len() as u32 + copy));
                vertices.extend(copies.vertices.iter().map(|&vertex| own[vertex as usize]));
                let first = self.triangle_offsets[sheet];
                for &(triangle, corner, copy) in &copies.corners {
                    self.triangles[first + triangle as usize][corner as usize] = copy;
                }
            }
            offsets.push(vertices.len());
        }
        (self.vertices, self.vertex_offsets, self.close_vertices) = (vertices, offsets, close);
    }

    /// Adds a merge pair for each copy before those of the fragment, and moves the vertices of its later runs.
    fn copy_merges(&mut self, copies: &[OuterCopies]) {
        let mut merges =
            Vec::with_capacity(self.merges.len() + copies.iter().map(|own| own.vertices.len()).sum::<usize>());
        let mut added = 0;
        for (fragment, range) in self.fragments.iter_mut().enumerate() {
            let copies = &copies[fragment].vertices;
            let runs = &mut self.runs[range.runs.clone()];
            let outer = runs.first().filter(|run| !run.crack).map_or(0, |run| run.vertices.len()) as u32;
            let moved = |vertex: u32| if vertex < outer { vertex } else { vertex + copies.len() as u32 };
            let start = range.merges.start + added;
            merges.extend(copies.iter().enumerate().map(|(copy, &vertex)| [outer + copy as u32, vertex]));
            merges.extend(self.merges[range.merges.clone()].iter().map(|pair| pair.map(moved)));
            for run in runs {
                let own = if run.crack { 0 } else { copies.len() };
                run.merges = run.merges.start + added..run.merges.end + added + own;
                added += own;
            }
            range.merges = start..range.merges.end + added;
        }
        self.merges = merges;
    }
}
