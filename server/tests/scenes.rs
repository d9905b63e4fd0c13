//! Scenes with real processes: the daemon serves the objects of a scene by its settings, and loads only what these need.

mod support;

use serde_json::Value;
use shatter_client::{
    Bond, Client, Contact, DegreeRule, Effect, EffectCost, Error, ErrorKind, Impact, Lift, Object, StageKind,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use support::{Child, TestDirectory, bar, shatter, shatter_program, shatterd, timeout};

const CHEAP: &str = "[objects.bar]\neffects = []\nallow = [\"bonds\"]\nsites_max = 30";
const RICH: &str =
    "[objects.bar]\neffects = [\"elastic\", \"interior\", \"slivers\", \"bonds\", \"normals\"]\nallow = [\"debris\"]";

/// A test place with a bar and a scene.
fn place(name: &str, scene: &str) -> (TestDirectory, PathBuf) {
    let here = TestDirectory::new(name);
    std::fs::write(here.databases().join("bar.shatter"), bar(0.06)).unwrap();
    let file = here.file("scene.toml", scene);
    (here, file)
}

/// Starts a daemon that serves the scene; returns the bar.
fn serve(here: &TestDirectory, scene: &Path) -> (Child, Client, Object) {
    let daemon = Child::start(shatterd(here).arg("--scene").arg(scene));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let bar = service.object("bar", timeout()).unwrap();
    (daemon, service, bar)
}

fn base_impact() -> Impact {
    Impact::new([Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]).radius(0.05)])
        .degree(DegreeRule::Sites(24))
        .seed(3)
}

fn refused(bar: &Object, impact: &Impact) -> Error {
    bar.strike(impact).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap()
}

