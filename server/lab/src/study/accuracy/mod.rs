//! Accuracy against time: every solver setting over its values, errors against a reference, times of whole requests.

mod all_bodies;
mod bodies;
mod close_up;
mod error;
mod front;
mod lifts;
mod outcomes;
mod page;
mod plan;
mod point;
mod presets;
mod reference;
mod settings;
mod subject;
mod tessellations;
mod truth;

pub use all_bodies::AllBodiesPoint;
pub use bodies::BodyPoint;
pub use close_up::CloseUp;
pub use error::StudyError;
pub use front::{PresetStanding, preset_standings};
pub use outcomes::{DISTANCES, OutcomePoint, results};
pub use page::{AccuracyDrawing, drawn, page};
pub use plan::{AccuracyPlan, IMPACTS_DEFAULT, StudyBody};
pub use point::{ErrorSpread, Measure, PointErrors, PointTimes, StudyPoint};

use reference::ElasticReference;
use serde_json::{Value, json};
use settings::Bench;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::bake;
use shatter_fracture::pipeline::{RANK_MAX, reduce};
use std::rc::Rc;
use truth::Truths;

/// Object and reference of the study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyGround {
    /// Name of the object.
    pub object: String,
    /// Number of triangles of the input.
    pub triangles: usize,
    /// Numbers of nodes of the object's lattices, elastic and crack.
    pub nodes: [usize; 2],
    /// Number of crack nodes of the reference of cells and cracks.
    pub reference_nodes: usize,
    /// Dimension of the lift.
    pub dimension: usize,
    /// Number of impacts, and of timed requests per impact.
    pub strikes: [usize; 2],
    /// Number of sites.
    pub sites: u32,
    /// Name of the processor.
    pub machine: String,
    /// Number of worker threads.
    pub threads: usize,
}

/// Results of the study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AccuracyFindings {
    /// Object and reference.
    pub ground: StudyGround,
    /// Measured points.
    pub points: Vec<StudyPoint>,
    /// Elastic energies of the presets on several bodies.
    pub bodies: Vec<BodyPoint>,
    /// Whole results of the presets on the object.
    pub outcomes: Vec<OutcomePoint>,
    /// Omitted points, with reasons.
    pub left_out: Vec<[String; 2]>,
    /// Pairs of estimated and true error of reduced energies, one per request.
    pub estimates: Vec<[f64; 2]>,
    /// Close-up of the same impact on the lattices of the presets.
    pub close_up: CloseUp,
}

impl AccuracyFindings {
    /// JSON document of all results.
    pub fn document(&self) -> Value {
        let ground = &self.ground;
        json!({
            "object": ground.object,
            "triangles": ground.triangles,
            "elastic_nodes": ground.nodes[0],
            "crack_nodes": ground.nodes[1],
            "reference_crack_nodes": ground.reference_nodes,
            "dimension": ground.dimension,
            "impacts": ground.strikes[0],
            "runs": ground.strikes[1],
            "sites": ground.sites,
            "machine": ground.machine,
            "threads": ground.threads,
            "points": self.points.iter().map(StudyPoint::document).collect::<Vec<_>>(),
            "bodies": self.bodies.iter().map(BodyPoint::document).collect::<Vec<_>>(),
            "all_bodies": AllBodiesPoint::all(&self.bodies).iter().map(AllBodiesPoint::document).collect::<Vec<_>>(),
            "outcomes": self.outcomes.iter().map(OutcomePoint::document).collect::<Vec<_>>(),
            "front": preset_standings(self).iter().map(PresetStanding::document).collect::<Vec<_>>(),
            "estimates": self.estimates.len(),
            "estimates_within_4": self.estimates_within(4.0),
            "left_out": self.left_out.iter().map(|[what, why]| json!({ "what": what, "why": why })).collect::<Vec<_>>(),
        })
    }

    /// Share of the estimates within this factor of the true error; `None` without estimates.
    pub fn estimates_within(&self, factor: f64) -> Option<f64> {
        let holds = |[estimate, error]: &&[f64; 2]| (error / factor..=error * factor).contains(estimate);
        let count = self.estimates.iter().filter(holds).count();
        (!self.estimates.is_empty()).then(|| count as f64 / self.estimates.len() as f64)
    }
}

/// Runs the whole study; calls `progress` for each of [`AccuracyPlan::steps`].
///
/// # Errors
/// [`StudyError`] where the object or its reference cannot be made, and [`StudyError::CoarseReference`] for any lattice
/// with a reference that is no finer; a setting that fails otherwise is left out, and named.
pub fn run(plan: &AccuracyPlan, progress: &mut dyn FnMut(&str)) -> Result<AccuracyFindings, StudyError> {
    progress("the object");
    let token = CancelToken::default();
    let mut base = bake(plan.mesh.clone(), &subject::request(plan)?, &token, &mut |_| {})?;
    // A basis needs more impacts than the degree, and they are cheaper.
    base.impacts = plan.snapshots.max(plan.examples);
    reduce(&mut base, RANK_MAX, &token)?;
    base.factor()?;
    progress("impacts");
    let strikes = subject::widened(plan, &base, subject::strikes(plan, &base)?)?;
    progress("the reference");
    let references = vec![Rc::new(ElasticReference::new(plan, &base, &base, &strikes)?)];
    let truths = Truths::new(plan, &base, &strikes)?;
    let ground = StudyGround {
        object: plan.name.clone(),
        triangles: plan.mesh.triangles.len(),
        nodes: [base.elastic_nodes(), base.crack_nodes()],
        reference_nodes: truths.fine.crack_nodes(),
        dimension: base.bodies.iter().filter_map(|body| Some(body.interior.as_ref()?.dimension)).max().unwrap_or(0),
        strikes: [strikes.len(), plan.runs],
        sites: plan.sites,
        machine: machine(),
        threads: rayon::current_num_threads(),
    };
    let findings = AccuracyFindings { ground, ..AccuracyFindings::default() };
    let mut bench = Bench { plan, base, strikes, truths, references, refused: None, findings, progress };
    bench.elastic_spacings();
    bench.ranks();
    bench.precisions();
    bench.tolerances();
    bench.degrees();
    bench.lifts();
    bench.crack_spacings();
    bench.tessellations();
    bench.presets();
    bench.whole_results();
    bench.bodies();
    match bench.refused {
        Some(error) => Err(error),
        None => Ok(bench.findings),
    }
}

/// Name of the processor, if the system reports it.
fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name =
        text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim()));
    name.unwrap_or(std::env::consts::ARCH).to_owned()
}
