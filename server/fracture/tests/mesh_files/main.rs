//! Readers of mesh files.

use nalgebra::Point3;
use proptest::prelude::*;
use shatter_fracture::surface::{LengthUnit, RawMesh, SINGLE, Surface, SurfaceError, UpAxis, read, shapes};
use std::path::Path;

mod attributes;
mod line_ends;
mod polygons;
mod required_extensions;

/// Writes a file of this name and reads it.
fn read_bytes(name: &str, bytes: &[u8]) -> Result<RawMesh, SurfaceError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, LengthUnit::M, UpAxis::Y)
}

/// Corners of a unit tetrahedron.
const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Checks that the file contains the unit tetrahedron with its vertices in order.
fn check(name: &str, bytes: &[u8]) -> RawMesh {
    let mesh = read_bytes(name, bytes).unwrap();
    assert_eq!(mesh.positions_m, POINTS.map(Point3::from));
    assert_eq!(mesh.triangles, TRIANGLES);
    mesh
}

/// Checks that the file contains the unit tetrahedron in any order.
fn check_shape(name: &str, bytes: &[u8]) -> RawMesh {
    let mesh = read_bytes(name, bytes).unwrap();
    let surface = Surface::repair(mesh.clone()).unwrap();
    let volume = surface.signed_volume() * surface.frame.diagonal_m.powi(3);
    assert!(surface.closed && (volume - 1.0 / 6.0).abs() < 1e-12);
    mesh
}

fn check_malformed(name: &str, bytes: &[u8], place: &str) {
    match read_bytes(name, bytes) {
        Err(SurfaceError::Malformed { place: found, .. }) => assert_eq!(found, place),
        other => panic!("{other:?}"),
    }
}

const OBJ: &str = "# caf\u{e9}\nmtllib no such file.mtl\no part\nv 0 0 0\nv 1. 0 0 1.0\nv 0 1e0 0 0.5 0.5 0.5\nvt 0 0\nvn 0 0 1\n\
    v 0 0 1\nusemtl none\nf 1//1 3//1 2//1\nf 1/1/1 2/1/1 \\\n 4/1/1\ng other\nf 2 3 4 # corner\nf -4 -1 -2\n";

#[test]
fn obj_is_read() {
    check("a.obj", OBJ.as_bytes());
    check("a.obj", format!("\u{feff}{}", OBJ.trim_start()).as_bytes());
    check("A Name with späces.OBJ", OBJ.replace('\n', "\r\n").as_bytes());
    check("a.obj", &OBJ.bytes().map(|byte| if byte > 127 { 0xE9 } else { byte }).collect::<Vec<_>>());
}

