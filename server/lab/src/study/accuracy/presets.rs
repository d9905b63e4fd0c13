//! Presets, each on its own lattices.

use super::bodies::{BodyPoint, with_geometry};
use super::reference::{ElasticReference, ImpactReference};
use super::settings::Bench;
use super::subject::{DRESSED, energies_on, request, timed};
use super::tessellations::CrackErrors;
use super::truth::{Truth, diagram, is_finer};
use super::{PointErrors, PointTimes, StudyError, StudyPoint};
use rayon::prelude::*;
use serde_json::json;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::DiagramOptions;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::lattice::Lattice;
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    BodyEnergy, DisplacementMethod, FractureRequest, LatticeSettings, PreparedObject, Preset, SurfaceKind, reduce,
};
use std::rc::Rc;

/// Object on the lattices of a preset, with the error of its tessellation.
struct Baked {
    lattices: LatticeSettings,
    prepared: PreparedObject,
    pair: CrackErrors,
}

/// Times and errors of a preset, the elastic reference of its lattice, and its elastic energies as those of a body.
type PresetFound = (PointTimes, PointErrors, Rc<ElasticReference>, BodyPoint);

impl Bench<'_> {
    /// Measures whole requests of all presets, with all of their errors.
    pub(super) fn presets(&mut self) {
        let (mut baked, mut own, mut judged) = (None, Vec::new(), Vec::new());
        for quality in Preset::ALL {
            let name = quality.name();
            (self.progress)(&format!("preset {name}"));
            match self.preset(quality, &mut baked) {
                Ok((times, errors, reference, point)) => {
                    if self.plan.body_presets.contains(&quality) {
                        judged.push((point, reference.impacts.iter().map(|own| own.judge.energy).collect()));
                    }
                    let (setting, value) = ("preset", json!(name));
                    own.push((self.findings.points.len(), reference));
                    self.findings.points.push(StudyPoint { setting, value, preset: Some(name), times, errors });
                }
                Err(error) => self.failed(format!("preset {name}"), error),
            }
            if let Err(error) = self.seen(quality, baked.as_ref()) {
                self.findings.left_out.push([format!("close-up of {name}"), error.to_string()]);
            }
        }
        self.findings.bodies.extend(with_geometry(judged));
        // The last preset has the finest lattice.
        let Some((_, finest)) = own.last().cloned() else { return };
        for (index, reference) in own {
            let each = reference.impacts.iter().zip(&finest.impacts).map(|(own, finest)| own.geometry(finest));
            let errors = PointErrors::medians(&each.collect::<Vec<_>>());
            let point = &mut self.findings.points[index];
            point.errors =
                point.errors.and(if Rc::ptr_eq(&reference, &finest) { PointErrors::default() } else { errors });
        }
    }

    /// Adds the close-up of `draft`, `game` or `film`; `reference` has the lattices of `film`.
    fn seen(&mut self, quality: Preset, baked: Option<&Baked>) -> Result<(), StudyError> {
        let shown = [Preset::Draft, Preset::Game, Preset::Film].contains(&quality);
        let (Some(own), Some(strike)) = (baked.filter(|_| shown), self.strikes.first()) else { return Ok(()) };
        let (degree, surface) = (strike.degree, SurfaceKind::Exact);
        let strike = FractureRequest { degree, surface, ..strike.clone().of_quality(quality) };
        self.look(quality.name(), &own.prepared, &strike)
    }

    fn preset(&mut self, quality: Preset, baked: &mut Option<Baked>) -> Result<PresetFound, StudyError> {
        let lattices = quality.lattices();
        let mut own = match baked.take().filter(|baked| baked.lattices == lattices) {
            Some(baked) => baked,
            None => {
                let prepared = self.baked(quality)?;
                Baked { lattices, pair: self.same_sites(&prepared)?, prepared }
            }
        };
        // The number of sites is the plan's; the preset's own rule is a separate setting.
        let strikes = self.with(|strike| {
            let degree = strike.degree;
            *strike = FractureRequest { degree, ..strike.clone().of_quality(quality) };
        });
        let times = timed(&own.prepared, &strikes, self.plan.runs)?;
        let crack: Vec<&Lattice> = self.base.bodies.iter().map(|body| &body.crack).collect();
        let energies = energies_on(&mut own.prepared, &crack, &strikes)?;
        let reference = self.reference(&own.prepared)?;
        let (base, sites) = (&self.base, self.plan.sites as usize);
        let errors =
            |(((truth, strike), reference), energy): (((&Truth, &FractureRequest), &ImpactReference), &BodyEnergy)| {
                let (tolerance, iterations_max) = (strike.tolerance, strike.iterations_max);
                let options = DiagramOptions { tolerance, iterations_max, ..DiagramOptions::new(sites, strike.seed) };
                let found = diagram(base, &truth.own, base.lift(truth.own.body, LiftKind::Interior)?, &options)?;
                Ok(reference.errors(base, energy)?.and(truth.diagram(base, &found)))
            };
        let each = self.truths.impacts.par_iter().zip(&strikes).zip(&reference.impacts).zip(&energies);
        let all: Vec<PointErrors> = each.map(errors).collect::<Result<_, StudyError>>()?;
        // If the reference is not fine enough, cracks are measured against the exact diagram on their own lattice.
        let judged = is_finer(self.truths.fine.crack_nodes(), own.prepared.crack_nodes());
        let cracks = if judged { own.pair.finest } else { own.pair.own };
        let found: Vec<_> = energies.into_iter().zip(reference.impacts.iter().map(|own| own.judge)).collect();
        let point = BodyPoint::new(&self.plan.name, quality, &own.prepared, &found, reference.took_s);
        *baked = Some(own);
        Ok((times, PointErrors::medians(&all).and(cracks), reference, point))
    }

    /// Bakes the object on the lattices of a preset, with a basis if the preset uses one.
    fn baked(&self, quality: Preset) -> Result<PreparedObject, StudyError> {
        let request = BakeRequest {
            quality,
            gamma_j_m2: Some(self.base.gamma_j_m2),
            kappa: Some(self.base.kappa),
            examples: 0,
            tables: DRESSED,
            // For the close-up; what is measured has the lattice's surface.
            surface: SurfaceKind::Exact,
            ..request(self.plan)?
        };
        let token = CancelToken::default();
        let mut prepared = bake(self.plan.mesh.clone(), &request, &token, &mut |_| {})?;
        let [expected, found] = [&self.base, &prepared].map(|prepared| prepared.bodies.len());
        if expected != found {
            return Err(StudyError::Bodies { expected, found });
        }
        if quality.solver_settings().elastic == DisplacementMethod::Reduced {
            prepared.impacts = self.plan.snapshots;
            reduce(&mut prepared, quality.lattices().rank_max, &token)?;
        }
        prepared.factor()?;
        Ok(prepared)
    }
}
