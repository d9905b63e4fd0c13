//! Object, impacts and timing of the study.

use super::{AccuracyPlan, PointTimes, StudyError};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::EnergyField;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::degree;
use shatter_fracture::lattice::{EnergyTransfer, Lattice};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, BodyEnergy, ContactSet, DegreeRequest, DisplacementMethod, FractureError, FractureRequest, ImpactSampler,
    PreparedObject, RequestContext, SurfaceKind, Workspace, strain_energy,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::Material;
use std::time::Instant;

/// Material of the object; it sets the scale of impulses and affects no error.
const MATERIAL: &str = "glass";

/// Tables of lattices on which elasticity is measured.
pub(super) const SOLID: Tables = Tables { elastic: true, ..Tables::NONE };
/// The same tables with interior distances.
pub(super) const LIFTED: Tables = Tables { interior: true, ..SOLID };
/// The same tables with attributes and skin.
pub(super) const DRESSED: Tables = Tables { attributes: true, skin: true, ..LIFTED };

/// Number of requests that warm up: they fill caches and buffers.
const WARMING: usize = 4;

/// Bake request of the object.
pub(super) fn request(plan: &AccuracyPlan) -> Result<BakeRequest, StudyError> {
    let material = Material::named(MATERIAL).map_err(|error| StudyError::Materials(error.to_string()))?;
    let [elastic_spacing, crack_spacing] =
        plan.spacings.map_or([None, None], |[elastic, crack]| [Some(elastic), Some(crack)]);
    let tables = Tables { surface_diffusion: true, examples: true, ..LIFTED };
    let (examples, seed) = (plan.examples, plan.seed);
    let request = BakeRequest::new(plan.name.clone(), MATERIAL, material);
    // Where a basis is judged, the study builds it, from more impacts.
    let (elastic, surface) = (DisplacementMethod::Solve, SurfaceKind::Lattice);
    Ok(BakeRequest { elastic_spacing, crack_spacing, elastic, surface, examples, seed, tables, ..request })
}

/// The same object on other lattices, with the same learned model.
pub(super) fn rebaked(
    plan: &AccuracyPlan,
    base: &PreparedObject,
    elastic_spacing: f64,
    crack_spacing: f64,
    tables: Tables,
) -> Result<PreparedObject, StudyError> {
    let request = BakeRequest {
        elastic_spacing: Some(elastic_spacing),
        crack_spacing: Some(crack_spacing),
        gamma_j_m2: Some(base.gamma_j_m2),
        kappa: Some(base.kappa),
        examples: 0,
        tables,
        ..request(plan)?
    };
    let other = bake(plan.mesh.clone(), &request, &CancelToken::default(), &mut |_| {})?;
    match [base, &other].map(|prepared| prepared.bodies.len()) {
        [expected, found] if expected == found => Ok(other),
        [expected, found] => Err(StudyError::Bodies { expected, found }),
    }
}

/// Inward impacts spread over the surface, with impulses for which the closed form gives the plan's number of sites.
pub(super) fn strikes(plan: &AccuracyPlan, base: &PreparedObject) -> Result<Vec<FractureRequest>, StudyError> {
    let sampler = ImpactSampler::new(base);
    let mut workspace = Workspace::default();
    let strike = |number: u64| {
        let (point, inward) = sampler.point(&mut RandomStream::new(plan.seed, number));
        let mut strike = FractureRequest {
            degree: DegreeRequest::Sites(plan.sites),
            seed: number,
            surface: SurfaceKind::Lattice,
            ..FractureRequest::at(base.frame.to_meters(&point), inward)
        };
        let energy = energy(base, &strike, &mut workspace)?;
        // n ∝ W^(3/5), and W ∝ J².
        let sites = base.kappa * degree_of(base, &energy)?;
        strike.contacts[0].impulse_ns *= (f64::from(plan.sites) / sites).powf(5.0 / 6.0);
        Ok(strike)
    };
    (0..plan.impacts).map(strike).collect()
}

/// The requests with the effective contact radii of the coarsest lattice that the study judges, so that all lattices have
/// equal loads.
pub(super) fn widened(
    plan: &AccuracyPlan,
    base: &PreparedObject,
    mut strikes: Vec<FractureRequest>,
) -> Result<Vec<FractureRequest>, StudyError> {
    let coarsest = plan.elastic.iter().copied().fold(1.0, f64::min).powf(-1.0 / 3.0);
    let spacings = [base.parameters.elastic_spacing * coarsest, base.parameters.crack_spacing];
    let coarse = rebaked(plan, base, spacings[0], spacings[1], SOLID)?;
    widen(&coarse, &mut strikes)?;
    widen(base, &mut strikes)?;
    Ok(strikes)
}

