//! Files for other tools, written by the real programs and read by code that shares nothing with the writer: an XML reader and MuJoCo, an
//! OBJ reader and trimesh; and fragments made ahead of time.

use nalgebra::{Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;
use shatter_fracture::fragment::{RigidProperties, closed};
use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis};
use shatter_tests::fixture::Fixture;
use shatter_tests::glb::closed_file;
use shatter_tests::model::{Element, elements};
use shatter_tests::{glb, peers};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const STEPS: &str = "1000";

/// Relative error of numbers in single precision.
const SINGLE: f64 = 1e-5;

/// Relative error of the volumes of fragments in a file: vertices are rounded about the center of their fragment.
const VOLUME: f64 = 1e-6;

/// A test folder with `mesh` on a lattice of this spacing, and the daemon running.
fn with(mesh: &RawMesh, spacing: &str) -> Fixture {
    with_surface(mesh, spacing, "exact")
}

fn with_surface(mesh: &RawMesh, spacing: &str, surface: &str) -> Fixture {
    let mut fixture = Fixture::new();
    let file = fixture.path("thing.obj");
    write_obj(mesh, &file).unwrap();
    let spacings = ["--crack-spacing", spacing, "--elastic-spacing", "0.08", "--surface", surface];
    fixture.bake_once(&file, "thing", &[&["--material", "ceramic"][..], &spacings].concat());
    fixture.serve(&[]);
    fixture
}

fn prefracture(fixture: &Fixture, pieces: u32, out: &Path, more: &[&str]) -> Value {
    let pieces = pieces.to_string();
    let arguments = ["prefracture", "thing", "--degree", &pieces, "--out", out.to_str().unwrap()];
    fixture.ok("shatter", &[&arguments[..], more].concat())
}

fn rows(document: &Value) -> &[Value] {
    document["fragments"].as_array().unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} in {value}"))
}

fn volumes(document: &Value) -> Vec<f64> {
    rows(document).iter().map(|row| number(row, "volume_m3")).collect()
}

/// Standard deviation over mean.
fn unevenness(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt() / mean
}

/// Number of triangles per material in an OBJ file, by its own lines.
fn triangles(text: &str) -> BTreeMap<String, usize> {
    let (mut counts, mut material) = (BTreeMap::new(), String::new());
    for line in text.lines() {
        match line.split_once(' ') {
            Some(("usemtl", name)) => name.clone_into(&mut material),
            Some(("f", _)) => *counts.entry(material.clone()).or_insert(0) += 1,
            _ => {}
        }
    }
    counts
}

/// True if an OBJ file is closed by the numbers of its points alone: every half-edge once, with its opposite.
fn is_closed_as_it_stands(text: &str) -> bool {
    let point = |corner: &str| corner.split('/').next().unwrap().parse::<u32>().unwrap();
    let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
    let half_edges = faces.flat_map(|face| {
        let [a, b, c] = face.split(' ').map(point).collect::<Vec<_>>().try_into().unwrap();
        [(a, b), (b, c), (c, a)]
    });
    let all: Vec<(u32, u32)> = half_edges.collect();
    let once: BTreeSet<(u32, u32)> = all.iter().copied().collect();
    once.len() == all.len() && once.iter().all(|&(a, b)| once.contains(&(b, a)))
}

/// Checks that the table of each fragment agrees with its surface.
#[track_caller]
fn check_properties(row: &Value, own: &RigidProperties, density_kg_m3: f64, inertia: &[f64; 6]) {
    let of_surface = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|entry| own.inertia[entry] * density_kg_m3);
    let scale = of_surface[..3].iter().copied().fold(0.0, f64::max);
    assert!((own.volume / number(row, "volume_m3") - 1.0).abs() < SINGLE);
    let off = of_surface.iter().zip(inertia).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < SINGLE * scale, "{inertia:?} is stated, {of_surface:?} found");
}

