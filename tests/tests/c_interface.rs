//! Programs in C and C++, built by the system's compilers as a user builds them, against a real daemon.

use shatter_fracture::surface::shapes::{self, write_obj};
use shatter_tests::fixture::{Fixture, program};
use shatter_tests::glb;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const C: [&str; 6] = ["-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror"];
const CXX: [&str; 6] = ["-std=c++17", "-O1", "-g", "-Wall", "-Wextra", "-Werror"];

/// The middle of an end of the bar, and an impulse against it.
const IMPACT_ARGUMENTS: [&str; 2] = ["0.2,0.01,0.02", "-50,3,0"];

/// A test folder with a small bar, and the daemon running.
fn with_bar() -> Fixture {
    let mut fixture = Fixture::new();
    let mesh = fixture.path("bar.obj");
    write_obj(&shapes::cuboid([0.4, 0.2, 0.2]), &mesh).unwrap();
    fixture.bake_once(&mesh, "bar", &["--material", "glass", "--crack-spacing", "0.04", "--elastic-spacing", "0.1"]);
    fixture.serve(&[]);
    fixture
}

fn client(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../client").join(name)
}

/// Way of linking the library.
#[derive(Clone, Copy, PartialEq)]
enum Linked {
    Shared,
    Static,
}

/// Runs `compiler` as the guide does, with additional flags.
fn compile(compiler: &str, flags: &[&str], source: &Path, linked: Linked, out: &Path) -> std::io::Result<Output> {
    let library = program("libshatter.so");
    let folder = library.parent().unwrap();
    let mut command = Command::new(compiler);
    command.args(flags).arg("-pedantic").arg("-I").arg(client("include")).arg(source).arg("-o").arg(out);
    match linked {
        Linked::Shared => {
            command.arg("-L").arg(folder).args(["-lshatter", "-Wl,-rpath"]);
            command.arg(format!("-Wl,{}", folder.display()));
        }
        Linked::Static => {
            command.arg(folder.join("libshatter.a")).args(["-lpthread", "-ldl"]);
        }
    }
    command.arg("-lm").output()
}

/// Builds a program into the test folder.
#[track_caller]
fn build(fixture: &Fixture, name: &str, source: &str, flags: &[&str], linked: Linked) -> String {
    let (out, source) = (fixture.path(name), client("c").join(source));
    let compiler = if source.extension().unwrap() == "cpp" { "c++" } else { "cc" };
    let built = compile(compiler, flags, &source, linked, &out).unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    out.to_str().unwrap().to_owned()
}

/// True if `compiler` exists and builds a program with these flags; else prints that the test is skipped.
fn can(fixture: &Fixture, compiler: &str, flags: &[&str]) -> bool {
    let source = fixture.path(if compiler == "c++" { "empty.cpp" } else { "empty.c" });
    std::fs::write(&source, "int main(void) { return 0; }\n").unwrap();
    let built = Command::new(compiler).args(flags).arg(&source).arg("-o").arg(fixture.path("empty")).output();
    let can = built.is_ok_and(|built| built.status.success());
    if !can {
        println!("skipped: no {compiler} that takes {flags:?}");
    }
    can
}

/// Runs a program to its end; returns exit code, "key value" lines, stderr.
fn run(fixture: &Fixture, words: &[&str]) -> (Option<i32>, BTreeMap<String, String>, String) {
    let out = fixture.run(words[0], &words[1..]);
    let text = String::from_utf8(out.stdout).unwrap();
    let pairs = text.lines().filter_map(|line| line.split_once(' '));
    let pairs = pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    (out.status.code(), pairs, String::from_utf8_lossy(&out.stderr).into_owned())
}

#[track_caller]
fn number(output: &BTreeMap<String, String>, key: &str) -> f64 {
    output.get(key).and_then(|value| value.parse().ok()).unwrap_or_else(|| panic!("{key} in {output:?}"))
}

#[track_caller]
fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a / b - 1.0).abs() < tolerance, "{a} and {b}: {:.1e} apart", a / b - 1.0);
}

