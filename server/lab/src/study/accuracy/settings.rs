//! Settings that keep the crack lattice and the lift.

use super::outcomes::outcomes;
use super::reference::{ElasticReference, ImpactReference};
use super::subject::{SOLID, energy, rebaked, timed};
use super::truth::{Truth, Truths, diagram, optimized, solve};
use super::{AccuracyFindings, AccuracyPlan, Measure, PointErrors, StudyError, StudyPoint};
use rayon::prelude::*;
use serde_json::{Value, json};
use shatter_fracture::accuracy::{degree_error, density_error, energy_error};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::DiagramOptions;
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, DegreeRequest, ElasticModel, FractureRequest, PreparedObject, Preset, Workspace,
};
use shatter_fracture::sparse::Precision;
use std::rc::Rc;

/// Number of values that every plan tries.
pub(super) const FIXED: usize =
    1 + SOURCES.len() + PRECISIONS.len() + super::lifts::KINDS.len() + super::tessellations::MODES + Preset::ALL.len();

/// Precisions of the stiffness factor.
const PRECISIONS: [(&str, Precision); 2] = [("f32", Precision::F32), ("f64", Precision::F64)];

/// Sources of the number of sites.
const SOURCES: [(&str, DegreeRequest); 4] = [
    ("closed_form", DegreeRequest::ClosedForm),
    ("inferred", DegreeRequest::Inferred),
    ("verified", DegreeRequest::Verified),
    ("optimised", DegreeRequest::Optimized),
];

/// Timed requests per impact for settings whose requests take as long as a hundred others.
const RUNS_OPTIMIZED: usize = 1;

/// State shared by the measurements of all settings.
pub(super) struct Bench<'a> {
    pub plan: &'a AccuracyPlan,
    pub base: PreparedObject,
    pub strikes: Vec<FractureRequest>,
    pub truths: Truths,
    /// Elastic references of the lattices so far, the object's first.
    pub references: Vec<Rc<ElasticReference>>,
    /// Error of a reference that is too coarse, which ends the study.
    pub refused: Option<StudyError>,
    pub findings: AccuracyFindings,
    pub progress: &'a mut dyn FnMut(&str),
}