#[test]
fn a_glb_has_inertias_and_is_watertight_for_other_tools() {
    let fixture = with(&shapes::arch(), "0.035");
    let file = fixture.path("pieces.glb");
    let document = prefracture(&fixture, 16, &file, &[]);
    let file = closed_file(&file);
    let read = glb::read(&file).unwrap();
    assert_eq!(read.len(), rows(&document).len());
    for (fragment, row) in read.iter().zip(rows(&document)) {
        fragment.check_closed().unwrap();
        let positions: Vec<Point3<f64>> =
            fragment.positions.iter().map(|own| Point3::from(own.map(f64::from))).collect();
        let own = RigidProperties::of_surface(&positions, fragment.triangles());
        check_properties(row, &own, fragment.mass_kg / fragment.stated_volume_m3, &fragment.inertia_kg_m2);
        assert!(own.center.coords.norm() < SINGLE, "its center is the origin of its node");
    }
    let Some(seen) = peers::watertight(&[&file]) else { return };
    check_seen(&seen, &document);
    check_declared(&seen);
    let out = fixture.path("pieces.glb");
    let impact_arguments =
        ["--point", "0,0.9,0.1", "--impulse", "0,-200,-300", "--degree", "24", "--out", out.to_str().unwrap()];
    let document = fixture.ok("shatter", &[&["impact", "thing"], &impact_arguments[..]].concat());
    let seen = peers::watertight(&[&file]).unwrap();
    check_seen(&seen, &document);
    check_declared(&seen);
}

/// Checks that the surface that `EXT_mesh_manifold` declares is closed, for each fragment, and has the volume of its node.
#[track_caller]
fn check_declared(seen: &[Value]) {
    for one in seen {
        let declared = &one["declared"];
        assert_eq!(declared["watertight"], true, "{one}");
        let off = number(declared, "volume_m3") / number(&declared["extras"], "volume_m3") - 1.0;
        assert!(off.abs() < VOLUME, "off by {off:e}: {one}");
    }
}

/// Checks with trimesh that everything is closed, with the stated volumes.
#[track_caller]
fn check_seen(seen: &[Value], document: &Value) {
    assert_eq!(seen.len(), rows(document).len());
    let closed = |one: &Value| one["watertight"] == true && one["merged_watertight"] == true;
    assert!(seen.iter().all(closed), "{seen:?}");
    let sum: f64 = seen.iter().map(|one| number(one, "volume_m3")).sum();
    assert!((sum / volumes(document).iter().sum::<f64>() - 1.0).abs() < SINGLE);
    let materials = |one: &Value| one["materials"].as_array().unwrap().iter().any(|name| name == "crack");
    assert!(seen.iter().all(materials), "{seen:?}");
}

/// Checks that every file of `folders`, which were empty before, is in the document.
#[track_caller]
fn check_files_named(document: &Value, folders: &[&Path]) {
    let mut named: Vec<PathBuf> =
        document["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap().into()).collect();
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let mut there: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()).collect();
    named.sort();
    there.sort();
    assert_eq!(named, there);
}

