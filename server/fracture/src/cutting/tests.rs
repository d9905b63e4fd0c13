use super::CuttingMesh;
use super::exposed_tests::rounded;
use crate::cancel_token::CancelToken;
use crate::database::{BakeRequest, Tables, load, save};
use crate::fragment::{OpenMesh, closed};
use crate::lattice::{FACES, Locator};
use crate::pipeline::{
    DegreeRequest, DisplacementMethod, FractureError, FractureMeshes, FractureOutcome, FractureRequest, PreparedObject,
    RequestContext, SurfaceKind, Workspace, strike_again,
};
use crate::random::RandomStream;
use crate::scene::{EffectKind, MATERIALS, Materials};
use crate::surface::{InsideTest, RawMesh, Surface, shapes};
use crate::tessellation::{CrackPoints, FixedPoints, LocalToMeters, Tessellation, TessellationWorkspace, components};
use crate::triangle::closest_point;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

const TABLES: Tables = Tables { interior: true, elastic: true, ..Tables::NONE };

fn request(spacing: f64) -> BakeRequest {
    let material = Materials::parse(MATERIALS).unwrap().get("ceramic").unwrap().clone();
    BakeRequest {
        surface: SurfaceKind::Exact,
        kappa: Some(1.0),
        elastic_spacing: Some(1.5 * spacing),
        crack_spacing: Some(spacing),
        tables: TABLES,
        ..BakeRequest::new("object", "ceramic", material)
    }
}

pub(super) fn baked(mesh: RawMesh, spacing: f64) -> PreparedObject {
    let prepared = request(spacing).bake(mesh).unwrap();
    assert_eq!(prepared.report.surface.reason, None);
    prepared
}

/// A request at a point of the surface, by number.
pub(super) fn strike(prepared: &PreparedObject, number: usize) -> FractureRequest {
    let body = &prepared.bodies[0];
    let cutting = body.cutting.as_ref().unwrap();
    let face = cutting.topology.boundary[number * 7919 % cutting.topology.boundary.len()];
    let point_m = prepared.frame.to_meters(&cutting.mesh.nodes[face.nodes[0] as usize]);
    let impulse_ns = (prepared.frame.center_m - point_m).normalize() * 10.0;
    let mut request = FractureRequest::at(point_m, impulse_ns).seeded(number as u64);
    request.contacts[0].radius_m = Some(0.1 * prepared.frame.diagonal_m);
    FractureRequest { degree: DegreeRequest::Sites(5 + 7 * number as u32), ..request }
}

pub(super) fn fragments(prepared: &PreparedObject, request: &FractureRequest) -> Box<crate::pipeline::Fracture> {
    match prepared.strike(request).unwrap() {
        FractureOutcome::Fractured(fracture) => fracture,
        FractureOutcome::Intact(report) => panic!("{report:?}"),
    }
}

/// Largest distance of an outer vertex from `inside`'s surface, local, and the outer area, m².
pub(super) fn outer(meshes: &FractureMeshes, prepared: &PreparedObject, inside: &InsideTest) -> (f64, f64) {
    let emitted = meshes.emitted().unwrap();
    let (mut worst, mut area): (f64, f64) = (0.0, 0.0);
    for fragment in emitted.fragments() {
        closed(fragment.positions, fragment.indices).unwrap();
        let center = Vector3::from(fragment.row.center_m);
        let place = |vertex: u32| Vector3::from(fragment.positions[vertex as usize]).cast::<f64>() + center;
        for run in &meshes.runs[fragment.row.run_first as usize..][..fragment.row.run_count as usize] {
            if run.crack {
                continue;
            }
            let first = (run.index_first - fragment.row.index_first) as usize;
            for triangle in fragment.indices[first..][..run.index_count as usize].chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|corner| place(triangle[corner]));
                area += (b - a).cross(&(c - a)).norm() / 2.0;
                let middle = prepared.frame.to_local(&((a + b + c) / 3.0).into());
                worst = worst.max(inside.distance(&middle));
            }
        }
    }
    (worst, area)
}

