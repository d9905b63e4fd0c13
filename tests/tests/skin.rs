//! Skins of fragments: the input's own triangles, and its attributes on their outer faces.

use nalgebra::{Point3, Vector3};
use shatter_fracture::accuracy::{NORMAL_DEG, NormalShares};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, BakeRequest, Tables, bake};
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureError, FractureMeshes, FractureRequest, PreparedObject, SkinVertexRow, Workspace,
};
use shatter_fracture::scene::{EffectKind, EffectSet, Grain, WarpControls};
use shatter_fracture::skin::Skin;
use shatter_fracture::surface::{NO_MATERIAL, RawMesh, Surface, TriangleAttributes, shapes};
use shatter_tests::{real, struck};
use std::collections::HashMap;
use std::sync::Arc;

const DRESSED: [EffectKind; 3] = [EffectKind::Attributes, EffectKind::Skin, EffectKind::Slivers];

fn baked(mesh: RawMesh, crack_spacing: f64) -> PreparedObject {
    baked_with(mesh, crack_spacing, None)
}

fn baked_with(mesh: RawMesh, crack_spacing: f64, cracks: Option<RawMesh>) -> PreparedObject {
    let request = BakeRequest {
        crack_spacing: Some(crack_spacing),
        elastic_spacing: Some(1.6 * crack_spacing),
        tables: Tables { interior: true, attributes: true, skin: true, ..Tables::NONE },
        cracks,
        ..real::request("dressed", "stone")
    };
    bake(mesh, &request, &CancelToken::default(), &mut |_| {}).unwrap()
}

fn request(prepared: &PreparedObject, sites: u32, more: &[EffectKind]) -> FractureRequest {
    let body = &prepared.bodies[0];
    let node = body.topology.boundary_nodes[body.topology.boundary_nodes.len() / 3];
    let point_m = prepared.frame.to_meters(&body.crack.nodes[node as usize]);
    let inward = prepared.frame.center_m - point_m;
    let effects = EffectSet::of(DRESSED.iter().chain(more).copied());
    FractureRequest { degree: DegreeRequest::Sites(sites), effects, seed: 3, ..FractureRequest::at(point_m, inward) }
}

