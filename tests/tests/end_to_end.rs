//! First use by a new user: a mesh file, both real programs, and their output.

use nalgebra::Point3;
use serde_json::{Value, json};
use shatter_fracture::fragment::RigidProperties;
use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_fracture::surface::{LengthUnit, RawMesh, UpAxis};
use shatter_lab::study::accuracy::{AccuracyFindings, BodyPoint, Measure, PointErrors};
use shatter_tests::fixture::Fixture;
use shatter_tests::glb::closed_file;
use shatter_tests::{glb, json_keys, real};
use std::collections::BTreeSet;
use std::path::Path;

/// A test folder with a small arch, and the daemon running.
fn with_arch(arguments: &[&str]) -> Fixture {
    let mut fixture = Fixture::new();
    let mesh = fixture.path("arch of Žofie.obj");
    write_obj(&shapes::arch(), &mesh).unwrap();
    let lattices = ["--crack-spacing", "0.035", "--elastic-spacing", "0.06", "--elements", "linear"];
    fixture.bake_once(&mesh, "arch", &[&["--material", "ceramic"][..], &lattices].concat());
    fixture.serve(arguments);
    fixture
}

/// The point of the arch with the largest x at half its height, and the impulse that just breaks it there along −x.
fn contact(fixture: &Fixture) -> (String, f64) {
    let mesh = shapes::arch();
    let height = |p: &Point3<f64>| p.y;
    let top = mesh.positions_m.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
    let bottom = mesh.positions_m.iter().map(height).fold(f64::INFINITY, f64::min);
    let middle = 0.5 * (top + bottom);
    let band = mesh.positions_m.iter().filter(|p| (p.y - middle).abs() < 0.1 * (top - bottom));
    let point = band.max_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
    let point = format!("{},{},{}", point.x, point.y, point.z);
    let found = fixture.ok("shatter", &["threshold", "arch", "--point", &point, "--direction", "-1,0,0"]);
    (point, number(&found, "impulse_ns"))
}

#[track_caller]
fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key} in {document}"))
}

fn impact(fixture: &Fixture, point: &str, impulse_ns: f64, more: &[&str]) -> Value {
    let impulse = format!("{},0,0", -impulse_ns);
    fixture.ok("shatter", &[&["impact", "arch", "--point", point, "--impulse", &impulse], more].concat())
}

fn section_hashes(document: &Value, names: &[&str]) -> Vec<String> {
    let sections = document["sections"].as_array().unwrap();
    let hash = |name: &&str| sections.iter().find(|section| section["name"] == **name).unwrap()["hash"].to_string();
    names.iter().map(hash).collect()
}

const GEOMETRY: [&str; 4] = ["positions", "indices", "runs", "merges"];

#[test]
fn a_strike_writes_closed_fragments_whose_volumes_add_up() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let file = fixture.path("scherben überall.glb");
    let document = impact(&fixture, &point, 5.0 * just, &["--degree", "24", "--out", file.to_str().unwrap()]);
    assert_eq!((document["degree_source"].as_str(), document["sites"].as_u64()), (Some("forced"), Some(24)));
    let names: Vec<&str> =
        document["stages"].as_array().unwrap().iter().map(|stage| stage["name"].as_str().unwrap()).collect();
    let wanted = ["load", "elasticity", "threshold", "degree", "centroidal", "labels", "tessellation", "fragments"];
    assert_eq!(names[..8], wanted);
    assert!(names.len() > 8, "effects under their own names");
    check_glb(&closed_file(&file), document["fragments"].as_array().unwrap().len(), volume_m3(&fixture));
}

/// Volume of the only object, as the daemon lists it.
fn volume_m3(fixture: &Fixture) -> f64 {
    number(&fixture.ok("shatter", &["list"])["objects"][0], "volume_m3")
}

/// Reads the file with a reader that shares no code with the writer.
fn check_glb(file: &Path, fragments: usize, volume_m3: f64) {
    let read = glb::read(file).unwrap();
    assert_eq!(read.len(), fragments);
    read.iter().for_each(|fragment| fragment.check_closed().unwrap());
    let sum: f64 = read.iter().map(glb::Fragment::volume_m3).sum();
    println!("{fragments} fragments, volume sum off by {:.1e}", sum / volume_m3 - 1.0);
    assert!((sum / volume_m3 - 1.0).abs() < 1e-6);
}

