//! Fragments of real meshes whose outer faces are the input surface itself.

use nalgebra::{Point3, Vector3};
use rayon::ThreadPoolBuilder;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::cutting::{CuttingMesh, RepairKind};
use shatter_fracture::database::{BakeRequest, Tables};
use shatter_fracture::fragment::closed;
use shatter_fracture::pipeline::{
    DegreeRequest, DisplacementMethod, ElementChoice, EmittedMeshes, Fracture, FractureOutcome, FractureRequest,
    PreparedObject, Preset, SurfaceKind,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::EffectKind;
use shatter_fracture::surface::{InsideTest, RawMesh, Surface, shapes};
use shatter_tests::real;
use std::f64::consts::{PI, TAU};

/// Meshes of `SHATTER_MESHES` that conform.
const EXACT: [&str; 3] = ["cheburashka.obj", "fandisk.obj", "spot.obj"];

/// Meshes that conform after repairs, with these.
pub(crate) const REPAIRED: [(&str, &[RepairKind]); 5] = [
    ("cow.obj", &[RepairKind::UnitedParts, RepairKind::HiddenTriangles, RepairKind::DividedVertices]),
    ("horse.ply", &[RepairKind::UnitedParts, RepairKind::HiddenTriangles]),
    ("stanford-bunny.obj", &[RepairKind::FilledHoles, RepairKind::UnitedParts]),
    (
        "suzanne.obj",
        &[
            RepairKind::DuplicateTriangles,
            RepairKind::FilledHoles,
            RepairKind::UnitedParts,
            RepairKind::HiddenTriangles,
        ],
    ),
    (
        "teapot.obj",
        &[RepairKind::FilledHoles, RepairKind::UnitedParts, RepairKind::HiddenTriangles, RepairKind::CollapsedEdges],
    ),
];

/// Meshes that do not, with a part of the reason.
const LATTICE: [(&str, &str); 1] = [("beetle.obj", "the mesh is open")];

fn request(name: &str) -> BakeRequest {
    BakeRequest {
        surface: SurfaceKind::Exact,
        kappa: Some(1.5),
        // Nothing here judges energies.
        elastic: DisplacementMethod::Solve,
        elements: ElementChoice::Linear,
        tables: Tables { elastic: true, interior: true, attributes: true, skin: true, ..Tables::NONE },
        ..real::request(name, "ceramic")
    }
}

/// A request at a point of the surface, by number.
fn strike(prepared: &PreparedObject, number: u64) -> FractureRequest {
    let cutting = prepared.bodies[0].cutting.as_ref().unwrap();
    let boundary = &cutting.topology.boundary;
    let face = boundary[RandomStream::new(9, number).bits() as usize % boundary.len()];
    let point_m = prepared.frame.to_meters(&cutting.mesh.nodes[face.nodes[0] as usize]);
    let request = FractureRequest::at(point_m, prepared.frame.center_m - point_m).seeded(number);
    let effects = request.effects.with(EffectKind::Skin).with(EffectKind::Attributes);
    FractureRequest { degree: DegreeRequest::Sites(5 + 5 * number as u32), effects, ..request }
}

fn fracture(prepared: &PreparedObject, request: &FractureRequest) -> Box<Fracture> {
    match prepared.strike(request).unwrap() {
        FractureOutcome::Fractured(fracture) => fracture,
        FractureOutcome::Intact(report) => panic!("{report:?}"),
    }
}

/// Volume of all fragments from single-precision positions, outer area, and largest distance of outer faces from the
/// input over the largest coordinate.
fn measured(
    fracture: &Fracture,
    emitted: &EmittedMeshes<'_>,
    prepared: &PreparedObject,
    inside: &InsideTest,
) -> [f64; 3] {
    let [mut volume, mut area, mut distance] = [0.0f64; 3];
    let largest = prepared.frame.center_m.coords.amax() + prepared.frame.diagonal_m / 2.0;
    for fragment in emitted.fragments() {
        let own = |vertex: u32| Point3::from(fragment.positions[vertex as usize]).cast::<f64>();
        for triangle in fragment.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| own(triangle[k]).coords);
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        let runs = &fracture.meshes.runs[fragment.row.run_first as usize..][..fragment.row.run_count as usize];
        for run in runs.iter().filter(|run| !run.crack) {
            let first = (run.index_first - fragment.row.index_first) as usize;
            for (number, triangle) in fragment.indices[first..][..run.index_count as usize].chunks(3).enumerate() {
                let center = Vector3::from(fragment.row.center_m);
                let [a, b, c] = [0, 1, 2].map(|k| own(triangle[k]) + center);
                area += (b - a).cross(&(c - a)).norm() / 2.0;
                if number % 50 == 0 {
                    let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
                    let apart = inside.distance(&prepared.frame.to_local(&middle)) * prepared.frame.diagonal_m;
                    distance = distance.max(apart / largest);
                }
            }
        }
    }
    [volume, area, distance]
}

