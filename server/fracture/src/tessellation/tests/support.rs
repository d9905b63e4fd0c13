//! The function `check` with all properties of every tessellation, and lattices and diagrams for it.

use crate::fragment::{self, RigidProperties};
use crate::lattice::{Lattice, block};
use crate::lift::{LiftKind, LiftedLattice};
use crate::random::RandomStream;
use crate::tessellation::*;
use nalgebra::{Point3, Vector3};
use std::collections::{HashMap, HashSet};

/// Output for a host.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitted {
    pub tessellation: Tessellation,
    pub properties: Vec<RigidProperties>,
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
    pub merges: Vec<[u32; 2]>,
}

pub fn emit(tessellation: Tessellation, meters_per_unit: f64) -> Emitted {
    let mut properties = Vec::new();
    fragment::properties(&tessellation, &mut properties);
    let centers: Vec<Point3<f64>> = properties.iter().map(|properties| properties.center).collect();
    let mut positions = vec![[f32::NAN; 3]; tessellation.vertex_count()];
    let mut indices = vec![u32::MAX; tessellation.index_count()];
    let mut merges = vec![[u32::MAX; 2]; tessellation.merge_count()];
    let transform = LocalToMeters { meters_per_unit };
    tessellation.emit(&centers, transform, &mut positions, &mut indices, &mut merges).unwrap();
    Emitted { tessellation, properties, positions, indices, merges }
}

/// Checks all properties that hold for any labels, points and lift on `lattice`.
pub fn check(lattice: &Lattice, labels: &[u32], sites: Option<BisectorSites<'_>>) -> Emitted {
    let topology = Topology::new(lattice);
    let points = crack_points(lattice, &topology, labels, sites, &FixedPoints::default()).unwrap();
    let emitted = emit(tessellate(lattice, &topology, labels, &points).unwrap(), 3.5);
    check_emitted(lattice, &emitted);
    emitted
}

pub fn check_emitted(lattice: &Lattice, emitted: &Emitted) {
    check_ranges(&emitted.tessellation);
    for (index, fragment) in emitted.tessellation.fragments().iter().enumerate() {
        if !fragment.runs.is_empty() {
            check_fragment(emitted, index);
        }
    }
    check_volumes(lattice, emitted);
}

/// Fragments and runs cover the sections without gaps, in the documented order, and every crack has its two runs.
fn check_ranges(tessellation: &Tessellation) {
    let (mut runs, mut vertices, mut triangles, mut merges) = (0, 0, 0, 0);
    for (index, fragment) in tessellation.fragments().iter().enumerate() {
        let starts = (fragment.runs.start, fragment.vertices.start, fragment.triangles.start, fragment.merges.start);
        assert_eq!(starts, (runs, vertices, triangles, merges));
        let mut neighbors = Vec::new();
        for run in &tessellation.runs()[fragment.runs.clone()] {
            assert_eq!(run.fragment as usize, index);
            assert_eq!((run.vertices.start, run.triangles.start, run.merges.start), (vertices, triangles, merges));
            assert!(!run.vertices.is_empty() && !run.triangles.is_empty());
            (vertices, triangles, merges) = (run.vertices.end, run.triangles.end, run.merges.end);
            neighbors.push(run.neighbor.map_or(0, |neighbor| neighbor + 1));
            if let Some(neighbor) = run.neighbor {
                let theirs = &tessellation.runs()[tessellation.fragments()[neighbor as usize].runs.clone()];
                let back = theirs.iter().find(|theirs| theirs.neighbor == Some(run.fragment)).expect("both sides");
                assert_eq!((back.vertices.len(), back.triangles.len()), (run.vertices.len(), run.triangles.len()));
            }
        }
        assert!(neighbors.is_sorted_by(|a, b| a < b), "outer first, then ascending neighbors");
        runs = fragment.runs.end;
        let ends = (fragment.vertices.end, fragment.triangles.end, fragment.merges.end);
        assert_eq!(ends, (vertices, triangles, merges));
    }
    assert_eq!(
        (runs, vertices, 3 * triangles, merges),
        (
            tessellation.runs().len(),
            tessellation.vertex_count(),
            tessellation.index_count(),
            tessellation.merge_count(),
        )
    );
}

