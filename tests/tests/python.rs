//! The Python package against a real daemon: its own tests in place, and the installed wheel as a new user has it.

use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_tests::fixture::{Fixture, program};
use shatter_tests::peers::python;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A test folder with a bar, and the daemon running.
fn with_bar() -> Fixture {
    let mut fixture = Fixture::new();
    let mesh = fixture.path("bar.obj");
    write_obj(&shapes::cuboid([0.4, 0.2, 0.2]), &mesh).unwrap();
    let bake = ["bake", mesh.to_str().unwrap(), "--name", "bar", "--material", "glass"];
    fixture.ok("shatterd", &[&bake[..], &["--crack-spacing", "0.04", "--elastic-spacing", "0.1"]].concat());
    fixture.serve(&[]);
    fixture
}

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../client/python")
}

/// Runs a program in the test folder to its end, which must be a success; returns its output.
#[track_caller]
fn run(fixture: &Fixture, program: &OsStr, arguments: &[&str], adapt: impl FnOnce(&mut Command)) -> String {
    let mut command = fixture.foreign(program);
    command.args(arguments).env("SHATTER_TEST_SERVICE", "default").env("SHATTER_TEST_OBJECT", "bar");
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    adapt(&mut command);
    let output = command.output().unwrap();
    let [stdout, error] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success(), "{program:?} {arguments:?}: {stdout}{error}");
    stdout
}

/// Runs `pytest` on the package's tests; returns the number that passed.
#[track_caller]
fn check_package(fixture: &Fixture, python: &OsStr, adapt: impl FnOnce(&mut Command)) {
    let tests = package().join("tests");
    let arguments = ["-m", "pytest", "-q", "-p", "no:cacheprovider", tests.to_str().unwrap()];
    let stdout = run(fixture, python, &arguments, adapt);
    assert!(stdout.contains("passed") && !stdout.contains("skipped"), "{stdout}");
}

#[test]
fn the_package_keeps_its_promises_where_python_is() {
    let Some(python) = python(&["numpy", "pytest"]) else { return };
    let fixture = with_bar();
    let site = fixture.path("site/shatter");
    std::fs::create_dir_all(&site).unwrap();
    for name in ["__init__.py", "_messages.py"] {
        std::fs::copy(package().join("python/shatter").join(name), site.join(name)).unwrap();
    }
    std::fs::copy(program("lib_shatter.so"), site.join("_shatter.abi3.so")).unwrap();
    check_package(&fixture, &python, |command| {
        command.env("PYTHONPATH", fixture.path("site"));
    });
}

#[test]
#[ignore = "minutes; needs Python and its package index"]
fn a_wheel_is_built_installed_and_used_in_a_fresh_environment() {
    let fixture = with_bar();
    let environment = fixture.path("venv");
    let system = std::env::var_os("SHATTER_PYTHON").unwrap_or_else(|| "python3".into());
    run(&fixture, &system, &["-m", "venv", environment.to_str().unwrap()], |_| {});
    let python = environment.join("bin/python");
    let pip =
        |what: &[&str]| run(&fixture, python.as_os_str(), &[&["-m", "pip", "install", "-q"], what].concat(), |_| {});
    pip(&["maturin", "pytest", "mypy"]);
    let wheels = fixture.path("wheels");
    let maturin = environment.join("bin/maturin");
    run(&fixture, maturin.as_os_str(), &["build", "--release", "--out", wheels.to_str().unwrap()], |command| {
        command.current_dir(package());
    });
    let wheel = std::fs::read_dir(&wheels).unwrap().next().unwrap().unwrap().path();
    pip(&[wheel.to_str().unwrap()]);
    check_package(&fixture, python.as_os_str(), |_| {});
    run(&fixture, python.as_os_str(), &["-m", "mypy.stubtest", "shatter"], |command| {
        command.current_dir(fixture.path("data"));
    });
    let mypy = ["-m", "mypy", "--strict", package().join("examples/strike.py").to_str().unwrap()].map(str::to_owned);
    run(&fixture, python.as_os_str(), &mypy.each_ref().map(String::as_str), |command| {
        command.current_dir(fixture.path("data"));
    });
    let example = package().join("examples/strike.py");
    let stdout = run(&fixture, python.as_os_str(), &[example.to_str().unwrap(), "bar", "out.glb"], |command| {
        command.current_dir(fixture.path("data"));
    });
    assert!(stdout.contains("24 fragments"), "{stdout}");
    assert!(std::fs::read(fixture.path("data/out.glb")).unwrap().starts_with(b"glTF"));
}
