//! Gain by threads in tessellation, compared with the gain that the machine allows: `cargo bench --bench threads`.
//!
//! The cells of a diagram on about 100,000 nodes become points, polygons and sections on 1 to all threads, each number in a pool of its
//! own. Two probes take turns with it: arithmetic, and sums over arrays, one per thread, too large for any cache. `SHATTER_BENCH_MESH`
//! names a mesh instead of a generated statue, whose lift has 19 waves; `SHATTER_BENCH_DATABASE` names a database instead.

use nalgebra::Point3;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, Diagram, DiagramOptions, EnergyField};
use shatter_fracture::database::{BakeRequest, Tables, bake, load};
use shatter_fracture::fragment::properties;
use shatter_fracture::lattice::Lattice;
use shatter_fracture::lift::{LiftKind, LiftedLattice};
use shatter_fracture::pipeline::{PreparedBody, PreparedObject, Preset};
use shatter_fracture::tessellation::{
    BisectorSites, Components, CrackPoints, FixedPoints, LocalToMeters, Tessellation, TessellationWorkspace, components,
};
use shatter_tests::real;
use shatter_tests::statistics::median;
use shatter_tests::timed::{self, since_ms};
use std::hint::black_box;
use std::time::Instant;

const SITES: usize = 50;
const DIMENSION: usize = 19;
const ROUNDS: usize = 20;
/// Turns of a round; the fastest counts, because buffers grow in the first.
const REPEATS: usize = 6;
/// Parts of a thread's share of a probe.
const PARTS: usize = 64;
/// Steps of a part.
const SPINS: u64 = 100_000;
/// Numbers of each thread's array: 64 MiB.
const NUMBERS: usize = 1 << 23;

