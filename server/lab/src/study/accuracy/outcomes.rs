//! Whole results of the presets, end to end, against those of a reference with finer lattices.
//!
//! Two results of one request with different seeds differ, too. The scatter between seeds of the reference is therefore
//! the yardstick: a preset whose results lie no farther from the reference's than those from each other cannot be told
//! from it.

use super::point::quantile;
use super::settings::spread;
use super::subject::{LIFTED, request, strikes};
use super::truth::SEED_FIRST;
use super::{AccuracyPlan, StudyError};
use crate::report::{ReportTable, Section, significant};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use serde_json::{Value, json};
use shatter_fracture::accuracy::wasserstein;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::pipeline::{
    self, DisplacementMethod, FractureMeshes, FractureRequest, PreparedObject, Preset, RequestContext, Workspace,
    reduce,
};

/// Share of the distances between the reference's own results that count as its scatter.
const SCATTER: f64 = 0.95;

/// Names of the distances of two results, in their order.
pub const DISTANCES: [&str; 4] = ["degree", "volumes", "crack_area", "largest_place"];

/// Figures of one result.
#[derive(Clone, Debug, PartialEq)]
struct Outcome {
    /// Logarithms of the volumes of the fragments, m³.
    log_volumes: Vec<f64>,
    /// Area of the cracks, each counted once, m².
    crack_area_m2: f64,
    /// Center of the largest fragment, over the diagonal.
    largest: Point3<f64>,
}

/// End-to-end errors of a preset.
#[derive(Clone, Debug, PartialEq)]
pub struct OutcomePoint {
    /// Name of the preset.
    pub preset: &'static str,
    /// Medians of the distances from the reference's results, in the order of [`DISTANCES`].
    pub medians: [f64; 4],
    /// Medians of the distances between the reference's own results.
    pub scatter: [f64; 4],
    /// Shares of the pairs that are within the scatter of the reference, per distance.
    pub within: [f64; 4],
    /// Share of the pairs that are within it in all distances together.
    pub within_all: f64,
    /// The same share of the reference's own pairs.
    pub own_within_all: f64,
    /// Number of pairs.
    pub pairs: usize,
}

impl OutcomePoint {
    /// JSON document of the point.
    pub fn document(&self) -> Value {
        let each = |values: &[f64; 4]| {
            let rows = DISTANCES.iter().zip(values).map(|(name, value)| ((*name).to_owned(), json!(value)));
            Value::Object(rows.collect())
        };
        json!({
            "preset": self.preset,
            "median": each(&self.medians),
            "scatter_median": each(&self.scatter),
            "within_scatter": each(&self.within),
            "within_scatter_all": self.within_all,
            "reference_within_scatter_all": self.own_within_all,
            "pairs": self.pairs,
        })
    }
}

/// Judges whole results of the presets alone, on impacts of a plan.
///
/// # Errors
/// [`StudyError`] where an object cannot be made, or a request fails.
pub fn results(plan: &AccuracyPlan) -> Result<Vec<OutcomePoint>, StudyError> {
    let base = prepared(plan, request(plan)?, Preset::default())?;
    outcomes(plan, base.gamma_j_m2, &strikes(plan, &base)?, &mut |_| ())
}

/// Judges whole results of the plan's presets; calls `progress` once for each of them, and for the reference.
pub(super) fn outcomes(
    plan: &AccuracyPlan,
    gamma_j_m2: f64,
    strikes: &[FractureRequest],
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<OutcomePoint>, StudyError> {
    let bench = OutcomeBench { plan, strikes: &strikes[..strikes.len().min(plan.outcome_impacts)] };
    let mut reference = BakeRequest { gamma_j_m2: Some(gamma_j_m2), ..request(plan)? };
    let bake =
        |preset: &Preset| prepared(plan, BakeRequest { gamma_j_m2: Some(gamma_j_m2), ..request(plan)? }, *preset);
    let baked: Vec<PreparedObject> = plan.outcome_presets.par_iter().map(bake).collect::<Result<_, _>>()?;
    let mut found = Vec::new();
    for (preset, own) in plan.outcome_presets.iter().zip(baked) {
        progress(&format!("results of {}", preset.name()));
        let finer = |spacing: f64| Some(spacing * plan.outcome_finer.powf(-1.0 / 3.0));
        reference.elastic_spacing = finer(own.parameters.elastic_spacing);
        reference.crack_spacing = finer(own.parameters.crack_spacing);
        reference.kappa = Some(own.kappa);
        found.push((preset.name(), bench.results(&own, *preset, 0)?));
    }
    progress("results of the reference");
    // It optimizes every degree, so it needs no examples.
    reference.examples = 0;
    let reference = bench.reference(&prepared(plan, reference, Preset::Reference)?)?;
    Ok(found.into_iter().map(|(name, results)| OutcomePoint::new(name, &results, &reference)).collect())
}

/// Impacts with which all presets are judged.
struct OutcomeBench<'a> {
    plan: &'a AccuracyPlan,
    strikes: &'a [FractureRequest],
}

