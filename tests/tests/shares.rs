//! Divided, stopped, resumed and joined bakes: the bytes are always those of an undivided bake.

use nalgebra::Point3;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{
    BakeRequest, BakeShare, DatabaseError, JoinError, PartialBake, ShareError, bake, join, load, load_partial, save,
    save_partial,
};
use shatter_fracture::surface::RawMesh;
use shatter_fracture::surface::shapes::write_obj;
use shatter_tests::fixture::Fixture;
use shatter_tests::real;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// Examples of the undivided bake.
const EXAMPLES: u64 = 24;

/// A corner of a cube: small enough to be baked a hundred times.
fn wedge() -> RawMesh {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    RawMesh::new(corners.map(Point3::from).to_vec(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
}

fn request(examples: u64) -> BakeRequest {
    let coarse =
        BakeRequest { elastic_spacing: Some(0.2), crack_spacing: Some(0.125), ..real::request("wedge", "glass") };
    BakeRequest { examples, ..coarse }
}

fn undivided(folder: &Path) -> Vec<u8> {
    let path = folder.join("undivided.shatter");
    save(&bake(wedge(), &request(EXAMPLES), &CancelToken::default(), &mut |_| ()).unwrap(), &path).unwrap();
    std::fs::read(path).unwrap()
}

/// A share of that many impacts, saved and read again after every step, as if it were stopped each time.
fn share(folder: &Path, share: BakeShare, request: &BakeRequest) -> PathBuf {
    let path = share.file(folder, &request.name);
    let token = CancelToken::default();
    let mut partial = PartialBake::begin(wedge(), request, share, &token, &mut |_| ()).unwrap();
    loop {
        save_partial(&partial, &path).unwrap();
        if partial.task.is_done() {
            return path;
        }
        partial = load_partial(&path).unwrap();
        partial.step(&token).unwrap();
    }
}

fn joined(paths: &[PathBuf]) -> Result<Vec<u8>, JoinError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("joined.shatter");
    save(&join(paths, &CancelToken::default(), &mut |_| ())?, &path).unwrap();
    Ok(std::fs::read(path).unwrap())
}

#[test]
fn shares_joined_in_any_order_are_the_undivided_bake() {
    let folder = tempfile::tempdir().unwrap();
    let whole = undivided(folder.path());
    for count in [1, 3] {
        let of = |index| share(folder.path(), BakeShare::new(index, count).unwrap(), &request(EXAMPLES));
        let mut shares: Vec<PathBuf> = (0..count).map(of).collect();
        assert!(joined(&shares).unwrap() == whole, "{count} shares");
        shares.reverse();
        assert!(joined(&shares).unwrap() == whole, "{count} shares, reversed");
    }
}

#[test]
fn more_examples_may_be_divided_too() {
    let folder = tempfile::tempdir().unwrap();
    let whole = undivided(folder.path());
    let first = folder.path().join("first.shatter");
    save(&bake(wedge(), &request(10), &CancelToken::default(), &mut |_| ()).unwrap(), &first).unwrap();
    let shares = [0, 1].map(|index| {
        let path = folder.path().join(format!("{index}.share"));
        let mut partial =
            PartialBake::add(load(&first).unwrap(), EXAMPLES - 10, BakeShare::new(index, 2).unwrap()).unwrap();
        while !partial.task.is_done() {
            partial.step(&CancelToken::default()).unwrap();
        }
        save_partial(&partial, &path).unwrap();
        path
    });
    assert!(joined(&shares).unwrap() == whole);
}

#[test]
fn shares_that_do_not_belong_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let of = |index, request: &BakeRequest, name: &str| {
        let place = folder.path().join(name);
        std::fs::create_dir_all(&place).unwrap();
        share(&place, BakeShare::new(index, 2).unwrap(), request)
    };
    let [zero, one] = [0, 1].map(|index| of(index, &request(16), "same"));
    let other = of(1, &BakeRequest { seed: 9, ..request(16) }, "other");
    let unfinished = BakeShare::new(1, 2).unwrap().file(folder.path(), "unfinished");
    let partial =
        PartialBake::begin(wedge(), &request(16), BakeShare::new(1, 2).unwrap(), &CancelToken::default(), &mut |_| ());
    save_partial(&partial.unwrap(), &unfinished).unwrap();
    let database = folder.path().join("database.shatter");
    save(&join(&[one.clone(), zero.clone()], &CancelToken::default(), &mut |_| ()).unwrap(), &database).unwrap();
    let check = |paths: &[&PathBuf], expected: &dyn Fn(&JoinError) -> bool| {
        let error = joined(&paths.iter().map(|path| (*path).clone()).collect::<Vec<_>>()).unwrap_err();
        assert!(expected(&error), "{error}");
    };
    check(&[], &|error| matches!(error, JoinError::Nothing));
    check(&[&one], &|error| matches!(error, JoinError::Missing { share } if share.index == 0));
    check(&[&zero, &zero], &|error| matches!(error, JoinError::Twice { .. }));
    check(&[&zero, &other], &|error| matches!(error, JoinError::OtherWork { path, .. } if *path == other));
    check(&[&zero, &unfinished], &|error| matches!(error, JoinError::Unfinished { done: 0, of: 8, .. }));
    let whole = |error: &JoinError| matches!(error, JoinError::Database { path, source: DatabaseError::Whole } if *path == database);
    check(&[&zero, &database], &whole);
    let absent = folder.path().join("nope.share");
    let named = |error: &JoinError| error.to_string().matches("nope.share").count() == 1;
    check(&[&absent], &named);
    assert!(load(&zero).err().unwrap().to_string().contains("shatterd merge"));
}

