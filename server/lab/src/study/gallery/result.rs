//! Broken object as meshes for drawing.

use super::super::effects::EffectsError;
use super::super::exploded::exploded;
use crate::picture::{DrawnMesh, Spread};
use nalgebra::{Point3, Vector3};
use shatter_engine::wire::engine_error;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureMeshes, FractureOutcome, FractureRequest, FragmentRow, PreparedObject, Workspace,
};
use shatter_fracture::scene::EffectKind;

/// Result of a request.
pub struct GalleryResult {
    /// Fragments.
    pub pieces: FractureMeshes,
    /// E_1/γ.
    pub e1_over_gamma: f64,
    /// Number of sites.
    pub sites: u32,
    hub_m: [f64; 3],
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// Fragment that was struck again, with its result.
    children: Option<(u32, Box<Self>)>,
}

/// Number of sites of the second request.
const AGAIN_SITES: u32 = 12;

/// Radius of its contact, m; large, so that the energy falls off slowly.
const AGAIN_RADIUS_M: f64 = 0.1;

impl GalleryResult {
    /// Strikes the object; an error if it stays whole.
    pub fn new(prepared: &PreparedObject, strike: &FractureRequest) -> Result<Self, EffectsError> {
        Self::of(prepared, prepared.strike(strike).map_err(engine_error)?)
    }

    /// Strikes the largest fragment again at its center, and replaces it by the result.
    pub fn again(self, prepared: &PreparedObject, strike: &FractureRequest) -> Result<Self, EffectsError> {
        let larger = |a: &&FragmentRow, b: &&FragmentRow| a.volume_m3.total_cmp(&b.volume_m3);
        let Some(parent) = self.pieces.fragments.iter().max_by(larger).copied() else { return Ok(self) };
        let mut strike = FractureRequest { degree: DegreeRequest::Sites(AGAIN_SITES), ..strike.clone() };
        for contact in &mut strike.contacts {
            (contact.point_m, contact.radius_m) = (parent.center_m.into(), Some(AGAIN_RADIUS_M));
        }
        strike.effects = strike.effects.without(EffectKind::Elastic);
        let from = (&self.pieces.keep(), parent.id);
        let (mut workspace, token) = (Workspace::default(), CancelToken::default());
        let outcome =
            pipeline::strike_again(pipeline::RequestContext::new(prepared, &strike, &token, &()), from, &mut workspace);
        let children = Self::of(prepared, outcome.map_err(engine_error)?)?;
        Ok(Self { children: Some((parent.id, Box::new(children))), ..self })
    }

    fn of(prepared: &PreparedObject, outcome: FractureOutcome) -> Result<Self, EffectsError> {
        let (e1_over_gamma, sites) = (outcome.threshold().e1_over_gamma, outcome.sites());
        let pieces = outcome.into_meshes().ok_or_else(|| EffectsError::Whole(prepared.name.clone()))?;
        let emitted = pieces.emitted().map_err(engine_error)?;
        let (positions, indices) = (emitted.positions, emitted.indices);
        Ok(Self {
            pieces,
            e1_over_gamma,
            sites,
            hub_m: prepared.frame.center_m.coords.into(),
            positions,
            indices,
            children: None,
        })
    }

    /// Whether anchors held the object.
    pub fn is_held(&self) -> bool {
        self.pieces.effects.has(EffectKind::Anchored)
    }

    /// Drawn center of fragment `fragment` when fragments are moved apart by `factor` of their distance.
    pub fn offset(&self, fragment: u32, factor: f64) -> Vector3<f32> {
        let center = Vector3::from(self.pieces.fragments[fragment as usize].center_m);
        ((center - Vector3::from(self.hub_m)) * (1.0 + factor)).cast()
    }

    /// Drawn position of a point of the object, with the fragments in place.
    pub fn point(&self, point_m: &Point3<f64>) -> Point3<f32> {
        (point_m - Vector3::from(self.hub_m)).cast()
    }

    /// Fragments, moved apart by `factor` of their distance. Vertices keep their numbers in the result.
    pub fn mesh(&self, factor: f64) -> DrawnMesh {
        let spread = Spread { hub_m: self.hub_m, factor };
        let mut mesh = exploded(&self.pieces.fragments, &self.pieces.runs, &self.positions, &self.indices, spread);
        if let Some((parent, children)) = &self.children {
            let row = &self.pieces.fragments[*parent as usize];
            let own = row.vertex_first..row.vertex_first + row.vertex_count;
            let stays: Vec<bool> = mesh.triangles.iter().map(|triangle| !own.contains(&triangle[0])).collect();
            let mut kept = stays.iter();
            mesh.corners.retain(|_| kept.next().is_some_and(|kept| *kept));
            mesh.triangles.retain(|triangle| !own.contains(&triangle[0]));
            mesh.append(children.mesh(factor));
        }
        mesh
    }
}
