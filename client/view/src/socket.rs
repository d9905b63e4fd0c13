//! The WebSocket of the page: requests in, results out.

use crate::server::Shared;
use crate::worker::{self, PageMessage, Reply};
use futures_util::{SinkExt, StreamExt};
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{self, HeaderMap, HeaderValue};
use hyper::upgrade::OnUpgrade;
use hyper::{Response, StatusCode};
use hyper_util::rt::TokioIo;
use std::time::Duration;
use tokio::io::AsyncWriteExt;
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::TrySendError;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;
use tokio_tungstenite::tungstenite::protocol::frame::FrameHeader;
use tokio_tungstenite::tungstenite::protocol::frame::coding::{Data, OpCode};
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Error as SocketError, Message};

/// Open pages at once: each has a worker thread and a connection to the service.
pub(crate) const SOCKETS_MAX: usize = 4;

/// Largest message of the page, bytes: a mesh file. A longer one is refused by the length that its header announces.
const MESSAGE_BYTES_MAX: usize = 64 << 20;

/// Requests of a page that wait for its worker. Further ones are refused.
const WAITING_MAX: usize = 16;

/// Longest time for a page to take a message.
const SEND_TIMEOUT: Duration = Duration::from_secs(60);

/// Reply to the request for a WebSocket; its status says whether the connection becomes one.
pub(crate) fn accept(headers: &HeaderMap) -> Response<Full<Bytes>> {
    let is = |name: header::HeaderName, wanted: &str| {
        let value = headers.get(name).and_then(|value| value.to_str().ok());
        value.is_some_and(|value| value.split(',').any(|part| part.trim().eq_ignore_ascii_case(wanted)))
    };
    let asks = is(header::UPGRADE, "websocket") && is(header::CONNECTION, "upgrade");
    let key = headers.get(header::SEC_WEBSOCKET_KEY);
    let accepted = key.and_then(|key| HeaderValue::from_str(&derive_accept_key(key.as_bytes())).ok());
    let mut response = Response::new(Full::default());
    match accepted.filter(|_| asks && is(header::SEC_WEBSOCKET_VERSION, "13")) {
        Some(accepted) => {
            *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
            let fields = response.headers_mut();
            fields.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
            fields.insert(header::CONNECTION, HeaderValue::from_static("Upgrade"));
            fields.insert(header::SEC_WEBSOCKET_ACCEPT, accepted);
        }
        None => *response.status_mut() = StatusCode::UPGRADE_REQUIRED,
    }
    response
}

/// Serves one page until it goes away.
pub(crate) async fn serve(upgrade: OnUpgrade, shared: &Shared) {
    let Ok(upgraded) = upgrade.await else { return };
    let config =
        WebSocketConfig::default().max_message_size(Some(MESSAGE_BYTES_MAX)).max_frame_size(Some(MESSAGE_BYTES_MAX));
    let mut stream = WebSocketStream::from_raw_socket(TokioIo::new(upgraded), Role::Server, Some(config)).await;
    let Ok(_slot) = shared.sockets.try_acquire() else {
        // The page may be gone already.
        let _ = stream.send(Message::text(worker::too_many_pages(SOCKETS_MAX))).await;
        let _ = stream.close(None).await;
        return;
    };
    let (requests, taken) = mpsc::channel(WAITING_MAX);
    let (sender, replies) = mpsc::channel(WAITING_MAX);
    worker::start(shared.worker.clone(), taken, sender);
    if let Err(error) = exchange(&mut stream, &requests, replies).await {
        tracing::debug!(%error, "a page went away");
    }
}

/// Passes messages on in both directions.
async fn exchange(
    stream: &mut WebSocketStream<TokioIo<hyper::upgrade::Upgraded>>,
    requests: &mpsc::Sender<PageMessage>,
    mut replies: mpsc::Receiver<Reply>,
) -> Result<(), SocketError> {
    loop {
        tokio::select! {
            message = stream.next() => match message {
                None => return Ok(()),
                Some(message) => {
                    let message = match message? {
                        Message::Text(text) => PageMessage::Text(text.to_string()),
                        Message::Binary(bytes) => PageMessage::Binary(bytes.to_vec()),
                        Message::Close(_) => return Ok(()),
                        _ => continue,
                    };
                    // Waiting here would keep replies from leaving, for which the worker may wait.
                    if let Err(TrySendError::Full(_)) = requests.try_send(message) {
                        stream.send(Message::text(worker::too_many_requests(WAITING_MAX))).await?;
                    }
                }
            },
            reply = replies.recv() => {
                let Some(reply) = reply else { return Ok(()) };
                match tokio::time::timeout(SEND_TIMEOUT, send(stream, reply)).await {
                    Ok(sent) => sent?,
                    Err(_) => return Ok(()),
                }
            }
        }
    }
}

/// Sends a reply. A binary one is a single frame that is written as it is: tungstenite 0.30 would copy it, and move the rest of it after
/// each write of the system.
async fn send(
    stream: &mut WebSocketStream<TokioIo<hyper::upgrade::Upgraded>>,
    reply: Reply,
) -> Result<(), SocketError> {
    let bytes = match reply {
        Reply::Text(text) => return stream.send(Message::text(text)).await,
        Reply::Binary(bytes) => bytes,
    };
    let header = FrameHeader { is_final: true, opcode: OpCode::Data(Data::Binary), ..FrameHeader::default() };
    let mut head = Vec::new();
    header.format(bytes.len() as u64, &mut head)?;
    stream.flush().await?;
    let connection = stream.get_mut();
    connection.write_all(&head).await?;
    connection.write_all(&bytes).await?;
    Ok(connection.flush().await?)
}
