//! Default output of a request: the input's own surface, no specks, no hairlines; and a message about parts that cannot be written.

use nalgebra::{Point3, Vector3};
use serde_json::Value;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, Tables, bake};
use shatter_fracture::pipeline::{
    DegreeRequest, FractureOutcome, FractureRequest, FragmentRow, PreparedObject, SurfaceKind,
};
use shatter_fracture::scene::EffectKind;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::fixture::Fixture;
use shatter_tests::{glb, real};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

const SIDES: [f64; 3] = [0.3, 0.2, 0.2];

/// Spacing of the crack lattice, over the diagonal.
const SPACING: f64 = 0.045;

/// A served block with these tables.
fn block(tables: Tables) -> Fixture {
    served(shapes::cuboid(SIDES), tables, SurfaceKind::Lattice).0
}

/// `mesh`, served as `block`, and the prepared object.
fn served(mesh: RawMesh, tables: Tables, surface: SurfaceKind) -> (Fixture, PreparedObject) {
    let mut fixture = Fixture::new();
    let request = database::BakeRequest {
        crack_spacing: Some(SPACING),
        elastic_spacing: Some(2.0 * SPACING),
        tables,
        surface,
        ..real::request("block", "stone")
    };
    let prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| {}).unwrap();
    std::fs::create_dir_all(fixture.databases()).unwrap();
    database::save(&prepared, &fixture.databases().join("block.shatter")).unwrap();
    fixture.serve(&[]);
    (fixture, prepared)
}

/// Strikes the block; returns exit code, document, stderr.
fn strike(fixture: &Fixture, more: &[&str]) -> (i32, Value, String) {
    let impact_arguments = ["impact", "block", "--point", "0.15,0.02,0.01", "--impulse", "-40,2,1", "--json"];
    let degree: &[&str] = if more.contains(&"--degree") { &[] } else { &["--degree", "60"] };
    let output = fixture.run("shatter", &[&impact_arguments[..], degree, more].concat());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let document = serde_json::from_str(&text(&output.stdout)).unwrap();
    (output.status.code().unwrap(), document, text(&output.stderr))
}

fn written(fixture: &Fixture, name: &str, more: &[&str]) -> (PathBuf, Value, String) {
    let path = fixture.path(name);
    let (code, document, stderr) = strike(fixture, &[&["--out", path.to_str().unwrap()], more].concat());
    assert_eq!(code, 0, "{document} {stderr}");
    (path, document, stderr)
}

/// Area of triangles of one fragment, m².
fn area_m2(fragment: &glb::Fragment, triangles: &[[u32; 3]]) -> f64 {
    let corner = |vertex: u32| Point3::from(fragment.positions[vertex as usize].map(f64::from));
    let area = |t: &[u32; 3]| 0.5 * (corner(t[1]) - corner(t[0])).cross(&(corner(t[2]) - corner(t[0]))).norm();
    triangles.iter().map(area).sum()
}

/// Vertices on the rim of the crack faces of a fragment: those of edges that only one of the triangles has.
fn rim(fragment: &glb::Fragment, triangles: &[[u32; 3]]) -> Vec<Point3<f64>> {
    let key = |vertex: u32| fragment.positions[vertex as usize].map(f32::to_bits);
    let mut edges: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
    for t in triangles {
        (0..3).for_each(|k| *edges.entry([key(t[k]), key(t[(k + 1) % 3])]).or_default() += 1);
    }
    let is_open = |[from, to]: &&[[u32; 3]; 2]| from != to && !edges.contains_key(&[*to, *from]);
    let place = |bits: [u32; 3]| Point3::from(bits.map(|x| f64::from(f32::from_bits(x))));
    edges.keys().filter(is_open).map(|[from, _]| place(*from)).collect()
}

