//! From a scene to its fragments: its objects are baked from the project's own shapes, served and struck.

use serde_json::{Value, json};
use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_tests::fixture::Fixture;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

const ARCH: &str = "shape = \"arch\"\nmaterial = \"stone\"\nelastic_spacing = 0.06\ncrack_spacing = 0.035";
const HORSESHOE: &str = "shape = \"horseshoe\"\nmaterial = \"ceramic\"\nelastic_spacing = 0.06\ncrack_spacing = 0.04";

/// A scene of two objects of one database, and one of another.
fn scene(fixture: &Fixture, horseshoe: &str) -> String {
    let near = format!("[objects.near]\ndatabase = \"arch\"\neffects = [\"elastic\", \"interior\", \"bonds\"]\n{ARCH}");
    let far = "[objects.far]\ndatabase = \"arch\"\neffects = []";
    write(fixture, &format!("title = \"A test\"\n{near}\n{far}\n[objects.horseshoe]\neffects = []\n{horseshoe}"))
}

fn write(fixture: &Fixture, text: &str) -> String {
    let file = fixture.path("scene.toml");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

/// Bakes the scene; returns the outcome of each database.
#[track_caller]
fn bake(fixture: &Fixture, scene: &str) -> Vec<(String, String)> {
    let output = fixture.ok("shatterd", &["bake", "--scene", scene]);
    let word = |row: &Value, key: &str| row[key].as_str().unwrap().to_owned();
    output["files"].as_array().unwrap().iter().map(|row| (word(row, "database"), word(row, "state"))).collect()
}

fn states(pairs: [(&str, &str); 2]) -> Vec<(String, String)> {
    pairs.map(|(database, state)| (database.to_owned(), state.to_owned())).to_vec()
}

/// Runs `shatterd` to its end without `--json`; returns exit code and stdout.
fn screen(fixture: &Fixture, arguments: &[&str]) -> (Option<i32>, String) {
    let output = fixture.run("shatterd", arguments);
    (output.status.code(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn a_scene_is_baked_once_served_and_struck() {
    let mut fixture = Fixture::new();
    let file = scene(&fixture, HORSESHOE);
    let (_, plan) = screen(&fixture, &["check", &file]);
    assert!(plan.ends_with(&format!("shatterd bake --scene {file}\n")), "{plan}");
    assert_eq!(bake(&fixture, &file), states([("arch", "baked"), ("horseshoe", "baked")]));
    let database = |name: &str| fixture.databases().join(format!("{name}.shatter"));
    let bytes = ["arch", "horseshoe"].map(|name| std::fs::read(database(name)).unwrap());
    let date = || ["arch", "horseshoe"].map(|name| database(name).metadata().unwrap().modified().unwrap());
    let first = date();

    // The database has only the parts that some request may need, for both objects of the arch.
    let inspect = |name: &str| fixture.ok("shatterd", &["inspect", database(name).to_str().unwrap()]);
    let (arch, horseshoe) = (inspect("arch"), inspect("horseshoe"));
    assert_eq!((&arch["object"], &arch["surface_diffusion_dimensions"]), (&json!("arch"), &json!([null])));
    assert!(arch["lift_dimensions"][0].as_u64() > Some(0) && arch["elastic_nodes"].as_u64() > Some(0), "{arch}");
    assert_eq!((&horseshoe["lift_dimensions"], &horseshoe["elastic_nodes"]), (&json!([null]), &json!(0)));

    assert_eq!(bake(&fixture, &file), states([("arch", "kept"), ("horseshoe", "kept")]));
    let (code, lines) = screen(&fixture, &["bake", "--scene", &file]);
    let lines: Vec<&str> = lines.lines().collect();
    assert!(code == Some(0) && lines.len() == 2, "{lines:?}");
    assert!(
        lines[0].starts_with("arch (for far, near)  kept ") && lines[1].starts_with("horseshoe  kept "),
        "{lines:?}"
    );
    assert_eq!(date(), first, "what is kept is not written");
    assert!(!screen(&fixture, &["check", &file]).1.contains("--scene"));

    let other = scene(&fixture, &HORSESHOE.replace("0.04", "0.045"));
    assert_eq!(bake(&fixture, &other), states([("arch", "kept"), ("horseshoe", "baked")]));
    assert_ne!(std::fs::read(database("horseshoe")).unwrap(), bytes[1]);
    let file = scene(&fixture, HORSESHOE);
    std::fs::remove_file(database("arch")).unwrap();
    assert_eq!(bake(&fixture, &file), states([("arch", "baked"), ("horseshoe", "baked")]));
    assert_eq!(["arch", "horseshoe"].map(|name| std::fs::read(database(name)).unwrap()), bytes, "the same bytes again");

    fixture.serve(&["--scene", &file]);
    let listed = fixture.ok("shatter", &["list"]);
    let names: Vec<_> = listed["objects"].as_array().unwrap().iter().map(|row| row["object"].as_str()).collect();
    assert_eq!(names, [Some("far"), Some("horseshoe"), Some("near")]);
    let strike = |name: &str| {
        let impact_arguments = ["--point", "0.5,0.3,0.1", "--impulse", "0,0,-900", "--degree", "6"];
        fixture.ok("shatter", &[&["impact", name][..], &impact_arguments].concat())
    };
    let ran = |document: &Value, stage: &str| {
        let stages = document["stages"].as_array().unwrap();
        stages.iter().any(|row| row["name"] == stage && row["ran"] == true)
    };
    let (near, far) = (strike("near"), strike("far"));
    assert_eq!([&near, &far].map(|document| ran(document, "elasticity")), [true, false], "{near}");
    assert_eq!([&near, &far].map(|document| ran(document, "bonds")), [true, false]);
    assert_eq!(fixture.end(), Some(0));
}

/// Anchors that hold every node are refused by the commands, and reported by the service with the key of the scene.
#[test]
fn anchors_that_hold_the_whole_object_are_refused_before_it_is_served() {
    let mut fixture = Fixture::new();
    let anchors = "anchors = [{ min = [-100, -100, -100], max = [100, 100, 100] }]";
    let object = format!("[objects.horseshoe]\neffects = [\"elastic\", \"anchored\"]\n{anchors}\n{HORSESHOE}");
    let whole = write(&fixture, &object);
    for attempt in ["baked", "kept"] {
        for command in [&["bake", "--scene", &whole][..], &["check", &whole]] {
            let (code, document) = fixture.json("shatterd", command);
            let (kind, at) = (&document["error"]["kind"], &document["error"]["at"]);
            let wanted = (3, &json!("configuration"), &json!("objects.horseshoe.anchors"));
            assert_eq!((code, kind, at), wanted, "{attempt}, {command:?}: {document}");
        }
    }
    fixture.serve(&["--scene", &whole]);
    let listed = fixture.ok("shatter", &["list"]);
    let message = listed["objects"][0]["error"]["message"].as_str().unwrap();
    assert!(message.contains("objects.horseshoe: the anchors contain all"), "{message}");
    assert_eq!(fixture.end(), Some(0));
}

/// The database of a thin mesh gets displacements for the anchors of a scene, once, and a changed scene is solved for.
#[test]
fn anchored_thin_walls_get_displacements_of_their_own() {
    let mut fixture = Fixture::new();
    let mesh = fixture.path("strip.obj");
    write_obj(&shapes::cuboid([0.2, 0.05, 0.02]), &mesh).unwrap();
    let held = |fixture: &Fixture, x: f64| {
        let anchor = format!("{{ min = [-1, -1, -1], max = [{x}, 1, 1] }}");
        write(fixture, &format!("[objects.strip]\neffects = [\"elastic\", \"anchored\"]\nanchors = [{anchor}]"))
    };
    let scene = held(&fixture, -0.075);
    assert_eq!(fixture.json("shatterd", &["bake", "--scene", &scene]).0, 3, "there is no database yet");
    let spacings = ["--elastic-spacing", "0.06", "--crack-spacing", "0.06", "--surface", "lattice", "--unit", "m"];
    fixture.ok("shatterd", &[&["bake", mesh.to_str().unwrap(), "--name", "strip"], &spacings[..]].concat());
    let own = |state: &str| vec![("strip".to_owned(), state.to_owned())];
    assert_eq!(bake(&fixture, &scene), own("extended"));
    assert_eq!(bake(&fixture, &scene), own("kept"));
    let strike = |fixture: &Fixture, more: &[&str]| {
        let at =
            ["impact", "strip", "--point", "0.09,0,0.01", "--impulse", "0,0,-1", "--radius-m", "0.02", "--degree", "4"];
        let document = fixture.ok("shatter", &[&at, more].concat());
        (document["elastic"].as_str().unwrap().to_owned(), document["ledger"]["strain_j"].as_f64().unwrap())
    };
    fixture.serve(&["--scene", &scene]);
    let (reduced, solved) = (strike(&fixture, &[]), strike(&fixture, &["--elastic", "solve"]));
    assert_eq!([&*reduced.0, &*solved.0], ["reduced", "solve"]);
    assert!((reduced.1 / solved.1 - 1.0).abs() < 0.05, "{reduced:?} {solved:?}");
    assert_eq!(fixture.end(), Some(0));

    let scene = held(&fixture, -0.05);
    fixture.serve(&["--scene", &scene]);
    assert_eq!(strike(&fixture, &[]).0, "solve");
    assert_eq!(fixture.end(), Some(0));
    assert_eq!(bake(&fixture, &scene), own("extended"));
    fixture.serve(&["--scene", &scene]);
    assert_eq!(strike(&fixture, &[]).0, "reduced");
    assert_eq!(fixture.end(), Some(0));
}

/// A database that was baked for less than a scene needs is reported before any request.
#[test]
fn tables_that_a_database_lacks_are_named() {
    let mut fixture = Fixture::new();
    let cheap = write(&fixture, &format!("[objects.horseshoe]\neffects = []\n{HORSESHOE}"));
    fixture.ok("shatterd", &["bake", "--scene", &cheap]);
    for (effect, table) in
        [("elastic", "elastic"), ("interior", "interior"), ("skin", "skin"), ("attributes", "attributes")]
    {
        let rich = write(&fixture, &format!("[objects.horseshoe]\neffects = [\"{effect}\"]\n{HORSESHOE}"));
        let (code, output) = fixture.json("shatterd", &["check", &rich]);
        let message = output["error"]["message"].as_str().unwrap();
        assert!(code == 3 && message.contains(&format!("`{table}`")) && message.contains("bake"), "{output}");
    }
    let rich = fixture.path("scene.toml").to_str().unwrap().to_owned();
    fixture.serve(&["--scene", &rich]);
    let (_, refused) = fixture.json("shatter", &["impact", "horseshoe", "--point", "0,0.12,0", "--impulse", "0,-9,0"]);
    assert!(refused["error"]["message"].as_str().unwrap().contains("`attributes`"), "{refused}");
    assert_eq!(fixture.end(), Some(0));
}

#[test]
fn an_interruption_keeps_finished_databases() {
    let fixture = Fixture::new();
    let file = scene(&fixture, &format!("{HORSESHOE}\nexamples = 4000"));
    let mut command = fixture.command("shatterd");
    let mut child =
        command.args(["bake", "--scene", &file]).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    assert!(line.starts_with("arch (for far, near)  baked "), "{line}");
    rustix::process::kill_process(rustix::process::Pid::from_child(&child), rustix::process::Signal::INT).unwrap();
    assert_eq!((child.wait().unwrap().code(), lines.count()), (Some(130), 0));
    let left: Vec<_> =
        std::fs::read_dir(fixture.databases()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["arch.shatter"]);
    let file = scene(&fixture, HORSESHOE);
    assert_eq!(bake(&fixture, &file), states([("arch", "kept"), ("horseshoe", "baked")]));
}

#[test]
fn an_invalid_scene_is_rejected_before_any_bake() {
    let fixture = Fixture::new();
    let refused = |text: &str| {
        let file = write(&fixture, text);
        let (code, document) = fixture.json("shatterd", &["bake", "--scene", &file]);
        assert!(!fixture.databases().exists());
        (code, document["error"]["at"].as_str().unwrap().to_owned())
    };
    let both = format!("[objects.a]\ndatabase = \"c\"\n{ARCH}\n[objects.b]\ndatabase = \"c\"\n");
    assert_eq!(refused(&(both.clone() + "shape = \"mug\"")), (3, "objects.b.shape".to_owned()));
    assert_eq!(refused(&(both + "crack_spacing = 0.04")), (3, "objects.b.crack_spacing".to_owned()));
    assert_eq!(refused("[objects.a]\nshape = \"mug\""), (3, "objects.a.material".to_owned()));
    assert_eq!(refused("[objects.a]\nmaterial = \"glass\""), (3, "shape".to_owned()));

    let (file, mesh) = (scene(&fixture, HORSESHOE), fixture.path("arch.obj"));
    write_obj(&shapes::arch(), &mesh).unwrap();
    for more in [&[mesh.to_str().unwrap(), "--name", "arch"][..], &["--material", "glass"], &["--resume"]] {
        let (code, document) = fixture.json("shatterd", &[&["bake", "--scene", &file], more].concat());
        assert_eq!((code, &document["error"]["kind"]), (2, &json!("usage")), "{document}");
    }
    for less in [&[][..], &[mesh.to_str().unwrap()], &["--name", "arch"]] {
        let (code, document) = fixture.json("shatterd", &[&["bake"], less].concat());
        assert_eq!((code, &document["error"]["kind"]), (2, &json!("usage")), "{document}");
    }
}
