//! Tests of reading, with documents made by hand.

use super::*;
use serde_json::json;
use std::fs;

/// A document with these members beside its version.
fn document(members: &Value) -> Value {
    let mut document = json!({ "asset": { "version": "2.0" } });
    let all = members.as_object().unwrap().clone();
    document.as_object_mut().unwrap().extend(all);
    document
}

/// Reads a document as the file `mesh/a.gltf` of a folder.
fn read(folder: &Path, members: &Value) -> Result<SourceMaterials, ExportError> {
    fs::create_dir_all(folder.join("mesh")).unwrap();
    let path = folder.join("mesh/a.gltf");
    fs::write(&path, document(members).to_string()).unwrap();
    SourceMaterials::read(&path)
}

/// Message of the error for a document.
#[track_caller]
fn refusal(members: &Value) -> String {
    read(tempfile::tempdir().unwrap().path(), members).map(drop).unwrap_err().to_string()
}

#[test]
fn images_come_from_data_uris_files_and_views_of_either() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("mesh/parts")).unwrap();
    fs::write(folder.path().join("mesh/parts/a b.JPG"), "jpeg").unwrap();
    fs::write(folder.path().join("mesh/a.bin"), "0123456789").unwrap();
    let source = read(
        folder.path(),
        &json!({
            "images": [
                { "uri": "data:image/png;base64,cG5n", "name": "one", "extras": { "kept": 1 } },
                { "uri": "parts/a%20b.JPG" },
                { "bufferView": 0, "mimeType": "image/png" },
                { "bufferView": 1, "mimeType": "image/jpeg" },
            ],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 2, "byteLength": 3 },
                { "buffer": 1, "byteLength": 3 },
            ],
            "buffers": [
                { "uri": "a.bin", "byteLength": 10 },
                { "uri": "data:application/octet-stream;base64,cG5n", "byteLength": 3 },
            ],
        }),
    )
    .unwrap();
    let bytes: Vec<&[u8]> = source.images.iter().map(|image| image.bytes.as_slice()).collect();
    assert_eq!(bytes, [&b"png"[..], b"jpeg", b"234", b"png"]);
    let types: Vec<&Value> = source.images.iter().map(|image| &image.members["mimeType"]).collect();
    assert_eq!(types, ["image/png", "image/jpeg", "image/png", "image/jpeg"]);
    assert_eq!(source.images[0].members["extras"], json!({ "kept": 1 }));
    assert!(source.images.iter().all(|image| !image.members.contains_key("uri")));
}

#[test]
fn extensions_of_materials_and_textures_are_declared_and_others_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let source = read(
        folder.path(),
        &json!({
            "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_clearcoat"],
            "extensionsRequired": ["KHR_texture_transform", "KHR_materials_variants"],
            "materials": [{
                "pbrMetallicRoughness": {
                    "baseColorTexture": { "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } },
                },
                "extensions": { "KHR_materials_clearcoat": {}, "ACME_rust": {} },
                "extras": { "extensions": { "no_extension": {} } },
            }],
            "textures": [{}],
        }),
    )
    .unwrap();
    assert_eq!(source.extensions_used, ["KHR_texture_transform", "KHR_materials_clearcoat", "ACME_rust"]);
    assert_eq!(source.extensions_required, ["KHR_texture_transform"]);
    assert_eq!((source.count(), source.path()), (1, folder.path().join("mesh/a.gltf").as_path()));
}

#[test]
fn images_of_extensions_are_kept_where_the_extension_is_used() {
    let image = json!({ "uri": "data:image/ktx2;base64,a3R4" });
    let texture = json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } });
    let required = json!(["KHR_texture_basisu"]);
    let folder = tempfile::tempdir().unwrap();
    let members = json!({
        "extensionsUsed": required, "extensionsRequired": required, "textures": [texture], "images": [image],
    });
    let source = read(folder.path(), &members).unwrap();
    assert_eq!(source.extensions_required, ["KHR_texture_basisu"]);
    assert_eq!(source.images[0].members["mimeType"], "image/ktx2");
    let error = refusal(&json!({ "images": [image] }));
    assert!(error.ends_with("image 0: has the format 'image/ktx2': convert it to PNG or JPEG"), "{error}");
}

#[test]
fn required_extensions_of_other_parts_are_refused_by_name() {
    let error = refusal(&json!({ "extensionsRequired": ["KHR_draco_mesh_compression"] }));
    assert!(error.contains("requires the extension `KHR_draco_mesh_compression`"), "{error}");
}

