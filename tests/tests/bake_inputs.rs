//! Untrusted files and signals in both programs: names, numbers and texts from meshes, scenes and databases, and early ends.

use nalgebra::Point3;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use shatter_fracture::surface::RawMesh;
use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_tests::fixture::Fixture;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::Duration;

/// A small object, as options of a bake.
const COARSE: [&str; 4] = ["--elastic-spacing", "0.2", "--crack-spacing", "0.15"];

fn bake(fixture: &Fixture, mesh: &Path, more: &[&str]) -> Output {
    let own = ["bake", mesh.to_str().unwrap(), "--name", "own"];
    fixture.run("shatterd", &[&own[..], more].concat())
}

/// Starts `shatterd` with these arguments, sends `signal` once stderr contains `stage` (if empty, as soon as the process catches it), and
/// returns exit code and stderr.
fn ended(fixture: &Fixture, arguments: &[&str], stage: &str, signal: Signal) -> (Option<i32>, String) {
    let mut command = fixture.command("shatterd");
    let mut child = command.args(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut output = String::new();
    while !stage.is_empty() && !output.contains(stage) {
        assert!(lines.read_line(&mut output).unwrap() > 0, "{arguments:?} ended before {stage}: {output}");
    }
    if stage.is_empty() {
        wait_until_caught(&child, signal);
    }
    kill_process(Pid::from_child(&child), signal).unwrap();
    lines.read_to_string(&mut output).unwrap();
    (child.wait().unwrap().code(), output)
}

/// Waits until `child` has a handler for `signal`.
fn wait_until_caught(child: &Child, signal: Signal) {
    let is_caught = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(caught.trim(), 16).unwrap() >> (signal.as_raw() - 1) & 1 == 1
    };
    let mut waits = 0;
    while !is_caught() {
        assert!(waits < 3000, "no handler in half a minute");
        waits += 1;
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Files below `folder` that are incomplete or unwanted.
fn left(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.ends_with(".part") || name.starts_with('.') || name.ends_with(".shatter")).collect()
}

#[test]
fn a_signal_ends_a_bake_early_with_its_own_code_and_leaves_nothing() {
    let fixture = Fixture::new();
    let mesh = fixture.path("vase.obj");
    write_obj(&shapes::vase(), &mesh).unwrap();
    let vase = ["bake", mesh.to_str().unwrap(), "--name", "own", "--quality", "film"];
    // Its lattices are done sooner.
    let horseshoe = ["bake", "--shape", "horseshoe", "--name", "own"];
    for (arguments, stage, signal, code) in [
        (&vase[..], "", Signal::INT, 130),
        (&vase, "surface", Signal::INT, 130),
        (&vase, "volume", Signal::INT, 130),
        (&vase, "lattices", Signal::INT, 130),
        (&vase, "lattices", Signal::TERM, 143),
        (&horseshoe, "lift", Signal::INT, 130),
    ] {
        let (found, output) = ended(&fixture, arguments, stage, signal);
        assert_eq!(found, Some(code), "{stage}: {output}");
        let wanted = "shatterd: interrupted: a signal ended the command; nothing was written";
        assert_eq!(output.lines().last(), Some(wanted), "{stage}: {output}");
        assert_eq!(left(&fixture.databases()), Vec::<String>::new(), "{stage}");
    }
}

#[test]
fn a_bake_ends_with_its_standard_input_if_that_is_wanted() {
    let fixture = Fixture::new();
    let arguments = ["bake", "--shape", "vase", "--name", "own", "--quality", "film", "--end-with-stdin"];
    let mut command = fixture.command("shatterd");
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut output = String::new();
    while !output.contains("volume") {
        assert!(lines.read_line(&mut output).unwrap() > 0, "the bake ended too early: {output}");
    }
    drop(child.stdin.take());
    lines.read_to_string(&mut output).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143), "{output}");
    assert_eq!(left(&fixture.databases()), Vec::<String>::new());
}