#[test]
fn fragments_end_on_the_input_surface_and_have_its_volume() {
    for (mesh, spacing) in
        [(shapes::statue_on(0.03), 0.06), (shapes::arch(), 0.05), (shapes::cuboid([0.3, 0.2, 0.1]), 0.08)]
    {
        let surface = Surface::repair(mesh.clone()).unwrap();
        let inside = InsideTest::new(&surface);
        let prepared = baked(mesh, spacing);
        let cubed = prepared.frame.diagonal_m.powi(3);
        let volume_m3 = surface.signed_volume() * cubed;
        let triangles = 0..surface.triangles.len();
        let area = triangles.map(|t| surface.corners(t)).map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0);
        let area_m2 = area.sum::<f64>() * prepared.frame.diagonal_m.powi(2);
        for number in 0..4 {
            let fracture = fragments(&prepared, &strike(&prepared, number));
            let rows = &fracture.meshes.fragments;
            assert!(rows.len() >= 2, "{} fragments", rows.len());
            let sum: f64 = rows.iter().map(|row| row.volume_m3).sum();
            assert!((sum / volume_m3 - 1.0).abs() < 1e-9, "{sum} of {volume_m3}");
            let (distance, outer_m2) = outer(&fracture.meshes, &prepared, &inside);
            assert!(distance < 2.0f64.powi(-23), "{distance}");
            assert!((outer_m2 / area_m2 - 1.0).abs() < 1e-6, "{outer_m2} of {area_m2}");
        }
    }
}

/// A box with triangles of the given heights on its top: their third corner is beside the middle of a long edge.
fn with_thin_triangles(heights: &[f64]) -> RawMesh {
    let mut mesh = shapes::cuboid([0.3, 0.2, 0.2]);
    let is_top = |own: &[u32; 3], mesh: &RawMesh| own.iter().all(|&vertex| mesh.positions_m[vertex as usize].y > 0.0);
    for &height in heights {
        let own = (0..mesh.triangles.len()).find(|own| is_top(&mesh.triangles[*own], &mesh)).unwrap();
        let [a, b, c] = mesh.triangles[own];
        let [p, q, r] = [a, b, c].map(|vertex| mesh.positions_m[vertex as usize]);
        let middle = nalgebra::center(&p, &q);
        let added = mesh.positions_m.len() as u32;
        mesh.positions_m.push(middle + (r - middle).normalize() * height);
        mesh.triangles.swap_remove(own);
        mesh.triangles.extend([[a, b, added], [b, c, added], [c, a, added]]);
    }
    mesh
}

/// Checks that fragments of any labels are closed: by points, and in single precision.
fn check_labels(cutting: &CuttingMesh, labels: &[u32], workspace: &mut TessellationWorkspace) {
    let split = components(&cutting.topology, labels);
    let (mut points, mut tessellation) = (CrackPoints::default(), Tessellation::default());
    let (mesh, topology) = (&cutting.mesh, &cutting.topology);
    points.find(mesh, topology, &split.labels, None, &FixedPoints::default()).unwrap();
    tessellation.build(mesh, topology, &split.labels, &points, workspace).unwrap();
    let mut properties = Vec::new();
    crate::fragment::properties(&tessellation, &mut properties);
    let centers: Vec<Point3<f64>> = properties.iter().map(|own| own.center).collect();
    let mut positions = vec![[0.0; 3]; tessellation.vertex_count()];
    let (mut indices, mut merges) = (vec![0; tessellation.index_count()], vec![[0; 2]; tessellation.merge_count()]);
    let transform = LocalToMeters { meters_per_unit: 0.3 };
    tessellation.emit(&centers, transform, &mut positions, &mut indices, &mut merges).unwrap();
    for fragment in tessellation.fragments() {
        let own = 3 * fragment.triangles.start..3 * fragment.triangles.end;
        match closed(&positions[fragment.vertices.clone()], &indices[own]) {
            // In single precision, the volume of the thinnest fragments has no sign.
            Err(OpenMesh::Volume { volume }) => assert!(volume.abs() < 1e-12, "{volume}"),
            found => found.unwrap(),
        }
    }
}

