//! The whole command: daemon, server, signals.

use crate::page_files::PageFiles;
use crate::recording::{PendingRecording, Recording};
use crate::server::{ViewOptions, ViewServer};
use crate::start::prepare;
use shatter_proto::{Error, ErrorKind};
use std::path::PathBuf;
use std::sync::Arc;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::Notify;

/// Arguments of `shatter view`.
pub struct ViewArguments {
    /// Name of the service.
    pub service: String,
    /// Databases and mesh files; none: the objects of the service.
    pub files: Vec<PathBuf>,
    /// Port of 127.0.0.1; 0: any free one.
    pub port: u16,
    /// File that receives the requests and their results as a page of its own.
    pub record: Option<PathBuf>,
    /// Files of the page.
    pub page: PageFiles,
}

/// Serves the page until SIGINT or SIGTERM. Calls `announce` with its address once it can be opened, and `on_write` before it writes
/// the recording, which takes some seconds if it is large. Returns the recording that was written.
///
/// # Errors
/// Those of [`prepare`], [`ViewServer::open`], [`Recording::write`] and `announce`.
pub fn run<E: From<Error>>(
    arguments: ViewArguments,
    announce: impl FnOnce(&str) -> Result<(), E>,
    on_write: impl FnOnce(PendingRecording<'_>),
) -> Result<Option<PathBuf>, E> {
    let (daemon, folder) = prepare(&arguments.service, &arguments.files)?.into_parts();
    let daemon = Arc::new(daemon);
    let recording = arguments.record.map(|file| Arc::new(Recording::new(&file, arguments.page)));
    let options = ViewOptions {
        port: arguments.port,
        page: arguments.page,
        daemon: daemon.clone(),
        recording: recording.clone(),
    };
    let served = serve(options, announce);
    // The thread of a page may be in the middle of a request, and uses the daemon until that fails.
    daemon.end();
    drop(folder);
    served?;
    let Some(recording) = recording.filter(|recording| !recording.is_empty()) else { return Ok(None) };
    on_write(recording.pending());
    Ok(Some(recording.write()?))
}

/// Serves until SIGINT or SIGTERM.
fn serve<E: From<Error>>(options: ViewOptions, announce: impl FnOnce(&str) -> Result<(), E>) -> Result<(), E> {
    let failed = |error: std::io::Error| Error::new(ErrorKind::Failed, "runtime", format!("cannot start: {error}"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
    runtime.block_on(async {
        let stop = Arc::new(Notify::new());
        for kind in [SignalKind::interrupt(), SignalKind::terminate()] {
            let mut signals = signal(kind).map_err(failed)?;
            let stop = stop.clone();
            tokio::spawn(async move {
                signals.recv().await;
                stop.notify_one();
            });
        }
        let server = ViewServer::open(options).await?;
        announce(&server.address())?;
        server.serve(&stop).await;
        Ok(())
    })
}
