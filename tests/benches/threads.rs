//! What threads gain in tessellation, beside what the machine gives them: `cargo bench --bench threads`.
//!
//! The cells of a diagram on about 100,000 nodes become points, polygons and sections on 1 to all threads, each in a pool of its own. Two
//! probes take turns with it: arithmetic of each thread for itself, and sums over arrays, one per thread, which no cache holds. The
//! database that `SHATTER_BENCH_DATABASE` names is used instead of a generated statue in a lift of 19 waves.

use nalgebra::Point3;
use rayon::{ThreadPool, ThreadPoolBuilder};
use shatter_fracture::centroidal::{self, Diagram, Field, Options};
use shatter_fracture::database::{BakeRequest, Tables, bake, load};
use shatter_fracture::fragment::properties;
use shatter_fracture::lattice::Lattice;
use shatter_fracture::lift::{Lift, LiftKind};
use shatter_fracture::pipeline::{Body, Prepared, Quality};
use shatter_fracture::tessellation::{
    Components, FixedPoints, Points, Sites, Tessellation, Transform, Workspace, components,
};
use shatter_fracture::token::Token;
use shatter_tests::real;
use shatter_tests::statistics::median;
use shatter_tests::timed::{self, since_ms};
use std::hint::black_box;
use std::time::Instant;

const SITES: usize = 50;
const DIMENSION: usize = 19;
const ROUNDS: usize = 15;
/// Tessellations of one turn, of which the fastest counts.
const REPEATS: usize = 8;
const SPINS: u64 = 20_000_000;
/// Numbers of each thread's array: 64 MiB.
const NUMBERS: usize = 1 << 23;

fn prepared() -> Prepared {
    if let Some(path) = std::env::var_os("SHATTER_BENCH_DATABASE") {
        return load(path.as_ref()).unwrap();
    }
    let request = real::request("threads", "ceramic");
    let request = BakeRequest { quality: Quality::Film, tables: Tables::NONE, kappa: Some(1.0), ..request };
    bake(timed::mesh(), &request, &Token::default(), &mut |_| ()).unwrap()
}

/// Coordinates first, then smooth functions of them, as an interior lift has.
fn waves(lattice: &Lattice) -> Lift {
    let wave = |node: &Point3<f64>, k: usize| (9.0 * node[k % 3] + k as f64).sin() / (3 + k) as f64;
    let coordinate = |node: &Point3<f64>, k: usize| if k < 3 { node[k] } else { wave(node, k) };
    let coordinates = lattice.nodes.iter().flat_map(|node| (0..DIMENSION).map(|k| coordinate(node, k))).collect();
    Lift::scaled(LiftKind::Interior, lattice, DIMENSION, coordinates)
}

/// Cells of even energy.
fn diagram(body: &Body, lift: &Lift) -> Diagram {
    let mut shares = body.volumes.clone();
    let field = Field::new(lift, &body.volumes, &mut shares).unwrap().grouped(&body.clusters);
    let mut workspace = centroidal::Workspace::default();
    centroidal::diagram(&field, &Options::new(SITES, 1), &mut workspace, &Token::default()).unwrap()
}

/// What is tessellated.
struct Work<'a> {
    body: &'a Body,
    lift: &'a Lift,
    diagram: Diagram,
    split: Components,
}

/// What is written into.
#[derive(Default)]
struct Memory {
    points: Points,
    tessellation: Tessellation,
    workspace: Workspace,
    centres: Vec<Point3<f64>>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    merges: Vec<[u32; 2]>,
}

impl Memory {
    /// Labels to sections: points, build, emit, ms. The second time it has room.
    fn tessellate(&mut self, work: &Work) -> [f64; 3] {
        let (lattice, topology, labels) = (&work.body.crack, &work.body.topology, &work.split.labels);
        let sites = Sites { lift: work.lift, coordinates: &work.diagram.sites, of_fragment: &work.split.sites };
        let begun = Instant::now();
        self.points.find(lattice, topology, labels, Some(sites), &FixedPoints::default()).unwrap();
        let points_ms = since_ms(begun);
        let begun = Instant::now();
        self.tessellation.build(lattice, topology, labels, &self.points, &mut self.workspace).unwrap();
        let build_ms = since_ms(begun);
        self.make_room();
        let begun = Instant::now();
        let transform = Transform { metres_per_unit: 1.0 };
        let sections = (&mut self.positions, &mut self.indices, &mut self.merges);
        self.tessellation.emit(&self.centres, transform, sections.0, sections.1, sections.2).unwrap();
        [points_ms, build_ms, since_ms(begun)]
    }