/// Area of a surface, m².
fn area_m2(surface: &Surface) -> f64 {
    let area = |triangle| {
        let [a, b, c] = surface.corners(triangle);
        (b - a).cross(&(c - a)).norm() / 2.0
    };
    (0..surface.triangles.len()).map(area).sum::<f64>() * surface.frame.diagonal_m.powi(2)
}

fn check(request: &BakeRequest, mesh: &RawMesh) {
    let name = &request.name;
    let prepared = request.bake(mesh.clone()).unwrap();
    assert_eq!(prepared.report.surface.repairs, [], "{name}");
    let surface = Surface::repair(mesh.clone()).unwrap();
    let volume = surface.signed_volume() * surface.frame.diagonal_m.powi(3);
    assert!((prepared.volume_m3() / volume - 1.0).abs() < 1e-9, "{name}: the object has another volume than its mesh");
    strikes(name, &prepared, &InsideTest::new(&surface), area_m2(&surface));
}

/// Strikes an object ten times. The outer area must be `area` each time, and the outer faces must be on the surface of `inside`.
fn strikes(name: &str, prepared: &PreparedObject, inside: &InsideTest, area: f64) {
    assert_eq!((prepared.report.surface.kind, &prepared.report.surface.reason), (SurfaceKind::Exact, &None), "{name}");
    let volume = prepared.volume_m3();
    for number in 0..10 {
        let fracture = fracture(prepared, &strike(prepared, number));
        let emitted = fracture.meshes.emitted().unwrap();
        emitted.fragments().for_each(|fragment| closed(fragment.positions, fragment.indices).unwrap());
        let sum: f64 = fracture.meshes.fragments.iter().map(|row| row.volume_m3).sum();
        assert!((sum / volume - 1.0).abs() < 1e-9, "{name}: {sum} of {volume}");
        let [single, outer, distance] = measured(&fracture, &emitted, prepared, inside);
        assert!((single / volume - 1.0).abs() < 1e-6, "{name}: {single} of {volume}");
        assert!((outer / area - 1.0).abs() < 1e-6, "{name}: {outer} of {area}");
        assert!(distance < 2.0f64.powi(-23), "{name}: {distance:e}");
    }
}

#[test]
fn real_meshes_break_into_closed_pieces_of_their_own_surface() {
    for name in EXACT {
        if let Some(mesh) = real::raw(name) {
            check(&request(name), &mesh);
        }
    }
}

/// A search for one of its triangles has no gain, but leaves that triangle in the mesh.
#[test]
fn a_head_is_exact_beside_the_coarsest_lattices() {
    check(&BakeRequest { quality: Preset::Draft, ..request("head") }, &shapes::head());
}