#[test]
fn obj_errors_name_the_line_or_the_face() {
    check_malformed("a.obj", b"v 0 0 0\nv 0 zero 0\n", "line 2");
    let comma = read_bytes("a.obj", b"v 0 0 0\nv 1,5 0 0\nv 0 0 0\n").unwrap_err().to_string();
    assert!(comma.contains("decimal points instead of commas") && comma.contains("'v 1,5 0 0'"), "{comma}");
    check_malformed("a.obj", b"v 0 0 0\n\nv 0 0\n", "line 3");
    let cut = read_bytes("a.obj", b"v 0 0 0\nv 0 0\n").unwrap_err().to_string();
    assert!(cut.contains("the file ends") && !cut.contains("commas") && !comma.contains("the file ends"), "{cut}");
    check_malformed("a.obj", b"v 0 0 0\nf 1 a 1\n", "line 2");
    for (text, line) in [("f 1 1 1\nf 1 1 3\nf 1 1 9\nv 1 1 1\n", 3), ("f 0 1 1\n", 2), ("# it\nf 1 1 \\\n-3\n", 4)] {
        check_malformed("a.obj", format!("v 0 0 0\n{text}").as_bytes(), &format!("line {line}"));
    }
    let infinite = read_bytes("a.obj", b"v 0 0 0\nv 0 nan 0\nv 0 1 1e999\nf 1 2 3\n");
    assert!(matches!(infinite, Err(SurfaceError::NonFiniteVertex { vertex: 1, line: Some(2) })));
    let joined = read_bytes("a.obj", b"# it\nv 0 0 0\n\nv 0 \\\ninf 0\nv 0 1 1\nf 1 2 3\n").unwrap_err();
    assert!(joined.to_string().starts_with("vertex 1, counted from 0, in line 5 has a coordinate"), "{joined}");
    assert!(matches!(read_bytes("a.obj", b""), Err(SurfaceError::Empty { .. })));
    assert!(matches!(read_bytes("a.obj", b"v 0 0 0\n"), Err(SurfaceError::Empty { .. })));
    let prose = read_bytes("a.obj", b"# Shatter\nA daemon that breaks things.\n").unwrap_err().to_string();
    assert!(prose.starts_with("no vertices were found; an OBJ file has vertices, lines `v X Y Z`"), "{prose}");
    let huge = read_bytes("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1e200 0\nf 1 2 3\n").unwrap_err();
    assert!(matches!(huge, SurfaceError::VertexOutOfRange { vertex: 2, .. }), "{huge}");
    let message = "vertex 2 at (0, 1e200, 0) is out of range: coordinates must lie within ±1e36 m";
    assert!(huge.to_string().starts_with(message), "{huge}");
    // Its first vertex with two numbers comes after a face with another defect: each rule is that of the line named.
    let two = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3 -0.015\nv 5 5 5\nv 0 1\n";
    let error = read_bytes("m.obj", two).unwrap_err().to_string();
    assert!(error.contains("line 7") && error.contains("a vertex needs three numbers"), "{error}");
}

fn ply_header(format: &str, number: &str, list: &str) -> String {
    let axes = ["x", "y", "z"].map(|axis| format!("property {number} {axis}\n")).concat();
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 4\n{axes}property uchar red\nelement face 4\n\
         property uchar quality\nproperty list {list} vertex_indices\nend_header\n"
    )
}

/// PLY file of the unit tetrahedron; the closures encode numbers in either byte order.
fn ply_binary(header: &str, number: impl Fn(f64) -> Vec<u8>, index: impl Fn(u32) -> Vec<u8>) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    for point in POINTS {
        point.iter().for_each(|c| bytes.extend(number(*c)));
        bytes.push(200);
    }
    for corners in TRIANGLES {
        bytes.extend([7, 3]);
        corners.iter().for_each(|&corner| bytes.extend(index(corner)));
    }
    bytes
}

#[test]
fn ply_is_read_in_all_encodings() {
    let mut text = ply_header("ascii", "float", "uchar int");
    for [x, y, z] in POINTS {
        text += &format!("{x} {y} {z} 200\n");
    }
    for [a, b, c] in TRIANGLES {
        text += &format!("  7 3 {a} {b} {c}\n");
    }
    let rounding = check("a.ply", text.as_bytes()).rounding;
    assert_eq!(rounding, SINGLE);
    check("a.ply", text.replace('\n', "\r\n").as_bytes());
    check("a.PLY", text.replace("1 0 0", "1. .0 -0.e0").as_bytes());
    let header = ply_header("binary_little_endian", "float", "uchar uint");
    check("a.ply", &ply_binary(&header, |c| (c as f32).to_le_bytes().into(), |i| i.to_le_bytes().into()));
    let header = ply_header("binary_big_endian", "double", "uchar ushort");
    let big = ply_binary(&header, |c| c.to_be_bytes().into(), |i| (i as u16).to_be_bytes().into());
    assert!(check("a.ply", &big).rounding < SINGLE);
    let third = ply_binary(&header, |c| (c / 3.0).to_be_bytes().into(), |i| (i as u16).to_be_bytes().into());
    assert_eq!(read_bytes("a.ply", &third).unwrap().positions_m[1].x, 1.0 / 3.0);
}

