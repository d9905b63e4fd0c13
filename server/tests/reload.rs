//! Databases that appear, change, become corrupt and disappear under a running daemon: real processes, toy objects.

mod support;

use rustix::process::Signal;
use serde_json::Value;
use shatter_client::{Client, Contact, ErrorKind, Impact, ObjectFacts, ObjectState, Status};
use std::io::Read;
use std::process::Stdio;
use std::time::{Duration, Instant};
use support::{Child, TestDirectory, play, role, shatter, shatter_program, timeout};

/// Settings of a daemon that reads its databases again only on demand.
const UNWATCHED: &str = "[databases]\nwatch_ms = 0";

/// Settings of a daemon that checks its databases often.
const WATCHED: &str = "[databases]\nwatch_ms = 10";

/// Runs the process of another role for the tests below; does nothing by itself.
#[test]
fn play_a_role() {
    play(|other| panic!("no such role: {other}"));
}

/// Starts a daemon, and connects to it.
fn start(here: &TestDirectory, settings: &str) -> (Child, Client) {
    let daemon = Child::start(&mut role(here, "daemon", settings));
    (daemon, Client::connect_at(&here.place, timeout()).unwrap())
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

/// γ of the version of the object that a new request meets.
fn strike(service: &Client, object: &str) -> f64 {
    let object = service.object(object, timeout()).unwrap();
    object.strike(&impact()).unwrap().wait(timeout()).unwrap().summary().gamma_j_m2
}

fn status(service: &Client) -> Status {
    service.status(timeout()).unwrap()
}

fn facts(service: &Client, object: &str) -> Option<ObjectFacts> {
    service.objects(timeout()).unwrap().into_iter().find(|facts| facts.name == object)
}

/// Waits with a timeout until `holds`.
#[track_caller]
fn eventually(service: &Client, holds: impl Fn(&Client) -> bool) {
    let deadline = timeout();
    while !holds(service) {
        assert!(!deadline.passed(), "never: {:?}, {:?}", status(service), service.objects(timeout()));
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn generation(service: &Client, object: &str) -> u32 {
    facts(service, object).map_or(0, |facts| facts.generation)
}

#[test]
fn a_hangup_swaps_whole_and_a_strike_keeps_the_version_it_began_with() {
    let here = TestDirectory::new("swap");
    here.database("vase", "gate 3");
    here.database("pot", "tint 5");
    let gate = here.databases().join("vase.gate");
    std::fs::write(&gate, "").unwrap();
    let (daemon, service) = start(&here, UNWATCHED);
    assert_eq!((status(&service).memory_bytes, status(&service).reloads), (8000, 0));
    let pot = facts(&service, "pot").unwrap();
    let mut early = service.object("vase", timeout()).unwrap().strike(&impact()).unwrap();
    eventually(&service, |service| status(service).running == 1);
    here.database("vase", "tint 7");
    here.database("jug", "tint 1");
    daemon.signal(Signal::HUP);
    eventually(&service, |service| generation(service, "vase") == 2);
    assert_eq!(strike(&service, "vase"), 7.0, "new strikes meet the new version");
    assert_eq!(strike(&service, "jug"), 1.0);
    let row = status(&service);
    assert_eq!((row.reloads, row.memory_bytes, row.objects_ready), (1, 13_000, 3));
    assert_eq!((row.retired, row.retired_bytes), (1, 3000), "the old version lives as long as it is struck");
    assert_eq!(facts(&service, "pot").unwrap(), pot, "what did not change was not loaded again");
    std::fs::remove_file(gate).unwrap();
    let result = early.wait(timeout()).unwrap();
    assert_eq!(result.summary().gamma_j_m2, 3.0);
    assert_eq!(result.positions()[1], [1.5, 0.0, 0.0]);
    eventually(&service, |service| status(service).retired == 0);
    assert_eq!((status(&service).retired_bytes, status(&service).failed), (0, 0));
}

#[test]
fn a_changed_folder_is_read_again_by_itself() {
    let here = TestDirectory::new("watched");
    here.database("vase", "tint 3");
    let (_daemon, service) = start(&here, WATCHED);
    let first = facts(&service, "vase").unwrap();
    assert_eq!((first.generation, first.file_bytes, first.memory_bytes), (1, 6, 3000));
    here.database("pot", "tint 5");
    eventually(&service, |service| generation(service, "pot") == 1);
    here.database("vase", "tint 7");
    eventually(&service, |service| generation(service, "vase") == 2);
    assert_eq!((strike(&service, "vase"), strike(&service, "pot")), (7.0, 5.0));
    assert!(facts(&service, "vase").unwrap().loaded_unix > first.loaded_unix);
    here.remove("vase");
    eventually(&service, |service| facts(service, "vase").is_none());
    assert_eq!(service.object("vase", timeout()).err().unwrap().kind, ErrorKind::UnknownObject);
    assert_eq!(strike(&service, "pot"), 5.0);
    assert_eq!(generation(&service, "pot"), 1, "it never changed");
    let reloads = status(&service).reloads;
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(status(&service).reloads, reloads, "a folder at rest is not read again");
}

#[test]
fn an_unwatched_folder_is_read_on_request() {
    let here = TestDirectory::new("unwatched");
    here.database("vase", "tint 3");
    let (daemon, service) = start(&here, UNWATCHED);
    here.database("vase", "tint 7");
    // Ten times as long as the default pause.
    std::thread::sleep(Duration::from_millis(2500));
    assert_eq!((generation(&service, "vase"), status(&service).reloads), (1, 0));
    daemon.signal(Signal::HUP);
    eventually(&service, |service| generation(service, "vase") == 2);
}

#[test]
fn bad_files_are_named_and_everything_else_is_served() {
    let here = TestDirectory::new("bad");
    for (name, text) in [("vase", "tint 3"), ("worn", "?"), ("rotten", "rotten")] {
        here.database(name, text);
    }
    let (daemon, service) = start(&here, UNWATCHED);
    let error = |name: &str| service.object(name, timeout()).err().unwrap();
    assert!(error("worn").message.contains("worn.shatter") && error("rotten").message.contains("fell over it"));
    here.database("cut", "?");
    here.database("pot", "tint 5");
    daemon.signal(Signal::HUP);
    eventually(&service, |service| generation(service, "pot") == 1);
    for name in ["worn", "rotten", "cut"] {
        assert_eq!(error(name).kind, ErrorKind::CorruptObject, "{name}");
    }
    assert_eq!((strike(&service, "vase"), strike(&service, "pot")), (3.0, 5.0));
    let row = status(&service);
    assert_eq!((row.objects_ready, row.objects_failed, row.objects_outdated), (2, 3, 0));
}

#[test]
fn a_bad_replacement_is_named_and_the_version_before_it_served() {
    let here = TestDirectory::new("spoilt");
    here.database("vase", "tint 3");
    let (_daemon, service) = start(&here, WATCHED);
    here.database("vase", "?");
    eventually(&service, |service| status(service).objects_outdated == 1);
    let vase = facts(&service, "vase").unwrap();
    assert!(vase.is_ready() && vase.generation == 1);
    assert!(vase.error.unwrap().message.contains("vase.shatter: checksum"));
    assert_eq!((status(&service).objects_ready, status(&service).objects_failed), (1, 0));
    assert_eq!(strike(&service, "vase"), 3.0);
    for command in ["list", "status"] {
        let (code, out) = shatter(&here, &[command, "--json"]);
        let vase = &serde_json::from_str::<Value>(&out).unwrap()["objects"][0];
        assert_eq!(
            (code, &vase["ready"], &vase["error"]["kind"]),
            (0, &true.into(), &"corrupt_object".into()),
            "{out}"
        );
        assert!(shatter(&here, &[command]).1.contains("outdated"));
    }
    here.database("vase", "tint 7");
    eventually(&service, |service| generation(service, "vase") == 2);
    assert_eq!((status(&service).objects_outdated, strike(&service, "vase")), (0, 7.0));
    assert_eq!(facts(&service, "vase").unwrap().error, None);
}

#[test]
fn status_shows_what_is_loaded_its_memory_and_since_when() {
    let here = TestDirectory::new("shown");
    here.database("vase", "tint 3000");
    here.database("worn", "?");
    let (daemon, service) = start(&here, UNWATCHED);
    here.database("pot", "tint 5");
    daemon.signal(Signal::HUP);
    eventually(&service, |service| status(service).reloads == 1);
    let (code, out) = shatter(&here, &["status", "--json"]);
    let shown: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (code, shown["reloads"].as_u64(), shown["memory_bytes"].as_u64()),
        (0, Some(1), Some(3_005_000)),
        "{out}"
    );
    assert_eq!((shown["retired"].as_u64(), shown["retired_bytes"].as_u64()), (Some(0), Some(0)), "{out}");
    let [pot, vase, damaged] = [0, 1, 2].map(|row| &shown["objects"][row]);
    assert_eq!((&pot["object"], &vase["object"], &damaged["object"]), (&"pot".into(), &"vase".into(), &"worn".into()));
    assert_eq!((vase["memory_bytes"].as_u64(), vase["file_bytes"].as_u64()), (Some(3_000_000), Some(9)), "{out}");
    assert_eq!((vase["ready"].as_bool(), vase["generation"].as_u64()), (Some(true), Some(1)), "{out}");
    assert!(vase["loaded_unix_s"].as_f64().unwrap() < pot["loaded_unix_s"].as_f64().unwrap(), "{out}");
    assert!(shown["read_unix_s"].as_f64().unwrap() > vase["loaded_unix_s"].as_f64().unwrap(), "{out}");
    assert!(vase["load_s"].as_f64().unwrap() >= 0.0 && vase.get("error").is_none(), "{out}");
    assert_eq!((damaged["ready"].as_bool(), damaged["error"]["at"].as_str()), (Some(false), Some("worn")), "{out}");
    let screen = shatter(&here, &["status"]).1;
    let line = screen.lines().find(|line| line.starts_with("vase")).unwrap();
    assert!(line.contains(" 2.9 ") && line.ends_with(" UTC"), "{screen}");
    assert!(screen.contains(", 1 reload; ") && screen.contains("worn.shatter: checksum"), "{screen}");
}

/// A database that is being loaded is listed, and requests for it get `loading`.
#[test]
fn an_object_that_is_being_loaded_is_listed_as_such() {
    let here = TestDirectory::new("loading");
    here.database("vase", "tint 3");
    let (_daemon, service) = start(&here, WATCHED);
    let gate = here.databases().join("pot.loading");
    std::fs::write(&gate, "").unwrap();
    here.database("pot", "tint 5");
    eventually(&service, |service| facts(service, "pot").is_some());
    let pot = facts(&service, "pot").unwrap();
    assert_eq!((pot.is_ready(), pot.state), (false, ObjectState::Loading));
    let row = status(&service);
    assert_eq!((row.objects_ready, row.objects_loading, row.objects_failed), (1, 1, 0));
    let error = service.object("pot", timeout()).err().unwrap();
    assert_eq!((error.kind, error.at.as_str(), error.kind.retry()), (ErrorKind::Loading, "pot", true), "{error}");
    assert!(error.retry_after.is_some());
    let error = service.object("another", timeout()).err().unwrap();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Loading, "another"), "{error}");
    assert!(error.retry_after.is_some() && error.message.contains("`pot` is still being loaded"), "{error}");
    let strike_now = ["impact", "pot", "--point", "0,0,0", "--impulse", "-1,0,0", "--json"];
    let (code, out) = shatter(&here, &strike_now);
    let error = &serde_json::from_str::<Value>(&out).unwrap()["error"];
    assert_eq!((code, &error["kind"], &error["retry"]), (5, &"loading".into(), &true.into()), "{out}");
    assert!(error["retry_after_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{out}");
    for command in ["list", "status"] {
        let (_, out) = shatter(&here, &[command, "--json"]);
        let objects = &serde_json::from_str::<Value>(&out).unwrap()["objects"];
        assert_eq!((&objects[0]["state"], &objects[1]["state"]), (&"loading".into(), &"ready".into()), "{out}");
        assert!(shatter(&here, &[command]).1.contains("loading"));
    }
    // Another database that appears meanwhile is loaded, too.
    here.database("jug", "tint 1");
    eventually(&service, |service| status(service).objects_loading == 2);
    assert_eq!(strike(&service, "vase"), 3.0);
    std::fs::remove_file(gate).unwrap();
    eventually(&service, |service| status(service).objects_ready == 3);
    assert_eq!((status(&service).objects_loading, strike(&service, "pot"), strike(&service, "jug")), (0, 5.0, 1.0));
}

/// A signal while the databases are being loaded ends the daemon at once, before it serves.
#[test]
fn a_signal_ends_a_daemon_that_still_loads() {
    for signal in [Signal::TERM, Signal::INT] {
        let here = TestDirectory::new("early");
        here.database("pot", "tint 5");
        std::fs::write(here.databases().join("pot.loading"), "").unwrap();
        let mut child = role(&here, "daemon", "").stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let (begun, limit) = (Instant::now(), Duration::from_secs(30));
        while !here.place.lock().exists() && begun.elapsed() < limit {
            std::thread::sleep(Duration::from_millis(2));
        }
        // The daemon takes its runtime directory before it loads.
        std::thread::sleep(Duration::from_millis(200));
        let asked = Instant::now();
        rustix::process::kill_process(rustix::process::Pid::from_child(&child), signal).unwrap();
        let mut reported = String::new();
        child.stdout.take().unwrap().read_to_string(&mut reported).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{reported}");
        assert!(asked.elapsed() < Duration::from_secs(1), "{:?}", asked.elapsed());
        assert!(!reported.contains("ready"), "{reported}");
        assert!(!here.place.hello().exists() && here.shared_memory().is_empty());
    }
}

/// A request for an object right after its database was written gets `loading`, however rarely the daemon checks by itself.
#[test]
fn a_database_that_was_written_a_moment_ago_is_being_loaded() {
    let here = TestDirectory::new("fresh");
    let (_daemon, service) = start(&here, "[databases]\nwatch_ms = 60000");
    for name in ["pot", "jug"] {
        here.database(name, "tint 5");
        let error = service.object(name, timeout()).err().unwrap();
        assert_eq!(error.kind, ErrorKind::Loading, "{error}");
    }
    here.database("vase", "tint 5");
    let (code, out) = shatter(&here, &["impact", "vase", "--point", "0,0,0", "--impulse", "-1,0,0", "--json"]);
    assert!(code == 5 && out.contains("\"loading\""), "{out}");
    here.database("cup", "tint 5");
    let wait = || service.object("cup", timeout()).err().unwrap().retry_after.unwrap();
    let first = wait();
    std::thread::sleep(Duration::from_millis(100));
    assert!(wait() < first, "it counts down");
    let error = service.object("pan", timeout()).err().unwrap();
    assert!(error.kind == ErrorKind::Loading && error.message.contains("no loaded database holds `pan`"), "{error}");
}

/// `impact --wait` waits for a daemon, and for an object that is being loaded; after its time it reports for what.
#[test]
fn a_request_waits_for_the_daemon_and_its_object() {
    let here = TestDirectory::new("wait");
    here.database("vase", "tint 3");
    let program = |object: &str, wait: &str| {
        let mut command = shatter_program(&here);
        command.args(["impact", object, "--point", "0,0.1,0", "--impulse", "-1,0,0", "--wait", wait, "--json"]);
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        command
    };
    let over = |object: &str, (wanted, kind): (i32, &str)| {
        let output = program(object, "0.2").output().unwrap();
        let error = &serde_json::from_slice::<Value>(&output.stdout).unwrap()["error"];
        assert_eq!((output.status.code(), &error["kind"]), (Some(wanted), &kind.into()), "{error}");
        let (_, waited) = error["message"].as_str().unwrap().split_once("waited ").unwrap();
        let waited_s: f64 = waited.strip_suffix(" s (--wait)").unwrap().parse().unwrap();
        assert!(waited_s >= 0.2, "{error}");
    };
    over("vase", (4, "no_daemon"));
    let early = program("vase", "60").spawn().unwrap();
    let (_daemon, service) = start(&here, WATCHED);
    assert!(early.wait_with_output().unwrap().status.success());
    let gate = here.databases().join("pot.loading");
    std::fs::write(&gate, "").unwrap();
    here.database("pot", "tint 5");
    eventually(&service, |service| facts(service, "pot").is_some());
    over("pot", (5, "loading"));
    let early = program("pot", "60").spawn().unwrap();
    std::fs::remove_file(gate).unwrap();
    assert!(early.wait_with_output().unwrap().status.success());
}

/// Niceness of the threads of process `pid` with this name.
fn niceness(pid: u32, name: &str) -> Vec<String> {
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task")).unwrap().flatten();
    let named =
        tasks.filter(|task| std::fs::read_to_string(task.path().join("comm")).is_ok_and(|comm| comm.trim() == name));
    // Fields after the name, which ends in a parenthesis: the 17th is the niceness.
    let nice = |stat: String| stat.rsplit(')').next().unwrap().split_whitespace().nth(16).unwrap().to_owned();
    named.map(|task| nice(std::fs::read_to_string(task.path().join("stat")).unwrap())).collect()
}

/// A load gets a share of a busy machine: as much as one computing thread, and no more.
#[test]
fn a_load_is_as_urgent_as_a_strike() {
    let here = TestDirectory::new("share");
    let (daemon, service) = start(&here, "[compute]\nthreads = 2\nrequests_at_once = 1\nnice = 3");
    let [load, strike] = ["load", "compute-1"].map(|name| move |pid| niceness(pid, name));
    eventually(&service, |_| load(daemon.id()).len() == 1 && load(daemon.id()) == strike(daemon.id()));
    assert_ne!(load(daemon.id()), niceness(daemon.id(), "finish"), "work without a waiting client gives way");
}
