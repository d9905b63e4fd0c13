//! Protected regions: each lies in one fragment, whose cracks lie on the region's boundary, on both surfaces.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables, bake};
use shatter_fracture::fragment::closed;
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureError, FractureMeshes, FractureRequest, PreparedObject, RequestContext, SurfaceKind,
    Workspace, strike_again,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::{EffectKind, EffectSet, Material, Region, WarpControls};
use shatter_fracture::surface::{NearestTriangles, shapes};

/// Sides of the block, m.
const SIZE_M: [f64; 3] = [0.4, 0.3, 0.2];

/// Spacing of the crack lattice over the diagonal.
const SPACING: f64 = 0.024;

/// Largest distance of a rim from the boundary of its region, in spacings. Regions are grown by most of it.
const RIM_ERROR: f64 = 0.05;

/// Largest distance of a natural crack near a rim from the same crack without regions, in spacings.
const NATURAL_ERROR: f64 = 0.2;

/// Both surfaces of fragments.
const SURFACES: [SurfaceKind; 2] = [SurfaceKind::Lattice, SurfaceKind::Exact];

fn ball(center_m: [f64; 3], radius_m: f64) -> Region {
    Region::Ball { center_m: center_m.into(), radius_m }
}

fn cuboid(min_m: [f64; 3], max_m: [f64; 3]) -> Region {
    Region::Cuboid { min_m: min_m.into(), max_m: max_m.into() }
}

/// The block with protected regions.
fn block(protected: Vec<Region>) -> PreparedObject {
    let request = BakeRequest {
        tables: Tables { skin: true, ..Tables::NONE },
        elastic_spacing: Some(0.08),
        crack_spacing: Some(SPACING),
        kappa: Some(2.0),
        seed: 1,
        ..BakeRequest::new("block", "stone", Material::named("stone").unwrap())
    };
    let token = CancelToken::default();
    let prepared = bake(shapes::cuboid(SIZE_M), &request, &token, &mut |_| {}).unwrap();
    assert!(prepared.bodies[0].cutting.is_some());
    prepared.warped(&WarpControls { protected, ..WarpControls::default() }, &token).unwrap()
}

/// An impact with a wide contact in a corner.
fn request(surface: SurfaceKind, sites: u32, seed: u64) -> FractureRequest {
    let mut strike = FractureRequest::at(Point3::new(0.2, 0.14, 0.09), Vector3::new(-900.0, -10.0, -20.0)).seeded(seed);
    strike.contacts[0].radius_m = Some(0.3);
    let effects = EffectSet::NONE.with(EffectKind::Warp);
    FractureRequest { degree: DegreeRequest::Sites(sites), lift: LiftKind::Euclidean, surface, effects, ..strike }
}

fn struck(prepared: &PreparedObject, strike: &FractureRequest) -> FractureMeshes {
    pipeline::strike(RequestContext::new(prepared, strike, &CancelToken::default(), &()), &mut Workspace::default())
        .unwrap()
        .into_meshes()
        .unwrap()
}

/// Triangles of one fragment, coordinates of the mesh file, m.
struct Solid {
    outer: Vec<[Point3<f64>; 3]>,
    cracks: Vec<[Point3<f64>; 3]>,
}

impl Solid {
    /// Generalized winding number at a point (A. Van Oosterom & J. Strackee 1983): 1 inside, 0 outside.
    fn winding(&self, at: &Point3<f64>) -> f64 {
        let angle = |triangle: &[Point3<f64>; 3]| {
            let [a, b, c] = triangle.map(|corner| corner - at);
            let (x, y, z) = (a.norm(), b.norm(), c.norm());
            let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
            2.0 * a.dot(&b.cross(&c)).atan2(below)
        };
        self.outer.iter().chain(&self.cracks).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    fn crack_points(&self) -> impl Iterator<Item = &Point3<f64>> {
        self.cracks.iter().flatten()
    }
}

/// The fragments of a result; each must be closed.
fn solids(meshes: &FractureMeshes) -> Vec<Solid> {
    let emitted = meshes.emitted().unwrap();
    let solid = |mesh: pipeline::FragmentMesh<'_>| {
        closed(mesh.positions, mesh.indices).unwrap();
        let center = Vector3::from(mesh.row.center_m);
        let at = |index: &u32| Point3::from(mesh.positions[*index as usize].map(f64::from)) + center;
        let runs = &meshes.runs[mesh.row.run_first as usize..][..mesh.row.run_count as usize];
        let of = |is_crack: bool| {
            let runs = runs.iter().filter(|run| run.crack == is_crack);
            let indices = runs.map(|run| &emitted.indices[run.index_first as usize..][..run.index_count as usize]);
            indices.flat_map(|own| own.chunks_exact(3)).map(|own| [at(&own[0]), at(&own[1]), at(&own[2])]).collect()
        };
        Solid { outer: of(false), cracks: of(true) }
    };
    emitted.fragments().map(solid).collect()
}

