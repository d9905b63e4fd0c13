//! Test of the example host: ten seconds, with the daemon killed in between.
//!
//! To run it: `cargo test --release --workspace --features shatter-lab/rapier --test rapier_host`

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Path of the example, built together with the daemon; cargo builds neither for a single named test.
fn host() -> PathBuf {
    let own = std::env::current_exe().unwrap();
    let folder = own.ancestors().nth(2).unwrap();
    let profile = if folder.ends_with("release") { "release" } else { "dev" };
    let mut build = Command::new(env!("CARGO"));
    build.args(["build", "--workspace", "--bins", "--example", "rapier_host", "--features", "shatter-lab/rapier"]);
    assert!(build.args(["--profile", profile]).status().unwrap().success());
    folder.join("examples/rapier_host")
}

/// Runs the example into `out`, and returns its summary.
fn hosted(out: &Path, more: &[&str]) -> Value {
    let service = format!("rapier-{}", std::process::id());
    let mut host = Command::new(host());
    host.args(["--service", &service, "--out"]).arg(out).args(more);
    assert!(host.status().unwrap().success());
    serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap()
}

/// Checks that all meshes but the balls are closed, as `EXT_mesh_manifold` declares, and as trimesh finds if Python has it.
#[track_caller]
fn check_closed(film: &Path, actors: u64) {
    let document = gltf::Gltf::from_slice(&std::fs::read(film).unwrap()).unwrap().document.into_json();
    let told = |mesh: &&gltf::json::Mesh| {
        mesh.extensions.as_ref().is_some_and(|own| own.others.contains_key("EXT_mesh_manifold"))
    };
    let open = document.meshes.iter().filter(|mesh| !told(mesh));
    let names: Vec<&str> = open.filter_map(|mesh| mesh.name.as_deref()).collect();
    assert!(names.iter().all(|name| *name == "ball"), "{names:?}");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/peers/watertight.py");
    let python = std::env::var_os("SHATTER_PYTHON").unwrap_or_else(|| "python3".into());
    let seen = Command::new(&python).arg(script).arg(film).output().unwrap();
    if !seen.status.success() {
        println!("skipped: {} reads no .glb: {}", python.display(), String::from_utf8_lossy(&seen.stderr));
        return;
    }
    let seen: Vec<Value> = serde_json::from_slice(&seen.stdout).unwrap();
    assert_eq!(seen.len() as u64, actors);
    // Breakable actors and their fragments have names like vase-7; boxes of the ground share a name.
    let breaks = |one: &&Value| one["name"].as_str().is_some_and(|name| name.contains('-'));
    assert!(seen.iter().filter(breaks).count() > 100);
    for one in seen.iter().filter(breaks) {
        assert!(one["watertight"] == true && one["declared"]["watertight"] == true, "{one}");
    }
}

#[test]
fn thirty_things_break_while_the_daemon_dies_and_no_step_waits() {
    let out = tempfile::tempdir().unwrap();
    let found = hosted(out.path(), &["--seconds", "10", "--kill-at", "4"]);
    let number = |key: &str| found[key].as_f64().unwrap_or(f64::NAN);
    assert!(number("breaks") >= 30.0 && number("breaks_again") >= 1.0, "{found:#}");
    assert!(number("mass_off") <= 1e-6 && found["energies_finite"] == true, "{found:#}");
    assert_eq!(found["steps_that_waited"], 0, "{found:#}");
    assert_eq!(found["paused_s"].as_array().unwrap().len(), 1, "it is restarted once: {found:#}");
    let film = gltf::Gltf::from_slice(&std::fs::read(out.path().join("film.glb")).unwrap()).unwrap();
    assert_eq!(film.nodes().len() as u64, found["actors"].as_u64().unwrap());
    assert!(film.animations().next().unwrap().channels().count() > film.nodes().len());
    check_closed(&out.path().join("film.glb"), found["actors"].as_u64().unwrap());
    for picture in ["film.png", "steps.svg"] {
        assert!(std::fs::metadata(out.path().join(picture)).unwrap().len() > 10_000, "{picture}");
    }
}