#[test]
fn a_share_is_two_numbers() {
    assert_eq!("3/8".parse(), BakeShare::new(3, 8));
    assert_eq!("3".parse::<BakeShare>(), Err(ShareError::Text("3".into())));
    assert_eq!("-1/2".parse::<BakeShare>(), Err(ShareError::Text("-1/2".into())));
    assert_eq!("2/2".parse::<BakeShare>(), Err(ShareError::Index { index: 2, count: 2 }));
    assert_eq!("0/0".parse::<BakeShare>(), Err(ShareError::Count { count: 0 }));
    let impacts: Vec<u64> = (0..3).flat_map(|index| BakeShare::new(index, 3).unwrap().impacts(5, 12)).collect();
    assert_eq!(impacts, [5, 8, 11, 6, 9, 7, 10]);
}

/// A test folder with the wedge as a mesh file, and the options of its bake.
struct BakeFixture {
    fixture: Fixture,
    mesh: String,
}

impl BakeFixture {
    fn new() -> Self {
        let fixture = Fixture::new();
        let mesh = fixture.path("wedge.obj");
        write_obj(&wedge(), &mesh).unwrap();
        Self { mesh: mesh.to_str().unwrap().to_owned(), fixture }
    }

    fn arguments<'a>(&'a self, more: &[&'a str]) -> Vec<&'a str> {
        let lattices =
            ["--elastic-spacing", "0.2", "--crack-spacing", "0.125", "--surface", "lattice", "--elements", "linear"];
        let own = [&["bake", &self.mesh, "--name", "wedge"], &lattices[..]].concat();
        [&own[..], more].concat()
    }

    fn bake(&self, more: &[&str]) -> (i32, Value) {
        self.fixture.json("shatterd", &self.arguments(more))
    }

    fn command(&self, more: &[&str]) -> Command {
        let mut command = self.fixture.command("shatterd");
        command.args(self.arguments(more)).stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        command
    }

    fn database(&self) -> PathBuf {
        self.fixture.databases().join("wedge.shatter")
    }

    fn bytes(&self) -> Vec<u8> {
        std::fs::read(self.database()).unwrap()
    }
}

fn end(child: &mut Child, signal: Signal) -> Option<i32> {
    kill_process(Pid::from_child(child), signal).unwrap();
    child.wait().unwrap().code()
}

/// Waits until `file` exists.
fn await_file(file: &Path) {
    let begun = Instant::now();
    while !file.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{} did not appear", file.display());
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn an_interrupted_bake_keeps_what_is_done_and_goes_on_with_it() {
    let bake_fixture = BakeFixture::new();
    let examples = ["--examples", "4000"];
    let kept = BakeShare::WHOLE.file(&bake_fixture.fixture.databases(), "wedge");
    for (signal, code) in [(Signal::INT, 130), (Signal::TERM, 143)] {
        let _ = std::fs::remove_file(&kept);
        let mut child = bake_fixture.command(&examples).spawn().unwrap();
        await_file(&kept);
        assert_eq!(end(&mut child, signal), Some(code));
        let partial = load_partial(&kept).unwrap();
        assert!(!partial.task.is_done() && !bake_fixture.database().exists());
    }
    let (code, refused) = bake_fixture.bake(&["--examples", "4000", "--seed", "3", "--resume"]);
    assert_eq!((code, refused["error"]["kind"].as_str()), (3, Some("other_work")), "{refused}");
    let resumed = |seconds| {
        let mut child = bake_fixture.command(&["--examples", "4000", "--resume"]).spawn().unwrap();
        std::thread::sleep(Duration::from_secs_f64(seconds));
        end(&mut child, Signal::INT);
        load_partial(&kept).unwrap().task.done
    };
    // A busy machine may need longer for the first of them.
    let done = (1..8).map(|turn| resumed(0.25 * f64::from(1 << turn))).find(|done| *done > 0).expect("it went on");
    let undone = bake_fixture.bake(&["--examples", "40", "--resume"]);
    assert_eq!(undone.0, 3, "40 examples are other work than 4000");
    let (code, refused) = bake_fixture.bake(&["--examples", "40"]);
    assert_eq!((code, refused["error"]["kind"].as_str()), (3, Some("kept_share")), "{refused}");
    let message = refused["error"]["message"].as_str().unwrap();
    assert!(message.starts_with(&format!("{done} of 4000 impacts are kept")), "{message}");
    assert!(message.contains("--resume") && message.contains("--restart") && kept.exists(), "{message}");
    assert_eq!(bake_fixture.bake(&["--examples", "40", "--restart"]).0, 0);
    assert!(!kept.exists(), "what was kept is gone when the database is there");
}

#[test]
fn shares_are_baked_and_merged_by_commands() {
    let bake_fixture = BakeFixture::new();
    assert_eq!(bake_fixture.bake(&["--examples", "40"]).0, 0);
    let whole = bake_fixture.bytes();
    let out = bake_fixture.fixture.path("shares");
    let out = out.to_str().unwrap();
    let (code, first) = bake_fixture.bake(&["--examples", "40", "--shard", "0/2", "--out", out]);
    assert_eq!((code, &first["share"]["count"], &first["impacts"]), (0, &2.into(), &20.into()), "{first}");
    let mut array = bake_fixture.command(&["--examples", "40", "--out", out]);
    // Variables of Slurm if task 1 alone is repeated.
    let repeated = ["ID", "MIN", "MAX", "COUNT"].map(|name| (format!("SLURM_ARRAY_TASK_{name}"), "1"));
    array.envs(repeated).env("SHATTER_SHARDS", "2");
    assert!(array.status().unwrap().success());
    let files = [0, 1].map(|index| format!("{out}/wedge.{index}-of-2.share"));
    let merged = bake_fixture.fixture.path("merged");
    let merge = |files: &[&str]| {
        let arguments = [&["merge", "--out", merged.to_str().unwrap()], files].concat();
        bake_fixture.fixture.json("shatterd", &arguments)
    };
    let (code, missing) = merge(&[&files[0]]);
    assert_eq!((code, missing["error"]["at"].as_str()), (3, Some("1/2")), "{missing}");
    assert!(!merged.exists(), "a refused merge leaves an empty folder");
    assert_eq!(merge(&[&files[1], &files[0]]).0, 0);
    assert!(std::fs::read(merged.join("wedge.shatter")).unwrap() == whole);
    let (code, usage) = bake_fixture.bake(&["--examples", "40", "--shard", "2/2"]);
    assert_eq!((code, usage["error"]["kind"].as_str()), (2, Some("usage")), "{usage}");
    assert!(usage["error"]["message"].as_str().unwrap().contains("2 is too large for 2 shares"), "{usage}");
    let (code, refused) = bake_fixture.bake(&["--shard", "0/2"]);
    assert_eq!((code, refused["error"]["at"].as_str()), (3, Some("--shard")), "{refused}");
}

/// Ends `command` by SIGKILL at a hundred random moments: `file` always holds `old` or `new`.
fn check_killed(command: impl Fn() -> Command, times: u64, file: &Path, old: &[u8], new: &[u8]) {
    let begun = Instant::now();
    assert!(command().status().unwrap().success());
    // A third of the turns get more time than a whole run took, so that some end by themselves on a busy machine, too.
    let longest = begun.elapsed().mul_f64(1.5);
    let mut seen = [0, 0];
    for turn in 0..times {
        std::fs::write(file, old).unwrap();
        let mut child = command().spawn().unwrap();
        // Golden-ratio steps: spread evenly over the whole run.
        std::thread::sleep(longest.mul_f64((turn as f64 * 0.618_033_988_75).fract()));
        end(&mut child, Signal::KILL);
        let found = std::fs::read(file).unwrap();
        assert!(found == old || found == new, "turn {turn}: {} bytes that are neither", found.len());
        seen[usize::from(found == new)] += 1;
        load(file).unwrap();
    }
    println!("{times} times SIGKILL within {longest:?}: {} times the old file, {} times the new one", seen[0], seen[1]);
    assert!(seen[0] > 0, "no run was ended before its end");
    assert!(seen[1] > 0, "every run was ended before its end");
}

#[test]
fn a_killed_bake_or_merge_leaves_the_old_file_or_the_new_one() {
    let bake_fixture = BakeFixture::new();
    // Few examples: the shorter a run, the more of the moments are those in which it writes.
    assert_eq!(bake_fixture.bake(&["--examples", "10"]).0, 0);
    let old = bake_fixture.bytes();
    assert_eq!(bake_fixture.bake(&["--examples", "14"]).0, 0);
    let new = bake_fixture.bytes();
    check_killed(|| bake_fixture.command(&["--examples", "14", "--resume"]), 60, &bake_fixture.database(), &old, &new);
    let shares =
        [0, 1].map(|index| share(&bake_fixture.fixture.databases(), BakeShare::new(index, 2).unwrap(), &request(14)));
    let merge = || {
        let mut command = bake_fixture.fixture.command("shatterd");
        command.arg("merge").args(&shares).arg("--out").arg(bake_fixture.fixture.databases());
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        command
    };
    check_killed(merge, 40, &bake_fixture.database(), &old, &new);
}

/// Mode of a file, without its type.
fn mode(file: &Path) -> u32 {
    std::fs::metadata(file).unwrap().permissions().mode() & 0o777
}

#[test]
fn a_new_database_has_the_usual_mode_and_one_that_is_replaced_keeps_its_own() {
    let bake_fixture = BakeFixture::new();
    let masked = |mask: &str, more: &[&str]| {
        let plain = bake_fixture.fixture.command("shatterd");
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("umask {mask}; exec \"$0\" \"$@\"")]).arg(plain.get_program());
        shell.envs(plain.get_envs().filter_map(|(name, value)| Some((name, value?))));
        assert!(shell.args(bake_fixture.arguments(more)).output().unwrap().status.success());
    };
    masked("027", &[]);
    assert_eq!(mode(&bake_fixture.database()), 0o640);
    masked("022", &[]);
    assert_eq!(mode(&bake_fixture.database()), 0o640);
    std::fs::remove_file(bake_fixture.database()).unwrap();
    masked("022", &[]);
    assert_eq!(mode(&bake_fixture.database()), 0o644);
}