/// Cutting meshes have the area of the input, but for what was added or is inside the solid.
#[test]
fn real_meshes_are_repaired_and_break_into_closed_pieces() {
    for (name, kinds) in REPAIRED {
        let Some(mesh) = real::raw(name) else { continue };
        let quality = if name == "cow.obj" { Preset::Film } else { Preset::Game };
        let elastic_spacing = Some(0.04);
        let prepared = BakeRequest { quality, elastic_spacing, ..request(name) }.bake(mesh.clone()).unwrap();
        let repairs = &prepared.report.surface.repairs;
        println!("{name}: {:?}", prepared.report.surface);
        assert_eq!(repairs.iter().map(|own| own.kind).collect::<Vec<_>>(), kinds, "{name}");
        assert!(repairs.iter().all(|own| own.count > 0 && !own.places_m.is_empty()), "{name}");
        let surface = Surface::repair(mesh).unwrap();
        let (sampled, volume) = (InsideTest::new(&surface).input_volume(&CancelToken::default()), prepared.volume_m3());
        let sampled = sampled.unwrap() * surface.frame.diagonal_m.powi(3);
        assert!((volume / sampled - 1.0).abs() < 3e-3, "{name}: {volume} m³ of {sampled} m³");
        let area: f64 = prepared.bodies.iter().map(|body| boundary_area(body.cutting.as_ref().unwrap())).sum();
        let area = area * surface.frame.diagonal_m.powi(2);
        let films = repairs.iter().filter(|own| own.kind == RepairKind::FilledHoles);
        let added: f64 = films.map(|own| own.area_m2).sum();
        println!("{name}: area {area} m², of the input {} m², films {added} m²", area_m2(&surface));
        let films = prepared.bodies.iter().flat_map(|body| boundary_corners(body.cutting.as_ref().unwrap()));
        let (positions, triangles) = films.fold((Vec::new(), Vec::new()), |(mut positions, mut triangles), corners| {
            let first = positions.len() as u32;
            positions.extend(corners.map(|corner| prepared.frame.to_meters(&corner)));
            triangles.push([first, first + 1, first + 2]);
            (positions, triangles)
        });
        let whole = Surface::repair(RawMesh::new(positions, triangles)).unwrap();
        strikes(name, &prepared, &InsideTest::new(&whole), area);
    }
}

fn boundary_corners(cutting: &CuttingMesh) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
    cutting.topology.boundary.iter().map(|face| face.nodes.map(|node| cutting.mesh.nodes[node as usize]))
}

/// Area of a cutting mesh's boundary, local.
fn boundary_area(cutting: &CuttingMesh) -> f64 {
    boundary_corners(cutting).map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum()
}

#[test]
fn real_meshes_that_do_not_conform_keep_the_lattice_and_say_why() {
    for (name, reason) in LATTICE {
        let Some(mesh) = real::raw(name) else { continue };
        let tables = Tables { interior: true, ..Tables::NONE };
        let prepared = BakeRequest { tables, ..request(name) }.bake(mesh).unwrap();
        let surface = &prepared.report.surface;
        println!("{name}: {surface:?}");
        assert_eq!(surface.kind, SurfaceKind::Lattice, "{name}");
        assert!(surface.reason.as_ref().is_some_and(|found| found.starts_with(reason)), "{name}: {surface:?}");
        assert!(prepared.bodies.iter().all(|body| body.cutting.is_none()), "{name}");
    }
}

/// A torus with texture coordinates that turn once around its hole: every triangle has its own at a seam. The second set has its
/// seam elsewhere, and colors change at a third place.
fn textured() -> RawMesh {
    let mut mesh = shapes::torus(0.3, 0.1, [48, 24]);
    let corners = mesh.triangles.iter().map(|own| own.map(|vertex| mesh.positions_m[vertex as usize]));
    let turned = |points: &[Point3<f64>; 3], angle: fn(&Point3<f64>) -> f64| {
        let angles = points.each_ref().map(angle);
        angles.map(|own| own + TAU * f64::from(i8::from(angles[0] - own > PI) - i8::from(own - angles[0] > PI)))
    };
    let uvs = corners.clone().map(|points| {
        let angles = turned(&points, |point| point.z.atan2(point.x));
        [0, 1, 2].map(|k| [(angles[k] / TAU) as f32, (5.0 * points[k].y) as f32])
    });
    let uvs2 = corners.clone().map(|points| {
        let angles = turned(&points, |point| point.x.atan2(point.z));
        [0, 1, 2].map(|k| [(3.0 * points[k].y) as f32, (angles[k] / TAU) as f32])
    });
    let colors = corners.map(|points| {
        let half = if points.iter().map(|point| point.x + point.z).sum::<f64>() > 0.0 { 0.9 } else { 0.1 };
        points.map(|point| [0.5 + point.x, half, 0.5 + 4.0 * point.y, 0.5 - point.z].map(|x| x as f32))
    });
    (mesh.attributes.uvs, mesh.attributes.uvs2, mesh.attributes.colors) =
        (uvs.collect(), uvs2.collect(), colors.collect());
    mesh
}

