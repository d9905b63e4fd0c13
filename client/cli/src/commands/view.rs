//! `shatter view`.

use super::CliError;
use std::path::PathBuf;

/// Arguments of `shatter view`.
#[derive(clap::Args)]
#[cfg_attr(not(feature = "view"), allow(dead_code, reason = "the page is not part of this build"))]
pub struct Args {
    /// Databases, or mesh files, which are baked first, for a daemon of its own [default: the objects of the service; if no daemon runs, one
    /// is started, and ended with this command]
    #[arg(value_name = "DATABASE|MESH")]
    files: Vec<PathBuf>,
    /// Port of 127.0.0.1; 0: any free one
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// File for a page that replays the results without a service; written when the command ends
    #[arg(long, value_name = "FILE.html")]
    record: Option<PathBuf>,
}

/// Serves the page until it is interrupted.
#[cfg(feature = "view")]
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    use super::{note, out};
    use shatter_view::{PageFiles, PendingRecording, ViewArguments};
    let arguments = ViewArguments {
        service: service.to_owned(),
        files: args.files.clone(),
        port: args.port,
        record: args.record.clone(),
        page: PageFiles::BUILT,
    };
    let announce = |address: &str| {
        out(format_args!("{address}\n"))?;
        note(format_args!("open this address in a browser of this machine; it counts once. Ctrl-C ends"));
        Ok::<(), CliError>(())
    };
    let on_write = |recording: PendingRecording<'_>| {
        let (file, left_out) = (recording.file.display(), recording.left_out);
        let most = PendingRecording::BYTES_MAX >> 20;
        if left_out > 0 {
            note(format_args!("{file} leaves out {left_out} results: it holds at most {most} MiB of them"));
        }
        note(format_args!("writing {file} ..."));
    };
    let written = shatter_view::run(arguments, announce, on_write)?;
    written.map_or(Ok(()), |file| out(format_args!("{}\n", file.display())))
}

/// Tells how to get a program with the page.
#[cfg(not(feature = "view"))]
pub fn run(_service: &str, _args: &Args) -> Result<(), CliError> {
    use shatter_client::{Error, ErrorKind};
    let message = "this program was built without the page. With Node.js 20 or later, build it in the project's folder: (cd client/view && npm \
                   ci && npm run build) && cargo build --release --features shatter-cli/view";
    Err(Error::new(ErrorKind::Configuration, "view", message).into())
}