#[test]
fn defects_are_named_with_their_place() {
    let png = "data:image/png;base64,cG5n";
    for (members, wanted) in [
        (json!({ "asset": { "version": "1.0" } }), "asset.version: is 1.0"),
        (json!({ "materials": {} }), "materials: is not a list"),
        (json!({ "materials": [5] }), "materials: is not a list"),
        (json!({ "materials": [{ "normalTexture": { "index": 0 } }] }), "material 0, normalTexture: its index is 0"),
        (
            json!({ "materials": [{ "extensions": { "KHR_materials_x": { "coatTexture": { "index": 3 } } } }] }),
            "material 0, coatTexture: its index is 3",
        ),
        (json!({ "textures": [{ "source": 1 }], "images": [{ "uri": png }] }), "texture 0: its source is 1"),
        (json!({ "textures": [{ "sampler": -1 }] }), "texture 0: its sampler is -1, not a whole number"),
        (json!({ "images": [{}] }), "image 0: has neither"),
        (json!({ "images": [{ "uri": png, "bufferView": 0 }] }), "image 0: has both"),
        (json!({ "images": [{ "uri": "data:image/png,png" }] }), "image 0: is a data URI without base64"),
        (json!({ "images": [{ "uri": "data:image/png;base64,*" }] }), "image 0: its data URI is damaged"),
        (json!({ "images": [{ "uri": "data:image/gif;base64,cG5n" }] }), "image 0: has the format 'image/gif'"),
        (json!({ "images": [{ "bufferView": 0 }] }), "bufferView 0: does not exist"),
        (
            json!({
                "images": [{ "bufferView": 0, "mimeType": "image/png" }],
                "bufferViews": [{ "buffer": 0, "byteLength": 5, "byteOffset": 1 }],
                "buffers": [{ "uri": "data:;base64,cG5n", "byteLength": 3 }],
            }),
            "bufferView 0: its bytes 1 to 1 + 5 exceed buffer 0, which has 3",
        ),
        (
            json!({ "images": [{ "bufferView": 0 }], "bufferViews": [{ "buffer": 0, "byteLength": 5 }], "buffers": [{}] }),
            "buffer 0: has neither",
        ),
        (json!({ "extensionsUsed": [1] }), "extensionsUsed: is not a list of names"),
    ] {
        let error = refusal(&members);
        assert!(error.starts_with("malformed glTF file ") && error.contains(wanted), "{error}");
    }
}

#[test]
fn files_that_are_missing_or_of_another_format_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let error = SourceMaterials::read(&folder.path().join("none.glb")).unwrap_err();
    assert!(matches!(error, ExportError::ReadMaterials { .. }), "{error}");
    assert!(matches!(SourceMaterials::read(folder.path()), Err(ExportError::ReadMaterials { .. })));
    let missing = refusal(&json!({ "images": [{ "uri": "none.png" }] }));
    assert!(missing.starts_with("cannot read ") && missing.contains("none.png"), "{missing}");
    let file = folder.path().join("a.glb");
    for (bytes, wanted) in [
        (&b"o cube\nv 0 0 0\n"[..], "document: "),
        (b"{}", "asset.version: is missing"),
        (b"glTF", "byte 4: the version of the container is missing"),
        (b"glTF\x01\0\0\0\x0c\0\0\0", "byte 4: the version of the container is 1, not 2"),
        (b"glTF\x02\0\0\0\x0c\0\0\0", "byte 12: the file ends within a chunk"),
        (b"glTF\x02\0\0\0\x14\0\0\0\x09\0\0\0JSON{}", "byte 12: the file ends within a chunk"),
        (b"glTF\x02\0\0\0\x14\0\0\0\0\0\0\0BIN\0", "byte 12: the first chunk is not JSON"),
    ] {
        fs::write(&file, bytes).unwrap();
        let error = SourceMaterials::read(&file).unwrap_err();
        let text = error.to_string();
        assert!(text.contains(wanted), "{text}");
        assert_eq!((error.materials_file(), error.path()), (Some(file.as_path()), None));
    }
}

#[test]
fn files_out_of_the_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("mesh/parts")).unwrap();
    fs::write(at("secret.png"), "png").unwrap();
    fs::write(at("mesh/own.png"), "png").unwrap();
    std::os::unix::fs::symlink("../secret.png", at("mesh/out.png")).unwrap();
    std::os::unix::fs::symlink("own.png", at("mesh/in.png")).unwrap();
    for uri in ["own.png", "./own.png", "in.png"] {
        read(folder.path(), &json!({ "images": [{ "uri": uri }] })).unwrap_or_else(|error| panic!("{uri}: {error}"));
    }
    let absolute = at("secret.png");
    let absolute = absolute.to_str().unwrap();
    for uri in [
        "../secret.png",
        "parts/../own.png",
        "%2e%2e/secret.png",
        "..%5Csecret.png",
        absolute,
        &format!("file://{absolute}"),
        "C:/secret.png",
        "http://127.0.0.1/own.png",
        "own.png%00",
        "out.png",
        "",
    ] {
        let error = read(folder.path(), &json!({ "images": [{ "uri": uri }] })).map(drop).unwrap_err().to_string();
        assert!(error.contains("image 0") && error.contains("leads out"), "{uri}: {error}");
    }
}