#[test]
fn obj_folders_hold_closed_pieces_in_place_and_their_masses() {
    let fixture = with(&shapes::arch(), "0.035");
    let folder = fixture.path("pieces of Žofie");
    let more = ["--format", "obj", "--enable", "hulls,bonds"];
    let document = prefracture(&fixture, 16, &folder, &more);
    assert_eq!(document["file"].as_str(), folder.to_str());
    check_files_named(&document, &[&folder]);
    let table: Value = serde_json::from_slice(&std::fs::read(folder.join("fragments.json")).unwrap()).unwrap();
    assert_eq!(table["bonds"].as_array().unwrap().len(), document["bonds"].as_array().unwrap().len());
    let listed = table["fragments"].as_array().unwrap();
    assert_eq!(listed.len(), rows(&document).len());
    let (mut lowest, mut files) = (f64::INFINITY, Vec::new());
    for (row, output) in listed.iter().zip(rows(&document)) {
        let file = folder.join(row["file"].as_str().unwrap());
        let read = surface::read(&file, LengthUnit::M, UpAxis::Y).unwrap();
        let named: Vec<&str> = read.attributes.names.iter().map(String::as_str).collect();
        assert!(!named.is_empty() && named.iter().all(|name| ["outer", "crack"].contains(name)), "{named:?}");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(is_closed_as_it_stands(&text), "{}", file.display());
        let counts = triangles(&text);
        assert_eq!(counts.values().sum::<usize>() as u64, output["triangles"].as_u64().unwrap());
        let singles: Vec<[f32; 3]> = read.positions_m.iter().map(|p| p.coords.map(|x| x as f32).into()).collect();
        closed(&singles, read.triangles.as_flattened()).unwrap();
        let own = RigidProperties::of_surface(&read.positions_m, read.triangles.iter().copied());
        let center: [f64; 3] = serde_json::from_value(row["center_m"].clone()).unwrap();
        assert!((own.center - Point3::from(center)).norm() < SINGLE, "pieces lie where they broke");
        let inertia: [f64; 6] = serde_json::from_value(row["inertia_kg_m2"].clone()).unwrap();
        check_properties(output, &own, number(output, "mass_kg") / number(output, "volume_m3"), &inertia);
        let hull = surface::read(&folder.join(row["hull"].as_str().unwrap()), LengthUnit::M, UpAxis::Y).unwrap();
        assert_eq!(hull.triangles.len() as u64, output["hull"]["triangles"].as_u64().unwrap());
        lowest = read.positions_m.iter().map(|p| p.y).fold(lowest, f64::min);
        files.push(file);
    }
    let wanted = shapes::arch().positions_m.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!((lowest - wanted).abs() < 0.01, "{lowest} {wanted}");
    let files: Vec<&Path> = files.iter().map(AsRef::as_ref).collect();
    let Some(seen) = peers::watertight(&files) else { return };
    check_seen(&seen, &document);
}

#[test]
fn blender_makes_rigid_bodies_of_a_glb() {
    let fixture = with(&shapes::arch(), "0.035");
    let file = fixture.path("pieces.glb");
    let document = prefracture(&fixture, 16, &file, &[]);
    let Some(seen) = peers::blender(&closed_file(&file), "72") else { return };
    let pieces = seen["pieces"].as_array().unwrap();
    assert_eq!(pieces.len(), rows(&document).len());
    for (piece, row) in pieces.iter().zip(rows(&document)) {
        assert!(piece["closed"] == true && piece["materials"].as_array().unwrap().iter().any(|name| name == "crack"));
        let off = number(piece, "volume_m3") / number(row, "volume_m3") - 1.0;
        assert!(off.abs() < VOLUME, "off by {off:e}: {piece}");
        assert_eq!(number(&piece["extras"], "mass_kg"), number(row, "mass_kg"));
    }
    assert!(seen["finite"] == true && number(&seen, "lowest_m") > number(&seen, "floor_m"), "{seen}");
}

/// Names of files in a folder.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn only_files_of_an_earlier_export_are_removed() {
    let fixture = with(&shapes::cuboid([0.3, 0.1, 0.1]), "0.04");
    let (folder, model) = (fixture.path("pieces"), fixture.path("thing.xml"));
    let meshes = fixture.path("thing_assets");
    let more = ["--format", "obj", "--enable", "hulls"];
    let write = |pieces: u32| {
        prefracture(&fixture, pieces, &folder, &more);
        prefracture(&fixture, pieces, &model, &[]);
        [names(&folder), names(&meshes)]
    };
    let first = write(4);
    let larger = write(12);
    assert!(first.iter().zip(&larger).all(|(few, many)| few.len() + 8 <= many.len() && few.is_subset(many)));
    // Files of the user, even under names like those of an export, are named by no table.
    let foreign = ["fragment_900.obj", "notes.txt"];
    for own in [&folder, &meshes] {
        foreign.iter().for_each(|name| std::fs::write(own.join(name), "mine").unwrap());
    }
    let again = write(4);
    for (own, wanted) in again.iter().zip(first) {
        let wanted: BTreeSet<String> = wanted.into_iter().chain(foreign.map(str::to_owned)).collect();
        assert_eq!(*own, wanted);
    }
    // A table of another program removes nothing, whatever it names.
    let kept = fixture.path("fragment_000.obj");
    std::fs::write(&kept, "mine").unwrap();
    let table = r#"{"fragments":[{"file":"../fragment_000.obj","hull":"notes.txt"},{"file":7}]}"#;
    std::fs::write(folder.join("fragments.json"), table).unwrap();
    std::fs::write(&model, "<mujoco><compiler meshdir=\"other\"/><mesh file=\"fragment_900.obj\"/></mujoco>").unwrap();
    assert_eq!(write(4), again);
    assert!(kept.is_file());
}