    fn make_room(&mut self) {
        if self.centres.is_empty() {
            let mut measured = Vec::new();
            properties(&self.tessellation, &mut measured);
            self.centres = measured.iter().map(|own| own.centre).collect();
        }
        self.positions.resize(self.tessellation.vertex_count(), [0.0; 3]);
        self.indices.resize(self.tessellation.index_count(), 0);
        self.merges.resize(self.tessellation.merge_count(), [0; 2]);
    }

    /// The fastest of some, by its whole time: points, build, emit, all.
    fn turn(&mut self, work: &Work) -> [f64; 4] {
        let all = (0..REPEATS).map(|_| self.tessellate(work));
        let sums = all.map(|[points, build, emit]| [points, build, emit, points + build + emit]);
        sums.reduce(|best, own| if own[3] < best[3] { own } else { best }).unwrap()
    }
}

/// Time of arithmetic of every thread for itself, ms.
fn spin_ms(pool: &ThreadPool) -> f64 {
    let begun = Instant::now();
    pool.broadcast(|context| {
        let step = |x: u64, _| (x ^ x >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        black_box((0..SPINS).fold(black_box(context.index() as u64 + 1), step))
    });
    since_ms(begun)
}

/// Time of every thread's sum over its own array, ms.
fn read_ms(pool: &ThreadPool, arrays: &[Vec<u64>]) -> f64 {
    let begun = Instant::now();
    pool.broadcast(|context| black_box(arrays[context.index()].iter().fold(0_u64, |sum, &own| sum.wrapping_add(own))));
    since_ms(begun)
}

/// Times on one number of threads, by round, ms.
struct Column {
    pool: ThreadPool,
    memory: Memory,
    tessellation: Vec<[f64; 4]>,
    spin: Vec<f64>,
    read: Vec<f64>,
}

impl Column {
    fn new(threads: usize) -> Self {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (tessellation, spin, read) = (Vec::new(), Vec::new(), Vec::new());
        Self { pool, memory: Memory::default(), tessellation, spin, read }
    }

    fn turn(&mut self, work: &Work, arrays: &[Vec<u64>]) {
        let Self { pool, memory, .. } = self;
        self.tessellation.push(pool.install(|| memory.turn(work)));
        self.spin.push(spin_ms(pool));
        self.read.push(read_ms(pool, arrays));
    }

    /// Against one thread, round by round, the middle: points, build, emit, all; what the machine gave in arithmetic; and in reading.
    fn gains(&self, one: &Self) -> [f64; 6] {
        let threads = self.pool.current_num_threads() as f64;
        let ratio = |slow: &[f64], fast: &[f64], work: f64| {
            median(&slow.iter().zip(fast).map(|(slow, fast)| work * slow / fast).collect::<Vec<_>>())
        };
        let part = |own: &Self, part: usize| own.tessellation.iter().map(|times| times[part]).collect::<Vec<_>>();
        let [points, build, emit, all] = [0, 1, 2, 3].map(|index| ratio(&part(one, index), &part(self, index), 1.0));
        // Every thread does as much as one alone.
        [points, build, emit, all, ratio(&one.spin, &self.spin, threads), ratio(&one.read, &self.read, threads)]
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
    for round in 0..=ROUNDS {
        columns.iter_mut().for_each(|column| column.turn(&work, &arrays));
        if round == 0 {
            // Memory grows here.
            columns.iter_mut().for_each(|own| (own.tessellation, own.spin, own.read) = Default::default());
        }
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
        let whole_ms = median(&column.tessellation.iter().map(|times| times[3]).collect::<Vec<_>>());
        println!(
            "{:7} {whole_ms:7.2} {points:7.2} {build:6.2} {emit:6.2} {all:6.2} {arithmetic:12.2} {reading:8.2} {:15.2} {:12.2}",
            column.pool.current_num_threads(),
            all / arithmetic,
            all / reading,
        );
    }
    println!("bound: all/arithmetic at least 0.80");
}
