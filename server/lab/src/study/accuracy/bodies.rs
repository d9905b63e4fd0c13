//! Elastic energies of the presets on several bodies, as requests compute them: reduced where the basis allows it.

use super::plan::StudyBody;
use super::reference::{ImpactLevels, geometry, levels};
use super::settings::Bench;
use super::subject::{LIFTED, energy, widen};
use super::{AccuracyPlan, ErrorSpread, Measure, PointErrors, StudyError};
use crate::report::{ReportTable, Section, significant};
use serde_json::{Value, json};
use shatter_fracture::accuracy::Extrapolation;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{
    BodyEnergy, DisplacementMethod, FractureRequest, ImpactSampler, PreparedObject, Preset, Workspace, reduce,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::Material;
use std::time::Instant;

/// Material of the bodies; only its Poisson's ratio matters.
const MATERIAL: &str = "glass";

/// Impulse of the impacts, N·s; it affects no relative error.
const IMPULSE_NS: f64 = 1.0;

/// A preset on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPoint {
    /// Name of the body.
    pub body: String,
    /// Name of the preset.
    pub preset: &'static str,
    /// Number of elastic nodes.
    pub nodes: usize,
    /// Elastic errors: of the energy, and of the lattice's shape.
    pub errors: PointErrors,
    /// Median of the observed orders; `None` where no impact has one.
    pub order: Option<f64>,
    /// Share of the impacts that were solved for instead of being reduced.
    pub solved: f64,
    /// Time of the reference, s.
    pub reference_s: f64,
}

impl BodyPoint {
    /// JSON document of the point.
    pub fn document(&self) -> Value {
        let error = |measure| {
            let spread = self.errors.spread(measure)?;
            Some(json!({
                "median": self.errors.get(measure),
                "at_most": self.errors.is_at_most(measure),
                "bar": self.errors.bar(measure),
                "median_interval": spread.median,
                "p90": spread.p90,
            }))
        };
        json!({
            "body": self.body,
            "preset": self.preset,
            "elastic_nodes": self.nodes,
            "energy_error": error(Measure::Energy),
            "geometry_error": error(Measure::Geometry),
            "observed_order": self.order,
            "solved": self.solved,
            "reference_s": self.reference_s,
        })
    }
}

/// A preset on a body, before the finest lattice is known.
struct Judged {
    point: BodyPoint,
    energies: Vec<Extrapolation>,
}

impl Bench<'_> {
    /// Judges the presets on the plan's object and its further bodies.
    pub(super) fn bodies(&mut self) {
        for body in &self.plan.bodies {
            (self.progress)(&format!("body {}", body.name));
            match body_points(self.plan, body) {
                Ok(points) => self.findings.bodies.extend(points),
                Err(error) => self.failed(format!("body {}", body.name), error),
            }
        }
    }
}

fn body_points(plan: &AccuracyPlan, body: &StudyBody) -> Result<Vec<BodyPoint>, StudyError> {
    let baked = plan.body_presets.iter().map(|preset| baked(plan, body, *preset));
    let baked: Vec<PreparedObject> = baked.collect::<Result<_, _>>()?;
    let Some(coarsest) = baked.first() else { return Ok(Vec::new()) };
    let mut strikes = strikes(plan, coarsest);
    baked.iter().try_for_each(|prepared| widen(prepared, &mut strikes))?;
    let judged =
        plan.body_presets.iter().zip(&baked).map(|(preset, prepared)| judged(plan, body, *preset, prepared, &strikes));
    let judged: Vec<Judged> = judged.collect::<Result<_, _>>()?;
    let finest: Vec<Extrapolation> = judged.last().map(|own| own.energies.clone()).unwrap_or_default();
    let last = judged.len() - 1;
    let with_geometry = |(index, own): (usize, Judged)| {
        let each: Vec<PointErrors> =
            own.energies.iter().zip(&finest).map(|(own, finest)| geometry(own, finest)).collect();
        let errors = if index < last { PointErrors::medians(&each) } else { PointErrors::default() };
        BodyPoint { errors: own.point.errors.and(errors), ..own.point }
    };
    Ok(judged.into_iter().enumerate().map(with_geometry).collect())
}

