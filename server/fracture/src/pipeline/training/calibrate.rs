//! Calibration of κ, the ratio of the criterion's number of sites to the closed form's, on impacts sampled over the
//! surface.
//!
//! Based on: section 1 of the method: n = max(2, round(κ·n₀)); n₀ after Gersho (1979) and Zador (1982).

use super::sample::ImpactSampler;
use crate::cancel_token::CancelToken;
use crate::centroidal::EnergyField;
use crate::degree::{self, CurveOptions, EnergyCurve};
use crate::lift::LiftKind;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::pipeline::stages::contact_set::ContactSet;
use crate::pipeline::stages::energy::strain_energy;
use crate::pipeline::workspace::Workspace;
use crate::random::RandomStream;

/// Number of sampled impacts.
const IMPACTS: u64 = 6;

/// Largest number of sites of the curves.
const SITES_MAX: usize = 40;

/// Fits κ to the curves E_max(n) of sampled impacts.
///
/// # Errors
/// [`FractureError`] of an impact, or for a canceled `token`.
pub fn calibrate(prepared: &PreparedObject, token: &CancelToken) -> Result<f64, FractureError> {
    let mut workspace = Workspace::default();
    let mut stream = RandomStream::new(prepared.parameters.seed, 0);
    let mut samples = Vec::new();
    let sampler = ImpactSampler::new(prepared);
    for sample in 0..IMPACTS {
        let (point, inward) = sampler.point(&mut stream);
        let request = FractureRequest::at(prepared.frame.to_meters(&point), inward).seeded(1);
        let request = FractureRequest { elastic: DisplacementMethod::Solve, ..request };
        let contacts = ContactSet::new(prepared, &request)?;
        let context = RequestContext::new(prepared, &request, token, &());
        for mut energy in strain_energy(context, &contacts, &mut workspace)? {
            let body = &prepared.bodies[energy.body];
            let field =
                EnergyField::new(prepared.lift(energy.body, LiftKind::Interior)?, &body.volumes, &mut energy.shares)
                    .map_err(|source| FractureError::Field { body: energy.body, source })?
                    .grouped(&body.clusters);
            let options = CurveOptions { sites_max: SITES_MAX, seed: sample, ..CurveOptions::default() };
            let mut curve = EnergyCurve::new(&field, options);
            curve.extend(&field, 0.0, &mut workspace.centroidal, token)?;
            samples.extend(degree::samples(&field, &body.slenderness, &curve));
        }
    }
    Ok(degree::fit_kappa(&samples).map_or(degree::KAPPA, |calibration| calibration.kappa))
}
