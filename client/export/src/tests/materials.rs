//! Materials: primitives by material, and the materials and textures of the mesh file.

use super::{Sample, parts, sample, view, words};
use crate::{ExportError, FragmentView, RunView, SourceMaterials, glb_bytes, glb_bytes_with, write_glb_with};
use serde_json::{Value, json};
use shatter_proto::result::NO_MATERIAL;
use std::path::{Path, PathBuf};

/// Materials of the sample's triangles; the last one is a crack.
const MIXED: [u32; 4] = [1, 0, 1, NO_MATERIAL];

fn textured<'a>(sample: &'a Sample, id: u32, materials: &'a [u32]) -> FragmentView<'a> {
    FragmentView { materials, uvs: &[[0.5; 2]; 7], ..view(sample, id) }
}

/// A `.glb` file of this document and buffer.
fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
    let total = (28 + json.len() + binary.len()) as u32;
    [
        b"glTF\x02\0\0\0".as_slice(),
        &total.to_le_bytes(),
        &length(&json),
        b"JSON",
        &json,
        &length(&binary),
        b"BIN\0",
        &binary,
    ]
    .concat()
}

/// A model with two materials, whose images are in its buffer.
fn model(folder: &Path) -> PathBuf {
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual"],
        "materials": [
            {
                "name": "glaze",
                "pbrMetallicRoughness": {
                    "baseColorTexture": { "index": 1, "extensions": { "KHR_texture_transform": { "offset": [0.1, 0.3] } } },
                    "roughnessFactor": 0.7,
                },
                "doubleSided": true,
                "extras": { "shop": "kiln" },
            },
            { "name": "clay", "normalTexture": { "index": 0, "scale": 0.8 } },
        ],
        "textures": [{ "source": 0 }, { "source": 1, "sampler": 0, "name": "paint" }],
        "samplers": [{ "wrapS": 33071 }],
        "images": [{ "bufferView": 1, "mimeType": "image/png" }, { "bufferView": 0, "mimeType": "image/jpeg" }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 5, "byteOffset": 1 },
            { "buffer": 0, "byteLength": 3, "byteOffset": 6 },
        ],
        "buffers": [{ "byteLength": 9 }],
    });
    let path = folder.join("model.glb");
    std::fs::write(&path, glb(&document, b"_paintpng")).unwrap();
    path
}

fn source() -> SourceMaterials {
    let folder = tempfile::tempdir().unwrap();
    SourceMaterials::read(&model(folder.path())).unwrap()
}

/// Triangles and material of each primitive of a mesh.
fn primitives(document: &Value, buffer: &[u8], mesh: usize) -> Vec<(u64, Vec<u32>)> {
    let primitives = document["meshes"][mesh]["primitives"].as_array().unwrap();
    let one = |own: &Value| (own["material"].as_u64().unwrap(), words(document, buffer, &own["indices"]));
    primitives.iter().map(one).collect()
}

/// Checks the manifold primitive of the first mesh against its primitives, one after the other.
#[track_caller]
fn check_manifold(document: &Value, buffer: &[u8], sample: &Sample) {
    let extension = &document["meshes"][0]["extensions"]["EXT_mesh_manifold"];
    let mut indices = words(document, buffer, &extension["manifoldPrimitive"]["indices"]);
    let written: Vec<u32> = primitives(document, buffer, 0).into_iter().flat_map(|(_, own)| own).collect();
    assert_eq!(indices, written);
    let places = words(document, buffer, &extension["mergeIndices"]);
    for (place, value) in places.into_iter().zip(words(document, buffer, &extension["mergeValues"])) {
        indices[place as usize] = value;
    }
    let same = |vertex: &u32| sample.merges.iter().find(|[from, _]| from == vertex).map_or(*vertex, |[_, to]| *to);
    assert_eq!(indices, written.iter().map(same).collect::<Vec<u32>>());
}