#[test]
fn ply_strips_and_quads_are_read() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n0 0 1\n11 1 0 2 3 1 0 -1 0 3 1 -1\n";
    let mesh = read_bytes("a.ply", text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[1, 0, 2], [2, 0, 3], [2, 3, 1], [1, 3, 0], [0, 3, 1]]);
    let quad = text.replace("tristrips", "face").replace("11 1 0 2 3 1 0 -1 0 3 1 -1", "4 0 1 2 3");
    assert_eq!(read_bytes("a.ply", quad.as_bytes()).unwrap().faces, [0, 0]);
}

#[test]
fn ply_errors_name_the_place() {
    let text = ply_header("ascii", "float", "uchar int");
    check_malformed("a.ply", b"ply\nformat ascii 1.0\nelement vertex many\n", "line 3");
    check_malformed("a.ply", (text.clone() + "0 0 0 200\n0 zero 0 200\n0 0 0 0\n0 0 0 0\n").as_bytes(), "line 14");
    check_malformed("a.ply", (text.clone() + "0 0 0 200\n0 0 0 200\n").as_bytes(), "line 14");
    let huge = text.replace("face 4", "face 4000000000000000000");
    check_malformed("a.ply", (huge + &"0 0 0 0\n".repeat(4)).as_bytes(), "element face, row 0, counted from 0");
    let flat = text.replace("property float z\n", "");
    check_malformed("a.ply", (flat + &"0 0 0\n".repeat(8)).as_bytes(), "element vertex");
    let bare = "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\nend_header\n";
    check_malformed("a.ply", bare.as_bytes(), "element vertex");
    let cut = ply_binary(
        &ply_header("binary_little_endian", "float", "uchar uint"),
        |c| (c as f32).to_le_bytes().into(),
        |i| i.to_le_bytes().into(),
    );
    let reason = |bytes: &[u8]| read_bytes("a.ply", bytes).unwrap_err().to_string();
    assert!(reason(&cut[..cut.len() - 3]).ends_with("element face: the file ends there: copy or export it again"));
    let cut_row = reason((text.clone() + "0 0 0 200\n0 0 0 200\n0 0").as_bytes());
    assert!(cut_row.ends_with("too short: the file ends there: copy or export it again"), "{cut_row}");
    let vertices = cut.windows(11).position(|own| own == b"end_header\n").unwrap() + 11;
    let short = reason(&cut[..vertices + 2 * 12 + 5]);
    assert!(short.contains("row 2, counted from 0: the header announces 4 rows, but the file ends"), "{short}");
    assert!(reason(b"").contains("header: does not begin with `ply`") && reason(b"v 0 0 0\n").contains("in .obj"));
    let header_lines = text.lines().count();
    let wild = text + "0 0 0 0\n1 0 0 0\n0 1 0 0\n0 2 1 0\n7 3 0 1 2\n7 3 0 1 2\n7 3 0 1 -2\n7 3 0 1 2\n";
    assert!(matches!(
        read_bytes("a.ply", wild.as_bytes()),
        Err(SurfaceError::VertexOutOfBounds { face: 2, index: -2, vertices: 4 })
    ));
    for number in ["nan", "-inf", "1e400"] {
        let infinite = read_bytes("a.ply", wild.replace("0 2 1 0", &format!("0 {number} 1 0")).as_bytes());
        let Err(SurfaceError::NonFiniteVertex { vertex: 3, line: Some(line) }) = infinite else {
            panic!("{infinite:?}")
        };
        assert_eq!(line, header_lines + 4);
    }
    let infinite = ply_binary(
        &ply_header("binary_little_endian", "float", "uchar uint"),
        |c| if c == 1.0 { f32::NAN } else { c as f32 }.to_le_bytes().into(),
        |i| i.to_le_bytes().into(),
    );
    let infinite = read_bytes("a.ply", &infinite);
    assert!(matches!(infinite, Err(SurfaceError::NonFiniteVertex { vertex: 1, line: None })), "{infinite:?}");
}