#[test]
fn the_intact_object_is_the_surface_on_which_fragments_end() {
    let fixture = with_arch(&[]);
    let database = fixture.databases().join("arch.shatter");
    let inspect = |mesh: &Path| {
        let arguments = ["inspect", database.to_str().unwrap(), "--mesh", mesh.to_str().unwrap()];
        fixture.json("shatterd", &arguments)
    };
    let [obj, glb, other] = ["whole.obj", "whole.glb", "whole.stl"].map(|name| fixture.path(name));
    assert_eq!(inspect(&obj).1["surface"]["kind"], "exact");
    let volume_m3 = volume_m3(&fixture);
    let read = shatter_fracture::surface::read(&obj, LengthUnit::M, UpAxis::Y).unwrap();
    let positions: Vec<[f32; 3]> = read.positions_m.iter().map(|p| p.coords.map(|x| x as f32).into()).collect();
    shatter_fracture::fragment::closed(&positions, read.triangles.as_flattened()).unwrap();
    let whole = RigidProperties::of_surface(&read.positions_m, read.triangles.iter().copied());
    assert!((whole.volume / volume_m3 - 1.0).abs() < 1e-12, "{} of {volume_m3}", whole.volume);
    let used: BTreeSet<u32> = read.triangles.iter().flatten().copied().collect();
    assert_eq!(used.len(), read.positions_m.len(), "every vertex once");
    let original = shapes::arch();
    let middle = RigidProperties::of_surface(&original.positions_m, original.triangles.iter().copied()).center;
    assert!((whole.center - middle).norm() < 0.02, "{} {middle}", whole.center);
    assert_eq!(inspect(&glb).0, 0);
    check_glb(&glb, 1, volume_m3);
    let (code, refused) = inspect(&other);
    assert_eq!((code, refused["error"]["kind"].as_str(), other.exists()), (3, Some("output"), false));
}

#[test]
fn twice_the_threshold_breaks_and_half_does_not() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let half = impact(&fixture, &point, 0.5 * just, &[]);
    assert_eq!(half["fracture_degree"], 1);
    assert_eq!(half["degree_source"], "threshold");
    assert_eq!(half["fragments"].as_array().unwrap().len(), 0);
    let ran: Vec<bool> =
        half["stages"].as_array().unwrap().iter().map(|stage| stage["ran"].as_bool().unwrap()).collect();
    assert_eq!(ran[..8], [true, true, true, false, false, false, false, false], "nothing follows the threshold test");
    let twice = impact(&fixture, &point, 2.0 * just, &[]);
    assert!(twice["fracture_degree"].as_u64().unwrap() >= 2 && twice["fragments"].as_array().unwrap().len() >= 2);
    assert!((number(&twice, "e1_over_gamma") - 4.0).abs() < 1e-6);
    // Both are solved for, as no basis was baked, and the bound ends neither.
    let at = ["threshold", "arch", "--point", &point, "--direction", "-1,0,0"];
    let threshold = number(&fixture.ok("shatter", &at)["ledger"], "strain_j");
    assert!((number(&twice["ledger"], "strain_j") / threshold - 4.0).abs() < 1e-6, "{twice}");
    let weak = impact(&fixture, &point, 1e-3 * just, &[]);
    assert_eq!((weak["elastic"].as_str(), &weak["ledger"]["strain_j"]), (Some("bounded"), &Value::Null));
}

