//! The HTTP server of the page, on the loopback address.

use crate::access::Access;
use crate::baking::Bakes;
use crate::connection_limit::OpenConnections;
use crate::daemon::ViewDaemon;
use crate::page_files::PageFiles;
use crate::recording::Recording;
use crate::socket::{self, SOCKETS_MAX};
use crate::worker::WorkerSetup;
use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderName, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use shatter_proto::{Error, ErrorKind};
use std::convert::Infallible;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, Semaphore};

/// Time for a connection to send the header of its request.
const HEADER_TIMEOUT: Duration = Duration::from_secs(2);

/// Largest header of a request, bytes.
const HEADER_BYTES_MAX: usize = 16 << 10;

/// Pause after a connection could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);

/// Sources that the page may load: itself alone. Textures of dropped meshes are blobs of the page.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self' blob: data:; \
                      worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Reply to a request without the token or the cookie.
const NO_ACCESS: &str = "This page belongs to the browser that opened the printed address first. Run `shatter view` again, and open the \
                         address that it prints.\n";

/// Options of the server.
pub struct ViewOptions {
    /// Port of 127.0.0.1; 0: any free one.
    pub port: u16,
    /// Files of the page.
    pub page: PageFiles,
    /// The daemon whose objects are struck.
    pub daemon: Arc<ViewDaemon>,
    /// The requests and results, if they are recorded.
    pub recording: Option<Arc<Recording>>,
}

/// A server that listens.
pub struct ViewServer {
    listener: TcpListener,
    shared: Arc<Shared>,
}

/// Parts that all connections use.
pub(crate) struct Shared {
    pub access: Access,
    pub page: PageFiles,
    pub sockets: Semaphore,
    pub worker: WorkerSetup,
}

impl ViewServer {
    /// Listens on the loopback address. Needs a tokio runtime.
    ///
    /// # Errors
    /// `port` if the port cannot be opened, `failed` without random numbers.
    pub async fn open(options: ViewOptions) -> Result<Self, Error> {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, options.port));
        let taken = |error: std::io::Error| {
            let message = format!("cannot listen on {address}: {error}; choose another --port, or 0 for any free one");
            Error::new(ErrorKind::Port, "--port", message)
        };
        let listener = TcpListener::bind(address).await.map_err(taken)?;
        let port = listener.local_addr().map_err(taken)?.port();
        let bakes = Arc::new(Bakes::open());
        let worker = WorkerSetup { daemon: options.daemon, recording: options.recording, bakes };
        let (access, page) = (Access::new(port)?, options.page);
        let sockets = Semaphore::new(SOCKETS_MAX);
        Ok(Self { listener, shared: Arc::new(Shared { access, page, sockets, worker }) })
    }

    /// Address of the page with the token, which only counts once.
    #[must_use]
    pub fn address(&self) -> String {
        self.shared.access.address()
    }

    /// Serves until `stop` is notified, then ends the bakes of its pages.
    pub async fn serve(&self, stop: &Notify) {
        self.accept(stop).await;
        self.shared.worker.bakes.end();
    }

    async fn accept(&self, stop: &Notify) {
        let mut connections = OpenConnections::default();
        loop {
            let accepted = tokio::select! {
                () = stop.notified() => return,
                accepted = self.listener.accept() => accepted,
            };
            match accepted {
                Ok((stream, _)) if connections.free_slot() => {
                    // A connection without it serves the page, too, but later.
                    let _ = stream.set_nodelay(true);
                    let is_trusted = Arc::new(AtomicBool::new(false));
                    let task = tokio::spawn(connection(stream, self.shared.clone(), is_trusted.clone()));
                    connections.add(task, is_trusted);
                    // A request that arrived with its connection is read before newer connections can close it.
                    tokio::task::yield_now().await;
                }
                Ok(_) => {}
                Err(error) => {
                    tracing::warn!(%error, "the page cannot accept a connection");
                    tokio::time::sleep(PAUSE).await;
                }
            }
        }
    }
}