fn check_fragment(emitted: &Emitted, index: usize) {
    let fragment = &emitted.tessellation.fragments()[index];
    let positions = &emitted.positions[fragment.vertices.clone()];
    let indices = &emitted.indices[3 * fragment.triangles.start..3 * fragment.triangles.end];
    let merges = &emitted.merges[fragment.merges.clone()];
    fragment::closed(positions, indices).unwrap();
    emitted.properties[index].rigid().unwrap();
    let merged = apply_merges(positions, merges);
    let welded: Vec<u32> = indices.iter().map(|&vertex| merged[vertex as usize]).collect();
    check_manifold(&welded);
    let distinct: HashSet<[u32; 3]> = positions.iter().map(|position| position.map(f32::to_bits)).collect();
    assert_eq!(distinct.len(), positions.len() - merges.len(), "coincident vertices");
    let mut rim = HashSet::new();
    for run in &emitted.tessellation.runs()[fragment.runs.clone()] {
        let first = (run.vertices.start - fragment.vertices.start) as u32;
        let vertices = first..first + run.vertices.len() as u32;
        let triangles = &emitted.indices[3 * run.triangles.start..3 * run.triangles.end];
        let used: HashSet<u32> = triangles.iter().copied().collect();
        assert_eq!(used.len(), run.vertices.len(), "every vertex of a run is used");
        assert!(used.iter().all(|vertex| vertices.contains(vertex)), "and no other");
        assert!(emitted.merges[run.merges.clone()].iter().all(|[from, _]| vertices.contains(from)));
        rim.extend(rim_of(triangles));
    }
    assert_eq!(rim, merges.iter().flatten().copied().collect(), "rim vertices, and only they, take part in merges");
}

/// First vertex of each point, after checks of the pairs themselves.
fn apply_merges(positions: &[[f32; 3]], merges: &[[u32; 2]]) -> Vec<u32> {
    let mut first: Vec<u32> = (0..positions.len() as u32).collect();
    assert!(merges.is_sorted_by(|a, b| a[0] < b[0]), "ascending, none twice");
    for &[from, to] in merges {
        assert!(to < from, "a later vertex merges into an earlier one");
        assert_eq!(positions[from as usize].map(f32::to_bits), positions[to as usize].map(f32::to_bits));
        assert_eq!(first[to as usize], to, "which merges into no other");
        first[from as usize] = to;
    }
    first
}

/// By index only: every edge has two opposite half-edges, every vertex one fan.
fn check_manifold(indices: &[u32]) {
    let mut half_edges = HashSet::new();
    let mut next: HashMap<u32, HashMap<u32, u32>> = HashMap::new();
    for triangle in indices.chunks(3) {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|step| triangle[(k + step) % 3]);
            assert!(a != b && half_edges.insert((a, b)), "half-edge twice");
            next.entry(a).or_default().insert(b, c);
        }
    }
    assert!(half_edges.iter().all(|&(a, b)| half_edges.contains(&(b, a))), "half-edge without opposite");
    for ring in next.values() {
        let start = *ring.keys().next().unwrap();
        let (mut at, mut steps) = (ring[&start], 1);
        while at != start {
            (at, steps) = (ring[&at], steps + 1);
        }
        assert_eq!(steps, ring.len(), "two fans at one vertex");
    }
}

/// Vertices on edges with a single half-edge within these triangles.
fn rim_of(triangles: &[u32]) -> HashSet<u32> {
    let half_edges: HashSet<(u32, u32)> =
        triangles.chunks(3).flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    half_edges.iter().filter(|&&(a, b)| !half_edges.contains(&(b, a))).flat_map(|&(a, b)| [a, b]).collect()
}

/// The fragments' volumes add up to the lattice's, in f64 and in the emitted f32.
fn check_volumes(lattice: &Lattice, emitted: &Emitted) {
    let expected = lattice.volume();
    let sum: f64 = emitted.properties.iter().map(|properties| properties.volume).sum();
    assert!((sum / expected - 1.0).abs() < 1e-9, "{sum} {expected}");
    let mut emitted_sum = 0.0;
    for fragment in emitted.tessellation.fragments() {
        let corner =
            |&vertex: &u32| Vector3::from(emitted.positions[fragment.vertices.start + vertex as usize].map(f64::from));
        for triangle in emitted.indices[3 * fragment.triangles.start..3 * fragment.triangles.end].chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| corner(&triangle[k]));
            emitted_sum += a.dot(&b.cross(&c)) / 6.0;
        }
    }
    let expected = expected * 3.5_f64.powi(3);
    assert!((emitted_sum / expected - 1.0).abs() < 1e-6, "{emitted_sum} {expected}");
}