/// Sets the contact radii of requests to the effective ones of an object, where those are larger.
pub(super) fn widen(prepared: &PreparedObject, strikes: &mut [FractureRequest]) -> Result<(), StudyError> {
    let mut workspace = Workspace::default();
    for strike in strikes {
        let radius_m = energy(prepared, strike, &mut workspace)?.radius_m;
        let contact = &mut strike.contacts[0];
        contact.radius_m = Some(contact.radius_m.map_or(radius_m, |own| own.max(radius_m)));
    }
    Ok(())
}

/// Strain energy of the body that a request with one contact strikes.
pub(super) fn energy(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    workspace: &mut Workspace,
) -> Result<BodyEnergy, StudyError> {
    let impact = ContactSet::new(prepared, strike)?;
    let energies =
        strain_energy(RequestContext::new(prepared, strike, &CancelToken::default(), &()), &impact, workspace)?;
    energies.into_iter().next().ok_or(StudyError::Whole)
}

/// Strain energies of all requests, on the nodes of `lattices`, those of another object with the same bodies.
pub(super) fn energies_on(
    prepared: &mut PreparedObject,
    lattices: &[&Lattice],
    strikes: &[FractureRequest],
) -> Result<Vec<BodyEnergy>, StudyError> {
    let mut own = Vec::new();
    for (body, lattice) in prepared.bodies.iter_mut().zip(lattices) {
        let solid = body.solid.as_mut().ok_or(StudyError::Unprepared)?;
        let other = EnergyTransfer::between(&solid.lattice, lattice);
        own.push(std::mem::replace(&mut solid.transfer, other));
    }
    let mut workspace = Workspace::default();
    let found = strikes.iter().map(|strike| energy(prepared, strike, &mut workspace)).collect();
    for (body, own) in prepared.bodies.iter_mut().zip(own) {
        body.solid.as_mut().ok_or(StudyError::Unprepared)?.transfer = own;
    }
    found
}

/// n₀ of the closed form at the object's γ, in interior distances; `energy` is on its crack lattice.
pub(super) fn degree_of(prepared: &PreparedObject, energy: &BodyEnergy) -> Result<f64, StudyError> {
    let body = &prepared.bodies[energy.body];
    let mut mass = energy.shares.clone();
    let field = EnergyField::new(prepared.lift(energy.body, LiftKind::Interior)?, &body.volumes, &mut mass)?;
    let gamma = prepared.gamma_j_m2 / energy.unit_j_m2(prepared.frame.diagonal_m);
    Ok(degree::closed_form(&field, &body.slenderness, gamma))
}

/// Times of all requests, including writing into existing memory; the first few impacts warm up.
pub(super) fn timed(
    prepared: &PreparedObject,
    strikes: &[FractureRequest],
    runs: usize,
) -> Result<PointTimes, FractureError> {
    let (mut workspace, mut buffers, mut times) =
        (Workspace::default(), ResultBuffers::default(), PointTimes::default());
    for run in 0..=runs {
        let count = if run == 0 { WARMING } else { usize::MAX };
        for strike in strikes.iter().take(count) {
            let begin = Instant::now();
            let outcome = pipeline::strike(
                pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
                &mut workspace,
            )?;
            if let Some(pieces) = &outcome.meshes() {
                buffers.emit(pieces)?;
            }
            let took = begin.elapsed();
            if run > 0 {
                times.0.push(1e3 * took.as_secs_f64());
            }
        }
    }
    Ok(times)
}

/// Reused buffers for results.
#[derive(Default)]
pub(super) struct ResultBuffers {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
    merges: Vec<[u32; 2]>,
}

impl ResultBuffers {
    pub fn emit(&mut self, pieces: &pipeline::FractureMeshes) -> Result<(), FractureError> {
        let counts = pieces.counts;
        self.positions.resize(self.positions.len().max(counts.vertices), [0.0; 3]);
        self.indices.resize(self.indices.len().max(counts.indices), 0);
        self.merges.resize(self.merges.len().max(counts.merges), [0; 2]);
        pieces.emit(
            &mut self.positions[..counts.vertices],
            &mut self.indices[..counts.indices],
            &mut self.merges[..counts.merges],
        )
    }
}