/// Runs a command of `shatterd` to its end; returns exit code, stdout, stderr.
fn run(here: &TestDirectory, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    let out = command.args(arguments).stdin(Stdio::null()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (out.status.code().unwrap(), text(out.stdout), text(out.stderr))
}

#[test]
fn a_cheap_scene_loads_and_runs_less() {
    let (here, scene) = place("cheap", CHEAP);
    let (daemon, service, bar) = serve(&here, &scene);
    let cheap_bytes = service.status(timeout()).unwrap().memory_bytes;
    let result = bar.strike(&base_impact()).unwrap().wait(timeout()).unwrap();
    assert!(
        result.effects().all(|cost| cost == EffectCost::idle(cost.effect)),
        "{:?}",
        result.effects().collect::<Vec<_>>()
    );
    assert!(result.stages().all(|cost| cost.stage != StageKind::Elasticity || !cost.has_run));
    assert!(bar.strike(&base_impact().enable(Effect::Bonds)).unwrap().wait(timeout()).unwrap().bonds().len() > 0);
    for (impact, kind, at) in [
        (base_impact().enable(Effect::Debris), ErrorKind::Effect, "debris"),
        (base_impact().enable(Effect::Elastic), ErrorKind::Effect, "elastic"),
        (base_impact().lift(Lift::Interior), ErrorKind::Effect, "interior"),
        (base_impact().degree(DegreeRule::Sites(31)), ErrorKind::Degree, "31"),
    ] {
        let error = refused(&bar, &impact);
        assert_eq!((error.kind, error.at.as_str()), (kind, at), "{error}");
    }
    assert_eq!(daemon.terminate().code(), Some(0));

    let (here, scene) = place("rich", RICH);
    let (daemon, service, bar) = serve(&here, &scene);
    let rich_bytes = service.status(timeout()).unwrap().memory_bytes;
    let result = bar.strike(&base_impact()).unwrap().wait(timeout()).unwrap();
    let ran: Vec<&str> = result.effects().filter(|cost| cost.has_run).map(|cost| cost.effect.name()).collect();
    assert_eq!(ran, ["elastic", "interior", "slivers", "normals", "bonds"]);
    assert!(bar.strike(&base_impact().disable(Effect::Elastic)).unwrap().wait(timeout()).is_ok());
    println!("memory: {cheap_bytes} bytes for the cheap scene, {rich_bytes} for the rich one");
    assert!(4 * cheap_bytes < 3 * rich_bytes, "{cheap_bytes} of {rich_bytes}");
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn a_scene_serves_its_own_objects_and_begins_with_all_of_them() {
    let (here, scene) = place("own", CHEAP);
    std::fs::copy(here.databases().join("bar.shatter"), here.databases().join("other.shatter")).unwrap();
    let (daemon, service, _) = serve(&here, &scene);
    let names: Vec<String> = service.objects(timeout()).unwrap().into_iter().map(|facts| facts.name).collect();
    assert_eq!(names, ["bar"]);
    assert_eq!(daemon.terminate().code(), Some(0));
    let missing = here.file("missing.toml", &format!("{CHEAP}\n[objects.bowl]"));
    let (code, _, error) = run(&here, &["serve", "--scene", missing.to_str().unwrap()]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("`bowl`") && error.contains("bake"), "{error}");
}

#[test]
fn check_prints_the_plan_and_rejects_unknown_keys() {
    let (here, scene) = place("check", RICH);
    let databases = here.databases();
    let at = ["--databases", databases.to_str().unwrap(), "--json"];
    let check = |scene: &Path| run(&here, &[&["check", scene.to_str().unwrap()], &at[..]].concat());
    let (code, text, error) = check(&scene);
    assert_eq!(code, 0, "{error}");
    let reported: Value = serde_json::from_str(&text).unwrap();
    let plan = &reported["objects"][0];
    let of = |list: &str, name: &str| {
        let rows = plan[list].as_array().unwrap();
        rows.iter().find(|row| row["name"] == name).cloned().unwrap()
    };
    assert_eq!((&plan["object"], &plan["baked"]), (&"bar".into(), &true.into()));
    let state = |effect: &str| of("effects", effect)["state"].as_str().unwrap().to_owned();
    assert_eq!([state("slivers"), state("debris"), state("uv")], ["on", "allowed", "off"]);
    let table = |name: &str| (of("tables", name)["loaded"] == true, of("tables", name)["bytes"].as_u64().unwrap() > 0);
    assert_eq!(
        [table("elastic"), table("interior"), table("surface_diffusion")],
        [(true, true), (true, true), (false, true)]
    );
    assert_eq!(table("examples"), (false, false), "a table that the file lacks is not loaded");

    let wrong = here.file("wrong.toml", "[objects.bar]\neffects = [\"bond\"]");
    let (code, text, _) = check(&wrong);
    let error: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &error["error"]["kind"], &error["error"]["at"]), (3, &"unknown_effect".into(), &"bond".into()));
    assert!(error["error"]["message"].as_str().unwrap().contains("`bonds`"), "{text}");

    let other = here.file("other.toml", "[objects.bar]\nmaterial = \"plaster\"");
    let (code, text, _) = check(&other);
    let error: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &error["error"]["at"]), (3, &"objects.bar.material".into()), "{text}");
}

