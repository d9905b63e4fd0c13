use super::*;
use shatter_fracture::surface::TriangleAttributes;

#[test]
fn obj_looks_are_read_by_corner() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\nusemtl red brick\n\
        f 1/1/1 2/2/1 3/3/1 4/4/1\nusemtl moss\nf 1/-4/-1 3/-2/-1 \\\n 4/-1/-1\nusemtl red brick\nf 1/1/1 2/2/1 4/4/1\n";
    let attributes = read_bytes("a.obj", text.as_bytes()).unwrap().attributes;
    assert_eq!(
        (attributes.materials, attributes.names),
        (vec![0, 0, 1, 0], vec!["red brick".to_owned(), "moss".to_owned()])
    );
    assert_eq!(attributes.normals, [[[0.0, 0.0, 1.0]; 3]; 4]);
    let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mesh = read_bytes("a.obj", text.as_bytes()).unwrap();
    for (triangle, uvs) in mesh.triangles.iter().zip(&attributes.uvs) {
        assert_eq!(*uvs, triangle.map(|vertex| corner[vertex as usize]));
    }
    for (from, to) in [("vn 0 0 2", "vn 0 0 0"), ("3/-2/-1", "3/-2/-9"), ("3/-2/-1", "3/-2")] {
        let attributes = read_bytes("a.obj", text.replace(from, to).as_bytes()).unwrap().attributes;
        assert!(attributes.normals.is_empty() && attributes.uvs.len() == 4, "{to}");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), text).unwrap();
    let attributes = read(&folder.path().join("a.obj"), LengthUnit::Cm, UpAxis::Z).unwrap().attributes;
    assert_eq!(attributes.normals[0][0], [0.0, 1.0, 0.0]);
}

#[test]
fn ply_looks_are_read_by_vertex() {
    let rows = |extra: [&str; 3]| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0 {}\n1 0 0 {}\n0 1 0 {}\n3 0 1 2\n",
            extra[0], extra[1], extra[2]
        )
    };
    let good = read_bytes("a.ply", rows(["0 0 1 0 0", "0 0 1 1 0", "0 0 1 0 .5"]).as_bytes()).unwrap().attributes;
    assert_eq!((good.normals, good.uvs), (vec![[[0.0, 0.0, 1.0]; 3]], vec![[[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]]));
    let damaged = read_bytes("a.ply", rows(["0 0 1 0 0", "what 0 1 1 0", "0 0 1 0 1"]).as_bytes()).unwrap().attributes;
    assert!(damaged.normals.is_empty() && damaged.uvs.len() == 1);
}

#[test]
fn obj_colors_follow_coordinates_and_are_dropped_with_a_gap() {
    let text = "v 0 0 0 1 0 .5\nv 1 0 0 0 1 0 .25\nv 0 1 0 0 0 1\nf 1 2 3\n";
    let attributes = read_bytes("a.obj", text.as_bytes()).unwrap().attributes;
    assert_eq!(attributes.colors, [[[1.0, 0.0, 0.5, 1.0], [0.0, 1.0, 0.0, 0.25], [0.0, 0.0, 1.0, 1.0]]]);
    let gap = read_bytes("a.obj", text.replace(" 0 0 1\n", "\n").as_bytes()).unwrap().attributes;
    assert_eq!((gap.colors, gap.lost), (Vec::new(), vec![("colors", 0)]));
    // A fourth coordinate is a weight.
    let weights = read_bytes("a.obj", b"v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").unwrap().attributes;
    assert_eq!((weights.colors, weights.lost), (Vec::new(), Vec::new()));
}

/// A PLY file of one triangle whose vertices have these color properties. `body`: rows of coordinates and colors, and the face.
fn colored_ply(format: &str, kind: &str, channels: &[&str], body: &[u8]) -> TriangleAttributes {
    let colors: String = channels.iter().map(|channel| format!("property {kind} {channel}\n")).collect();
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{colors}\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    read_bytes("a.ply", &[header.as_bytes(), body].concat()).unwrap().attributes
}