#[test]
fn the_criterion_by_strength_has_its_own_threshold_and_ledger() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let strength = ["--criterion", "strength"];
    let at = ["threshold", "arch", "--point", &point, "--direction", "-1,0,0"];
    let threshold = fixture.ok("shatter", &[&at[..], &strength].concat());
    let own = number(&threshold, "impulse_ns");
    assert_eq!((threshold["criterion"].as_str(), own > just), (Some("strength"), true), "{threshold}");
    let whole = impact(&fixture, &point, 0.99 * own, &strength);
    assert_eq!((whole["fracture_degree"].as_u64(), &whole["ledger"]["surface_j"]), (Some(1), &Value::Null), "{whole}");
    // Far above, the arch has the energy for several cracks, and uses no more than it has.
    let broken = impact(&fixture, &point, 6.0 * own, &[&strength[..], &["--enable", "release"]].concat());
    let ledger = &broken["ledger"];
    let [strain, surface, released] = ["strain_j", "surface_j", "released_j"].map(|key| number(ledger, key));
    assert!(broken["fragments"].as_array().unwrap().len() >= 2 && surface > 0.0 && released > 0.0, "{ledger}");
    assert!(surface + released <= strain && ledger["deficit_j"].is_null(), "{ledger}");
    assert!(number(ledger, "stress_over_strength") >= 1.0);
    assert!(number(&broken["averaged_over"], "length_m") > 0.0);
    let forced = impact(&fixture, &point, 0.05 * own, &[&strength[..], &["--degree", "24"]].concat());
    assert!(number(&forced["ledger"], "deficit_j") > 0.0 && forced["sites"] == 24, "{}", forced["ledger"]);
    let paper = impact(&fixture, &point, 2.0 * just, &[]);
    assert_eq!((paper["criterion"].as_str(), &paper["ledger"]["surface_j"]), (Some("paper"), &Value::Null));
    assert_eq!(paper["output_hash"], impact(&fixture, &point, 2.0 * just, &["--criterion", "paper"])["output_hash"]);
}

#[test]
fn the_threshold_depends_on_the_contact_as_the_impact_does() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let at = ["threshold", "arch", "--point", &point, "--direction", "-1,0,0"];
    let contact = ["--radius-m", "0.4", "--duration-s", "0.05"];
    let other = number(&fixture.ok("shatter", &[&at[..], &contact].concat()), "impulse_ns");
    assert!((other / just - 1.0).abs() > 1e-3, "{other} and {just}");
    let struck = impact(&fixture, &point, 2.0 * other, &contact);
    assert!((number(&struck, "e1_over_gamma") - 4.0).abs() < 1e-6, "{struck}");
    for impulse in [0.5 * just, 2.0 * just] {
        let impulse = format!("{},0,0", -impulse);
        let shown = fixture.run("shatter", &["impact", "arch", "--point", &point, "--impulse", &impulse]);
        let text = String::from_utf8(shown.stdout).unwrap();
        // Errors of displacements are relative to a solve, so that a solve has none.
        assert!(["displacements: solve;", "confidence"].iter().all(|word| text.contains(word)), "{text}");
    }
}

#[test]
fn ten_times_the_impulse_with_a_hundred_times_gamma_is_the_same_geometry() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let first = impact(&fixture, &point, 4.0 * just, &[]);
    let gamma = format!("{:e}", 100.0 * number(&first, "gamma_j_m2"));
    let second = impact(&fixture, &point, 40.0 * just, &["--gamma", &gamma]);
    assert_eq!(section_hashes(&first, &GEOMETRY), section_hashes(&second, &GEOMETRY));
    let other = impact(&fixture, &point, 4.0 * just, &["--seed", "9"]);
    assert_ne!(section_hashes(&first, &GEOMETRY), section_hashes(&other, &GEOMETRY), "the hash would not notice");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let mut fixture = with_arch(&["--threads", "1"]);
    let (point, just) = contact(&fixture);
    let mut hashes = Vec::new();
    for threads in ["1", "2", "4"] {
        assert_eq!(fixture.end(), Some(0));
        fixture.serve(&["--threads", threads]);
        hashes.push(impact(&fixture, &point, 6.0 * just, &["--degree", "30"])["output_hash"].clone());
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
}

