//! Existing cracks from the command line: a second mesh file, reported by `bake` and `inspect`, and part of the object's identity.

use serde_json::Value;
use shatter_fracture::surface::RawMesh;
use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_tests::fixture::Fixture;

/// A test folder with a block, and a sheet to half its depth.
fn with_block() -> Fixture {
    let fixture = Fixture::new();
    write_obj(&shapes::cuboid([0.4, 0.2, 0.2]), &fixture.path("block.obj")).unwrap();
    let corners = [[0.0, -0.12], [0.12, -0.12], [0.12, 0.12], [0.0, 0.12]].map(|[y, z]| [0.0, y, z].into());
    let sheet = RawMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    write_obj(&sheet, &fixture.path("sheet.obj")).unwrap();
    fixture
}

/// Bakes the block on a coarse lattice with a file of cracks; returns exit code and document.
fn bake(fixture: &Fixture, cracks: Option<&str>, more: &[&str]) -> (i32, Value) {
    let (mesh, cracks) = (fixture.path("block.obj"), cracks.map(|name| fixture.path(name)));
    let mut all = vec!["bake", mesh.to_str().unwrap(), "--name", "block"];
    all.extend(cracks.iter().flat_map(|file| ["--cracks", file.to_str().unwrap()]));
    fixture.json("shatterd", &[&all, more].concat())
}

const COARSE: [&str; 5] = ["--crack-spacing", "0.07", "--elastic-spacing", "0.1", "--examples=12"];

#[test]
fn cracks_are_a_file_of_their_own_and_part_of_the_object() {
    let fixture = with_block();
    let inspected =
        || fixture.ok("shatterd", &["inspect", fixture.databases().join("block.shatter").to_str().unwrap()]);
    let (_, whole) = bake(&fixture, None, &COARSE);
    assert!(whole["cracks"].is_null(), "{whole}");
    let without = inspected()["provenance"]["input_hash"].clone();
    let (code, baked) = bake(&fixture, Some("sheet.obj"), &COARSE);
    assert_eq!((code, &baked["cracks"]["triangles"]), (0, &2.into()), "{baked}");
    assert_eq!(inspected()["cracks"], baked["cracks"]);
    for key in ["area_m2", "width_m", "elastic_width_m", "volume_m3"] {
        assert!(baked["cracks"][key].as_f64().is_some_and(|number| number > 0.0), "{key}: {baked}");
    }
    assert_ne!(inspected()["provenance"]["input_hash"], without);
    let (code, refused) = bake(&fixture, None, &["--add", "4"]);
    assert_eq!((code, refused["error"]["kind"].as_str()), (3, Some("other_mesh")), "{refused}");
    let (code, added) = bake(&fixture, Some("sheet.obj"), &["--add", "4"]);
    assert_eq!((code, &added["cracks"]), (0, &baked["cracks"]), "{added}");
}

#[test]
fn a_bad_file_of_cracks_is_refused_by_name() {
    let fixture = with_block();
    std::fs::write(fixture.path("bad.obj"), "v 0 0 0\nv 0 nan 0\nv 1 0 0\nf 1 2 3\n").unwrap();
    std::fs::write(fixture.path("line.obj"), "v 0 0 0\nv 0 1 0\nv 0 2 0\nf 1 2 3\n").unwrap();
    for (name, words) in [("bad.obj", "bad.obj"), ("none.obj", "none.obj"), ("line.obj", "existing cracks")] {
        let (code, refused) = bake(&fixture, Some(name), &COARSE);
        let message = refused["error"]["message"].as_str().unwrap();
        assert!(code == 3 && message.contains(words), "{refused}");
        assert_eq!(message.matches(name).count(), usize::from(name == words), "named once: {message}");
    }
    assert!(!fixture.databases().join("block.shatter").exists());
}
