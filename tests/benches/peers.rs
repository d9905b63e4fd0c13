//! A request beside the exact-boolean method, on the same mesh and with the same number of sites, in one run: `cargo bench --bench peers`.
//!
//! Ours is a request of the preset `game` in this process, on the input surface, result written out, in the interior lift and with straight distances. Theirs is
//! `tests/peers/booleans.py`, every Euclidean Voronoi cell intersected with the mesh, if Python has `manifold3d`. They take turns.
//! `SHATTER_BENCH_MESH` names a mesh instead of a generated statue of about 100,000 triangles, `SHATTER_BENCH_DATABASE` a database of that
//! mesh, `SHATTER_BENCH_EXAMPLES` the number of impacts to learn from (100) without a database, `SHATTER_PYTHON` the interpreter.

use serde::Deserialize;
use serde_json::json;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, load};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{FractureRequest, PreparedObject, SurfaceKind};
use shatter_fracture::surface::RawMesh;
use shatter_fracture::tessellation::components;
use shatter_tests::statistics::median;
use shatter_tests::timed::{self, Stopwatch, Timed};
use shatter_tests::{real, struck};
use std::ffi::OsString;
use std::process::Command;

const SITES: u32 = 50;
const IMPACTS: usize = 16;
/// Turns of theirs, each between two of ours, and each with the sites of another impact.
const TURNS: usize = 5;
/// Requests of ours with each impact in one turn.
const ROUNDS: usize = 3;
/// Runs of theirs in one turn.
const RUNS: usize = 3;
const LIFTS: [LiftKind; 2] = [LiftKind::Interior, LiftKind::Euclidean];

