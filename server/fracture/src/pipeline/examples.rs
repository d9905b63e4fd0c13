//! Examples: impacts whose fracture degree is known at every magnitude and every threshold.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3: examples fractured with a full optimisation teach the degree. That
//! one curve E_max(n) labels every γ is ours: n depends on W/γ alone.

use super::sample::ImpactSampler;
use super::{ContactSet, FractureError, ImpactContact, PreparedObject, StrikeContext, Workspace, strain_energy};
use crate::cancel_token::CancelToken;
use crate::centroidal::{Diagram, EnergyField};
use crate::degree::{self, CurveOptions, CurvePoint, EnergyCurve, SITES_MIN, TrainingSample};
use crate::lift::LiftKind;
use crate::random::RandomStream;
use std::collections::BTreeMap;

/// Curves end at this many sites; predictions above the largest label are out of reach.
const SITES_MAX: usize = 128;

/// One impact of this many is labelled twice.
const TWICE: u64 = 8;

/// One point of an example's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExamplePoint {
    /// n.
    pub sites: u32,
    /// E_max(n), the better of the starts; shares of the body's energy times local length squared.
    pub energy_max: f64,
    /// The worse of the starts.
    pub energy_max_worst: f64,
    /// E_max(n) from other starts: one impact of eight is labelled twice, to see what labels are worth; 0 elsewhere.
    pub energy_max_again: f64,
    /// n₀ at the threshold that this point is a label of; 0 where it is none.
    pub estimate: f64,
}

/// One strain energy field and its curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// Number of the impact; two bodies that it strikes make two examples.
    pub impact: u64,
    /// The body.
    pub body: usize,
    /// The whole impact.
    pub contacts: Vec<ImpactContact>,
    /// The body's strain energy, J.
    pub energy_j: f64,
    /// E_1 in the units of the points.
    pub first_moment: f64,
    /// How evenly the energy is spread: [`degree::evenness`].
    pub evenness: f64,
    /// E_max(n) by rising n, from 1.
    pub points: Vec<ExamplePoint>,
    /// The sites of the best diagram of each point but n = 1, as the crack nodes nearest to them, point after point.
    pub site_nodes: Vec<u32>,
}

impl Example {
    /// The sites of the best diagram of point `place`, as crack nodes; none where n = 1.
    pub fn sites(&self, place: usize) -> &[u32] {
        let length = |point: &ExamplePoint| if point.sites > 1 { point.sites as usize } else { 0 };
        let begin: usize = self.points[..place].iter().map(length).sum();
        &self.site_nodes[begin..][..length(&self.points[place])]
    }

    /// γ of each label, its n₀ and its n: the middles, in the logarithm, of the intervals of γ whose degree some point is.
    pub fn labels(&self) -> impl Iterator<Item = (f64, f64, u32)> + '_ {
        records(self.points.iter().map(|point| point.energy_max)).map(|(place, gamma)| {
            let point = &self.points[place];
            (gamma, point.estimate, point.sites)
        })
    }

    /// The degree at γ; `None` beyond the curve's end.
    pub fn degree(&self, gamma: f64) -> Option<u32> {
        self.points.iter().find(|point| point.energy_max <= gamma).map(|point| point.sites)
    }

    /// One lesson per label.
    pub fn lessons(&self, example: usize) -> impl Iterator<Item = TrainingSample> + '_ {
        self.labels().map(move |(gamma, estimate, found)| TrainingSample {
            example,
            descriptor: degree::descriptor(estimate, self.first_moment, self.evenness, gamma),
            target: degree::target(f64::from(found), estimate),
        })
    }

    /// Lessons from the impact's pose and magnitude alone: place and direction of the first contact, its radius, and ln J²/γ.
    pub(super) fn poses(&self, example: usize) -> impl Iterator<Item = TrainingSample> + '_ {
        let first = self.contacts[0];
        let (place, magnitude) = (first.point_m.coords, first.impulse_ns.norm());
        let direction = first.impulse_ns / magnitude;
        let radius = first.radius_m.unwrap_or(1.0).ln();
        self.labels().map(move |(gamma, estimate, found)| {
            let drive = (magnitude * magnitude / (gamma * self.energy_j)).ln();
            TrainingSample {
                example,
                descriptor: place.iter().chain(direction.iter()).copied().chain([radius, drive]).collect(),
                target: degree::target(f64::from(found), estimate),
            }
        })
    }

    /// |Δn|/n between the degrees of both curves at the γ of the first one's labels; nothing where there is one curve.
    pub fn noise(&self) -> impl Iterator<Item = f64> + '_ {
        let again = |gamma: f64| self.points.iter().find(|point| (0.0..=gamma).contains(&point.energy_max_again));
        let twice = self.impact.is_multiple_of(TWICE);
        self.labels().filter(move |(.., found)| twice && *found as usize >= SITES_MIN).filter_map(
            move |(gamma, _, found)| {
                let found = f64::from(found);
                Some((f64::from(again(gamma)?.sites) - found).abs() / found)
            },
        )
    }
}

/// Places at which the running minimum falls, beyond the first, and the middle γ of the fall.
fn records(energies: impl Iterator<Item = f64>) -> impl Iterator<Item = (usize, f64)> {
    let mut least = f64::INFINITY;
    energies.enumerate().filter_map(move |(place, energy)| {
        let before = least;
        least = before.min(energy);
        (place > 0 && energy < before && energy > 0.0).then(|| (place, before.sqrt() * energy.sqrt()))
    })
}

/// The examples of impact number `index` of `seed`, one per body that it strikes.
pub fn examples(
    prepared: &PreparedObject,
    sampler: &ImpactSampler,
    seed: u64,
    index: u64,
    workspace: &mut Workspace,
    token: &CancelToken,
) -> Result<Vec<Example>, FractureError> {
    let strike = sampler.impact(seed, index);
    let impact = ContactSet::new(prepared, &strike)?;
    let mut examples = Vec::new();
    let energies = match strain_energy(StrikeContext::new(prepared, &strike, token, &()), &impact, workspace) {
        // Two blows that cancel leave nothing to learn from.
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
        let mut points: Vec<ExamplePoint> = own
            .iter()
            .enumerate()
            .map(|(place, point)| ExamplePoint {
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
        examples.push(Example {
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
