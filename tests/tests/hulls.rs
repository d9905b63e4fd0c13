//! Hulls of generated shapes' fragments, measured independently.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::hull::FACES_MAX;
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureMeshes, FractureRequest, HULL_COVERAGE, HullRow, PreparedObject, Stage, StageObserver,
    Workspace,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::{EffectKind, EffectSet};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::{real, struck};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Random points per fragment that estimate its coverage by the hull.
const SAMPLES: usize = 1500;

/// Number of requests, the shortest of which is shown.
const STRIKES: usize = 3;

/// Error of lengths in single precision, over the object's diagonal.
const ROUNDING: f64 = 1e-6;

/// A closed mesh in the coordinates of the mesh file.
struct Mesh {
    corners: Vec<[Point3<f64>; 3]>,
}

impl Mesh {
    fn new(center: [f64; 3], positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let place = |index: u32| Point3::from(positions[index as usize].map(f64::from)) + Vector3::from(center);
        Self { corners: indices.chunks_exact(3).map(|t| [place(t[0]), place(t[1]), place(t[2])]).collect() }
    }

    /// True if `point` is inside: a ray crosses the surface an odd number of times.
    fn holds(&self, point: &Point3<f64>) -> bool {
        let along = Vector3::new(0.36, 0.48, 0.8);
        let crossed = |[a, b, c]: &&[Point3<f64>; 3]| {
            let side = |p: &Point3<f64>, q: &Point3<f64>| (p - point).cross(&(q - point)).dot(&along);
            let sides = [side(a, b), side(b, c), side(c, a)];
            let one_sided = sides.iter().all(|x| *x > 0.0) || sides.iter().all(|x| *x < 0.0);
            let normal = (b - a).cross(&(c - a));
            one_sided && (a - point).dot(&normal) * along.dot(&normal) > 0.0
        };
        self.corners.iter().filter(crossed).count() % 2 == 1
    }

    /// Planes of the triangles: a point, and the outward normal.
    fn planes(&self) -> Vec<(Point3<f64>, Vector3<f64>)> {
        self.corners.iter().map(|[a, b, c]| (*a, (b - a).cross(&(c - a)).normalize())).collect()
    }
}

/// Depth of a point below the nearest plane; negative outside.
fn depth(planes: &[(Point3<f64>, Vector3<f64>)], point: &Point3<f64>) -> f64 {
    planes.iter().map(|(at, normal)| normal.dot(&(at - point))).fold(f64::INFINITY, f64::min)
}