#[test]
fn anchors_that_hold_nothing_are_refused_when_the_scene_is_loaded() {
    let held = |max: f64| {
        format!(
            "effects = [\"elastic\", \"interior\", \"bonds\", \"anchored\", \"gravity\"]\n\
             anchors = [{{ min = [-0.3, -0.3, -0.3], max = [{max}, 0.3, 0.3] }}]\n"
        )
    };
    let firm = format!("[objects.firm]\ndatabase = \"bar\"\n{}", held(0.1));
    let held = |max: f64| format!("[objects.bar]\n{}", held(max));
    let (here, scene) = place("held", &(held(-0.15) + &firm));
    let databases = here.databases();
    let check = |scene: &Path| {
        run(&here, &["check", scene.to_str().unwrap(), "--databases", databases.to_str().unwrap(), "--json"])
    };
    let (code, text, error) = check(&scene);
    let reported: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(code, 0, "{error}");
    assert!(reported["objects"][0]["anchors"][0]["nodes"].as_u64().unwrap() > 8, "{text}");
    let (daemon, service, bar) = serve(&here, &scene);
    let result = bar.strike(&base_impact()).unwrap().wait(timeout()).unwrap();
    let ran: Vec<&str> = result.effects().filter(|cost| cost.has_run).map(|cost| cost.effect.name()).collect();
    assert_eq!(ran, ["elastic", "interior", "bonds", "anchored", "gravity"]);
    assert_eq!(result.summary().energy_source.name(), "solve");
    // The weight does not grow with the impulse, so that no factor breaks the bar.
    let soft = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-1e-4,0,0", "--radius-m", "0.05"];
    let advice = |more: &[&str]| shatter(&here, &[&soft[..], more].concat()).1;
    let [heavy, light] = [advice(&[]), advice(&["--disable", "gravity"])];
    assert!(heavy.contains("stays whole") && !heavy.contains("to break it"), "{heavy}");
    assert!(light.contains("to break it: "), "{light}");
    // The energy at the threshold is that of impulse and weight together.
    let at = ["--point", "0.2,0,0", "--radius-m", "0.05", "--json"];
    let json = |arguments: &[&str]| -> Value {
        serde_json::from_str(&shatter(&here, &[arguments, &at[..]].concat()).1).unwrap()
    };
    let just = json(&["threshold", "bar", "--direction", "-1,0,0"]);
    let impulse = format!("-{},0,0", just["impulse_ns"]);
    let struck = json(&["impact", "bar", "--impulse", &impulse, "--degree", "2"]);
    let strain_j = |document: &Value| document["ledger"]["strain_j"].as_f64().unwrap();
    assert!((strain_j(&just) / strain_j(&struck) - 1.0).abs() < 1e-9, "{just} {struck}");
    // A contact on anchors alone deforms nothing, with or without weight.
    let firm = service.object("firm", timeout()).unwrap();
    let pressed = Impact::new([Contact::new([-0.2, 0.0, 0.0]).impulse([1.0, 0.0, 0.0])]).threshold_only();
    let refused = firm.strike(&pressed).unwrap().wait(timeout()).err().unwrap();
    assert!(refused.kind == ErrorKind::Impulse && refused.message.contains("press on anchors only"), "{refused}");
    let light = bar.strike(&base_impact().disable(Effect::Gravity)).unwrap().wait(timeout()).unwrap();
    assert_ne!(light.digest().output_hash, result.digest().output_hash);
    let strike = [
        "impact",
        "bar",
        "--point",
        "0.2,0,0",
        "--impulse",
        "-50,3,0",
        "--radius-m",
        "0.05",
        "--degree",
        "24",
        "--seed",
        "3",
    ];
    let (_, text) = shatter(&here, &[&strike[..], &["--json"]].concat());
    let document: Value = serde_json::from_str(&text).unwrap();
    let bonds = document["bonds"].as_array().unwrap();
    let world = bonds.iter().filter(|bond| bond["world"] == true && bond["fragments"].as_array().unwrap().len() == 1);
    assert_eq!(world.count(), result.bonds().filter(Bond::is_with_world).count());
    assert_eq!(daemon.terminate().code(), Some(0));

    let wrong = here.file("wrong.toml", &held(-0.25));
    let (code, text, _) = check(&wrong);
    let error: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &error["error"]["at"]), (3, &"objects.bar.anchors".into()), "{text}");
    let daemon = Child::start(shatterd(&here).arg("--scene").arg(&wrong));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let error = service.object("bar", timeout()).err().unwrap();
    assert!(error.message.contains("objects.bar") && error.message.contains("anchors[0]"), "{error}");
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn the_shipped_scenes_are_valid() {
    let here = TestDirectory::new("shipped");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/scenes");
    let scenes: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(scenes.len() >= 3);
    for scene in scenes {
        let (code, text, error) = run(&here, &["check", scene.to_str().unwrap()]);
        assert_eq!(code, 0, "{error}");
        assert!(text.contains("stages") && text.contains("not baked yet"), "{text}");
    }
}

