//! Ctrl-C and the ends that supervisors and job schedulers ask for: the work stops at its next checkpoint and keeps what it has.

use super::Failure;
use shatter_fracture::token::Token;
use shatter_proto::exit;
use std::path::Path;
use tokio::runtime::{Builder, Runtime};
use tokio::signal::unix::{Signal, SignalKind, signal};

/// A token that the first interrupt or termination cancels; the second ends the process.
pub fn token() -> Result<Token, Failure> {
    let failed = |error: std::io::Error| Failure::output(Path::new("signals"), &error);
    let runtime = Builder::new_current_thread().enable_io().build().map_err(failed)?;
    let signals = Signals::new(&runtime).map_err(failed)?;
    let token = Token::default();
    let cancelled = token.clone();
    std::thread::spawn(move || runtime.block_on(wait(signals, &cancelled)));
    Ok(token)
}

struct Signals {
    interrupt: Signal,
    terminate: Signal,
}

impl Signals {
    fn new(runtime: &Runtime) -> std::io::Result<Self> {
        let _inside = runtime.enter();
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => (),
            _ = self.terminate.recv() => (),
        }
    }
}

async fn wait(mut signals: Signals, token: &Token) {
    signals.next().await;
    token.cancel();
    signals.next().await;
    std::process::exit(i32::from(exit::INTERRUPTED));
}
