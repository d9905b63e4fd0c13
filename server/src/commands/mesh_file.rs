//! Mesh files of commands: errors name the file.

use super::CommandError;
use super::expected_file::{self, ExpectedFile};
use shatter_fracture::database::BakeError;
use shatter_fracture::surface::{self, LengthUnit, RawMesh, SurfaceError, UpAxis};
use std::path::Path;

/// Reads a mesh file; defects of the mesh name the file.
///
/// # Errors
/// Those of [`surface::read`], and `unknown_format` for a file of another kind.
pub fn read(file: &Path, unit: LengthUnit, up: UpAxis) -> Result<RawMesh, CommandError> {
    expected_file::check(file, ExpectedFile::Mesh)?;
    surface::read(file, unit, up).map_err(|error| match error {
        named @ (SurfaceError::Unreadable { .. } | SurfaceError::UnknownFormat { .. }) => named.into(),
        error => CommandError::from(error).of_file(file),
    })
}

/// Converts a bake error; defects of the mesh name its file.
pub fn bake_error(error: BakeError, mesh: Option<&Path>) -> CommandError {
    let own = mesh.filter(|_| matches!(error, BakeError::Surface(_)) && !error.is_canceled());
    let failure = CommandError::from(error);
    match own {
        Some(file) => failure.of_file(file),
        None => failure,
    }
}
