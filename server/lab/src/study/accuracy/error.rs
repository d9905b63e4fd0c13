//! Errors of the study.

use crate::picture::PictureError;
use crate::study::plot::PlotError;
use shatter_fracture::accuracy::AccuracyError;
use shatter_fracture::cancel_token::Canceled;
use shatter_fracture::centroidal::FieldError;
use shatter_fracture::database::BakeError;
use shatter_fracture::elasticity::ElasticityError;
use shatter_fracture::lift::LiftError;
use shatter_fracture::pipeline::FractureError;

/// Error of the study, or of one of its points.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The built-in materials are invalid.
    #[error("materials: {0}")]
    Materials(String),
    /// The object could not be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A request failed.
    #[error(transparent)]
    Strike(#[from] FractureError),
    /// The strain energies are no valid field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The elasticity could not be computed.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// The lift could not be computed.
    #[error(transparent)]
    Lift(#[from] LiftError),
    /// The comparison failed.
    #[error(transparent)]
    Accuracy(#[from] AccuracyError),
    /// Another lattice has a different number of bodies, so the bodies cannot be matched.
    #[error("the lattice has {found} bodies, but the object has {expected}")]
    Bodies {
        /// Number of bodies of the object.
        expected: usize,
        /// Number of bodies of the other lattice.
        found: usize,
    },
    /// An object that should break stays whole.
    #[error("the object stays whole")]
    Whole,
    /// The object lacks a table.
    #[error("the object was baked without the required table")]
    Unprepared,
    /// A reference has no more than twice the unknowns of the object that it judges.
    #[error(
        "the reference has {reference} unknowns and the object that it judges {subject}: it needs more than twice as \
         many. Allow more nodes in the plan (`refined_nodes_max`)"
    )]
    CoarseReference {
        /// Unknowns of the reference's finest level.
        reference: usize,
        /// Unknowns of the object's elastic lattice.
        subject: usize,
    },
    /// The study was canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