/// The body on the lattices of a preset, with its basis.
fn baked(plan: &AccuracyPlan, body: &StudyBody, quality: Preset) -> Result<PreparedObject, StudyError> {
    let material = Material::named(MATERIAL).map_err(|error| StudyError::Materials(error.to_string()))?;
    let request = BakeRequest::new(body.name.clone(), MATERIAL, material);
    let request = BakeRequest { quality, kappa: Some(1.0), examples: 0, tables: LIFTED, seed: plan.seed, ..request };
    let token = CancelToken::default();
    let mut prepared = bake(body.mesh.clone(), &request, &token, &mut |_| {})?;
    if quality.solver_settings().elastic == DisplacementMethod::Reduced {
        prepared.impacts = plan.snapshots;
        reduce(&mut prepared, quality.lattices().rank_max, &token)?;
    }
    prepared.factor()?;
    Ok(prepared)
}

/// Inward impacts spread over the surface.
fn strikes(plan: &AccuracyPlan, prepared: &PreparedObject) -> Vec<FractureRequest> {
    let sampler = ImpactSampler::new(prepared);
    let strike = |number| {
        let (point, inward) = sampler.point(&mut RandomStream::new(plan.seed, number));
        FractureRequest::at(prepared.frame.to_meters(&point), inward * IMPULSE_NS).seeded(number)
    };
    (0..plan.impacts).map(strike).collect()
}

fn judged(
    plan: &AccuracyPlan,
    body: &StudyBody,
    preset: Preset,
    prepared: &PreparedObject,
    strikes: &[FractureRequest],
) -> Result<Judged, StudyError> {
    let strikes: Vec<FractureRequest> = strikes.iter().map(|strike| strike.clone().of_quality(preset)).collect();
    let mut workspace = Workspace::default();
    let found = strikes.iter().map(|strike| energy(prepared, strike, &mut workspace));
    let found: Vec<BodyEnergy> = found.collect::<Result<_, _>>()?;
    let start = Instant::now();
    let energies: Vec<Extrapolation> = levels(plan, prepared, &strikes)?.iter().map(ImpactLevels::energy).collect();
    let reference_s = start.elapsed().as_secs_f64();
    let error = |(own, found): (&Extrapolation, &BodyEnergy)| {
        PointErrors::default().with_bar(Measure::Energy, own.error(found.energy_j))
    };
    let errors: Vec<PointErrors> = energies.iter().zip(&found).map(error).collect();
    let mut orders: Vec<f64> = energies.iter().filter_map(|own| own.order).collect();
    orders.sort_by(f64::total_cmp);
    let solved = found.iter().filter(|own| own.reduced_error.is_none()).count() as f64 / found.len() as f64;
    let point = BodyPoint {
        body: body.name.clone(),
        preset: preset.name(),
        nodes: prepared.elastic_nodes(),
        errors: PointErrors::medians(&errors),
        order: orders.get(orders.len() / 2).copied(),
        solved,
        reference_s,
    };
    Ok(Judged { point, energies })
}

/// Section of the page; none without bodies.
pub(super) fn section(points: &[BodyPoint]) -> Option<Section> {
    let lead = "Median error of the elastic energy against the same lattice refined uniformly, with its 95 % interval; and of the \
                lattice's shape against that of film. Values after ≤ are upper bounds: the error is below three error bars of \
                the reference.";
    let head = [
        "body",
        "preset",
        "elastic nodes",
        "energy error",
        "interval",
        "p90",
        "error bar",
        "error of the shape",
        "observed order",
        "solved, %",
    ];
    let row = |own: &BodyPoint| {
        let text = |measure| own.errors.text(measure).unwrap_or_else(|| "–".to_owned());
        let ErrorSpread { median: [low, high], p90 } = own.errors.spread(Measure::Energy).unwrap_or_default();
        let row = vec![
            own.body.clone(),
            own.preset.to_owned(),
            own.nodes.to_string(),
            text(Measure::Energy),
            format!("{} to {}", significant(low, 2), significant(high, 2)),
            significant(p90, 3),
            own.errors.bar(Measure::Energy).map_or_else(|| "–".to_owned(), |bar| significant(bar, 2)),
            text(Measure::Geometry),
            own.order.map_or_else(|| "–".to_owned(), |order| significant(order, 3)),
            significant(100.0 * own.solved, 3),
        ];
        ("", row)
    };
    let tables = vec![ReportTable { head: head.map(str::to_owned).to_vec(), rows: points.iter().map(row).collect() }];
    let heading = "Elastic energies of several bodies".to_owned();
    (!points.is_empty()).then(|| Section { heading, lead: vec![lead.to_owned()], tables, ..Section::default() })
}
