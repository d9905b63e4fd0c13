//! What an object was baked from, and what baking found out.

use super::preset::Preset;
use crate::lift::LiftKind;
use crate::scene::Material;
use crate::sparse::Precision;
use crate::surface::Defect;
use serde::{Deserialize, Serialize};
/// Most displacements of one body's basis.
pub const RANK_MAX: usize = 256;

/// Where displacements come from: of an object, and of one strike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElasticRequest {
    /// From the reduced basis where there is one and it is exact enough for this impact, else from the solve.
    #[default]
    Reduced,
    /// From the solve.
    Solve,
}

/// What an object was baked from; with the mesh it determines the database.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeParameters {
    /// Name of the material.
    pub material_name: String,
    /// The material's numbers at that time.
    pub material: Material,
    /// Reference fragment size d, m.
    pub fragment_size_m: f64,
    /// Spacing of the elastic lattice over the bounding-box diagonal.
    pub elastic_spacing: f64,
    /// Spacing of the crack lattice over the bounding-box diagonal.
    pub crack_spacing: f64,
    /// Neumann modes asked of the interior lift (the spectrum is cut at a gap near it).
    pub modes: usize,
    /// Weight α of the modes beside the coordinates.
    pub alpha: f64,
    /// Everything random while baking follows from it.
    pub seed: u64,
    /// Whether its impacts give it a reduced basis; without one every strike is solved.
    pub elastic: ElasticRequest,
    /// Of the factors of its stiffness that are exact enough in it.
    pub factor: Precision,
    /// Which preset it was baked as.
    pub quality: Preset,
}

/// What baking found out about the mesh and the lattices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// BLAKE3 of the normalised input (positions and triangles, those of existing cracks among them), hexadecimal.
    pub input_hash: String,
    /// Volume inside the input surface (generalised winding number above one half), m³.
    pub input_volume_m3: f64,
    /// Volume of the crack lattices, m³.
    pub lattice_volume_m3: f64,
    /// Largest distance from the crack lattice's boundary to the input surface, over the diagonal. The films on which the
    /// winding number is one half close the surface's holes and count as surface; slots of existing cracks are left out: it is
    /// that of the lattice before they are cut.
    pub surface_deviation: f64,
    /// What was wrong with the input and what was done about it.
    pub defects: Vec<Defect>,
    /// Names of the input's materials; attributes and skins tell them by their places.
    pub materials: Vec<String>,
    /// The cracks that it carries from the beginning, if it was given any.
    pub cracks: Option<ExistingCracks>,
    /// Lifts that a body does without, and why.
    pub unprepared: Vec<MissingLift>,
}

/// Cracks that an object carries from the beginning: sheets without width, along which its lattices have slots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExistingCracks {
    /// Triangles of the sheets.
    pub triangles: u64,
    /// Their area, in the object or not, m².
    pub area_m2: f64,
    /// Width of the slots in the crack lattices, m.
    pub width_m: f64,
    /// The same in the elastic lattices.
    pub elastic_width_m: f64,
    /// Volume that the crack lattices lose by them, m³.
    pub volume_m3: f64,
}

/// A lift that could not be made for a body; strikes that ask for it are refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingLift {
    /// Which body.
    pub body: usize,
    /// Which lift.
    pub lift: LiftKind,
    /// Why.
    pub reason: String,
}

impl BakeReport {
    /// Signed volume error of the crack lattices, relative to the input's volume; slots of existing cracks are no error.
    pub fn volume_error(&self) -> f64 {
        let slots_m3 = self.cracks.map_or(0.0, |cracks| cracks.volume_m3);
        (self.lattice_volume_m3 + slots_m3) / self.input_volume_m3 - 1.0
    }
}