#[test]
fn a_glb_never_lies_beside_files_of_another_result() {
    let fixture = with_surface(&shapes::cuboid([0.3, 0.1, 0.1]), "0.04", "lattice");
    let (file, more) = (fixture.path("pieces.glb"), ["--enable", "hulls"]);
    prefracture(&fixture, 4, &file, &more);
    let [closed, hulls] = ["closed.glb", "hulls.glb"].map(|ending| file.with_extension(ending));
    let earlier = std::fs::read(&closed).unwrap();
    std::fs::remove_file(&hulls).unwrap();
    std::fs::create_dir(&hulls).unwrap();
    let out = file.to_str().unwrap();
    let arguments = ["prefracture", "thing", "--degree", "12", "--out", out];
    let (code, document) = fixture.json("shatter", &[&arguments[..], &more].concat());
    assert!(code != 0 && document["error"]["kind"] == "output", "{document}");
    assert!(std::fs::read(&closed).unwrap() != earlier && !file.exists());
}

fn of<'a>(all: &'a [Element], name: &str) -> Vec<&'a Element> {
    all.iter().filter(|element| element.name == name).collect()
}

/// Compares the document with the result.
#[track_caller]
fn check_model(all: &[Element], document: &Value, meshes: &Path) {
    for kind in ["body", "freejoint", "geom", "mesh", "material", "weld"] {
        let elements = of(all, kind);
        let named: Vec<&str> = elements.iter().filter_map(|element| element.get("name")).collect();
        assert_eq!(named.iter().collect::<BTreeSet<_>>().len(), named.len(), "names of {kind} are unique");
    }
    let inertials = of(all, "inertial");
    assert_eq!((inertials.len(), of(all, "body").len()), (rows(document).len(), rows(document).len()));
    for ((inertial, body), row) in inertials.iter().zip(of(all, "body")).zip(rows(document)) {
        assert_eq!(inertial.number("mass"), number(row, "mass_kg"), "mass as in the result");
        let [a, b, c] = inertial.numbers("diaginertia");
        assert!(a >= b && b >= c && c > 0.0 && a <= b + c, "{inertial:?}");
        let [w, x, y, z] = inertial.numbers("quat");
        assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-14);
        let [x, y, z]: [f64; 3] = serde_json::from_value(row["center_m"].clone()).unwrap();
        assert_eq!(body.numbers("pos"), [x, -z, y], "+Z is up");
    }
    for mesh in of(all, "mesh") {
        assert!(meshes.join(mesh.get("file").unwrap()).is_file(), "{mesh:?}");
    }
    let bonds = document["bonds"].as_array().unwrap();
    assert_eq!((of(all, "weld").len(), of(all, "exclude").len()), (bonds.len(), bonds.len()));
}

/// Checks that tensors of the model, reassembled, are those of the surfaces, rotated.
#[track_caller]
fn check_tensors(all: &[Element], pieces: &[glb::Fragment]) {
    for (inertial, piece) in of(all, "inertial").iter().zip(pieces) {
        let [w, x, y, z] = inertial.numbers("quat");
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        let moments = Matrix3::from_diagonal(&Vector3::from(inertial.numbers("diaginertia")));
        let output = turn.matrix() * moments * turn.matrix().transpose();
        let points: Vec<Point3<f64>> =
            piece.positions.iter().map(|own| own.map(f64::from)).map(|[x, y, z]| Point3::new(x, -z, y)).collect();
        let own = RigidProperties::of_surface(&points, piece.triangles());
        let found = own.inertia * (piece.mass_kg / piece.stated_volume_m3);
        assert!((output - found).norm() < SINGLE * found.norm(), "{output} is stated, {found} found");
    }
}

