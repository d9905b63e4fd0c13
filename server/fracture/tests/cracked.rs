//! Objects with existing cracks without width: neither lattice crosses them, elasticity opens them, and distances go
//! around them.

use nalgebra::{Point3, Rotation3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, DiagramOptions, EnergyField};
use shatter_fracture::database::{BakeError, BakeRequest, Tables, bake, input_hash, load, save};
use shatter_fracture::fragment::closed;
use shatter_fracture::lattice::{Lattice, check_manifold};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureMeshes, FractureRequest, ImpactContact, PreparedObject, Workspace,
};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::{CrackSheets, DefectKind, RawMesh, Surface, shapes};
use std::sync::LazyLock;

/// Sides of the block, m. Its crack is in the middle plane, from the top to half its depth.
const SIZE_M: [f64; 3] = [0.4, 0.2, 0.2];

/// Distance from a crack's end up to which its sides may be connected, m: three tenths of the elastic spacing.
const END_M: f64 = 0.01;

static WHOLE: LazyLock<PreparedObject> = LazyLock::new(|| baked(shapes::cuboid(SIZE_M), None).unwrap());

static HALF: LazyLock<PreparedObject> =
    LazyLock::new(|| check(shapes::cuboid(SIZE_M), [half_depth(), sheet([END_M, 0.12], [-0.12, 0.12])], 1));