#[test]
fn outer_triangles_are_grouped_by_material_and_stay_closed() {
    let sample = sample();
    let (bytes, written) = glb_bytes(&[textured(&sample, 0, &MIXED)]).unwrap();
    assert_eq!(written.closed, 1);
    let (document, buffer) = parts(&bytes);
    let wanted = [(0, vec![0, 1, 3]), (0, vec![0, 2, 1, 0, 3, 2]), (1, vec![4, 5, 6])];
    assert_eq!(primitives(&document, &buffer, 0), wanted);
    let own = &document["meshes"][0]["primitives"];
    assert_eq!([&own[0]["extras"]["material"], &own[1]["extras"]["material"]], [0, 1]);
    assert!(own[2].get("extras").is_none());
    check_manifold(&document, &buffer, &sample);
}

#[test]
fn triangles_without_material_are_the_last_outer_ones() {
    let sample = sample();
    let (bytes, _) = glb_bytes_with(&[textured(&sample, 0, &[NO_MATERIAL, 1, 0, NO_MATERIAL])], &source()).unwrap();
    let (document, buffer) = parts(&bytes);
    let wanted = [(0, vec![0, 3, 2]), (1, vec![0, 1, 3]), (2, vec![0, 2, 1]), (3, vec![4, 5, 6])];
    assert_eq!(primitives(&document, &buffer, 0), wanted);
    let names: Vec<&Value> = document["materials"].as_array().unwrap().iter().map(|own| &own["name"]).collect();
    assert_eq!(names, ["glaze", "clay", "outer", "crack"]);
    check_manifold(&document, &buffer, &sample);
}