#[test]
fn a_log_without_a_terminal_tells_how_far_a_bake_is() {
    let bake_fixture = BakeFixture::new();
    let output = bake_fixture.fixture.run("shatterd", &bake_fixture.arguments(&["--examples", "40"]));
    let log = String::from_utf8(output.stderr).unwrap();
    let wordless = bake_fixture.fixture.run("shatterd", &bake_fixture.arguments(&[])).stderr;
    assert!(!String::from_utf8(wordless).unwrap().contains("wedge: examples"), "there are none");
    let line = |text: &str| log.lines().any(|line| line.starts_with("shatterd: wedge: ") && line.ends_with(text));
    for text in ["lattices", "lift of body 0", "examples 0/40", "examples 40/40", "reduced elasticity", "write"] {
        assert!(line(text), "{text} in {log}");
    }
}

/// Changes a byte of the last tensor.
fn damage_file(file: &Path) {
    let mut bytes = std::fs::read(file).unwrap();
    let last = bytes.len() - 9;
    bytes[last] ^= 1;
    std::fs::write(file, bytes).unwrap();
}

#[track_caller]
fn check_named(document: &Value, file: &Path, words: &[&str]) {
    let (error, name) = (&document["error"], file.display().to_string());
    assert!(error["at"].as_str().unwrap().contains(&name), "{document}");
    let message = error["message"].as_str().unwrap();
    assert!(message.contains(&name) && words.iter().all(|word| message.contains(word)), "{document}");
}

#[test]
fn damaged_files_are_named_with_what_is_damaged_and_what_to_do() {
    let bake_fixture = BakeFixture::new();
    let folder = bake_fixture.fixture.databases();
    std::fs::create_dir_all(&folder).unwrap();
    let kept = share(&folder, BakeShare::WHOLE, &request(16));
    damage_file(&kept);
    let (code, refused) = bake_fixture.bake(&["--examples", "16", "--resume"]);
    assert_eq!(code, 3, "{refused}");
    check_named(&refused, &kept, &["checksum of", "remove it", "--restart"]);
    check_named(&bake_fixture.bake(&["--examples", "16"]).1, &kept, &["remove it", "--restart"]);
    let (code, refused) = bake_fixture.fixture.json("shatterd", &["inspect", kept.to_str().unwrap()]);
    assert_eq!(code, 3, "{refused}");
    check_named(&refused, &kept, &["checksum of"]);
}
