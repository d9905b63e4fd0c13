//! Other pages and other programs against the server of the page: each is refused, and the page stays usable.

use shatter_view::{PageFile, PageFiles, ViewDaemon, ViewOptions, ViewServer};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::Notify;

/// Longest wait for a reply.
const TIMEOUT: Duration = Duration::from_secs(20);

const FILES: PageFiles =
    PageFiles(&[PageFile { path: "", media_type: "text/html; charset=utf-8", bytes: b"<title>page</title>" }]);

/// A server on a thread of its own. Dropping it ends the server.
struct Server {
    address: String,
    stop: Arc<Notify>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    fn start() -> Self {
        let (sender, addresses) = channel();
        let stop = Arc::new(Notify::new());
        let stopped = stop.clone();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let daemon = Arc::new(ViewDaemon::of_service("view-attacks-without-daemon"));
                let server =
                    ViewServer::open(ViewOptions { port: 0, page: FILES, daemon, recording: None }).await.unwrap();
                sender.send(server.address()).unwrap();
                server.serve(&stopped).await;
            });
        });
        Self { address: addresses.recv_timeout(TIMEOUT).unwrap(), stop, thread: Some(thread) }
    }

    /// `127.0.0.1:PORT`.
    fn host(&self) -> &str {
        self.address.strip_prefix("http://").unwrap().split('/').next().unwrap()
    }

    fn token_path(&self) -> &str {
        self.address.strip_prefix("http://").unwrap().split_once('/').unwrap().1
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream
    }

    /// The head of the reply to a GET with these headers.
    fn get(&self, path: &str, headers: &str) -> String {
        let mut stream = self.connect();
        write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    }

    fn own(&self) -> String {
        format!("Host: {}\r\n", self.host())
    }

    /// Redeems the token: the folder of the page, and the header with the cookie.
    fn enter(&self) -> (String, String) {
        let reply = self.get(&format!("/{}", self.token_path()), &self.own());
        assert!(reply.starts_with("HTTP/1.1 303"), "{reply}");
        let header = |name: &str| {
            let line = reply.lines().find(|line| line.to_lowercase().starts_with(name)).unwrap();
            line.split_once(": ").unwrap().1.to_owned()
        };
        let cookie = header("set-cookie");
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
        (header("location"), format!("Cookie: {}\r\n", cookie.split(';').next().unwrap()))
    }

    /// Opens the WebSocket; the reply's head must have this status.
    fn socket(&self, folder: &str, cookie: &str, origin: &str, status: &str) -> TcpStream {
        let mut stream = self.connect();
        let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                       Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
        write!(stream, "GET {folder}socket HTTP/1.1\r\n{}{cookie}{origin}{upgrade}\r\n", self.own()).unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            head.push(byte[0]);
        }
        let head = String::from_utf8(head).unwrap();
        assert!(head.starts_with(&format!("HTTP/1.1 {status}")), "{head}");
        stream
    }

    fn origin(&self) -> String {
        format!("Origin: http://{}\r\n", self.host())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.notify_one();
        self.thread.take().unwrap().join().unwrap();
    }
}

/// Sends a short text, masked with zeros as a client must.
fn send(stream: &mut TcpStream, text: &str) {
    let mut frame = vec![0x81, 0x80 | u8::try_from(text.len()).unwrap(), 0, 0, 0, 0];
    frame.extend(text.as_bytes());
    stream.write_all(&frame).unwrap();
}

