//! An artist's controls: grain, waves, paint, protected regions and sites, measured on the fragments.

use nalgebra::{Matrix3, Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{DegreeRequest, FractureOutcome, FractureRequest, PreparedObject, WarpError};
use shatter_fracture::scene::{EffectKind, EffectSet, Grain, Paint, Region, WarpControls, Waves};
use shatter_fracture::surface::shapes;
use shatter_tests::baked_once::BakedOnce;
use shatter_tests::{real, struck};

/// Side of the cube, m.
const SIDE: f64 = 1.0;

/// Sites of each request.
const SITES: u32 = 80;

fn cube() -> PreparedObject {
    static CUBE: BakedOnce = BakedOnce::new(|| {
        let tables = Tables { interior: true, surface_diffusion: true, ..Tables::NONE };
        let request = BakeRequest { crack_spacing: Some(0.028), tables, ..real::request("cube", "stone") };
        bake(shapes::cuboid([SIDE; 3]), &request, &CancelToken::default(), &mut |_| ()).unwrap()
    });
    CUBE.load()
}

/// An impact with a wide contact on the cube, in a lift: energy falls off slowly, so that fragments are alike.
fn request(lift: LiftKind, warp: bool) -> FractureRequest {
    let mut effects = EffectSet::NONE;
    if lift == LiftKind::Interior {
        effects = effects.with(EffectKind::Interior);
    }
    if warp {
        effects = effects.with(EffectKind::Warp);
    }
    let at = FractureRequest::at(Point3::new(0.5 * SIDE, 0.02, 0.01), Vector3::new(-900.0, 10.0, 20.0)).seeded(1);
    let mut strike = FractureRequest { degree: DegreeRequest::Sites(SITES), lift, effects, seed: 5, ..at };
    strike.contacts[0].radius_m = Some(0.6 * SIDE);
    strike
}

/// Meshes of the fragments, in coordinates of the mesh file.
struct Pieces {
    outcome: FractureOutcome,
    positions: Vec<Point3<f64>>,
    indices: Vec<u32>,
}

impl Pieces {
    fn new(prepared: &PreparedObject, strike: &FractureRequest) -> Self {
        let outcome = struck::outcome(prepared, strike).unwrap();
        let pieces = outcome.meshes().unwrap();
        let mut flat = vec![[0.0; 3]; pieces.counts.vertices];
        let mut indices = vec![0; pieces.counts.indices];
        pieces.emit(&mut flat, &mut indices, &mut vec![[0; 2]; pieces.counts.merges]).unwrap();
        let mut positions = Vec::with_capacity(flat.len());
        for row in &pieces.fragments {
            let own = &flat[row.vertex_first as usize..][..row.vertex_count as usize];
            positions.extend(own.iter().map(|p| Point3::from(row.center_m) + Vector3::from(p.map(f64::from))));
        }
        Self { outcome, positions, indices }
    }

    /// Triangles of fragment `fragment`.
    fn of(&self, fragment: usize) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
        let row = &self.rows()[fragment];
        let own = &self.indices[row.index_first as usize..][..row.index_count as usize];
        let at = |index: &u32| self.positions[(row.vertex_first + index) as usize];
        own.chunks_exact(3).map(move |t| [at(&t[0]), at(&t[1]), at(&t[2])])
    }

    fn rows(&self) -> &[shatter_fracture::pipeline::FragmentRow] {
        &self.outcome.meshes().unwrap().fragments
    }

    /// Triangles of each crack, seen from one side, by vertex.
    fn cracks(&self) -> impl Iterator<Item = Vec<[u32; 3]>> + '_ {
        let pieces = self.outcome.meshes().unwrap();
        let runs = pieces.runs.iter().filter(|run| run.neighbor != u32::MAX && run.fragment < run.neighbor);
        runs.map(|run| {
            let first = self.rows()[run.fragment as usize].vertex_first;
            let own = &self.indices[run.index_first as usize..][..run.index_count as usize];
            own.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|index| first + index)).collect()
        })
    }

    /// Generalized winding number of a fragment at a point (A. Van Oosterom & J. Strackee 1983): 1 inside, 0 outside.
    fn winding(&self, fragment: usize, at: &Point3<f64>) -> f64 {
        let solid = |[a, b, c]: [Point3<f64>; 3]| {
            let [a, b, c] = [a - at, b - at, c - at];
            let (x, y, z) = (a.norm(), b.norm(), c.norm());
            let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
            2.0 * a.dot(&b.cross(&c)).atan2(below)
        };
        self.of(fragment).map(solid).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    /// The fragment that contains a point.
    fn holder(&self, at: &Point3<f64>) -> usize {
        let holders: Vec<usize> = (0..self.rows().len()).filter(|&own| self.winding(own, at) > 0.5).collect();
        assert_eq!(holders.len(), 1, "{at} lies in {holders:?}");
        holders[0]
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Ratio of the length of the middle fragment along `axis` to that across, from its inertia.
fn stretch(pieces: &Pieces, axis: Vector3<f64>) -> f64 {
    let of = |row: &shatter_fracture::pipeline::FragmentRow| {
        let [xx, yy, zz, xy, xz, yz] = row.inertia_kg_m2;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let second = Matrix3::identity() * (inertia.trace() / 2.0) - inertia;
        let along = axis.dot(&(second * axis));
        (2.0 * along / (second.trace() - along)).sqrt()
    };
    median(pieces.rows().iter().map(of).collect())
}

/// Mean curvature of all cracks times the size of a fragment: ∫|H| over edges is half their length times the angle they bend by (J. Steiner
/// 1840).
fn curvature(pieces: &Pieces) -> f64 {
    let (mut bent, mut area) = (0.0, 0.0);
    for crack in pieces.cracks() {
        let normal = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|vertex| pieces.positions[vertex as usize]);
            (b - a).cross(&(c - a))
        };
        let mut sides = std::collections::HashMap::new();
        for triangle in &crack {
            area += normal(*triangle).norm() / 2.0;
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                if let Some(other) = sides.insert((a.min(b), a.max(b)), normal(*triangle)) {
                    let angle = other.angle(&normal(*triangle));
                    bent += angle * (pieces.positions[a as usize] - pieces.positions[b as usize]).norm() / 2.0;
                }
            }
        }
    }
    bent / area * SIDE / f64::from(SITES).cbrt()
}

