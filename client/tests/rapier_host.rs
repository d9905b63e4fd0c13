//! The example host, ten seconds of it, with the daemon killed in between. Needs the programs:
//! `cargo build --release --workspace --bins --examples --features shatter-client/rapier`, then
//! `cargo test --release --workspace --features shatter-client/rapier --test rapier_host`

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs the example beside this test's program into `out`, and returns its figures.
fn hosted(out: &Path, more: &[&str]) -> Value {
    let own = std::env::current_exe().unwrap();
    let folder: PathBuf = own.ancestors().nth(2).unwrap().to_owned();
    let service = format!("rapier-{}", std::process::id());
    let mut host = Command::new(folder.join("examples/rapier_host"));
    host.args(["--service", &service, "--out"]).arg(out).args(more);
    assert!(host.status().unwrap().success());
    serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn thirty_things_break_while_the_daemon_dies_and_no_step_waits() {
    let out = tempfile::tempdir().unwrap();
    let found = hosted(out.path(), &["--seconds", "10", "--kill-at", "4"]);
    let number = |key: &str| found[key].as_f64().unwrap_or(f64::NAN);
    assert!(number("breaks") >= 30.0 && number("breaks_again") >= 1.0, "{found:#}");
    assert!(number("mass_off") <= 1e-6 && found["energies_finite"] == true, "{found:#}");
    assert_eq!(found["steps_that_waited"], 0, "{found:#}");
    assert_eq!(found["paused_s"].as_array().unwrap().len(), 1, "it comes back by itself: {found:#}");
    let film = gltf::Gltf::from_slice(&std::fs::read(out.path().join("film.glb")).unwrap()).unwrap();
    assert_eq!(film.nodes().len() as u64, found["actors"].as_u64().unwrap());
    assert!(film.animations().next().unwrap().channels().count() > film.nodes().len());
    for picture in ["film.png", "steps.svg"] {
        assert!(std::fs::metadata(out.path().join(picture)).unwrap().len() > 10_000, "{picture}");
    }
}
