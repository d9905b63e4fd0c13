//! Independent readers in Python, if it has them: `SHATTER_PYTHON` names the interpreter, by default `python3`.

use crate::fixture::{Fixture, program};
use serde_json::Value;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;

/// The interpreter, if it has `modules`; else `None`, after a line that CI counts.
pub fn python(modules: &[&str]) -> Option<OsString> {
    let python = std::env::var_os("SHATTER_PYTHON").unwrap_or_else(|| "python3".into());
    let tried = Command::new(&python).args(["-c", &format!("import {}", modules.join(", "))]).output();
    if tried.is_ok_and(|tried| tried.status.success()) {
        return Some(python);
    }
    println!("skipped: {} lacks one of {modules:?} (SHATTER_PYTHON names another)", python.display());
    None
}

/// Runs a script of `tests/peers`; returns the document that it prints.
#[track_caller]
fn script(python: &OsStr, name: &str, arguments: &[&OsStr]) -> Value {
    run(name, &mut Command::new(python), arguments)
}

/// Runs a script with another folder or environment.
#[track_caller]
fn run(name: &str, python: &mut Command, arguments: &[&OsStr]) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("peers").join(name);
    let output = python.arg(script).args(arguments).output().unwrap();
    let reported = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&reported).unwrap_or_else(|error| {
        panic!("{name} {arguments:?}: {error}: {reported}{}", String::from_utf8_lossy(&output.stderr))
    })
}

/// Runs a model in MuJoCo: see `tests/peers/mujoco_steps.py`.
#[track_caller]
pub fn mujoco(model: &Path, arguments: &[&str]) -> Option<Value> {
    let python = python(&["mujoco", "numpy"])?;
    let arguments: Vec<&OsStr> = [model.as_os_str()].into_iter().chain(arguments.iter().map(OsStr::new)).collect();
    Some(script(&python, "mujoco_steps.py", &arguments))
}

/// Drops the fragments of a `.glb` file in Blender: see `tests/peers/blender_drops.py`.
#[track_caller]
pub fn blender(file: &Path, frames: &str) -> Option<Value> {
    let python = python(&["bpy"])?;
    Some(script(&python, "blender_drops.py", &[file.as_os_str(), OsStr::new(frames)]))
}

/// Reads files with trimesh: see `tests/peers/watertight.py`.
#[track_caller]
pub fn watertight(files: &[&Path]) -> Option<Vec<Value>> {
    let python = python(&["trimesh", "numpy"])?;
    let arguments: Vec<&OsStr> = files.iter().map(|file| file.as_os_str()).collect();
    script(&python, "watertight.py", &arguments).as_array().cloned()
}

/// Validates job files against the schema of Kubernetes: see `tests/peers/kubernetes_files.py`.
#[track_caller]
pub fn kubernetes(files: &[&Path]) -> Option<Value> {
    let python = python(&["kubernetes_validate", "yaml"])?;
    let arguments: Vec<&OsStr> = files.iter().map(|file| file.as_os_str()).collect();
    Some(script(&python, "kubernetes_files.py", &arguments))
}

/// Strikes bodies with known energies in a test folder: see `tests/peers/closed_forms.py`.
#[track_caller]
pub fn closed_forms(fixture: &Fixture) -> Option<Vec<Value>> {
    let python = python(&["json"])?;
    let programs = ["shatterd", "shatter"].map(program);
    let arguments: Vec<&OsStr> = programs.iter().map(|path| path.as_os_str()).collect();
    let folder = fixture.path("");
    run("closed_forms.py", fixture.foreign(&python).current_dir(folder), &arguments).as_array().cloned()
}

/// Strikes `objects` with balls, each `strikes` times, and balances energies: see `tests/peers/ledger.py`.
#[track_caller]
pub fn ledger(fixture: &Fixture, strikes: u32, objects: &[&str]) -> Option<Vec<Value>> {
    let python = python(&["json"])?;
    let (programs, strikes) = (["shatterd", "shatter"].map(program), strikes.to_string());
    let more = [strikes.as_str()].into_iter().chain(objects.iter().copied()).map(OsStr::new);
    let arguments: Vec<&OsStr> = programs.iter().map(|path| path.as_os_str()).chain(more).collect();
    let folder = fixture.path("");
    run("ledger.py", fixture.foreign(&python).current_dir(folder), &arguments).as_array().cloned()
}

/// Runs an array of shares under HyperQueue, from `folder` with this `PATH`: see `tests/peers/hyperqueue_jobs.py`.
#[track_caller]
pub fn hyperqueue(arguments: &[&OsStr], folder: &Path, path: &str) -> Option<Value> {
    let python = python(&["hyperqueue"])?;
    Some(run("hyperqueue_jobs.py", Command::new(&python).current_dir(folder).env("PATH", path), arguments))
}
