//! Why there is no study, or no point of it.

use crate::picture::PictureError;
use crate::study::plot::PlotError;
use shatter_fracture::accuracy::AccuracyError;
use shatter_fracture::cancel_token::Cancelled;
use shatter_fracture::centroidal::FieldError;
use shatter_fracture::database::BakeError;
use shatter_fracture::elasticity::ElasticityError;
use shatter_fracture::lift::LiftError;
use shatter_fracture::pipeline::FractureError;

/// Why there is no study, or no point of it.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The materials that come with the program cannot be read.
    #[error("materials: {0}")]
    Materials(String),
    /// The object could not be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A strike failed.
    #[error(transparent)]
    Strike(#[from] FractureError),
    /// Strain energies are no field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// No stiffness.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// No lift.
    #[error(transparent)]
    Lift(#[from] LiftError),
    /// Nothing to compare.
    #[error(transparent)]
    Accuracy(#[from] AccuracyError),
    /// Another lattice has other bodies, so none of it stands for one of the object's.
    #[error("{found} bodies where the object has {expected}")]
    Bodies {
        /// Bodies of the object.
        expected: usize,
        /// Bodies of the other.
        found: usize,
    },
    /// What should break stays whole.
    #[error("the object stays whole")]
    Whole,
    /// The object has no such table.
    #[error("the object was not prepared for it")]
    Unprepared,
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// No picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// No plot.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
