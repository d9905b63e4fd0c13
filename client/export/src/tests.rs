//! Tests of the file against the rules of the formats, read by hand; `shatter-tests` reads it with an independent library.

mod folders;
mod materials;

use super::*;
use serde_json::Value;
use std::path::Path;

/// A tetrahedron: three outer faces with vertices of their own, one crack face with three more.
struct Sample {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    runs: Vec<RunView>,
    merges: Vec<[u32; 2]>,
}

fn sample() -> Sample {
    let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    Sample {
        positions: vec![o, x, y, z, x, y, z],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 4, 5, 6],
        runs: vec![
            RunView { crack: false, index_first: 0, index_count: 9 },
            RunView { crack: true, index_first: 9, index_count: 3 },
        ],
        merges: vec![[4, 1], [5, 2], [6, 3]],
    }
}

fn view(sample: &Sample, id: u32) -> FragmentView<'_> {
    FragmentView {
        normals: &[],
        uvs: &[],
        uvs2: &[],
        colors: &[],
        materials: &[],
        id,
        body: 0,
        positions: &sample.positions,
        indices: &sample.indices,
        runs: &sample.runs,
        merges: &sample.merges,
        center_m: [0.5, -2.0, 0.25],
        volume_m3: 1.0 / 6.0,
        mass_kg: 400.0,
        inertia_kg_m2: [3.0, 2.0, 4.0, 0.5, 0.25, -0.5],
    }
}

/// Splits a `.glb` into its document and its buffer, and checks the container.
fn parts(bytes: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!((word(4), word(8)), (2, bytes.len()));
    let json_end = 20 + word(12);
    assert_eq!(&bytes[16..20], b"JSON");
    assert_eq!(&bytes[json_end + 4..json_end + 8], b"BIN\0");
    assert_eq!(json_end + 8 + word(json_end), bytes.len());
    assert!(bytes.len().is_multiple_of(4) && json_end.is_multiple_of(4));
    (serde_json::from_slice(&bytes[20..json_end]).unwrap(), bytes[json_end + 8..].to_vec())
}

/// Words of the dense part of an accessor.
fn words(document: &Value, buffer: &[u8], accessor: &Value) -> Vec<u32> {
    let accessor = &document["accessors"][accessor.as_u64().unwrap() as usize];
    let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let first = (view["byteOffset"].as_u64().unwrap() + accessor["byteOffset"].as_u64().unwrap()) as usize;
    let lanes = if accessor["type"] == "VEC3" { 3 } else { 1 };
    let count = accessor["count"].as_u64().unwrap() as usize * lanes;
    buffer[first..first + 4 * count].chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect()
}