#[test]
fn bad_strikes_are_refused_by_name() {
    let fixture = with_arch(&[]);
    let (point, _) = contact(&fixture);
    let refused = |arguments: &[&str], kind: &str| {
        let (code, document) = fixture.json("shatter", arguments);
        assert_eq!((code, document["error"]["kind"].as_str()), (3, Some(kind)), "{arguments:?}: {document}");
        assert_eq!(document["error"]["fault"], "caller");
    };
    let point = point.as_str();
    refused(&["impact", "nothing", "--point", point, "--impulse", "-1,0,0"], "unknown_object");
    refused(&["impact", "arch", "--point", "9,9,9", "--impulse", "-1,0,0"], "contact_too_far");
    refused(&["impact", "arch", "--point", point, "--impulse", "0,0,0"], "impulse");
    let (code, document) = fixture.json("shatter", &["impact", "arch", "--point", point, "--impulse", "NaN,0,0"]);
    assert_eq!((code, document["error"]["kind"].as_str()), (2, Some("usage")), "{document}");
    refused(&["impact", "arch", "--point", point, "--impulse", "-1,0,0", "--gamma", "0"], "gamma");
    refused(&["impact", "arch", "--point", point, "--impulse", "-1,0,0", "--gamma", "-1"], "gamma");
    refused(&["impact", "arch", "--point", point, "--impulse", "-1,0,0", "--degree", "0"], "degree");
    refused(&["impact", "arch", "--point", point, "--impulse", "-1,0,0", "--degree", "100000"], "degree");
}

#[test]
fn a_convention_changes_input_and_output_but_no_file() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let files = ["ours.glb", "theirs.glb"].map(|name| fixture.path(name));
    let [ours, theirs] = [0, 1].map(|k| files[k].to_str().unwrap());
    let usual = impact(&fixture, &point, 5.0 * just, &["--degree", "24", "--out", ours]);
    assert_eq!(usual["convention"], "gltf");
    let strike = |name: &str, point: &str, impulse: &str, more: &[&str]| {
        let arguments =
            ["impact", "arch", "--degree", "24", "--convention", name, "--point", point, "--impulse", impulse];
        fixture.ok("shatter", &[&arguments, more].concat())
    };
    // +x of Unity is −x of the default.
    let impulse = format!("{},0,0", 5.0 * just);
    let unity = strike("unity", &format!("-{point}"), &impulse, &["--out", theirs]);
    let fragments = |document: &Value| document["fragments"].as_array().unwrap().clone();
    let center = |fragment: &Value| -> Vec<f64> { serde_json::from_value(fragment["center_m"].clone()).unwrap() };
    assert_eq!((unity["convention"].as_str(), fragments(&unity).len()), (Some("unity"), fragments(&usual).len()));
    for (theirs, ours) in fragments(&unity).iter().zip(&fragments(&usual)) {
        let [theirs, ours] = [theirs, ours].map(center);
        assert_eq!(theirs, [-ours[0], ours[1], ours[2]]);
    }
    assert!(std::fs::read(ours).unwrap() == std::fs::read(theirs).unwrap(), "files are glTF's");
    // Coordinates of Unreal are (x, z, y), cm; a radius keeps its name.
    let meters: Vec<f64> = point.split(',').map(|part| part.parse().unwrap()).collect();
    let centimeters = format!("{},{},{}", 100.0 * meters[0], 100.0 * meters[2], 100.0 * meters[1]);
    let impulse = format!("{},0,0", -500.0 * just);
    let unreal = strike("unreal", &centimeters, &impulse, &["--radius-m", "0.2"]);
    let same = impact(&fixture, &point, 5.0 * just, &["--degree", "24", "--radius-m", "0.2"]);
    assert!((number(&unreal, "e1_over_gamma") / number(&same, "e1_over_gamma") - 1.0).abs() < 1e-9);
    assert!((number(&unreal, "radius_m") / number(&same, "radius_m") - 100.0).abs() < 1e-9);
    let volume = |document| fragments(document).iter().map(|fragment| number(fragment, "volume_m3")).sum::<f64>();
    assert!((volume(&unreal) / volume(&usual) / 1e6 - 1.0).abs() < 1e-6);
    // The impulse that just breaks the object is printed in the host's unit, too.
    let threshold =
        |arguments: &[&str]| fixture.ok("shatter", &[&["threshold", "arch", "--radius-m", "0.2"], arguments].concat());
    let usual = threshold(&["--point", &point, "--direction", "-1,0,-0.5"]);
    let unreal = threshold(&["--convention", "unreal", "--point", &centimeters, "--direction", "-1,-0.5,0"]);
    assert_eq!((usual["convention"].as_str(), unreal["convention"].as_str()), (Some("gltf"), Some("unreal")));
    for key in ["impulse_ns", "radius_m"] {
        assert!((number(&unreal, key) / number(&usual, key) / 100.0 - 1.0).abs() < 1e-9, "{key}: {unreal} {usual}");
    }
}