#[test]
fn a_signal_ends_every_command_and_leaves_no_half_file() {
    let fixture = Fixture::new();
    let out = fixture.path("out");
    let [out, databases] = [&out, &fixture.databases()].map(|path| path.to_str().unwrap().to_owned());
    let demo = ["demo", "--out", &out, "--databases", &databases];
    let study = ["study", "effects", "--out", &out];
    let scene = fixture.path("scene.toml");
    std::fs::write(&scene, "[objects.vase]\nshape = \"vase\"\nmaterial = \"glass\"\n").unwrap();
    let scene = ["bake", "--scene", scene.to_str().unwrap()];
    for (arguments, stage, signal, code) in [
        (&demo[..], "shatterd: bake: surface\n", Signal::INT, 130),
        (&demo[..], "", Signal::TERM, 143),
        (&study[..], "", Signal::INT, 130),
        (&study[..], "", Signal::TERM, 143),
        (&scene[..], "", Signal::TERM, 143),
    ] {
        let (found, output) = ended(&fixture, arguments, stage, signal);
        assert_eq!(found, Some(code), "{arguments:?}: {output}");
        assert_eq!(left(&fixture.databases()), Vec::<String>::new());
        assert_eq!(left(Path::new(&out)), Vec::<String>::new());
    }
    let (code, document) = {
        let mut child = fixture.command("shatterd");
        let child = child.args(study).arg("--json").stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        wait_until_caught(&child, Signal::INT);
        kill_process(Pid::from_child(&child), Signal::INT).unwrap();
        let output = child.wait_with_output().unwrap();
        (output.status.code(), serde_json::from_slice::<Value>(&output.stdout).unwrap())
    };
    assert_eq!((code, &document["error"]["kind"]), (Some(130), &Value::from("interrupted")));
}

/// Checks that neither stderr nor the message of `output` has much text or a control character, except the ends of the program's lines.
#[track_caller]
fn check_texts(output: &Output, what: &str) -> String {
    assert_eq!(output.status.code(), Some(3), "{what}: {}", String::from_utf8_lossy(&output.stderr));
    let stderr = String::from_utf8(output.stderr.clone()).unwrap();
    let hidden = |c: char| c.is_control() || c == '\u{202e}';
    // A line that begins with a file name would look like a line of the program.
    let begins = |line: &str| ["shatterd: ", "warning: "].into_iter().any(|own| line.starts_with(own));
    let own = |line: &str| begins(line) && !line.starts_with("shatterd: all is well");
    assert!(!stderr.chars().any(|c| hidden(c) && c != '\n') && stderr.lines().all(own), "{what}: {stderr:?}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let message = document["error"]["message"].as_str().unwrap().to_owned();
    assert!(
        !message.chars().any(hidden) && !document["error"]["at"].as_str().unwrap().chars().any(hidden),
        "{message:?}"
    );
    assert!(message.chars().count() < 1000 && stderr.len() < 5000, "{what}: {} bytes", stderr.len());
    message
}

#[test]
fn texts_of_files_reach_terminal_and_documents_escaped_and_cut() {
    let fixture = Fixture::new();
    let long = "x".repeat(5_000_000);
    let evil = "a\u{1b}]0;title\u{7}\u{1b}[2J\nshatterd: all is well\u{202e}\u{9b}31m.obj";
    for (name, text) in [
        ("long.obj", format!("v 0 0 {long}\n")),
        ("escape.obj", "v 0 0 \u{1b}[31mred\u{7}\n".to_owned()),
        (evil, "v 1 2\n".to_owned()),
        (
            "bad.gltf",
            format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"../\u001b[31m{long}","byteLength":4}}]}}"#),
        ),
        ("bad.ply", format!("ply\nformat ascii 1.0\nelement \u{1b}[31m{long} 9\nend_header\n")),
    ] {
        let file = fixture.path(name);
        std::fs::write(&file, text).unwrap();
        check_texts(&bake(&fixture, &file, &["--json"]), name);
    }
    let mesh = fixture.path("cube.obj");
    write_obj(&shapes::cuboid([1.0; 3]), &mesh).unwrap();
    for text in [format!("x = \u{1b}[31m{long}"), format!("{long} = 1\n"), format!("[a]\nyoung_pa = \"{long}\"\n")] {
        let table = fixture.path("materials\u{1b}[1m.toml");
        std::fs::write(&table, &text).unwrap();
        check_texts(&bake(&fixture, &mesh, &["--materials", table.to_str().unwrap(), "--json"]), "materials");
        let scene = fixture.path("scene\n.toml");
        std::fs::write(&scene, &text).unwrap();
        check_texts(&fixture.run("shatterd", &["check", scene.to_str().unwrap(), "--json"]), "scene");
        check_texts(&fixture.run("shatterd", &["inspect", scene.to_str().unwrap(), "--json"]), "database");
    }
}