/// The text of the next frame.
fn receive(stream: &mut TcpStream) -> String {
    let mut head = [0; 2];
    stream.read_exact(&mut head).unwrap();
    assert_eq!(head[0], 0x81);
    let mut length = usize::from(head[1]);
    if length == 126 {
        let mut long = [0; 2];
        stream.read_exact(&mut long).unwrap();
        length = usize::from(u16::from_be_bytes(long));
    }
    let mut text = vec![0; length];
    stream.read_exact(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// Whether the page answers a request over its WebSocket.
fn answers(stream: &mut TcpStream) -> bool {
    send(stream, r#"{"id":7,"op":"none"}"#);
    let reply = receive(stream);
    reply.contains("\"id\":7") && reply.contains("unknown_request")
}

#[test]
fn the_token_counts_once_and_the_page_is_closed_to_others() {
    let server = Server::start();
    let own = server.own();
    for path in
        ["/", "/?token=", "/?token=0123456789abcdef0123456789abcdef", "/socket", "/view.js", "/../../etc/passwd"]
    {
        let reply = server.get(path, &own);
        assert!(reply.starts_with("HTTP/1.1 403"), "{path}: {reply}");
    }
    let (folder, cookie) = server.enter();
    let again = server.get(&format!("/{}", server.token_path()), &own);
    assert!(again.starts_with("HTTP/1.1 403") && again.contains("shatter view"), "{again}");
    assert!(server.get(&folder, &own).starts_with("HTTP/1.1 403"), "no cookie");
    assert!(server.get(&folder, &format!("{own}Cookie: shatter-view=00\r\n")).starts_with("HTTP/1.1 403"));
    let page = server.get(&folder, &format!("{own}{cookie}")).to_lowercase();
    assert!(page.starts_with("http/1.1 200") && page.ends_with("<title>page</title>"), "{page}");
    for header in [
        "content-security-policy: default-src 'none'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
    ] {
        assert!(page.contains(header), "{page}");
    }
    assert!(server.get(&format!("{folder}none"), &format!("{own}{cookie}")).starts_with("HTTP/1.1 404"));
}

#[test]
fn another_host_or_origin_is_refused() {
    let server = Server::start();
    let (folder, cookie) = server.enter();
    for host in ["Host: evil.example\r\n", "Host: 127.0.0.1\r\n", "Host: evil.example:80\r\n"] {
        assert!(server.get(&folder, &format!("{host}{cookie}")).starts_with("HTTP/1.1 403"), "{host}");
    }
    for origin in ["Origin: http://evil.example\r\n", "Origin: null\r\n", "Origin: https://127.0.0.1\r\n"] {
        assert!(
            server.get(&folder, &format!("{}{cookie}{origin}", server.own())).starts_with("HTTP/1.1 403"),
            "{origin}"
        );
        server.socket(&folder, &cookie, origin, "403");
    }
    server.socket(&folder, &cookie, "", "403");
    server.socket(&folder, "", &server.origin(), "403");
    assert!(answers(&mut server.socket(&folder, &cookie, &server.origin(), "101")));
}

#[test]
fn a_frame_of_a_gigabyte_is_refused_by_its_header() {
    let server = Server::start();
    let (folder, cookie) = server.enter();
    let mut page = server.socket(&folder, &cookie, &server.origin(), "101");
    let mut hostile = server.socket(&folder, &cookie, &server.origin(), "101");
    let mut header = vec![0x82, 0x80 | 127];
    header.extend((1_u64 << 30).to_be_bytes());
    header.extend([0; 4]);
    hostile.write_all(&header).unwrap();
    // Not one byte of the gigabyte was sent: the connection ends by its length alone.
    let mut rest = Vec::new();
    match hostile.read_to_end(&mut rest) {
        Ok(_) => {}
        Err(error) => assert_eq!(error.kind(), ErrorKind::ConnectionReset),
    }
    assert!(answers(&mut page));
}

#[test]
fn a_thousand_silent_connections_do_not_keep_the_page_out() {
    let server = Server::start();
    let (folder, cookie) = server.enter();
    let mut page = server.socket(&folder, &cookie, &server.origin(), "101");
    for _ in 0..4 {
        let silent: Vec<TcpStream> = (0..250).map(|_| server.connect()).collect();
        assert!(answers(&mut page));
        let reply = server.get(&folder, &format!("{}{cookie}", server.own()));
        assert!(reply.starts_with("HTTP/1.1 200"), "{reply}");
        drop(silent);
    }
}

#[test]
fn more_pages_than_allowed_are_told_so() {
    let server = Server::start();
    let (folder, cookie) = server.enter();
    let mut pages: Vec<TcpStream> = (0..4).map(|_| server.socket(&folder, &cookie, &server.origin(), "101")).collect();
    assert!(pages.iter_mut().all(answers));
    let mut fifth = server.socket(&folder, &cookie, &server.origin(), "101");
    let reply = receive(&mut fifth);
    assert!(reply.contains("busy") && reply.contains("4 pages"), "{reply}");
}

#[test]
fn a_request_without_a_daemon_names_the_service() {
    let server = Server::start();
    let (folder, cookie) = server.enter();
    let mut page = server.socket(&folder, &cookie, &server.origin(), "101");
    send(&mut page, r#"{"id":1,"op":"objects"}"#);
    let reply = receive(&mut page);
    assert!(reply.contains("no_daemon") && reply.contains("view-attacks-without-daemon"), "{reply}");
}