/// Serves one connection: plain requests, or the WebSocket.
async fn connection(stream: TcpStream, shared: Arc<Shared>, is_trusted: Arc<AtomicBool>) {
    let (upgraded_sender, mut upgraded) = tokio::sync::mpsc::channel(1);
    let service = service_fn(|request| {
        let (shared, upgraded_sender) = (shared.clone(), upgraded_sender.clone());
        let is_trusted = is_trusted.clone();
        async move { Ok::<_, Infallible>(reply(request, &shared, &upgraded_sender, &is_trusted)) }
    });
    let mut server = http1::Builder::new();
    let server = server.timer(TokioTimer::new()).header_read_timeout(HEADER_TIMEOUT).max_buf_size(HEADER_BYTES_MAX);
    if let Err(error) = server.serve_connection(TokioIo::new(stream), service).with_upgrades().await {
        tracing::debug!(%error, "a connection of the page ended");
    }
    if let Ok(upgrade) = upgraded.try_recv() {
        socket::serve(upgrade, &shared).await;
    }
}

/// Replies to one request. Hosts and origins come first, so that no other page learns whether a path exists.
fn reply(
    mut request: Request<Incoming>,
    shared: &Shared,
    upgraded: &tokio::sync::mpsc::Sender<hyper::upgrade::OnUpgrade>,
    is_trusted: &AtomicBool,
) -> Response<Full<Bytes>> {
    let (access, headers) = (&shared.access, request.headers());
    let is_socket = headers.contains_key(header::UPGRADE);
    if !access.is_host(headers) {
        return text(StatusCode::FORBIDDEN, "wrong Host: open the address that `shatter view` printed\n");
    }
    if !access.is_origin(headers, is_socket) {
        return text(StatusCode::FORBIDDEN, "wrong Origin: only the page itself may ask\n");
    }
    if request.method() != Method::GET {
        return text(StatusCode::METHOD_NOT_ALLOWED, "only GET\n");
    }
    if request.uri().path() == "/" {
        let token = request.uri().query().and_then(|query| query.strip_prefix("token="));
        return if token.is_some_and(|token| access.redeem(token)) { admitted(access) } else { refused() };
    }
    let folder = access.folder();
    let Some(path) = request.uri().path().strip_prefix(&folder) else { return refused() };
    if !access.has_cookie(headers) {
        return refused();
    }
    if path == "socket" {
        let reply = socket::accept(headers);
        if reply.status() == StatusCode::SWITCHING_PROTOCOLS {
            is_trusted.store(true, Ordering::Relaxed);
            // The receiver lives as long as the connection.
            let _ = upgraded.try_send(hyper::upgrade::on(&mut request));
        }
        return secured(reply);
    }
    match shared.page.file(path) {
        Some(file) => {
            let mut response = Response::new(Full::new(Bytes::from_static(file.bytes)));
            response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(file.media_type));
            secured(response)
        }
        None => text(StatusCode::NOT_FOUND, "not found\n"),
    }
}

/// Sends the browser that has the token to the page.
fn admitted(access: &Access) -> Response<Full<Bytes>> {
    let mut response = text(StatusCode::SEE_OTHER, "");
    for (name, value) in [(header::SET_COOKIE, access.set_cookie()), (header::LOCATION, access.folder())] {
        if let Ok(value) = HeaderValue::from_str(&value) {
            response.headers_mut().insert(name, value);
        }
    }
    response
}

fn refused() -> Response<Full<Bytes>> {
    text(StatusCode::FORBIDDEN, NO_ACCESS)
}

fn text(status: StatusCode, body: &'static str) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::new(Bytes::from_static(body.as_bytes())));
    *response.status_mut() = status;
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8"));
    secured(response)
}

/// Adds the headers that keep other pages out.
fn secured(mut response: Response<Full<Bytes>>) -> Response<Full<Bytes>> {
    let fixed: [(HeaderName, &'static str); 6] = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ];
    for (name, value) in fixed {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}
