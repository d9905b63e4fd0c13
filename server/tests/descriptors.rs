//! A daemon with few descriptors admits few clients, and serves again once they are gone. Alone in its process, because the transport's
//! descriptors outlive `exec`.

mod support;

use std::process::Stdio;
use support::{Child, TestDirectory, bar, eventually, shatter, shatter_program, shatterd, under};

/// Descriptors of the daemon: enough for one client, and for three.
const LIMITS: [&str; 2] = ["ulimit -n 71", "ulimit -n 90"];

/// Clients at once.
const CLIENTS: usize = 15;

#[test]
fn a_daemon_with_few_descriptors_serves_one_client_after_another() {
    LIMITS.into_iter().for_each(check);
}

fn check(limit: &str) {
    let here = TestDirectory::new("descriptors");
    here.database("bar", bar(0.06));
    let daemon = Child::start(&mut under(&[], limit, shatterd(&here)));
    let strike = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,3,0"];
    for round in 0..3 {
        let start = |_| {
            let mut client = shatter_program(&here);
            client.args(strike).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        };
        let mut clients: Vec<_> = (0..CLIENTS).map(start).collect();
        // Dead clients keep their descriptors until the daemon has cleaned up after them.
        clients.iter_mut().step_by(2).for_each(|client| client.kill().unwrap());
        let codes: Vec<_> = clients.into_iter().map(|mut client| client.wait().unwrap().code()).collect();
        println!("{limit}, round {round}: exit codes of {CLIENTS} clients at once: {codes:?}");
        eventually(|| "no client is served any more", || shatter(&here, &["list"]).0 == 0);
    }
    let (code, text) = shatter(&here, &strike);
    assert_eq!(code, 0, "{text}");
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn a_daemon_without_descriptors_for_a_client_does_not_start() {
    let here = TestDirectory::new("none");
    let output = under(&[], "ulimit -n 70", shatterd(&here)).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(error.contains("the limit of descriptors is 70; raise it to 71 or more"), "{error}");
}