/// A block with randomly moved nodes; the moves are too small to invert a tetrahedron.
pub fn wobbly(cells: [usize; 3], seed: u64) -> Lattice {
    let spacing = 0.5 / cells.iter().copied().max().unwrap_or(1) as f64;
    let mut lattice = block(cells, spacing);
    let mut random = RandomStream::new(seed, 1);
    for node in &mut lattice.nodes {
        *node += Vector3::from_fn(|_, _| 0.2 * spacing * (random.uniform() - 0.5));
    }
    assert!((0..lattice.tets.len()).all(|tet| lattice.tet_volume(tet) > 0.0));
    lattice
}

/// The cells of a block whose centers `keep` accepts; unused nodes are dropped.
pub fn carved(cells: [usize; 3], spacing: f64, keep: impl Fn(Point3<f64>) -> bool) -> Lattice {
    let whole = block(cells, spacing);
    let mut lattice = Lattice::default();
    let mut renumbered = HashMap::new();
    for nodes in &whole.tets {
        if keep(whole.nodes[nodes[0] as usize]) {
            let tet = nodes.map(|node| {
                *renumbered.entry(node).or_insert_with(|| {
                    lattice.nodes.push(whole.nodes[node as usize]);
                    lattice.nodes.len() as u32 - 1
                })
            });
            lattice.tets.push(tet);
        }
    }
    lattice
}

/// Independent random labels below `count`, renumbered without gaps.
pub fn random_labels(nodes: usize, count: usize, seed: u64) -> Vec<u32> {
    let mut random = RandomStream::new(seed, 2);
    dense((0..nodes).map(|_| (random.uniform() * count as f64) as u32).collect())
}

fn dense(mut labels: Vec<u32>) -> Vec<u32> {
    let mut used = labels.clone();
    used.sort_unstable();
    used.dedup();
    labels.iter_mut().for_each(|label| *label = used.partition_point(|other| other < label) as u32);
    labels
}

/// A lift of `dimension` random coordinates, and random sites.
pub fn random_lift(lattice: &Lattice, dimension: usize, sites: usize, seed: u64) -> (LiftedLattice, Vec<f64>) {
    let mut random = RandomStream::new(seed, 3);
    let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| random.uniform() - 0.5).collect() };
    let coordinates = draw(lattice.nodes.len() * dimension);
    let lift = LiftedLattice::scaled(LiftKind::Interior, lattice, dimension, coordinates);
    (lift, draw(sites * dimension))
}

/// Nearest site of each node; ties go to the lowest.
pub fn nearest(lift: &LiftedLattice, sites: &[f64]) -> Vec<u32> {
    let squared = |x: &[f64], p: &[f64]| x.iter().zip(p).map(|(x, p)| (x - p) * (x - p)).sum::<f64>();
    let node_count = lift.coordinates.len() / lift.dimension;
    let best = |node: usize| {
        let distances = sites.chunks(lift.dimension).map(|site| squared(lift.at(node), site));
        distances.enumerate().fold((0, f64::INFINITY), |best, (k, d)| if d < best.1 { (k, d) } else { best }).0
    };
    (0..node_count).map(|node| best(node) as u32).collect()
}

/// A Euclidean Voronoi diagram of `lattice`, with its components.
pub struct Voronoi {
    pub lift: LiftedLattice,
    pub sites: Vec<f64>,
    pub split: Components,
}

impl Voronoi {
    pub fn new(lattice: &Lattice, sites: &[Point3<f64>]) -> Self {
        // Already scaled to unit density, so that sites and nodes keep their positions.
        let mut lift = LiftedLattice::euclidean(lattice);
        lift.coordinates = lattice.nodes.iter().flat_map(|node| [node.x, node.y, node.z]).collect();
        let sites: Vec<f64> = sites.iter().flat_map(|site| [site.x, site.y, site.z]).collect();
        let split = components(&Topology::new(lattice), &nearest(&lift, &sites));
        Self { lift, sites, split }
    }

    pub fn sites(&self) -> BisectorSites<'_> {
        BisectorSites { lift: &self.lift, coordinates: &self.sites, of_fragment: &self.split.sites, of_node: None }
    }

    pub fn site(&self, fragment: u32) -> Point3<f64> {
        Point3::from_slice(&self.sites[3 * self.split.sites[fragment as usize] as usize..][..3])
    }

    pub fn check(&self, lattice: &Lattice) -> Emitted {
        check(lattice, &self.split.labels, Some(self.sites()))
    }
}

pub fn random_points(count: usize, half: f64, seed: u64) -> Vec<Point3<f64>> {
    let mut random = RandomStream::new(seed, 4);
    (0..count).map(|_| Point3::from(Vector3::from_fn(|_, _| half * (2.0 * random.uniform() - 1.0)))).collect()
}