/// Distances of the rim of crack faces from the nearest rim vertex of the skin, in spacings, for all fragments.
fn gaps(read: &[glb::Fragment]) -> Vec<f64> {
    let spacing_m = SPACING * Vector3::from(SIDES).norm();
    let own = |fragment: &glb::Fragment| -> Vec<f64> {
        let skin = rim(fragment, &fragment.outer);
        let gap = |at: Point3<f64>| skin.iter().map(|own| (own - at).norm()).fold(f64::INFINITY, f64::min) / spacing_m;
        rim(fragment, &fragment.crack).into_iter().map(gap).collect()
    };
    let mut gaps: Vec<f64> = read.iter().filter(|fragment| !fragment.outer.is_empty()).flat_map(own).collect();
    gaps.sort_by(f64::total_cmp);
    gaps
}

#[test]
fn a_glb_shows_the_input_and_the_closed_meshes_lie_beside_it() {
    let fixture = block(Tables { elastic: true, interior: true, skin: true, ..Tables::NONE });
    let (path, document, stderr) = written(&fixture, "x.glb", &[]);
    let closed = path.with_extension("closed.glb");
    for file in [&path, &closed] {
        let bytes = std::fs::metadata(file).unwrap().len();
        assert!(stderr.contains(&format!("wrote {} (", file.display())) && bytes > 1000, "{stderr}");
    }
    let [seen, solid] = [&path, &closed].map(|file| glb::read(file).unwrap());
    let count = document["fragments"].as_array().unwrap().len();
    assert_eq!((seen.len(), solid.len()), (count, count));
    solid.iter().for_each(|fragment| fragment.check_closed().unwrap());
    let inside = seen.iter().filter(|fragment| fragment.outer.is_empty()).count();
    let outer_m2: f64 = seen.iter().map(|fragment| area_m2(fragment, &fragment.outer)).sum();
    let [a, b, c] = SIDES;
    let exact_m2 = 2.0 * (a * b + b * c + c * a);
    assert!((outer_m2 / exact_m2 - 1.0).abs() < 1e-5, "{outer_m2} of {exact_m2} m²");
    let gaps = gaps(&seen);
    let on = gaps.iter().filter(|gap| **gap == 0.0).count() as f64 / gaps.len() as f64;
    let sealed = seen.iter().filter(|fragment| fragment.manifold.is_some()).count();
    println!(
        "{count} fragments, {inside} from the inside, {sealed} closed; {:.1} % of {} rim vertices on the skin's rim, farthest {:.3} spacings off",
        100.0 * on,
        gaps.len(),
        gaps[gaps.len() - 1]
    );
    assert!(on > 0.97 && 2 * sealed > count);
    // Without the skin one file has the closed meshes.
    let (plain, _, _) = written(&fixture, "plain.glb", &["--disable", "skin"]);
    assert!(!plain.with_extension("closed.glb").exists());
    glb::read(&plain).unwrap().iter().for_each(|fragment| fragment.check_closed().unwrap());
    assert!(std::fs::read(&plain).unwrap() == std::fs::read(&closed).unwrap(), "the same meshes");
}

/// The block with texture coordinates of its own for each triangle: every edge is a seam.
fn seamed() -> RawMesh {
    let mut mesh = shapes::cuboid(SIDES);
    let own = |triangle: usize| [0, 1, 2].map(|corner| [triangle as f32, corner as f32]);
    mesh.attributes.uvs = (0..mesh.triangles.len()).map(own).collect();
    mesh
}

/// Sections that hold vertices, or offsets into them.
const OF_VERTICES: [&str; 7] = ["fragments", "runs", "positions", "indices", "merges", "normals", "uvs"];

