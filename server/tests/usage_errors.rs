//! Mistakes of first-time users of the programs: each message by itself names the remedy.

mod support;

use shatter_cli_common::COMMANDS;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use support::{InProcess, TestDirectory, bar, shatter_program, under};

fn shatterd(here: &TestDirectory) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    command
}

/// Runs `words`, the program first; returns exit code, stdout and stderr.
fn run(here: &TestDirectory, words: &[&str]) -> (i32, String, String) {
    let mut command = if words[0] == "shatter" { shatter_program(here) } else { shatterd(here) };
    let output = command.args(&words[1..]).stdin(Stdio::null()).output().unwrap();
    let [out, error] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    (output.status.code().unwrap(), out, error)
}

#[track_caller]
fn check(here: &TestDirectory, line: &str, wanted: (i32, &str)) {
    let words: Vec<&str> = line.split(' ').collect();
    let (code, _, error) = run(here, &words);
    assert!(code == wanted.0 && error.contains(wanted.1), "$ {line}\n{error}-> {code}");
    if code == 2 {
        let called = words.iter().take_while(|word| word.chars().all(|c| c.is_ascii_lowercase())).count();
        let used = words[..called.min(2)].join(" ");
        let known = COMMANDS.iter().any(|(program, own)| words[0] == *program && own.contains(&words[1]));
        let used = if known { used.as_str() } else { words[0] };
        assert!(error.contains(&format!("\nUsage: {used} ")), "$ {line}\n{error}");
        assert!(error.contains(&format!("try '{used} --help'")), "$ {line}\n{error}");
    }
}

#[test]
fn the_tables_of_commands_are_those_of_the_programs() {
    let here = TestDirectory::new("tables");
    for (program, wanted) in COMMANDS {
        let (_, help, _) = run(&here, &[program, "--help"]);
        let rows = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
        let found: Vec<&str> =
            rows.filter_map(|row| row.split_whitespace().next()).filter(|name| *name != "help").collect();
        assert_eq!(found, wanted, "{program}");
    }
}

#[test]
fn unknown_commands_and_options_suggest_existing_ones() {
    let here = TestDirectory::new("words");
    for (line, wanted) in [
        ("shatter strike", "did you mean `shatter impact`?"),
        ("shatter hit mug", "did you mean `shatter impact`?"),
        ("shatter LIST", "did you mean `shatter list`?"),
        ("shatter --impact", "did you mean `shatter impact`?"),
        ("shatter help strike", "did you mean `shatter impact`?"),
        ("shatter bake", "did you mean `shatterd bake`?"),
        ("shatter serve", "did you mean `shatterd serve`?"),
        ("shatter start", "did you mean `shatterd serve`?"),
        ("shatter mug", "shatter list|status|impact"),
        ("shatterd impact", "did you mean `shatter impact`?"),
        ("shatterd threshold --impulse 1", "did you mean `shatter threshold`?"),
        ("shatterd status", "did you mean `shatter status`?"),
        ("shatterd stop", "SIGTERM"),
        ("shatter threshold mug --point 0,0,0 --impulse 1", "'--direction'"),
        ("shatter threshold --impulse 1", "'--direction'"),
        ("shatter impact mug --point 0,0,0 --direction 1,0,0", "'--impulse'"),
        ("shatter impact mug --position 0,0,0", "'--point'"),
        ("shatter impact mug -o x.glb", "'--out'"),
        ("shatter impact mug --wrong", "the options of `shatter impact` are --point, --ray"),
        ("shatter impact mug --point (0,0,0) --impulse 1,0,0", "write numbers and commas alone"),
        ("shatter impact mug --point 0,0,0 --impulse 1,0,0 --seed x", "must be a whole number"),
        ("shatter threshold mug --ray 0,0,0,0,0,0", "--ray: the direction DX,DY,DZ of the ray is zero"),
        ("shatter impact mug --point 0,0,05 --impulse 1,0,0", "`05` is ambiguous; write 0.5"),
        ("shatter impact mug --point 0,nan,0 --impulse 1,0,0", "`nan` is not finite"),
        (
            "shatter impact mug --point 0,0,0 --impulse 1,0,0 --deadline-ms 0",
            "must be a whole number of milliseconds, 1 to 18446744073709551615",
        ),
        ("shatter impact mug --point 0,0,0 --impulse 1,0,0 --seed=-1", "a whole number, 0 to 18446744073709551615"),
        ("shatter impact mug --point 0,0,0 --impulse 1,0,0 --degree=-1", "a whole number, 1 to 512"),
        ("shatter view --port=-1", "'--port <N>': must be a whole number, 0 to 65535"),
        ("shatter load --closed --clients 0", "must be a whole number, 1 to 256"),
        ("shatter load --closed --degree 513", "must be a whole number, 1 to 512"),
        ("shatterd bake --shape mug --examples=-1", "'--examples <K>': must be a whole number, 0 to 1048576"),
        ("shatterd bake --shape mug --examples 1048577", "must be a whole number, 0 to 1048576"),
        ("shatterd bake --shape mug --add 99999999999999999999", "must be a whole number, 0 to 1048576"),
        ("shatterd bake --shape mug --seed=-1", "must be a whole number, 0 to 18446744073709551615"),
        ("shatterd serve --threads=-1", "must be a whole number, 0 to 1024"),
        ("shatterd serve --threads 1025", "must be a whole number, 0 to 1024"),
        ("shatter impact mug --enable hulls bonds", "a list is one word: names with commas"),
        ("shatter impact", "`shatter list` shows the names of the objects"),
        ("shatter list mug", "`shatter list` takes only options"),
        ("shatterd bake spot.obj", "--name vase"),
        ("shatterd bake --name x", "--shape SHAPE"),
        ("shatterd bake", "--shape SHAPE"),
        ("shatterd bake x.obj --name x --quality good", "must be one of `draft`"),
        ("shatterd serve --port 80", "the options of `shatterd serve` are"),
        ("shatterd inspect mug --outt x", "'--out'"),
    ] {
        check(&here, line, (2, wanted));
    }
    check(&here, "shatterd study foo", (2, "the commands of `shatterd study` are stability, effects, paper, accuracy"));
}