#[test]
fn every_lift_can_be_asked_for() {
    let fixture = with_arch(&[]);
    let (point, just) = contact(&fixture);
    let strike = |more: &[&str]| impact(&fixture, &point, 5.0 * just, &[&["--degree", "24"], more].concat());
    let documents = ["euclidean", "interior", "surface_diffusion"].map(|lift| strike(&["--lift", lift]));
    let hashes = documents.map(|document| {
        assert!(document["fragments"].as_array().unwrap().iter().all(|fragment| fragment["closed"] == true));
        document["output_hash"].clone()
    });
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[2] != hashes[0]);
    assert_eq!(strike(&[])["output_hash"], hashes[1], "interior is the default");
}

#[test]
fn training_examples_are_printed_plotted_extended_and_used() {
    let mut fixture = Fixture::new();
    let mesh = fixture.path("arch.obj");
    write_obj(&shapes::arch(), &mesh).unwrap();
    let (mesh, file) = (mesh.to_str().unwrap().to_owned(), fixture.databases().join("arch.shatter"));
    let coarse = ["--crack-spacing", "0.06", "--elastic-spacing", "0.1", "--examples", "10"];
    let baked = fixture.ok("shatterd", &[&["bake", mesh.as_str(), "--name", "arch"], &coarse[..]].concat());
    assert!(number(&baked["learned"], "median_relative_error") < number(&baked["learned"], "closed_form_p90"));
    let added = fixture.ok("shatterd", &["bake", &mesh, "--name", "arch", "--add", "2"]);
    assert_eq!((number(&baked, "examples"), number(&added, "examples")), (10.0, 12.0));
    let pages = fixture.path("pages");
    let inspected = fixture.ok("shatterd", &["inspect", file.to_str().unwrap(), "--out", pages.to_str().unwrap()]);
    assert_eq!(inspected["learned"], added["learned"]);
    let page = std::fs::read_to_string(pages.join("arch.html")).unwrap();
    assert!(page.matches("<svg").count() == 2 && page.contains("data:image/png") && page.contains("Predicted against"));
    let other = fixture.path("mug.obj");
    write_obj(&shapes::mug(), &other).unwrap();
    let (code, refused) = fixture.json("shatterd", &["bake", other.to_str().unwrap(), "--name", "arch", "--add", "2"]);
    assert_eq!((code, refused["error"]["kind"].as_str()), (3, Some("other_mesh")), "{refused}");
    fixture.serve(&[]);
    let (point, just) = contact(&fixture);
    let source = |more: &[&str]| impact(&fixture, &point, 5.0 * just, more)["degree_source"].clone();
    let rules = ["closed_form", "verified", "optimised"];
    assert_eq!(rules.map(|rule| source(&["--degree", rule])), rules);
    assert_eq!(source(&[]), source(&["--degree", "inferred"]));
}

#[test]
fn damaged_databases_are_named_and_the_others_served() {
    let mut fixture = with_arch(&[]);
    let good = std::fs::read(fixture.databases().join("arch.shatter")).unwrap();
    std::fs::write(fixture.databases().join("cut.shatter"), &good[..good.len() / 2]).unwrap();
    let mut damaged = good.clone();
    let last = damaged.len() - 9;
    damaged[last] ^= 1;
    std::fs::write(fixture.databases().join("worn.shatter"), &damaged).unwrap();
    assert_eq!(fixture.end(), Some(0));
    fixture.serve(&[]);
    contact(&fixture);
    for name in ["cut.shatter", "worn.shatter"] {
        let (code, document) = fixture.json("shatterd", &["inspect", fixture.databases().join(name).to_str().unwrap()]);
        assert_eq!((code, document["error"]["kind"].as_str()), (3, Some("corrupt_database")), "{name}: {document}");
        assert!(document["error"]["message"].as_str().unwrap().contains("copy it again; else bake the object again"));
    }
    let listed = fixture.ok("shatter", &["list"]);
    println!("{listed}");
    assert!(listed.to_string().contains("checksum"), "the damaged ones are listed with their error: {listed}");
    assert_eq!(listed.to_string().matches("copy it again; else bake the object again").count(), 2, "{listed}");
}