impl Bench<'_> {
    /// Measures one value of a setting; a failure is recorded and omitted.
    pub(super) fn point(
        &mut self,
        setting: &'static str,
        value: Value,
        measure: impl FnOnce(&mut Self) -> Result<(super::PointTimes, PointErrors), StudyError>,
    ) {
        (self.progress)(&format!("{setting} {value}"));
        match measure(self) {
            Ok((times, errors)) => {
                self.findings.points.push(StudyPoint { setting, value, preset: None, times, errors })
            }
            Err(error) => self.failed(format!("{setting} {value}"), error),
        }
    }

    /// Records a failure: the study goes on without this value, unless its reference is too coarse.
    pub(super) fn failed(&mut self, what: String, error: StudyError) {
        match error {
            error @ StudyError::CoarseReference { .. } => self.refused = Some(error),
            error => self.findings.left_out.push([what, error.to_string()]),
        }
    }

    /// Elastic reference of the lattice of `prepared`.
    pub(super) fn reference(&mut self, prepared: &PreparedObject) -> Result<Rc<ElasticReference>, StudyError> {
        if let Some(known) = self.references.iter().find(|known| known.is_of(prepared)) {
            return Ok(known.clone());
        }
        let made = Rc::new(ElasticReference::new(self.plan, &self.base, prepared, &self.strikes)?);
        self.references.push(made.clone());
        Ok(made)
    }

    /// Omits one value, with the reason.
    pub(super) fn skip(&mut self, setting: &str, value: impl std::fmt::Display, why: String) {
        let what = format!("{setting} {value}");
        (self.progress)(&what);
        self.findings.left_out.push([what, why]);
    }

    /// The plan's requests with a change.
    pub(super) fn with(&self, change: impl Fn(&mut FractureRequest)) -> Vec<FractureRequest> {
        let mut strikes = self.strikes.clone();
        strikes.iter_mut().for_each(change);
        strikes
    }

    /// Whole results of the presets, end to end.
    pub(super) fn whole_results(&mut self) {
        match outcomes(self.plan, self.base.gamma_j_m2, &self.strikes, self.progress) {
            Ok(found) => self.findings.outcomes = found,
            Err(error) => self.failed("whole results".to_owned(), error),
        }
    }

    /// Spacings of the elastic lattice, by a solve on each.
    pub(super) fn elastic_spacings(&mut self) {
        for nodes in self.plan.elastic.clone() {
            let spacing = self.base.parameters.elastic_spacing * nodes.powf(-1.0 / 3.0);
            self.point("elastic_spacing", json!(spacing), |bench| bench.elastic_spacing(spacing));
        }
    }

    fn elastic_spacing(&mut self, spacing: f64) -> Result<(super::PointTimes, PointErrors), StudyError> {
        let mut other = rebaked(self.plan, &self.base, spacing, self.base.parameters.crack_spacing, SOLID)?;
        let same = |(own, other): (&pipeline::PreparedBody, &pipeline::PreparedBody)| own.crack == other.crack;
        if !self.base.bodies.iter().zip(&other.bodies).all(same) {
            return Err(StudyError::Unprepared);
        }
        let reference = self.reference(&other)?;
        swap_solids(&mut self.base, &mut other);
        let strikes = self.with(|strike| *strike = solve(strike));
        let found = timed(&self.base, &strikes, self.plan.runs).map_err(StudyError::from);
        let found = found.and_then(|times| Ok((times, self.elastic_errors(&reference, &strikes)?)));
        swap_solids(&mut self.base, &mut other);
        found
    }

    fn elastic_errors(
        &self,
        reference: &ElasticReference,
        strikes: &[FractureRequest],
    ) -> Result<PointErrors, StudyError> {
        let base = &self.base;
        let errors = |workspace: &mut Workspace, (own, strike): (&ImpactReference, &FractureRequest)| {
            own.errors(base, &energy(base, strike, workspace)?)
        };
        let each = reference.impacts.par_iter().zip(strikes).map_init(Workspace::default, errors);
        Ok(PointErrors::medians(&each.collect::<Result<Vec<_>, StudyError>>()?))
    }

    /// Ranks of the reduced basis, against the reference and against the solve on the same lattice; then that solve.
    pub(super) fn ranks(&mut self) {
        let Some(reference) = self.references.first().cloned() else { return };
        for rank in self.plan.ranks.clone() {
            let strikes = self.with(|strike| strike.rank_max = Some(rank));
            let mut alone = None;
            self.point("rank", json!(rank), |bench| {
                let found =
                    (timed(&bench.base, &strikes, bench.plan.runs)?, bench.elastic_errors(&reference, &strikes)?);
                alone = Some((found.0.clone(), bench.reduction_errors(&strikes)?));
                Ok(found)
            });
            match alone {
                Some((times, Some(errors))) => {
                    let (setting, value) = ("rank_own_lattice", json!(rank));
                    self.findings.points.push(StudyPoint { setting, value, preset: None, times, errors });
                }
                Some((_, None)) => {
                    let why = "the basis is accurate enough for none of the impacts: all were solved for";
                    self.findings.left_out.push([format!("rank_own_lattice {rank}"), why.to_owned()]);
                }
                None => {}
            }
        }
        self.point("rank", json!("solve"), |bench| {
            let strikes = bench.with(|strike| *strike = solve(strike));
            Ok((timed(&bench.base, &strikes, bench.plan.runs)?, bench.elastic_errors(&reference, &strikes)?))
        });
    }

    /// Error added by the basis, and its estimate: of the impacts that are not solved for; `None` without such impacts.
    fn reduction_errors(&mut self, strikes: &[FractureRequest]) -> Result<Option<PointErrors>, StudyError> {
        let mut workspace = Workspace::default();
        let mut all = Vec::new();
        for (truth, strike) in self.truths.impacts.iter().zip(strikes) {
            let found = energy(&self.base, strike, &mut workspace)?;
            let Some(estimate) = found.reduced_error else { continue };
            let own = &truth.own;
            let ratio = found.energy_j / own.energy_j;
            let scaled: Vec<f64> = found.shares.iter().map(|share| share * ratio).collect();
            let error = energy_error(found.energy_j, own.energy_j);
            self.findings.estimates.push([estimate, error]);
            all.push(
                PointErrors::default()
                    .with(Measure::Energy, error)
                    .with(Measure::Density, density_error(&scaled, &own.shares)?)
                    .with(Measure::Estimate, estimate),
            );
        }
        Ok((!all.is_empty()).then(|| PointErrors::medians(&all)))
    }

    /// Precisions of the factor, against a factor of double precision on the same lattice; every impact is solved for.
    pub(super) fn precisions(&mut self) {
        for (name, precision) in PRECISIONS {
            self.point("factor_precision", json!(name), |bench| bench.precision(precision));
        }
    }

    fn precision(&mut self, precision: Precision) -> Result<(super::PointTimes, PointErrors), StudyError> {
        let mut own = Vec::new();
        let poisson = self.base.parameters.material.poisson;
        for body in &mut self.base.bodies {
            let Some(solid) = &body.solid else { return Err(StudyError::Unprepared) };
            let (lattice, transfer) = (solid.lattice.clone(), solid.transfer.clone());
            let (law, order) = ((poisson, precision), solid.elasticity.order());
            own.push(ElasticModel::new(lattice, transfer, law, order, &CancelToken::default())?);
        }
        let mut swap = |base: &mut PreparedObject| {
            for (body, own) in base.bodies.iter_mut().zip(&mut own) {
                body.solid = body.solid.take().map(|solid| std::mem::replace(own, solid));
            }
        };
        swap(&mut self.base);
        let strikes = self.with(|strike| *strike = solve(strike));
        let found = self.precise(&strikes);
        swap(&mut self.base);
        found
    }

    fn precise(&self, strikes: &[FractureRequest]) -> Result<(super::PointTimes, PointErrors), StudyError> {
        self.base.factor()?;
        let mut workspace = Workspace::default();
        let errors = self.truths.impacts.iter().zip(strikes).map(|(truth, strike)| {
            let found = energy(&self.base, strike, &mut workspace)?;
            let ratio = found.energy_j / truth.own.energy_j;
            let scaled: Vec<f64> = found.shares.iter().map(|share| share * ratio).collect();
            Ok(PointErrors::default()
                .with(Measure::Energy, energy_error(found.energy_j, truth.own.energy_j))
                .with(Measure::Density, density_error(&scaled, &truth.own.shares)?))
        });
        let errors = errors.collect::<Result<Vec<_>, StudyError>>()?;
        Ok((timed(&self.base, strikes, self.plan.runs)?, PointErrors::medians(&errors)))
    }

    /// Tolerances of the diagram.
    pub(super) fn tolerances(&mut self) {
        for tolerance in self.plan.tolerances.clone() {
            self.point("cvd_tolerance", json!(tolerance), |bench| {
                let strikes = bench.with(|strike| strike.tolerance = tolerance);
                let (base, sites) = (&bench.base, bench.plan.sites as usize);
                let errors = |(truth, strike): (&Truth, &FractureRequest)| {
                    let options = DiagramOptions { tolerance, ..DiagramOptions::new(sites, strike.seed) };
                    let lift = base.lift(truth.own.body, LiftKind::Interior)?;
                    Ok(truth.diagram(base, &diagram(base, &truth.own, lift, &options)?))
                };
                let all = bench.truths.impacts.par_iter().zip(&bench.strikes).map(errors);
                let all: Vec<PointErrors> = all.collect::<Result<_, StudyError>>()?;
                Ok((timed(base, &strikes, bench.plan.runs)?, PointErrors::medians(&all)))
            });
        }
    }

    /// Sources of the degree, on impacts of several magnitudes: with a single number of sites, sources close to it would look too good.
    pub(super) fn degrees(&mut self) {
        let factors = spread(self.strikes.len());
        let base = &self.base;
        let wanted = self.truths.impacts.par_iter().zip(&factors);
        let wanted = wanted.map(|(truth, factor)| optimized(base, truth, *factor));
        let wanted: Vec<f64> = match wanted.collect::<Result<_, _>>() {
            Ok(wanted) => wanted,
            Err(error) => return self.findings.left_out.push(["degree".to_owned(), StudyError::to_string(&error)]),
        };
        for (name, degree) in SOURCES {
            self.point("degree", json!(name), |bench| {
                let mut strikes = bench.with(|strike| strike.degree = degree);
                for (strike, factor) in strikes.iter_mut().zip(&factors) {
                    strike.contacts[0].impulse_ns *= *factor;
                }
                let base = &bench.base;
                let errors = |(strike, wanted): (&FractureRequest, &f64)| {
                    let (token, mut workspace) = (CancelToken::default(), Workspace::default());
                    let context = pipeline::RequestContext::new(base, strike, &token, &());
                    let found = pipeline::strike(context, &mut workspace)?;
                    let error = degree_error(f64::from(found.fracture_degree()), *wanted);
                    Ok(PointErrors::default().with(Measure::Degree, error))
                };
                let all = strikes.par_iter().zip(&wanted).map(errors);
                let all: Vec<PointErrors> = all.collect::<Result<_, StudyError>>()?;
                let runs = bench.plan.runs.min(RUNS_OPTIMIZED);
                Ok((timed(&bench.base, &strikes, runs)?, PointErrors::medians(&all)))
            });
        }
    }
}

/// Factors on impulses that spread the number of sites evenly over a factor of four, about the plan's number.
pub(super) fn spread(count: usize) -> Vec<f64> {
    let place = |number: usize| (number as f64 + 0.5) / count as f64 - 0.5;
    (0..count).map(|number| 4f64.powf(5.0 / 6.0 * place(number))).collect()
}

/// Exchanges the elasticity of two objects with the same crack lattices.
fn swap_solids(one: &mut PreparedObject, other: &mut PreparedObject) {
    for (own, other) in one.bodies.iter_mut().zip(&mut other.bodies) {
        std::mem::swap(&mut own.solid, &mut other.solid);
    }
}
