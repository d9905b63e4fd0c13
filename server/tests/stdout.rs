//! Commands whose stdout cannot be written: they report it and end with an error.

mod support;

use std::ffi::OsStr;
use std::fs::File;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Command, Stdio};
use support::{InProcess, TestDirectory, bar, shatter_program, under};

/// Starts a service with a bar.
fn start() -> InProcess {
    let here = TestDirectory::new("stdout");
    here.database("bar", bar(0.06));
    InProcess::start_with(here, "", shatter_engine::wire::loader(None))
}

/// Runs a command with a full stdout; returns exit code and stderr.
fn full(mut command: Command) -> (Option<i32>, String) {
    let stdout = File::options().write(true).open("/dev/full").unwrap();
    let output = command.stdin(Stdio::null()).stdout(stdout).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Runs a command whose reader went away; returns exit code and stderr.
fn closed(mut command: Command) -> (Option<i32>, String) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = command.stdin(Stdio::null()).stdout(writer).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Checks that a command fails with a message on a full stdout, and quietly if the reader went away.
#[track_caller]
fn check(command: impl Fn() -> Command, quiet: bool) {
    let what = format!("{:?}", command());
    let (code, error) = full(command());
    assert!(code == Some(3) && error.contains("cannot write to stdout"), "{what}: {code:?} {error}");
    let (code, error) = absent(command());
    assert!(code == Some(3) && error.contains("cannot write to stdout: it is closed"), "{what}: {code:?} {error}");
    let (code, error) = closed(command());
    assert!(code == Some(141) && (!quiet || error.is_empty()), "{what}: {code:?} {error}");
}

/// Runs a command without a stdout; returns exit code and stderr.
fn absent(command: Command) -> (Option<i32>, String) {
    let output = under(&[], "exec 1>&-", command).stdin(Stdio::null()).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Checks that a command with an error of its own keeps its exit code, and reports both errors.
#[track_caller]
fn check_failure(command: impl Fn() -> Command, wanted: i32) {
    let what = format!("{:?}", command());
    let (code, error) = full(command());
    assert!(code == Some(wanted) && error.contains("cannot write to stdout"), "{what}: {code:?} {error}");
    assert!(error.lines().count() > 1, "the error of the command is reported: {what}: {error}");
    let (code, _) = closed(command());
    assert_eq!(code, Some(wanted), "{what}");
}

const POINT: [&str; 2] = ["--point", "0.2,0,0"];

#[test]
fn every_command_of_shatter_tells_that_stdout_is_full() {
    let daemon = start();
    let command = |arguments: &[&str]| {
        let mut command = shatter_program(&daemon.here);
        command.args(arguments);
        command
    };
    let file = &daemon.here.databases().join("pieces.glb");
    let strike = [&["impact", "bar", "--impulse", "-50,3,0", "--degree", "6"], &POINT[..]].concat();
    let whole = [&["impact", "bar", "--impulse", "-1e-6,0,0"], &POINT[..]].concat();
    let test = [&["threshold", "bar", "--direction", "-1,0,0"], &POINT[..]].concat();
    let load = ["load", "bar", "--clients", "1", "--rate", "20", "--seconds", "0.1", "--degree", "3"];
    for arguments in [&["list"][..], &["status"], &strike, &whole, &test] {
        check(|| command(arguments), true);
        check(|| command(&[arguments, &["--json"]].concat()), true);
    }
    let prefracture = ["prefracture", "bar", "--degree", "4", "--out", file.to_str().unwrap()];
    check(|| command(&prefracture), false);
    check(|| command(&load), true);
    check(|| command(&["status", "--watch"]), true);
    for help in [&["--help"][..], &["--version"], &["list", "--help"], &["impact", "--help"], &["help", "load"]] {
        check(|| command(help), true);
    }
    check_failure(|| command(&["impact", "bra", "--impulse", "1,0,0", "--point", "0,0,0", "--json"]), 3);
    check_failure(|| command(&["impact", "--json"]), 2);
    check_failure(|| command(&["list", "--service", "nowhere", "--json"]), 4);
}

#[test]
fn every_command_of_shatterd_tells_that_stdout_is_full() {
    let here = TestDirectory::new("stdout");
    here.database("bar", bar(0.06));
    let command = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
        here.aim(&mut command);
        command.args(arguments);
        command
    };
    let databases = here.databases();
    let (folder, database) = (databases.to_str().unwrap(), databases.join("bar.shatter"));
    let database = database.to_str().unwrap();
    let scene = here.file("scene.toml", "[objects.bar]\ndatabase = \"bar\"");
    let mesh = here.file("cube.obj", &cube());
    let (scene, mesh) = (scene.to_str().unwrap(), mesh.to_str().unwrap());
    let bake = ["bake", mesh, "--name", "cube", "--out", folder, "--crack-spacing", "0.1", "--elastic-spacing", "0.2"];
    for arguments in [&["inspect", database][..], &["check", scene, "--databases", folder], &bake] {
        check(|| command(arguments), false);
        check(|| command(&[arguments, &["--json"]].concat()), false);
    }
    for help in ["demo", "bake", "merge", "inspect", "check", "serve", "study"] {
        check(|| command(&[help, "--help"]), true);
    }
    check(|| command(&["--version"]), true);
    check_failure(|| command(&["inspect", "nowhere.shatter", "--json"]), 3);
    check_failure(|| command(&["inspect", "--json"]), 2);
    let (code, error) = full(command(&["serve"]));
    assert!(code == Some(3) && error.contains("cannot write to stdout"), "{code:?} {error}");
    assert!(Path::new(database).exists());
}

#[test]
fn a_file_whose_name_is_no_text_is_written_and_named() {
    let here = TestDirectory::new("no-text");
    here.database("bar", bar(0.06));
    let mesh = here.databases().join(OsStr::from_bytes(b"\xff.glb"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    command.arg("inspect").arg(here.databases().join("bar.shatter")).arg("--json").arg("--mesh").arg(&mesh);
    let output = command.output().unwrap();
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(output.status.success() && mesh.is_file());
    assert_eq!(document["mesh"], mesh.display().to_string());
}

/// A closed cube of 0.1 m.
fn cube() -> String {
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| (bit as f64 * 0.1).to_string()).join(" ");
    let corners: String = (0..8).map(|k| format!("v {}\n", corner(k))).collect();
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    corners + &faces.map(|face| format!("f {face}\n")).concat()
}

/// `shatterd bake … 2>&1 | head` closes stderr while the bake has warnings and more to say.
#[test]
fn a_closed_stderr_ends_no_command() {
    let here = TestDirectory::new("closed");
    let mesh = here.file("cube.obj", &cube());
    let mut bake = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut bake);
    let spacings = ["--crack-spacing", "0.1", "--elastic-spacing", "0.2"];
    bake.args(["bake", mesh.to_str().unwrap(), "--name", "cube", "--fragment-size", "5"]).args(spacings);
    bake.arg("--out").arg(here.databases()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = bake.spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// The system would otherwise end the process by SIGXFSZ, without a message.
#[test]
fn a_limit_of_the_size_of_files_is_an_error() {
    let daemon = start();
    let mesh = daemon.here.file("cube.obj", &cube());
    let out = daemon.here.databases().join("limited");
    let mut bake = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    daemon.here.aim(&mut bake);
    let spacings = ["--crack-spacing", "0.1", "--elastic-spacing", "0.2"];
    bake.args(["bake", mesh.to_str().unwrap(), "--name", "cube"]).args(spacings).arg("--out").arg(&out);
    let mut list = shatter_program(&daemon.here);
    list.arg("list");
    let unreached = "shared_memory: the daemon lives but was not reached";
    for (command, limit, reason) in [(bake, "ulimit -f 8", "File too large"), (list, "ulimit -f 100", unreached)] {
        let output = under(&[], limit, command).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code().is_some_and(|code| code > 2) && error.contains(reason),
            "{:?}: {error}",
            output.status
        );
    }
    assert_eq!(std::fs::read_dir(&out).map_or(0, Iterator::count), 0, "an incomplete file is removed");
}