impl OutcomeBench<'_> {
    /// Results of the reference for every impact, one per seed.
    fn reference(&self, prepared: &PreparedObject) -> Result<Vec<Vec<Outcome>>, StudyError> {
        let seeds = (1..=self.plan.outcome_seeds).map(|seed| self.results(prepared, Preset::Reference, seed));
        let seeds: Vec<Vec<Outcome>> = seeds.collect::<Result<_, _>>()?;
        Ok((0..self.strikes.len()).map(|impact| seeds.iter().map(|own| own[impact].clone()).collect()).collect())
    }

    /// Result of every impact with the rules of a preset, and seeds of their own for every `seed`.
    ///
    /// Contact radii are the default, so each lattice widens them as it must.
    fn results(&self, prepared: &PreparedObject, preset: Preset, seed: u64) -> Result<Vec<Outcome>, StudyError> {
        let factors = spread(self.strikes.len());
        let result = |workspace: &mut Workspace, (strike, factor): (&FractureRequest, &f64)| {
            let mut strike = strike.clone().of_quality(preset);
            strike.seed += SEED_FIRST + seed * self.plan.impacts;
            strike.contacts[0].radius_m = None;
            strike.contacts[0].impulse_ns *= *factor;
            let token = CancelToken::default();
            let outcome = pipeline::strike(RequestContext::new(prepared, &strike, &token, &()), workspace)?;
            outcome.meshes().map_or_else(|| Ok(Outcome::whole(prepared)), |meshes| Outcome::of(prepared, meshes))
        };
        self.strikes.par_iter().zip(&factors).map_init(Workspace::default, result).collect()
    }
}

/// Object of a request on the lattices of a preset, with what the preset's requests need.
fn prepared(plan: &AccuracyPlan, request: BakeRequest, quality: Preset) -> Result<PreparedObject, StudyError> {
    let examples = request.examples > 0;
    let request = BakeRequest { quality, tables: Tables { examples, ..LIFTED }, ..request };
    let token = CancelToken::default();
    let mut prepared = bake(plan.mesh.clone(), &request, &token, &mut |_| {})?;
    if quality.solver_settings().elastic == DisplacementMethod::Reduced {
        prepared.impacts = plan.snapshots;
        reduce(&mut prepared, quality.lattices().rank_max, &token)?;
    }
    prepared.factor()?;
    Ok(prepared)
}

impl Outcome {
    /// An object that stays whole.
    fn whole(prepared: &PreparedObject) -> Self {
        let log_volumes = vec![(prepared.report.lattice_volume_m3).ln()];
        Self { log_volumes, crack_area_m2: 0.0, largest: Point3::origin() }
    }

    /// Figures of a result.
    fn of(prepared: &PreparedObject, meshes: &FractureMeshes) -> Result<Self, StudyError> {
        let emitted = meshes.emitted()?;
        let log_volumes = meshes.fragments.iter().map(|own| own.volume_m3.ln()).collect();
        let mut doubled = 0.0;
        for run in meshes.runs.iter().filter(|run| run.crack) {
            let first = meshes.fragments[run.fragment as usize].vertex_first;
            let indices = &emitted.indices[run.index_first as usize..][..run.index_count as usize];
            doubled += area(&emitted.positions[first as usize..], indices);
        }
        let largest = meshes.fragments.iter().max_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3));
        let largest = largest.ok_or(StudyError::Whole)?;
        let largest = prepared.frame.to_local(&Point3::from(largest.center_m));
        Ok(Self { log_volumes, crack_area_m2: 0.5 * doubled, largest })
    }

    /// Distances of two results of one request, in the order of [`DISTANCES`].
    ///
    /// The difference of the logarithms of the numbers of fragments; the Wasserstein-1 distance of the logarithms of
    /// their volumes; the difference of crack areas over their mean; and the distance between the centers of the largest
    /// fragments over the diagonal.
    fn distances(&self, other: &Self) -> [f64; 4] {
        let [own, wanted] = [self, other].map(|outcome| (outcome.log_volumes.len() as f64).ln());
        let [area, wanted_area] = [self, other].map(|outcome| outcome.crack_area_m2);
        let total = area + wanted_area;
        [
            (own - wanted).abs(),
            wasserstein(&self.log_volumes, &other.log_volumes),
            if total > 0.0 { 2.0 * (area - wanted_area).abs() / total } else { 0.0 },
            (self.largest - other.largest).norm(),
        ]
    }
}

/// Area of triangles, m².
fn area(positions: &[[f32; 3]], indices: &[u32]) -> f64 {
    let triangle = |corners: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| Vector3::from(positions[corners[k] as usize]).cast::<f64>());
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    indices.chunks_exact(3).map(triangle).sum()
}

