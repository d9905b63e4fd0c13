//! Time of a request by stage: whole requests with emission, in turn over impacts on all parts of the object. `cargo bench --bench parts`
//! bakes a generated statue with examples; `SHATTER_BENCH_DATABASE` names a database to use instead.

use nalgebra::Point3;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{bake, load};
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureRequest, PreparedObject, Stage, StageObserver, Workspace,
};
use shatter_fracture::scene::EffectKind;
use shatter_fracture::surface::shapes;
use shatter_tests::real;
use std::cell::Cell;
use std::time::Instant;

const SITES: u32 = 50;
const IMPACTS: usize = 16;
const ROUNDS: usize = 12;

/// Milliseconds by stage of one request.
#[derive(Default)]
struct Clock {
    spent_ms: Cell<[f64; Stage::ALL.len()]>,
    begun: Cell<Option<Instant>>,
}

impl StageObserver for Clock {
    fn enter(&self, _: Stage) {
        self.begun.set(Some(Instant::now()));
    }

    fn leave(&self, stage: Stage, _: u64) {
        let mut spent_ms = self.spent_ms.get();
        spent_ms[stage as usize] += self.begun.take().map_or(0.0, |begun| begun.elapsed().as_secs_f64() * 1e3);
        self.spent_ms.set(spent_ms);
    }

    fn begin(&self, _: EffectKind) {}
    fn end(&self, _: EffectKind, _: u64) {}
    fn part(&self, _: EffectKind, _: u64) {}
}

fn prepared() -> PreparedObject {
    match std::env::var_os("SHATTER_BENCH_DATABASE") {
        Some(path) => load(path.as_ref()).unwrap(),
        None => {
            bake(shapes::statue(), &real::request("statue", "ceramic"), &CancelToken::default(), &mut |_| ()).unwrap()
        }
    }
}

/// Impacts on nodes of the surface, inwards.
fn requests(prepared: &PreparedObject) -> Vec<FractureRequest> {
    let body = &prepared.bodies[0];
    let nodes = &body.topology.boundary_nodes;
    let center =
        body.crack.nodes.iter().map(|node| node.coords).sum::<nalgebra::Vector3<f64>>() / body.crack.nodes.len() as f64;
    let strike = |impact: usize| {
        let node = nodes[(2 * impact + 1) * nodes.len() / (2 * IMPACTS)];
        let point: Point3<f64> = body.crack.nodes[node as usize];
        let request = FractureRequest::at(prepared.frame.to_meters(&point), center - point.coords).seeded(1);
        FractureRequest { degree: DegreeRequest::Sites(SITES), seed: impact as u64, ..request }
    };
    (0..IMPACTS).map(strike).collect()
}

fn main() {
    // `cargo test` may run benches to test that they start.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    // Runs on a thread of the pool, as in the daemon: another thread would pay for waking a pool thread each time.
    rayon::scope(|_| parts());
}

fn parts() {
    let prepared = prepared();
    println!(
        "{}: {} elastic nodes, {} crack nodes, {SITES} sites",
        prepared.name,
        prepared.elastic_nodes(),
        prepared.crack_nodes()
    );
    let (strikes, token, mut workspace) = (requests(&prepared), CancelToken::default(), Workspace::default());
    let (mut stages, mut totals, mut emitted) = (vec![Vec::new(); Stage::ALL.len()], Vec::new(), Vec::new());
    let (mut positions, mut indices, mut merges) = (Vec::new(), Vec::new(), Vec::new());
    for round in 0..=ROUNDS {
        for strike in &strikes {
            let clock = Clock::default();
            let begun = Instant::now();
            let outcome =
                pipeline::strike(pipeline::RequestContext::new(&prepared, strike, &token, &clock), &mut workspace)
                    .unwrap();
            let pieces = outcome.into_meshes().unwrap();
            let emission = Instant::now();
            positions.resize(pieces.counts.vertices, [0.0; 3]);
            indices.resize(pieces.counts.indices, 0);
            merges.resize(pieces.counts.merges, [0; 2]);
            pieces.emit(&mut positions, &mut indices, &mut merges).unwrap();
            drop(pieces);
            if round > 0 {
                emitted.push(emission.elapsed().as_secs_f64() * 1e3);
                totals.push(begun.elapsed().as_secs_f64() * 1e3);
                stages.iter_mut().zip(clock.spent_ms.get()).for_each(|(all, own)| all.push(own));
            }
        }
    }
    let reported = |name: &str, values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        println!("{name:14} least {:7.3}  p50 {:7.3}  p99 {:7.3} ms", values[0], at(0.5), at(0.99));
    };
    Stage::ALL.iter().zip(&mut stages).for_each(|(stage, all)| reported(stage.name(), all));
    reported("emission", &mut emitted);
    reported("whole", &mut totals);
}
