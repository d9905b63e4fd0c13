//! Independent check of emitted meshes: closed and oriented surfaces, as a reader sees them.

/// First defect that keeps a mesh from being closed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OpenMesh {
    /// The mesh has no triangles.
    #[error("no triangles")]
    Empty,
    /// The number of indices is not a multiple of three.
    #[error("{count} indices, not a multiple of three")]
    IndexCount {
        /// Number of indices.
        count: usize,
    },
    /// An index exceeds the number of vertices.
    #[error("index {at} is vertex {vertex}, out of range")]
    VertexOutOfRange {
        /// Position of the index.
        at: usize,
        /// Its value.
        vertex: u32,
    },
    /// A coordinate is not finite.
    #[error("vertex {vertex} is not finite")]
    NonFiniteVertex {
        /// Index of the vertex.
        vertex: usize,
    },
    /// Two corners of a triangle have the same position.
    #[error("triangle {triangle} has two corners at one position")]
    Degenerate {
        /// Index of the triangle.
        triangle: usize,
    },
    /// A half-edge appears more than once, or its opposite is missing.
    ///
    /// Vertices are named by the lowest index at their position.
    #[error("edge from vertex {from} to vertex {to}: {forward} half-edges that way, {backward} back")]
    Edge {
        /// Start vertex.
        from: u32,
        /// End vertex.
        to: u32,
        /// Number of half-edges from `from` to `to`.
        forward: usize,
        /// Number of half-edges from `to` to `from`.
        backward: usize,
    },
    /// The enclosed volume is not positive.
    #[error("volume {volume} is not positive")]
    Volume {
        /// Signed volume, cubed units of the positions.
        volume: f64,
    },
}

/// Checks that the triangles form a closed, oriented surface around a positive volume.
///
/// After welding vertices with bitwise equal positions, every edge must have exactly two half-edges of opposite
/// direction. The check uses positions and indices only, no merge pairs.
///
/// # Errors
/// [`OpenMesh`]: the first defect.
pub fn closed(positions: &[[f32; 3]], indices: &[u32]) -> Result<(), OpenMesh> {
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(OpenMesh::IndexCount { count: indices.len() });
    }
    if triangles.is_empty() {
        return Err(OpenMesh::Empty);
    }
    if let Some((at, &vertex)) = indices.iter().enumerate().find(|(_, vertex)| **vertex as usize >= positions.len()) {
        return Err(OpenMesh::VertexOutOfRange { at, vertex });
    }
    if let Some(vertex) = positions.iter().position(|position| !position.iter().all(|x| x.is_finite())) {
        return Err(OpenMesh::NonFiniteVertex { vertex });
    }
    let welded = weld(positions);
    paired(triangles.iter().map(|triangle| triangle.map(|vertex| welded[vertex as usize])))?;
    let volume = volume(positions, triangles);
    if volume > 0.0 { Ok(()) } else { Err(OpenMesh::Volume { volume }) }
}

/// The lowest vertex at each vertex's position.
fn weld(positions: &[[f32; 3]]) -> Vec<u32> {
    let key = |vertex: u32| positions[vertex as usize].map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
    let mut welded = vec![0; positions.len()];
    for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
        same.iter().for_each(|&vertex| welded[vertex as usize] = same[0]);
    }
    welded
}

/// Checks that every half-edge appears once and has its opposite.
fn paired(triangles: impl Iterator<Item = [u32; 3]>) -> Result<(), OpenMesh> {
    let mut half_edges = Vec::new();
    for (triangle, [a, b, c]) in triangles.enumerate() {
        if a == b || b == c || c == a {
            return Err(OpenMesh::Degenerate { triangle });
        }
        half_edges.extend([(a, b), (b, c), (c, a)]);
    }
    half_edges.sort_unstable();
    let count = |edge: (u32, u32)| {
        half_edges.partition_point(|&other| other <= edge) - half_edges.partition_point(|&other| other < edge)
    };
    for &(from, to) in &half_edges {
        let (forward, backward) = (count((from, to)), count((to, from)));
        if (forward, backward) != (1, 1) {
            return Err(OpenMesh::Edge { from, to, forward, backward });
        }
    }
    Ok(())
}

/// Signed volume, summed in f64 from the f32 positions, relative to the first vertex.
fn volume(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let base = positions[0].map(f64::from);
    let corner = |vertex: u32| {
        let place = positions[vertex as usize].map(f64::from);
        [place[0] - base[0], place[1] - base[1], place[2] - base[2]]
    };
    let cone = |&triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(corner);
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    triangles.iter().map(cone).sum::<f64>() / 6.0
}
