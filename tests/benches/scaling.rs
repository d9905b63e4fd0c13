//! Growth of the time of a request of the preset `game`: with crack tetrahedra, with fragments, and with input triangles, which should not
//! matter once an object is baked. `cargo bench --bench scaling`; `SHATTER_BENCH_OUT` names a folder for pictures and their numbers.
//!
//! A time is the median over impacts of the fastest of several requests with each, objects and numbers in turn.

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::lattice::CRACK_NODES_DEFAULT;
use shatter_fracture::pipeline::{FractureRequest, PreparedObject, RANK_MAX, reduce};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_lab::study::plot::{self, Axes, PlotLine, PlotMark};
use shatter_tests::real;
use shatter_tests::statistics::{median, power_law};
use shatter_tests::timed::{self, Stopwatch, Timed};
use std::path::Path;

/// Approximate numbers of crack nodes of the lattices.
const NODES: [usize; 5] = [4_000, 8_000, 16_000, 32_000, 64_000];
const SITES: [u32; 6] = [10, 20, 40, 80, 160, 320];
/// Sides of the cubes for the mesh of the statue, m: 27, 54, 100 and 270 thousand triangles.
const GRIDS_M: [f64; 4] = [0.0106, 0.0075, 0.00552, 0.00335];
const SITES_DEFAULT: u32 = 50;
const IMPACTS: usize = 16;
const ROUNDS: usize = 6;
/// Number of impacts for the reduced bases.
const LEARNED: u64 = 100;

/// The statue with this crack spacing over its diagonal, prepared for requests without a solve.
fn prepared(mesh: RawMesh, elastic_spacing: Option<f64>, crack_spacing: Option<f64>) -> PreparedObject {
    let tables = Tables { elastic: true, interior: true, ..Tables::NONE };
    let request = real::request("scaling", "ceramic");
    let request = BakeRequest { elastic_spacing, crack_spacing, tables, kappa: Some(1.0), ..request };
    let mut prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
    prepared.impacts = LEARNED;
    reduce(&mut prepared, RANK_MAX, &CancelToken::default()).unwrap();
    prepared
}

/// An object, and its impacts.
struct Case<'a> {
    prepared: &'a PreparedObject,
    strikes: Vec<FractureRequest>,
    fastest: Vec<Timed>,
}

impl<'a> Case<'a> {
    fn new(prepared: &'a PreparedObject, sites: u32) -> Self {
        Self { prepared, strikes: timed::impacts(prepared, IMPACTS, sites), fastest: Vec::new() }
    }

    fn round(&mut self, stopwatch: &mut Stopwatch) {
        let timed: Vec<Timed> =
            self.strikes.iter().map(|strike| stopwatch.strike(self.prepared, strike).unwrap()).collect();
        self.fastest.resize(timed.len(), Timed { time_ms: f64::INFINITY, ..Timed::default() });
        let faster = self.fastest.iter_mut().zip(timed).filter(|(best, own)| own.time_ms < best.time_ms);
        faster.for_each(|(best, own)| *best = own);
    }

    /// Median of a value over the impacts.
    fn of(&self, value: impl Fn(&Timed) -> f64) -> f64 {
        median(&self.fastest.iter().map(value).collect::<Vec<_>>())
    }
}

/// Quantity that the time is measured against.
struct Study {
    file: &'static str,
    over: &'static str,
    bound: &'static str,
}

/// Strikes all `cases`, prints their times over the `x` of each, prints the exponent beside its bound, and draws them.
fn measure(study: &Study, mut cases: Vec<Case>, x: impl Fn(usize, &Case) -> f64) {
    let mut stopwatch = Stopwatch::default();
    for _ in 0..ROUNDS {
        cases.iter_mut().for_each(|case| case.round(&mut stopwatch));
    }
    let points: Vec<(f64, f64)> =
        cases.iter().enumerate().map(|(place, case)| (x(place, case), case.of(|timed| timed.time_ms))).collect();
    println!("{:>18}  time (ms)  crack nodes  fragments  triangles out  solved", study.over);
    for (case, (x, time_ms)) in cases.iter().zip(&points) {
        println!(
            "{x:18.0} {time_ms:10.3} {:12} {:10.0} {:14.0} {:4}/{IMPACTS}",
            case.prepared.crack_nodes(),
            case.of(|timed| timed.fragments as f64),
            case.of(|timed| timed.triangles as f64),
            case.fastest.iter().filter(|timed| timed.solved).count(),
        );
    }
    let law = power_law(&points);
    let steepest = points.windows(2).map(|pair| power_law(pair)[0]).fold(f64::NEG_INFINITY, f64::max);
    let Study { over, bound, .. } = study;
    println!("exponent over {over}: {:.2} (bound: {bound}), between neighbors at most {steepest:.2}\n", law[0]);
    if let Some(folder) = std::env::var_os("SHATTER_BENCH_OUT") {
        write(study, &points, law, folder.as_ref());
    }
}

fn write(study: &Study, points: &[(f64, f64)], [exponent, factor]: [f64; 2], folder: &Path) {
    let axes = Axes { x: study.over.into(), y: "time of a request, ms".into(), log_x: true, log_y: true };
    let fitted = points.iter().map(|&(x, _)| (x, factor * x.powf(exponent))).collect();
    let lines = [
        PlotLine { name: "measured".into(), points: points.to_vec(), mark: PlotMark::Both },
        PlotLine { name: format!("exponent {exponent:.2}"), points: fitted, mark: PlotMark::Line },
    ];
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join(format!("{}.svg", study.file)), plot::svg(&axes, &lines).unwrap()).unwrap();
    let rows: String = points.iter().map(|(x, time_ms)| format!("{x},{time_ms}\n")).collect();
    let table = format!("{},time_ms\n{rows}", study.file);
    std::fs::write(folder.join(format!("{}.csv", study.file)), table).unwrap();
}

fn main() {
    if timed::only_begin() {
        return;
    }
    let usual = prepared(shapes::statue(), None, None);
    let spacing = usual.parameters.crack_spacing;
    // An estimate: the study uses the actual numbers.
    let of_nodes = |nodes: usize| spacing * (CRACK_NODES_DEFAULT as f64 / nodes as f64).powf(1.0 / 2.7);
    let lattices = NODES.map(|nodes| prepared(shapes::statue(), None, Some(of_nodes(nodes))));
    let cases = lattices.iter().map(|own| Case::new(own, SITES_DEFAULT)).collect();
    let study = Study { file: "crack_tetrahedra", over: "crack tetrahedra", bound: "<= 1" };
    measure(&study, cases, |_, case| case.prepared.crack_tets() as f64);

    let cases = SITES.iter().map(|&sites| Case::new(&usual, sites)).collect();
    let study = Study { file: "fragments", over: "fragments", bound: "< 1" };
    measure(&study, cases, |_, case| case.of(|timed| timed.fragments as f64));

    let meshes = GRIDS_M.map(shapes::statue_on);
    let triangles = meshes.each_ref().map(|mesh| mesh.triangles.len() as f64);
    let baked = meshes.map(|mesh| prepared(mesh, Some(usual.parameters.elastic_spacing), Some(spacing)));
    let cases = baked.iter().map(|own| Case::new(own, SITES_DEFAULT)).collect();
    let study = Study { file: "input_triangles", over: "input triangles", bound: "about 0" };
    measure(&study, cases, |place, _| triangles[place]);
}