fn stl_facet([a, b, c]: [u32; 3]) -> String {
    let vertex = |v: u32| {
        let [x, y, z] = POINTS[v as usize];
        format!("  vertex {x:e} {y} {z:.3}\n")
    };
    format!("facet normal 0 0 0\n outer loop\n{}{}{} endloop\nendfacet\n", vertex(a), vertex(b), vertex(c))
}

fn stl_binary(header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4u32.to_le_bytes());
    for corners in TRIANGLES {
        bytes.extend([0; 12]);
        for c in corners.iter().flat_map(|&v| POINTS[v as usize]) {
            bytes.extend((c as f32).to_le_bytes());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn stl_is_read_in_both_forms() {
    let facets = TRIANGLES.map(stl_facet);
    let text = format!("solid a part\n{}endsolid a part\n", facets.concat());
    assert_eq!(check_shape("a.stl", text.as_bytes()).positions_m.len(), 4);
    check_shape("A.STL", text.to_uppercase().as_bytes());
    check_shape("a.stl", text.replace("solid a part", "solid").as_bytes());
    let two = format!("solid\n{}endsolid\nsolid b\n{}endsolid b\n", facets[..2].concat(), facets[2..].concat());
    check_shape("a.stl", two.as_bytes());
    assert_eq!(check_shape("a.stl", &stl_binary(b"made by hand")).rounding, SINGLE);
    check_shape("a.stl", &stl_binary(b"solid facet of a liar"));
    check_shape("a.stl", &[stl_binary(b"with a tail"), vec![1, 2, 3]].concat());
}

#[test]
fn stl_errors_name_the_place() {
    let facet = stl_facet(TRIANGLES[0]);
    let text = format!("solid\n{facet}");
    check_malformed("a.stl", text.as_bytes(), "facet 1");
    check_malformed("a.stl", (text.clone() + "facet normal 0 0 0\nouter loop\nvertex 1 2\n").as_bytes(), "facet 1");
    check_malformed("a.stl", (text.clone() + "facet normal\nendfacet\n").as_bytes(), "facet 1");
    check_malformed("a.stl", (text.clone() + "nonsense\n").as_bytes(), "facet 1");
    check_malformed("a.stl", (text + "endsolid\nnonsense\n").as_bytes(), "line 10");
    check_malformed("a.stl", b"short", "byte 5");
    let binary = stl_binary(b"");
    check_malformed("a.stl", &binary[..binary.len() - 1], "byte 283");
    let mut infinite = binary.clone();
    infinite[84 + 50 + 12 + 4..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let infinite = read_bytes("a.stl", &infinite);
    assert!(matches!(infinite, Err(SurfaceError::NonFiniteVertex { vertex: 3, line: None })), "{infinite:?}");
    let whole = format!("solid\n{}endsolid\n", TRIANGLES.map(stl_facet).concat());
    check_shape("a.stl", whole.replacen("facet normal 0 0 0", "facet normal nan nan nan", 1).as_bytes());
    let text = format!("solid\n{}endsolid\n", stl_facet(TRIANGLES[0]).replacen("vertex 1e0", "vertex NaN", 1));
    let line = text.lines().position(|line| line.contains("NaN")).unwrap() + 1;
    let infinite = read_bytes("a.stl", text.as_bytes());
    let Err(SurfaceError::NonFiniteVertex { vertex, line: Some(found) }) = infinite else { panic!("{infinite:?}") };
    assert_eq!((found, vertex), (line, line as u64 - 4));
    for (count, place) in [([255; 4], "byte 284"), ([3, 0, 0, 0], "byte 80")] {
        let many = [&binary[..80], &count, &binary[84..]].concat();
        check_malformed("a.stl", &many, place);
    }
}

/// glTF document with the unit tetrahedron as mesh 0. `nodes` is JSON; `uri` holds further members of the buffer.
fn gltf_text(nodes: &str, mode: u32, indices: &[u16], uri: &str) -> String {
    let count = indices.len();
    let length = 48 + 2 * count;
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":{nodes},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5123,"count":{count},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":{}}}],
        "buffers":[{{"byteLength":{length}{uri}}}]}}"#,
        2 * count
    )
}

