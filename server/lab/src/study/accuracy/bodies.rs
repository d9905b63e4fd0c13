//! Elastic energies of the presets on several bodies, as requests compute them: reduced where the basis allows it.

use super::all_bodies::{self, AllBodiesPoint};
use super::plan::StudyBody;
use super::reference::{EnergyJudge, ImpactLevels, geometry, levels};
use super::settings::Bench;
use super::subject::{SOLID, energy, widen};
use super::{AccuracyPlan, ErrorSpread, Measure, PointErrors, StudyError};
use crate::report::{ReportTable, Section, significant};
use rayon::prelude::*;
use serde_json::{Value, json};
use shatter_fracture::accuracy::Extrapolation;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::pipeline::{
    BodyEnergy, DisplacementMethod, FractureRequest, ImpactSampler, PreparedObject, Preset, SurfaceKind, Workspace,
    reduce,
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
    /// Errors of the energy, of the impacts that were reduced alone; then of those that were solved for.
    pub by_method: [PointErrors; 2],
    /// Error of the energy of a solve on the same lattice with elements of the same order: the rest is the basis'.
    pub lattice: PointErrors,
    /// Whether elements are quadratic.
    pub is_quadratic: bool,
    /// Median of the observed orders; `None` where no impact has one.
    pub order: Option<f64>,
    /// Share of the impacts that were solved for instead of being reduced.
    pub solved: f64,
    /// Time of the reference, s.
    pub reference_s: f64,
}

impl BodyPoint {
    /// Order of the elements.
    pub fn elements(&self) -> &'static str {
        if self.is_quadratic { "quadratic" } else { "linear" }
    }

    /// JSON document of the point.
    pub fn document(&self) -> Value {
        let [reduced, solved] = &self.by_method;
        json!({
            "body": self.body,
            "preset": self.preset,
            "elastic_nodes": self.nodes,
            "quadratic": self.is_quadratic,
            "energy_error": self.errors.document(Measure::Energy),
            "energy_error_reduced": reduced.document(Measure::Energy),
            "energy_error_solved": solved.document(Measure::Energy),
            "energy_error_lattice": self.lattice.document(Measure::Energy),
            "geometry_error": self.errors.document(Measure::Geometry),
            "observed_order": self.order,
            "solved": self.solved,
            "reference_s": self.reference_s,
        })
    }
}

/// A preset on a body, before the finest lattice is known, with the extrapolated energies of the impacts.
type Judged = (BodyPoint, Vec<Extrapolation>);

impl Bench<'_> {
    /// Judges the presets on the plan's further bodies; module `presets` judges them on its object.
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
    let objects = objects(plan, body)?;
    let Some(coarsest) = objects.first() else { return Ok(Vec::new()) };
    let mut strikes = strikes(plan, &coarsest.prepared);
    objects.iter().try_for_each(|own| widen(&own.prepared, &mut strikes))?;
    let judged = objects.iter().map(|own| own.judged(plan, &body.name, &strikes)).collect::<Result<Vec<_>, _>>()?;
    Ok(with_geometry(judged.into_iter().flatten().collect()))
}

/// A body on the elastic lattice of a preset, and the presets that have the same one. Energies depend on no other lattice.
struct BodyObject {
    prepared: PreparedObject,
    presets: Vec<Preset>,
}

/// The body on the elastic lattices of all presets. Thin bodies have the same one for several.
fn objects(plan: &AccuracyPlan, body: &StudyBody) -> Result<Vec<BodyObject>, StudyError> {
    // Crack lattices alone take a fraction of the time of a solid.
    let cracks = plan.body_presets.par_iter().map(|preset| baked(plan, body, *preset, Tables::NONE));
    let cracks: Vec<PreparedObject> = cracks.collect::<Result<_, _>>()?;
    let mut groups: Vec<(PreparedObject, Vec<Preset>)> = Vec::new();
    for (&preset, own) in plan.body_presets.iter().zip(cracks) {
        match groups.iter_mut().find(|(known, _)| has_same_elastic_lattice(known, &own)) {
            Some((_, presets)) => presets.push(preset),
            None => groups.push((own, vec![preset])),
        }
    }
    let object = |(_, presets): (PreparedObject, Vec<Preset>)| {
        let preset = presets[0];
        let mut prepared = baked(plan, body, preset, SOLID)?;
        if preset.solver_settings().elastic == DisplacementMethod::Reduced {
            prepared.impacts = plan.snapshots;
            reduce(&mut prepared, preset.lattices().rank_max, &CancelToken::default())?;
        }
        prepared.factor()?;
        Ok(BodyObject { prepared, presets })
    };
    groups.into_par_iter().map(object).collect()
}

