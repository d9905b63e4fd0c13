//! Names of objects.

use crate::scene::is_invisible;

/// Longest object name in bytes: it travels in a fixed field of the request.
pub const NAME_BYTES_MAX: usize = 64;

/// True if `name` can name an object: it names a file and travels in a fixed field.
pub fn is_object_name(name: &str) -> bool {
    (1..=NAME_BYTES_MAX).contains(&name.len())
        && !name.starts_with('.')
        && !name.chars().any(|c| is_invisible(c) || c == '/' || c == '\\')
}