#[test]
fn any_labels_give_closed_fragments() {
    let mut workspace = TessellationWorkspace::default();
    let shapes = [
        (shapes::statue_on(0.03), 0.06),
        (shapes::arch(), 0.06),
        (with_thin_triangles(&[1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]), 0.08),
        (with_thin_triangles(&[1e-5; 6]), 0.08),
        (rounded(shapes::torus(0.1, 0.04, [48, 24])), 0.06),
    ];
    for (number, (mesh, spacing)) in (0..).zip(shapes) {
        let prepared = baked(mesh, spacing);
        let cutting = prepared.bodies[0].cutting.as_ref().unwrap();
        for seed in 0..50 {
            let mut stream = RandomStream::new(seed, number);
            let count = 2 + seed as u32 % 9;
            let mut any = || (stream.uniform() * f64::from(count)) as u32;
            // Labels of their own for some nodes, or of the nearest of a few nodes.
            let labels: Vec<u32> = match seed % 2 {
                0 => cutting.mesh.nodes.iter().map(|_| any()).collect(),
                _ => {
                    let nodes = &cutting.mesh.nodes;
                    let sites: Vec<Point3<f64>> =
                        (0..count).map(|_| nodes[(stream.uniform() * nodes.len() as f64) as usize]).collect();
                    let nearest = |node: &Point3<f64>| {
                        let distance = |site: &u32| (sites[*site as usize] - node).norm();
                        (0..count).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
                    };
                    nodes.iter().map(nearest).collect()
                }
            };
            check_labels(cutting, &labels, &mut workspace);
        }
    }
}

#[test]
fn strikes_on_thin_triangles_give_closed_fragments() {
    for heights in [[1e-4; 5], [1e-5; 5], [1e-6; 5], [1e-7; 5], [1e-8; 5]] {
        let prepared = baked(with_thin_triangles(&heights), 0.05);
        for number in 0..12 {
            let fracture = fragments(&prepared, &strike(&prepared, number));
            let emitted = fracture.meshes.emitted().unwrap();
            emitted.fragments().for_each(|fragment| closed(fragment.positions, fragment.indices).unwrap());
        }
    }
}

#[test]
fn a_stored_object_breaks_as_the_baked_one() {
    let prepared = baked(shapes::statue_on(0.03), 0.06);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("object.shatter");
    save(&prepared, &file).unwrap();
    let loaded = load(&file).unwrap();
    assert_eq!(loaded.bodies[0].cutting, prepared.bodies[0].cutting);
    let both = [&prepared, &loaded].map(|own| {
        let fracture = fragments(own, &strike(own, 2));
        let emitted = fracture.meshes.emitted().unwrap();
        (emitted.positions.clone(), emitted.indices.clone(), fracture.meshes.fragments.clone())
    });
    assert_eq!(both[0], both[1]);
}

#[test]
fn the_lattice_can_be_had() {
    let prepared = baked(shapes::statue_on(0.03), 0.06);
    // The bases stem from impacts on different surfaces.
    let exact = FractureRequest { elastic: DisplacementMethod::Solve, ..strike(&prepared, 1) };
    let lattice = FractureRequest { surface: SurfaceKind::Lattice, ..exact.clone() };
    let plain = BakeRequest { surface: SurfaceKind::Lattice, ..request(0.06) }.bake(shapes::statue_on(0.03)).unwrap();
    let [own, other] = [(&prepared, &lattice), (&plain, &exact)]
        .map(|(object, request)| fragments(object, request).meshes.emitted().unwrap().positions.clone());
    assert_eq!(own, other);
}

/// A box whose sides have texture coordinates far from each other, and one material each.
fn painted() -> RawMesh {
    let mut mesh = shapes::cuboid([0.3, 0.2, 0.1]);
    let side = |triangle: &[u32; 3]| side(&triangle.map(|vertex| mesh.positions_m[vertex as usize]));
    mesh.attributes.materials = mesh.triangles.iter().map(|own| side(own) as u32).collect();
    let names = ["left", "right", "bottom", "top", "back", "front"];
    mesh.attributes.names = names.map(str::to_owned).to_vec();
    mesh.attributes.colors = mesh.triangles.iter().map(|own| [color(side(own)); 3]).collect();
    let uv = |own: &[u32; 3]| own.map(|vertex| painted_uv(side(own), &mesh.positions_m[vertex as usize]));
    mesh.attributes.uvs = mesh.triangles.iter().map(uv).collect();
    mesh.attributes.uvs2 = mesh.attributes.uvs.iter().map(|own| own.map(|[u, v]| [-v, u + 1.0])).collect();
    mesh
}

/// Color of a side of the painted box.
fn color(side: usize) -> [f32; 4] {
    [side as f32 / 5.0, 0.2, 1.0, 0.8]
}

