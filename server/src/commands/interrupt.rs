//! Handling of SIGINT and SIGTERM: the command ends soon with exit code 128 plus the signal's number, and leaves no partial file.

use super::CommandError;
use crate::jobs::no_thread;
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

/// Time within which work with a token must reach its next checkpoint and report. After that the process ends.
const GRACE: Duration = Duration::from_secs(1);

/// Number of the received signal; 0: none.
static SIGNAL_NUMBER: AtomicU8 = AtomicU8::new(0);

/// Token that the first signal cancels, if the command requested one.
static TOKEN: Mutex<Option<CancelToken>> = Mutex::new(None);

/// Whether the work saves its state at the next checkpoint, however long that takes.
static KEEPS_FINISHED_WORK: AtomicBool = AtomicBool::new(false);

/// Whether the end of the process was reported, by the command or by the signal thread; only one of them reports.
static IS_REPORTED: AtomicBool = AtomicBool::new(false);

/// Lock that is held while a file is written.
static WRITING: Mutex<()> = Mutex::new(());

/// Whether the command began to write a file.
static HAS_WRITTEN: AtomicBool = AtomicBool::new(false);

/// Child process that must not outlive this one.
static CHILD_PID: Mutex<Option<Pid>> = Mutex::new(None);

/// Starts to wait for signals; commands call it first. `json`: whether stdout receives a document.
///
/// # Errors
/// [`CommandError`] if signals cannot be heard, or no thread can be started.
pub fn watch(json: bool) -> Result<(), CommandError> {
    let failed = |error: std::io::Error| CommandError::output(Path::new("signals"), &error);
    let runtime = Builder::new_current_thread().enable_io().enable_time().build().map_err(failed)?;
    let signals = Signals::new(&runtime).map_err(failed)?;
    let work = move || {
        runtime.block_on(wait(signals));
        end(json)
    };
    std::thread::Builder::new().spawn(work).map_err(|error| no_thread(&error))?;
    Ok(())
}

/// Creates a token that the first signal cancels.
pub fn token() -> CancelToken {
    let token = CancelToken::default();
    if SIGNAL_NUMBER.load(Ordering::SeqCst) != 0 {
        token.cancel();
    }
    *held(&TOKEN) = Some(token.clone());
    token
}

/// Lets the first signal wait for the next checkpoint, where the work saves its state, until the guard is dropped. A second signal does not
/// wait.
pub fn keeping() -> KeepingGuard {
    KEEPS_FINISHED_WORK.store(true, Ordering::SeqCst);
    KeepingGuard(())
}

/// Guard of work that saves its state.
pub struct KeepingGuard(());

impl Drop for KeepingGuard {
    fn drop(&mut self) {
        KEEPS_FINISHED_WORK.store(false, Ordering::SeqCst);
    }
}

/// Guard that keeps signals from ending the process while a file is written.
pub fn writing() -> MutexGuard<'static, ()> {
    let guard = held(&WRITING);
    HAS_WRITTEN.store(true, Ordering::SeqCst);
    guard
}

/// The error of a command that a signal ended.
pub fn ended() -> CommandError {
    CommandError::interrupted(match HAS_WRITTEN.load(Ordering::SeqCst) {
        true => "a signal ended the command; every file that it wrote is complete, and others are as they were",
        false => "a signal ended the command; nothing was written",
    })
}

/// Sets the child process that ends together with this one; `None` clears it.
pub fn child(pid: Option<Pid>) {
    *held(&CHILD_PID) = pid;
}

/// Exit code of a command that a signal ended.
pub fn exit_code() -> u8 {
    match SIGNAL_NUMBER.load(Ordering::SeqCst) {
        0 => exit::INTERRUPTED,
        signal => 128 + signal,
    }
}

/// Ends the command as SIGTERM does.
pub fn terminate() {
    // A process can always signal itself.
    let _ = kill_process(rustix::process::getpid(), Kill::TERM);
}

/// Marks that the command ends by itself. Does not return if the process is already ending.
pub fn ending() {
    if IS_REPORTED.swap(true, Ordering::SeqCst) {
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

/// Waits until the process has to end.
async fn wait(mut signals: Signals) {
    let first = signals.next().await;
    SIGNAL_NUMBER.store(u8::try_from(first.as_raw_value()).unwrap_or(2), Ordering::SeqCst);
    let token = held(&TOKEN).clone();
    let Some(token) = token else { return };
    token.cancel();
    while timeout(GRACE, signals.next()).await.is_err() {
        if !KEEPS_FINISHED_WORK.load(Ordering::SeqCst) {
            return;
        }
    }
}

fn end(json: bool) -> ! {
    ending();
    if let Some(child) = *held(&CHILD_PID) {
        // The child may have ended already.
        let _ = kill_process(child, Kill::TERM);
    }
    let _last = held(&WRITING);
    let _ = ended().print(json);
    std::process::exit(i32::from(exit_code()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stages after the examples save nothing: a bake of `film` took 37 s to end.
    #[test]
    fn a_signal_waits_for_a_checkpoint_only_while_there_are_some() {
        let keeps = || KEEPS_FINISHED_WORK.load(Ordering::SeqCst);
        let keeping = keeping();
        assert!(keeps());
        drop(keeping);
        assert!(!keeps());
    }
}
