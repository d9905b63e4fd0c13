//! Why a mesh was refused.

use std::path::PathBuf;

fn vertex_at(vertex: u64, at_m: &[f64; 3]) -> String {
    let is_long = |x: &f64| *x != 0.0 && !(1e-6..1e12).contains(&x.abs());
    let [x, y, z] = at_m.map(|x| if is_long(&x) { format!("{x:e}") } else { x.to_string() });
    format!("vertex {vertex} at ({x}, {y}, {z})")
}

fn vertices_at(vertices: &[(u64, [f64; 3])]) -> String {
    vertices.iter().map(|(vertex, at_m)| vertex_at(*vertex, at_m)).collect::<Vec<_>>().join(", ")
}

/// A mesh that cannot be used; every variant names the place.
#[derive(Debug, thiserror::Error)]
pub enum SurfaceError {
    /// The file, or one that it refers to, cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file name ends in none of the known extensions.
    #[error("{path}: unknown mesh format '{extension}': one of obj, ply, stl, gltf, glb", path = .path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The extension, empty if there is none.
        extension: String,
    },
    /// The file does not follow its format.
    #[error("malformed {format}, {place}: {reason}")]
    Malformed {
        /// The format's name.
        format: &'static str,
        /// Where: a line, a byte, an element.
        place: String,
        /// What is wrong there.
        reason: String,
    },
    /// More vertices or triangles than are worked on.
    #[error("too many vertices or triangles: at most {limit} of each")]
    TooLarge {
        /// How many are.
        limit: u64,
    },
    /// No vertex or no triangle.
    #[error("no {missing} were found; {expected}")]
    Empty {
        /// Which of both.
        missing: &'static str,
        /// What a file of this format has.
        expected: &'static str,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is not finite")]
    NonFiniteVertex {
        /// The vertex of the file, counted from 0.
        vertex: u64,
    },
    /// A coordinate so large that volumes and masses are no finite numbers.
    #[error("{} is out of range: coordinates must lie within ±{limit_m:e} m. Check --unit", vertex_at(*.vertex, .at_m))]
    VertexOutOfRange {
        /// The vertex of the file, counted from 0.
        vertex: u64,
        /// Where it is, m.
        at_m: [f64; 3],
        /// The largest magnitude of a coordinate, m.
        limit_m: f64,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index}, but there are {vertices}")]
    VertexOutOfBounds {
        /// The face of the file, counted from 0.
        face: u64,
        /// The index, counted from 0; negative where the file counts backwards past its beginning.
        index: i64,
        /// How many vertices there are.
        vertices: u64,
    },
    /// A vertex of a crack so far from the object that distances to it would lose their digits.
    #[error("vertex {vertex} is more than a million diagonals from the object")]
    FarVertex {
        /// The vertex of the file, counted from 0.
        vertex: u64,
    },
    /// Every triangle has zero area.
    #[error("every triangle is degenerate")]
    AllDegenerate,
    /// All vertices lie in one point.
    #[error("the bounding box is a point")]
    ZeroExtent,
    /// The bounding box is so small or large that its fragments, whose vertices are single-precision meters, would lose their
    /// shape.
    #[error("a bounding box of {diagonal_m} m is out of range: 1e-30 to 1e36")]
    ExtentOutOfRange {
        /// Its diagonal, meters.
        diagonal_m: f64,
    },
    /// The winding number exceeds ½ nowhere: a flat sheet, or shells that cancel.
    #[error("the surface encloses nothing: it is open, or its shells cancel each other")]
    NothingInside,
    /// All vertices lie in a plane, or almost.
    #[error(
        "the mesh is flat and encloses nothing: its extents are {:.3e} × {:.3e} × {:.3e} m; give it a thickness",
        .extents_m[0], .extents_m[1], .extents_m[2]
    )]
    Flat {
        /// Its extents along its principal axes, the largest first, m.
        extents_m: [f64; 3],
    },
    /// A few vertices so far from the others that these are a dot.
    #[error(
        "far from all other vertices, up to {distance_m:.3e} m from the middle of the mesh, {times:.0} times as far as the others: {}. \
         Nothing that is enclosed is left at that scale; remove them",
        vertices_at(.vertices)
    )]
    Outliers {
        /// The vertices of the file, counted from 0, and where they are, m; the farthest first.
        vertices: Vec<(u64, [f64; 3])>,
        /// The largest of their distances from the middle of the mesh, m.
        distance_m: f64,
        /// That distance over the largest one of all other vertices.
        times: f64,
    },
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] crate::cancel_token::Cancelled),
}