/// Random points that lie in the region, and in the block by a margin.
fn points_in(region: &Region, count: usize) -> Vec<Point3<f64>> {
    let mut random = RandomStream::new(7, 0);
    let mut draw = || Point3::from(SIZE_M.map(|side| 0.97 * side * (random.uniform() - 0.5)));
    std::iter::repeat_with(&mut draw).filter(|point| region.holds(point)).take(count).collect()
}

/// The only fragment that contains points of the region.
#[track_caller]
fn holder(solids: &[Solid], region: &Region, count: usize) -> usize {
    let holder = |point: &Point3<f64>| solids.iter().position(|solid| solid.winding(point) > 0.5).unwrap();
    let mut holders: Vec<usize> = points_in(region, count).iter().map(holder).collect();
    let all = holders.len();
    holders.sort_unstable();
    let counts: Vec<usize> = holders.chunk_by(|a, b| a == b).map(<[usize]>::len).collect();
    holders.dedup();
    assert_eq!(holders.len(), 1, "{all} points of {region} in {counts:?}");
    holders[0]
}

#[test]
fn the_rim_is_on_the_sphere() {
    let (center_m, radius_m) = ([0.05, 0.02, 0.03], 0.09);
    let region = ball(center_m, radius_m);
    let prepared = block(vec![region]);
    let cell_m = SPACING * prepared.frame.diagonal_m;
    for (surface, sites) in SURFACES.into_iter().flat_map(|surface| [(surface, 12), (surface, 60)]) {
        let strike = request(surface, sites, 3);
        let solids_on = solids(&struck(&prepared, &strike));
        let off = FractureRequest { effects: EffectSet::NONE, ..strike };
        let solids_off = solids(&struck(&prepared, &off));
        let own = &solids_on[holder(&solids_on, &region, 400)];
        let natural: Vec<_> = solids_off.iter().flat_map(|solid| solid.cracks.iter().copied()).collect();
        let natural = NearestTriangles::new(&natural);
        let from_rim = |point: &Point3<f64>| ((point - Point3::from(center_m)).norm() - radius_m).abs() / cell_m;
        let (on_rim, others): (Vec<_>, Vec<_>) = own.crack_points().partition(|point| from_rim(point) < RIM_ERROR);
        let away = |point: &Point3<f64>| from_rim(point).min(natural.distance(point) / cell_m);
        let worst = others.into_iter().map(away).fold(0.0, f64::max);
        println!("{surface:?}, {sites} sites: {} corners on the sphere, others up to {worst:.3} off", on_rim.len());
        assert!(on_rim.len() > 1000 && worst < NATURAL_ERROR, "{surface:?}, {sites} sites: {}, {worst}", on_rim.len());
    }
}

#[test]
fn the_skin_is_cut_on_the_sphere() {
    let (center_m, radius_m) = ([0.05, 0.02, 0.03], 0.09);
    let region = ball(center_m, radius_m);
    let prepared = block(vec![region]);
    let cell_m = SPACING * prepared.frame.diagonal_m;
    let strike = request(SurfaceKind::Lattice, 60, 3);
    let effects = strike.effects.with(EffectKind::Skin);
    let meshes = struck(&prepared, &FractureRequest { effects, ..strike });
    let holder = holder(&solids(&meshes), &region, 50);
    let mut inside = 0;
    for (row, fragment) in meshes.skins.rows.iter().zip(&meshes.fragments) {
        for vertex in &meshes.skins.vertices[row.vertex_first as usize..][..row.vertex_count as usize] {
            let point = Point3::from(vertex.position_m.map(f64::from)) + Vector3::from(fragment.center_m);
            let depth = -region.signed_distance_m(&point) / cell_m;
            inside += usize::from(depth > 0.0);
            assert!(fragment.id as usize == holder || depth < RIM_ERROR, "{point} of {}: {depth}", fragment.id);
        }
    }
    assert!(inside > 100, "{inside}");
}

