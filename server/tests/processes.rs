//! Real processes: daemons and clients that come, go, and are killed.

mod support;

use rustix::process::Signal;
use serde_json::Value;
use shatter_client::{Client, Contact, Deadline, Effect, ErrorKind, Impact};
use shatter_proto::result::StageKind;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Duration;
use support::{Child, TestDirectory, eventually, play, role, shatter, shatter_program, shatterd, timeout};

/// Runs the process of another role for the tests below; does nothing by itself.
#[test]
fn play_a_role() {
    play(|client| match client {
        "hoarder" => {
            let vase = connect(None).object("vase", timeout()).unwrap();
            let held: Vec<_> = (0..2).map(|_| vase.strike(&impact()).unwrap().wait(timeout()).unwrap()).collect();
            let _pending = vase.strike(&impact()).unwrap();
            println!("ready");
            std::thread::sleep(Duration::from_secs(120));
            drop(held);
        }
        other => panic!("no such role: {other}"),
    });
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

fn connect(here: Option<&TestDirectory>) -> Client {
    match here {
        Some(here) => Client::connect_at(&here.place, timeout()).unwrap(),
        None => Client::connect(&std::env::var("SHATTER_SERVICE").unwrap(), timeout()).unwrap(),
    }
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Runs `shatterd serve` to its end; returns exit code and stderr.
fn serve(here: &TestDirectory, arguments: &[&str]) -> (i32, String) {
    let out = shatterd(here).args(arguments).stdin(Stdio::null()).output().unwrap();
    (out.status.code().unwrap(), String::from_utf8_lossy(&out.stderr).into_owned())
}

#[test]
fn the_daemon_serves_lists_and_ends_without_a_trace() {
    let here = TestDirectory::new("serves");
    here.database("worn", "not a database");
    let daemon = Child::start(&mut shatterd(&here));
    let (code, out) = shatter(&here, &["list", "--json"]);
    let list = json(&out);
    assert_eq!((code, list["objects"][0]["object"].as_str()), (0, Some("worn")), "{out}");
    assert_eq!(list["objects"][0]["error"]["kind"], "corrupt_object");
    let (code, out) = shatter(&here, &["status", "--wait", "5", "--json"]);
    assert_eq!((code, json(&out)["objects_failed"].as_u64()), (0, Some(1)), "{out}");
    let strike = ["impact", "worn", "--point", "0,0,0", "--impulse", "-1,0,0", "--json"];
    let (code, out) = shatter(&here, &strike);
    assert_eq!((code, json(&out)["error"]["kind"].as_str()), (3, Some("corrupt_object")), "{out}");
    let (code, out) = shatter(&here, &["threshold", "pot", "--point", "0,0,0", "--direction", "0,-1,0", "--json"]);
    assert_eq!((code, json(&out)["error"]["at"].as_str()), (3, Some("pot")), "{out}");
    assert_eq!(daemon.terminate().code(), Some(0));
    assert_eq!(here.shared_memory(), Vec::<std::path::PathBuf>::new());
    let (code, out) = shatter(&here, &["list", "--json"]);
    assert_eq!((code, json(&out)["error"]["kind"].as_str()), (4, Some("no_daemon")), "{out}");
}

#[test]
fn a_second_daemon_of_the_same_name_is_refused() {
    let here = TestDirectory::new("second");
    let first = Child::start(&mut shatterd(&here));
    let (code, error) = serve(&here, &[]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("`second`") && error.contains(&first.id().to_string()), "{error}");
    let other = Child::start(shatterd(&here).args(["--service", "other"]));
    assert_eq!(other.terminate().code(), Some(0));
    assert_eq!(connect(Some(&here)).status(timeout()).unwrap().pid, first.id());
}

#[test]
fn a_daemon_with_a_closed_stderr_keeps_serving() {
    let here = TestDirectory::new("unread");
    let daemon = Child::with_closed_output(shatterd(&here).args(["--log", "debug"]));
    let service = connect(Some(&here));
    for _ in 0..20 {
        assert!(service.object("nothing", timeout()).is_err());
    }
    assert_eq!(service.status(timeout()).unwrap().pid, daemon.id());
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn a_daemon_ends_with_its_standard_input_if_that_is_wanted() {
    let here = TestDirectory::new("stdin");
    let mut free = Child::start(shatterd(&here).stdin(Stdio::piped()));
    free.close_stdin();
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(connect(Some(&here)).status(timeout()).unwrap().pid, free.id());
    assert_eq!(free.terminate().code(), Some(0));
    let mut tied = Child::start(shatterd(&here).arg("--end-with-stdin").stdin(Stdio::piped()));
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(connect(Some(&here)).status(timeout()).unwrap().pid, tied.id());
    tied.close_stdin();
    eventually(|| "the daemon goes on", || Client::connect_at(&here.place, Deadline::ms(100)).is_err());
    tied.finish();
    assert_eq!(here.shared_memory(), Vec::<std::path::PathBuf>::new());
}

#[test]
fn status_waits_for_the_daemon_that_comes_after_a_killed_one() {
    let here = TestDirectory::new("waits");
    for _ in 0..4 {
        let killed = Child::start(&mut shatterd(&here));
        killed.signal(Signal::KILL);
        let next = Child::begin(&mut shatterd(&here));
        let (code, text) = shatter(&here, &["status", "--wait", "30", "--json"]);
        assert_eq!((code, json(&text)["pid"].as_u64()), (0, Some(next.id().into())), "{text}");
        next.kill();
    }
}

#[test]
fn start_errors_name_their_cause() {
    let here = TestDirectory::new("named");
    let check = |arguments: &[&str], exit: i32, named: &str| {
        let (code, error) = serve(&here, arguments);
        assert_eq!(code, exit, "{error}");
        assert!(error.contains(named), "{error}");
    };
    check(&["--service", "a b"], 3, "`a b`");
    check(&["--databases", "/nowhere/ä b"], 3, "/nowhere/ä b");
    assert_eq!(here.shared_memory(), Vec::<std::path::PathBuf>::new(), "a start that fails leaves nothing");
    check(&["--config", "/nowhere.toml"], 3, "/nowhere.toml");
    check(&["--threads", "100000"], 2, "0 to 1024");
    let config = here.file("color.toml", "[compute]\ncolor = 3");
    check(&["--config", config.to_str().unwrap()], 3, "color");
    check(&["--log", "a=b=c"], 3, "log.filter");
    check(&["--nonsense"], 2, "--nonsense");
}

#[test]
fn a_killed_daemon_is_noticed_and_can_be_started_again() {
    let here = TestDirectory::new("killed");
    here.database("slow", "slow");
    here.database("vase", "tetra");
    let first = Child::start(&mut role(&here, "daemon", ""));
    let service = connect(Some(&here));
    let slow = service.object("slow", timeout()).unwrap();
    let mut ticket = slow.strike(&impact()).unwrap();
    while service.status(timeout()).unwrap().running == 0 {
        std::thread::yield_now();
    }
    first.kill();
    assert_eq!(ticket.wait(timeout()).err().unwrap().kind, ErrorKind::Lost);
    assert_eq!(Client::connect_at(&here.place, timeout()).err().unwrap().kind, ErrorKind::NoDaemon);
    let second = Child::start(&mut role(&here, "daemon", ""));
    let vase = connect(Some(&here)).object("vase", timeout()).unwrap();
    assert!(vase.strike(&impact()).unwrap().wait(timeout()).is_ok());
    // The connection to the first daemon works with the second one as well.
    let vase = service.object("vase", timeout()).unwrap();
    assert!(vase.strike(&impact()).unwrap().wait(timeout()).is_ok());
    drop((vase, service, slow, ticket));
    assert_eq!(second.terminate().code(), Some(0));
}

#[test]
fn daemons_killed_while_starting_leave_nothing_in_the_way() {
    let here = TestDirectory::new("early");
    for delay_ms in 0..12 {
        let child = Child::begin(&mut shatterd(&here));
        std::thread::sleep(Duration::from_millis(delay_ms));
        child.kill();
    }
    let daemon = Child::start(&mut shatterd(&here));
    assert_eq!(shatter(&here, &["status"]).0, 0);
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn results_of_a_killed_client_are_released() {
    let here = TestDirectory::new("hoarder");
    here.database("vase", "tetra");
    let settings = "[results]\nbuckets = 2\nheld_max = 2\nprefault_buckets = 1";
    let daemon = Child::start(&mut role(&here, "daemon", settings));
    let holding_client = Child::start(&mut role(&here, "hoarder", ""));
    let service = connect(Some(&here));
    let vase = service.object("vase", timeout()).unwrap();
    let strike = || vase.strike(&impact()).unwrap().wait(timeout());
    assert_eq!(strike().err().unwrap().kind, ErrorKind::Busy);
    holding_client.kill();
    let deadline = timeout();
    let result = loop {
        match strike() {
            Err(error) if error.kind == ErrorKind::Busy && !deadline.passed() => std::thread::yield_now(),
            other => break other.unwrap(),
        }
    };
    assert_eq!(result.fragments().len(), 1);
    drop((result, vase, service));
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn the_command_line_strikes_and_prints_one_document() {
    let here = TestDirectory::new("strikes");
    here.database("vase", "tetra");
    let _daemon = Child::start(&mut role(&here, "daemon", ""));
    let strike = ["impact", "vase", "--point", "-0.1,0,0", "--impulse", "-1,0.5,0", "--degree", "3", "--json"];
    let (code, out) = shatter(&here, &strike);
    let document = json(&out);
    assert_eq!((code, document["status"].as_str()), (0, Some("ok")), "{out}");
    assert_eq!(document["fragments"].as_array().unwrap().len(), 3);
    assert!(document["fragments"].as_array().unwrap().iter().all(|fragment| fragment["closed"] == true));
    let names = document["stages"].as_array().unwrap().iter().map(|stage| stage["name"].as_str().unwrap());
    assert!(names.eq(StageKind::ALL.iter().map(|stage| stage.name()).chain(Effect::ALL.map(Effect::name))), "{out}");
    let keys = ["object", "handle", "gamma_j_m2", "e1_over_gamma", "sites", "fracture_degree", "degree_source"];
    let keys = keys.into_iter().chain(["quality", "iterations", "time_ns"]).chain([
        "confidence",
        "capped",
        "stop_reason",
        "error_estimate",
        "round_trip_ns",
    ]);
    for key in keys.chain(["response_bytes", "output_hash", "sections"]) {
        assert!(document.get(key).is_some(), "{key}: {out}");
    }
    let asked = |key: &str, out: &str| json(out)["quality"][key].as_f64();
    let (_, bounded) = shatter(&here, &[&strike[..], &["--error", "0.25", "--time-ms", "50"]].concat());
    assert_eq!((asked("error_max", &bounded), asked("time_ms_max", &bounded)), (Some(0.25), Some(50.0)), "{bounded}");
    assert_eq!((asked("error_max", &out), asked("time_ms_max", &out)), (None, None), "{out}");
    assert!(asked("reduced_error_max", &out).is_some(), "{out}");
    let hash = |text: &str| json(text)["output_hash"].clone();
    assert_eq!(hash(&out), hash(&shatter(&here, &strike).1));
    let (code, out) = shatter(&here, &["threshold", "vase", "--point", "0,0,0", "--direction", "0,-3,0", "--json"]);
    assert_eq!((code, json(&out)["impulse_ns"].as_f64()), (0, Some(0.5)), "{out}");
    let (code, out) = shatter(&here, &["impact", "vase", "--point", "0,0,0", "--impulse", "0,0,0", "--json"]);
    assert_eq!((code, json(&out)["error"]["kind"].as_str()), (3, Some("impulse")), "{out}");
    for (flag, value, at) in [("--error", "2", "error_max"), ("--time-ms", "0", "time_ms_max")] {
        let (code, out) = shatter(&here, &[&strike[..], &[flag, value]].concat());
        assert_eq!((code, json(&out)["error"]["at"].as_str()), (3, Some(at)), "{out}");
    }
    let (code, out) = shatter(&here, &[&strike[..], &["--quality", "fine"]].concat());
    assert!(code == 2 && out.contains("film"), "{out}");
    let folder = here.databases().join("broken vase ä");
    let (code, out) = shatter(&here, &[&strike[..], &["--out", folder.to_str().unwrap()]].concat());
    assert!(code == 0 && json(&out)["file"].as_str().unwrap().ends_with("vase.glb"), "{out}");
    assert!(std::fs::read(folder.join("vase.glb")).unwrap().starts_with(b"glTF"));
    let (code, out) = shatter(&here, &[&strike[..], &["--out", "/proc/nowhere/x.glb"]].concat());
    assert_eq!((code, json(&out)["error"]["kind"].as_str()), (3, Some("output")), "{out}");
    let (_, out) = shatter(&here, &[&strike[..], &["--out", "/dev/full/x.glb"]].concat());
    let message = json(&out)["error"]["message"].as_str().unwrap().to_owned();
    assert_eq!(message, "/dev/full is a device, not a folder; choose another path (--out)");
    for arguments in [&["list"][..], &["status"], &["impact", "vase", "--point", "0,0,0", "--impulse", "1,0,0"]] {
        let (code, out) = shatter(&here, arguments);
        assert!(code == 0 && !out.is_empty(), "{arguments:?}");
    }
}

/// The daemon notifies a supervisor that it serves, and that it ends.
#[test]
fn the_supervisor_is_notified() {
    let here = TestDirectory::new("notified");
    let socket = here.databases().join("notify");
    let listener = std::os::unix::net::UnixDatagram::bind(&socket).unwrap();
    listener.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let received = move || {
        let mut buffer = [0; 256];
        let length = listener.recv(&mut buffer).unwrap();
        String::from_utf8_lossy(&buffer[..length]).into_owned()
    };
    let mut command: Command = shatterd(&here);
    let daemon = Child::start(command.env("NOTIFY_SOCKET", &socket).env("WATCHDOG_USEC", "100000"));
    let first = received();
    assert!(first.contains("READY=1") && first.contains("STATUS=serving: 0 of 0 objects ready"), "{first}");
    // Twice per period of the watchdog, as long as its event loop runs.
    (0..3).for_each(|_| assert_eq!(received().trim(), "WATCHDOG=1"));
    daemon.signal(Signal::TERM);
    let last = std::iter::repeat_with(received).find(|text| !text.contains("WATCHDOG=1")).unwrap();
    assert!(last.contains("STOPPING=1") && last.contains("STATUS=ending"), "{last}");
    daemon.finish();
}

/// The unit runs the program that `cargo install` installs, with valid arguments.
#[test]
fn the_unit_file_starts_the_daemon_as_it_is() {
    let unit = include_str!("../../config/shatterd.service");
    let value = |key: &str| unit.lines().find_map(|line| line.strip_prefix(key)).unwrap();
    let (program, arguments) = value("ExecStart=").split_once(' ').unwrap();
    assert_eq!(program, "%h/.cargo/bin/shatterd");
    let here = TestDirectory::new("unit");
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    let daemon = Child::start(command.args(arguments.split(' ')));
    daemon.signal(Signal::HUP);
    assert_eq!(daemon.terminate().code(), Some(0));
    let seconds = |key| value(key).trim_end_matches('s').parse::<f64>().unwrap();
    let drain_s = shatter_server::config::Config::parse("", "default").unwrap().times.drain_s;
    assert!(seconds("TimeoutStopSec=") >= drain_s + 5.0, "a supervisor must not cut the drain short");
    assert_eq!(value("Type="), "notify");
}

#[test]
fn the_live_view_goes_on_when_the_daemon_is_replaced() {
    let here = TestDirectory::new("view");
    let first = Child::start(&mut shatterd(&here));
    let mut view = shatter_program(&here);
    let mut view =
        view.args(["status", "--watch", "--json"]).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(view.stdout.take().unwrap()).lines().map(|line| json(&line.unwrap()));
    let pid = |line: Value| line["pid"].as_u64().map(|pid| pid as u32);
    assert_eq!(pid(lines.next().unwrap()), Some(first.id()));
    first.kill();
    let absent = lines.find(|line| line["error"].is_object()).unwrap();
    assert!(["lost", "no_daemon"].contains(&absent["error"]["kind"].as_str().unwrap()), "{absent}");
    let second = Child::start(&mut shatterd(&here));
    let back = lines.find(|line| line["pid"].is_u64()).unwrap();
    assert_eq!((&back["restarts"], &back["crashes"]), (&1.into(), &1.into()), "{back}");
    assert_eq!(pid(back), Some(second.id()));
    view.kill().unwrap();
    view.wait().unwrap();
}