/// At the spacings of the preset, with what cells need: which field decides about them does not matter to their hulls.
fn baked(name: &str, mesh: RawMesh, crack_spacing: Option<f64>) -> PreparedObject {
    let tables = Tables { interior: true, ..Tables::NONE };
    let request = BakeRequest { tables, crack_spacing, ..real::request(name, "ceramic") };
    bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

fn request(prepared: &PreparedObject, sites: u32, effects: EffectSet) -> FractureRequest {
    let (point_m, inward) = struck::surface_point(prepared, [0.9, 0.6, 0.5]);
    let effects = effects.without(EffectKind::Elastic);
    FractureRequest { degree: DegreeRequest::Sites(sites), effects, seed: 3, ..FractureRequest::at(point_m, inward) }
}

fn pieces(prepared: &PreparedObject, sites: u32, effects: EffectSet) -> FractureMeshes {
    struck::outcome(prepared, &request(prepared, sites, effects)).unwrap().into_meshes().unwrap()
}

/// Time of the hulls and of the whole request.
struct Stopwatch {
    begun: Cell<Instant>,
    hulls: Cell<Duration>,
}

impl StageObserver for Stopwatch {
    fn enter(&self, _: Stage) {}

    fn leave(&self, _: Stage, _: u64) {}

    fn part(&self, _: EffectKind, _: u64) {}

    fn begin(&self, _: EffectKind) {
        self.begun.set(Instant::now());
    }

    fn end(&self, _: EffectKind, _: u64) {
        self.hulls.set(self.begun.get().elapsed());
    }
}

/// Time of the hulls and of the whole request on one thread, ms: the least of some.
fn times(prepared: &PreparedObject, sites: u32) -> [f64; 2] {
    let strike = request(prepared, sites, EffectSet::default().with(EffectKind::Hulls));
    let once = || {
        let since = Instant::now();
        let stopwatch = Stopwatch { begun: Cell::new(since), hulls: Cell::new(Duration::ZERO) };
        pipeline::strike(
            pipeline::RequestContext::new(prepared, &strike, &CancelToken::default(), &stopwatch),
            &mut Workspace::default(),
        )
        .unwrap();
        [stopwatch.hulls.get(), since.elapsed()].map(|time| 1e3 * time.as_secs_f64())
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let all = pool.install(|| std::array::from_fn::<_, STRIKES, _>(|_| once()));
    [0, 1].map(|which| all.iter().map(|times| times[which]).fold(f64::INFINITY, f64::min))
}

/// Meshes of the fragments and of their hulls.
fn meshes(pieces: &FractureMeshes) -> (Vec<Mesh>, Vec<Mesh>) {
    let mut positions = vec![[0.0; 3]; pieces.counts.vertices];
    let mut indices = vec![0; pieces.counts.indices];
    pieces.emit(&mut positions, &mut indices, &mut vec![[0; 2]; pieces.counts.merges]).unwrap();
    let fragments = pieces.fragments.iter().map(|row| {
        let (vertex, index) = (row.vertex_first as usize, row.index_first as usize);
        let positions = &positions[vertex..][..row.vertex_count as usize];
        Mesh::new(row.center_m, positions, &indices[index..][..row.index_count as usize])
    });
    let hulls = pieces.fragments.iter().zip(&pieces.hulls.rows).map(|(fragment, row)| {
        let (vertex, index) = (row.vertex_first as usize, row.index_first as usize);
        let positions = &pieces.hulls.positions[vertex..][..row.vertex_count as usize];
        Mesh::new(fragment.center_m, positions, &pieces.hulls.indices[index..][..row.index_count as usize])
    });
    (fragments.collect(), hulls.collect())
}

/// Share of a fragment inside its hull, by points drawn in its box.
fn sampled(fragment: &Mesh, planes: &[(Point3<f64>, Vector3<f64>)], seed: u64) -> f64 {
    let corners = || fragment.corners.iter().flatten();
    let low = corners().fold(Point3::from([f64::INFINITY; 3]), |low, p| low.inf(p));
    let high = corners().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, p| high.sup(p));
    let mut random = RandomStream::new(seed, 12);
    let (mut inside, mut held) = (0, 0);
    while inside < SAMPLES {
        let point = low + (high - low).map(|x| x * random.uniform());
        if fragment.holds(&point) {
            inside += 1;
            held += usize::from(depth(planes, &point) >= 0.0);
        }
    }
    held as f64 / SAMPLES as f64
}

/// Checks limits, margins and coverage of all hulls, and prints them.
#[track_caller]
fn check(name: &str, mesh: RawMesh, sites: u32) {
    // Twice the default spacing of the vase still resolves its wall.
    let spacing = (name == "vase").then_some(0.019);
    let prepared = baked(name, mesh, spacing);
    let pieces = pieces(&prepared, sites, EffectSet::default().with(EffectKind::Hulls));
    let (fragments, hulls) = meshes(&pieces);
    let diagonal = prepared.frame.diagonal_m;
    let spacing = prepared.parameters.crack_spacing * diagonal;
    let (mut volume, mut held, mut estimated) = (0.0, 0.0, 0.0);
    for (own, (row, hull)) in pieces.hulls.rows.iter().zip(&hulls).enumerate() {
        assert!(row.vertex_count > 0 && row.index_count as usize <= 3 * FACES_MAX && row.vertex_count <= 64, "{row:?}");
        let planes = hull.planes();
        let others = fragments.iter().enumerate().filter(|(other, _)| *other != own);
        let corners = others.flat_map(|(_, mesh)| &mesh.corners);
        let places = corners.flat_map(|&[a, b, c]| [a, Point3::from((a.coords + b.coords + c.coords) / 3.0)]);
        let deepest = places.map(|point| depth(&planes, &point)).fold(0.0, f64::max);
        let rounding = ROUNDING * diagonal;
        assert!(deepest <= row.margin_m + rounding, "{name} {own}: {deepest} and {row:?}");
        assert!(row.margin_m <= deepest + 0.5 * spacing, "{name} {own}: {deepest} and {row:?}");
        let own_volume = pieces.fragments[own].volume_m3;
        volume += own_volume;
        held += own_volume * row.coverage;
        estimated += own_volume * sampled(&fragments[own], &planes, own as u64);
    }
    let (held, estimated) = (held / volume, estimated / volume);
    show(name, &pieces.hulls.rows, held, estimated, diagonal);
    let [own, whole] = times(&prepared, sites);
    println!("{name}: hulls take {own:.1} of {whole:.1} ms");
    assert!((held - estimated).abs() < 0.01, "{name}: {held} {estimated}");
    assert!(held >= HULL_COVERAGE, "{name}: {held}");
}

fn show(name: &str, rows: &[HullRow], held: f64, estimated: f64, diagonal: f64) {
    let mut coverages: Vec<f64> = rows.iter().map(|row| row.coverage).collect();
    let mut margins: Vec<f64> = rows.iter().map(|row| row.margin_m / diagonal).collect();
    coverages.sort_by(f64::total_cmp);
    margins.sort_by(f64::total_cmp);
    let below = coverages.iter().filter(|coverage| **coverage < HULL_COVERAGE).count();
    println!(
        "{name}: {} hulls hold {:.1} % ({:.1} % sampled), least {:.1} %, {below} below; margins: median {:.2} %, most {:.2} % of the diagonal",
        rows.len(),
        100.0 * held,
        100.0 * estimated,
        100.0 * coverages[0],
        100.0 * margins[margins.len() / 2],
        100.0 * margins[margins.len() - 1],
    );
}

#[test]
fn hulls_hold_their_fragments_and_keep_to_their_margins() {
    check("bar", shapes::cuboid([0.4, 0.2, 0.2]), 24);
    check("mug", shapes::mug(), 24);
    check("horseshoe", shapes::horseshoe(), 24);
    check("vase", shapes::vase(), 24);
    check("statue", shapes::statue(), 24);
}

#[test]
fn hulls_are_the_same_for_any_number_of_threads() {
    let request =
        BakeRequest { crack_spacing: Some(0.04), elastic_spacing: Some(0.1), ..real::request("mug", "glass") };
    let prepared = bake(shapes::horseshoe(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| pieces(&prepared, 30, EffectSet::default().with(EffectKind::Hulls)).hulls)
    };
    let one = with(1);
    assert!(!one.positions.is_empty() && one == with(2) && one == with(5));
    assert!(pieces(&prepared, 30, EffectSet::default()).hulls.rows.is_empty());
}
