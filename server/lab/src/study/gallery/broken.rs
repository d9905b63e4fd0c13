//! A broken object, as meshes to be drawn.

use super::super::effects::EffectsError;
use super::super::exploded::exploded;
use crate::picture::{DrawnMesh, Spread};
use nalgebra::{Point3, Vector3};
use shatter_engine::wire::refusal;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureMeshes, FractureOutcome, FractureRequest, FragmentRow, PreparedObject, Workspace,
};
use shatter_fracture::scene::EffectKind;

/// What became of a strike.
pub struct GalleryResult {
    /// Its pieces.
    pub pieces: FractureMeshes,
    /// E_1/γ.
    pub e1_over_gamma: f64,
    /// Sites of the diagrams.
    pub sites: u32,
    hub_m: [f64; 3],
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// The fragment that was struck again, and what became of it.
    children: Option<(u32, Box<Self>)>,
}

/// Sites of a second strike.
const AGAIN_SITES: u32 = 12;

/// Radius of its contact, m: its energy falls off slowly.
const AGAIN_RADIUS_M: f64 = 0.1;

impl GalleryResult {
    /// Strikes; what stays whole cannot be shown.
    pub fn new(prepared: &PreparedObject, strike: &FractureRequest) -> Result<Self, EffectsError> {
        Self::of(prepared, prepared.strike(strike).map_err(refusal)?)
    }

    /// With the children of the largest piece, struck again in its middle, in its place.
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
            pipeline::strike_again(pipeline::StrikeContext::new(prepared, &strike, &token, &()), from, &mut workspace);
        let children = Self::of(prepared, outcome.map_err(refusal)?)?;
        Ok(Self { children: Some((parent.id, Box::new(children))), ..self })
    }

    fn of(prepared: &PreparedObject, outcome: FractureOutcome) -> Result<Self, EffectsError> {
        let (e1_over_gamma, sites) = (outcome.threshold().e1_over_gamma, outcome.sites());
        let pieces = outcome.into_meshes().ok_or_else(|| EffectsError::Whole(prepared.name.clone()))?;
        let emitted = pieces.emitted().map_err(refusal)?;
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

    /// Whether anchors held it.
    pub fn is_held(&self) -> bool {
        self.pieces.effects.has(EffectKind::Anchored)
    }

    /// Where the center of fragment `fragment` is drawn when pieces are moved apart by `factor` of their distance.
    pub fn place(&self, fragment: u32, factor: f64) -> Vector3<f32> {
        let center = Vector3::from(self.pieces.fragments[fragment as usize].center_m);
        ((center - Vector3::from(self.hub_m)) * (1.0 + factor)).cast()
    }

    /// A point of the object, drawn with the pieces in their places.
    pub fn point(&self, point_m: &Point3<f64>) -> Point3<f32> {
        (point_m - Vector3::from(self.hub_m)).cast()
    }

    /// The pieces, moved apart by `factor` of their distance. Vertices are numbered as in the answer.
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