#[test]
fn a_c_program_gets_the_same_result_as_the_command_line() {
    let mut fixture = with_bar();
    let strike = build(&fixture, "strike", "examples/strike.c", &C, Linked::Shared);
    let file = fixture.path("bar.glb");
    let words =
        [strike.as_str(), "default", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "24", file.to_str().unwrap()];
    let (code, output, error) = run(&fixture, &words);
    assert_eq!(code, Some(0), "{error}");
    let fragments = number(&output, "fragments");
    assert!(fragments >= 24.0 && number(&output, "closed") == fragments && number(&output, "crack_faces") > 0.0);
    let listed = fixture.ok("shatter", &["list"]);
    near(number(&output, "volume_m3"), listed["objects"][0]["volume_m3"].as_f64().unwrap(), 1e-9);
    near(number(&output, "meshes_m3"), number(&output, "volume_m3"), 1e-6);
    let arguments =
        ["impact", "bar", "--point", IMPACT_ARGUMENTS[0], "--impulse", IMPACT_ARGUMENTS[1], "--degree", "24"];
    let document = fixture.ok("shatter", &arguments);
    assert_eq!(document["output_hash"].as_str(), output.get("hash").map(String::as_str));
    let read = glb::read(&file).unwrap();
    assert_eq!(read.len() as f64, fragments);
    read.iter().for_each(|fragment| fragment.check_closed().unwrap());

    let still = build(&fixture, "still", "examples/strike.c", &C, Linked::Static);
    let (code, other, error) = run(&fixture, &[&[still.as_str()], &words[1..6]].concat());
    assert_eq!((code, other.get("hash")), (Some(0), output.get("hash")), "{error}");

    let refused = |words: &[&str], exit: i32, name: &str| {
        let (code, output, error) = run(&fixture, words);
        assert!(code == Some(exit) && error.contains(name) && output.is_empty(), "{code:?}: {error}");
    };
    refused(&[&strike, "default", "pot", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "24"], 3, "unknown_object");
    refused(&[&strike, "default", "bar", "9,9,9", IMPACT_ARGUMENTS[1], "24"], 3, "contact_too_far");
    refused(&[&strike, "a b", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "24"], 3, "service_name");
    refused(&[&strike, "other", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "24"], 4, "no_daemon");
    assert_eq!(fixture.end(), Some(0));
    let (code, _, error) = run(&fixture, &words);
    assert!(
        code == Some(4) && error.contains("no_daemon") && error.contains("may be tried again"),
        "{code:?}: {error}"
    );
}

/// An impact in the coordinates of a host gives the same contact and the same fragments as in the default ones; so does an even division.
#[test]
fn a_host_works_in_its_own_coordinates() {
    let fixture = with_bar();
    let host = build(&fixture, "host", "examples/host.c", &C, Linked::Shared);
    let output = |convention: &str, impact_arguments: [&str; 3]| {
        let (code, output, error) =
            run(&fixture, &[&[&host, "default", "bar", convention][..], &impact_arguments].concat());
        assert_eq!(code, Some(0), "{convention}: {error}");
        output
    };
    let ours = output("gltf", [IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "4"]);
    assert!(number(&ours, "struck_fragments") > 1.0 && number(&ours, "even_fragments") >= 12.0, "{ours:?}");
    near(number(&ours, "even_mass_kg"), number(&ours, "struck_mass_kg"), 1e-9);
    // A steel ball of 18 mm at 4 m/s, by hand: E* of steel and glass, m* of both masses; Johnson, section 11.4.
    let (glass, steel) = ((1.0 - 0.23_f64.powi(2)) / 70e9, (1.0 - 0.09) / 210e9);
    let (modulus_pa, radius_m) = (1.0 / (glass + steel), 1.0 / (1.0 / 0.018 + 1.0 / (0.5 * 0.24_f64.sqrt())));
    let mass_kg = 1.0 / (1.0 / 0.2 + 1.0 / number(&ours, "struck_mass_kg"));
    let duration_s = 2.87 * (mass_kg * mass_kg / (radius_m * modulus_pa * modulus_pa * 4.0)).powf(0.2);
    near(number(&ours, "duration_s"), duration_s, 0.05);
    for (convention, impact_arguments) in [
        ("unreal", ["20,2,1", "-5000,0,300", "400"]),
        ("unity", ["-0.2,0.01,0.02", "50,3,0", "4"]),
        ("blender", ["0.2,-0.02,0.01", "-50,0,3", "4"]),
        ("godot", [IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "4"]),
    ] {
        let other = output(convention, impact_arguments);
        for (key, tolerance) in
            [("contact_m", 1e-12), ("duration_s", 1e-12), ("struck_mass_kg", 1e-9), ("even_mass_kg", 1e-9)]
        {
            near(number(&other, key), number(&ours, key), tolerance);
        }
        for key in ["struck_fragments", "even_fragments"] {
            assert_eq!(other.get(key), ours.get(key), "{convention}");
        }
    }
    let (code, _, error) =
        run(&fixture, &[&host, "default", "bar", "maya", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "4"]);
    assert!(code == Some(3) && error.contains("convention"), "{error}");
}

