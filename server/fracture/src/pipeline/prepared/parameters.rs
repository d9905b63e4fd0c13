//! Parameters and report of a bake.

use super::preset::Preset;
use crate::cutting::SurfaceRepair;
use crate::elasticity::ElementOrder;
use crate::lattice::LatticeStretch;
use crate::lift::LiftKind;
use crate::scene::Material;
use crate::sparse::Precision;
use crate::surface::Defect;
use serde::{Deserialize, Serialize};
/// Largest number of displacements of one body's basis.
pub const RANK_MAX: usize = 256;

/// Source of the displacements, of an object or of one request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DisplacementMethod {
    /// The reduced basis if there is one and its estimated error is small enough for the impact, else the solve.
    #[default]
    Reduced,
    /// The solve.
    Solve,
}

/// Outer surface of the fragments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceKind {
    /// The boundary of the crack lattice, which approximates the input surface.
    #[default]
    Lattice,
    /// The input surface itself, where the object has a mesh of it; else the boundary of the crack lattice.
    Exact,
}

impl SurfaceKind {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Lattice];

    /// Its name on command lines and in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Lattice => "lattice",
        }
    }
}

/// Surface of an object's fragments, and the meshes behind it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceReport {
    /// Kind of the surface.
    pub kind: SurfaceKind,
    /// Why the surface is that of the lattice; `None` for the exact one, and if no other was asked for.
    pub reason: Option<String>,
    /// Nodes of the meshes of the input surface.
    pub nodes: u64,
    /// Tetrahedra of these meshes.
    pub tets: u64,
    /// Largest distance of a boundary node of these meshes from the input surface, over the diagonal.
    pub deviation: f64,
    /// Edges of the input that were too short for single precision and were collapsed.
    pub collapsed_edges: u64,
    /// Nodes too far from the lattice to follow its values; they take those of the lattice's nearest point.
    pub anchored_nodes: u64,
    /// Repairs of the input that the exact surface needed.
    #[serde(default)]
    pub repairs: Vec<SurfaceRepair>,
}

/// Parameters of a bake, which determine the database together with the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeParameters {
    /// Name of the material.
    pub material_name: String,
    /// Parameters of the material at the time of the bake.
    pub material: Material,
    /// Reference fragment size d, m.
    pub fragment_size_m: f64,
    /// Spacing of the elastic lattice over the bounding-box diagonal.
    pub elastic_spacing: f64,
    /// Spacing of the crack lattice over the bounding-box diagonal.
    pub crack_spacing: f64,
    /// Number of Neumann modes requested for the interior lift (the spectrum is cut at a gap near it).
    pub modes: usize,
    /// Weight α of the modes relative to the coordinates.
    pub alpha: f64,
    /// Seed of all random numbers of the bake.
    pub seed: u64,
    /// True if the bake builds a reduced basis; without one, every request is solved.
    pub elastic: DisplacementMethod,
    /// Precision of the stiffness factors. Single precision applies only where it is accurate enough.
    pub factor: Precision,
    /// Preset of the bake.
    pub quality: Preset,
    /// Surface of the fragments that was asked for.
    #[serde(default)]
    pub surface: SurfaceKind,
    /// Order of the elements that was asked for. Linear in databases of older versions.
    #[serde(default = "ElementChoice::linear")]
    pub elements: ElementChoice,
}

/// Figures of a bake about the mesh and the lattices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// BLAKE3 of the normalized input (positions and triangles, including those of existing cracks), hexadecimal.
    pub input_hash: String,
    /// Volume inside the input surface (generalized winding number above one half), m³.
    pub input_volume_m3: f64,
    /// Total volume of the crack lattices, m³.
    pub lattice_volume_m3: f64,
    /// Largest distance from the crack lattice's boundary to the input surface, over the diagonal.
    ///
    /// The films on which the winding number is one half close the surface's holes and count as surface. Slots of
    /// existing cracks do not count: the distance is measured before they are cut.
    pub surface_deviation: f64,
    /// Defects of the input, and their repairs.
    pub defects: Vec<Defect>,
    /// Names of the input's materials. Attributes and skins refer to them by index.
    pub materials: Vec<String>,
    /// Existing cracks of the object; `None`: none given.
    pub cracks: Option<ExistingCracks>,
    /// Lifts that a body lacks, and why.
    pub unprepared: Vec<MissingLift>,
    /// Surface of the fragments.
    #[serde(default)]
    pub surface: SurfaceReport,
    /// Elements of each body. Empty in databases of older versions, whose elements are linear.
    #[serde(default)]
    pub elastic: Vec<ElasticReport>,
    /// Stretch of the lattices of a thin sheet; `None`: their cells are regular.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<LatticeStretch>,
}

