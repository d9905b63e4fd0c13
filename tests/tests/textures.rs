//! Orientation of textures: an input whose texture coordinates are an affine function of the position, in files of both kinds.

use serde_json::Value;
use shatter_fracture::surface::{self, LengthUnit, UpAxis, shapes};
use shatter_tests::fixture::Fixture;
use shatter_tests::glb::closed_file;
use std::fmt::Write;
use std::path::Path;

/// Tolerance on the lattice, which rounds edges off: a vertex has the attributes of a point of the surface near it.
const LATTICE: f64 = 2e-3;

/// Tolerance on the skin, which is the input's own.
const SKIN: f64 = 1e-5;

/// Texture coordinates (u, v) at a point of the input, v upwards; no symmetry maps them to 1 − v.
fn painted(point: [f64; 3]) -> [f64; 2] {
    [point[0] + 0.25, 2.0 * point[1] + 0.4]
}

/// Second texture coordinates at a point of the glTF input, v upwards.
fn painted_second(point: [f64; 3]) -> [f64; 2] {
    [point[2] - 0.1, 3.0 * point[0] + 0.3]
}

/// Red, green and blue at a point of the glTF input, from 0 to 1.
fn colored(point: [f64; 3]) -> [f64; 3] {
    [0.5 + point[0], 0.5 + 2.0 * point[1], 0.5 - point[2]]
}