/// Points on all cracks: corners, midpoints of sides and centers of triangles.
fn on_cracks(pieces: &Pieces) -> Vec<Point3<f64>> {
    let of = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|vertex| pieces.positions[vertex as usize].coords);
        [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0].map(Point3::from)
    };
    pieces.cracks().flatten().flat_map(of).collect()
}

fn under(controls: WarpControls) -> PreparedObject {
    cube().warped(&controls, &CancelToken::default()).unwrap()
}

#[test]
fn a_grain_of_four_shows_in_the_inertia_of_the_pieces() {
    let axis = Vector3::new(0.0, 0.6, 0.8);
    let prepared = under(WarpControls { grain: Some(Grain { axis, ratio: 4.0 }), ..WarpControls::default() });
    for lift in [LiftKind::Euclidean, LiftKind::Interior, LiftKind::SurfaceDiffusion] {
        let [with, without] = [true, false].map(|warp| stretch(&Pieces::new(&prepared, &request(lift, warp)), axis));
        println!("grain of 4, {lift}: {with:.2} times as long along it, {without:.2} without");
        assert!((2.0..=6.0).contains(&with) && (0.7..1.4).contains(&without), "{lift}: {with} {without}");
    }
}

#[test]
fn waves_bend_the_cracks() {
    let prepared = under(WarpControls { waves: Some(Waves { length_m: 0.4, slope: 0.3 }), ..WarpControls::default() });
    for lift in [LiftKind::Euclidean, LiftKind::Interior] {
        let [with, without] = [true, false].map(|warp| curvature(&Pieces::new(&prepared, &request(lift, warp))));
        println!("waves, {lift}: mean curvature times size {with:.3}, {without:.3} without");
        assert!(with > 1.2 * without, "{lift}: {with} {without}");
    }
}

#[test]
fn no_crack_passes_through_what_is_protected() {
    let ball = Region::Ball { center_m: Point3::from([0.2, 0.1, 0.0]), radius_m: 0.18 };
    let block = Region::Cuboid { min_m: Point3::from([-0.5, -0.5, -0.5]), max_m: Point3::from([-0.2, -0.1, 0.1]) };
    let overlapping = Region::Ball { center_m: Point3::from([-0.2, -0.1, 0.1]), radius_m: 0.1 };
    let protected = vec![ball, block, overlapping];
    let prepared = under(WarpControls { protected: protected.clone(), ..WarpControls::default() });
    let inside = |warp: bool| {
        let points = on_cracks(&Pieces::new(&prepared, &request(LiftKind::Interior, warp)));
        protected.iter().map(|region| points.iter().filter(|p| region.distance_m(p) == 0.0).count()).collect::<Vec<_>>()
    };
    assert_eq!(inside(true), [0, 0, 0]);
    assert!(inside(false).iter().all(|count| *count > 20), "{:?}", inside(false));
}

#[test]
fn every_forced_site_has_a_piece_of_its_own() {
    let sites_m: Vec<Point3<f64>> =
        (0..9).map(|k| Point3::new(0.1 * f64::from(k) - 0.4, 0.3 * f64::from(k % 3) - 0.3, 0.2)).collect();
    let prepared = under(WarpControls { sites_m: sites_m.clone(), ..WarpControls::default() });
    let check = |sites: u32| {
        let strike = FractureRequest { degree: DegreeRequest::Sites(sites), ..request(LiftKind::Euclidean, true) };
        let pieces = Pieces::new(&prepared, &strike);
        let mut holders: Vec<usize> = sites_m.iter().map(|site| pieces.holder(site)).collect();
        holders.sort_unstable();
        holders.dedup();
        assert_eq!(holders.len(), (sites as usize).min(sites_m.len()), "{sites} sites");
        assert_eq!(pieces.outcome.sites(), sites);
    };
    [4, 9, 40].into_iter().for_each(check);
    // A free degree is large enough for all of them.
    let free = FractureRequest { degree: DegreeRequest::ClosedForm, ..request(LiftKind::Euclidean, true) };
    assert!(struck::outcome(&prepared, &free).unwrap().sites() >= 9);
}

