//! What may go wrong.

use crate::picture::PictureError;
use crate::study::effects::EffectsError;
use shatter_export::contact::ContactError;
use shatter_fracture::database::BakeError;

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The materials that come with the program cannot be read.
    #[error("materials: {0}")]
    Materials(String),
    /// The body could not be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// There is nothing to strike.
    #[error("the mesh has no extent")]
    Empty,
    /// A collision without duration and radius.
    #[error("contact: {0}")]
    Contact(#[from] ContactError),
    /// A strike failed, or left the body whole.
    #[error(transparent)]
    Strike(#[from] EffectsError),
    /// No picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
