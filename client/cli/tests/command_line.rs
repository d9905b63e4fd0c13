//! The command line without a daemon: usage errors, absent daemons, versions, documents, exit codes.

use rustix::fs::{FlockOperation, flock};
use serde_json::Value;
use shatter_proto::name::ServiceName;
use shatter_transport::paths::ServicePaths;
use std::process::Command;

/// Runs `shatter` in an empty runtime directory; returns exit code, the document on stdout, and stderr.
fn shatter(runtime: &std::path::Path, arguments: &[&str]) -> (i32, Value, String) {
    let out = Command::new(env!("CARGO_BIN_EXE_shatter"))
        .env("XDG_RUNTIME_DIR", runtime)
        .env_remove("SHATTER_SERVICE")
        .args(arguments)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    let document = if text.is_empty() { Value::Null } else { serde_json::from_str(&text).expect("one document") };
    (out.status.code().unwrap(), document, String::from_utf8_lossy(&out.stderr).into_owned())
}

fn check(arguments: &[&str], exit: i32, kind: &str) {
    let runtime = tempfile::tempdir().unwrap();
    let (code, document, error) = shatter(runtime.path(), &[arguments, &["--json"]].concat());
    assert_eq!((code, document["error"]["kind"].as_str()), (exit, Some(kind)), "{arguments:?}: {document} {error}");
    for key in ["message", "fault", "retry", "at"] {
        assert!(document["error"].get(key).is_some(), "{key}");
    }
    assert!(!error.is_empty());
}

const STRIKE: [&str; 6] = ["impact", "vase", "--point", "-1,0,0", "--impulse", "-1,0.5,0"];

#[test]
fn a_missing_daemon_is_exit_4_and_named() {
    check(&["list"], 4, "no_daemon");
    check(&["status"], 4, "no_daemon");
    check(&["status", "--wait", "0.05"], 4, "no_daemon");
    check(&STRIKE, 4, "no_daemon");
    check(&[&STRIKE[..], &["--lift", "surface_diffusion"]].concat(), 4, "no_daemon");
    check(&["threshold", "vase", "--point", "-1,-2,-3", "--direction", "-1,0,0"], 4, "no_daemon");
    check(&["list", "--service", "other-1"], 4, "no_daemon");
}

#[test]
fn usage_errors_are_exit_2_and_one_document_too() {
    check(&["impact", "vase"], 2, "usage");
    check(&["impact", "vase", "--point", "0,0"], 2, "usage");
    check(&["impact", "vase", "--point", "0,0,0", "--impulse", "a,b,c"], 2, "usage");
    check(&[&STRIKE[..], &["--point", "1,2,3"]].concat(), 2, "usage");
    check(&[&STRIKE[..], &["--degree", "guessed"]].concat(), 2, "usage");
    check(&[&STRIKE[..], &["--lift", "sideways"]].concat(), 2, "usage");
    check(&[&STRIKE[..], &["--convention", "maya"]].concat(), 2, "usage");
    check(&[&STRIKE[..], &["--nonsense"]].concat(), 2, "usage");
    check(&["status", "--wait", "-1"], 2, "usage");
    check(&[], 2, "usage");
}

#[test]
fn a_bad_service_name_is_exit_3() {
    check(&["list", "--service", "a/b"], 3, "service_name");
}

#[test]
fn help_and_version_are_exit_0() {
    for argument in ["--help", "--version"] {
        let out = Command::new(env!("CARGO_BIN_EXE_shatter")).arg(argument).output().unwrap();
        assert!(out.status.success() && !out.stdout.is_empty());
    }
}

#[test]
fn a_version_mismatch_names_both_versions() {
    let runtime = tempfile::tempdir().unwrap();
    let uid = rustix::process::geteuid().as_raw();
    let place = ServicePaths::new(&ServiceName::new("default").unwrap(), Some(runtime.path()), uid);
    place.create().unwrap();
    std::fs::write(place.hello(), r#"{"protocol": 9, "transport": "iceoryx2 1.2.3"}"#).unwrap();
    let lock = std::fs::File::create(place.lock()).unwrap();
    flock(&lock, FlockOperation::NonBlockingLockExclusive).unwrap();
    let (code, document, _) = shatter(runtime.path(), &["list", "--json"]);
    assert_eq!((code, document["error"]["kind"].as_str()), (4, Some("version_mismatch")), "{document}");
    let message = document["error"]["message"].as_str().unwrap();
    let own = format!("protocol {}", shatter_proto::PROTOCOL_VERSION);
    for version in ["protocol 9", "iceoryx2 1.2.3", &own, "iceoryx2 0.10.0"] {
        assert!(message.contains(version), "{message}");
    }
    // Without a process that holds the lock, the daemon counts as absent.
    drop(lock);
    let (code, document, _) = shatter(runtime.path(), &["list", "--json"]);
    assert_eq!((code, document["error"]["kind"].as_str()), (4, Some("no_daemon")), "{document}");
}

#[test]
fn a_runtime_folder_open_to_others_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let runtime = tempfile::tempdir().unwrap();
    let uid = rustix::process::geteuid().as_raw();
    let place = ServicePaths::new(&ServiceName::new("default").unwrap(), Some(runtime.path()), uid);
    place.create().unwrap();
    std::fs::set_permissions(&place.folder, std::fs::Permissions::from_mode(0o777)).unwrap();
    let (code, document, _) = shatter(runtime.path(), &["list", "--json"]);
    assert_eq!((code, document["error"]["kind"].as_str()), (3, Some("runtime_folder")), "{document}");
}
