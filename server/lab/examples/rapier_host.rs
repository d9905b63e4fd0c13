//! Example of a host: a headless Rapier simulation whose bodies break.
//!
//! ```sh
//! cargo build --release --workspace
//! cargo run --release --features shatter-lab/rapier --example rapier_host -- --seconds 10 --out host
//! ```
//!
//! Statues fall, and balls swing through shelves of vases and mugs. Rapier's contact forces become impacts, which are sent through the
//! client; broken bodies are replaced by their fragments, which can break again. No step waits for the daemon. The host starts the daemon
//! if none runs, restarts it when it dies, and ends it. `--out` receives `film.glb`, `film.png`, `steps.svg`, `summary.json`.
//!
//! `--set vase --seconds 1.2` strikes a painted vase instead. It writes `vase.png` and the animation `vase-film.png` in place of `film.png`.

#[path = "rapier_host/mod.rs"]
mod host;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match host::run(&host::Options::parse()) {
        Ok(summary) => {
            println!("{summary:#}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("rapier_host: {error}");
            ExitCode::FAILURE
        }
    }
}