#[test]
fn a_name_in_a_log_starts_no_line_of_its_own() {
    let mut fixture = Fixture::new();
    std::fs::create_dir_all(fixture.databases()).unwrap();
    std::fs::write(fixture.databases().join("a\u{1b}[31m\nERROR all is lost.shatter"), "spoilt").unwrap();
    let mut command = fixture.command("shatterd");
    let mut child =
        command.args(["serve", "--service", "log"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.is_ok_and(|line| line == "ready")));
    kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
    let output = child.wait_with_output().unwrap();
    let log = String::from_utf8(output.stderr).unwrap();
    assert!(log.contains("all is lost"), "{log}");
    assert!(
        !log.chars().any(|c| c.is_control() && c != '\n') && !log.lines().any(|line| line.starts_with("ERROR")),
        "{log:?}"
    );
    fixture.end();
}

#[test]
fn messages_say_what_is_wrong_and_what_to_do() {
    let fixture = Fixture::new();
    let output = |name: &str, text: &str, more: &[&str]| {
        let file = fixture.path(name);
        std::fs::write(&file, text).unwrap();
        check_texts(&bake(&fixture, &file, &[more, &["--json"]].concat()), name)
    };
    let empty = output("empty.obj", "# nothing\n", &[]);
    assert!(empty.contains("empty.obj"), "{empty}");
    let flat = output("flat.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n", &[]);
    assert!(
        flat.contains("flat.obj") && flat.contains("flat and encloses no volume") && flat.contains("2.000e0"),
        "{flat}"
    );
    let needle = fixture.path("needle.obj");
    write_obj(&shapes::cuboid([1000.0, 1.0, 1.0]), &needle).unwrap();
    let needle = check_texts(&bake(&fixture, &needle, &["--unit", "m", "--json"]), "needle");
    assert!(needle.contains("a needle, thin in two directions") && needle.contains("1000 times as long"), "{needle}");
    let numbers = output("nan.obj", "# it\nv 0 0 0\nv 2 nan 0\nv 2 1 0\nf 1 2 3\n", &[]);
    assert!(numbers.contains("nan.obj: vertex 1, counted from 0, in line 3 has"), "{numbers}");
    let cube = fixture.path("cube.obj");
    write_obj(&shapes::cuboid([1.0; 3]), &cube).unwrap();
    for (options, wanted) in [
        (
            ["--elastic-spacing", "7"],
            "elastic spacing 7 is outside 0.002 to 0.25 of the bounding-box diagonal; set --elastic-spacing from 0.002 to 0.25",
        ),
        (["--crack-spacing", "7"], "crack spacing 7 is outside 0.002 to 0.25"),
        (["--elastic-spacing", "0.002"], "or more; set it with --elastic-spacing"),
        (["--gamma", "-1"], "--gamma is -1; it must be a finite number above 0"),
    ] {
        let spacing = bake(&fixture, &cube, &[&options[..], &["--json"]].concat());
        let document: Value = serde_json::from_slice(&spacing.stdout).unwrap();
        assert_eq!(document["error"]["at"], options[0]);
        let message = check_texts(&spacing, options[0]);
        assert!(message.contains(wanted), "{message}");
    }
    let far = fixture.path("far.obj");
    write_obj(&shapes::arch(), &far).unwrap();
    let text = std::fs::read_to_string(&far).unwrap();
    let vertices = text.lines().filter(|line| line.starts_with("v ")).count();
    let far = output("far.obj", &format!("{text}v 5e5 0 0\nf 1 2 {}\n", vertices + 1), &[]);
    assert!(far.contains(&format!("vertex {vertices} at (500000, 0, 0)")), "{far}");
    let scene = fixture.path("scene.toml");
    std::fs::write(&scene, "[objects.vase]\ngravity = [0.0, -9.81, 0.0]\n").unwrap();
    let scene = check_texts(&fixture.run("shatterd", &["check", scene.to_str().unwrap(), "--json"]), "scene");
    assert!(scene.contains("`gravity_m_s2`"), "{scene}");
}

