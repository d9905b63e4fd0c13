//! The page of `shatter view`: strike the objects of a running `shatterd` in a browser.
//!
//! [`ViewServer`] listens on the loopback address alone. It serves one page ([`PageFiles`]) to the browser that presents the one-time
//! token, and one WebSocket to that page. Requests arrive there as JSON. Results leave as the sections that they are in shared memory:
//! one binary message each, a JSON head and then the bytes of the sections ([`ResultMessage`]).
//!
//! [`ViewDaemon`] finds a running daemon, or starts one, which ends with the command.
//!
//! The feature `page` embeds the page that `npm run build` writes to `dist`. Without it the crate serves the files that it is given.

mod access;
mod baking;
mod child_process;
mod connection_limit;
mod daemon;
mod download;
mod impact_request;
mod page_files;
mod programs;
mod recording;
mod result_message;
mod run;
mod scene_check;
mod server;
mod shown_pieces;
mod socket;
mod start;
mod worker;
mod zip;

pub use daemon::ViewDaemon;
pub use page_files::{PageFile, PageFiles};
pub use programs::daemon_program;
pub use recording::{PendingRecording, Recording};
pub use result_message::ResultMessage;
pub use run::{ViewArguments, run};
pub use server::{ViewOptions, ViewServer};
pub use start::{ViewTargets, prepare};