#[test]
fn a_fragment_is_one_node_with_shared_accessors_and_two_materials() {
    let sample = sample();
    let (bytes, written) = glb_bytes(&[view(&sample, 0), view(&sample, 1)]).unwrap();
    assert_eq!((written.fragments, written.closed, written.bytes), (2, 2, bytes.len()));
    assert!(written.files.is_empty(), "{:?}", written.files);
    let (document, _) = parts(&bytes);
    assert_eq!(document["asset"]["version"], "2.0");
    assert_eq!(document["extensionsUsed"], serde_json::json!(["EXT_mesh_manifold"]));
    assert!(document.get("extensionsRequired").is_none());
    let node = &document["nodes"][1];
    assert_eq!(node["name"], "fragment_001");
    assert_eq!(node["extras"]["fragment"], 1);
    assert_eq!(node["extras"]["mass_kg"], 400.0);
    assert_eq!(node["extras"]["inertia_kg_m2"], serde_json::json!([3.0, 2.0, 4.0, 0.5, 0.25, -0.5]));
    assert_eq!(node["translation"], serde_json::json!([0.5, -2.0, 0.25]));
    let primitives = &document["meshes"][1]["primitives"];
    assert_eq!(primitives[0]["attributes"], primitives[1]["attributes"]);
    assert_eq!([&primitives[0]["material"], &primitives[1]["material"]], [0, 1]);
    let position = &document["accessors"][primitives[0]["attributes"]["POSITION"].as_u64().unwrap() as usize];
    assert_eq!(position["min"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(position["max"], serde_json::json!([1.0, 1.0, 1.0]));
}

/// The document of three fragments about `place_m`, and their centers.
fn at(place_m: [f64; 3]) -> (Value, Vec<[f64; 3]>) {
    let sample = sample();
    let centers: Vec<[f64; 3]> =
        [0.0, 0.3, 1.1].map(|step| [0, 1, 2].map(|k| place_m[k] + step * (k + 1) as f64)).to_vec();
    let views: Vec<FragmentView<'_>> =
        (0..).zip(&centers).map(|(id, center_m)| FragmentView { center_m: *center_m, ..view(&sample, id) }).collect();
    (parts(&glb_bytes(&views).unwrap().0).0, centers)
}

fn vector(node: &Value) -> [f64; 3] {
    serde_json::from_value(node["translation"].clone()).unwrap()
}

#[test]
fn fragments_far_from_the_origin_are_placed_relative_to_a_parent() {
    for place_m in [[500_000.0, 200.0, 5_000_000.0], [-0.01, 300.7, 1e9], [400.0, 0.0, 0.0]] {
        let (document, centers) = at(place_m);
        let nodes = document["nodes"].as_array().unwrap();
        let parent = &nodes[3];
        assert_eq!(document["scenes"][0]["nodes"], serde_json::json!([3]));
        assert_eq!((&parent["name"], &parent["children"]), (&"object".into(), &serde_json::json!([0, 1, 2])));
        let origin = vector(parent);
        // Readers with single and with double precision take it for the same number.
        assert_eq!(origin, origin.map(|x| f64::from(x as f32)), "{origin:?}");
        let spacing = place_m.iter().fold(0.0, |largest: f64, x| largest.max(x.abs())) * f64::from(f32::EPSILON);
        for (node, center) in nodes.iter().zip(&centers) {
            let own = vector(node);
            for k in 0..3 {
                assert!(own[k].abs() < 3.0 + spacing, "{own:?} is far from the parent");
                let off = (origin[k] + own[k] - center[k]).abs();
                let rounding = f64::from(f32::EPSILON) * own[k].abs() + f64::EPSILON * center[k].abs();
                assert!(off <= rounding, "{off:e} along {k} at {place_m:?}");
            }
            assert_eq!(node["extras"]["center_m"], serde_json::json!(center));
        }
    }
}

#[test]
fn fragments_near_the_origin_have_no_parent() {
    for place_m in [[0.0; 3], [-2.0, 1.3, 0.0], [10.0, 0.0, -7.0]] {
        let (document, centers) = at(place_m);
        assert_eq!(document["scenes"][0]["nodes"], serde_json::json!([0, 1, 2]));
        let nodes = document["nodes"].as_array().unwrap();
        assert!(nodes.iter().all(|node| node.get("children").is_none()));
        for (node, center) in nodes.iter().zip(centers) {
            assert_eq!(vector(node).map(|x| x as f32), center.map(|x| x as f32));
        }
    }
}

#[test]
fn the_manifold_primitive_joins_what_the_runs_split() {
    let sample = sample();
    let (bytes, _) = glb_bytes(&[view(&sample, 0)]).unwrap();
    let (document, buffer) = parts(&bytes);
    let mesh = &document["meshes"][0];
    let extension = &mesh["extensions"]["EXT_mesh_manifold"];
    let manifold = &extension["manifoldPrimitive"];
    assert_eq!(manifold["attributes"]["POSITION"], mesh["primitives"][0]["attributes"]["POSITION"]);
    assert!(manifold.get("material").is_none());
    let mut indices = words(&document, &buffer, &manifold["indices"]);
    let places = words(&document, &buffer, &extension["mergeIndices"]);
    let values = words(&document, &buffer, &extension["mergeValues"]);
    assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "sparse indices must rise");
    for (place, value) in places.into_iter().zip(values) {
        indices[place as usize] = value;
    }
    assert_eq!(indices, [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    let sparse = &document["accessors"][manifold["indices"].as_u64().unwrap() as usize]["sparse"];
    assert_eq!(sparse["count"], 3);
}

#[test]
fn normals_are_unit_and_sharp_between_runs() {
    let sample = sample();
    let (bytes, _) = glb_bytes(&[view(&sample, 0)]).unwrap();
    let (document, buffer) = parts(&bytes);
    let normals = words(&document, &buffer, &document["meshes"][0]["primitives"][1]["attributes"]["NORMAL"]);
    let normals: Vec<f32> = normals.into_iter().map(f32::from_bits).collect();
    let third = 1.0 / 3.0_f32.sqrt();
    for (vertex, normal) in normals.chunks_exact(3).enumerate() {
        assert!((normal.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-6);
        assert_eq!(vertex >= 4, normal.iter().all(|x| (x - third).abs() < 1e-6));
    }
}

#[test]
fn an_open_fragment_has_no_manifold_primitive() {
    let mut sample = sample();
    sample.merges.pop();
    let (bytes, written) = glb_bytes(&[view(&sample, 0)]).unwrap();
    assert_eq!(written.closed, 0);
    assert!(!is_closed(&view(&sample, 0)));
    let (document, _) = parts(&bytes);
    assert!(document["meshes"][0].get("extensions").is_none() && document.get("extensionsUsed").is_none());
}

#[test]
fn an_interior_fragment_has_one_primitive() {
    let mut sample = sample();
    sample.runs[0].crack = true;
    let (document, _) = parts(&glb_bytes(&[view(&sample, 0)]).unwrap().0);
    assert_eq!(document["meshes"][0]["primitives"].as_array().unwrap().len(), 1);
    assert_eq!(document["meshes"][0]["primitives"][0]["material"], 1);
}

#[test]
fn equal_fragments_give_equal_bytes() {
    let (one, two) = (sample(), sample());
    assert_eq!(glb_bytes(&[view(&one, 3)]).unwrap().0, glb_bytes(&[view(&two, 3)]).unwrap().0);
}

/// Corrupts a sample and expects an error that begins with `message`.
fn check(message: &str, damage: impl Fn(&mut Sample)) {
    let mut damaged = sample();
    damage(&mut damaged);
    let error = glb_bytes(&[view(&damaged, 5)]).unwrap_err().to_string();
    assert!(error.starts_with(message), "{error}");
}

#[test]
fn data_that_no_gltf_reader_accepts_is_rejected_by_name() {
    check("fragment 5: a coordinate is not finite", |s| s.positions[2][1] = f32::NAN);
    check("fragment 5: index 4 names vertex 7", |s| s.indices[4] = 7);
    check("fragment 5: run 1 is out of order", |s| s.runs[1].index_first = 6);
    check("fragment 5: run 0 is out of order", |s| s.runs.swap(0, 1));
    check("fragment 5: run 1 is out of order", |s| (s.runs[0].crack, s.runs[1].crack) = (true, false));
    check("fragment 5: run 2 is out of order", |s| s.indices.extend([0, 1, 2]));
    check("fragment 5: merge pair 1 joins", |s| s.merges[1] = [5, 3]);
    check("fragment 5: merge pair 0 joins", |s| s.merges[0] = [99, 3]);
    assert!(matches!(glb_bytes(&[]), Err(ExportError::NoFragments)));
}

#[test]
fn an_invalid_folder_is_named_and_left_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let sample = sample();
    let fragments = [view(&sample, 0)];
    std::fs::write(folder.path().join("file"), "").unwrap();
    let below = folder.path().join("file/below");
    let error = write_glb(&below.join("a.glb"), &fragments).unwrap_err();
    assert!(matches!(&error, ExportError::NotAFolder { folder, .. } if *folder == below), "{error}");
    assert!(error.to_string().ends_with("file is a file, not a folder; choose another path"), "{error}");
    let error = write_glb(folder.path(), &fragments).unwrap_err();
    assert!(matches!(error, ExportError::IsFolder(_)), "{error}");
    let error = write_glb(Path::new("/proc/shatter.glb"), &fragments).unwrap_err();
    assert!(matches!(error, ExportError::Folder { .. }), "{error}");
    for (path, wanted) in [
        ("/dev/full/a.glb", "/dev/full is a device, not a folder; choose another path"),
        (
            "/dev/full/b/a.glb",
            "cannot make the folder /dev/full/b: /dev/full is a device, not a folder; choose another",
        ),
        ("/proc/shatter/a.glb", "cannot make the folder /proc/shatter: the file system there makes no folders"),
    ] {
        let error = write_glb(Path::new(path), &fragments).unwrap_err().to_string();
        assert!(error.starts_with(wanted) && error.contains("choose another path"), "{error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_new_folder_is_made_for_a_file_as_for_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let sample = sample();
    let file = folder.path().join("new/er/a.glb");
    write_glb(&file, &[view(&sample, 0)]).unwrap();
    assert!(file.is_file());
}

#[test]
fn symlinks_are_followed_and_special_files_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let sample = sample();
    let fragments = [view(&sample, 0)];
    let [pipe, link, file] = ["pipe.glb", "link.glb", "file.glb"].map(|name| folder.path().join(name));
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, mode).unwrap();
    let error = write_glb(&pipe, &fragments).unwrap_err();
    assert!(matches!(error, ExportError::NoFile(_)) && !pipe.is_file(), "{error}");
    std::fs::write(&file, "old").unwrap();
    std::os::unix::fs::symlink("file.glb", &link).unwrap();
    write_glb(&link, &fragments).unwrap();
    assert!(link.is_symlink() && std::fs::read(&file).unwrap().starts_with(b"glTF"));
    std::os::unix::fs::symlink("nowhere/else.glb", folder.path().join("lost.glb")).unwrap();
    assert!(matches!(write_glb(&folder.path().join("lost.glb"), &fragments), Err(ExportError::Write { .. })));
}

#[test]
fn a_file_is_replaced_whole_and_keeps_any_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("zerbrochener Krug ☂.glb");
    std::fs::write(&path, b"old").unwrap();
    let sample = sample();
    let written = write_glb(&path, &[view(&sample, 0)]).unwrap();
    assert_eq!(std::fs::read(&path).unwrap().len(), written.bytes);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