/// Area of a mesh, m².
fn area_m2(mesh: &RawMesh) -> f64 {
    let surface = Surface::repair(mesh.clone()).unwrap();
    let area = |triangle| {
        let [a, b, c] = surface.corners(triangle);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    (0..surface.triangles.len()).map(area).sum::<f64>() * surface.frame.diagonal_m.powi(2)
}

/// Triangles of one fragment's skin, in the coordinates of the mesh file.
fn skin_triangles(pieces: &FractureMeshes, fragment: usize) -> Vec<[(Point3<f64>, SkinVertexRow); 3]> {
    let (row, skins) = (&pieces.skins.rows[fragment], &pieces.skins);
    let vertices = &skins.vertices[row.vertex_first as usize..][..row.vertex_count as usize];
    let indices = &skins.indices[row.index_first as usize..][..row.index_count as usize];
    let center = Vector3::from(pieces.fragments[fragment].center_m);
    let corner = |index: u32| {
        let vertex = vertices[index as usize];
        (Point3::from(vertex.position_m.map(f64::from)) + center, vertex)
    };
    indices.chunks_exact(3).map(|own| [corner(own[0]), corner(own[1]), corner(own[2])]).collect()
}

/// Outer vertices of one fragment, by run, in the coordinates of the mesh file.
fn outer(pieces: &FractureMeshes, fragment: usize, crack: bool) -> Vec<Point3<f64>> {
    let mut positions = vec![[0.0; 3]; pieces.counts.vertices];
    let (mut indices, mut merges) = (vec![0; pieces.counts.indices], vec![[0; 2]; pieces.counts.merges]);
    pieces.emit(&mut positions, &mut indices, &mut merges).unwrap();
    let center = Vector3::from(pieces.fragments[fragment].center_m);
    let row = &pieces.fragments[fragment];
    let runs = &pieces.runs[row.run_first as usize..][..row.run_count as usize];
    let own = runs.iter().filter(|run| run.crack == crack);
    own.flat_map(|run| &positions[run.vertex_first as usize..][..run.vertex_count as usize])
        .map(|position| Point3::from(position.map(f64::from)) + center)
        .collect()
}

/// Distances of the rim of a fragment's skin from the nearest vertex of its crack faces, m.
fn rim_m(pieces: &FractureMeshes, fragment: usize) -> Vec<f64> {
    let key = |point: &Point3<f64>| [point.x, point.y, point.z].map(f64::to_bits);
    let mut edges: HashMap<[[u64; 3]; 2], Option<Point3<f64>>> = HashMap::new();
    for corners in skin_triangles(pieces, fragment) {
        for k in 0..3 {
            let (from, to) = (corners[k].0, corners[(k + 1) % 3].0);
            if edges.insert([key(&from), key(&to)], Some(from)).is_some() {
                panic!("an edge twice");
            }
        }
    }
    let cracks = outer(pieces, fragment, true);
    let is_rim = |(ends, _): &(&[[u64; 3]; 2], &Option<Point3<f64>>)| !edges.contains_key(&[ends[1], ends[0]]);
    let rim = edges.iter().filter(is_rim).filter_map(|(_, from)| *from);
    rim.map(|from| cracks.iter().map(|crack| (crack - from).norm()).fold(f64::INFINITY, f64::min)).collect()
}

/// A database may hold a skin without triangles; it has no normals to compare with.
#[test]
fn a_skin_without_triangles_has_no_shares_of_normals() {
    let mut prepared = baked(shapes::cuboid([0.4, 0.3, 0.2]), 0.08);
    assert!(NormalShares::of(&prepared, NORMAL_DEG).is_some());
    let skin = Skin { triangles: Vec::new(), ..(**prepared.skin.as_ref().unwrap()).clone() };
    prepared.skin = Some(Arc::new(skin));
    assert_eq!(NormalShares::of(&prepared, NORMAL_DEG), None);
}

/// A skin ends where its fragment's crack faces begin, within a spacing.
#[test]
fn skins_end_at_the_cracks() {
    let spacing = 0.04;
    let prepared = baked(shapes::cuboid([0.4, 0.3, 0.2]), spacing);
    let pieces =
        struck::outcome(&prepared, &request(&prepared, 24, &[EffectKind::Interior])).unwrap().into_meshes().unwrap();
    let mut all: Vec<f64> = (0..pieces.fragments.len()).flat_map(|fragment| rim_m(&pieces, fragment)).collect();
    all.iter_mut().for_each(|gap| *gap /= spacing * prepared.frame.diagonal_m);
    all.sort_by(f64::total_cmp);
    let [median, most] = [all[all.len() / 2], all[all.len() - 1]];
    println!("{} rim vertices: median {median:.2}, most {most:.2} spacings from a vertex of their crack", all.len());
    assert!(all.len() > 500 && median < 0.35 && most < 1.0);
}

/// Checks the skins of a request: their area is the input's, and each lies on its fragment.
fn check(name: &str, mesh: RawMesh, spacing: f64, more: &[EffectKind], controls: Option<WarpControls>) {
    let input_m2 = area_m2(&mesh);
    let prepared = baked(mesh, spacing);
    let prepared = controls
        .iter()
        .fold(prepared, |prepared, controls| prepared.warped(controls, &CancelToken::default()).unwrap());
    let pieces = struck::outcome(&prepared, &request(&prepared, 24, more)).unwrap().into_meshes().unwrap();
    let diagonal_m = prepared.frame.diagonal_m;
    let (mut sum_m2, mut apart_m, mut count, mut far) = (0.0, 0.0f64, 0usize, 0usize);
    for fragment in 0..pieces.fragments.len() {
        let own = outer(&pieces, fragment, false);
        for corners in skin_triangles(&pieces, fragment) {
            let [a, b, c] = corners.map(|(point, _)| point);
            sum_m2 += 0.5 * (b - a).cross(&(c - a)).norm();
            let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            let distance = own.iter().map(|point| (point - middle).norm()).fold(f64::INFINITY, f64::min);
            count += 1;
            far += usize::from(distance > 2.0 * spacing * diagonal_m);
            if distance.is_finite() {
                apart_m = apart_m.max(distance);
            }
        }
        for (_, vertex) in skin_triangles(&pieces, fragment).into_iter().flatten() {
            assert!((Vector3::from(vertex.normal).norm() - 1.0).abs() < 1e-5);
        }
    }
    println!(
        "{name}: area {:+.1e}, {count} triangles for {}, farthest from its fragment {:.2} spacings, {far} farther than two",
        sum_m2 / input_m2 - 1.0,
        prepared.skin.as_ref().unwrap().triangles.len(),
        apart_m / diagonal_m / spacing,
    );
    assert!((sum_m2 / input_m2 - 1.0).abs() < 1e-5, "{sum_m2} of {input_m2} m²");
    assert_eq!(far, 0, "skin away from its fragment");
}

#[test]
fn skins_have_the_inputs_area_and_lie_on_their_fragments() {
    check("cuboid", shapes::cuboid([0.4, 0.3, 0.2]), 0.04, &[], None);
    check("mug", shapes::mug(), 0.022, &[EffectKind::Interior], None);
    check("statue", shapes::statue(), 0.025, &[EffectKind::Interior], None);
    let grain = Some(Grain { axis: Vector3::x(), ratio: 3.0 });
    let controls = Some(WarpControls { grain, ..WarpControls::default() });
    check("horseshoe, grain", shapes::horseshoe(), 0.03, &[EffectKind::Interior, EffectKind::Warp], controls);
}

#[test]
fn real_meshes_have_skins() {
    for name in ["horse.ply", "spot.obj", "beetle.obj"] {
        if let Some(mesh) = real::raw(name) {
            check(name, mesh, 0.02, &[EffectKind::Interior], None);
        }
    }
}

/// The slot of an existing crack has walls; skins cover them too, or one would see into the fragments.
#[test]
fn walls_of_existing_cracks_have_skin() {
    let corners = [[0.0, -0.2], [0.2, -0.2], [0.2, 0.2], [0.0, 0.2]].map(|[y, z]| Point3::new(0.0, y, z));
    let sheet = RawMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let spacing = 0.03;
    let prepared = baked_with(shapes::cuboid([0.4, 0.3, 0.2]), spacing, Some(sheet));
    let pieces =
        struck::outcome(&prepared, &request(&prepared, 12, &[EffectKind::Interior])).unwrap().into_meshes().unwrap();
    let whole_m2 = 2.0 * (0.4 * 0.3 + 0.3 * 0.2 + 0.2 * 0.4);
    let (mut sum_m2, mut bare) = (0.0, 0);
    for fragment in 0..pieces.fragments.len() {
        sum_m2 += skin_area_m2(&pieces, fragment);
        let skin_points: Vec<Point3<f64>> =
            skin_triangles(&pieces, fragment).into_iter().flatten().map(|(point, _)| point).collect();
        let reach = 1.5 * spacing * prepared.frame.diagonal_m;
        let has_skin = |point: &&Point3<f64>| skin_points.iter().any(|own| (own - **point).norm() < reach);
        let own = outer(&pieces, fragment, false);
        bare += own.len() - own.iter().filter(has_skin).count();
    }
    let walls_m2 = sum_m2 - whole_m2;
    println!("{walls_m2:.4} m² of walls beside {whole_m2} m²; {bare} vertices bare");
    assert!((0.8..1.3).contains(&(walls_m2 / (2.0 * 0.15 * 0.2))), "two walls of 0.15 by 0.2 m, and the slot's end");
    assert_eq!(bare, 0);
}

/// A block of two materials, with (x, y) as texture coordinates and normals of its own.
fn painted() -> RawMesh {
    let mut mesh = shapes::cuboid([0.4, 0.3, 0.2]);
    let points = |own: &[u32; 3]| own.map(|vertex| mesh.positions_m[vertex as usize]);
    let flat = |own: &[u32; 3]| {
        let [a, b, c] = points(own);
        let normal = (b - a).cross(&(c - a)).normalize();
        [[normal.x as f32, normal.y as f32, normal.z as f32]; 3]
    };
    let normals: Vec<[[f32; 3]; 3]> = mesh.triangles.iter().map(flat).collect();
    let uvs = mesh.triangles.iter().map(|own| points(own).map(|point| [point.x as f32, point.y as f32])).collect();
    let materials = normals.iter().map(|own| u32::from(own[0][1] > 0.5)).collect();
    let names = vec!["sides".into(), "top".into()];
    mesh.attributes = TriangleAttributes { normals, uvs, materials, names, ..TriangleAttributes::default() };
    mesh
}

#[test]
fn outer_faces_look_as_the_input() {
    let prepared = baked(painted(), 0.04);
    assert_eq!(prepared.report.materials, ["sides", "top"]);
    let pieces = struck::outcome(&prepared, &request(&prepared, 12, &[])).unwrap().into_meshes().unwrap();
    let mut positions = vec![[0.0; 3]; pieces.counts.vertices];
    let (mut indices, mut merges) = (vec![0; pieces.counts.indices], vec![[0; 2]; pieces.counts.merges]);
    pieces.emit(&mut positions, &mut indices, &mut merges).unwrap();
    assert_eq!(
        (pieces.attributes.vertices.len(), 3 * pieces.attributes.materials.len()),
        (positions.len(), indices.len())
    );
    let (mut tops, mut sides, mut wrong, mut tilted, mut outer) = (0, 0, 0, 0, 0);
    for run in &pieces.runs {
        let fragment = &pieces.fragments[run.fragment as usize];
        let vertices = run.vertex_first as usize..(run.vertex_first + run.vertex_count) as usize;
        let triangles = run.index_first as usize / 3..(run.index_first + run.index_count) as usize / 3;
        if run.crack {
            assert!(
                pieces.attributes.vertices[vertices]
                    .iter()
                    .all(|look| *look == pipeline::OuterVertexAttributes::default())
            );
            assert!(pieces.attributes.materials[triangles].iter().all(|material| *material == NO_MATERIAL));
            continue;
        }
        for (look, position) in pieces.attributes.vertices[vertices.clone()].iter().zip(&positions[vertices]) {
            let at = Vector3::from(position.map(f64::from)) + Vector3::from(fragment.center_m);
            for axis in 0..2 {
                assert!((f64::from(look.uv[axis]) - at[axis]).abs() < 2e-3, "{:?} at {at:?}", look.uv);
            }
            assert!((Vector3::from(look.normal).norm() - 1.0).abs() < 1e-5);
        }
        for triangle in triangles {
            let own = &indices[3 * triangle..][..3];
            let corner = |k: usize| Point3::from(positions[(fragment.vertex_first + own[k]) as usize]);
            let flat = (corner(1) - corner(0)).cross(&(corner(2) - corner(0))).normalize();
            let look =
                |k: usize| Vector3::from(pieces.attributes.vertices[(fragment.vertex_first + own[k]) as usize].normal);
            outer += 1;
            tilted += usize::from((0..3).any(|k| look(k).dot(&flat) < 0.7));
            match pieces.attributes.materials[triangle] {
                1 => tops += 1,
                0 => sides += 1,
                other => panic!("material {other}"),
            }
            wrong += usize::from((pieces.attributes.materials[triangle] == 1) != (flat.y > 0.7));
        }
    }
    println!(
        "{tops} triangles on top, {sides} on the sides, {wrong} wrong, {tilted} of {outer} with a normal of another side"
    );
    assert!(tops > 100 && sides > 300);
    assert!(wrong * 20 < outer, "edges alone may be rounded");
    assert!(tilted * 5 < outer);
    let skin_materials = &pieces.skins.materials;
    assert_eq!(3 * skin_materials.len(), pieces.skins.indices.len());
    let mut sum = [0.0; 2];
    for fragment in 0..pieces.fragments.len() {
        let first = pieces.skins.rows[fragment].index_first as usize / 3;
        for (place, corners) in skin_triangles(&pieces, fragment).into_iter().enumerate() {
            let [a, b, c] = corners.map(|(point, _)| point);
            let area = (b - a).cross(&(c - a)) * 0.5;
            sum[skin_materials[first + place] as usize] += area.norm();
            for (point, vertex) in corners {
                assert!((0..2).all(|axis| (f64::from(vertex.uv[axis]) - point[axis]).abs() < 1e-6), "{vertex:?}");
                assert!(Vector3::from(vertex.normal).cast::<f64>().dot(&area) > 0.9999 * area.norm());
            }
        }
    }
    let exact = [2.0 * (0.4 * 0.2 + 0.4 * 0.3 + 0.3 * 0.2) - 0.4 * 0.2, 0.4 * 0.2];
    (0..2).for_each(|k| assert!((sum[k] / exact[k] - 1.0).abs() < 1e-5, "{sum:?} of {exact:?}"));
}

#[test]
fn a_database_keeps_the_skin_to_the_bit_and_loads_it_where_it_is_wanted() {
    let prepared = baked(painted(), 0.05);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.shatter");
    database::save(&prepared, &path).unwrap();
    let whole = database::load(&path).unwrap();
    assert_eq!((&whole.skin, &whole.bodies[0].outer), (&prepared.skin, &prepared.bodies[0].outer));
    assert_eq!(whole.report, prepared.report);
    let bare = database::load_tables(&path, Tables { interior: true, ..Tables::NONE }).unwrap();
    assert!(bare.skin.is_none() && bare.bodies[0].outer.is_none());
    for effect in [EffectKind::Attributes, EffectKind::Skin] {
        let only = FractureRequest { effects: EffectSet::of([effect]), ..request(&bare, 8, &[]) };
        match struck::outcome(&bare, &only) {
            Err(FractureError::AttributesUnprepared { effect: named }) => assert_eq!(named, effect),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("{effect:?} came from nowhere"),
        }
    }
}

/// The largest fragment.
fn largest(pieces: &FractureMeshes) -> u32 {
    let volume = |fragment: &u32| pieces.fragments[*fragment as usize].volume_m3;
    (0..pieces.fragments.len() as u32).max_by(|a, b| volume(a).total_cmp(&volume(b))).unwrap()
}

/// Area of one fragment's skin, m².
fn skin_area_m2(pieces: &FractureMeshes, fragment: usize) -> f64 {
    let area = |corners: [(Point3<f64>, SkinVertexRow); 3]| {
        let [a, b, c] = corners.map(|(point, _)| point);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    skin_triangles(pieces, fragment).into_iter().map(area).sum()
}

/// Children have the skin of their parent, generation by generation, with the same attributes.
#[test]
fn child_fragments_inherit_the_skin() {
    let prepared = baked(painted(), 0.04);
    let mut pieces = struck::outcome(&prepared, &request(&prepared, 6, &[])).unwrap().into_meshes().unwrap();
    for generation in 1..3 {
        let (kept, parent) = (pieces.keep(), largest(&pieces));
        let before_m2 = skin_area_m2(&pieces, parent as usize);
        let mut again = request(&prepared, 6, &[]);
        again.contacts[0].point_m = Point3::from(pieces.fragments[parent as usize].center_m);
        again.contacts[0].radius_m = Some(0.3);
        let (mut workspace, token) = (Workspace::default(), CancelToken::default());
        let outcome = pipeline::strike_again(
            pipeline::RequestContext::new(&prepared, &again, &token, &()),
            (&kept, parent),
            &mut workspace,
        );
        pieces = outcome.unwrap().into_meshes().unwrap();
        let sum_m2: f64 = (0..pieces.fragments.len()).map(|child| skin_area_m2(&pieces, child)).sum();
        let least = 2.0 * 0.04 * prepared.frame.diagonal_m;
        for child in 0..pieces.fragments.len() {
            let own = outer(&pieces, child, false);
            for corners in skin_triangles(&pieces, child) {
                let middle = corners.iter().map(|(point, _)| point.coords).sum::<Vector3<f64>>() / 3.0;
                let apart = own.iter().map(|point| (point.coords - middle).norm()).fold(f64::INFINITY, f64::min);
                assert!(apart < least, "{apart} m from child {child}");
                for (point, vertex) in corners {
                    assert!((0..2).all(|axis| (f64::from(vertex.uv[axis]) - point[axis]).abs() < 1e-6), "{vertex:?}");
                }
            }
        }
        println!("generation {generation}: {} children wear {sum_m2:.6} of {before_m2:.6} m²", pieces.fragments.len());
        assert!((sum_m2 / before_m2 - 1.0).abs() < 1e-5);
        assert!(pieces.skins.rows.iter().filter(|row| row.index_count > 0).count() > 1);
        let attributes = pieces.attributes.vertices.iter().filter(|look| look.normal != [0.0; 3]).count();
        assert!(attributes > 50 && 3 * pieces.attributes.materials.len() == pieces.counts.indices);
    }
    let without_skin = FractureRequest { effects: EffectSet::of([EffectKind::Interior]), ..request(&prepared, 6, &[]) };
    let bare = struck::outcome(&prepared, &without_skin).unwrap().into_meshes().unwrap();
    let (kept, parent) = (bare.keep(), largest(&bare));
    let mut workspace = Workspace::default();
    let again = request(&prepared, 6, &[]);
    match pipeline::strike_again(
        pipeline::RequestContext::new(&prepared, &again, &CancelToken::default(), &()),
        (&kept, parent),
        &mut workspace,
    ) {
        Err(FractureError::SkinUnprepared { fragment }) => assert_eq!(fragment, parent),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("a skin came from nowhere"),
    }
}
