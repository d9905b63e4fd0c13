//! Time from labels to emitted fragments on a block of 14 k nodes and 61 k tetrahedra with 50 sites, on one thread.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point3;
use shatter_fracture::fragment::{RigidProperties, properties};
use shatter_fracture::lattice::{Lattice, block};
use shatter_fracture::lift::{LiftKind, LiftedLattice};
use shatter_fracture::random::RandomStream;
use shatter_fracture::tessellation::*;

const SITES: usize = 50;

/// A lift of the coordinates and of smooth functions of them, like an interior lift.
fn lift(lattice: &Lattice, dimension: usize) -> LiftedLattice {
    let wave = |node: &Point3<f64>, k: usize| (9.0 * node[k % 3] + k as f64).sin() / (3 + k) as f64;
    let coordinates = |node: &Point3<f64>| -> Vec<f64> {
        (0..dimension).map(|k| if k < 3 { node[k] } else { wave(node, k) }).collect()
    };
    LiftedLattice::scaled(LiftKind::Interior, lattice, dimension, lattice.nodes.iter().flat_map(coordinates).collect())
}

/// Sites on random nodes, and the nearest of them for each node.
fn diagram(lift: &LiftedLattice) -> (Vec<f64>, Vec<u32>) {
    let nodes = lift.coordinates.len() / lift.dimension;
    let mut random = RandomStream::new(1, 1);
    let sites: Vec<f64> =
        (0..SITES).flat_map(|_| lift.at((random.uniform() * nodes as f64) as usize).to_vec()).collect();
    let squared =
        |node: usize, site: &[f64]| lift.at(node).iter().zip(site).map(|(x, p)| (x - p) * (x - p)).sum::<f64>();
    let nearest = |node: usize| {
        let distances = sites.chunks(lift.dimension).map(|site| squared(node, site)).enumerate();
        distances.fold((0, f64::INFINITY), |best, (k, d)| if d < best.1 { (k, d) } else { best }).0 as u32
    };
    let labels = (0..nodes).map(nearest).collect();
    (sites, labels)
}

#[derive(Default)]
struct Memory {
    split: Components,
    points: CrackPoints,
    tessellation: Tessellation,
    workspace: TessellationWorkspace,
    properties: Vec<RigidProperties>,
    centers: Vec<Point3<f64>>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    merges: Vec<[u32; 2]>,
}

impl Memory {
    fn fit(&mut self) {
        self.positions.resize(self.tessellation.vertex_count(), [0.0; 3]);
        self.indices.resize(self.tessellation.index_count(), 0);
        self.merges.resize(self.tessellation.merge_count(), [0; 2]);
        self.centers = self.properties.iter().map(|properties| properties.center).collect();
    }

    fn emit(&mut self) {
        let transform = LocalToMeters { meters_per_unit: 2.0 };
        let sections = (&mut self.positions, &mut self.indices, &mut self.merges);
        self.tessellation.emit(&self.centers, transform, sections.0, sections.1, sections.2).unwrap();
    }

    fn report(&self, lattice: &Lattice) {
        println!(
            "{} nodes, {} tetrahedra, {} fragments, {} runs, {} vertices, {} triangles, {} merges",
            lattice.nodes.len(),
            lattice.tets.len(),
            self.tessellation.fragments().len(),
            self.tessellation.runs().len(),
            self.positions.len(),
            self.indices.len() / 3,
            self.merges.len()
        );
    }
}

fn stages(criterion: &mut Criterion, dimension: usize) {
    let lattice = block([14, 14, 13], 0.04);
    let topology = Topology::new(&lattice);
    let lift = lift(&lattice, dimension);
    let (coordinates, labels) = diagram(&lift);
    let fixed = FixedPoints::default();
    let mut memory = Memory::default();
    let mut group = criterion.benchmark_group(format!("tessellation/dimension {dimension}"));
    group.bench_function("components", |bench| bench.iter(|| memory.split.split(&topology, &labels)));
    let split = memory.split.clone();
    let sites = BisectorSites { lift: &lift, coordinates: &coordinates, of_fragment: &split.sites, of_node: None };
    group.bench_function("points", |bench| {
        bench.iter(|| memory.points.find(&lattice, &topology, &split.labels, Some(sites), &fixed).unwrap())
    });
    let points = memory.points.clone();
    group.bench_function("tessellate", |bench| {
        let Memory { tessellation, workspace, .. } = &mut memory;
        bench.iter(|| tessellation.build(&lattice, &topology, &split.labels, &points, workspace).unwrap())
    });
    group.bench_function("properties", |bench| bench.iter(|| properties(&memory.tessellation, &mut memory.properties)));
    memory.fit();
    group.bench_function("emit", |bench| bench.iter(|| memory.emit()));
    group.finish();
    memory.report(&lattice);
}

fn tessellation(criterion: &mut Criterion) {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().unwrap();
    stages(criterion, 3);
    stages(criterion, 19);
}

criterion_group!(benches, tessellation);
criterion_main!(benches);