#[test]
fn sizes_defects_and_files_are_told_and_databases_found_by_name() {
    let fixture = Fixture::new();
    let mesh = fixture.path("bust.obj");
    write_obj(&shapes::cuboid([300.0, 658.0, 200.0]), &mesh).unwrap();
    // A duplicate triangle is a defect.
    let text = std::fs::read_to_string(&mesh).unwrap();
    let face = text.lines().find(|line| line.starts_with("f ")).unwrap();
    std::fs::write(&mesh, format!("{text}{face}\n")).unwrap();
    let folder = fixture.path("new/er");
    let more = [&COARSE[..], &["--out", folder.to_str().unwrap()]].concat();
    let output = bake(&fixture, &mesh, &[&more[..], &["--json"]].concat());
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("warning: the mesh is 658 m large") && stderr.contains("--unit mm"), "{stderr}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(document["warnings"][0].as_str().unwrap().contains("with --unit mm it would be 0.658 m"), "{document}");
    assert_eq!(document["defects"][0]["counted"], "1 triangle");
    let file = document["file"].as_str().unwrap();
    assert!(Path::new(file).is_file());
    let again = |own: &[&str]| String::from_utf8(bake(&fixture, &mesh, &[own, &more].concat()).stderr).unwrap();
    assert!(!again(&[]).contains("will be replaced"));
    let replaced = again(&["--unit", "mm", "--fragment-size", "5"]);
    let begun = replaced.find("surface: weld").unwrap();
    for early in ["warning: the database of `", "warning: fragments of 5 m"] {
        assert!(replaced.find(early).is_some_and(|place| place < begun), "{early} comes late: {replaced}");
    }
    assert!(replaced.contains("another --name"), "{replaced}");
    assert!(!again(&["--unit", "mm"]).contains("will be replaced"));

    let databases = folder.to_str().unwrap();
    let found = fixture.ok("shatterd", &["inspect", "own", "--databases", databases]);
    assert_eq!((&found["object"], found["file"].as_str()), (&Value::from("own"), Some(file)));
    let output = fixture.run("shatterd", &["inspect", "owm", "--databases", databases, "--json"]);
    assert!(check_texts(&output, "owm").contains("`own`"));
    let intact = fixture.path("a/new/folder/own.obj");
    let arguments = ["inspect", file, "--mesh", intact.to_str().unwrap()];
    let output = fixture.run("shatterd", &arguments);
    assert!(output.status.success() && intact.is_file());
    assert!(String::from_utf8(output.stderr).unwrap().contains(&format!("wrote {}", intact.display())));
}