impl OutcomePoint {
    /// Judges the results of a preset, one per impact, against those of the reference, several per impact.
    fn new(preset: &'static str, results: &[Outcome], reference: &[Vec<Outcome>]) -> Self {
        let own: Vec<[f64; 4]> = reference.iter().flat_map(|seeds| pairs(seeds)).collect();
        let against = |(result, seeds): (&Outcome, &Vec<Outcome>)| -> Vec<[f64; 4]> {
            seeds.iter().map(|other| result.distances(other)).collect()
        };
        let found: Vec<[f64; 4]> = results.iter().zip(reference).flat_map(against).collect();
        let at = |all: &[[f64; 4]], share| column(all, |values| quantile(values, share).unwrap_or(f64::NAN));
        let scatter_max = at(&own, SCATTER);
        let is_within = |pair: &[f64; 4]| (0..4).all(|k| pair[k] <= scatter_max[k]);
        let share = |all: &[[f64; 4]]| all.iter().filter(|pair| is_within(pair)).count() as f64 / all.len() as f64;
        Self {
            preset,
            medians: at(&found, 0.5),
            scatter: at(&own, 0.5),
            within: std::array::from_fn(|k| {
                found.iter().filter(|pair| pair[k] <= scatter_max[k]).count() as f64 / found.len() as f64
            }),
            within_all: share(&found),
            own_within_all: share(&own),
            pairs: found.len(),
        }
    }
}

/// Distances of all pairs of results.
fn pairs(results: &[Outcome]) -> impl Iterator<Item = [f64; 4]> + '_ {
    results.iter().enumerate().flat_map(|(k, own)| results[..k].iter().map(|other| own.distances(other)))
}

/// A figure of every column.
fn column(rows: &[[f64; 4]], figure: impl Fn(&[f64]) -> f64) -> [f64; 4] {
    std::array::from_fn(|k| figure(&rows.iter().map(|row| row[k]).collect::<Vec<_>>()))
}

/// Section of the page; none without points.
pub(super) fn section(points: &[OutcomePoint]) -> Option<Section> {
    let lead = "Whole results against those of a reference with finer lattices: medians of the distances, and in brackets those \
                between results of the reference with other seeds. Within: share of the pairs that no distance tells from the \
                reference, at 95 % of its own scatter; the last column is that share of its own pairs.";
    let head =
        ["preset", "degree", "volumes", "crack area", "place of the largest", "within, %", "of the reference, %"];
    let row = |own: &OutcomePoint| {
        let distance = |k: usize| format!("{} ({})", significant(own.medians[k], 2), significant(own.scatter[k], 2));
        let shares = [own.within_all, own.own_within_all].map(|share| significant(100.0 * share, 3));
        ("", [own.preset.to_owned()].into_iter().chain((0..4).map(distance)).chain(shares).collect())
    };
    let tables = vec![ReportTable { head: head.map(str::to_owned).to_vec(), rows: points.iter().map(row).collect() }];
    let heading = "Whole results, end to end".to_owned();
    (!points.is_empty()).then(|| Section { heading, lead: vec![lead.to_owned()], tables, ..Section::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(volumes: &[f64], crack_area_m2: f64, x: f64) -> Outcome {
        let log_volumes = volumes.iter().map(|volume| volume.ln()).collect();
        Outcome { log_volumes, crack_area_m2, largest: Point3::new(x, 0.0, 0.0) }
    }

    #[test]
    fn distances_are_those_of_the_definition() {
        let own = outcome(&[1.0, 1.0], 3.0, 0.0);
        let other = outcome(&[2.0, 2.0, 2.0, 2.0], 1.0, 0.5);
        let log_2 = 2f64.ln();
        let expected = [log_2, log_2, 1.0, 0.5];
        assert!(own.distances(&other).iter().zip(expected).all(|(own, wanted)| (own - wanted).abs() < 1e-15));
        assert_eq!(own.distances(&own), [0.0; 4]);
        let whole = outcome(&[1.0], 0.0, 0.0);
        assert_eq!(whole.distances(&whole), [0.0; 4]);
    }

    #[test]
    fn a_preset_that_differs_more_than_seeds_is_told_from_the_reference() {
        let seeds =
            |x: f64| (0..4).map(|k| outcome(&[1.0, 1.0 + 0.1 * f64::from(k)], 1.0, x + 0.01 * f64::from(k))).collect();
        let reference: Vec<Vec<Outcome>> = vec![seeds(0.0), seeds(0.5)];
        let near: Vec<Outcome> = reference.iter().map(|own| own[1].clone()).collect();
        let far = vec![outcome(&[1.0, 8.0], 1.0, 0.4), outcome(&[1.0, 8.0], 1.0, 0.9)];
        let [near, far] = [near, far].map(|results| OutcomePoint::new("game", &results, &reference));
        assert!(near.within_all > 0.9 && near.own_within_all > 0.9 && near.pairs == 8, "{near:?}");
        assert_eq!((far.within_all, far.within[0], far.within[1], far.within[3]), (0.0, 1.0, 0.0, 0.0), "{far:?}");
    }
}