/// Side of the box on which a triangle lies.
fn side(corners: &[Point3<f64>; 3]) -> usize {
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let axis = normal.iamax();
    2 * axis + usize::from(normal[axis] > 0.0)
}

fn painted_uv(side: usize, place: &Point3<f64>) -> [f32; 2] {
    let axis = side / 2;
    [3.0 * side as f64 + place[(axis + 1) % 3], 2.0 * place[(axis + 2) % 3]].map(|x| x as f32)
}

/// Checks normals, texture coordinates and materials of all outer faces of a broken [`painted`] box.
fn check_paint(meshes: &FractureMeshes) {
    let emitted = meshes.emitted().unwrap();
    let mut checked = 0;
    for fragment in emitted.fragments() {
        closed(fragment.positions, fragment.indices).unwrap();
        let (first, skin) = (fragment.row.vertex_first as usize, &meshes.skins.rows[fragment.row.id as usize]);
        let place = |vertex: u32| {
            Point3::from(fragment.positions[vertex as usize]).cast::<f64>() + Vector3::from(fragment.row.center_m)
        };
        let runs = &meshes.runs[fragment.row.run_first as usize..][..fragment.row.run_count as usize];
        for run in runs.iter().filter(|run| !run.crack) {
            let own =
                &fragment.indices[(run.index_first - fragment.row.index_first) as usize..][..run.index_count as usize];
            assert_eq!(own, &meshes.skins.indices[skin.index_first as usize..][..skin.index_count as usize]);
            for (number, triangle) in own.chunks(3).enumerate() {
                let corners = [0, 1, 2].map(|k| place(triangle[k]));
                let side = side(&corners);
                assert_eq!(meshes.attributes.materials[run.index_first as usize / 3 + number], side as u32);
                for (vertex, corner) in triangle.iter().zip(corners) {
                    let found = meshes.attributes.vertices[first + *vertex as usize];
                    let skinned = meshes.skins.vertices[skin.vertex_first as usize + *vertex as usize];
                    assert_eq!((skinned.uv, skinned.normal), (found.uv, found.normal));
                    assert_eq!(skinned.position_m, fragment.positions[*vertex as usize]);
                    let second = meshes.attributes.uvs2[first + *vertex as usize];
                    assert!((0..2).all(|k| (second[k] - [-found.uv[1], found.uv[0] + 1.0][k]).abs() < 1e-5));
                    let painted = color(side).map(|x| (x * 255.0).round() as u8);
                    assert_eq!(meshes.attributes.colors[first + *vertex as usize], painted);
                    let skinned = skin.vertex_first as usize + *vertex as usize;
                    assert_eq!((meshes.skins.uvs2[skinned], meshes.skins.colors[skinned]), (second, painted));
                    let wanted = painted_uv(side, &corner);
                    assert!((0..2).all(|k| (found.uv[k] - wanted[k]).abs() < 1e-5), "{:?} {wanted:?}", found.uv);
                    let outward = if side % 2 == 1 { 1.0 } else { -1.0 };
                    assert_eq!(found.normal[side / 2], outward);
                    checked += 1;
                }
            }
        }
        check_merges(fragment.indices, fragment.merges);
    }
    assert!(checked > 1000, "{checked}");
}

