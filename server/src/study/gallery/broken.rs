//! A broken object, as meshes to be drawn.

use super::super::effects::EffectsError;
use super::super::exploded::exploded;
use crate::picture::{Mesh, Spread};
use crate::wire::refusal;
use nalgebra::{Point3, Vector3};
use shatter_fracture::pipeline::{self, Pieces, Prepared, Strike, Workspace};
use shatter_fracture::token::Token;

/// What became of a strike.
pub struct Broken {
    /// Its pieces.
    pub pieces: Pieces,
    hub_m: [f64; 3],
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Broken {
    /// Strikes; what stays whole cannot be shown.
    pub fn new(prepared: &Prepared, strike: &Strike) -> Result<Self, EffectsError> {
        let outcome = pipeline::strike(prepared, strike, &mut Workspace::default(), &Token::default(), &mut ());
        let outcome = outcome.map_err(refusal)?;
        let pieces = outcome.pieces.ok_or_else(|| EffectsError::Whole(prepared.name.clone()))?;
        let mut positions = vec![[0.0; 3]; pieces.counts.vertices];
        let mut indices = vec![0; pieces.counts.indices];
        let mut merges = vec![[0; 2]; pieces.counts.merges];
        pieces.emit(&mut positions, &mut indices, &mut merges).map_err(refusal)?;
        Ok(Self { pieces, hub_m: prepared.frame.centre_m.coords.into(), positions, indices })
    }

    /// Where the centre of fragment `fragment` is drawn when pieces are moved apart by `factor` of their distance.
    pub fn place(&self, fragment: u32, factor: f64) -> Vector3<f32> {
        let centre = Vector3::from(self.pieces.fragments[fragment as usize].centre_m);
        ((centre - Vector3::from(self.hub_m)) * (1.0 + factor)).cast()
    }

    /// A point of the object, drawn with the pieces in their places.
    pub fn point(&self, point_m: &Point3<f64>) -> Point3<f32> {
        (point_m - Vector3::from(self.hub_m)).cast()
    }

    /// The pieces, moved apart by `factor` of their distance. Vertices are numbered as in the answer.
    pub fn mesh(&self, factor: f64) -> Mesh {
        let spread = Spread { hub_m: self.hub_m, factor };
        exploded(&self.pieces.fragments, &self.pieces.runs, &self.positions, &self.indices, spread)
    }
}