#[test]
fn paint_controls_fragment_size() {
    let points_m = vec![Point3::new(0.0, 0.25, 0.0), Point3::new(0.0, -0.25, 0.0)];
    let paint = Paint { points_m, factors: vec![4.0, 0.5] };
    let prepared = under(WarpControls { paint: Some(paint), ..WarpControls::default() });
    let ratio = |warp: bool| {
        let pieces = Pieces::new(&prepared, &request(LiftKind::Euclidean, warp));
        let above = pieces.rows().iter().filter(|row| row.center_m[1] > 0.0).count() as f64;
        above / (pieces.rows().len() as f64 - above)
    };
    let (with, without) = (ratio(true), ratio(false));
    println!("painted 8 to 1: {with:.2} pieces above per one below, {without:.2} without");
    assert!(with > 2.0 * without, "{with} {without}");
}

#[test]
fn artist_controls_do_not_change_the_threshold() {
    let controls = WarpControls {
        grain: Some(Grain { axis: Vector3::x(), ratio: 3.0 }),
        waves: Some(Waves { length_m: 0.5, slope: 0.25 }),
        protected: vec![Region::Ball { center_m: Point3::from([0.0; 3]), radius_m: 0.2 }],
        sites_m: vec![Point3::new(0.3, 0.3, 0.3)],
        ..WarpControls::default()
    };
    let (plain, warped) = (cube(), under(controls));
    let requests = [true, false].map(|warp| request(LiftKind::Interior, warp));
    let [on, off] = requests.clone().map(|request| Pieces::new(&warped, &request));
    let none = Pieces::new(&plain, &requests[0]);
    assert_eq!(
        (on.outcome.threshold().e1_over_gamma, on.outcome.threshold().gamma_j_m2),
        (off.outcome.threshold().e1_over_gamma, off.outcome.threshold().gamma_j_m2)
    );
    assert!(off.positions == none.positions && off.indices == none.indices && on.positions != off.positions);
    let volume = |pieces: &Pieces| pieces.rows().iter().map(|row| row.volume_m3).sum::<f64>();
    assert!((volume(&on) / volume(&off) - 1.0).abs() < 1e-9);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let alone = one.install(|| Pieces::new(&warped, &requests[0]));
    assert!(alone.positions == on.positions && alone.indices == on.indices);
}

#[test]
fn controls_that_an_object_cannot_follow_are_refused_by_name() {
    let refused = |controls: WarpControls| cube().warped(&controls, &CancelToken::default()).err().unwrap();
    let protected = vec![Region::Ball { center_m: Point3::from([9.0; 3]), radius_m: 1.0 }];
    assert_eq!(refused(WarpControls { protected, ..WarpControls::default() }), WarpError::Region { region: 0 });
    let sites_m = vec![Point3::origin(), Point3::new(0.0, 2.0, 0.0)];
    assert!(matches!(refused(WarpControls { sites_m, ..WarpControls::default() }), WarpError::Site { site: 1, .. }));
    let waves = Some(Waves { length_m: 0.3, slope: 4.0 });
    let folds = refused(WarpControls { waves, ..WarpControls::default() });
    let WarpError::Folds { body: 0, slope: Some(slope), .. } = folds else { panic!("{folds}") };
    assert!(folds.to_string().contains(&format!("a slope of {slope} does not fold")), "{folds}");
    let waves = Some(Waves { length_m: 0.3, slope });
    assert!(
        (0.05..4.0).contains(&slope)
            && cube().warped(&WarpControls { waves, ..WarpControls::default() }, &CancelToken::default()).is_ok()
    );
    for steep in [1e3, 1e300] {
        let waves = Some(Waves { length_m: 0.3, slope: steep });
        let folds = refused(WarpControls { waves, ..WarpControls::default() });
        assert!(matches!(folds, WarpError::Folds { slope: Some(slope), .. } if slope > 0.05), "{steep}: {folds}");
    }
    let waves = Some(Waves { length_m: 1e-9, slope: 0.1 });
    assert!(matches!(refused(WarpControls { waves, ..WarpControls::default() }), WarpError::Short { .. }));
    let token = CancelToken::default();
    token.cancel();
    let grain = Some(Grain { axis: Vector3::x(), ratio: 2.0 });
    let canceled = cube().warped(&WarpControls { grain, ..WarpControls::default() }, &token).err().unwrap();
    assert!(matches!(canceled, WarpError::Canceled(_)), "{canceled}");
}
