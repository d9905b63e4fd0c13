//! κ: how many more sites the criterion wants than the closed form says, fitted on impacts sampled over the surface.
//!
//! Based on: method of the house (section 1): n = max(2, round(κ·n₀)); n₀ after Gersho (1979) and Zador (1982).

use super::{ElasticRequest, Impact, Prepared, Sampler, Strike, StrikeError, Workspace, strain_energy};
use crate::centroidal::Field;
use crate::degree::{self, Curve, CurveOptions};
use crate::lift::LiftKind;
use crate::random::Stream;
use crate::token::Token;

/// Impacts sampled.
const IMPACTS: u64 = 6;

/// The curves end at this many sites.
const SITES_MAX: usize = 40;

/// κ from the curves E_max(n) of sampled impacts.
pub fn calibrate(prepared: &Prepared, token: &Token) -> Result<f64, StrikeError> {
    let mut workspace = Workspace::default();
    let mut stream = Stream::new(prepared.parameters.seed, 0);
    let mut samples = Vec::new();
    let sampler = Sampler::new(prepared);
    for sample in 0..IMPACTS {
        let (point, inward) = sampler.point(&mut stream);
        let strike = Strike::at(prepared.frame.to_metres(&point), inward).seeded(1);
        let impact = Impact::new(prepared, &Strike { elastic: ElasticRequest::Solve, ..strike })?;
        for mut energy in strain_energy(prepared, &impact, &mut workspace, token, &mut ())? {
            let body = &prepared.bodies[energy.body];
            let field = Field::new(prepared.lift(energy.body, LiftKind::Interior)?, &body.volumes, &mut energy.shares)
                .map_err(|source| StrikeError::Field { body: energy.body, source })?
                .grouped(&body.clusters);
            let options = CurveOptions { sites_max: SITES_MAX, seed: sample, ..CurveOptions::default() };
            let mut curve = Curve::new(&field, options);
            curve.extend(&field, 0.0, &mut workspace.centroidal, token)?;
            samples.extend(degree::samples(&field, &body.slenderness, &curve));
        }
    }
    Ok(degree::fit_kappa(&samples).map_or(degree::KAPPA, |calibration| calibration.kappa))
}
