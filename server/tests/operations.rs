//! The loopback port under connections that send no request: supervisors still get replies.

mod support;

use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::DirBuilderExt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use support::{InProcess, TestDirectory, shatter_program};

/// Connections held open: ten times as many as the port serves at once.
const HELD: usize = 640;

/// Timeout of a probe: less than two rounds of timeouts of idle connections, 3 s each.
const PROBE: Duration = Duration::from_secs(5);

fn daemon() -> (InProcess, u16) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    (InProcess::start(TestDirectory::new("port"), &format!("[operations]\nport = {port}")), port)
}

/// Status line of a reply to `GET /healthz`.
fn probe(port: u16) -> String {
    reply(port, "/healthz").lines().next().unwrap_or_default().to_owned()
}

/// Reply to a request for `path`.
fn reply(port: u16, path: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(PROBE)).unwrap();
    stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).unwrap();
    let mut text = String::new();
    let read = stream.read_to_string(&mut text);
    assert!(read.is_ok(), "no reply within {PROBE:?}: {read:?}");
    text
}

#[test]
fn a_misspelled_service_is_told_the_one_that_runs() {
    let (daemon, _) = daemon();
    let mut command = shatter_program(&daemon.here);
    let variable = command.get_envs().find(|(name, _)| *name == "SHATTER_SERVICE");
    let own = variable.and_then(|(_, value)| value?.to_str()).unwrap().to_owned();
    let output = command.args(["list", "--service", &format!("{own}x")]).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{error}");
    assert!(
        error.contains(&format!("service `{own}` runs: choose it (--service, SHATTER_SERVICE); else start one")),
        "{error}"
    );
}

#[test]
fn idle_connections_keep_no_probe_waiting() {
    let (_daemon, port) = daemon();
    let held: Vec<TcpStream> = (0..HELD).map(|_| TcpStream::connect(("127.0.0.1", port)).unwrap()).collect();
    for _ in 0..5 {
        assert!(probe(port).contains("200"));
    }
    drop(held);
}

#[test]
fn headers_that_arrive_byte_by_byte_keep_no_probe_waiting() {
    let (_daemon, port) = daemon();
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let header = b"GET /healthz HTTP/1.1\r\nX-Slow: ";
            let mut held: Vec<TcpStream> = Vec::new();
            while !over.load(Ordering::Relaxed) {
                // A closed connection is opened again.
                held.retain_mut(|stream| stream.write_all(b"a").is_ok());
                while held.len() < HELD {
                    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
                    let _ = stream.write_all(header);
                    held.push(stream);
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        std::thread::sleep(Duration::from_millis(200));
        let replies: Vec<_> = (0..5).map(|_| std::panic::catch_unwind(|| probe(port))).collect();
        over.store(true, Ordering::Relaxed);
        for reply in replies {
            assert!(reply.is_ok_and(|status| status.contains("200")));
        }
    });
}

#[test]
fn a_header_that_never_ends_is_closed_without_any_other_connection() {
    let (_daemon, port) = daemon();
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(PROBE)).unwrap();
    stream.write_all(b"GET /healthz HTTP/1.1\r\nX-Slow: ").unwrap();
    let mut rest = Vec::new();
    let closed = stream.read_to_end(&mut rest);
    assert!(closed.is_ok() && !rest.starts_with(b"HTTP/1.1 200"), "{closed:?}");
}

#[test]
fn a_service_without_a_place_for_another_client_is_not_ready() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let settings = format!("[service]\nclients_max = 2\n[operations]\nport = {port}");
    let daemon = InProcess::start(TestDirectory::new("full"), &settings);
    let first = daemon.connect();
    assert!(reply(port, "/readyz").contains(" 200 "));
    let second = daemon.connect();
    let full = reply(port, "/readyz");
    assert!(
        full.contains(" 503 ") && full.contains("2 clients are connected, as many as the service admits"),
        "{full}"
    );
    assert!(probe(port).contains("200"));
    let strike = ["impact", "bar", "--point", "0,0,0", "--impulse", "1,0,0", "--wait", "0"];
    let output = shatter_program(&daemon.here).args(strike).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    let (_, waited) = error.split_once("; waited ").unwrap();
    let waited_s: f64 = waited.split(' ').next().unwrap().parse().unwrap();
    // A client that finds no place tries again for a second.
    assert!(error.contains("service.clients_max") && waited_s >= 0.9, "{error}");
    drop((first, second));
    assert!(reply(port, "/readyz").contains(" 200 "));
}

/// Without a writer, opening a pipe would never end.
#[test]
fn pipes_in_the_runtime_folder_keep_no_client_waiting() {
    let (daemon, _) = daemon();
    let base = daemon.here.place.folder.parent().unwrap().to_owned();
    for (service, file) in [("pipes", "lock"), ("nothing", "hello.json")] {
        let folder = base.join(service);
        std::fs::DirBuilder::new().mode(0o700).create(&folder).unwrap();
        mknodat(CWD, folder.join(file), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        for name in [service, "another"] {
            let output = shatter_program(&daemon.here).args(["list", "--service", name]).output().unwrap();
            assert_eq!(output.status.code(), Some(4), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
