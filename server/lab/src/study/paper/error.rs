//! Errors of the paper study.

use crate::picture::PictureError;
use crate::study::effects::EffectsError;
use shatter_export::contact::ContactError;
use shatter_fracture::database::BakeError;

/// Error of the paper study.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The built-in materials are invalid.
    #[error("materials: {0}")]
    Materials(String),
    /// The body could not be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The mesh has no extent.
    #[error("the mesh has no extent")]
    Empty,
    /// A contact has no duration or radius.
    #[error("contact: {0}")]
    Contact(#[from] ContactError),
    /// A request failed, or left the body whole.
    #[error(transparent)]
    Strike(#[from] EffectsError),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
