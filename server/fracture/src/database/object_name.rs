//! Names of objects.

use crate::scene::is_invisible;

/// Longest object name, bytes, limited by a fixed-size field of the request.
pub const NAME_BYTES_MAX: usize = 64;

/// True if `name` is a valid object name, which serves as a file name and fits into a fixed-size field.
pub fn is_object_name(name: &str) -> bool {
    (1..=NAME_BYTES_MAX).contains(&name.len())
        && !name.starts_with('.')
        && !name.chars().any(|c| is_invisible(c) || c == '/' || c == '\\')
}