/// The points with the errors of their lattices' shapes against that of the last one.
pub(super) fn with_geometry(judged: Vec<Judged>) -> Vec<BodyPoint> {
    let finest: Vec<Extrapolation> = judged.last().map(|(_, energies)| energies.clone()).unwrap_or_default();
    let last = judged.len().saturating_sub(1);
    let one = |(index, (point, energies)): (usize, Judged)| {
        let each = energies.iter().zip(&finest).map(|(own, finest)| geometry(own, finest));
        let errors = PointErrors::medians(&each.collect::<Vec<_>>());
        let errors = if index < last { errors } else { PointErrors::default() };
        BodyPoint { errors: point.errors.and(errors), ..point }
    };
    judged.into_iter().enumerate().map(one).collect()
}

/// True if two bakes of one body without solids have the same elastic lattice: its spacing is equal.
fn has_same_elastic_lattice(own: &PreparedObject, other: &PreparedObject) -> bool {
    let spacings = [own, other].map(|prepared| prepared.parameters.elastic_spacing);
    spacings[0] == spacings[1] && own.bodies.len() == other.bodies.len()
}

/// The body on the lattices of a preset, without a basis.
fn baked(plan: &AccuracyPlan, body: &StudyBody, quality: Preset, tables: Tables) -> Result<PreparedObject, StudyError> {
    let material = Material::named(MATERIAL).map_err(|error| StudyError::Materials(error.to_string()))?;
    let request = BakeRequest::new(body.name.clone(), MATERIAL, material);
    let (elastic, surface) = (DisplacementMethod::Solve, SurfaceKind::Lattice);
    let (kappa, examples, seed) = (Some(1.0), 0, plan.seed);
    let request = BakeRequest { quality, elastic, surface, kappa, examples, tables, seed, ..request };
    Ok(bake(body.mesh.clone(), &request, &CancelToken::default(), &mut |_| {})?)
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

impl BodyObject {
    /// Judges the energies of every preset with this lattice.
    fn judged(&self, plan: &AccuracyPlan, body: &str, strikes: &[FractureRequest]) -> Result<Vec<Judged>, StudyError> {
        let (prepared, start) = (&self.prepared, Instant::now());
        let judges: Vec<EnergyJudge> = levels(plan, prepared, strikes)?.iter().map(ImpactLevels::judge).collect();
        let reference_s = start.elapsed().as_secs_f64();
        let mut workspace = Workspace::default();
        let mut one = |preset: &Preset| {
            let mut found =
                |strike: &FractureRequest| energy(prepared, &strike.clone().of_quality(*preset), &mut workspace);
            let found = strikes.iter().map(&mut found).collect::<Result<Vec<BodyEnergy>, _>>()?;
            let found: Vec<(BodyEnergy, EnergyJudge)> = found.into_iter().zip(judges.iter().copied()).collect();
            let point = BodyPoint::new(body, *preset, prepared, &found, reference_s);
            Ok((point, judges.iter().map(|judge| judge.energy).collect()))
        };
        self.presets.iter().map(&mut one).collect()
    }
}

impl BodyPoint {
    /// Judges the energies of a preset's requests, each with its reference.
    pub(super) fn new(
        body: &str,
        preset: Preset,
        prepared: &PreparedObject,
        found: &[(BodyEnergy, EnergyJudge)],
        reference_s: f64,
    ) -> Self {
        let errors = |keep: &dyn Fn(&BodyEnergy) -> bool, energy_j: &dyn Fn(&BodyEnergy, &EnergyJudge) -> f64| {
            let kept = found.iter().filter(|(own, _)| keep(own));
            let each = kept.map(|(own, judge)| {
                PointErrors::default().with_bar(Measure::Energy, judge.energy.error(energy_j(own, judge)))
            });
            PointErrors::medians(&each.collect::<Vec<_>>())
        };
        let is_reduced = |own: &BodyEnergy| own.reduced_error.is_some();
        let energy_j = |own: &BodyEnergy, _: &EnergyJudge| own.energy_j;
        let mut orders: Vec<f64> = found.iter().filter_map(|(_, judge)| judge.energy.order).collect();
        orders.sort_by(f64::total_cmp);
        Self {
            body: body.to_owned(),
            preset: preset.name(),
            nodes: prepared.elastic_nodes(),
            errors: errors(&|_| true, &energy_j),
            by_method: [errors(&is_reduced, &energy_j), errors(&|own| !is_reduced(own), &energy_j)],
            lattice: errors(&|_| true, &|_, judge| judge.own_j),
            is_quadratic: prepared.has_quadratic_elements(),
            order: orders.get(orders.len() / 2).copied(),
            solved: found.iter().filter(|(own, _)| !is_reduced(own)).count() as f64 / found.len() as f64,
            reference_s,
        }
    }
}

/// Text of an error; a dash if it was not measured.
fn text(errors: &PointErrors, measure: Measure) -> String {
    errors.text(measure).unwrap_or_else(|| "–".to_owned())
}

/// Texts of the interval, the ninth decile and the bar of an error of the energy.
fn spread(errors: &PointErrors) -> [String; 3] {
    let Some(ErrorSpread { median: [low, high], p90 }) = errors.spread(Measure::Energy) else {
        return ["–"; 3].map(str::to_owned);
    };
    let bar = errors.bar(Measure::Energy).map_or_else(|| "–".to_owned(), |bar| significant(bar, 2));
    [format!("{} to {}", significant(low, 2), significant(high, 2)), significant(p90, 3), bar]
}

/// Section of the page; none without bodies.
pub(super) fn section(points: &[BodyPoint]) -> Option<Section> {
    let lead = "Median error of the elastic energy against the same lattice refined uniformly with elements of the same order, with \
                its 95 % interval; of the impacts that were reduced, and of those that were solved for; of a solve on the lattice; \
                and of the lattice's shape against that of film. Values after ≤ are upper bounds: the error is below three error \
                bars of the reference. All bodies: medians of the bodies' medians of reduced impacts, with the interval over the \
                choice of bodies.";
    let head = [
        "body",
        "preset",
        "elastic nodes",
        "elements",
        "energy error",
        "interval",
        "p90",
        "error bar",
        "reduced",
        "solved",
        "solved, %",
        "of the lattice",
        "error of the shape",
        "observed order",
    ];
    let row = |own: &BodyPoint| {
        let [reduced, solved] = own.by_method.each_ref().map(|errors| text(errors, Measure::Energy));
        let [interval, p90, bar] = spread(&own.errors);
        let row = vec![
            own.body.clone(),
            own.preset.to_owned(),
            own.nodes.to_string(),
            own.elements().to_owned(),
            text(&own.errors, Measure::Energy),
            interval,
            p90,
            bar,
            reduced,
            solved,
            significant(100.0 * own.solved, 3),
            text(&own.lattice, Measure::Energy),
            text(&own.errors, Measure::Geometry),
            own.order.map_or_else(|| "–".to_owned(), |order| significant(order, 3)),
        ];
        ("", row)
    };
    let over_all = |own: &AllBodiesPoint| {
        let ([interval, p90, bar], reduced) = (spread(&own.reduced), text(&own.reduced, Measure::Energy));
        let row = [all_bodies::NAME, own.preset, "–", "–", &reduced, &interval, &p90, &bar, &reduced];
        ("", row.into_iter().chain(["–"; 5]).map(str::to_owned).collect())
    };
    let rows = points.iter().map(row).chain(AllBodiesPoint::all(points).iter().map(over_all)).collect();
    let tables = vec![ReportTable { head: head.map(str::to_owned).to_vec(), rows }];
    let heading = "Elastic energies of several bodies".to_owned();
    (!points.is_empty()).then(|| Section { heading, lead: vec![lead.to_owned()], tables, ..Section::default() })
}