/// Films and hidden triangles above a twentieth of the surface.
#[test]
fn large_repairs_of_the_surface_are_warned_of() {
    let fixture = Fixture::new();
    let mesh = fixture.path("own.obj");
    let warned = |raw: &RawMesh| {
        write_obj(raw, &mesh).unwrap();
        let baked = bake(&fixture, &mesh, &COARSE);
        let shown = fixture.run("shatterd", &["inspect", "own", "--json"]);
        let [baked_lines, shown_lines] = [&baked, &shown].map(|output| {
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{text}");
            let lines = text.lines().filter(|line| line.starts_with("warning: ") && line.contains(" % of the "));
            lines.map(str::to_owned).collect::<Vec<_>>()
        });
        assert_eq!(baked_lines, shown_lines);
        let document: Value = serde_json::from_slice(&shown.stdout).unwrap();
        assert_eq!(document["warnings"].as_array().unwrap().len(), shown_lines.len(), "{document}");
        shown_lines.join("\n")
    };
    let cube = |size: f64| shapes::cuboid([size; 3]);
    let mut open = cube(1.0);
    open.triangles.truncate(10);
    let open = warned(&open);
    let wanted = ["17 % of the exact surface are films that close", "hole", "`shatterd inspect own --mesh FILE.glb`"];
    assert!(wanted.iter().all(|part| open.contains(part)), "{open}");
    let mut small = shapes::sphere(0.5, 3);
    small.triangles.pop();
    assert_eq!(warned(&small), "", "a small film");
    // A ball across a side of a cube: half of its triangles are inside.
    let mut crossing = cube(1.0);
    let (first, inner) = (crossing.positions_m.len() as u32, shapes::sphere(0.3, 3));
    let moved = inner.positions_m.iter().map(|point| Point3::new(point.x + 0.51, point.y + 0.01, point.z + 0.02));
    crossing.positions_m.extend(moved);
    crossing.triangles.extend(inner.triangles.iter().map(|own| own.map(|vertex| vertex + first)));
    let crossing = warned(&crossing);
    let wanted = ["inside the solid, ", " % of the mesh's area, left out", "--mesh FILE.glb`"];
    assert!(wanted.iter().all(|part| crossing.contains(part)), "{crossing}");
}

#[test]
fn a_preset_that_severs_is_refused_unless_it_is_named() {
    let fixture = Fixture::new();
    let mesh = fixture.path("limbs.obj");
    write_obj(&limbs(), &mesh).unwrap();
    let output = check_texts(&bake(&fixture, &mesh, &["--json"]), "game by default");
    assert!(output.contains("preset `game` severs 1 part"), "{output}");
    assert!(
        output.contains(
            "no preset and no --crack-spacing is sure to hold a joint of 3.000e-2 m: try finer ones, thicken it to"
        ) && output.contains("an explicit --quality"),
        "{output}"
    );
    assert!(!fixture.databases().join("own.shatter").exists());
    let draft = bake(&fixture, &mesh, &["--quality", "draft", "--json"]);
    assert_eq!(draft.status.code(), Some(0), "{}", String::from_utf8_lossy(&draft.stderr));
    let document: Value = serde_json::from_slice(&draft.stdout).unwrap();
    let warnings = document["warnings"].to_string();
    assert!(warnings.contains("severs") && warnings.contains("m³") && warnings.contains("thicken it to"), "{warnings}");
    assert!(String::from_utf8_lossy(&draft.stderr).contains("warning: the lattice (preset `draft`) severs"));
}

/// Two blocks of 1 m joined by a rod that is too thin for coarse lattices, in one shell.
fn limbs() -> RawMesh {
    let rings = [(0.0, 0.5), (1.0, 0.5), (1.0, ROD), (2.0, ROD), (2.0, 0.5), (3.0, 0.5)];
    let corners = |(x, half): (f64, f64)| {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[y, z]| Point3::new(x, y * half, z * half))
    };
    let side = |k: u32| [0, 1, 2, 3].map(|c| [4 * k + c, 4 * k + (c + 1) % 4, 4 * k + 4 + (c + 1) % 4, 4 * k + 4 + c]);
    let quads = (0..5).flat_map(side).chain([[3, 2, 1, 0], [20, 21, 22, 23]]);
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    RawMesh::new(rings.into_iter().flat_map(corners).collect(), quads.flat_map(halves).collect())
}

/// Half the thickness of the rod, m.
const ROD: f64 = 0.015;
