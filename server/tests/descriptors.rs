//! A daemon with few descriptors serves again once its clients are gone. Alone in its process, because the transport's descriptors
//! outlive `exec`.

mod support;

use std::process::Stdio;
use support::{Child, TestDirectory, bar, eventually, shatter, shatter_program, shatterd, under};

/// Descriptors of the daemon: enough for some clients, too few for all.
const LIMIT: &str = "ulimit -n 64";

/// Clients at once.
const CLIENTS: usize = 15;

#[test]
fn a_daemon_recovers_after_it_ran_out_of_descriptors() {
    let here = TestDirectory::new("descriptors");
    here.database("bar", bar(0.06));
    let daemon = Child::start(&mut under(&[], LIMIT, shatterd(&here)));
    let strike = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,3,0"];
    let start = |_| {
        let mut client = shatter_program(&here);
        client.args(strike).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let clients: Vec<_> = (0..CLIENTS).map(start).collect();
    let codes: Vec<_> = clients.into_iter().map(|mut client| client.wait().unwrap().code()).collect();
    println!("exit codes of {CLIENTS} clients at once: {codes:?}");
    eventually(|| "no client is served any more", || shatter(&here, &["list"]).0 == 0);
    // Segments are removed at the second check after they seemed to have no owner.
    std::thread::sleep(std::time::Duration::from_secs(3));
    for _ in 0..3 {
        let (code, text) = shatter(&here, &strike);
        assert_eq!(code, 0, "{text}");
    }
    assert_eq!(daemon.terminate().code(), Some(0));
}