fn prepared() -> PreparedObject {
    if let Some(path) = std::env::var_os("SHATTER_BENCH_DATABASE") {
        return load(path.as_ref()).unwrap();
    }
    let request = real::request("threads", "ceramic");
    let request = BakeRequest { quality: Preset::Film, tables: Tables::NONE, kappa: Some(1.0), ..request };
    bake(timed::mesh(), &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

/// A lift of the coordinates and of smooth functions of them, like an interior lift.
fn waves(lattice: &Lattice) -> LiftedLattice {
    let wave = |node: &Point3<f64>, k: usize| (9.0 * node[k % 3] + k as f64).sin() / (3 + k) as f64;
    let coordinate = |node: &Point3<f64>, k: usize| if k < 3 { node[k] } else { wave(node, k) };
    let coordinates = lattice.nodes.iter().flat_map(|node| (0..DIMENSION).map(|k| coordinate(node, k))).collect();
    LiftedLattice::scaled(LiftKind::Interior, lattice, DIMENSION, coordinates)
}

/// A diagram with uniform energy.
fn diagram(body: &PreparedBody, lift: &LiftedLattice) -> Diagram {
    let mut shares = body.volumes.clone();
    let field = EnergyField::new(lift, &body.volumes, &mut shares).unwrap().grouped(&body.clusters);
    let mut workspace = centroidal::DiagramWorkspace::default();
    centroidal::diagram(&field, &DiagramOptions::new(SITES, 1), &mut workspace, &CancelToken::default()).unwrap()
}

/// Input of the tessellation.
struct Work<'a> {
    body: &'a PreparedBody,
    lift: &'a LiftedLattice,
    diagram: Diagram,
    split: Components,
}

/// Output buffers of the tessellation.
#[derive(Default)]
struct Memory {
    points: CrackPoints,
    tessellation: Tessellation,
    workspace: TessellationWorkspace,
    centers: Vec<Point3<f64>>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    merges: Vec<[u32; 2]>,
}

impl Memory {
    /// Tessellates from labels to sections; returns the times of points, build and emit, ms. Buffers exist from the second call on.
    fn tessellate(&mut self, work: &Work) -> [f64; 3] {
        let (lattice, topology, labels) = (&work.body.crack, &work.body.topology, &work.split.labels);
        let sites = BisectorSites {
            lift: work.lift,
            coordinates: &work.diagram.sites,
            of_fragment: &work.split.sites,
            of_node: None,
        };
        let begun = Instant::now();
        self.points.find(lattice, topology, labels, Some(sites), &FixedPoints::default()).unwrap();
        let points_ms = since_ms(begun);
        let begun = Instant::now();
        self.tessellation.build(lattice, topology, labels, &self.points, &mut self.workspace).unwrap();
        let build_ms = since_ms(begun);
        self.make_room();
        let begun = Instant::now();
        let transform = LocalToMeters { meters_per_unit: 1.0 };
        let sections = (&mut self.positions, &mut self.indices, &mut self.merges);
        self.tessellation.emit(&self.centers, transform, sections.0, sections.1, sections.2).unwrap();
        [points_ms, build_ms, since_ms(begun)]
    }

    fn make_room(&mut self) {
        if self.centers.is_empty() {
            let mut measured = Vec::new();
            properties(&self.tessellation, &mut measured);
            self.centers = measured.iter().map(|own| own.center).collect();
        }
        self.positions.resize(self.tessellation.vertex_count(), [0.0; 3]);
        self.indices.resize(self.tessellation.index_count(), 0);
        self.merges.resize(self.tessellation.merge_count(), [0; 2]);
    }
}

/// Time of a fixed number of parts of arithmetic per thread, taken by idle threads, ms.
fn spin_ms() -> f64 {
    let begun = Instant::now();
    let step = |x: u64, _| (x ^ x >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let parts = (0..PARTS * rayon::current_num_threads()).into_par_iter().with_max_len(1);
    parts.for_each(|part| _ = black_box((0..SPINS).fold(black_box(part as u64 + 1), step)));
    since_ms(begun)
}

/// Time of a sum over one array per thread, in parts taken by idle threads, ms.
fn read_ms(arrays: &[Vec<u64>]) -> f64 {
    let begun = Instant::now();
    let parts = arrays[..rayon::current_num_threads()].par_iter().flat_map(|own| own.par_chunks(NUMBERS / PARTS));
    parts.for_each(|part| _ = black_box(part.iter().fold(0_u64, |sum, &own| sum.wrapping_add(own))));
    since_ms(begun)
}

/// Measured times, ms: points, build, emit, all three; arithmetic; reading.
type Times = [f64; 6];

/// Times on one number of threads.
struct Column {
    pool: ThreadPool,
    memory: Memory,
    rounds: Vec<Times>,
}

impl Column {
    fn new(threads: usize) -> Self {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        Self { pool, memory: Memory::default(), rounds: Vec::new() }
    }

    /// The fastest of several turns, each quantity by itself.
    fn round(&mut self, work: &Work, arrays: &[Vec<u64>]) {
        let Self { pool, memory, rounds } = self;
        let turn = || {
            let [points, build, emit] = memory.tessellate(work);
            [points, build, emit, points + build + emit, spin_ms(), read_ms(arrays)]
        };
        let fastest = |best: Times, own: Times| std::array::from_fn(|index| best[index].min(own[index]));
        rounds.push(pool.install(|| std::iter::repeat_with(turn).take(REPEATS).reduce(fastest)).unwrap());
    }

    /// Gains over one thread, medians of all rounds.
    fn gains(&self, one: &Self) -> Times {
        let threads = self.pool.current_num_threads() as f64;
        // Probes do the same work on every thread.
        let work = [1.0, 1.0, 1.0, 1.0, threads, threads];
        std::array::from_fn(|index| {
            let pairs = one.rounds.iter().zip(&self.rounds);
            median(&pairs.map(|(one, own)| work[index] * one[index] / own[index]).collect::<Vec<_>>())
        })
    }
}

fn main() {
    if timed::only_begin() {
        return;
    }
    let prepared = prepared();
    let body = &prepared.bodies[0];
    let waves = body.interior.is_none().then(|| waves(&body.crack));
    let lift = body.interior.as_ref().or(waves.as_ref()).unwrap();
    let diagram = diagram(body, lift);
    let split = components(&body.topology, &diagram.labels);
    let work = Work { body, lift, diagram, split };
    let threads = std::thread::available_parallelism().unwrap().get();
    let arrays: Vec<Vec<u64>> = (0..threads as u64).map(|own| (own..own + NUMBERS as u64).collect()).collect();
    let mut columns: Vec<Column> = (1..=threads).map(Column::new).collect();
    for _ in 0..ROUNDS {
        columns.iter_mut().for_each(|column| column.round(&work, &arrays));
    }
    println!(
        "{} nodes, {} tetrahedra, dimension {}, {} fragments, {} triangles",
        body.crack.nodes.len(),
        body.crack.tets.len(),
        lift.dimension,
        work.split.sites.len(),
        columns[0].memory.indices.len() / 3,
    );
    println!("threads      ms  points  build   emit    all   arithmetic  reading  all/arithmetic  all/reading");
    for column in &columns {
        let [points, build, emit, all, arithmetic, reading] = column.gains(&columns[0]);
        let whole_ms = median(&column.rounds.iter().map(|times| times[3]).collect::<Vec<_>>());
        println!(
            "{:7} {whole_ms:7.2} {points:7.2} {build:6.2} {emit:6.2} {all:6.2} {arithmetic:12.2} {reading:8.2} {:15.2} {:12.2}",
            column.pool.current_num_threads(),
            all / arithmetic,
            all / reading,
        );
    }
    println!("bound: all/arithmetic at least 0.80");
}