#[test]
fn files_of_another_kind_are_named_with_what_to_do() {
    let here = TestDirectory::new("files");
    here.database("mug", "not a database");
    let spot = here.file("spot.obj", "v 0 0 0\n");
    let scene = here.file("scene.toml", "[objects.mugg]\n");
    let [spot, scene, folder] = [spot.as_path(), &scene, &here.databases()].map(|path| path.display().to_string());
    for line in ["inspect", "check", "serve --config", "serve --scene", "bake --scene"] {
        check(&here, &format!("shatterd {line} {spot}"), (3, "has the extension of a mesh"));
    }
    check(&here, &format!("shatterd merge {spot} --out {folder}"), (3, &format!("shatterd bake {spot} --name NAME")));
    check(&here, &format!("shatterd bake {folder} --name x"), (3, "is a folder, not a mesh"));
    check(&here, &format!("shatterd bake {scene} --name x"), (3, "shatterd check"));
    check(&here, &format!("shatterd bake {folder}/mug.shatter --name x"), (3, "has the extension of a database"));
    check(&here, &format!("shatterd bake {} --name x", spot.trim_end_matches(".obj")), (3, "spot.obj?"));
    let misspelled = spot.replace("spot.obj", "spott.obj");
    check(&here, &format!("shatterd bake {misspelled}"), (2, &format!("does not exist; did you mean {spot}?")));
    check(&here, &format!("shatterd bake {spot} --name x --out {spot}"), (3, "is a file, not a folder"));
    check(&here, "shatterd check mug", (3, "`mug` is the name of an object, and this command takes a scene"));
    let elsewhere = run(&here, &["shatter", "list"]).2;
    let folder_choice = "(the folder that XDG_RUNTIME_DIR names; it must be the same for the daemon)";
    assert!(elsewhere.contains(folder_choice), "{elsewhere}");
    check(&here, &format!("shatterd inspect {folder}"), (3, "mug.shatter"));
    check(&here, &format!("shatterd serve --scene {scene}"), (3, "did you mean `mug`?"));
    let (code, plan, error) = run(&here, &["shatterd", "check", &scene]);
    assert!(code == 0 && plan.contains("not baked yet; did you mean the database `mug`?"), "{plan}");
    assert!(plan.contains("needed") && !plan.contains("loaded"), "tables of a file that does not exist: {plan}");
    assert!(error.contains("warning: object `mugg` has no database") && error.contains("`mug`?"), "{error}");
}