/// MuJoCo loads the model without a warning. Welded it stands; with welds off it falls apart.
#[track_caller]
fn check_steps(file: &Path, document: &Value) {
    let Some(whole) = peers::mujoco(file, &[STEPS]) else { return };
    let count = rows(document).len() as u64;
    let masses: Vec<f64> = serde_json::from_value(whole["masses_kg"].clone()).unwrap();
    assert!(masses.iter().zip(rows(document)).all(|(own, row)| *own == number(row, "mass_kg")));
    assert_eq!(whole["bodies"].as_u64(), Some(count));
    let size_m = number(&whole, "size_m");
    assert!(number(&whole, "apart_max_m") < 1e-3 * size_m, "welded pieces stay together: {whole}");
    let loose = peers::mujoco(file, &[STEPS, "release"]).unwrap();
    let welds = whole["welds"].as_u64().unwrap();
    assert!(welds == 0 || number(&loose, "apart_max_m") > 0.1 * size_m, "released pieces part: {loose}");
    for run in [&whole, &loose] {
        assert_eq!(run["finite"], true);
        assert!(run["warnings"].as_array().unwrap().iter().all(|count| count == 0), "{run}");
        assert!(number(run, "lowest_m") > number(run, "floor_m"), "the floor holds: {run}");
    }
}

#[test]
fn mujoco_models_match_the_result_and_step() {
    let fixture = with(&shapes::arch(), "0.035");
    let glb_file = fixture.path("pieces.glb");
    prefracture(&fixture, 16, &glb_file, &[]);
    let pieces = glb::read(&closed_file(&glb_file)).unwrap();
    let folder = fixture.path("models");
    let document = prefracture(&fixture, 16, &folder, &["--format", "mjcf"]);
    let file = folder.join("thing.xml");
    assert_eq!(document["file"].as_str(), file.to_str());
    check_files_named(&document, &[&folder, &folder.join("thing_assets")]);
    let text = std::fs::read_to_string(&file).unwrap();
    let all = elements(&text).unwrap();
    assert!(all.iter().any(|element| element.get("mesh").is_some_and(|mesh| mesh.ends_with("_hull"))));
    check_model(&all, &document, &folder.join("thing_assets"));
    check_tensors(&all, &pieces);
    check_steps(&file, &document);
    prefracture(&fixture, 16, &fixture.path("again.xml"), &[]);
    let again = std::fs::read_to_string(fixture.path("again.xml")).unwrap();
    assert_eq!(again.replace("again_assets", "thing_assets"), text, "equal pieces give equal bytes");
    let bare = fixture.path("bare.xml");
    let document = prefracture(&fixture, 16, &bare, &["--disable", "hulls,bonds"]);
    let all = elements(&std::fs::read_to_string(&bare).unwrap()).unwrap();
    assert!(all.iter().all(|element| element.name != "weld" && element.name != "exclude"));
    check_model(&all, &document, &fixture.path("bare_assets"));
    check_steps(&bare, &document);
}

