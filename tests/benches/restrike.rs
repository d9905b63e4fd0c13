//! Cost of striking a fragment of a result, compared with striking the object, on one thread: generated shapes at the default spacings,
//! with 24 sites each time. The largest and a middling fragment of the first result are struck at their highest point. `cargo bench --bench
//! again`.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureMeshes, FractureOutcome, FractureRequest, PreparedObject, RequestContext,
    RetainedFragments, Stage, StageObserver, Workspace, strike_again,
};
use shatter_fracture::scene::{EffectKind, EffectSet};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::{real, statistics};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::time::Instant;

const ROUNDS: usize = 5;

/// Milliseconds by stage; the time of effects is included in their stages.
#[derive(Default)]
struct Times {
    since: Cell<Option<Instant>>,
    begun: Cell<Option<Instant>>,
    stages: RefCell<BTreeMap<&'static str, f64>>,
}

impl StageObserver for Times {
    fn enter(&self, _: Stage) {
        self.since.set(Some(Instant::now()));
    }

    fn leave(&self, stage: Stage, _: u64) {
        *self.stages.borrow_mut().entry(stage.name()).or_default() += ms_since(self.since.take());
    }

    fn begin(&self, _: EffectKind) {
        self.begun.set(Some(Instant::now()));
    }

    fn end(&self, effect: EffectKind, _: u64) {
        *self.stages.borrow_mut().entry(effect.name()).or_default() += ms_since(self.begun.take());
    }

    fn part(&self, _: EffectKind, _: u64) {}
}

fn ms_since(since: Option<Instant>) -> f64 {
    since.map_or(0.0, |since| since.elapsed().as_secs_f64() * 1e3)
}

/// Median milliseconds of some rounds, and the stages of the last.
fn timed(mut work: impl FnMut(&Times) -> FractureOutcome) -> (f64, Times, FractureOutcome) {
    let mut rounds = Vec::new();
    loop {
        let (times, begun) = (Times::default(), Instant::now());
        let outcome = work(&times);
        rounds.push(begun.elapsed().as_secs_f64() * 1e3);
        if rounds.len() == ROUNDS {
            return (statistics::median(&rounds), times, outcome);
        }
    }
}

/// An impact from above on the highest of some points.
fn contacts_request(points: impl Iterator<Item = Point3<f64>>, effects: EffectSet) -> FractureRequest {
    let highest = points.max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
    FractureRequest {
        degree: DegreeRequest::Sites(24),
        effects,
        ..FractureRequest::at(highest, -Vector3::y()).seeded(1)
    }
}

/// Vertices of a fragment in the coordinates of the mesh file.
fn points(pieces: &FractureMeshes, fragment: u32) -> Vec<Point3<f64>> {
    let counts = pieces.counts;
    let mut positions = vec![[0.0; 3]; counts.vertices];
    pieces.emit(&mut positions, &mut vec![0; counts.indices], &mut vec![[0; 2]; counts.merges]).unwrap();
    let row = &pieces.fragments[fragment as usize];
    let own = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
    own.iter().map(|at| Point3::from(at.map(f64::from)) + Vector3::from(row.center_m)).collect()
}

fn show(what: &str, ms: f64, times: &Times) {
    let stages: Vec<String> = times.stages.borrow().iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
    println!("  {what}: {ms:.1} ms ({})", stages.join(", "));
}

fn again(
    prepared: &PreparedObject,
    kept: &RetainedFragments,
    pieces: &FractureMeshes,
    fragment: u32,
    workspace: &mut Workspace,
) {
    for (name, effects) in
        [("elastic", EffectSet::default()), ("falloff", EffectSet::default().without(EffectKind::Elastic))]
    {
        let strike = contacts_request(points(pieces, fragment).into_iter(), effects);
        let (ms, times, outcome) = timed(|times| {
            strike_again(
                RequestContext::new(prepared, &strike, &CancelToken::default(), times),
                (kept, fragment),
                workspace,
            )
            .unwrap()
        });
        let children = outcome.into_meshes().unwrap();
        let parent = &pieces.fragments[fragment as usize];
        let sum: f64 = children.fragments.iter().map(|row| row.volume_m3).sum();
        let share = 100.0 * parent.volume_m3 / pieces.fragments.iter().map(|row| row.volume_m3).sum::<f64>();
        let what = format!(
            "again, {name}: {share:.0} % of the volume, {} children, volumes off by {:.0e}",
            children.fragments.len(),
            sum / parent.volume_m3 - 1.0
        );
        show(&what, ms, &times);
    }
}

fn measure(name: &str, mesh: RawMesh) {
    let top = mesh.positions_m.clone();
    let request = BakeRequest { kappa: Some(2.0), ..real::request(name, "ceramic") };
    let prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
    prepared.factor().unwrap();
    println!("{name}: {} crack nodes, {} elastic nodes", prepared.crack_nodes(), prepared.elastic_nodes());
    let mut workspace = Workspace::default();
    for sites in [4, 24] {
        let mut strike = contacts_request(top.iter().copied(), EffectSet::default());
        strike.degree = DegreeRequest::Sites(sites);
        let (ms, times, outcome) = timed(|times| {
            pipeline::strike(
                pipeline::RequestContext::new(&prepared, &strike, &CancelToken::default(), times),
                &mut workspace,
            )
            .unwrap()
        });
        show(&format!("first, {sites} sites"), ms, &times);
        let pieces = outcome.into_meshes().unwrap();
        let begun = Instant::now();
        let kept = pieces.keep();
        println!("  kept: {} bytes, {:.2} ms", kept.bytes(), begun.elapsed().as_secs_f64() * 1e3);
        let mut order: Vec<&pipeline::FragmentRow> = pieces.fragments.iter().collect();
        order.sort_by(|a, b| b.volume_m3.total_cmp(&a.volume_m3));
        for row in [order[0], order[order.len() / 2]] {
            again(&prepared, &kept, &pieces, row.id, &mut workspace);
        }
    }
}

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        measure("horseshoe", shapes::horseshoe());
        measure("mug", shapes::mug());
        measure("bar", shapes::cuboid([0.4, 0.2, 0.2]));
    });
}
