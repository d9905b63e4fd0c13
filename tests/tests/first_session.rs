//! Every example of the README and the guide, against a daemon with the object of the guide's first session.

use shatter_tests::fixture::{Fixture, program};
use shatter_tests::pages::{self, Block, blocks, crate_example, impacts, root};
use shatter_tests::peers::python;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Pages with examples, in the order in which their blocks are run.
fn pages_with_examples() -> Vec<String> {
    [vec!["README.md".to_owned()], pages::guide()].concat()
}

/// Objects that the guide bakes.
const OBJECTS: [&str; 2] = ["mug", "fine"];

/// Blocks that run elsewhere: `.ci/run` runs the demo, cargo the tests; the build exists.
const CARGO: &str = "cargo() { :; }";

/// Variables that the Rust examples of the pages use without defining them.
const SURROUNDINGS: &str = "
    use shatter_client::{Client, Contact, Convention, Deadline, Impact};
    let deadline = Deadline::after(std::time::Duration::from_secs(60));
    let service = Client::connect(\"default\", deadline)?;
    let mug = service.object(\"mug\", deadline)?;
    let (point, j_ns) = ([0.0, 0.05, 0.04], [0.0, 0.0, -2.0]);
    let there = point;
";

/// A folder like a clone, watched by git: files written there appear in `git status` unless `.gitignore` names them.
fn clone(fixture: &Fixture) -> PathBuf {
    let folder = fixture.path("clone");
    fs::create_dir_all(folder.join("target")).unwrap();
    for name in ["client", "config"] {
        symlink(root().join(name), folder.join(name)).unwrap();
    }
    symlink(program("").as_path(), folder.join("target/release")).unwrap();
    fs::copy(root().join(".gitignore"), folder.join(".gitignore")).unwrap();
    folder
}

/// Runs git there; returns its output, or `None` without git.
fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
    assert!(output.status.success(), "git {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

/// The blocks in `language` that tests run, in the order of the pages.
fn run_blocks(language: &str) -> Vec<Block> {
    let all = pages_with_examples();
    let all = all.iter().flat_map(|page| blocks(page));
    all.filter(|block| block.language == language && block.not_run.is_none()).collect()
}

/// Builds a program of the pages' Rust examples and the first example of the client's documentation.
fn rust_examples(fixture: &Fixture) -> String {
    let examples: Vec<String> = run_blocks("rust")
        .iter()
        .enumerate()
        .map(|(number, block)| {
            format!(
                "// {}\nfn example_{number}() -> Result<(), shatter_client::Error> {{{SURROUNDINGS}{}Ok(())}}\n",
                block.place, block.text
            )
        })
        .collect();
    let count = examples.len();
    assert!(count >= 5, "{examples:?}");
    let examples = examples.concat();
    let calls: String = (0..count).map(|number| format!("example_{number}()?;\n")).collect();
    let crate_example = crate_example("client/src/lib.rs", "no_run").replace("fn main()", "pub fn main()");
    let source = format!(
        "#![allow(unused)]\nmod head {{\n{crate_example}}}\n{examples}fn main() -> Result<(), shatter_client::Error> {{\nhead::main()?;\n{calls}Ok(())\n}}\n"
    );
    let (file, out) = (fixture.path("examples.rs"), fixture.path("examples"));
    fs::write(&file, source).unwrap();
    let library = program("libshatter_client.rlib");
    let mut rustc = Command::new(Path::new(env!("CARGO")).with_file_name("rustc"));
    rustc.args(["--edition", "2024", "-L"]).arg(format!("dependency={}", program("deps").display()));
    rustc.arg("--extern").arg(format!("shatter_client={}", library.display())).arg(&file).arg("-o").arg(&out);
    let built = rustc.output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    out.to_str().unwrap().to_owned()
}

/// Commands that run the Python examples, if Python has numpy.
fn python_examples(fixture: &Fixture) -> String {
    let Some(python) = python(&["numpy"]) else { return String::new() };
    let package = root().join("client/python");
    let site = fixture.path("site/shatter");
    fs::create_dir_all(&site).unwrap();
    for name in ["__init__.py", "_messages.py"] {
        fs::copy(package.join("python/shatter").join(name), site.join(name)).unwrap();
    }
    fs::copy(program("lib_shatter.so"), site.join("_shatter.abi3.so")).unwrap();
    let documented = pages::text("client/python/python/shatter/__init__.py");
    let documented: String = documented
        .split("\"\"\"")
        .nth(1)
        .unwrap()
        .lines()
        .filter_map(|line| line.strip_prefix("    "))
        .map(|line| line.to_owned() + "\n")
        .collect();
    let first = |page: &str| blocks(page).into_iter().find(|block| block.language == "python").unwrap().text;
    let (readme, guide) = (first("README.md"), first(&pages::guide()[0]));
    for (name, text) in [("readme.py", readme), ("guide.py", guide), ("documented.py", documented)] {
        assert!(text.contains("import shatter") && text.contains("write_glb"), "{text}");
        fs::write(fixture.path(name), text).unwrap();
    }
    let (python, site) = (python.to_str().unwrap().to_owned(), fixture.path("site"));
    let run = |file: &Path, more: &str| {
        format!("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='{}' '{python}' '{}' {more}\n", site.display(), file.display())
    };
    run(&fixture.path("readme.py"), "")
        + &run(&fixture.path("guide.py"), "")
        + &run(&fixture.path("documented.py"), "")
        + &run(&package.join("examples/strike.py"), "mug broken.glb")
}

/// Commands that run the README's C example, if there is a C compiler.
fn c_example(fixture: &Fixture) -> String {
    if Command::new("cc").arg("--version").output().is_err() {
        println!("skipped: README.md: no cc");
        return String::new();
    }
    let block = blocks("README.md").into_iter().find(|block| block.language == "c").unwrap();
    let source =
        format!("#include \"shatter.h\"\n#include <stdio.h>\nint main(void) {{\n{}return 0;\n}}\n", block.text);
    let (file, out) = (fixture.path("readme.c"), fixture.path("readme_c"));
    fs::write(&file, source).unwrap();
    let built = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-I"])
        .args([&root().join("client/include"), &file])
        .arg(program("libshatter.a"))
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    format!("{}\n", out.display())
}

/// True if the compilers and interpreters that a block needs exist; else prints that it is skipped.
fn can_run(block: &Block) -> bool {
    let missing = |tool: &str| {
        let missing = block.text.contains(&format!("{tool} ")) && Command::new(tool).arg("--version").output().is_err();
        if missing {
            println!("skipped: {}: no {tool}", block.place);
        }
        missing
    };
    !(missing("cc") || missing("c++") || missing("python3"))
}

/// All shell blocks, one after another, in one shell.
fn shell_blocks() -> String {
    let mut script = String::new();
    let all = pages_with_examples();
    for block in all.iter().flat_map(|page| blocks(page)).filter(|block| block.language == "sh") {
        match &block.not_run {
            Some(reason) => println!("not run: {}: {reason}", block.place),
            None if can_run(&block) => script += &format!("echo '== {}' >&2\n{}", block.place, block.text),
            None => {}
        }
    }
    script
}

/// Plain requests with every documented point and impulse, whether or not their block is run.
fn documented_impacts() -> String {
    let all: String = pages_with_examples().iter().map(|page| pages::text(page)).collect();
    let mut all = impacts(&all);
    let header = pages::text("client/include/shatter.h");
    let numbers = header.split_once("ShatterContact contact = {.point_m = {").unwrap().1.split_once("}}").unwrap().0;
    let (point, impulse) = numbers.split_once("}, .impulse_ns = {").unwrap();
    all.push([point, impulse].map(|numbers| numbers.replace(' ', "")));
    all.iter()
        .map(|[point, impulse]| format!("shatter impact mug --point {point} --impulse {impulse} --json\n"))
        .collect()
}

#[test]
fn every_example_of_the_documentation_works_on_what_the_first_session_makes() {
    let fixture = Fixture::new();
    let folder = clone(&fixture);
    let watched = git(&folder, &["init", "-q"]).is_some();
    if watched {
        git(&folder, &["add", "-A"]);
    } else {
        println!("skipped: no git, so files that the commands leave are not checked");
    }
    let before = git(&folder, &["status", "--porcelain", "--untracked-files=all"]);
    let (rust, python, c) = (rust_examples(&fixture), python_examples(&fixture), c_example(&fixture));
    let script = format!(
        "set -euo pipefail\ntrap 'kill $(jobs -p); wait' EXIT\n{CARGO}\n{}echo '== documented points' >&2\n{}\
         echo '== Rust' >&2\n{rust}\necho '== Python' >&2\n{python}echo '== C' >&2\n{c}",
        shell_blocks(),
        documented_impacts(),
    );
    let paths = std::env::join_paths(
        [program("")].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    let mut bash = fixture.foreign("bash");
    let run = bash.args(["-c", &script]).current_dir(&folder).env("PATH", paths.unwrap()).output().unwrap();
    let [output, error] = [&run.stdout, &run.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(run.status.success(), "{}:\n{output}\n{error}", run.status);
    for stated in [" left on an idle machine, ", "a daemon will hold "] {
        assert!(error.contains(stated), "`bake` says what it costs before it costs that: {error}");
    }
    assert!(output.contains("fragments 2") || output.contains("\"fragments\""), "{output}");
    assert_eq!(
        git(&folder, &["status", "--porcelain", "--untracked-files=all"]),
        before,
        "documented commands leave nothing that git sees"
    );

    let database = fixture.databases().join("mug.shatter");
    let memory = &fixture.ok("shatterd", &["inspect", database.to_str().unwrap(), "--memory"])["memory"];
    let bytes = |key: &str| memory[key].as_f64().unwrap();
    let rows: f64 = memory["rows"].as_array().unwrap().iter().map(|row| row["bytes"].as_f64().unwrap()).sum();
    assert_eq!(rows, bytes("accounted_bytes"));
    let share = rows / bytes("resident_bytes");
    assert!((share - 1.0).abs() <= 0.05, "the rows add up to {share} of the resident memory: {memory}");
    // Most of the mug's memory is its exact surface, so a factor in single precision saves less.
    assert_eq!(memory["next_saving"]["what"], "bake with --surface lattice", "{memory}");
}

/// Commands of pages name objects that the guide bakes, or the page itself, and the guide bakes all of these.
#[test]
fn documented_strikes_name_objects_that_the_guide_bakes() {
    let mut odd = Vec::new();
    for page in pages_with_examples() {
        let text = pages::text(&page);
        let is_baked = |object: &str| OBJECTS.contains(&object) || text.contains(&format!("--name {object} "));
        for block in blocks(&page) {
            for line in block.text.lines() {
                let words: Vec<&str> = line.split_whitespace().collect();
                if let ["shatter", "impact" | "threshold" | "prefracture" | "load", object, ..] = words[..]
                    && !is_baked(object)
                {
                    odd.push(format!("{}: {line}", block.place));
                }
                let asked = line.split("object(\"").skip(1).filter_map(|rest| rest.split('"').next());
                odd.extend(
                    asked.filter(|object| !OBJECTS.contains(object)).map(|_| format!("{}: {line}", block.place)),
                );
            }
        }
    }
    assert!(odd.is_empty(), "{}", odd.join("\n"));
    let guide: String = pages::guide().iter().map(|page| pages::text(page)).collect();
    assert!(guide.contains("shatterd bake --shape mug") && guide.contains("--name fine"));
}

#[test]
fn a_shape_is_baked_by_its_name_alone_or_refused_with_the_names_that_there_are() {
    let fixture = Fixture::new();
    let spacings = ["--elastic-spacing", "0.08", "--crack-spacing", "0.05"];
    let baked = fixture.ok("shatterd", &[&["bake", "--shape", "horseshoe"][..], &spacings].concat());
    assert_eq!(baked["object"], "horseshoe");
    assert!(fixture.databases().join("horseshoe.shatter").is_file());
    let named = fixture.ok("shatterd", &[&["bake", "--shape", "horseshoe", "--name", "lucky"][..], &spacings].concat());
    assert_eq!(named["object"], "lucky");
    for wrong in [&["--shape", "muug"][..], &["--shape", "mug", "mug.obj"], &["--shape", "mug", "--unit", "cm"]] {
        let refused = fixture.run("shatterd", &[&["bake"], wrong].concat());
        let error = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && error.contains("--shape"), "{wrong:?}: {error}");
    }
    let error = fixture.run("shatterd", &["bake", "--shape", "muug"]).stderr;
    let error = String::from_utf8_lossy(&error);
    assert!(error.contains("mug") && error.contains("vase"), "{error}");
}