fn prepared(mesh: RawMesh) -> PreparedObject {
    if let Some(path) = std::env::var_os("SHATTER_BENCH_DATABASE") {
        return load(path.as_ref()).unwrap();
    }
    let examples = std::env::var("SHATTER_BENCH_EXAMPLES").map_or(100, |text| text.parse().unwrap());
    let request = BakeRequest { examples, surface: SurfaceKind::Exact, ..real::request("peers", "ceramic") };
    bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

/// Output of the script for one turn.
#[derive(Deserialize)]
struct Booleans {
    times_ms: Vec<f64>,
    /// Processor time over wall time.
    cores: f64,
    fragments: usize,
    triangles: usize,
    several: usize,
    volume_error: f64,
}

/// The interpreter, if it has the modules that the script needs.
fn python() -> Option<OsString> {
    let python = std::env::var_os("SHATTER_PYTHON").unwrap_or_else(|| "python3".into());
    let tried = Command::new(&python).args(["-c", "import manifold3d, numpy"]).output();
    if tried.is_ok_and(|tried| tried.status.success()) {
        return Some(python);
    }
    println!("no exact booleans: {} has no manifold3d (pip install manifold3d numpy)", python.display());
    None
}

/// Runs theirs with the sites of `strike`; `None`, after a line with the reason, if it cannot run.
fn booleans(
    python: &OsString,
    mesh: &RawMesh,
    prepared: &PreparedObject,
    strike: &FractureRequest,
) -> Option<Booleans> {
    let energy = struck::energy(prepared, strike);
    let diagram = struck::diagram(prepared, strike.lift, &energy.shares, SITES as usize, strike.seed);
    let body = &prepared.bodies[0];
    let place = |node: u32| prepared.frame.to_meters(&body.crack.nodes[node as usize]);
    let nodes = diagram.site_nodes(body.lift(strike.lift).unwrap());
    let sites: Vec<[f64; 3]> = nodes.into_iter().map(|node| place(node).coords.into()).collect();
    let positions: Vec<[f64; 3]> = mesh.positions_m.iter().map(|point| point.coords.into()).collect();
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("input.json");
    let given = json!({ "positions": positions, "triangles": mesh.triangles, "sites": sites });
    std::fs::write(&input, given.to_string()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/booleans.py");
    let output = Command::new(python).arg(script).arg(&input).arg(RUNS.to_string()).output().unwrap();
    let reported = String::from_utf8_lossy(&output.stdout);
    let read = serde_json::from_str(&reported).ok();
    if read.is_none() {
        println!("no exact booleans: {reported}{}", String::from_utf8_lossy(&output.stderr));
    }
    read
}

/// Number of cells that fall into several parts, which become fragments of their own.
fn several(prepared: &PreparedObject, strike: &FractureRequest) -> f64 {
    let energy = struck::energy(prepared, strike);
    let diagram = struck::diagram(prepared, strike.lift, &energy.shares, SITES as usize, strike.seed);
    let split = components(&prepared.bodies[0].topology, &diagram.labels);
    split.sites.chunk_by(|a, b| a == b).filter(|pieces| pieces.len() > 1).count() as f64
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// One line of the table.
struct Row {
    route: &'static str,
    /// Times by impact, ms.
    times_ms: Vec<Vec<f64>>,
    fragments: f64,
    triangles: f64,
    several: f64,
    volume_error: f64,
    deviation: f64,
}

impl Row {
    fn p50_ms(&self) -> f64 {
        median(&self.times_ms.concat())
    }

    /// Median over impacts of the fastest request with each: other work on the machine affects it less.
    fn fastest_ms(&self) -> f64 {
        let fastest = |times: &Vec<f64>| times.iter().copied().fold(f64::INFINITY, f64::min);
        median(&self.times_ms.iter().map(fastest).collect::<Vec<_>>())
    }
}

fn reported(row: &Row, ours: &Row) {
    let [p50_ms, fastest_ms] = [row.p50_ms(), row.fastest_ms()];
    println!(
        "{:15} {p50_ms:9.2} {:8.1} {fastest_ms:11.2} {:8.1} {:9.0} {:9.0} {:8.1} {:+10.3} {:10.3}",
        row.route,
        p50_ms / ours.p50_ms(),
        fastest_ms / ours.fastest_ms(),
        row.fragments,
        row.triangles,
        row.several,
        100.0 * row.volume_error,
        100.0 * row.deviation,
    );
}

/// Requests of one lift.
struct Ours {
    strikes: Vec<FractureRequest>,
    timed: Vec<Timed>,
    /// Index of the first time of each turn.
    turns: Vec<usize>,
}

impl Ours {
    fn new(prepared: &PreparedObject, lift: LiftKind) -> Self {
        let of_lift = |strike| FractureRequest { lift, ..strike };
        let strikes = timed::impacts(prepared, IMPACTS, SITES).into_iter().map(of_lift).collect();
        Self { strikes, timed: Vec::new(), turns: Vec::new() }
    }

    fn turn(&mut self, prepared: &PreparedObject, stopwatch: &mut Stopwatch) {
        self.turns.push(self.timed.len());
        for _ in 0..ROUNDS {
            self.timed.extend(self.strikes.iter().map(|strike| stopwatch.strike(prepared, strike).unwrap()));
        }
    }

    fn of(&self, value: impl Fn(&Timed) -> f64) -> Vec<f64> {
        self.timed.iter().map(value).collect()
    }

    /// Median of the turns before and after turn `turn` of theirs, ms.
    fn around_ms(&self, turn: usize) -> f64 {
        let end = self.turns.get(turn + 2).copied().unwrap_or(self.timed.len());
        median(&self.of(|timed| timed.time_ms)[self.turns[turn]..end])
    }

    fn row(&self, route: &'static str, prepared: &PreparedObject) -> Row {
        let times_ms =
            |impact: usize| self.timed.iter().skip(impact).step_by(IMPACTS).map(|timed| timed.time_ms).collect();
        let volume_m3 = median(&self.of(|timed| timed.volume_m3));
        Row {
            route,
            times_ms: (0..IMPACTS).map(times_ms).collect(),
            fragments: median(&self.of(|timed| timed.fragments as f64)),
            triangles: median(&self.of(|timed| timed.triangles as f64)),
            several: mean(self.strikes.iter().map(|strike| several(prepared, strike))),
            volume_error: volume_m3 / prepared.report.input_volume_m3 - 1.0,
            deviation: prepared.report.surface_deviation,
        }
    }
}

/// Row of theirs, which cut the mesh itself.
fn their_row(all: &[Booleans]) -> Row {
    let of = |value: fn(&Booleans) -> f64| median(&all.iter().map(value).collect::<Vec<_>>());
    Row {
        route: "exact booleans",
        times_ms: all.iter().map(|own| own.times_ms.clone()).collect(),
        fragments: of(|own| own.fragments as f64),
        triangles: of(|own| own.triangles as f64),
        several: mean(all.iter().map(|own| own.several as f64)),
        volume_error: of(|own| own.volume_error),
        deviation: 0.0,
    }
}

fn main() {
    if timed::only_begin() {
        return;
    }
    let mesh = timed::mesh();
    let prepared = prepared(mesh.clone());
    assert_eq!(prepared.bodies.len(), 1, "one body: sites are counted per body");
    prepared.factor().unwrap();
    println!(
        "{} triangles, {} elastic nodes, {} crack nodes, {SITES} sites, {} threads",
        mesh.triangles.len(),
        prepared.elastic_nodes(),
        prepared.crack_nodes(),
        rayon::current_num_threads(),
    );
    let (python, mut stopwatch) = (python(), Stopwatch::default());
    let mut ours = LIFTS.map(|lift| Ours::new(&prepared, lift));
    // Buffers grow in this turn.
    ours.iter_mut().for_each(|own| own.turn(&prepared, &mut stopwatch));
    ours.iter_mut().for_each(|own| (own.timed, own.turns) = (Vec::new(), Vec::new()));
    let mut theirs = Vec::new();
    for turn in 0..=TURNS {
        ours.iter_mut().for_each(|own| own.turn(&prepared, &mut stopwatch));
        let python = python.as_ref().filter(|_| turn < TURNS && theirs.len() == turn);
        theirs.extend(python.and_then(|python| booleans(python, &mesh, &prepared, &ours[0].strikes[turn])));
    }
    println!(
        "route              p50 ms    ratio  fastest ms    ratio fragments triangles  several   volume %  surface %"
    );
    let [interior, euclidean] =
        [("game", &ours[0]), ("game, straight", &ours[1])].map(|(name, own)| own.row(name, &prepared));
    reported(&interior, &interior);
    reported(&euclidean, &interior);
    if !theirs.is_empty() {
        reported(&their_row(&theirs), &interior);
        let ratios: Vec<f64> =
            theirs.iter().enumerate().map(|(turn, own)| median(&own.times_ms) / ours[0].around_ms(turn)).collect();
        let [low, high] = [f64::min, f64::max].map(|best| ratios.iter().copied().reduce(best).unwrap());
        let cores = median(&theirs.iter().map(|own| own.cores).collect::<Vec<_>>());
        println!("exact booleans over game, turn by turn: {low:.0} to {high:.0}, theirs on {cores:.2} cores");
    }
    let solved = ours[0].timed.iter().filter(|timed| timed.solved).count();
    println!("{solved} of {} strikes were solved for, not reduced", ours[0].timed.len());
    println!(
        "several: cells in several pieces, mean; ours become fragments of their own. surface: largest deviation over the diagonal"
    );
}
