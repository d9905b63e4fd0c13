//! Standard output: both programs write to it only here.

use rustix::io::fcntl_getfd;
use shatter_proto::{Error, ErrorKind};
use std::fmt::Arguments;
use std::io::Write;
use std::os::fd::BorrowedFd;
use std::sync::atomic::{AtomicBool, Ordering};

/// Reason why a result did not reach standard output.
#[derive(Debug)]
pub enum StdoutError {
    /// The reader closed the pipe: the program ends quietly with [`exit::CLOSED`](shatter_proto::exit::CLOSED).
    Closed,
    /// Standard output cannot be written.
    Failed(Error),
}

/// True if the process began without a standard output; set before `main`.
static IS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Tests standard output before `main`: Rust's runtime replaces a closed standard output by `/dev/null`, and writes to that succeed.
extern "C" fn check_stdout() {
    // SAFETY: descriptor 1 is borrowed for this one call, which tests whether it is open and changes nothing.
    let stdout = unsafe { BorrowedFd::borrow_raw(1) };
    IS_CLOSED.store(fcntl_getfd(stdout).is_err(), Ordering::Relaxed);
}

// SAFETY: the loader calls the functions of this section once, before `main`. It passes arguments, which a function of the C convention may
// ignore. This one makes one system call and stores a flag; it uses nothing of Rust's runtime.
#[used]
#[unsafe(link_section = ".init_array")]
static CHECK_STDOUT: extern "C" fn() = check_stdout;

/// True if the process began without a standard output (`>&-`).
pub fn is_closed() -> bool {
    IS_CLOSED.load(Ordering::Relaxed)
}

/// Writes to standard output and flushes it.
///
/// # Errors
/// [`StdoutError`].
pub fn print(text: Arguments<'_>) -> Result<(), StdoutError> {
    let failed = |why: String| {
        StdoutError::Failed(Error::new(ErrorKind::Output, "stdout", format!("cannot write to stdout: {why}")))
    };
    if is_closed() {
        return Err(failed("it is closed".to_owned()));
    }
    let mut stdout = std::io::stdout().lock();
    stdout.write_fmt(text).and_then(|()| stdout.flush()).map_err(|error| match error.kind() {
        std::io::ErrorKind::BrokenPipe => StdoutError::Closed,
        _ => failed(error.to_string()),
    })
}
