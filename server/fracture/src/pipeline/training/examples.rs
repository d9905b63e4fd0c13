//! Computation of examples: impacts whose fracture degree is found by full optimization.

use super::sample::ImpactSampler;
use crate::cancel_token::CancelToken;
use crate::centroidal::{Diagram, EnergyField};
use crate::degree::{self, CurveOptions, CurvePoint, EnergyCurve};
use crate::lift::LiftKind;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::example::{DegreeCurvePoint, TWICE, TrainingExample, records};
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::stages::contact_set::ContactSet;
use crate::pipeline::stages::energy::strain_energy;
use crate::pipeline::workspace::Workspace;
use crate::random::RandomStream;
use std::collections::BTreeMap;

/// Largest number of sites of the curves. Predictions cannot exceed the largest label.
const SITES_MAX: usize = 128;

/// The examples of impact `index` of `seed`, one per struck body.
///
/// # Errors
/// [`FractureError`] of the impact, or for a canceled `token`.
pub fn examples(
    prepared: &PreparedObject,
    sampler: &ImpactSampler,
    seed: u64,
    index: u64,
    workspace: &mut Workspace,
    token: &CancelToken,
) -> Result<Vec<TrainingExample>, FractureError> {
    let strike = sampler.impact(seed, index);
    let impact = ContactSet::new(prepared, &strike)?;
    let mut examples = Vec::new();
    let energies = match strain_energy(RequestContext::new(prepared, &strike, token, &()), &impact, workspace) {
        // Two contacts that cancel yield no example.
        Err(FractureError::Balanced { .. }) => Vec::new(),
        energies => energies?,
    };
    for mut energy in energies {
        let (body, interior) = (&prepared.bodies[energy.body], prepared.lift(energy.body, LiftKind::Interior)?);
        let field = EnergyField::new(interior, &body.volumes, &mut energy.shares)
            .map_err(|source| FractureError::Field { body: energy.body, source })?
            .grouped(&body.clusters);
        let mut curve = |starts: u64| -> Result<(Vec<CurvePoint>, Vec<u32>), FractureError> {
            let seed = RandomStream::new(seed ^ index, starts).bits();
            let mut curve =
                EnergyCurve::new(&field, CurveOptions { sites_max: SITES_MAX, seed, ..CurveOptions::default() });
            let mut sites = BTreeMap::new();
            let mut show = |count: usize, diagram: &Diagram| {
                sites.insert(count, diagram.site_nodes(interior));
            };
            curve.extend_until(&field, 0.0, &mut &*token, &mut workspace.centroidal, &mut show)?;
            Ok((curve.points().to_vec(), sites.into_values().flatten().collect()))
        };
        let (own, site_nodes) = curve(0)?;
        let again = if index.is_multiple_of(TWICE) { curve(1)?.0 } else { Vec::new() };
        let mut points: Vec<DegreeCurvePoint> = own
            .iter()
            .enumerate()
            .map(|(place, point)| DegreeCurvePoint {
                sites: point.sites as u32,
                energy_max: point.energy_max,
                energy_max_worst: point.energy_max_worst,
                energy_max_again: again.get(place).map_or(0.0, |point| point.energy_max),
                estimate: 0.0,
            })
            .collect();
        let labels: Vec<(usize, f64)> = records(own.iter().map(|point| point.energy_max)).collect();
        for (place, gamma) in labels {
            points[place].estimate = degree::closed_form(&field, &body.slenderness, gamma);
        }
        examples.push(TrainingExample {
            impact: index,
            body: energy.body,
            contacts: strike.contacts.clone(),
            energy_j: energy.energy_j,
            first_moment: own[0].energy_max,
            evenness: degree::evenness(&field),
            points,
            site_nodes,
        });
    }
    Ok(examples)
}