/// Invariant 19: on the input's surface, two effects copy the vertices on its seams. All else stays.
#[test]
fn attributes_and_skin_copy_vertices_on_seams_and_change_nothing_else() {
    let tables = Tables { elastic: true, interior: true, attributes: true, skin: true, ..Tables::NONE };
    let (fixture, prepared) = served(seamed(), tables, SurfaceKind::Exact);
    let usual = "release,normals,uv,bonds,debris,hulls";
    let sections = |more: &str| -> BTreeMap<String, String> {
        let (code, document, stderr) = strike(&fixture, &["--enable", &format!("{usual}{more}")]);
        assert_eq!((code, document["surface"].as_str()), (0, Some("exact")), "{stderr}");
        let of = |key: &str, own: &Value| own[key].as_str().unwrap().to_owned();
        let sections = document["sections"].as_array().unwrap().iter().map(|own| (of("name", own), of("hash", own)));
        // These two report what ran, and how many bytes it made.
        sections.filter(|(name, _)| !["effects", "stages"].contains(&name.as_str())).collect()
    };
    let plain = sections("");
    for more in [",attributes", ",skin", ",attributes,skin"] {
        let found = sections(more);
        let changed: BTreeSet<&str> = plain
            .iter()
            .filter(|(name, hash)| found.get(*name) != Some(*hash))
            .map(|(name, _)| name.as_str())
            .collect();
        assert_eq!(changed, BTreeSet::from(OF_VERTICES), "{more}");
    }
    let point_m = Point3::new(0.15, 0.02, 0.01);
    let request = FractureRequest { degree: DegreeRequest::Sites(60), ..FractureRequest::at(point_m, -Vector3::x()) };
    let pieces = |effects: &[EffectKind]| {
        let effects = effects.iter().fold(request.effects, |effects, effect| effects.with(*effect));
        let outcome = prepared.strike(&FractureRequest { effects, ..request.clone() }).unwrap();
        let FractureOutcome::Fractured(fracture) = outcome else { panic!("intact") };
        let emitted = fracture.meshes.emitted().unwrap();
        let points = emitted.fragments().flat_map(|own| own.indices.iter().map(|at| own.positions[*at as usize]));
        let points: Vec<[f32; 3]> = points.collect();
        let bare = |row: &FragmentRow| FragmentRow {
            vertex_first: 0,
            vertex_count: 0,
            merge_first: 0,
            merge_count: 0,
            ..*row
        };
        (points, fracture.meshes.fragments.iter().map(bare).collect::<Vec<_>>(), emitted.positions.len())
    };
    let [(points, rows, count), (copied_points, copied_rows, copied_count)] =
        [pieces(&[]), pieces(&[EffectKind::Attributes])];
    assert!(points == copied_points && rows == copied_rows, "the same triangles");
    assert!(copied_count > count && copied_count < count + count / 4, "{copied_count} of {count} vertices");
}

#[test]
fn no_piece_is_a_speck_unless_it_is_asked_for() {
    let fixture = block(Tables { elastic: true, interior: true, ..Tables::NONE });
    let volumes = |more: &[&str]| -> Vec<f64> {
        let (code, document, _) = strike(&fixture, more);
        assert_eq!(code, 0, "{document}");
        document["fragments"].as_array().unwrap().iter().map(|row| row["volume_m3"].as_f64().unwrap()).collect()
    };
    let least = |volumes: &[f64]| volumes.iter().copied().fold(f64::INFINITY, f64::min);
    let [usual, all] = [volumes(&["--degree", "250"]), volumes(&["--degree", "250", "--disable", "slivers"])];
    let limit = 2.0 * (SPACING * Vector3::from(SIDES).norm()).powi(3);
    println!(
        "least {:.2e} and {:.2e} m³, limit {limit:.2e}; {} and {} pieces",
        least(&usual),
        least(&all),
        usual.len(),
        all.len()
    );
    assert!(least(&all) < 0.9 * limit, "there are slivers");
    assert!(least(&usual) > 0.9 * limit && usual.len() < all.len());
    assert!((usual.iter().sum::<f64>() / all.iter().sum::<f64>() - 1.0).abs() < 1e-6);
}

/// Checks an error: kind, position, and words of the message.
#[track_caller]
fn check_rejected(fixture: &Fixture, more: &[&str], kind: &str, at: &str, words: &[&str]) {
    let (code, document, _) = strike(fixture, more);
    let error = &document["error"];
    assert_eq!((code, error["kind"].as_str(), error["at"].as_str()), (3, Some(kind), Some(at)), "{more:?}: {document}");
    let message = error["message"].as_str().unwrap();
    words.iter().for_each(|word| assert!(message.contains(word), "{word} in {message}"));
}

