//! Ctrl-C and the ends that supervisors and job schedulers ask for: the command ends soon, with 128 and the signal's number, and
//! leaves no half-written file.

use super::CommandError;
use rustix::process::{Pid, Signal as Kill, kill_process};
use shatter_fracture::cancel_token::CancelToken;
use shatter_proto::exit;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::runtime::{Builder, Runtime};
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::time::timeout;

/// Work with a token has this long to reach its next checkpoint and say itself what is left. Beyond that the process ends.
const GRACE: Duration = Duration::from_secs(1);

/// The signal that came; 0: none.
static CAME: AtomicU8 = AtomicU8::new(0);

/// Cancelled by the first signal, if the command has asked for it.
static TOKEN: Mutex<Option<CancelToken>> = Mutex::new(None);

/// Whether the work keeps what it has at its next checkpoint, however long that takes.
static KEEPS: AtomicBool = AtomicBool::new(false);

/// Whether the end of the process is told of: by the command itself or by the thread that waits for signals, not by both.
static TOLD: AtomicBool = AtomicBool::new(false);

/// Held while a file is written.
static WRITING: Mutex<()> = Mutex::new(());

/// A process that must not outlive this one.
static CHILD: Mutex<Option<Pid>> = Mutex::new(None);

/// Waits for signals from here on; commands call it before anything else. `json`: whether stdout gets a document.
///
/// # Errors
/// [`CommandError`] if signals cannot be heard.
pub fn watch(json: bool) -> Result<(), CommandError> {
    let failed = |error: std::io::Error| CommandError::output(Path::new("signals"), &error);
    let runtime = Builder::new_current_thread().enable_io().enable_time().build().map_err(failed)?;
    let signals = Signals::new(&runtime).map_err(failed)?;
    std::thread::spawn(move || {
        runtime.block_on(wait(signals));
        end(json)
    });
    Ok(())
}

/// A token that the first signal cancels.
pub fn token() -> CancelToken {
    let token = CancelToken::default();
    if CAME.load(Ordering::SeqCst) != 0 {
        token.cancel();
    }
    *held(&TOKEN) = Some(token.clone());
    token
}

/// From here on a signal waits for the work's next checkpoint, where it keeps what it has; a second one does not.
pub fn keeping() {
    KEEPS.store(true, Ordering::SeqCst);
}

/// While this is held, no signal ends the process: a file is being written.
pub fn writing() -> MutexGuard<'static, ()> {
    held(&WRITING)
}

/// A process that is asked to end where a signal ends this one; none any more.
pub fn child(pid: Option<Pid>) {
    *held(&CHILD) = pid;
}

/// Exit code of a command that a signal ended.
pub fn exit_code() -> u8 {
    match CAME.load(Ordering::SeqCst) {
        0 => exit::INTERRUPTED,
        signal => 128 + signal,
    }
}

/// The command ends by itself. Does not return where the process is ending already.
pub fn ending() {
    if TOLD.swap(true, Ordering::SeqCst) {
        loop {
            std::thread::park();
        }
    }
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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

    async fn next(&mut self) -> SignalKind {
        tokio::select! {
            _ = self.interrupt.recv() => SignalKind::interrupt(),
            _ = self.terminate.recv() => SignalKind::terminate(),
        }
    }
}

/// Returns when the process has to end now.
async fn wait(mut signals: Signals) {
    let first = signals.next().await;
    CAME.store(u8::try_from(first.as_raw_value()).unwrap_or(2), Ordering::SeqCst);
    let token = held(&TOKEN).clone();
    let Some(token) = token else { return };
    token.cancel();
    while timeout(GRACE, signals.next()).await.is_err() {
        if !KEEPS.load(Ordering::SeqCst) {
            return;
        }
    }
}

fn end(json: bool) -> ! {
    ending();
    if let Some(child) = *held(&CHILD) {
        // It may have ended by itself.
        let _ = kill_process(child, Kill::TERM);
    }
    let _last = writing();
    let _ = CommandError::interrupted("interrupted; every file is whole, as it was or as it became").print(json);
    std::process::exit(i32::from(exit_code()))
}