#[test]
fn a_cpp_program_breaks_a_piece_again() {
    let fixture = with_bar();
    if !can(&fixture, "c++", &CXX) {
        return;
    }
    let again = build(&fixture, "again", "examples/restrike.cpp", &CXX, Linked::Shared);
    let (code, output, error) =
        run(&fixture, &[&again, "default", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "6"]);
    assert_eq!(code, Some(0), "{error}");
    for (name, least) in [("first", 6.0), ("second", 4.0)] {
        let count = number(&output, &format!("{name}_fragments"));
        assert!(count >= least, "{output:?}");
        for all in ["closed", "hulls"] {
            assert_eq!(number(&output, &format!("{name}_{all}")), count, "{output:?}");
        }
        assert!(number(&output, &format!("{name}_bonds")) >= count - 1.0, "{output:?}");
    }
    near(number(&output, "children_volume_m3"), number(&output, "parent_volume_m3"), 1e-9);
    assert_eq!(output.get("released_twice").map(String::as_str), Some("unknown_handle"));
    let (code, _, error) = run(&fixture, &[&again, "other", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "6"]);
    assert!(code == Some(4) && error.contains("no_daemon"), "{code:?}: {error}");
}

#[test]
fn c_misuse_is_rejected_without_sanitizer_reports() {
    let fixture = with_bar();
    let misuse = build(&fixture, "misuse", "tests/misuse.c", &C, Linked::Shared);
    let (code, _, error) = run(&fixture, &[&misuse, "default", "bar", IMPACT_ARGUMENTS[0]]);
    assert_eq!((code, error.as_str()), (Some(0), ""));
    let watched = [&C[..], &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]].concat();
    if !can(&fixture, "cc", &watched) {
        return;
    }
    let misuse = build(&fixture, "watched_misuse", "tests/misuse.c", &watched, Linked::Shared);
    let (code, _, error) = run(&fixture, &[&misuse, "default", "bar", IMPACT_ARGUMENTS[0]]);
    assert_eq!((code, error.as_str()), (Some(0), ""));
    for (linked, name) in [(Linked::Shared, "shared"), (Linked::Static, "static")] {
        let strike = build(&fixture, name, "examples/strike.c", &watched, linked);
        let (code, output, error) =
            run(&fixture, &[&strike, "default", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "24"]);
        assert_eq!((code, error.as_str()), (Some(0), ""), "{name}: {output:?}");
    }
}

/// `cargo test --release --workspace --test suite c_interface:: -- --ignored`: a minute, with Valgrind.
#[test]
#[ignore = "needs Valgrind"]
fn valgrind_finds_nothing() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("skipped: no valgrind");
        return;
    }
    let fixture = with_bar();
    let strike = build(&fixture, "strike", "examples/strike.c", &C, Linked::Shared);
    let misuse = build(&fixture, "misuse", "tests/misuse.c", &C, Linked::Shared);
    let check = ["--quiet", "--error-exitcode=99", "--leak-check=full", "--errors-for-leak-kinds=definite"];
    for words in [
        &[&strike, "default", "bar", IMPACT_ARGUMENTS[0], IMPACT_ARGUMENTS[1], "24"][..],
        &[&misuse, "default", "bar", IMPACT_ARGUMENTS[0]],
    ] {
        let valgrind = Path::new("/usr/bin/env").to_str().unwrap();
        let (code, output, error) = run(&fixture, &[&[valgrind, "valgrind"], &check[..], words].concat());
        assert!(code == Some(0), "{code:?} {output:?}: {error}");
    }
}