/// Writes a block as an OBJ file with those coordinates.
fn block(path: &Path) {
    let mesh = shapes::cuboid([0.3, 0.2, 0.1]);
    let mut text = String::new();
    for point in &mesh.positions_m {
        let [u, v] = painted((*point).into());
        writeln!(text, "v {} {} {}\nvt {u} {v}", point.x, point.y, point.z).unwrap();
    }
    for [a, b, c] in mesh.triangles.iter().map(|own| own.map(|vertex| vertex + 1)) {
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Positions and texture coordinates of the material `outer` in a `.glb` file, unchanged.
fn in_glb(path: &Path) -> Vec<([f64; 3], [f64; 2])> {
    let file = gltf::Gltf::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let mut found = Vec::new();
    for node in file.document.nodes() {
        let center = node.transform().decomposed().0.map(f64::from);
        for primitive in node.mesh().unwrap().primitives().filter(|own| own.material().name() == Some("outer")) {
            let reader = primitive.reader(|_| Some(blob));
            let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
            let points: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let place = |point: [f32; 3]| [0, 1, 2].map(|k| center[k] + f64::from(point[k]));
            let corners = reader.read_indices().unwrap().into_u32().map(|vertex| vertex as usize);
            found.extend(corners.map(|vertex| (place(points[vertex]), uvs[vertex].map(f64::from))));
        }
    }
    found
}

/// Checks second texture coordinates and colors of the material `outer` in a `.glb` file, and that cracks have none.
#[track_caller]
fn check_second_and_colors(path: &Path, error: f64) {
    let file = gltf::Gltf::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let (blob, mut checked) = (file.blob.as_deref().unwrap(), 0);
    for node in file.document.nodes() {
        let center = node.transform().decomposed().0.map(f64::from);
        for primitive in node.mesh().unwrap().primitives() {
            let reader = primitive.reader(|_| Some(blob));
            if primitive.material().name() == Some("crack") {
                assert!(reader.read_tex_coords(1).is_none() && reader.read_colors(0).is_none());
                continue;
            }
            let points: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let uvs: Vec<[f32; 2]> = reader.read_tex_coords(1).unwrap().into_f32().collect();
            let colors: Vec<[u8; 4]> = reader.read_colors(0).unwrap().into_rgba_u8().collect();
            assert_eq!((uvs.len(), colors.len()), (points.len(), points.len()));
            for vertex in reader.read_indices().unwrap().into_u32().map(|vertex| vertex as usize) {
                let point = [0, 1, 2].map(|k| center[k] + f64::from(points[vertex][k]));
                let ([u, v], color) = (painted_second(point), colored(point));
                let [s, t] = uvs[vertex].map(f64::from);
                assert!((s - u).abs() < error && (t - downwards(v)).abs() < error, "{:?} at {point:?}", uvs[vertex]);
                let off = [0, 1, 2].map(|k| (f64::from(colors[vertex][k]) / 255.0 - color[k]).abs());
                assert!(off.iter().all(|off| *off < 1.01 / 255.0 + error), "{:?} at {point:?}", colors[vertex]);
                assert_eq!(colors[vertex][3], 255);
                checked += 1;
            }
        }
    }
    assert!(checked > 30, "{checked} corners");
}

/// The same of an OBJ file.
fn in_obj(path: &Path) -> Vec<([f64; 3], [f64; 2])> {
    let text = std::fs::read_to_string(path).unwrap();
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').map(|word| word.parse().unwrap()).collect() };
    let rows = |word: &str| -> Vec<Vec<f64>> {
        text.lines().filter_map(|line| line.strip_prefix(word)).map(numbers).collect()
    };
    let (points, uvs) = (rows("v "), rows("vt "));
    let (mut outer, mut found) = (false, Vec::new());
    for line in text.lines() {
        match line.split_once(' ') {
            Some(("usemtl", name)) => outer = name == "outer",
            Some(("f", corners)) if outer => found.extend(corners.split(' ').map(|corner| {
                let place: Vec<usize> = corner.split('/').map(|word| word.parse().unwrap()).collect();
                let (point, uv) = (&points[place[0] - 1], &uvs[place[1] - 1]);
                ([point[0], point[1], point[2]], [uv[0], uv[1]])
            })),
            _ => {}
        }
    }
    found
}

/// Checks that every corner has the coordinates of its position, with v changed by `turned`.
#[track_caller]
fn check(what: &str, found: &[([f64; 3], [f64; 2])], turned: fn(f64) -> f64, error: f64) {
    assert!(found.len() > 30, "{what}: {} corners", found.len());
    for (point, uv) in found {
        let [u, v] = painted(*point);
        assert!((uv[0] - u).abs() < error && (uv[1] - turned(v)).abs() < error, "{what}: {uv:?} at {point:?}");
    }
}

fn upwards(v: f64) -> f64 {
    v
}

fn downwards(v: f64) -> f64 {
    1.0 - v
}

/// Bakes a mesh file, divides the object, and checks all files.
#[track_caller]
fn check_files(fixture: &Fixture, mesh: &Path, name: &str) {
    for (surface, error) in [("exact", SKIN), ("lattice", LATTICE)] {
        check_files_of(fixture, mesh, name, surface, error);
    }
}

/// As [`check_files`], with this surface, whose closed meshes have this error.
#[track_caller]
fn check_files_of(fixture: &Fixture, mesh: &Path, name: &str, surface: &str, error: f64) {
    let bake = ["bake", mesh.to_str().unwrap(), "--name", name, "--material", "ceramic", "--surface", surface];
    fixture.ok("shatterd", &[&bake[..], &["--crack-spacing", "0.03", "--elastic-spacing", "0.06"]].concat());
    let mut served = Fixture::new();
    std::fs::create_dir_all(served.databases()).unwrap();
    let database = format!("{name}.shatter");
    std::fs::copy(fixture.databases().join(&database), served.databases().join(&database)).unwrap();
    served.serve(&[]);
    let (file, folder) = (served.path("a.glb"), served.path("pieces"));
    let divide = |out: &Path, more: &[&str]| -> Value {
        let own = ["prefracture", name, "--degree", "8", "--enable", "attributes,skin", "--out", out.to_str().unwrap()];
        served.ok("shatter", &[&own[..], more].concat())
    };
    divide(&file, &[]);
    check("glb", &in_glb(&closed_file(&file)), downwards, error);
    check("skin", &in_glb(&file), downwards, SKIN);
    if mesh.extension().is_some_and(|extension| extension == "glb") {
        check_second_and_colors(&closed_file(&file), error);
        check_second_and_colors(&file, SKIN);
    }
    divide(&folder, &["--format", "obj"]);
    let pieces = (0..8).map(|piece| folder.join(format!("fragment_{piece:03}.obj"))).filter(|piece| piece.is_file());
    let corners: Vec<_> = pieces.flat_map(|piece| in_obj(&piece)).collect();
    check("obj", &corners, upwards, error);
}

#[test]
fn textures_of_obj_inputs_lie_the_right_way_up() {
    let fixture = Fixture::new();
    let mesh = fixture.path("block.obj");
    block(&mesh);
    check_files(&fixture, &mesh, "block");
}

/// The same block as glTF, not written by this project's code.
#[test]
fn textures_of_gltf_inputs_lie_the_right_way_up() {
    let fixture = Fixture::new();
    let mesh = fixture.path("again.glb");
    std::fs::write(&mesh, block_glb()).unwrap();
    let attributes = surface::read(&mesh, LengthUnit::M, UpAxis::Y).unwrap().attributes;
    assert_eq!((attributes.uvs.len(), attributes.uvs2.len(), attributes.colors.len()), (12, 12, 12));
    check_files(&fixture, &mesh, "again");
}

/// The block as a `.glb` file, made by hand, v downwards.
fn block_glb() -> Vec<u8> {
    let mesh = shapes::cuboid([0.3, 0.2, 0.1]);
    let count = mesh.positions_m.len();
    let mut buffer: Vec<u8> = Vec::new();
    let mut put = |values: &[f64]| buffer.extend(values.iter().flat_map(|x| (*x as f32).to_le_bytes()));
    mesh.positions_m.iter().for_each(|point| put(point.coords.as_slice()));
    for point in &mesh.positions_m {
        let [u, v] = painted((*point).into());
        put(&[u, 1.0 - v]);
    }
    for point in &mesh.positions_m {
        let [u, v] = painted_second((*point).into());
        put(&[u, 1.0 - v]);
    }
    mesh.positions_m.iter().for_each(|point| put(&colored((*point).into())));
    buffer.extend(mesh.triangles.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
    let indices = 3 * mesh.triangles.len();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":3,"COLOR_0":4}},"indices":2}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5126,"count":{count},"type":"VEC2"}},
        {{"bufferView":2,"componentType":5125,"count":{indices},"type":"SCALAR"}},
        {{"bufferView":3,"componentType":5126,"count":{count},"type":"VEC2"}},
        {{"bufferView":4,"componentType":5126,"count":{count},"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}},
        {{"buffer":0,"byteOffset":{},"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}},
        {{"buffer":0,"byteOffset":{},"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}}"#,
        12 * count,
        12 * count,
        8 * count,
        40 * count,
        4 * indices,
        20 * count,
        8 * count,
        28 * count,
        12 * count,
        buffer.len()
    );
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + json.len() + buffer.len()) as u32).to_le_bytes());
    for (chunk, kind) in [(json.as_bytes(), b"JSON"), (&buffer[..], b"BIN\0")] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
