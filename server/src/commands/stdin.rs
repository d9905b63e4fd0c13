//! The end of standard input, which tells that the process that started this one is gone.

use crate::jobs::no_thread;
use shatter_proto::Error;

/// Starts a thread that calls `react` once standard input ends, or cannot be read.
///
/// # Errors
/// `failed` if no thread can be started.
pub fn at_end(react: impl FnOnce() + Send + 'static) -> Result<(), Error> {
    let wait = move || {
        // A descriptor that cannot be read has no other end that could keep the process.
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        react();
    };
    std::thread::Builder::new().name("stdin".to_owned()).spawn(wait).map_err(|error| no_thread(&error))?;
    Ok(())
}
