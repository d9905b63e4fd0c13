//! The plan: what is asked for, with what its effects make of it, before any work.

use super::{DegreeRequest, FractureRequest};
use crate::lift::LiftKind;
use crate::scene::EffectKind;

impl FractureRequest {
    /// The strike as it is carried out: without interior distances the lift is the straight one, without examples the closed form
    /// decides where they would have.
    pub fn planned(&self) -> Self {
        let lift = if self.effects.has(EffectKind::Interior) { self.lift } else { LiftKind::Euclidean };
        let degree = match self.degree {
            DegreeRequest::Inferred if !self.effects.has(EffectKind::Examples) => DegreeRequest::ClosedForm,
            degree => degree,
        };
        Self { lift, degree, ..self.clone() }
    }
}