/// Both sets of texture coordinates and the color at a point.
type Values = [f64; 8];

/// Largest errors of texture coordinates and of colors against the input's at points of its triangles, by a nearest triangle. Infinite
/// where the point is on none.
fn errors(mesh: &RawMesh, point: Point3<f64>, values: &Values) -> [f64; 2] {
    let mut best = [f64::INFINITY; 2];
    for (own, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|vertex| mesh.positions_m[vertex as usize]);
        let normal = (b - a).cross(&(c - a));
        let weight =
            |p: &Point3<f64>, q: &Point3<f64>| (q - p).cross(&(point - p)).dot(&normal) / normal.norm_squared();
        let weights = [weight(&b, &c), weight(&c, &a), weight(&a, &b)];
        let is_on =
            (point - a).dot(&normal).abs() < 1e-7 * normal.norm() && weights.iter().all(|weight| *weight > -1e-6);
        if is_on {
            let mean = |of: &dyn Fn(usize) -> f32| (0..3).map(|k| f64::from(of(k)) * weights[k]).sum::<f64>();
            let sets = [&mesh.attributes.uvs[own], &mesh.attributes.uvs2[own]];
            let uv = (0..4).map(|k| (mean(&|corner| sets[k / 2][corner][k % 2]) - values[k]).abs()).fold(0.0, f64::max);
            let colors = &mesh.attributes.colors[own];
            let color = (0..4).map(|k| (mean(&|corner| colors[corner][k]) - values[4 + k]).abs()).fold(0.0, f64::max);
            if uv + color < best[0] + best[1] {
                best = [uv, color];
            }
        }
    }
    best
}

/// The values of a vertex of a result.
fn values(uv: [f32; 2], uv2: [f32; 2], color: [u8; 4]) -> Values {
    let [r, g, b, a] = color.map(|x| f64::from(x) / 255.0);
    let [s, t, u, v] = [uv[0], uv[1], uv2[0], uv2[1]].map(f64::from);
    [s, t, u, v, r, g, b, a]
}

/// A corner of a triangle in the coordinates of the object.
type Corner = (Point3<f64>, Values);

/// Triangles of the outer runs.
fn outer_corners(fracture: &Fracture) -> Vec<[Corner; 3]> {
    let (emitted, attributes) = (fracture.meshes.emitted().unwrap(), &fracture.meshes.attributes);
    let mut outer = Vec::new();
    for fragment in emitted.fragments() {
        let runs = &fracture.meshes.runs[fragment.row.run_first as usize..][..fragment.row.run_count as usize];
        for run in runs.iter().filter(|run| !run.crack) {
            let first = (run.index_first - fragment.row.index_first) as usize;
            let corner = |&vertex: &u32| {
                let row = (fragment.row.vertex_first + vertex) as usize;
                let at = Point3::from(fragment.positions[vertex as usize]).cast::<f64>();
                let values = values(attributes.vertices[row].uv, attributes.uvs2[row], attributes.colors[row]);
                (at + Vector3::from(fragment.row.center_m), values)
            };
            let corners: Vec<_> = fragment.indices[first..][..run.index_count as usize].iter().map(corner).collect();
            outer.extend(corners.as_chunks::<3>().0.to_vec());
        }
    }
    outer
}

/// Triangles of the skins.
fn skin_corners(fracture: &Fracture) -> Vec<[Corner; 3]> {
    let skins = &fracture.meshes.skins;
    let mut all = Vec::new();
    for (row, fragment) in skins.rows.iter().zip(&fracture.meshes.fragments) {
        let corner = |&index: &u32| {
            let vertex = (row.vertex_first + index) as usize;
            let at = Point3::from(skins.vertices[vertex].position_m).cast::<f64>() + Vector3::from(fragment.center_m);
            (at, values(skins.vertices[vertex].uv, skins.uvs2[vertex], skins.colors[vertex]))
        };
        let own = &skins.indices[row.index_first as usize..][..row.index_count as usize];
        let corners: Vec<_> = own.iter().map(corner).collect();
        all.extend(corners.as_chunks::<3>().0.to_vec());
    }
    all
}

