//! Retained data of a result for striking its fragments again: labels and crack points, a few bytes per node.

use super::meshes::FractureMeshes;
use super::skins::SkinCut;
use crate::memory::held;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::parameters::SurfaceKind;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::skin::ClippedSurface;
use crate::tessellation::FixedPoints;

/// Fragments of a result in the crack lattices of the struck object.
///
/// Valid only for the same version of the object.
#[derive(Clone, Debug, PartialEq)]
pub struct RetainedFragments {
    bodies: Vec<RetainedBody>,
    /// Cut of the skins, if there are any.
    skins: Option<SkinCut>,
    surface: SurfaceKind,
}

/// Retained fragments of one body.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::pipeline) struct RetainedBody {
    /// Index of the body.
    pub body: usize,
    /// Fragment of each node of the mesh on which the body was cut; fragments of the result come first.
    pub labels: Vec<u32>,
    /// Volumes of the fragments of the result, local.
    pub volumes: Vec<f64>,
    /// All crack points for these labels.
    pub points: FixedPoints,
}

impl FractureMeshes {
    /// Copies the data needed to strike these fragments again.
    pub fn keep(&self) -> RetainedFragments {
        let keep = |pieces: &BodyMeshes| RetainedBody {
            body: pieces.body,
            labels: pieces.labels.clone(),
            volumes: pieces.properties.iter().map(|properties| properties.volume).collect(),
            points: pieces.points.to_fixed(),
        };
        let bodies = self.bodies.iter().map(keep).collect();
        let surface = if self.is_exact { SurfaceKind::Exact } else { SurfaceKind::Lattice };
        RetainedFragments { bodies, skins: self.skins.cut.clone(), surface }
    }
}

impl RetainedFragments {
    /// Surface of the fragments: the nodes are those of crack lattices, or of meshes of the input surface.
    pub(in crate::pipeline) fn surface(&self) -> SurfaceKind {
        self.surface
    }

    /// Number of fragments that can be struck, those of the result.
    pub fn fragments(&self) -> u32 {
        self.bodies.iter().map(|body| body.volumes.len() as u32).sum()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let own = self
            .bodies
            .iter()
            .map(|body| held(&body.labels) + held(&body.volumes) + body.points.bytes())
            .sum::<usize>();
        // The object's own skin is counted with the object.
        let skins = |cut: &SkinCut| {
            let from = if cut.whole { 0 } else { cut.skin.bytes() };
            from + cut.parts.iter().map(ClippedSurface::bytes).sum::<usize>() + held(&cut.parts)
        };
        own + self.skins.as_ref().map_or(0, skins) + held(&self.bodies)
    }

    /// The cut of the result's skins, which includes fragment `fragment`.
    ///
    /// # Errors
    /// [`FractureError::SkinUnprepared`].
    pub(in crate::pipeline) fn skin_cut(&self, fragment: u32) -> Result<&SkinCut, FractureError> {
        let has = |cut: &&SkinCut| (fragment as usize) < cut.parts.len();
        self.skins.as_ref().filter(has).ok_or(FractureError::SkinUnprepared { fragment })
    }

    /// The body of fragment `fragment` of the result, and its label there.
    ///
    /// # Errors
    /// [`FractureError::UnknownFragment`].
    pub(in crate::pipeline) fn find(&self, fragment: u32) -> Result<(&RetainedBody, u32), FractureError> {
        let mut label = fragment;
        for body in &self.bodies {
            let count = body.volumes.len() as u32;
            if label < count {
                return Ok((body, label));
            }
            label -= count;
        }
        Err(FractureError::UnknownFragment { fragment, count: self.fragments() })
    }
}
