//! Why a demonstration ended early.

use crate::picture::PictureError;
use shatter_client::Error;
use shatter_export::ExportError;
use shatter_fracture::database::{BakeError, DatabaseError};
use shatter_fracture::pipeline::FractureError;
use shatter_fracture::scene::MaterialError;
use shatter_fracture::surface::SurfaceError;
use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

/// What went wrong, by the part that it went wrong in.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// A folder could not be made.
    #[error("cannot make the folder {}: {source}", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The built-in table of materials.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// The generated shape.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// Baking.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The database file.
    #[error("{}", source.of(path))]
    Database {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        source: DatabaseError,
    },
    /// The daemon's process could not be started, or not be ended.
    #[error("the daemon's process: {0}")]
    Process(io::Error),
    /// The daemon ended before it served.
    #[error("the daemon ended before it was ready: {0}")]
    DaemonEnded(ExitStatus),
    /// The daemon did not become ready.
    #[error("the daemon was not ready after {seconds} s")]
    DaemonSilent {
        /// How long it was waited for.
        seconds: u64,
    },
    /// The service refused.
    #[error(transparent)]
    Refused(#[from] Error),
    /// A strike beyond the threshold left the object whole.
    #[error("the object stayed whole at {factor} times the impulse that breaks it")]
    StayedWhole {
        /// The multiple.
        factor: f64,
    },
    /// The strain energy for the pictures.
    #[error(transparent)]
    Energy(#[from] FractureError),
    /// A picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A file for the output folder.
    #[error(transparent)]
    Export(#[from] ExportError),
}