#[test]
fn a_table_that_the_bake_left_out_is_named_with_the_key_that_brings_it() {
    let fixture = block(Tables { elastic: true, interior: true, ..Tables::NONE });
    let scene = ["[objects.block]", "shatterd bake"];
    check_rejected(
        &fixture,
        &["--enable", "skin"],
        "effect",
        "skin",
        &["\"skin\"", "`effects` or `allow`", scene[0], scene[1]],
    );
    check_rejected(
        &fixture,
        &["--enable", "attributes"],
        "effect",
        "attributes",
        &["\"attributes\"", scene[0], scene[1]],
    );
    let lift = ["--lift", "surface_diffusion"];
    check_rejected(&fixture, &lift, "lift", "surface_diffusion", &["lift = \"surface_diffusion\"", scene[0], scene[1]]);
    check_rejected(&fixture, &["--enable", "anchored"], "effect", "anchored", &["key `anchors`", scene[0]]);
    // Without a request for the skin it is left out, with a note.
    let (path, _, stderr) = written(&fixture, "x.glb", &[]);
    assert!(stderr.contains("\"skin\"") && stderr.contains("x.glb") && stderr.contains("wrote "), "{stderr}");
    glb::read(&path).unwrap().iter().for_each(|fragment| fragment.check_closed().unwrap());
    assert!(!path.with_extension("closed.glb").exists());
    let fixture = block(Tables { skin: true, ..Tables::NONE });
    check_rejected(&fixture, &[], "effect", "elastic", &["\"elastic\"", "--disable elastic", scene[0]]);
    check_rejected(&fixture, &["--disable", "elastic"], "lift", "interior", &["lift = \"interior\"", scene[0]]);
}

#[test]
fn an_effect_that_the_scene_leaves_out_is_named_with_its_key() {
    let mut fixture = block(Tables { elastic: true, interior: true, skin: true, ..Tables::NONE });
    assert_eq!(fixture.end(), Some(0));
    let scene = fixture.path("scene.toml");
    std::fs::write(&scene, "[objects.block]\neffects = [\"interior\"]\n").unwrap();
    fixture.serve(&["--scene", scene.to_str().unwrap()]);
    check_rejected(
        &fixture,
        &["--enable", "bonds"],
        "effect",
        "bonds",
        &["\"bonds\"", "`effects` or `allow`", "[objects.block]"],
    );
    let (path, document, stderr) = written(&fixture, "x.glb", &[]);
    assert!(stderr.contains("\"skin\"") && stderr.contains("[objects.block]"), "{stderr}");
    assert_eq!(glb::read(&path).unwrap().len(), document["fragments"].as_array().unwrap().len());
}

/// Files name the crate that writes them.
#[test]
fn every_file_is_named() {
    let fixture = block(Tables { elastic: true, interior: true, ..Tables::NONE });
    let check = |name: &str, arguments: &[&str], files: &[&str]| {
        let out = fixture.path(name);
        let output = fixture.run("shatter", &[arguments, &["--out", out.to_str().unwrap()]].concat());
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{stderr}");
        for file in files {
            let file = if file.is_empty() { out.clone() } else { out.join(Path::new(file)) };
            assert!(stderr.contains(&format!("wrote {} (", file.display())) && file.exists(), "{file:?} in {stderr}");
        }
        stderr
    };
    let divide = ["prefracture", "block", "--degree", "8"];
    check("a.glb", &divide, &[""]);
    let model = check("a.xml", &divide, &[""]);
    let pieces = check("pieces", &[&divide[..], &["--format", "obj"]].concat(), &[""]);
    for (stderr, folder) in [(model, "a_assets"), (pieces, "pieces")] {
        let folder = fixture.path(folder);
        let lines: Vec<&str> = stderr.lines().filter(|line| line.contains("wrote in ")).collect();
        let names = lines[0].split_once(&format!("wrote in {}: ", folder.display())).expect(lines[0]).1;
        let named: BTreeSet<String> = names.split(", ").map(str::to_owned).collect();
        let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        assert_eq!((lines.len(), named), (1, files.collect()));
    }
    let load = ["load", "block", "--clients", "1", "--closed", "--seconds", "0.5"];
    check("load", &load, &["load.json", "load.csv"]);
}