/// A thousand separate small cubes: half of them fall between the nodes of a lattice at default spacing.
fn leftover_files() -> String {
    let mut text = String::new();
    let cube = shapes::cuboid([0.6; 3]);
    for place in (0..1000).map(|k| [k % 10, k / 10 % 10, k / 100].map(f64::from)) {
        text.extend(
            cube.positions_m.iter().map(|p| format!("v {} {} {}\n", p.x + place[0], p.y + place[1], p.z + place[2])),
        );
    }
    for first in (0..1000).map(|k| k * cube.positions_m.len() as u32 + 1) {
        text.extend(cube.triangles.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + first, b + first, c + first)));
    }
    text
}

#[test]
fn one_bad_mesh_is_judged_with_one_document() {
    let fixture = Fixture::new();
    let out = fixture.path("study");
    let judged =
        |id: &str| fixture.ok("shatterd", &["study", "stability", "--shrink", id, "--out", out.to_str().unwrap()]);
    assert_eq!(judged("sphere/two_shells/1")["outcome"], "checked");
    let refused = judged("sphere/nan/3");
    assert_eq!(
        (refused["outcome"].as_str(), refused["justified"].as_bool()),
        (Some("refused"), Some(true)),
        "{refused}"
    );
}

#[test]
fn bad_meshes_are_refused_by_name_and_leave_nothing() {
    let fixture = Fixture::new();
    let refused = |name: &str, text: &str, more: &[&str], kind: &str| {
        let file = fixture.path(name);
        std::fs::write(&file, text).unwrap();
        let (code, document) =
            fixture.json("shatterd", &[&["bake", file.to_str().unwrap(), "--name", "bad"], more].concat());
        assert_eq!((code, document["error"]["kind"].as_str()), (3, Some(kind)), "{name}: {document}");
        let left = std::fs::read_dir(fixture.databases()).map_or(0, Iterator::count);
        assert_eq!(left, 0, "nothing is left in the folder of databases");
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    refused("empty.obj", "", &[], "empty_mesh");
    refused("strange.xyz", triangle, &[], "unknown_format");
    refused("sheet.obj", triangle, &[], "nothing_inside");
    refused("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &[], "non_finite_vertex");
    refused("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", &[], "malformed_file");
    refused("point.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", &[], "zero_extent");
    refused("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", &[], "all_degenerate");
    refused("garbage.ply", "ply\nformat what\n", &[], "malformed_file");
    refused("material.obj", triangle, &["--material", "glas"], "unknown_material");
    refused("gamma.obj", triangle, &["--gamma", "-1"], "not_positive");
    let cube = fixture.path("cube.obj");
    write_obj(&shapes::cuboid([1.0, 1.0, 1.0]), &cube).unwrap();
    let text = std::fs::read_to_string(&cube).unwrap();
    refused("fine.obj", &text, &["--crack-spacing", "1e-9"], "spacing_out_of_range");
    refused("coarse.obj", &text, &["--crack-spacing", "7"], "spacing_out_of_range");
    refused("many.obj", &text, &["--elastic-spacing", "0.01"], "too_many_nodes");
    refused("scraps.obj", &leftover_files(), &[], "too_small");
    refused("order.obj", &text, &["--elastic-spacing", "0.05", "--crack-spacing", "0.06"], "spacing_order");
    let (code, document) = fixture.json("shatterd", &["bake", "cube.obj", "--unit", "furlong"]);
    assert_eq!((code, document["error"]["kind"].as_str()), (2, Some("usage")));
    let (code, document) = fixture.json("shatterd", &["bake", "/no/such/file.obj", "--name", "bad"]);
    assert_eq!((code, document["error"]["kind"].as_str()), (3, Some("unreadable_file")));
}

#[test]
fn baking_twice_gives_the_same_file() {
    let fixture = Fixture::new();
    let mesh = fixture.path("ball.obj");
    let ball: RawMesh = shapes::sphere(0.1, 3);
    write_obj(&ball, &mesh).unwrap();
    let bytes = |out: &str| {
        let out = fixture.path(out);
        let arguments = ["bake", mesh.to_str().unwrap(), "--name", "ball", "--crack-spacing", "0.06"];
        fixture
            .ok("shatterd", &[&arguments[..], &["--elastic-spacing", "0.08", "--out", out.to_str().unwrap()]].concat());
        std::fs::read(out.join("ball.shatter")).unwrap()
    };
    assert!(bytes("a") == bytes("b"));
}

#[test]
fn the_horse_and_the_bunny_come_back_closed() {
    for (file, point, impulse) in
        [("horse.ply", "0,0.075,0.06", "0,-1,0"), ("stanford-bunny.obj", "-0.06,0.12,0.02", "1,-1,0")]
    {
        let Some(mesh) = real::mesh(file) else { continue };
        let mut fixture = Fixture::new();
        let baked = fixture.ok("shatterd", &["bake", mesh.to_str().unwrap(), "--name", "it"]);
        println!("{file}: bake {:.1} s, {baked}", number(&baked, "seconds"));
        assert!(number(&baked, "volume_error").abs() <= 0.015);
        assert!(number(&baked, "surface_deviation") <= number(&baked, "crack_spacing"));
        fixture.serve(&[]);
        let out = fixture.path("it.glb");
        let strike = ["impact", "it", "--point", point, "--impulse", impulse, "--radius-m", "0.03", "--degree", "50"];
        let document = fixture.ok("shatter", &[&strike[..], &["--out", out.to_str().unwrap()]].concat());
        assert_eq!(baked["surface"]["kind"], "exact");
        check_glb(&closed_file(&out), document["fragments"].as_array().unwrap().len(), volume_m3(&fixture));
        println!("{file}: daemon {:.0} MB", fixture.daemon_memory_bytes().unwrap() as f64 / 1e6);
    }
}

#[test]
fn the_guide_lists_the_keys_of_all_documents() {
    let mut fixture = with_arch(&[]);
    std::fs::write(fixture.databases().join("cut.shatter"), "").unwrap();
    assert_eq!(fixture.end(), Some(0));
    fixture.serve(&[]);
    let ray = ["--ray", "2,0.5,0,-1,0,0"];
    let effects = ["--enable", "skin,attributes,release,hulls,bonds,debris", "--keep"];
    let strike =
        |more: &[&str]| fixture.ok("shatter", &[&["impact", "arch", "--impulse-ns", "50"], &ray[..], more].concat());
    let full = strike(&[&["--degree", "8"], &effects[..]].concat());
    let slow = strike(&["--elastic", "solve", "--time-ms", "0.001", "--degree", "8"]);
    json_keys::check("Impact", &[&full, &slow]);
    json_keys::check("Threshold", &[&fixture.ok("shatter", &[&["threshold", "arch"], &ray[..]].concat())]);
    json_keys::check("List", &[&fixture.ok("shatter", &["list"])]);
    json_keys::check("Status", &[&fixture.ok("shatter", &["status"])]);
    let scene = fixture.path("scene.toml");
    std::fs::write(&scene, "[objects.dumbbell]\nshape = \"dumbbell\"\nmaterial = \"stone\"\nquality = \"draft\"\n")
        .unwrap();
    let scene = ["bake", "--scene", scene.to_str().unwrap()];
    json_keys::check("Bake of a scene", &[&fixture.ok("shatterd", &scene)]);
    let shape = ["bake", "--shape", "dumbbell", "--name", "copy", "--material", "stone", "--quality", "draft"];
    json_keys::check("Bake", &[&fixture.ok("shatterd", &shape)]);
    json_keys::check("Study of accuracy", &[&elastic_energies()]);
}

/// The document of a study of accuracy with one body, as far as the guide lists its keys.
fn elastic_energies() -> Value {
    let error = |measure| PointErrors::default().with_bar(measure, [0.02, 0.001]);
    let errors = PointErrors::medians(&[error(Measure::Energy).and(error(Measure::Geometry))]);
    let body = BodyPoint {
        body: "mug".to_owned(),
        preset: "game",
        nodes: 4_596,
        errors,
        by_method: [errors; 2],
        lattice: errors,
        is_quadratic: true,
        order: None,
        solved: 0.5,
        reference_s: 9.0,
    };
    let document = AccuracyFindings { bodies: vec![body], ..AccuracyFindings::default() }.document();
    json!({ "bodies": document["bodies"], "all_bodies": document["all_bodies"] })
}
