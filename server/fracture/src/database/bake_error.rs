//! Errors of a bake.

use super::joints::place;
use super::learned::EXAMPLES_MAX;
use super::lost_parts::SeveredParts;
use super::object_name::NAME_BYTES_MAX;
use super::stored_values::RATIOS;
use crate::cancel_token::Canceled;
use crate::elasticity::ElasticityError;
use crate::lattice::{LatticeError, SPACING_RANGE};
use crate::lift::LiftError;
use crate::pipeline::FractureError;
use crate::scene::{brief, number};
use crate::surface::SurfaceError;
use nalgebra::Point3;

/// Largest share of the volume in components that the lattice drops. Beyond it, the rest is a different object.
pub(super) const GONE_MAX: f64 = 0.25;

/// Reason why an object was not baked.
#[derive(thiserror::Error)]
pub enum BakeError {
    /// The name is not a valid file name, or too long for a request.
    #[error(
        "object name {:?} is invalid: use 1 to {NAME_BYTES_MAX} bytes without path separators, control or invisible characters or a leading dot",
        brief(.0)
    )]
    Name(String),
    /// A number is not finite and positive, or too small for full precision.
    #[error("{key} is {}; it must be a finite number {}", number(*.value), lower_bound(*.value))]
    NotPositive {
        /// Name of the number.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// A number that is implausible for an object of this size and material.
    #[error("{key} is {value:e} times {over}: must be {:e} to {:e} times", RATIOS.start(), RATIOS.end())]
    Unusual {
        /// Name of the number.
        key: &'static str,
        /// Reference value, in words.
        over: &'static str,
        /// Ratio of the number to the reference value.
        value: f64,
    },
    /// The mesh has no surface or no inside.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The existing cracks are not valid sheets.
    #[error("existing cracks: {0}")]
    Cracks(SurfaceError),
    /// No existing crack reaches the object.
    #[error(
        "existing cracks: the nearest is {distance_m:.2e} m away from the object. They extend from {:.4?} to {:.4?} m, the object \
         from {:.4?} to {:.4?} m; move them into the object, in its unit and axes",
        .sheets_m[0], .sheets_m[1], .object_m[0], .object_m[1]
    )]
    CracksMiss {
        /// Distance of the nearest corner of a sheet from the surface, m.
        distance_m: f64,
        /// Lowest and highest corner of the sheets' bounding box, m.
        sheets_m: [[f64; 3]; 2],
        /// Lowest and highest corner of the object's bounding box, m.
        object_m: [[f64; 3]; 2],
    },
    /// Every existing crack is smaller than the lattice resolves.
    #[error(
        "existing cracks: none opens a slot. They are about {size_m:.2e} m large, and slots are {width_m:.3e} m wide at crack spacing \
         {spacing:.5}: {}make the cracks larger than a slot is wide; check their unit, too",
        finer_spacing(spacing * size_m / width_m)
    )]
    CracksTooSmall {
        /// Crack spacing over the diagonal.
        spacing: f64,
        /// Width of a slot, m.
        width_m: f64,
        /// Side of a square with the area of the cracks, m.
        size_m: f64,
    },
    /// The existing cracks leave too little of the object.
    #[error(
        "existing cracks take {percent:.0} % of the object at crack spacing {spacing:.5}: bake with a finer spacing or fewer cracks"
    )]
    CracksTakeAll {
        /// Their share of the volume, percent.
        percent: f64,
        /// Crack spacing over the diagonal.
        spacing: f64,
    },
    /// Walls are too thin for every possible lattice, or for the requested one.
    #[error(
        "a quarter of the surface or more has walls of {thickness_m:.3e} m or less: crack spacing {spacing:.5} loses them, \
         {spacing_needed:.5} is needed{}",
        finer_than_possible(*.thickness_needed_m)
    )]
    TooThin {
        /// Wall thickness that a quarter of the surface does not exceed, m.
        thickness_m: f64,
        /// Crack spacing that loses them, over the diagonal.
        spacing: f64,
        /// Crack spacing that preserves them, over the diagonal.
        spacing_needed: f64,
        /// Wall thickness of the same shape that can be baked, m; none if the spacing is possible.
        thickness_needed_m: Option<f64>,
    },
    /// A preset that was not requested explicitly severs parts.
    #[error("{0}")]
    Severed(Box<SeveredParts>),
    /// The request has more examples than a database can hold.
    #[error("{asked} examples exceed the maximum of {EXAMPLES_MAX}")]
    TooManyExamples {
        /// Requested number.
        asked: u64,
    },
    /// Most of the object is in components that no lattice of this spacing preserves.
    #[error(
        "{count} components with {percent:.0} % of the volume are smaller than crack spacing {spacing:.5} resolves: bake with a \
         finer spacing, or fewer components at a time"
    )]
    TooSmall {
        /// Number of components.
        count: u64,
        /// Their share of the volume, percent.
        percent: f64,
        /// Crack spacing over the diagonal.
        spacing: f64,
    },
    /// The lattices could not be computed.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A lift could not be computed.
    #[error("lift of body {body}: {source}")]
    Lift {
        /// Index of the body.
        body: usize,
        /// Cause.
        source: LiftError,
    },
    /// Parts of a body move freely about a joint.
    #[error(
        "elasticity of body {body}: parts move freely about a joint at {}, which is too thin for a stable solution (residual \
         {residual:.1e} of a test load): thicken it there, or bake the parts as separate objects",
        place(.place_m)
    )]
    FreeJoint {
        /// Index of the body.
        body: usize,
        /// Position of the joint, m.
        place_m: Point3<f64>,
        /// Relative residual of the test load.
        residual: f64,
    },
    /// The stiffness could not be factored.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Index of the body.
        body: usize,
        /// Cause.
        source: ElasticityError,
    },
    /// A sampled impact failed.
    #[error(transparent)]
    Calibration(FractureError),
    /// Canceled at a checkpoint.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