fn gltf_buffer(indices: &[u16]) -> Vec<u8> {
    let positions = POINTS.iter().flatten().flat_map(|&c| (c as f32).to_le_bytes());
    positions.chain(indices.iter().flat_map(|index| index.to_le_bytes())).collect()
}

fn glb(json: &str, mut buffer: Vec<u8>) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + json.len() + buffer.len()) as u32).to_le_bytes());
    for (chunk, name) in [(json, b"JSON"), (buffer, b"BIN\0")] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(name);
        bytes.extend(chunk);
    }
    bytes
}

const LIST: [u16; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2];
const NODE: &str = r#"[{"mesh":0}]"#;

#[test]
fn a_glb_that_ends_early_says_so() {
    let whole = glb(&gltf_text(NODE, 4, &LIST, ""), gltf_buffer(&LIST));
    let error = read_bytes("a.glb", &whole[..whole.len() - 9]).unwrap_err().to_string();
    let announced = format!("it announces {} bytes: copy or export it again", whole.len());
    assert!(error.ends_with(&announced), "{error}");
}

#[test]
fn glb_nodes_are_placed() {
    check("a.glb", &glb(&gltf_text(NODE, 4, &LIST, ""), gltf_buffer(&LIST)));
    let nodes = r#"[{"children":[1,2],"scale":[2,2,2]},{"mesh":0,"translation":[1,0,0]},
        {"mesh":0,"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,-5,0,0,1]}]"#;
    let mesh = read_bytes("a.glb", &glb(&gltf_text(nodes, 4, &LIST, ""), gltf_buffer(&LIST))).unwrap();
    assert_eq!(mesh.positions_m[1], Point3::new(4.0, 0.0, 0.0));
    assert_eq!(mesh.positions_m[5], Point3::new(-12.0, 0.0, 0.0));
    let surface = Surface::repair(mesh).unwrap();
    let [defect] = &surface.defects[..] else { panic!("{:?}", surface.defects) };
    assert_eq!((defect.kind, defect.count), (shatter_fracture::surface::DefectKind::SeveralShells, 2));
}

#[test]
fn gltf_strips_and_fans_are_read() {
    let strip = [1, 0, 2, 3, 1, 0];
    check_shape("a.glb", &glb(&gltf_text(NODE, 5, &strip, ""), gltf_buffer(&strip)));
    let fan = [3, 0, 1, 2, 0];
    let mesh = read_bytes("a.glb", &glb(&gltf_text(NODE, 6, &fan, ""), gltf_buffer(&fan))).unwrap();
    assert_eq!(mesh.triangles, [[3, 0, 1], [3, 1, 2], [3, 2, 0]]);
}

#[test]
fn gltf_buffers_lie_beside_it_or_inside() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bücher 1.bin"), gltf_buffer(&LIST)).unwrap();
    let path = folder.path().join("mesh.gltf");
    std::fs::write(&path, gltf_text(NODE, 4, &LIST, r#","uri":"b%C3%BCcher%201.bin""#)).unwrap();
    assert_eq!(read(&path, LengthUnit::M, UpAxis::Y).unwrap().triangles, TRIANGLES);
    std::fs::write(&path, gltf_text(NODE, 4, &LIST, r#","uri":"missing.bin""#)).unwrap();
    assert!(
        matches!(read(&path, LengthUnit::M, UpAxis::Y), Err(SurfaceError::Unreadable { path, .. }) if path.ends_with("missing.bin"))
    );
    // One triangle in base64: three vertices of twelve bytes, three indices, padded to 48 + 6 bytes.
    let inside = r#","uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAABAAIA""#;
    let mesh = read_bytes("a.gltf", gltf_text(NODE, 4, &[0, 1, 2], inside).as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn gltf_errors_name_the_place() {
    let text = gltf_text(NODE, 4, &LIST, "");
    let altered = |from: &str, to: &str| glb(&text.replace(from, to), gltf_buffer(&LIST));
    assert_ne!(altered("\"count\":4", "\"count\":5"), altered("", ""));
    check_malformed("a.glb", &altered("\"count\":4", "\"count\":5"), "accessor 0");
    check_malformed("a.glb", &altered("\"count\":4", "\"count\":1844674407370955161"), "accessor 0");
    check_malformed("a.glb", &altered("5123", "5126"), "accessor 1");
    check_malformed("a.glb", &altered("\"byteOffset\":48", "\"byteOffset\":18446744073709551615"), "accessor 1");
    check_malformed(
        "a.glb",
        &altered("\"buffer\":0,\"byteLength\":48", "\"buffer\":0,\"byteLength\":480"),
        "accessor 0",
    );
    check_malformed("a.glb", &altered(NODE, r#"[{"mesh":0,"children":[0]}]"#), "node 0");
    check_malformed("a.glb", &altered("\"mesh\":0", "\"mesh\":1"), "document");
    check_malformed("a.glb", &altered("\"POSITION\":0", "\"POSITION\":2"), "mesh 0");
    check_malformed("a.glb", b"glTF\x02\0\0\0\x05\0\0\0 and more", "byte 8");
    check_malformed("a.gltf", b"{", "document");
    check_malformed("a.gltf", gltf_text(NODE, 4, &LIST, "").as_bytes(), "buffer 0");
    let far = gltf_text(NODE, 4, &LIST, r#","uri":"https://example.com/a.bin""#);
    check_malformed("a.gltf", far.as_bytes(), "buffer 0");
    let odd = gltf_text(NODE, 4, &LIST, r#","uri":"%ff.bin""#);
    check_malformed("a.gltf", odd.as_bytes(), "buffer 0");
    let wild = [0, 1, 4];
    let found = read_bytes("a.glb", &glb(&gltf_text(NODE, 4, &wild, ""), gltf_buffer(&wild)));
    assert!(matches!(found, Err(SurfaceError::VertexOutOfBounds { face: 0, index: 4, vertices: 4 })));
}

#[test]
fn a_far_translation_in_gltf_loses_nothing() {
    let nodes = r#"[{"mesh":0,"translation":[1000000,0,0]}]"#;
    let mesh = read_bytes("a.glb", &glb(&gltf_text(nodes, 4, &LIST, ""), gltf_buffer(&LIST))).unwrap();
    assert_eq!(Surface::repair(mesh).unwrap().defects, []);
}

const MSH: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n\
    0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 1 2 1\n1 1 2 3\n3 1 4 1\n2 1 2 3 4\n$EndElements\n";
const MSH_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
    $Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";
const VTK: &str = "# vtk DataFile Version 3.0\na part\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0\n\
    0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";
const VTK_5: &str = "# vtk DataFile Version 5.1\na part\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0\n\
    0 1 0 0 0 1\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\n";
const MEDIT: &str = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n\
    Tetrahedra 1\n1 2 3 4 0 # all\nEnd\n";

#[test]
fn tetrahedral_meshes_are_read_as_their_boundary() {
    for (name, text) in [("a.msh", MSH), ("a.MSH", MSH_2), ("a.vtk", VTK), ("a.vtk", VTK_5), ("a.mesh", MEDIT)] {
        assert!(check(name, text.as_bytes()).rounding < SINGLE);
        let none = read_bytes(name, &text.as_bytes()[..text.len() / 9]).unwrap_err().to_string();
        assert!(none.starts_with("malformed "), "{none}");
    }
    let bare = MEDIT.replace("Tetrahedra 1\n1 2 3 4 0", "Edges 1\n1 2 0");
    let bare = read_bytes("a.mesh", bare.as_bytes()).unwrap_err().to_string();
    assert!(bare.starts_with("no faces were found; a Medit file has `Vertices`, and `Tetrahedra`"), "{bare}");
}

#[test]
fn units_and_axes_are_applied() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 1 2 3\nv 4 5 6\nv 7 8 10\nf 1 2 3\n").unwrap();
    let first = |unit, up| read(&path, unit, up).unwrap().positions_m[0];
    assert_eq!(first(LengthUnit::M, UpAxis::Y), Point3::new(1.0, 2.0, 3.0));
    assert_eq!(first(LengthUnit::Mm, UpAxis::Z), Point3::new(1.0, 3.0, -2.0) * 0.001);
    assert_eq!(first(LengthUnit::In, UpAxis::Y).x, 0.0254);
    for word in ["m", "cm", "mm", "in"] {
        assert_eq!(word.parse::<LengthUnit>().unwrap().to_string(), word);
    }
    assert_eq!("z".parse::<UpAxis>().unwrap().to_string(), "z");
    assert!("ft".parse::<LengthUnit>().is_err() && "x".parse::<UpAxis>().is_err());
}

#[test]
fn other_files_are_refused() {
    assert!(
        matches!(read_bytes("a.fbx", b""), Err(SurfaceError::UnknownFormat { extension, .. }) if extension == "fbx")
    );
    assert!(
        matches!(read_bytes("obj", b""), Err(SurfaceError::UnknownFormat { extension, .. }) if extension.is_empty())
    );
    let missing = read(Path::new("no such folder/a.obj"), LengthUnit::M, UpAxis::Y);
    assert!(matches!(missing, Err(SurfaceError::Unreadable { .. })));
}

/// Checks that the readers return for any bytes, and that repair accepts or rejects every mesh they return.
fn survive(bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    let meshes = ["obj", "ply", "stl", "gltf", "glb", "msh", "vtk", "mesh"].map(|extension| {
        let path = folder.path().join("a").with_extension(extension);
        std::fs::write(&path, bytes).unwrap();
        read(&path, LengthUnit::M, UpAxis::Y)
    });
    for mesh in meshes.into_iter().flatten() {
        let _ = Surface::repair(mesh);
    }
}

/// A valid file of each kind.
fn good_files() -> Vec<Vec<u8>> {
    let header = ply_header("binary_little_endian", "float", "uchar uint");
    let ascii =
        ply_header("ascii", "double", "int int") + "0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n" + &"7 3 0 1 2\n".repeat(4);
    vec![
        OBJ.as_bytes().to_vec(),
        ply_binary(&header, |c| (c as f32).to_le_bytes().into(), |i| i.to_le_bytes().into()),
        ascii.into_bytes(),
        stl_binary(b"solid facet"),
        format!("solid\n{}endsolid\n", TRIANGLES.map(stl_facet).concat()).into_bytes(),
        glb(&gltf_text(NODE, 4, &LIST, ""), gltf_buffer(&LIST)),
        gltf_text(NODE, 5, &LIST, r#","uri":"data:;base64,AAAA""#).into_bytes(),
        MSH.as_bytes().to_vec(),
        VTK.as_bytes().to_vec(),
        MEDIT.as_bytes().to_vec(),
    ]
}

#[test]
fn truncated_files_never_panic() {
    for file in good_files() {
        (0..file.len()).for_each(|length| survive(&file[..length]));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        survive(&bytes);
    }

    #[test]
    fn damaged_files_never_panic(
        which in 0..10usize,
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        digits in any::<bool>(),
    ) {
        let mut file = good_files().swap_remove(which);
        for (place, byte) in changes {
            let place = place.index(file.len());
            file[place] = if digits { b'0' + byte % 10 } else { byte };
        }
        survive(&file);
    }
}

#[test]
fn a_generated_shape_survives_every_text_format() {
    let shape = shapes::torus(1.0, 0.25, [12, 8]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.obj");
    shapes::write_obj(&shape, &path).unwrap();
    assert_eq!(read(&path, LengthUnit::M, UpAxis::Y).unwrap().triangles, shape.triangles);
}