/// Checks both sets of texture coordinates and the colors at random points. Colors are rounded in the database and in the result.
fn check_random_points(what: &str, mesh: &RawMesh, results: &[Vec<[Corner; 3]>]) {
    let mut stream = RandomStream::new(11, 0);
    let (mut checked, mut worst) = (0, [0.0f64; 2]);
    for outer in results {
        for _ in 0..2000 {
            let [(a, p), (b, q), (c, r)] = outer[stream.bits() as usize % outer.len()];
            let (s, t) = (stream.uniform().sqrt(), stream.uniform());
            let weights = [1.0 - s, s * (1.0 - t), s * t];
            let point = Point3::from(a.coords * weights[0] + b.coords * weights[1] + c.coords * weights[2]);
            let mixed = std::array::from_fn(|k| p[k] * weights[0] + q[k] * weights[1] + r[k] * weights[2]);
            let found = errors(mesh, point, &mixed);
            if found[0].is_finite() {
                checked += 1;
                worst = [0, 1].map(|k| worst[k].max(found[k]));
            }
        }
    }
    println!("{what}: {checked} of {} points, largest errors {worst:?}", 2000 * results.len());
    assert!(checked > 1980 * results.len() && worst[0] < 1e-5, "{what}: {checked} points, {worst:?}");
    assert!(worst[1] < 1.01 / 255.0, "{what}: {worst:?}");
}

#[test]
fn textures_at_random_points_are_those_of_the_input() {
    let mesh = textured();
    let prepared = request("torus").bake(mesh.clone()).unwrap();
    assert_eq!(prepared.report.surface.reason, None);
    let exact: Vec<_> = (0..5).map(|number| outer_corners(&fracture(&prepared, &strike(&prepared, number)))).collect();
    check_random_points("outer faces", &mesh, &exact);
    let lattice = |number| FractureRequest { surface: SurfaceKind::Lattice, ..strike(&prepared, number) };
    let skins: Vec<_> = (0..5).map(|number| skin_corners(&fracture(&prepared, &lattice(number)))).collect();
    check_random_points("skins", &mesh, &skins);
}

/// A seam of one attribute alone: vertices on it are copied, and no others. Normals are smooth.
#[test]
fn seams_of_the_second_set_and_of_colors_are_copied() {
    let all = textured();
    let vertices = |keep: fn(&mut RawMesh, &RawMesh)| {
        let mut mesh = shapes::torus(0.3, 0.1, [48, 24]);
        keep(&mut mesh, &all);
        let prepared = request("torus").bake(mesh).unwrap();
        let fracture = fracture(&prepared, &strike(&prepared, 0));
        let emitted = fracture.meshes.emitted().unwrap();
        emitted.fragments().for_each(|fragment| closed(fragment.positions, fragment.indices).unwrap());
        let attributes = &fracture.meshes.attributes;
        let has = [attributes.uvs2.is_empty(), attributes.colors.is_empty()].map(|is_empty| !is_empty);
        (attributes.vertices.len(), has)
    };
    let (plain, none) = vertices(|_, _| ());
    assert_eq!(none, [false; 2]);
    let (second, has) = vertices(|mesh, all| mesh.attributes.uvs2.clone_from(&all.attributes.uvs2));
    assert!(has == [true, false] && second > plain && second < plain + plain / 10, "{second} of {plain}");
    let (colored, has) = vertices(|mesh, all| mesh.attributes.colors.clone_from(&all.attributes.colors));
    assert!(has == [false, true] && colored > plain && colored < plain + plain / 10, "{colored} of {plain}");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let Some(mesh) = real::raw("spot.obj") else { return };
    let results = [1, 2, 4].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let prepared = request("spot").bake(mesh.clone()).unwrap();
            let fracture = fracture(&prepared, &strike(&prepared, 4));
            let EmittedMeshes { positions, indices, merges, .. } = fracture.meshes.emitted().unwrap();
            (positions, indices, merges, fracture.meshes.skins.vertices.clone())
        })
    });
    assert!(results[0] == results[1] && results[1] == results[2]);
}
