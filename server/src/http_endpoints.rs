//! Loopback HTTP port for supervisors and scrapers: liveness, readiness and metrics.
//!
//! It carries no requests or results. Every reply comes from the daemon's event loop, so a daemon whose loop hangs fails its health check.

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{ALLOW, CONTENT_TYPE, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use shatter_proto::{Error, ErrorKind};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio::time::timeout;

/// Time for the loop to reply. It runs at least once per tick, so a longer silence means that it hangs.
const TIMEOUT: Duration = Duration::from_secs(2);

/// Limits of connections and of their duration: any user of the machine can connect, and each connection holds a descriptor.
const CONNECTIONS_MAX: usize = 64;
const CONNECTION: Duration = Duration::from_secs(3);

/// Time for a connection to send the header of its request.
const HEADER: Duration = Duration::from_secs(1);

/// Pause after a connection could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);

/// Content type of metrics (OpenMetrics 1.0).
const OPENMETRICS: HeaderValue = HeaderValue::from_static("application/openmetrics-text; version=1.0.0; charset=utf-8");
const TEXT: HeaderValue = HeaderValue::from_static("text/plain; charset=utf-8");

/// State of the daemon, reported by its event loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DaemonReport {
    /// Whether the daemon accepts requests.
    pub ready: bool,
    /// Summary in one line.
    pub summary: String,
    /// Metrics as text.
    pub metrics: String,
}

/// Inquiry to the daemon's event loop.
pub type DaemonInquiry = oneshot::Sender<DaemonReport>;

/// Loopback HTTP port; dropping it closes the port.
pub struct OperationsPort {
    task: Option<JoinHandle<()>>,
    inquiries: mpsc::Receiver<DaemonInquiry>,
    /// Keeps the channel open if there is no port.
    _inquiry_sender: mpsc::Sender<DaemonInquiry>,
}

impl OperationsPort {
    /// Listens on `port` of the loopback address; 0: no port. Needs a tokio runtime.
    ///
    /// # Errors
    /// `port`.
    pub async fn open(port: u16) -> Result<Self, Error> {
        let (inquiry_sender, inquiries) = mpsc::channel(CONNECTIONS_MAX);
        if port == 0 {
            return Ok(Self { task: None, inquiries, _inquiry_sender: inquiry_sender });
        }
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        let taken = |error: std::io::Error| {
            Error::new(
                ErrorKind::Port,
                "operations.port",
                format!("cannot listen on {address}: {error}; choose another operations.port"),
            )
        };
        let listener = TcpListener::bind(address).await.map_err(taken)?;
        tracing::info!(%address, "health and metrics");
        let task = tokio::spawn(listen(listener, inquiry_sender.clone()));
        Ok(Self { task: Some(task), inquiries, _inquiry_sender: inquiry_sender })
    }

    /// Next inquiry. Waits without end if there is none.
    pub async fn next(&mut self) -> DaemonInquiry {
        match self.inquiries.recv().await {
            Some(inquiry) => inquiry,
            // Unreachable while `_inquiry_sender` lives; a closed port waits without end.
            None => std::future::pending().await,
        }
    }
}

impl Drop for OperationsPort {
    fn drop(&mut self) {
        if let Some(task) = &self.task {
            task.abort();
        }
    }
}

/// Open connection.
struct Connection {
    task: JoinHandle<()>,
    /// Whether its request has arrived completely.
    has_request: Arc<AtomicBool>,
}

/// Open connections, the oldest first.
#[derive(Default)]
struct Connections(VecDeque<Connection>);

impl Connections {
    /// Makes space for one more: closes the oldest connection without a request, or the oldest one if all have one. New
    /// connections are always accepted, so silent ones cannot keep a supervisor out.
    fn free_slot(&mut self) {
        self.0.retain(|connection| !connection.task.is_finished());
        while self.0.len() >= CONNECTIONS_MAX {
            let idle = self.0.iter().position(|connection| !connection.has_request.load(Ordering::Relaxed));
            if let Some(closed) = self.0.remove(idle.unwrap_or(0)) {
                closed.task.abort();
                tracing::debug!("closed an idle connection to the operations port to accept another");
            }
        }
    }
}

impl Drop for Connections {
    fn drop(&mut self) {
        self.0.iter().for_each(|connection| connection.task.abort());
    }
}

/// Accepts connections, a bounded number at once.
async fn listen(listener: TcpListener, inquiry_sender: mpsc::Sender<DaemonInquiry>) {
    let mut connections = Connections::default();
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                connections.free_slot();
                let has_request = Arc::new(AtomicBool::new(false));
                let serve = serve(stream, inquiry_sender.clone(), has_request.clone());
                connections.0.push_back(Connection { task: tokio::spawn(serve), has_request });
                // Lets the server read a request that arrived with its connection before newer connections can close it.
                tokio::task::yield_now().await;
            }
            Err(error) => {
                tracing::warn!(%error, "the operations port cannot accept a connection");
                tokio::time::sleep(PAUSE).await;
            }
        }
    }
}

/// Serves one connection with one request.
async fn serve(stream: TcpStream, inquiry_sender: mpsc::Sender<DaemonInquiry>, has_request: Arc<AtomicBool>) {
    let service = service_fn(|request| {
        has_request.store(true, Ordering::Relaxed);
        reply(request, &inquiry_sender)
    });
    let mut server = http1::Builder::new();
    let server = server.keep_alive(false).timer(TokioTimer::new()).header_read_timeout(HEADER);
    match timeout(CONNECTION, server.serve_connection(TokioIo::new(stream), service)).await {
        Ok(Ok(())) => {}
        Ok(Err(error)) => tracing::debug!(%error, "operations port"),
        Err(_) => tracing::debug!("a connection to the operations port took too long"),
    }
}

async fn reply(
    request: Request<Incoming>,
    inquiry_sender: &mpsc::Sender<DaemonInquiry>,
) -> Result<Response<Full<Bytes>>, Infallible> {
    if !matches!(*request.method(), Method::GET | Method::HEAD) {
        let mut rejection = response(StatusCode::METHOD_NOT_ALLOWED, TEXT, "only GET and HEAD\n".to_owned());
        rejection.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
        return Ok(rejection);
    }
    let path = request.uri().path();
    if !matches!(path, "/healthz" | "/readyz" | "/metrics") {
        return Ok(response(StatusCode::NOT_FOUND, TEXT, "not found; use /healthz, /readyz or /metrics\n".to_owned()));
    }
    let Some(report) = ask(inquiry_sender).await else {
        return Ok(response(
            StatusCode::SERVICE_UNAVAILABLE,
            TEXT,
            "the daemon's loop does not reply; restart the daemon\n".to_owned(),
        ));
    };
    Ok(match path {
        "/metrics" => response(StatusCode::OK, OPENMETRICS, report.metrics),
        "/readyz" if !report.ready => response(StatusCode::SERVICE_UNAVAILABLE, TEXT, report.summary),
        _ => response(StatusCode::OK, TEXT, report.summary),
    })
}

/// Asks the event loop for a report; `None` if it does not reply in time.
async fn ask(inquiry_sender: &mpsc::Sender<DaemonInquiry>) -> Option<DaemonReport> {
    let (inquiry, report) = oneshot::channel();
    inquiry_sender.try_send(inquiry).ok()?;
    timeout(TIMEOUT, report).await.ok()?.ok()
}

fn response(status: StatusCode, kind: HeaderValue, body: String) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::new(Bytes::from(body)));
    *response.status_mut() = status;
    response.headers_mut().insert(CONTENT_TYPE, kind);
    response
}
