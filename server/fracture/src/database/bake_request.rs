//! Request of a bake, and values derived from it.

use super::Tables;
use super::bake_error::BakeError;
use super::learned::EXAMPLES_MAX;
use super::object_name::is_object_name;
use crate::pipeline::{BakeParameters, DisplacementMethod, ElementChoice, Preset, SurfaceKind};
use crate::scene::{DEFAULT_FRAGMENT_DIAGONALS, Material};
use crate::sparse::Precision;
use crate::surface::{RawMesh, Surface};
use crate::{degree, lift};
use serde::{Deserialize, Serialize};

/// Parameters of a bake, without the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeRequest {
    /// Object name: 1 to [`NAME_BYTES_MAX`](super::NAME_BYTES_MAX) bytes, no path separators, no control or invisible
    /// characters.
    pub name: String,
    /// Name of the material, for information.
    pub material_name: String,
    /// Material of the object.
    pub material: Material,
    /// Reference fragment size d, m; `None`: a tenth of the diagonal.
    pub fragment_size_m: Option<f64>,
    /// Threshold γ, J·m²; `None`: from material and fragment size.
    pub gamma_j_m2: Option<f64>,
    /// Preset of the lattices, for everything that the fields below leave open.
    pub quality: Preset,
    /// Spacing of the elastic lattice over the diagonal; `None`: from the preset's number of nodes.
    pub elastic_spacing: Option<f64>,
    /// Spacing of the crack lattice over the diagonal; `None`: from the preset's number of nodes.
    pub crack_spacing: Option<f64>,
    /// κ; `None`: fitted on sampled impacts, which takes most of the time on small lattices.
    pub kappa: Option<f64>,
    /// Number of impacts on which the degree is trained; with any, κ is fitted on them.
    pub examples: u64,
    /// Selects a reduced basis from these impacts, or solves only.
    pub elastic: DisplacementMethod,
    /// Precision of the stiffness factors. Single precision applies only to bodies for which it is accurate enough.
    pub factor: Precision,
    /// Surface of the fragments. The exact one is prepared if the mesh allows it.
    #[serde(default)]
    pub surface: SurfaceKind,
    /// Order of the elements.
    #[serde(default)]
    pub elements: ElementChoice,
    /// Tables to prepare. Examples need elasticity and interior distances.
    pub tables: Tables,
    /// Seed of all random numbers of the bake.
    pub seed: u64,
    /// True if parts that the preset's lattice severs may become separate bodies; else the bake fails. Not stored.
    #[serde(skip, default)]
    pub allows_severed: bool,
    /// Triangles of existing cracks in the coordinates of the mesh; their orientation has no effect.
    #[serde(skip)]
    pub cracks: Option<RawMesh>,
}

impl BakeRequest {
    /// A request with the given name and material, and defaults otherwise.
    pub fn new(name: impl Into<String>, material_name: impl Into<String>, material: Material) -> Self {
        Self {
            name: name.into(),
            material_name: material_name.into(),
            material,
            fragment_size_m: None,
            gamma_j_m2: None,
            quality: Preset::default(),
            elastic_spacing: None,
            crack_spacing: None,
            kappa: None,
            examples: 0,
            elastic: DisplacementMethod::Reduced,
            factor: Precision::F64,
            surface: SurfaceKind::Exact,
            elements: ElementChoice::Auto,
            tables: Tables::ALL,
            seed: 0,
            allows_severed: true,
            cracks: None,
        }
    }

    /// The request without the cracks.
    pub fn without_cracks(&self) -> Self {
        // Copied field by field, because the crack sheets may be large.
        Self {
            name: self.name.clone(),
            material_name: self.material_name.clone(),
            material: self.material.clone(),
            allows_severed: false,
            cracks: None,
            ..*self
        }
    }

    /// The tables that the bake computes.
    pub(super) fn tables(&self) -> Tables {
        let learns = self.examples > 0;
        Tables { elastic: self.tables.elastic || learns, interior: self.tables.interior || learns, ..self.tables }
    }
}

pub(super) fn check(request: &BakeRequest) -> Result<(), BakeError> {
    if !is_object_name(&request.name) {
        return Err(BakeError::Name(request.name.clone()));
    }
    let numbers = [
        ("fragment-size", request.fragment_size_m),
        ("gamma", request.gamma_j_m2),
        ("elastic-spacing", request.elastic_spacing),
        ("crack-spacing", request.crack_spacing),
        ("kappa", request.kappa),
    ];
    for (key, value) in numbers {
        if let Some(value) = value.filter(|value| !(value.is_normal() && *value > 0.0)) {
            return Err(BakeError::NotPositive { key, value });
        }
    }
    check_counts(request.examples)
}

pub(super) fn parameters(
    request: &BakeRequest,
    surface: &Surface,
    [elastic_spacing, crack_spacing]: [f64; 2],
) -> BakeParameters {
    BakeParameters {
        material_name: request.material_name.clone(),
        material: request.material.clone(),
        fragment_size_m: request.fragment_size_m.unwrap_or(DEFAULT_FRAGMENT_DIAGONALS * surface.frame.diagonal_m),
        elastic_spacing,
        crack_spacing,
        modes: request.quality.lattices().modes,
        alpha: lift::ALPHA_DEFAULT,
        seed: request.seed,
        elastic: request.elastic,
        factor: request.factor,
        quality: request.quality,
        surface: request.surface,
        elements: request.elements,
    }
}

pub(super) fn check_counts(examples: u64) -> Result<(), BakeError> {
    let fits = examples <= EXAMPLES_MAX as u64;
    fits.then_some(()).ok_or(BakeError::TooManyExamples { asked: examples })
}

/// The threshold γ, J·m².
pub(super) fn gamma(request: &BakeRequest, parameters: &BakeParameters) -> f64 {
    let BakeParameters { material, fragment_size_m, .. } = parameters;
    let reference = || degree::reference_gamma(material.young_pa, material.strength_pa, *fragment_size_m);
    request.gamma_j_m2.unwrap_or_else(reference)
}
