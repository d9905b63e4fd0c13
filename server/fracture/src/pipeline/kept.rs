//! What is kept of an answer so that its fragments can be struck again: labels and crack points, a few bytes per node.

use super::{Pieces, StrikeError};
use crate::memory::held;
use crate::tessellation::FixedPoints;

/// The fragments of an answer, as they lie in the crack lattices of the object that was struck. It belongs to that version of
/// the object alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    bodies: Vec<KeptBody>,
}

/// Those of one body.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct KeptBody {
    /// Which body.
    pub body: usize,
    /// Fragment of each node of its crack lattice; those of the answer come first.
    pub labels: Vec<u32>,
    /// Volumes of those of the answer, local.
    pub volumes: Vec<f64>,
    /// All crack points of these labels.
    pub points: FixedPoints,
}

impl Pieces {
    /// What it takes to strike these fragments again.
    pub fn keep(&self) -> Kept {
        let keep = |pieces: &super::pieces::BodyPieces| KeptBody {
            body: pieces.body,
            labels: pieces.labels.clone(),
            volumes: pieces.properties.iter().map(|properties| properties.volume).collect(),
            points: pieces.points.to_fixed(),
        };
        Kept { bodies: self.bodies.iter().map(keep).collect() }
    }
}

impl Kept {
    /// Fragments that can be named: those of the answer.
    pub fn fragments(&self) -> u32 {
        self.bodies.iter().map(|body| body.volumes.len() as u32).sum()
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        let own = self
            .bodies
            .iter()
            .map(|body| held(&body.labels) + held(&body.volumes) + body.points.bytes())
            .sum::<usize>();
        own + held(&self.bodies)
    }

    /// The body of fragment `fragment` of the answer, and its label there.
    ///
    /// Errors: [`StrikeError::UnknownFragment`].
    pub(super) fn find(&self, fragment: u32) -> Result<(&KeptBody, u32), StrikeError> {
        let mut label = fragment;
        for body in &self.bodies {
            let count = body.volumes.len() as u32;
            if label < count {
                return Ok((body, label));
            }
            label -= count;
        }
        Err(StrikeError::UnknownFragment { fragment, count: self.fragments() })
    }
}