#[test]
fn materials_textures_and_images_are_copied() {
    let sample = sample();
    let uvs = vec![[0.25, 0.75]; sample.positions.len()];
    let fragment = FragmentView { uvs: &uvs, ..textured(&sample, 0, &MIXED) };
    let (bytes, written) = glb_bytes_with(&[fragment], &source()).unwrap();
    assert_eq!((written.closed, written.bytes), (1, bytes.len()));
    let (document, buffer) = parts(&bytes);
    let glaze = &document["materials"][0];
    let transform = json!({ "KHR_texture_transform": { "offset": [0.1, 0.3] } });
    assert_eq!(glaze["pbrMetallicRoughness"]["baseColorTexture"], json!({ "index": 1, "extensions": transform }));
    assert_eq!((&glaze["extras"], &glaze["doubleSided"]), (&json!({ "shop": "kiln" }), &json!(true)));
    assert_eq!(document["materials"][1], json!({ "name": "clay", "normalTexture": { "index": 0, "scale": 0.8 } }));
    assert_eq!(document["materials"].as_array().unwrap().len(), 3, "no material `outer`");
    assert_eq!(document["textures"], json!([{ "source": 0 }, { "source": 1, "sampler": 0, "name": "paint" }]));
    assert_eq!(document["samplers"], json!([{ "wrapS": 33071 }]));
    assert_eq!(document["extensionsUsed"], json!(["KHR_texture_transform", "EXT_mesh_manifold"]));
    for (image, wanted, media_type) in [(0, &b"png"[..], "image/png"), (1, b"paint", "image/jpeg")] {
        let image = &document["images"][image];
        assert_eq!(image["mimeType"], media_type);
        let view = &document["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let first = view["byteOffset"].as_u64().unwrap() as usize;
        assert!(first.is_multiple_of(4) && view.get("target").is_none(), "{view}");
        assert_eq!(&buffer[first..first + view["byteLength"].as_u64().unwrap() as usize], wanted);
    }
    let wanted = [(0, vec![0, 1, 3]), (1, vec![0, 2, 1, 0, 3, 2]), (2, vec![4, 5, 6])];
    assert_eq!(primitives(&document, &buffer, 0), wanted);
    assert!(document["meshes"][0]["primitives"].as_array().unwrap().iter().all(|own| own.get("extras").is_none()));
    check_manifold(&document, &buffer, &sample);
    assert_eq!(document["nodes"][0]["extras"]["mass_kg"], 400.0);
}

#[test]
fn an_independent_reader_finds_the_textures() {
    let sample = sample();
    let uvs = vec![[0.25, 0.75]; sample.positions.len()];
    for center_m in [[0.5, -2.0, 0.25], [500_000.0, 200.0, 5_000_000.0]] {
        let fragment = FragmentView { uvs: &uvs, center_m, ..textured(&sample, 0, &MIXED) };
        let file = gltf::Gltf::from_slice(&glb_bytes_with(&[fragment], &source()).unwrap().0).unwrap();
        let mesh = file.document.meshes().next().unwrap();
        let names: Vec<Option<String>> =
            mesh.primitives().map(|own| own.material().name().map(str::to_owned)).collect();
        assert_eq!(names, ["glaze", "clay", "crack"].map(|name| Some(name.to_owned())));
        let glaze = mesh.primitives().next().unwrap().material();
        let texture = glaze.pbr_metallic_roughness().base_color_texture().unwrap().texture();
        assert_eq!((texture.name(), texture.source().index()), (Some("paint"), 1));
        let reader = mesh.primitives().next().unwrap();
        let reader = reader.reader(|_| file.blob.as_deref());
        assert_eq!(reader.read_tex_coords(0).unwrap().into_f32().next(), Some([0.25, 0.25]));
    }
}

/// A material that uses the second set keeps its `texCoord`, and outer faces have that set.
#[test]
fn second_textures_and_colors_are_attributes_of_outer_faces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.gltf");
    let document = json!({
        "asset": { "version": "2.0" },
        "materials": [{ "name": "glaze", "occlusionTexture": { "index": 0, "texCoord": 1 } }, { "name": "clay" }],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "data:image/png;base64,cG5n" }],
    });
    std::fs::write(&path, document.to_string()).unwrap();
    let source = SourceMaterials::read(&path).unwrap();
    let (sample, inside) =
        (sample(), Sample { runs: vec![RunView { crack: true, index_first: 0, index_count: 12 }], ..sample() });
    let (uvs2, colors) = (vec![[0.5, 0.75]; 7], (0..7).map(|k| [k, 2, 3, 128]).collect::<Vec<[u8; 4]>>());
    let of = |own, id, materials| FragmentView { uvs2: &uvs2, colors: &colors, ..textured(own, id, materials) };
    let fragments = [of(&sample, 0, &MIXED), of(&inside, 1, &[NO_MATERIAL; 4]), of(&sample, 2, &MIXED)];
    let (bytes, written) = glb_bytes_with(&fragments, &source).unwrap();
    assert_eq!(written.closed, 3);
    let (json, buffer) = parts(&bytes);
    assert_eq!(json["materials"][0]["occlusionTexture"], json!({ "index": 0, "texCoord": 1 }));
    check_manifold(&json, &buffer, &sample);
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    for mesh in file.document.meshes() {
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|_| file.blob.as_deref());
            let read = reader.read_tex_coords(1).map(|uvs| uvs.into_f32().collect::<Vec<_>>());
            let read_colors = reader.read_colors(0).map(|colors| colors.into_rgba_u8().collect::<Vec<_>>());
            match primitive.material().name() {
                Some("crack") => assert_eq!((read, read_colors), (None, None)),
                _ => assert_eq!((read, read_colors), (Some(vec![[0.5, 0.25]; 7]), Some(colors.clone()))),
            }
        }
    }
    assert_eq!(json["accessors"].as_array().unwrap().iter().filter(|own| own["normalized"] == true).count(), 2);
    let (plain, _) = parts(&glb_bytes(&fragments).unwrap().0);
    let base = |material: usize| plain["materials"][material]["pbrMetallicRoughness"]["baseColorFactor"].clone();
    assert!(base(0).is_null() || base(0) == json!([1.0, 1.0, 1.0, 1.0]), "{}", base(0));
}