#[test]
fn ply_colors_are_scaled_by_their_type() {
    const RGBA: [&str; 4] = ["red", "green", "blue", "alpha"];
    let bytes = b"0 0 0 255 0 51 102\n1 0 0 0 0 0 0\n0 1 0 0 0 0 255\n3 0 1 2\n";
    let wanted = [[1.0, 0.0, 0.2, 0.4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
    assert_eq!(colored_ply("ascii", "uchar", &RGBA, bytes).colors, [wanted]);
    let floats = b"0 0 0 1 0 0.2 0.4\n1 0 0 0 0 0 0\n0 1 0 0 0 0 1\n3 0 1 2\n";
    assert_eq!(colored_ply("ascii", "float", &RGBA, floats).colors, [wanted]);
    for kind in ["int", "uint", "short"] {
        assert_eq!(colored_ply("ascii", kind, &RGBA, bytes).colors, [wanted]);
    }
    let large = colored_ply("ascii", "float", &RGBA, bytes);
    assert_eq!((large.colors, large.lost), (Vec::new(), vec![("colors", 0)]));
    let mut binary = Vec::new();
    for (point, color) in [([0.0f32, 0.0], [65535u16, 0, 13107]), ([1.0, 0.0], [0; 3]), ([0.0, 1.0], [0; 3])] {
        binary.extend([point[0], point[1], 0.0].iter().flat_map(|x| x.to_le_bytes()));
        binary.extend(color.iter().flat_map(|x| x.to_le_bytes()));
    }
    binary.push(3);
    binary.extend([0i32, 1, 2].iter().flat_map(|x| x.to_le_bytes()));
    let opaque = colored_ply("binary_little_endian", "ushort", &RGBA[..3], &binary).colors;
    assert_eq!(opaque, [[[1.0, 0.0, 0.2, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]]);
    let damaged = b"0 0 0 what 0 0 0\n1 0 0 0 0 0 0\n0 1 0 0 0 0 0\n3 0 1 2\n";
    assert_eq!(colored_ply("ascii", "uchar", &RGBA, damaged).lost, [("colors", 0)]);
    assert!(
        colored_ply("ascii", "uchar", &["red", "green"], b"0 0 0 1 1\n1 0 0 1 1\n0 1 0 1 1\n3 0 1 2\n")
            .colors
            .is_empty()
    );
}

/// The unit tetrahedron with second texture coordinates, and colors of this type in elements of eight or more bytes.
fn colored_glb(semantic: &str, kind: u32, shape: &str, colors: &[u8]) -> TriangleAttributes {
    let (json, mut buffer) = (gltf_text(NODE, 4, &LIST, ""), gltf_buffer(&LIST));
    let first = buffer.len();
    for [u, v] in [[0.0f32, 1.0], [0.5, 1.0], [0.0, 0.5], [2.0, -1.0]] {
        buffer.extend([u, v].iter().flat_map(|x| x.to_le_bytes()));
    }
    buffer.extend_from_slice(colors);
    let (stride, end) = (colors.len() / 4, first + 32);
    let accessors = format!(
        r#""bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}},
        {{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}},
        {{"bufferView":3,"componentType":{kind},"count":4,"type":"{shape}","normalized":{}}}]"#,
        kind != 5126
    );
    let views = format!(
        r#""byteOffset":48,"byteLength":24}},{{"buffer":0,"byteOffset":{first},"byteLength":32}},
        {{"buffer":0,"byteOffset":{end},"byteLength":{},"byteStride":{stride}}}]"#,
        colors.len()
    );
    let json = json
        .replace(r#""POSITION":0"#, &format!(r#""POSITION":0,"TEXCOORD_1":2,"{semantic}":3"#))
        .replace(r#""bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]"#, &accessors)
        .replace(r#""byteOffset":48,"byteLength":24}]"#, &views)
        .replace(&format!(r#"[{{"byteLength":{first}}}]"#), &format!(r#"[{{"byteLength":{}}}]"#, buffer.len()));
    check("a.glb", &glb(&json, buffer)).attributes
}

#[test]
fn gltf_has_second_texture_coordinates_and_colors_of_three_types() {
    let rgb = [[1.0f32, 0.2, 0.0], [0.0, 0.4, 1.0], [0.2; 3], [0.6; 3]];
    let floats: Vec<u8> = rgb.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let words: Vec<u8> = rgb
        .iter()
        .flat_map(|own| [own[0], own[1], own[2], 0.4].map(|x| (x * 65535.0) as u16))
        .flat_map(u16::to_le_bytes)
        .collect();
    let bytes: Vec<u8> = rgb.iter().flat_map(|own| [own[0], own[1], own[2], 0.0].map(|x| (x * 255.0) as u8)).collect();
    for (kind, shape, colors, alpha) in
        [(5126, "VEC3", &floats, 1.0), (5123, "VEC4", &words, 0.4), (5121, "VEC3", &bytes, 1.0)]
    {
        let attributes = colored_glb("COLOR_0", kind, shape, colors);
        assert!(attributes.uvs.is_empty() && attributes.lost.is_empty(), "{:?}", attributes.lost);
        let uvs2 = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [2.0, 2.0]];
        for ((triangle, uvs), colors) in TRIANGLES.iter().zip(&attributes.uvs2).zip(&attributes.colors) {
            assert_eq!(*uvs, triangle.map(|vertex| uvs2[vertex as usize]));
            for (vertex, color) in triangle.iter().zip(colors) {
                let [r, g, b] = rgb[*vertex as usize];
                let off = [0, 1, 2, 3].map(|k| (color[k] - [r, g, b, alpha][k]).abs());
                assert!(off.iter().all(|off| *off < 1e-5), "{kind}: {color:?}");
            }
        }
        assert_eq!((attributes.uvs2.len(), attributes.colors.len()), (4, 4));
    }
    assert_eq!(colored_glb("COLOR_0", 5123, "VEC2", &words[..16]).lost, [("colors", 0)]);
    // Texture coordinates are stored in the same types; v is turned.
    let shares: Vec<u8> = [0u16, 65535, 13107, 0, 65535, 26214, 0, 0].map(u16::to_le_bytes).concat();
    let uvs = colored_glb("TEXCOORD_0", 5123, "VEC2", &shares).uvs;
    let wanted = [[0.0, 0.0], [0.2, 1.0], [1.0, 0.6], [0.0, 1.0]];
    for (triangle, uvs) in TRIANGLES.iter().zip(&uvs) {
        let off = |k: usize| [0, 1].map(|axis| uvs[k][axis] - wanted[triangle[k] as usize][axis]);
        assert!((0..3).flat_map(off).all(|off: f32| off.abs() < 1e-6), "{uvs:?}");
    }
    assert_eq!(uvs.len(), 4);
}
