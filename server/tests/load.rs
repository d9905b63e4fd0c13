//! `shatter load` against a daemon in this process with a toy engine: real client processes, and an outcome for every request.

mod support;

use serde_json::Value;
use support::{InProcess, TestDirectory, shatter};

fn daemon() -> InProcess {
    let here = TestDirectory::new("load");
    for name in ["vase", "arch"] {
        here.database(name, "tetra");
    }
    here.database("slow", "slow");
    InProcess::start(here, "")
}

/// Document of a run; checks that every request has one outcome.
fn run(daemon: &InProcess, arguments: &[&str]) -> Value {
    let all: Vec<&str> = ["load", "--seconds", "1", "--json"].iter().chain(arguments).copied().collect();
    let (code, text) = shatter(&daemon.here, &all);
    assert_eq!(code, 0, "{text}");
    let report: Value = serde_json::from_str(&text).unwrap();
    let ends: u64 = ["ok", "busy", "late", "failed"].iter().map(|end| report[*end].as_u64().unwrap()).sum();
    assert_eq!(report["sent"].as_u64(), Some(ends), "{report}");
    report
}

#[test]
fn many_processes_strike_by_schedule_and_all_is_accounted_for() {
    let daemon = daemon();
    let report = run(&daemon, &["vase", "arch", "--clients", "3", "--rate", "150"]);
    let (sent, ok) = (report["sent"].as_u64().unwrap(), report["ok"].as_u64().unwrap());
    assert!((90..220).contains(&sent) && ok == sent, "{report}");
    assert_eq!(report["per_client_ok"].as_array().unwrap().len(), 3);
    assert!(report["latency_us"]["p50"].as_u64() <= report["latency_us"]["max"].as_u64(), "{report}");
}

#[test]
fn a_closed_loop_waits() {
    let daemon = daemon();
    let closed = run(&daemon, &["vase", "--clients", "2", "--closed"]);
    assert!(closed["ok"].as_u64() > Some(20) && closed["rate_hz"].is_null(), "{closed}");
}

#[test]
fn several_rates_of_a_mix_are_run_one_after_the_other() {
    let daemon = daemon();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("load");
    let mix = folder.path().join("mix.toml");
    std::fs::write(&mix, "[[strike]]\nobject = \"vase\"\nweight = 3\n[[strike]]\nobject = \"arch\"\ndegree = 2")
        .unwrap();
    let (out_, mix) = (out.to_str().unwrap(), mix.to_str().unwrap());
    let (code, text) =
        shatter(&daemon.here, &["load", "--seconds", "1", "--rate", "20,40", "--mix", mix, "--out", out_, "--json"]);
    assert_eq!(code, 0, "{text}");
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["runs"].as_array().unwrap().len(), 2);
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert!(read("load.svg").contains("highest throughput"));
    let strikes: u64 = report["runs"].as_array().unwrap().iter().map(|run| run["sent"].as_u64().unwrap()).sum();
    assert_eq!(read("load.csv").lines().count() as u64, 1 + strikes);
}

#[test]
fn unknown_load_targets_are_rejected_by_name() {
    let daemon = daemon();
    let refused = |arguments: &[&str]| {
        let all: Vec<&str> = ["load", "--json"].iter().chain(arguments).copied().collect();
        let (code, text) = shatter(&daemon.here, &all);
        let report: Value = serde_json::from_str(&text).unwrap();
        (code, report["error"]["kind"].as_str().unwrap().to_owned())
    };
    assert_eq!(refused(&["nothing", "--rate", "5"]), (3, "unknown_object".to_owned()));
    assert_eq!(refused(&["vase", "--mix", "/nowhere", "--rate", "5"]).0, 2);
    assert_eq!(refused(&["--mix", "/nowhere", "--rate", "5"]), (3, "configuration".to_owned()));
    for wrong in [["--rate", "0"], ["--rate", "x"], ["--clients", "0"], ["--seconds", "-1"]] {
        assert_eq!(refused(&wrong), (2, "usage".to_owned()), "{wrong:?}");
    }
    assert_eq!(refused(&["vase"]).0, 2, "a rate or --closed");
}