/// Strikes a block with protected regions on both surfaces: all fragments are closed, each region is in one of them, and
/// the volumes add up. Strikes that fragment again, too.
#[track_caller]
fn check(protected: &[Region], sites: u32) {
    let prepared = block(protected.to_vec());
    for (surface, seed) in SURFACES.into_iter().flat_map(|surface| [(surface, 1), (surface, 2)]) {
        let strike = request(surface, sites, seed);
        let meshes = struck(&prepared, &strike);
        let solids_on = solids(&meshes);
        let holders: Vec<usize> = protected.iter().map(|region| holder(&solids_on, region, 150)).collect();
        let volume_m3 = |meshes: &FractureMeshes| meshes.fragments.iter().map(|row| row.volume_m3).sum::<f64>();
        let off = struck(&prepared, &FractureRequest { effects: EffectSet::NONE, ..strike.clone() });
        let error = volume_m3(&meshes) / volume_m3(&off) - 1.0;
        println!("{surface:?}, seed {seed}: {} fragments, volume off by {error:.0e}", solids_on.len());
        assert!(error.abs() < 1e-9, "{error:e}");
        let again = FractureRequest { degree: DegreeRequest::Sites(8), ..strike };
        strike_twice(&prepared, &meshes, holders[0] as u32, &again);
    }
}

/// Strikes a fragment again; all children are closed, and their volumes add up.
#[track_caller]
fn strike_twice(prepared: &PreparedObject, meshes: &FractureMeshes, fragment: u32, strike: &FractureRequest) {
    let parent = &meshes.fragments[fragment as usize];
    let mut strike = strike.clone();
    strike.contacts[0].point_m = parent.center_m.into();
    let outcome = strike_again(
        RequestContext::new(prepared, &strike, &CancelToken::default(), &()),
        (&meshes.keep(), fragment),
        &mut Workspace::default(),
    );
    let children = match outcome {
        Ok(outcome) => outcome.into_meshes().unwrap(),
        Err(FractureError::FragmentSmall { .. }) => return,
        Err(error) => panic!("{error}"),
    };
    assert_eq!(solids(&children).len(), children.fragments.len());
    let error = children.fragments.iter().map(|row| row.volume_m3).sum::<f64>() / parent.volume_m3 - 1.0;
    assert!(error.abs() < 1e-6, "{error:e}");
}

#[test]
fn balls_and_boxes_are_whole() {
    check(&[ball([0.0, 0.0, 0.0], 0.06)], 80);
    check(&[cuboid([-0.12, -0.05, -0.04], [0.02, 0.06, 0.05])], 80);
}

#[test]
fn overlapping_and_neighboring_regions_are_whole() {
    check(&[ball([0.0, 0.0, 0.0], 0.06), cuboid([0.03, 0.03, -0.02], [0.15, 0.08, 0.05])], 60);
    check(&[ball([-0.05, 0.0, 0.0], 0.04), ball([0.05, 0.0, 0.0], 0.04)], 60);
}

#[test]
fn regions_across_the_surface_are_whole() {
    check(&[ball([0.2, 0.05, 0.05], 0.07)], 60);
    check(&[cuboid([-0.3, -0.3, -0.3], [-0.1, -0.05, 0.05])], 60);
}

#[test]
fn a_region_smaller_than_a_cell_is_whole() {
    let radius_m = 0.2 * SPACING * 0.53;
    check(&[ball([0.043, 0.021, 0.013], radius_m)], 120);
}

#[test]
fn a_region_that_contains_everything_is_one_fragment() {
    let everything = cuboid([-1.0; 3], [1.0; 3]);
    let prepared = block(vec![everything]);
    for surface in SURFACES {
        let solids = solids(&struck(&prepared, &request(surface, 40, 1)));
        assert_eq!((solids.len(), solids[0].cracks.len()), (1, 0));
    }
}