/// Part of [`BakeError::NotPositive`]: the lower bound that `value` does not reach.
fn lower_bound(value: f64) -> String {
    if value > 0.0 { format!("of at least {:e}", f64::MIN_POSITIVE) } else { "above 0".to_owned() }
}

/// Part of [`BakeError::TooThin`] about walls that no possible lattice preserves.
fn finer_than_possible(thickness_needed_m: Option<f64>) -> String {
    let words = |needed_m| {
        format!(", which is finer than can be baked: walls of about {needed_m:.2e} m or more in this shape can be")
    };
    thickness_needed_m.map_or_else(String::new, words)
}

impl BakeError {
    /// True if the bake was canceled, in any step.
    pub fn is_canceled(&self) -> bool {
        matches!(
            self,
            Self::Canceled(_)
                | Self::Surface(SurfaceError::Canceled(_))
                | Self::Cracks(SurfaceError::Canceled(_))
                | Self::Lattice(LatticeError::Canceled(_))
                | Self::Lift { source: LiftError::Canceled(_), .. }
                | Self::Elasticity { source: ElasticityError::Canceled(_), .. }
                | Self::Calibration(FractureError::Canceled(_))
        )
    }
}

impl From<FractureError> for BakeError {
    fn from(error: FractureError) -> Self {
        match error {
            FractureError::Canceled(canceled) => Self::Canceled(canceled),
            error => Self::Calibration(error),
        }
    }
}

/// Advice to lower the crack spacing below `needed`, where that is possible.
fn finer_spacing(needed: f64) -> String {
    if needed < SPACING_RANGE[0] { String::new() } else { format!("bake with a spacing below {needed:.4}, or ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_too_small_name_the_least_one() {
        let message = |value| BakeError::NotPositive { key: "--gamma", value }.to_string();
        assert_eq!(message(-1.5), "--gamma is -1.5; it must be a finite number above 0");
        assert_eq!(
            message(1e-320),
            "--gamma is 1e-320; it must be a finite number of at least 2.2250738585072014e-308"
        );
    }

    #[test]
    fn a_finer_spacing_is_advised_where_one_helps() {
        let message = |size_m| BakeError::CracksTooSmall { spacing: 0.04, width_m: 0.02, size_m }.to_string();
        assert!(
            message(0.005).contains("5.00e-3 m large") && message(0.005).contains("a spacing below 0.0100, or make")
        );
        assert!(!message(0.0005).contains("a spacing below"), "{}", message(0.0005));
    }
}