#[test]
fn check_names_the_criterion_and_shortens_long_lists_of_anchors() {
    let here = TestDirectory::new("terms");
    let region = "{ min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }";
    let anchors = [region; 11].join(", ");
    let text = format!(
        "[objects.bar]\ncriterion = \"strength\"\nstrength_scale = 2.5\nallow = [\"anchored\"]\nanchors = [{anchors}]\n"
    );
    let scene = here.file("terms.toml", &format!("{text}[objects.cup]\nshape = \"mug\"\nmaterial = \"ceramic\"\n"));
    let (code, text, error) = run(&here, &["check", scene.to_str().unwrap()]);
    assert_eq!(code, 0, "{error}");
    assert!(
        text.contains("  criterion strength, impulses that break it times 2.5\n")
            && text.contains("  criterion paper\n"),
        "{text}"
    );
    assert!(text.matches("  anchor ").count() == 9 && text.contains("and 3 more"), "{text}");
    let (_, text, _) = run(&here, &["check", scene.to_str().unwrap(), "--json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    let bar = &document["objects"][0];
    assert_eq!((&bar["criterion"], &bar["strength_scale"]), (&"strength".into(), &2.5.into()), "{text}");
    assert_eq!(bar["anchors"].as_array().unwrap().len(), 11);
}

#[test]
fn scenes_of_the_guide_are_valid() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../client/guide/src/scenes.md");
    let page = std::fs::read_to_string(page).unwrap();
    let scenes: Vec<&str> = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let scenes = scenes.into_iter().filter(|text| text.contains("[objects."));
    let scenes: Vec<_> = scenes.map(|text| shatter_engine::scene::Scene::parse(text, Path::new("")).unwrap()).collect();
    assert_eq!(scenes.len(), 2);
}

#[test]
fn results_beyond_the_scene_limits_are_rejected_by_name() {
    for (key, cap) in [("bytes_max", 20_000), ("fragments_max", 10)] {
        let (here, scene) = place("caps", &format!("[objects.bar]\n{key} = {cap}"));
        let (daemon, _, bar) = serve(&here, &scene);
        let error = refused(&bar, &base_impact());
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::CapExceeded, key), "{error}");
        assert_eq!(daemon.terminate().code(), Some(0));
    }
}

#[test]
fn pieces_below_the_scenes_volume_become_part_of_others() {
    const LEAST: f64 = 2e-4;
    let scene = format!("[objects.bar]\neffects = [\"interior\", \"slivers\"]\nvolume_min_m3 = {LEAST}");
    let (here, scene) = place("least", &scene);
    let (daemon, _, bar) = serve(&here, &scene);
    let volumes = |impact: &Impact| -> Vec<f64> {
        let result = bar.strike(impact).unwrap().wait(timeout()).unwrap();
        result.fragments().map(|own| own.volume_m3()).collect()
    };
    let many = base_impact().degree(DegreeRule::Sites(120));
    let (merged, all) = (volumes(&many), volumes(&many.clone().disable(Effect::Slivers)));
    assert!(all.iter().any(|volume| *volume < 0.5 * LEAST) && merged.len() < all.len());
    // Where a merge reduces a junction of three cracks to two, volumes change a little.
    assert!(merged.iter().all(|volume| *volume > 0.9 * LEAST), "{merged:?}");
    assert!((merged.iter().sum::<f64>() / all.iter().sum::<f64>() - 1.0).abs() < 1e-6);
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn a_result_in_one_piece_is_told_with_its_reason() {
    let scene = "[objects.bar]\neffects = [\"interior\", \"slivers\"]\nvolume_min_m3 = 1e3";
    let (here, scene) = place("one-piece", scene);
    let (daemon, ..) = serve(&here, &scene);
    let warning = |more: &[&str]| {
        let strike = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,3,0", "--degree", "24"];
        let out = shatter_program(&here).args(strike).args(more).output().unwrap();
        assert!(out.status.success(), "{out:?}");
        String::from_utf8(out.stderr).unwrap()
    };
    let told = warning(&[]);
    assert!(told.contains("in one piece: all 24 cells") && told.contains("`volume_min_m3`"), "{told}");
    assert_eq!(warning(&["--disable", "slivers"]), "");
    assert_eq!(daemon.terminate().code(), Some(0));
}