/// The rectangle at x = 0 with y and z in the given ranges.
fn sheet(y: [f64; 2], z: [f64; 2]) -> RawMesh {
    let corners = [[y[0], z[0]], [y[1], z[0]], [y[1], z[1]], [y[0], z[1]]];
    RawMesh::new(corners.map(|[y, z]| Point3::new(0.0, y, z)).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

/// A sheet from slightly above the block to its middle.
fn half_depth() -> RawMesh {
    sheet([0.0, 0.12], [-0.12, 0.12])
}

fn moved(mut mesh: RawMesh, to: impl Fn(Point3<f64>) -> Point3<f64>) -> RawMesh {
    mesh.positions_m.iter_mut().for_each(|point| *point = to(*point));
    mesh
}

fn baked(mesh: RawMesh, cracks: Option<RawMesh>) -> Result<PreparedObject, BakeError> {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let glass = materials.get("glass").unwrap().clone();
    let request = BakeRequest {
        elastic_spacing: Some(0.07),
        crack_spacing: Some(0.04),
        kappa: Some(2.0),
        seed: 1,
        cracks,
        ..BakeRequest::new("thing", "glass", glass)
    };
    bake(mesh, &request, &CancelToken::default(), &mut |_| {})
}

/// True if the segment from `a` to `b` crosses the triangle.
fn crosses(a: &Point3<f64>, b: &Point3<f64>, [p, q, r]: &[Point3<f64>; 3]) -> bool {
    let volume =
        |a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>, d: &Point3<f64>| (b - a).cross(&(c - a)).dot(&(d - a));
    let around = [(p, q), (q, r), (r, p)].map(|(from, to)| volume(a, b, from, to));
    volume(p, q, r, a) * volume(p, q, r, b) < 0.0
        && (around.iter().all(|side| *side > 0.0) || around.iter().all(|side| *side < 0.0))
}

/// Number of edges of a lattice that cross the sheets.
fn crossings(prepared: &PreparedObject, lattice: &Lattice, sheets: &RawMesh) -> usize {
    let corners = |triangle: &[u32; 3]| triangle.map(|k| prepared.frame.to_local(&sheets.positions_m[k as usize]));
    let triangles: Vec<[Point3<f64>; 3]> = sheets.triangles.iter().map(corners).collect();
    let ends = |edge: [u32; 2]| edge.map(|node| lattice.nodes[node as usize]);
    let edges = lattice.edges().into_iter().map(ends);
    edges.filter(|[a, b]| triangles.iter().any(|triangle| crosses(a, b, triangle))).count()
}

/// Bakes an object with cracks and strikes it.
///
/// Expects the number of bodies, no edge of either lattice across the sheets (without their ends: `sure`), no other
/// losses or defects, and closed fragments with the volume of the lattice.
#[track_caller]
fn check(mesh: RawMesh, [sheets, sure]: [RawMesh; 2], bodies: usize) -> PreparedObject {
    let prepared = baked(mesh, Some(sheets.clone())).unwrap();
    let report = &prepared.report;
    assert_eq!(prepared.bodies.len(), bodies);
    for body in &prepared.bodies {
        for lattice in [&body.crack, &body.solid.as_ref().unwrap().lattice] {
            check_manifold(lattice).unwrap();
            println!("{} edges through the sheet", crossings(&prepared, lattice, &sheets));
            assert_eq!(crossings(&prepared, lattice, &sure), 0);
        }
    }
    let cracks = report.cracks.unwrap();
    println!("{cracks:?}, volume {:+.4}, deviation {:.4}", report.volume_error(), report.surface_deviation);
    assert!(report.volume_error().abs() < 2e-3, "{}", report.volume_error());
    assert!(report.lattice_volume_m3 < report.input_volume_m3 - 0.9 * cracks.volume_m3 && cracks.volume_m3 > 0.0);
    assert!(report.defects.is_empty(), "{:?}", report.defects);
    let point =
        prepared.frame.to_meters(prepared.bodies[0].crack.nodes.iter().max_by(|a, b| a.y.total_cmp(&b.y)).unwrap());
    let pieces = struck(&prepared, &request(point, Vector3::new(0.0, -1.0, 0.0), LiftKind::Interior, 0));
    assert!(shown(&pieces).len() >= 8);
    let sum: f64 = pieces.fragments.iter().map(|row| row.volume_m3).sum();
    let own = prepared.bodies[0].crack.volume() * prepared.frame.diagonal_m.powi(3);
    let all = report.lattice_volume_m3;
    assert!((sum / own - 1.0).abs() < 1e-6 || (sum / all - 1.0).abs() < 1e-6, "{sum} {own} {all}");
    prepared
}

fn request(point_m: Point3<f64>, impulse: Vector3<f64>, lift: LiftKind, seed: u64) -> FractureRequest {
    FractureRequest { degree: DegreeRequest::Sites(8), lift, seed, ..FractureRequest::at(point_m, impulse) }
}

fn struck(prepared: &PreparedObject, strike: &FractureRequest) -> FractureMeshes {
    let outcome = pipeline::strike(
        pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        &mut Workspace::default(),
    )
    .unwrap();
    outcome.into_meshes().unwrap()
}

/// The points of each fragment in the coordinates of the file; each must be closed.
fn shown(pieces: &FractureMeshes) -> Vec<Vec<Point3<f64>>> {
    let counts = pieces.counts;
    let (mut positions, mut indices) = (vec![[0.0; 3]; counts.vertices], vec![0; counts.indices]);
    pieces.emit(&mut positions, &mut indices, &mut vec![[0; 2]; counts.merges]).unwrap();
    let show = |row: &pipeline::FragmentRow| {
        let own = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
        closed(own, &indices[row.index_first as usize..][..row.index_count as usize]).unwrap();
        own.iter().map(|at| Point3::from(at.map(f64::from)) + Vector3::from(row.center_m)).collect()
    };
    pieces.fragments.iter().map(show).collect()
}

/// True if points near the crack's mouth are on both of its sides.
fn spans_the_mouth(points: impl Iterator<Item = Point3<f64>>) -> bool {
    let mouth: Vec<f64> = points.filter(|point| point.y > 0.06).map(|point| point.x).collect();
    mouth.iter().any(|x| *x < -0.01) && mouth.iter().any(|x| *x > 0.01)
}

/// Number of fragments, and of cells of their diagrams, on both sides of the crack's mouth, over eight requests beside
/// it.
fn across_the_crack(lift: LiftKind) -> [usize; 2] {
    let mut across = [0; 2];
    for seed in 0..8 {
        let strike = request(Point3::new(0.06, 0.1, 0.0), Vector3::new(0.0, -1.0, 0.0), lift, seed);
        let fragments = shown(&struck(&HALF, &strike));
        across[0] += fragments.iter().filter(|own| spans_the_mouth(own.iter().copied())).count();
        let labels = cells(&HALF, &strike);
        let place = |node: usize| HALF.frame.to_meters(&HALF.bodies[0].crack.nodes[node]);
        for cell in 0..8 {
            let own = (0..labels.len()).filter(|&node| labels[node] == cell);
            across[1] += usize::from(spans_the_mouth(own.map(place)));
        }
    }
    across
}

/// Energy of the only body under `strike`, J, and the share of each crack node.
fn energy(prepared: &PreparedObject, strike: &FractureRequest) -> (f64, Vec<f64>) {
    let impact = pipeline::ContactSet::new(prepared, strike).unwrap();
    let solved = pipeline::strain_energy(
        pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        &impact,
        &mut Workspace::default(),
    );
    let own = solved.unwrap().remove(0);
    (own.energy_j, own.shares)
}

/// The cell of each node of the only body.
fn cells(prepared: &PreparedObject, strike: &FractureRequest) -> Vec<u32> {
    let mut shares = energy(prepared, strike).1;
    let field =
        EnergyField::new(prepared.lift(0, strike.lift).unwrap(), &prepared.bodies[0].volumes, &mut shares).unwrap();
    let (options, token) = (DiagramOptions::new(8, strike.seed), CancelToken::default());
    centroidal::diagram(&field, &options, &mut Default::default(), &token).unwrap().labels
}

#[test]
fn nothing_spans_a_crack_of_no_width_but_straight_distances() {
    let lifts = [LiftKind::Interior, LiftKind::Euclidean, LiftKind::SurfaceDiffusion];
    let [interior, straight, diffusion] = lifts.map(across_the_crack);
    println!(
        "fragments and cells across the crack: interior {interior:?}, euclidean {straight:?}, surface {diffusion:?}"
    );
    assert_eq!(interior, [0; 2]);
    assert!(straight[1] > 0);
}

/// Distance in the interior lift between the nodes nearest to (∓`x`, 0.09, 0), over the Euclidean one.
fn around_the_mouth(prepared: &PreparedObject, x: f64) -> f64 {
    let body = &prepared.bodies[0];
    let nearest = |x: f64| {
        let at = prepared.frame.to_local(&Point3::new(x, 0.09, 0.0));
        let distance = |node: usize| (body.crack.nodes[node] - at).norm();
        (0..body.crack.nodes.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let lift = body.interior.as_ref().unwrap();
    let row = |node: usize| lift.coordinates[node * lift.dimension..][..lift.dimension].iter();
    let (a, b) = (nearest(-x), nearest(x));
    let lifted = row(a).zip(row(b)).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt();
    lifted / (body.crack.nodes[a] - body.crack.nodes[b]).norm()
}

#[test]
fn distances_go_around_a_crack() {
    let [whole, cracked] = [&*WHOLE, &*HALF].map(|prepared| around_the_mouth(prepared, 0.03));
    println!("distance across the mouth over the straight one: {cracked:.2}, without the crack {whole:.2}");
    assert!(cracked > 2.5 * whole, "{cracked} {whole}");
}

/// The same ratio for a block with a slit of 12 mm in its mesh, at a quarter of the spacings.
const SLIT: f64 = 7.8;

#[test]
fn pulled_apart_a_crack_opens_as_far_as_a_slit_does() {
    let pulled = |prepared: &PreparedObject| {
        let contact = |x: f64| ImpactContact {
            point_m: Point3::new(x, 0.1, 0.0),
            impulse_ns: Vector3::new(x.signum(), 0.0, 0.0),
            duration_s: Some(1e-3),
            radius_m: Some(0.05),
            partner: None,
        };
        let mut strike = FractureRequest::at(Point3::origin(), Vector3::x()).seeded(1);
        strike.contacts = vec![contact(-0.1), contact(0.1)];
        energy(prepared, &strike).0
    };
    let [whole, cracked] = [&*WHOLE, &*HALF].map(pulled);
    println!("energy of pulling the sides apart: {:.2} times the whole block's", cracked / whole);
    assert!((cracked / whole / SLIT - 1.0).abs() < 0.25, "{cracked} {whole}");
}

#[test]
fn a_crack_through_the_object_makes_two() {
    let prepared = check(shapes::cuboid(SIZE_M), [(); 2].map(|()| sheet([-0.12, 0.12], [-0.12, 0.12])), 2);
    let side = |body: usize| prepared.bodies[body].crack.center().x.signum();
    assert_eq!(side(0) * side(1), -1.0);
    for body in &prepared.bodies {
        let one = body.crack.center().x.signum();
        assert!(body.crack.nodes.iter().all(|node| node.x * one > 0.0));
    }
}

#[test]
fn crack_results_are_invariant_under_motion_and_scale() {
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, 0.5, -0.4));
    let turned = |point: Point3<f64>| turn * point + Vector3::new(3.0, -1.0, 2.0);
    let sheets = [half_depth(), sheet([END_M, 0.12], [-0.12, 0.12])].map(|sheet| moved(sheet, turned));
    let other = check(moved(shapes::cuboid(SIZE_M), turned), sheets, 1);
    let [one, other] = [&*HALF, &other].map(|prepared| {
        let cracks = prepared.report.cracks.unwrap();
        // Half the section; the slot's end is round.
        [cracks.area_m2, cracks.volume_m3 / (cracks.width_m * 0.02)]
    });
    println!("area and slot over what it should be: {one:?}, turned {other:?}");
    assert!((one[0] - 0.0288).abs() < 1e-12 && (other[0] - 0.0288).abs() < 1e-12);
    assert!([one[1], other[1]].iter().all(|share| (0.8..1.1).contains(share)));
    let larger = |point: Point3<f64>| point * 4.0;
    let large = baked(moved(shapes::cuboid(SIZE_M), larger), Some(moved(half_depth(), larger))).unwrap();
    assert!(large.bodies[0].crack == HALF.bodies[0].crack);
    assert_eq!(large.report.cracks.unwrap().width_m, 4.0 * HALF.report.cracks.unwrap().width_m);
}

/// The bytes of a database.
fn bytes(prepared: &PreparedObject) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("thing.shatter");
    save(prepared, &path).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn bytes_depend_on_where_a_crack_is_and_not_on_which_way_it_faces() {
    let mut flipped = half_depth();
    flipped.triangles.iter_mut().for_each(|[a, b, c]| (*a, *b, *c) = (*c, *b, *a));
    let flipped = baked(shapes::cuboid(SIZE_M), Some(flipped)).unwrap();
    assert!(bytes(&HALF) == bytes(&flipped));
    let other = sheet([0.01, 0.12], [-0.12, 0.12]);
    let surface = Surface::repair(shapes::cuboid(SIZE_M)).unwrap();
    let hash = |cracks: &RawMesh| input_hash(&surface, Some(&CrackSheets::new(cracks, &surface.frame).unwrap()));
    assert_eq!(hash(&half_depth()), HALF.report.input_hash);
    assert!(hash(&other) != HALF.report.input_hash && HALF.report.input_hash != WHOLE.report.input_hash);
    assert!(String::from_utf8_lossy(&bytes(&WHOLE)).contains(r#"\"cracks\":null"#));
}

#[test]
fn invalid_cracks_are_reported_or_rejected() {
    let outside = moved(half_depth(), |point| point + Vector3::new(0.0, 0.5, 0.0));
    let both = |mut cracks: RawMesh, more: &RawMesh| {
        let first = cracks.positions_m.len() as u32;
        cracks.positions_m.extend(&more.positions_m);
        cracks.triangles.extend(more.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
        cracks
    };
    let prepared = baked(shapes::cuboid(SIZE_M), Some(both(half_depth(), &outside))).unwrap();
    let [named] = &prepared.report.defects[..] else { panic!("{:?}", prepared.report.defects) };
    assert_eq!((named.kind, named.count, named.first_index), (DefectKind::IdleCrack, 1, 2));
    assert!(prepared.bodies[0].crack == HALF.bodies[0].crack);
    let slices =
        (-9..10).map(|k| moved(sheet([-0.2, 0.2], [-0.2, 0.2]), |point| point + Vector3::x() * (0.02 * f64::from(k))));
    let slices = slices.reduce(|sum, next| both(sum, &next)).unwrap();
    let mut flat = half_depth();
    flat.triangles = vec![[0, 0, 1]];
    let tiny = moved(half_depth(), |point| Point3::new(0.1, 0.05, 0.05) + 1e-4 * point.coords);
    for (cracks, words) in [
        (
            outside,
            "existing cracks: the nearest is 4.00e-1 m away from the object. They extend from [0.0000, 0.5000, -0.1200]",
        ),
        (tiny, "at crack spacing 0.04000: make the cracks larger than a slot is wide"),
        (slices, "existing cracks take"),
        (flat, "existing cracks: every triangle is degenerate"),
        (moved(half_depth(), |point| point * f64::NAN), "existing cracks: vertex 0, counted from 0, has a coordinate"),
        (RawMesh::new(Vec::new(), Vec::new()), "existing cracks: no vertices were found"),
    ] {
        let error = baked(shapes::cuboid(SIZE_M), Some(cracks)).err().unwrap().to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// A tiny sheet at the surface, whose slot takes less than the fit of the boundary changes.
#[test]
fn a_slot_without_volume_gives_a_valid_database() {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let glass = materials.get("glass").unwrap().clone();
    let with = |cracks: Option<RawMesh>| {
        let request = BakeRequest { tables: Tables::NONE, cracks, ..BakeRequest::new("mug", "glass", glass.clone()) };
        bake(shapes::mug(), &request, &CancelToken::default(), &mut |_| {}).unwrap()
    };
    let whole = with(None);
    let nodes = &whole.bodies[0].crack.nodes;
    let at = whole.frame.to_meters(&nodes[nodes.len() / 3]);
    let cracked = with(Some(moved(half_depth(), |point| at + 1e-4 * point.coords)));
    assert_eq!(cracked.report.cracks.unwrap().volume_m3, 0.0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mug.shatter");
    save(&cracked, &path).unwrap();
    let loaded = load(&path).unwrap();
    assert_eq!(loaded.report.lattice_volume_m3, cracked.report.lattice_volume_m3);
}