/// Checks that the triangles are closed by index once merged vertices are one.
fn check_merges(indices: &[u32], merges: &[[u32; 2]]) {
    let merged: BTreeMap<u32, u32> = merges.iter().map(|&[from, to]| (from, to)).collect();
    let root = |vertex: u32| merged.get(&vertex).map_or(vertex, |&to| *merged.get(&to).unwrap_or(&to));
    let mut balance: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for triangle in indices.chunks(3) {
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(root);
            *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    assert!(balance.values().all(|sum| *sum == 0));
}

#[test]
fn attributes_are_those_of_the_input_on_both_sides_of_a_seam() {
    let tables = Tables { attributes: true, skin: true, ..TABLES };
    let prepared = BakeRequest { tables, ..request(0.08) }.bake(painted()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("object.shatter");
    save(&prepared, &file).unwrap();
    let loaded = load(&file).unwrap();
    assert_eq!(loaded.bodies[0].cutting, prepared.bodies[0].cutting);
    assert_eq!((&loaded.bodies[0].outer, &loaded.skin), (&prepared.bodies[0].outer, &prepared.skin));
    assert!(loaded.attribute_kinds().is_more_than_first_uvs());
    for number in 0..3 {
        let request = strike(&loaded, number);
        let effects = request.effects.with(EffectKind::Skin).with(EffectKind::Attributes);
        let painted = fragments(&loaded, &FractureRequest { effects, ..request.clone() });
        check_paint(&painted.meshes);
        let plain = fragments(&loaded, &request);
        let rows = |fracture: &crate::pipeline::Fracture| {
            fracture.meshes.fragments.iter().map(|row| (row.volume_m3, row.center_m)).collect::<Vec<_>>()
        };
        assert_eq!(rows(&painted), rows(&plain));
        assert!(painted.meshes.counts.vertices > plain.meshes.counts.vertices);
    }
}

#[test]
fn a_fragment_can_be_struck_again() {
    let prepared = BakeRequest { tables: Tables { attributes: true, skin: true, ..TABLES }, ..request(0.05) };
    let prepared = prepared.bake(painted()).unwrap();
    let inside = InsideTest::new(&Surface::repair(painted()).unwrap());
    let first = strike(&prepared, 0);
    let effects = first.effects.with(EffectKind::Skin).with(EffectKind::Attributes);
    let first = fragments(&prepared, &FractureRequest { degree: DegreeRequest::Sites(3), effects, ..first });
    let kept = first.meshes.keep();
    let mut broken = 0;
    for row in &first.meshes.fragments {
        let mut again = FractureRequest::at(row.center_m.into(), Vector3::new(5.0, 1.0, 0.0));
        again.contacts[0].radius_m = Some(1.0);
        let again = FractureRequest { degree: DegreeRequest::Sites(6), effects, ..again };
        let token = CancelToken::default();
        let context = RequestContext::new(&prepared, &again, &token, &());
        let outcome = match strike_again(context, (&kept, row.id), &mut Workspace::default()) {
            Err(FractureError::FragmentUndivided { .. }) => continue,
            outcome => outcome.unwrap(),
        };
        let FractureOutcome::Fractured(fracture) = outcome else { panic!("intact") };
        let rows = &fracture.meshes.fragments;
        assert!(rows.len() > 1);
        let sum: f64 = rows.iter().map(|row| row.volume_m3).sum();
        assert!((sum / row.volume_m3 - 1.0).abs() < 1e-9, "{sum} of {}", row.volume_m3);
        check_paint(&fracture.meshes);
        assert!(outer(&fracture.meshes, &prepared, &inside).0 < 2.0f64.powi(-23));
        broken += 1;
    }
    assert!(broken >= 2, "{broken}");
}

#[test]
fn an_open_mesh_keeps_the_lattice_and_says_why() {
    // A bowl without thickness: its rim is no small hole.
    let mut bowl = shapes::sphere(0.1, 4);
    let is_low = |own: &[u32; 3]| own.iter().all(|&vertex| bowl.positions_m[vertex as usize].y < 1e-6);
    bowl.triangles = bowl.triangles.iter().filter(|own| is_low(own)).copied().collect();
    let prepared = request(0.05).bake(bowl).unwrap();
    assert!(prepared.bodies[0].cutting.is_none() && prepared.report.surface.repairs.is_empty());
    let reason = prepared.report.surface.reason.unwrap();
    assert!(
        reason.starts_with("the mesh is open") && reason.ends_with(", in meters; mend the mesh there and bake again"),
        "{reason}"
    );
    let place: Vec<f64> = reason.split(['(', ')']).nth(1).unwrap().split(", ").map(|x| x.parse().unwrap()).collect();
    let distance = (place[0].hypot(place[2]) - 0.1).hypot(place[1]);
    assert!(distance < 0.02, "{reason}, not at the rim");
}

#[test]
fn a_fin_that_the_lattice_lost_keeps_its_shape() {
    // A plate of 0.3 spacings on a block.
    let spacing = 0.05;
    let prepared = baked(fin(0.3 * spacing), spacing);
    let cutting = prepared.bodies[0].cutting.as_ref().unwrap();
    assert!(cutting.anchored_count() > 0);
    let fracture = fragments(&prepared, &strike(&prepared, 0));
    let sum: f64 = fracture.meshes.fragments.iter().map(|row| row.volume_m3).sum();
    assert!((sum / prepared.report.input_volume_m3 - 1.0).abs() < 1e-9);
}

#[test]
fn carriers_hold_a_nearest_point_of_the_lattice() {
    // The boundary of the lattice is not convex, so a descent may end beside the nearest point: 0.0067 farther here. The bound is
    // half a spacing.
    const EXCESS_MAX: f64 = 0.025;
    let prepared = baked(fin(0.015), 0.05);
    let body = &prepared.bodies[0];
    let cutting = body.cutting.as_ref().unwrap();
    let locator = Locator::new(&body.crack);
    let (mut checked, mut excess) = (0, 0f64);
    for (node, carrier) in cutting.mesh.nodes.iter().zip(&cutting.carriers) {
        let Some(nearest) = locator.nearest(node).filter(|_| locator.containing(node, None).is_none()) else {
            continue;
        };
        let corners = body.crack.corners(carrier.tet as usize);
        let faces = FACES.map(|face| closest_point(&face.map(|corner| corners[corner]), node));
        let distance = faces.iter().map(|place| (place - node).norm()).fold(f64::INFINITY, f64::min);
        excess = excess.max(distance - nearest.distance);
        if carrier.is_anchored {
            let place =
                corners.iter().zip(carrier.weights).map(|(own, weight)| own.coords * weight).sum::<Vector3<f64>>();
            assert!((place - node.coords).norm() <= distance + 1e-9, "{node}: {place}, not {}", nearest.point);
        }
        checked += 1;
    }
    assert!(checked > 100 && cutting.anchored_count() > 0, "{checked}");
    assert!(excess < EXCESS_MAX, "{excess}");
}

#[test]
fn values_do_not_jump_over_a_gap() {
    // Two walls on a base, as wide as the base; the gap between them is narrower than the walls.
    let (spacing, gap) = (0.05, 0.07);
    let outline = [
        [-0.3, -0.3],
        [0.3, -0.3],
        [0.3, 0.4],
        [gap / 2.0, 0.4],
        [gap / 2.0, -0.1],
        [-gap / 2.0, -0.1],
        [-gap / 2.0, 0.4],
        [-0.3, 0.4],
    ];
    let prepared =
        baked(extruded(&outline, &[[0, 1, 5], [1, 4, 5], [1, 2, 4], [2, 3, 4], [0, 5, 7], [5, 6, 7]]), spacing);
    let body = &prepared.bodies[0];
    let cutting = body.cutting.as_ref().unwrap();
    let mut checked = 0;
    for (node, carrier) in cutting.mesh.nodes.iter().zip(&cutting.carriers) {
        let at = prepared.frame.to_meters(node);
        if at.y > 0.0 {
            let center =
                body.crack.corners(carrier.tet as usize).iter().map(|own| own.coords).sum::<Vector3<f64>>() / 4.0;
            assert!(at.x * prepared.frame.to_meters(&center.into()).x > 0.0, "{at}");
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked}");
}

/// A block with a thin plate on its top; its diagonal is about 1 m.
fn fin(width: f64) -> RawMesh {
    let half = width / 2.0;
    let outline =
        [[-0.3, -0.3], [0.3, -0.3], [0.3, 0.1], [half, 0.1], [half, 0.4], [-half, 0.4], [-half, 0.1], [-0.3, 0.1]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 6], [0, 6, 7], [3, 4, 5], [3, 5, 6]])
}

/// A closed surface with this cross-section in x and y, counter-clockwise, which `caps` triangulate, between z = -0.25 m and
/// 0.25 m.
fn extruded(outline: &[[f64; 2]], caps: &[[u32; 3]]) -> RawMesh {
    let count = outline.len() as u32;
    let ends = [-0.25, 0.25].iter();
    let positions = ends.flat_map(|&z| outline.iter().map(move |&[x, y]| Point3::new(x, y, z))).collect();
    let mut triangles = Vec::new();
    for k in 0..count {
        let next = (k + 1) % count;
        triangles.extend([[k, next, count + next], [k, count + next, count + k]]);
    }
    for &[a, b, c] in caps {
        triangles.extend([[a, c, b], [count + a, count + b, count + c]]);
    }
    RawMesh::new(positions, triangles)
}