#[test]
fn long_words_are_cut_in_every_message() {
    let here = TestDirectory::new("long");
    here.database("bar", bar(0.06));
    let daemon = InProcess::start_with(here, "", shatter_engine::wire::loader(None));
    let here = &daemon.here;
    let mesh = here.file("spot.obj", "v 0 0 0\n").display().to_string();
    let long = "x".repeat(100_000);
    for (words, wanted) in [
        (vec!["shatter", "impact", &long, "--point", "0,0,0", "--impulse", "1,0,0"], 3),
        (vec!["shatter", "list", "--service", &long], 3),
        (vec!["shatter", &long], 2),
        (vec!["shatter", "impact", "bar", "--enable", &long], 2),
        (vec!["shatter", "impact", "bar", "--point", &long], 2),
        (vec!["shatterd", "inspect", &long], 3),
        (vec!["shatterd", "bake", "--shape", "mug", "--name", &long], 3),
        (vec!["shatterd", "bake", &mesh, "--name", "x", "--material", &long], 3),
        (vec!["shatterd", "bake", &mesh, "--name", "x", "--unit", &long], 2),
        (vec!["shatterd", "bake", &mesh, "--name", "x", "--shard", &long], 2),
        (vec!["shatterd", "serve", "--log", &long], 3),
    ] {
        for json in [false, true] {
            // `serve` has no JSON.
            let words = [&words[..], if json && words[1] != "serve" { &["--json"] } else { &[] }].concat();
            let (code, out, error) = run(here, &words);
            let shown = format!("{out}{error}");
            let most = shown.split(|c: char| c != 'x').map(str::len).max();
            assert_eq!((code, most), (wanted, Some(200)), "{:?}: {}", &words[..2], shown.replace(&long, "LONG"));
            assert!(shown.contains("… (100000 bytes)"), "{:?}: {shown}", &words[..2]);
        }
    }
}

#[test]
fn outputs_that_are_no_folders_are_named_as_what_they_are() {
    let here = TestDirectory::new("outputs");
    let mesh = here.file("cube.obj", "v 0 0 0\n").display().to_string();
    let device = (3, "/dev/full is a device, not a folder; choose another path (--out)");
    check(&here, &format!("shatterd bake {mesh} --name x --out /dev/full"), device);
    check(&here, &format!("shatterd merge {mesh}.share --out /dev/full"), device);
    let below =
        (3, "cannot make the folder /dev/full/x: /dev/full is a device, not a folder; choose another path (--out)");
    check(&here, &format!("shatterd bake {mesh} --name x --out /dev/full/x"), below);
}

#[test]
fn errors_of_scenes_and_configurations_name_key_value_and_range() {
    let here = TestDirectory::new("values");
    for (text, wanted) in [
        (
            "[objects.a]\nsites_max = 5000000000",
            "`objects.a.sites_max` is 5000000000; it must be a whole number from 1 to",
        ),
        (
            "[objects.a]\nelastic_spacing = 7",
            "`objects.a.elastic_spacing` is 7; it must be a number from 0.002 to 0.25",
        ),
        ("[objects.a\n", "scene.toml: line 1, column 11: unclosed table, expected `]`\n"),
        ("objects = 3", "`objects` is 3; it must be a table [objects.NAME] for each object"),
    ] {
        let scene = here.file("scene.toml", text).display().to_string();
        check(&here, &format!("shatterd check {scene}"), (3, wanted));
        let (_, out, _) = run(&here, &["shatterd", "check", &scene, "--json"]);
        assert!(!out.contains("\"at\": \"scene\"") && !out.contains("\"at\": \"\""), "{out}");
    }
    let mesh = here.file("cube.obj", "v 0 0 0\n").display().to_string();
    let table = here.file("soft.toml", "[glass]\nyoung_pa = \"soft\"\n").display().to_string();
    let soft = "soft.toml: materials cannot be read: line 2, column 12: `young_pa` is \"soft\"; it must be a number";
    check(&here, &format!("shatterd bake {mesh} --name x --materials {table}"), (3, soft));
    check(&here, "shatterd serve --databases /dev/full/x", (3, "`shatterd bake --out DIR` makes one"));
    for (text, wanted) in [
        ("[operations]\nport = 80000", "`operations.port` is 80000; it must be a whole number from 0 to 65535\n"),
        ("[compute]\nthreads = 2.5", "`compute.threads` is 2.5; it must be a whole number from 0 to 1024\n"),
        ("[compute]\nnice = 30", "`compute.nice` is 30; it must be a whole number from 0 to 19\n"),
    ] {
        let file = here.file("shatterd.toml", text).display().to_string();
        check(&here, &format!("shatterd serve --config {file}"), (3, wanted));
    }
}

