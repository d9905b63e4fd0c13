//! Classification of bake errors: rejected meshes, or internal errors.

use shatter_fracture::database::BakeError;
use shatter_server::commands::CommandError;

/// Kind of the error as on the command line and its message; `Err` with the message for an internal error.
pub(super) fn rejection(error: BakeError) -> Result<(&'static str, String), String> {
    let message = error.to_string();
    let failure = CommandError::from(error);
    if failure.is_ours() { Err(message) } else { Ok((failure.kind(), message)) }
}