#[test]
fn textures_without_their_coordinates_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.gltf");
    let refused = |texture: Value, uvs2: &[[f32; 2]]| {
        let document = json!({
            "asset": { "version": "2.0" },
            "materials": [{ "name": "plain" }, { "extensions": { "KHR_materials_sheen": { "sheenColorTexture": texture } } }],
            "textures": [{ "source": 0 }],
            "images": [{ "uri": "data:image/png;base64,cG5n" }],
        });
        std::fs::write(&path, document.to_string()).unwrap();
        let sample = sample();
        let fragment = FragmentView { uvs2, ..textured(&sample, 0, &MIXED) };
        glb_bytes_with(&[fragment], &SourceMaterials::read(&path).unwrap()).err().map(|error| error.to_string())
    };
    let second = json!({ "index": 0, "texCoord": 1 });
    let message = refused(second.clone(), &[]).unwrap();
    assert!(message.contains("material 1 of ") && message.contains("TEXCOORD_1, which"), "{message}");
    assert_eq!(refused(second, &[[0.5; 2]; 7]), None);
    let moved = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": { "texCoord": 2 } } });
    let message = refused(moved, &[[0.5; 2]; 7]).unwrap();
    assert!(message.contains("TEXCOORD_2, which") && message.contains("two sets at most"), "{message}");
}

#[test]
fn files_without_materials_have_the_same_bytes_as_before_and_equal_ones_equal_bytes() {
    let sample = sample();
    let (plain, _) = glb_bytes(&[view(&sample, 0)]).unwrap();
    let (document, buffer) = parts(&plain);
    assert_eq!(primitives(&document, &buffer, 0), [(0, sample.indices[..9].to_vec()), (1, vec![4, 5, 6])]);
    assert!(document["meshes"][0]["primitives"][0].get("extras").is_none());
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["one.glb", "two.glb"].map(|name| {
        let path = folder.path().join(name);
        let written = write_glb_with(&path, &[textured(&sample, 0, &MIXED)], &source()).unwrap();
        assert_eq!(written.files, [path.as_path()]);
        std::fs::read(path).unwrap()
    });
    assert_eq!(one, two);
}

#[test]
fn a_source_without_materials_leaves_the_two_of_fragments() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plain.gltf");
    std::fs::write(&path, r#"{"asset":{"version":"2.0"}}"#).unwrap();
    let source = SourceMaterials::read(&path).unwrap();
    let sample = sample();
    let with = glb_bytes_with(&[view(&sample, 0)], &source).unwrap().0;
    assert_eq!(parts(&with), parts(&glb_bytes(&[view(&sample, 0)]).unwrap().0));
}

#[test]
fn interior_fragments_have_the_material_crack_alone() {
    let (outside, mut inside) = (sample(), sample());
    inside.runs = vec![RunView { crack: true, index_first: 0, index_count: 12 }];
    let fragments = [textured(&outside, 0, &MIXED), textured(&inside, 1, &[NO_MATERIAL; 4])];
    let (document, buffer) = parts(&glb_bytes_with(&fragments, &source()).unwrap().0);
    assert_eq!(primitives(&document, &buffer, 1), [(2, inside.indices)]);
}

#[test]
fn materials_that_do_not_fit_are_refused() {
    let (sample, source) = (sample(), source());
    let error = glb_bytes(&[textured(&sample, 3, &MIXED[..3])]).unwrap_err();
    assert_eq!(error.to_string(), "fragment 3: it has 3 materials for 4 triangles");
    let error = glb_bytes_with(&[view(&sample, 0)], &source).unwrap_err();
    assert!(matches!(error, ExportError::NoMaterials { .. }), "{error}");
    let error = glb_bytes_with(&[textured(&sample, 3, &[0, 2, 1, NO_MATERIAL])], &source).unwrap_err();
    assert_eq!(error.materials_file(), Some(source.path()));
    let text = error.to_string();
    assert!(text.starts_with("fragment 3 has the material 2, but "), "{text}");
    assert!(text.contains("has the materials 0 to 1: the object was baked from another file"), "{text}");
    // Materials of cracks are not read.
    assert!(glb_bytes_with(&[textured(&sample, 3, &[0, 1, 1, 7])], &source).is_ok());
    assert!(matches!(glb_bytes_with(&[], &source), Err(ExportError::NoFragments)));
}