#[test]
fn rays_of_any_length_and_points_far_off_are_understood() {
    let here = TestDirectory::new("rays");
    here.database("bar", bar(0.06));
    let daemon = InProcess::start_with(here, "", shatter_engine::wire::loader(None));
    let threshold = |length: &str| {
        let ray = format!("1,0.03,0.02,-{length},0,0");
        let (code, out, error) = run(&daemon.here, &["shatter", "threshold", "bar", "--ray", &ray]);
        assert_eq!(code, 0, "{error}");
        let (code, _, error) = run(&daemon.here, &["shatter", "impact", "bar", "--ray", &ray, "--impulse-ns", "50"]);
        assert_eq!(code, 0, "{error}");
        out
    };
    let wanted = threshold("1");
    ["1e300", "1e-300", "5e-324"].iter().for_each(|length| assert_eq!(threshold(length), wanted));
    let far = (3, "more than 1e9 m");
    check(&daemon.here, "shatter impact bar --point 1e308,0,0 --impulse 1,0,0", far);
    check(&daemon.here, "shatter impact bar --ray 1e308,0,0,0,1,0 --impulse-ns 1", far);
    check(&daemon.here, "shatter impact bar --ray 1,0,0,0,0,0 --impulse-ns 1", (3, "direction of the ray is zero"));
}

#[test]
fn a_client_that_may_map_little_memory_is_told_so() {
    let here = TestDirectory::new("little");
    here.database("bar", bar(0.06));
    let daemon = InProcess::start_with(here, "[results]\nbucket_mib_max = 256", shatter_engine::wire::loader(None));
    let mut command = shatter_program(&daemon.here);
    command.args(["impact", "bar", "--ray", "1,0.03,0.02,-1,0,0", "--impulse-ns", "50"]);
    let output = under(&[], "ulimit -v 100000", command).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(5) && error.contains("ulimit -v"), "{:?} {error}", output.status);
}

/// A panic can end in a hang if memory does not suffice for the stack of a thread: its report needs memory, too.
#[test]
fn limits_that_allow_no_thread_are_named() {
    let here = TestDirectory::new("limited");
    let mesh = here.file("empty.obj", "");
    let mut bake = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut bake);
    bake.args(["bake", mesh.to_str().unwrap(), "--name", "empty"]);
    let daemon = InProcess::start_with(here, "", shatter_engine::wire::loader(None));
    let mut list = shatter_program(&daemon.here);
    list.arg("list");
    for (command, code, reason) in [(bake, 6, "no thread can be started"), (list, 5, "ulimit -d")] {
        let mut limited = under(&["timeout", "--signal=KILL", "60"], "ulimit -d 1000", command);
        let output = limited.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && error.contains(reason), "{:?}: {error}", output.status);
    }
}

/// A folder in /tmp that another user made first: the message names it, its owner, and the remedy. Needs root, to become another user.
#[test]
fn a_runtime_folder_that_another_user_took_is_named() {
    const OTHER: u32 = 65_534;
    let folder = format!("/tmp/shatter-{OTHER}");
    if !rustix::process::geteuid().is_root() || Path::new(&folder).exists() {
        println!("skipped: needs root, and no {folder}");
        return;
    }
    // Other users can read and run files here, unlike those in the build folder.
    let own = tempfile::Builder::new().prefix("sh").tempdir_in("/dev/shm").unwrap();
    let here = TestDirectory::new("taken");
    let copy = own.path().join("shatter");
    std::fs::copy(shatter_program(&here).get_program(), &copy).unwrap();
    use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
    std::fs::set_permissions(own.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    std::fs::DirBuilder::new().mode(0o700).create(&folder).unwrap();
    let mut command = Command::new(&copy);
    command.args(["status"]).env_remove("XDG_RUNTIME_DIR").env_remove("SHATTER_SERVICE").uid(OTHER).gid(OTHER);
    let output = command.output();
    std::fs::remove_dir(&folder).unwrap();
    let output = output.unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    for part in [folder.as_str(), "belongs to user 0, not to 65534", "XDG_RUNTIME_DIR"] {
        assert!(error.contains(part), "{error}");
    }
    assert_eq!(output.status.code(), Some(3));
}
