//! A host: a headless Rapier simulation whose bodies break.
//!
//! ```sh
//! cargo build --release --workspace
//! cargo run --release --features shatter-lab/rapier --example rapier_host -- --seconds 10 --out host
//! ```
//!
//! Statues fall, balls swing through shelves of vases and mugs. Impacts are found from Rapier's contact forces, struck through the
//! client, and broken bodies are swapped for their fragments, which can break again; no step waits for the daemon. It is started
//! if none runs, started again when it dies, and ended in the end. `--out` gets `film.glb`, `film.png`, `steps.svg`, `summary.json`.

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
