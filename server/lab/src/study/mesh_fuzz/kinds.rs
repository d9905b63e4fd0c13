//! What a refusal is called, and whether it is one.

use shatter_fracture::database::BakeError;
use shatter_server::commands::CommandError;

/// A refusal's kind as the command line tells it, or nothing where the fault is the engine's own.
pub(super) fn refusal(error: BakeError) -> Result<(&'static str, String), String> {
    let message = error.to_string();
    let failure = CommandError::from(error);
    if failure.is_ours() { Err(message) } else { Ok((failure.kind(), message)) }
}
