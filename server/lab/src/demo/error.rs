//! Errors of the demonstration.

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

/// Error of the demonstration, by the part that failed.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// The built-in table of materials is invalid.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// The generated shape is invalid.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The bake failed.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The database file is invalid.
    #[error("{}", source.of(path))]
    Database {
        /// The file.
        path: PathBuf,
        /// The defect.
        source: DatabaseError,
    },
    /// The daemon's process could not be started or ended.
    #[error("the daemon's process: {0}")]
    Process(io::Error),
    /// The daemon ended before it served.
    #[error("the daemon ended before it was ready: {0}")]
    DaemonEnded(ExitStatus),
    /// The daemon did not become ready.
    #[error("the daemon was not ready after {seconds} s")]
    DaemonSilent {
        /// Time waited, s.
        seconds: u64,
    },
    /// The service returned an error.
    #[error(transparent)]
    Refused(#[from] Error),
    /// An impulse above the threshold left the object whole.
    #[error("the object stayed whole at {factor} times the impulse that breaks it")]
    StayedWhole {
        /// Multiple of the breaking impulse.
        factor: f64,
    },
    /// The strain energy could not be computed.
    #[error(transparent)]
    Energy(#[from] FractureError),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A file could not be written to the output folder.
    #[error(transparent)]
    Export(#[from] ExportError),
}
