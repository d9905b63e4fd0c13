//! Why a strike was refused or failed.

use super::output::rows::BulkCounts;
use crate::cancel_token::Cancelled;
use crate::centroidal::FieldError;
use crate::elasticity::ElasticityError;
use crate::lattice::BODY_TETS_MIN;
use crate::lift::{LiftError, LiftKind};
use crate::scene::EffectKind;
use crate::tessellation::TessellationError;
use nalgebra::Point3;

/// A fragment of fewer whole tetrahedra cannot be struck again.
pub const TETS_MIN: usize = BODY_TETS_MIN;

/// Displacements of a fragment of more nodes are found on the object's coarser elastic lattice: its stiffness is factored within
/// the strike.
pub const SOLVED_NODES_MAX: usize = 1_000;

/// Most contacts of one strike.
pub const CONTACTS_MAX: usize = 8;

/// A strike that has no answer. Nothing was changed by it; [`Self::is_callers`] says whose to mend it is.
#[derive(Debug, thiserror::Error)]
pub enum FractureError {
    /// No contact, or more than [`CONTACTS_MAX`].
    #[error("{0} contacts; 1 to {CONTACTS_MAX} are possible")]
    ContactCount(usize),
    /// A coordinate, duration or radius is not finite, or not positive where it must be.
    #[error("contact {contact}: {key} must be finite{also}, got {value}", also = if *.positive { " and positive" } else { "" })]
    Number {
        /// Which contact.
        contact: usize,
        /// Which number.
        key: &'static str,
        /// What it was.
        value: f64,
        /// Whether it must be positive too.
        positive: bool,
    },
    /// All impulses are zero.
    #[error("contact {contact}: the impulse is zero")]
    ZeroImpulse {
        /// Which contact.
        contact: usize,
    },
    /// The contacts of a body cancel, or press on its anchors alone: nothing is deformed.
    #[error("the contacts of body {body} cancel each other, or press on anchors alone: nothing is deformed")]
    Balanced {
        /// Which body.
        body: usize,
    },
    /// γ is not finite and positive.
    #[error("gamma must be finite and positive, got {0}")]
    Gamma(f64),
    /// Impulse, modulus and γ are so far apart that E_1/γ is no number.
    #[error("E_1/gamma is {0}: impulse, duration, size and gamma are too far apart for numbers to hold")]
    Range(f64),
    /// Zero sites, or more than the cap.
    #[error("degree {degree}: 1 to {cap} sites are possible")]
    Degree {
        /// What was asked.
        degree: u32,
        /// The cap.
        cap: u32,
    },
    /// The contact point is farther from the body than its radius.
    #[error(
        "contact {contact} is {distance_m:.6} m from the surface; contacts must lie within {radius_m:.6} m (radius). The nearest surface point is {}. Check --unit and --up.",
        point(.surface_m)
    )]
    TooFar {
        /// Which contact.
        contact: usize,
        /// Distance to the nearest body, m.
        distance_m: f64,
        /// The radius given, m.
        radius_m: f64,
        /// The nearest point of a body, m.
        surface_m: Point3<f64>,
    },
    /// A ray whose direction is zero or not finite.
    #[error("the direction of the ray is zero or not finite; pass a direction of any other length")]
    RayDirection,
    /// A ray that does not meet the object.
    #[error(
        "the ray misses the object by {distance_m:.6} m; at {} it is closest to the surface point {}",
        point(.ray_m), point(.surface_m)
    )]
    RayMissed {
        /// The point of the ray that is closest to the object, m.
        ray_m: Point3<f64>,
        /// The point of the surface that is closest to the ray, m.
        surface_m: Point3<f64>,
        /// Between the two, m.
        distance_m: f64,
    },
    /// The object is not prepared for deformation.
    #[error("body {body} is not prepared for elasticity: the scene does without, or it was baked without")]
    ElasticityUnprepared {
        /// Which body.
        body: usize,
    },
    /// Nothing holds the object, or nothing pulls at it.
    #[error("the object is not prepared for the effect `{}`: a scene's `anchors` do that", .effect.name())]
    Unheld {
        /// What was asked for.
        effect: EffectKind,
    },
    /// The object's surface was not kept for that effect.
    #[error("the object is not prepared for the effect `{}`: bake it again", .effect.name())]
    Bare {
        /// What was asked for.
        effect: EffectKind,
    },
    /// The answer that a fragment is of has no skins.
    #[error(
        "fragment {fragment} has no skin: the strike that it comes from was without the effect `skin`; repeat that with it"
    )]
    Undressed {
        /// Which.
        fragment: u32,
    },
    /// The object is not prepared for that lift.
    #[error("body {body} has no lift {lift}: the scene does without, or `shatterd inspect` says why; or bake it again")]
    LiftUnprepared {
        /// Which body.
        body: usize,
        /// Which lift.
        lift: LiftKind,
    },
    /// The answer has no such fragment.
    #[error("fragment {fragment}: the answer has {count}, counted from 0")]
    UnknownFragment {
        /// Which was asked for.
        fragment: u32,
        /// How many there are.
        count: u32,
    },
    /// A fragment of fewer than [`TETS_MIN`] whole tetrahedra cannot be struck again.
    #[error("fragment {fragment} is too small to be struck: it holds fewer than {TETS_MIN} whole tetrahedra")]
    FragmentSmall {
        /// Which.
        fragment: u32,
    },
    /// A fragment has more than [`SOLVED_NODES_MAX`] nodes, and the object's elastic lattice does not resolve it.
    #[error(
        "fragment {fragment} has {nodes} nodes, of which {SOLVED_NODES_MAX} are solved for, and is too thin for the elastic lattice: do without `elastic`"
    )]
    FragmentLarge {
        /// Which.
        fragment: u32,
        /// Its nodes.
        nodes: usize,
    },
    /// Fragments do not have that lift.
    #[error("fragment {fragment} has no lift {lift}: `euclidean` and `interior` are made for fragments")]
    FragmentLiftKind {
        /// Which.
        fragment: u32,
        /// Which lift.
        lift: LiftKind,
    },
    /// The lift of a fragment could not be made.
    #[error("interior lift of fragment {fragment}: {source}")]
    FragmentLift {
        /// Which.
        fragment: u32,
        /// Why.
        source: LiftError,
    },
    /// What was kept is of another object, or of another version of it; a fault of ours.
    #[error("the answer that was kept is not one of this object")]
    OtherObject,
    /// The elastic solve refused.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Which body.
        body: usize,
        /// Why.
        source: ElasticityError,
    },
    /// The strain energy is no density.
    #[error("strain energy of body {body}: {source}")]
    Field {
        /// Which body.
        body: usize,
        /// Why.
        source: FieldError,
    },
    /// Labels do not fit the lattice; a fault of ours.
    #[error(transparent)]
    Tessellation(#[from] TessellationError),
    /// The memory given to the emission has other lengths than the fragments need; a fault of ours.
    #[error("sections hold {given:?}, the fragments need {needed:?}")]
    SectionLengths {
        /// What was given.
        given: BulkCounts,
        /// What is needed.
        needed: BulkCounts,
    },
    /// Cancelled at a checkpoint.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A point as command lines take it.
fn point(point: &Point3<f64>) -> String {
    format!("{:.6},{:.6},{:.6}", point.x, point.y, point.z)
}

impl FractureError {
    /// What elasticity said of body `body`.
    pub(in crate::pipeline) fn of_body(body: usize, source: ElasticityError) -> Self {
        match source {
            ElasticityError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            source => Self::Elasticity { body, source },
        }
    }

    /// Whether the request was at fault (it will fail again), rather than the service.
    pub fn is_callers(&self) -> bool {
        !matches!(
            self,
            Self::Tessellation(_)
                | Self::SectionLengths { .. }
                | Self::Cancelled(_)
                | Self::OtherObject
                | Self::Field { .. }
                | Self::Elasticity {
                    source: ElasticityError::Residual { .. } | ElasticityError::OtherLattice { .. },
                    ..
                }
        )
    }
}
