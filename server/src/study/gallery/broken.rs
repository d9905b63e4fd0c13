//! A broken object, as meshes to be drawn.

use super::super::effects::EffectsError;
use crate::picture::{Mesh, Spread, pieces};
use crate::wire::refusal;
use nalgebra::{Point3, Vector3};
use shatter_client::export::{FragmentView, RunView};
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
        let runs: Vec<RunView> = self
            .pieces
            .runs
            .iter()
            .map(|run| RunView { crack: run.crack, index_first: run.index_first, index_count: run.index_count })
            .collect();
        let view = |row: &pipeline::FragmentRow| FragmentView {
            id: row.id,
            body: row.body,
            positions: &self.positions[row.vertex_first as usize..][..row.vertex_count as usize],
            indices: &self.indices[row.index_first as usize..][..row.index_count as usize],
            runs: &runs[row.run_first as usize..][..row.run_count as usize],
            merges: &[],
            centre_m: row.centre_m,
            volume_m3: row.volume_m3,
            mass_kg: row.mass_kg,
        };
        let views: Vec<FragmentView> = self.pieces.fragments.iter().map(view).collect();
        pieces(&views, Spread { hub_m: self.hub_m, factor })
    }
}