/// Order of the elements of a bake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElementChoice {
    /// Quadratic elements in bodies with few cells across their walls, and where linear ones would miss much of the elastic
    /// energy. Linear ones in the others. Fragments have those of their body.
    #[default]
    Auto,
    /// Linear elements.
    Linear,
    /// Quadratic elements.
    Quadratic,
}

impl ElementChoice {
    /// All choices.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Linear, Self::Quadratic];

    /// Its name on command lines and in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
        }
    }

    fn linear() -> Self {
        Self::Linear
    }
}

/// Elements of one body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElasticReport {
    /// Order of the elements.
    pub order: ElementOrder,
    /// Cells of the elastic lattice across the walls: the thickness that the walls of a quarter of the body's surface do
    /// not exceed, over the spacing. [`CELLS_MAX`] means as many or more.
    pub elements_across: f64,
    /// Why the order is not the usual one, which is linear; `None` if it is.
    pub reason: Option<String>,
    /// Relative error of the elastic energy that stems from the lattice: the median of sampled impacts, estimated from
    /// the lattice refined once, or from the jumps of strains with quadratic elements and on large lattices. `None`: no
    /// elastic lattice, or an older version.
    #[serde(rename = "discretisation_error", default)]
    pub discretization_error: Option<f64>,
    /// Error of solves with linear elements on the same lattice; `None`: the elements are linear, there is no elastic
    /// lattice, or an older version.
    #[serde(rename = "linear_discretisation_error", default)]
    pub linear_error: Option<f64>,
}

/// Cells across walls below which linear elements are too stiff, and [`ElementChoice::Auto`] takes quadratic ones.
pub const CELLS_LINEAR_MIN: f64 = 5.0;

/// Largest number of cells across walls that is measured.
pub const CELLS_MAX: f64 = 8.0;

/// Existing cracks of an object: sheets without width, along which its lattices have slots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExistingCracks {
    /// Number of triangles of the sheets.
    pub triangles: u64,
    /// Area of the sheets, m², including parts outside the object.
    pub area_m2: f64,
    /// Width of the slots in the crack lattices, m.
    pub width_m: f64,
    /// Width of the slots in the elastic lattices, m.
    pub elastic_width_m: f64,
    /// Volume that the slots remove from the crack lattices, m³.
    pub volume_m3: f64,
}

/// A lift that could not be computed for a body. Requests that need it fail.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingLift {
    /// Index of the body.
    pub body: usize,
    /// Kind of the lift.
    pub lift: LiftKind,
    /// Cause.
    pub reason: String,
}

impl BakeReport {
    /// Order of the elements of body `body`.
    pub fn order(&self, body: usize) -> ElementOrder {
        self.elastic.get(body).map_or(ElementOrder::Linear, |own| own.order)
    }

    /// Fewest cells across the walls of any body; `None` in databases of older versions.
    pub fn elements_across(&self) -> Option<f64> {
        self.elastic.iter().map(|own| own.elements_across).reduce(f64::min)
    }

    /// Largest estimated error of any body that stems from its lattice; `None` if no body has one.
    pub fn discretization_error(&self) -> Option<f64> {
        self.elastic.iter().filter_map(|own| own.discretization_error).reduce(f64::max)
    }
    /// Signed volume error of the crack lattices, relative to the input's volume. Slots of existing cracks do not
    /// count.
    pub fn volume_error(&self) -> f64 {
        let slots_m3 = self.cracks.map_or(0.0, |cracks| cracks.volume_m3);
        (self.lattice_volume_m3 + slots_m3) / self.input_volume_m3 - 1.0
    }
}