#[test]
fn even_pieces_are_alike_wherever_they_lie() {
    let fixture = with(&shapes::cuboid([0.4, 0.1, 0.1]), "0.03");
    let file = fixture.path("pieces.glb");
    let document = prefracture(&fixture, 24, &file, &[]);
    assert_eq!((rows(&document).len(), document["sites"].as_u64()), (24, Some(24)));
    let struck = ["impact", "thing", "--point", "0.2,0,0", "--impulse", "-50,0,0", "--degree", "24"];
    let struck = fixture.ok("shatter", &struck);
    let (even, impact_arguments) = (unevenness(&volumes(&document)), unevenness(&volumes(&struck)));
    println!(
        "volumes of pieces vary by {:.0} % evenly, {:.0} % under an impact",
        100.0 * even,
        100.0 * impact_arguments
    );
    assert!(even < 0.35 && even < 0.5 * impact_arguments, "{even} {impact_arguments}");
    // Each half and each quarter has its share.
    let along = |row: &Value| row["center_m"][0].as_f64().unwrap();
    for quarter in 0..4 {
        let begin = -0.2 + 0.1 * f64::from(quarter);
        let inside = rows(&document).iter().filter(|row| (begin..begin + 0.1).contains(&along(row)));
        let share = inside.map(|row| number(row, "volume_m3")).sum::<f64>() / 0.004;
        assert!((0.15..0.35).contains(&share), "{quarter}: {share}");
    }
    let mean = |inner: bool| {
        let chosen = rows(&document).iter().filter(|row| (along(row).abs() < 0.1) == inner);
        let volumes: Vec<f64> = chosen.map(|row| number(row, "volume_m3")).collect();
        volumes.iter().sum::<f64>() / volumes.len() as f64
    };
    let ratio = mean(true) / mean(false);
    println!("pieces in the middle over those at the ends: {ratio:.2}");
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
}

#[test]
fn the_seed_decides_and_bodies_share_by_volume() {
    let (mut two, mut second) = (shapes::cuboid([0.1, 0.1, 0.2]), shapes::cuboid([0.1, 0.1, 0.1]));
    second.positions_m.iter_mut().for_each(|point| point.x += 0.15);
    let first = two.positions_m.len() as u32;
    two.positions_m.append(&mut second.positions_m);
    two.triangles.extend(second.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    let fixture = with(&two, "0.04");
    let file = fixture.path("two.glb");
    let document = prefracture(&fixture, 30, &file, &["--seed", "7"]);
    let of_body = |body: u64| rows(&document).iter().filter(|row| row["body"] == body).count();
    assert_eq!(of_body(0) + of_body(1), rows(&document).len());
    let share = of_body(0) as f64 / rows(&document).len() as f64;
    assert!((share - 2.0 / 3.0).abs() < 0.1, "the larger body gets two thirds: {share}");
    let again = prefracture(&fixture, 30, &file, &["--seed", "7"]);
    let other = prefracture(&fixture, 30, &file, &["--seed", "8"]);
    assert_eq!(document["output_hash"], again["output_hash"]);
    assert_ne!(document["output_hash"], other["output_hash"]);
}

#[test]
fn prefracture_errors_match_those_of_impacts() {
    let fixture = with(&shapes::cuboid([0.2, 0.1, 0.1]), "0.06");
    let check = |what: &[&str]| {
        let impact_arguments = ["--point", "0.1,0,0", "--impulse", "-50,0,0"];
        let out = fixture.path("x.glb");
        let out = if what.contains(&"--out") { vec![] } else { vec!["--out", out.to_str().unwrap()] };
        let (code, refused) = fixture.json("shatter", &[&["prefracture"], what, &out[..]].concat());
        let (wanted_code, wanted) =
            fixture.json("shatter", &[&["impact"], what, &out[..], &impact_arguments[..]].concat());
        assert!(code != 0, "{what:?}");
        let kind = |document: &Value| document["error"]["kind"].clone();
        assert_eq!((code, kind(&refused)), (wanted_code, kind(&wanted)), "{what:?}: {refused} {wanted}");
    };
    check(&["nothing", "--degree", "8"]);
    check(&["thing", "--degree", "0"]);
    check(&["thing", "--degree", "1000000"]);
    check(&["thing", "--degree", "-3"]);
    check(&["thing", "--degree", "8", "--enable", "bonds", "--disable", "bonds"]);
    check(&["thing", "--degree", "8", "--out", "/proc/nowhere/x.xml"]);
    check(&["thing", "--degree", "8", "--out", "/proc/nowhere", "--format", "obj"]);
    check(&["thing", "--degree", "8", "--out", "x.obj"]);
    check(&["thing", "--degree", "8", "--out", "x.glb", "--format", "mjcf"]);
}
