//! Errors of reading and checking meshes.

use crate::scene::number;
use std::path::PathBuf;

/// Formats a vertex with its position. Exponents are used for very small and very large coordinates.
fn vertex_at(vertex: u64, at_m: &[f64; 3]) -> String {
    let is_long = |x: &f64| *x != 0.0 && !(1e-6..1e12).contains(&x.abs());
    let [x, y, z] = at_m.map(|x| if is_long(&x) { format!("{x:e}") } else { x.to_string() });
    format!("vertex {vertex} at ({x}, {y}, {z})")
}

fn vertices_at(vertices: &[(u64, [f64; 3])]) -> String {
    vertices.iter().map(|(vertex, at_m)| vertex_at(*vertex, at_m)).collect::<Vec<_>>().join(", ")
}

/// Formats extents in m.
fn product(extents_m: &[f64; 3]) -> String {
    let [length, width, thickness] = extents_m;
    format!("{length:.3e} × {width:.3e} × {thickness:.3e} m")
}

/// Error for a mesh that cannot be used. Every variant names the place.
#[derive(thiserror::Error)]
pub enum SurfaceError {
    /// The file, or a file that it refers to, cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file name has none of the known extensions.
    #[error("{path}: unknown mesh format '{extension}'; export the mesh as obj, ply, stl, gltf or glb, or a tetrahedral mesh as msh, vtk or mesh", path = .path.display())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
        /// Extension of the file; empty if it has none.
        extension: String,
    },
    /// The file does not follow its format.
    #[error("malformed {format}, {place}: {reason}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// Place in the file: a line, a byte or an element.
        place: String,
        /// Fault at that place.
        reason: String,
    },
    /// A glTF file requires an extension that this reader does not know.
    #[error(
        "the glTF file requires the extension {extension}, which Shatter does not read; export the mesh without it"
    )]
    RequiredExtension {
        /// Name of the extension.
        extension: String,
    },
    /// The mesh has too many vertices or triangles.
    #[error("too many vertices or triangles: at most {limit} of each are accepted")]
    TooLarge {
        /// Largest accepted number of each.
        limit: u64,
    },
    /// The mesh has no vertex or no triangle.
    #[error("no {missing} were found; {expected}. Export the mesh again, with its geometry")]
    Empty {
        /// Missing kind: vertices or faces.
        missing: &'static str,
        /// Description of a valid file of this format.
        expected: &'static str,
    },
    /// A coordinate is infinite or not a number.
    #[error(
        "vertex {vertex}, counted from 0,{} has a coordinate that is infinite or not a number; correct it, or export the mesh again",
        line.map_or(String::new(), |line| format!(" in line {line}"))
    )]
    NonFiniteVertex {
        /// Vertex of the file, counted from 0.
        vertex: u64,
        /// Its line in a text file, counted from 1.
        line: Option<usize>,
    },
    /// A coordinate is so large that volumes or masses would not be finite.
    #[error("{} is out of range: coordinates must lie within ±{limit_m:e} m. Check --unit", vertex_at(*.vertex, .at_m))]
    VertexOutOfRange {
        /// Vertex of the file, counted from 0.
        vertex: u64,
        /// Position of the vertex, m.
        at_m: [f64; 3],
        /// Largest accepted magnitude of a coordinate, m.
        limit_m: f64,
    },
    /// A face refers to a vertex that does not exist.
    #[error("face {face} refers to vertex {index}, but the mesh has {vertices} {}", if *.vertices == 1 { "vertex" } else { "vertices" })]
    VertexOutOfBounds {
        /// Face of the file, counted from 0.
        face: u64,
        /// Vertex index, counted from 0; negative if a relative index precedes the first vertex.
        index: i64,
        /// Number of vertices.
        vertices: u64,
    },
    /// A vertex of an existing crack is so far from the object that distances to it would lose their digits.
    #[error("vertex {vertex} is more than a million diagonals from the object")]
    FarVertex {
        /// Vertex of the file, counted from 0.
        vertex: u64,
    },
    /// Every triangle has zero area.
    #[error("every triangle is degenerate")]
    AllDegenerate,
    /// All vertices coincide.
    #[error("the bounding box is a point: all vertices coincide")]
    ZeroExtent,
    /// The bounding box is too small or too large for fragments with single-precision vertices in meters.
    #[error("the bounding-box diagonal, {} m, is out of range: 1e-30 to 1e36 m", number(*.diagonal_m))]
    ExtentOutOfRange {
        /// Diagonal of the bounding box, m.
        diagonal_m: f64,
    },
    /// No point has a winding number above ½: the surface is a flat sheet, or its shells cancel.
    #[error("the surface encloses no volume: it is open, or its shells cancel each other")]
    NothingInside,
    /// All vertices lie in a plane, or nearly so.
    #[error(
        "the mesh is flat{}: its extents are {}; {}",
        if *encloses { "" } else { " and encloses no volume" },
        product(.extents_m),
        if *encloses { "no lattice resolves so thin a plate; make it thicker" } else { "give it a thickness" }
    )]
    Flat {
        /// Extents along the principal axes, largest first, m.
        extents_m: [f64; 3],
        /// True if the surface is closed around a volume.
        encloses: bool,
    },
    /// The mesh is closed, but too thin in two directions for every possible lattice.
    #[error(
        "the mesh is a needle, thin in two directions: its extents are {}, so it is {:.0} times as long as thick, which no lattice \
         resolves; make it {thickness_min_m:.3e} m thick or more and lay it along an axis, or bake it in shorter parts",
        product(.extents_m),
        .extents_m[0] / .extents_m[2]
    )]
    Needle {
        /// Extents along the principal axes, largest first, m.
        extents_m: [f64; 3],
        /// Thickness that the finest lattice resolves, m.
        thickness_min_m: f64,
    },
    /// A few vertices are so far from the others that the rest of the mesh is too small to resolve.
    #[error(
        "outlying vertices, up to {distance_m:.3e} m from the middle of the mesh, {times:.0} times as far as the others: {}. \
         At that scale the rest of the mesh encloses no volume; remove these vertices, or, if they belong to the shape, \
         it is too thin for its length: thicken it",
        vertices_at(.vertices)
    )]
    Outliers {
        /// Outlying vertices, counted from 0, and their positions in m; farthest first.
        vertices: Vec<(u64, [f64; 3])>,
        /// Largest distance of an outlier from the middle of the mesh, m.
        distance_m: f64,
        /// That distance over the largest distance of all other vertices.
        times: f64,
    },
    /// The work was canceled.
    #[error(transparent)]
    Canceled(#[from] crate::cancel_token::Canceled),
}
