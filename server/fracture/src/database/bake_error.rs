//! Why an object is not baked.

use super::learned::EXAMPLES_MAX;
use super::lost_parts::SeveredParts;
use super::object_name::NAME_BYTES_MAX;
use super::stored_values::RATIOS;
use crate::cancel_token::Cancelled;
use crate::elasticity::ElasticityError;
use crate::lattice::LatticeError;
use crate::lift::LiftError;
use crate::pipeline::FractureError;
use crate::surface::SurfaceError;

/// Share of the volume that may be in components which the lattice drops: beyond it, what is left is another object.
pub(super) const GONE_MAX: f64 = 0.25;

/// Why an object was not baked.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The name cannot be a file's name or is too long for a request.
    #[error(
        "object name {0:?}: 1 to {NAME_BYTES_MAX} bytes without path separators, control or invisible characters or a leading dot"
    )]
    Name(String),
    /// A number is not finite and positive.
    #[error("{key} must be finite and positive, got {value}")]
    NotPositive {
        /// Which number.
        key: &'static str,
        /// What it was.
        value: f64,
    },
    /// A number that no object of this size and material has.
    #[error("{key} is {value:e} times {over}: must be {:e} to {:e} times", RATIOS.start(), RATIOS.end())]
    Unusual {
        /// Which number.
        key: &'static str,
        /// Over what.
        over: &'static str,
        /// How many times that it is.
        value: f64,
    },
    /// The mesh has no surface or no inside.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The existing cracks are no sheets.
    #[error("existing cracks: {0}")]
    Cracks(SurfaceError),
    /// The existing cracks leave too little of the object.
    #[error(
        "existing cracks take {percent:.0} % of the object at crack spacing {spacing:.5}: bake with a finer one, or fewer of them"
    )]
    CracksTakeAll {
        /// Their share of the volume, per cent.
        percent: f64,
        /// Crack spacing over the diagonal.
        spacing: f64,
    },
    /// Walls are too thin for any lattice that is accepted, or for the one that was asked for.
    #[error(
        "a quarter of the surface or more has walls of {thickness_m:.3e} m or less: crack spacing {spacing:.5} loses them, \
         {spacing_needed:.5} is needed{possible}",
        possible = if *possible { "" } else { ", finer than what can be baked" }
    )]
    TooThin {
        /// Thickness that a quarter of the surface does not exceed, m.
        thickness_m: f64,
        /// Crack spacing in question, over the diagonal.
        spacing: f64,
        /// Crack spacing that keeps such walls, over the diagonal.
        spacing_needed: f64,
        /// True if that spacing is accepted.
        possible: bool,
    },
    /// A preset that was not asked for by name severs parts.
    #[error("{0}")]
    Severed(Box<SeveredParts>),
    /// More examples than a database holds.
    #[error("{asked} examples: at most {EXAMPLES_MAX}")]
    TooManyExamples {
        /// How many were asked for.
        asked: u64,
    },
    /// Most of the object is in components that no lattice of that spacing keeps.
    #[error(
        "{count} components with {percent:.0} % of the volume are smaller than crack spacing {spacing:.5} resolves: bake with a \
         finer one, or fewer components at a time"
    )]
    TooSmall {
        /// How many.
        count: u64,
        /// Their share of the volume, per cent.
        percent: f64,
        /// Crack spacing over the diagonal.
        spacing: f64,
    },
    /// No lattice could be made.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// No lift could be computed.
    #[error("lift of body {body}: {source}")]
    Lift {
        /// Which body.
        body: usize,
        /// Why.
        source: LiftError,
    },
    /// The stiffness could not be factored.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Which body.
        body: usize,
        /// Why.
        source: ElasticityError,
    },
    /// A sampled impact failed.
    #[error(transparent)]
    Calibration(FractureError),
    /// Cancelled at a checkpoint.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl BakeError {
    /// True if the work was cancelled, wherever it was.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Cancelled(_)
                | Self::Surface(SurfaceError::Cancelled(_))
                | Self::Cracks(SurfaceError::Cancelled(_))
                | Self::Lattice(LatticeError::Cancelled(_))
                | Self::Lift { source: LiftError::Cancelled(_), .. }
                | Self::Elasticity { source: ElasticityError::Cancelled(_), .. }
                | Self::Calibration(FractureError::Cancelled(_))
        )
    }
}

impl From<FractureError> for BakeError {
    fn from(error: FractureError) -> Self {
        match error {
            FractureError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            error => Self::Calibration(error),
        }
    }
}
