//! Loading of mesh files, and errors and limits of all readers.

use crate::scene::brief;
use crate::surface::SurfaceError;
use std::fmt::Display;
use std::path::Path;

/// Description of a valid PLY file.
pub(super) const PLY_EXPECTED: &str = "a PLY file has the elements `vertex` and `face`";

/// Largest accepted number of vertices, and of triangles.
pub(super) const LIMIT: usize = 1 << 26;

pub(super) fn load(path: &Path) -> Result<Vec<u8>, SurfaceError> {
    let unreadable = |source| SurfaceError::Unreadable { path: path.to_owned(), source };
    // Devices and pipes may never end.
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(std::io::Error::other("not a regular file")));
    }
    std::fs::read(path).map_err(unreadable)
}

pub(super) fn malformed(format: &'static str, place: impl Display, reason: impl Display) -> SurfaceError {
    SurfaceError::Malformed { format, place: brief(&place.to_string()), reason: brief(&reason.to_string()) }
}

/// Fails if `count` exceeds [`LIMIT`].
pub(super) fn within_limit(count: usize) -> Result<(), SurfaceError> {
    if count <= LIMIT { Ok(()) } else { Err(SurfaceError::TooLarge { limit: LIMIT as u64 }) }
}
