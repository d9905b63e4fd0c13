//! Errors of a request.

use super::contact::PartnerError;
use super::output::rows::BulkCounts;
use crate::cancel_token::Canceled;
use crate::centroidal::FieldError;
use crate::elasticity::ElasticityError;
use crate::lattice::BODY_TETS_MIN;
use crate::lift::{LiftError, LiftKind};
use crate::scene::{EffectKind, counted, fixed, number};
use crate::surface::LengthUnit;
use crate::tessellation::TessellationError;
use nalgebra::Point3;

/// Smallest number of whole tetrahedra of a fragment that can be struck again.
pub const TETS_MIN: usize = BODY_TETS_MIN;

/// Smallest number of nodes of a fragment that can be divided, counting nodes on one short edge as one.
pub const NODES_MIN: usize = 2;

/// Largest distance of the origin of a ray from the center of the object, m. From farther away, rounding moves the hit.
pub const RAY_ORIGIN_MAX_M: f64 = 1e9;

/// Largest number of nodes of a fragment whose displacements are solved for on its own lattice.
///
/// Larger fragments use the object's coarser elastic lattice, because their stiffness is factored within the request.
pub const SOLVED_NODES_MAX: usize = 1_000;

/// Largest number of contacts of one request.
pub const CONTACTS_MAX: usize = 8;

/// A request that failed and changed nothing.
///
/// [`Self::is_callers`] distinguishes errors of the request from faults of the service.
#[derive(thiserror::Error)]
pub enum FractureError {
    /// No contact, or more than [`CONTACTS_MAX`].
    #[error("the request has {0} contacts; pass 1 to {CONTACTS_MAX}")]
    ContactCount(usize),
    /// A coordinate, duration or radius is not finite, or not positive where it must be.
    #[error("contact {contact}: {key} must be finite{also}, got {}", number(*.value), also = if *.positive { " and positive" } else { "" })]
    Number {
        /// Index of the contact.
        contact: usize,
        /// Name of the number.
        key: &'static str,
        /// Its value.
        value: f64,
        /// True if it must also be positive.
        positive: bool,
    },
    /// The impulse of a contact is zero.
    #[error("contact {contact}: the impulse is zero; pass a nonzero impulse in N·s")]
    ZeroImpulse {
        /// Index of the contact.
        contact: usize,
    },
    /// The partners of the contacts do not limit the energy.
    #[error(transparent)]
    Partner(#[from] PartnerError),
    /// The contacts of a body cancel, or press on its anchors only, so that nothing deforms.
    #[error("body {body}: the contacts cancel or press on anchors only, so nothing is deformed; move them")]
    Balanced {
        /// Index of the body.
        body: usize,
    },
    /// γ is not finite and positive.
    #[error("gamma must be finite and positive, got {}", number(*.0))]
    Gamma(f64),
    /// The factor on the strength is not finite and positive.
    #[error("strength_scale must be finite and positive, got {}", number(*.0))]
    StrengthScale(f64),
    /// E_1/γ is not a normal 64-bit number, because impulse, modulus and γ differ too much in magnitude.
    #[error("E_1/gamma is {}, beyond 64-bit numbers; check the units of impulse, duration, size and gamma", number(*.0))]
    Range(f64),
    /// Zero sites, or more than the maximum.
    #[error("degree {degree} is out of range; pass 1 to {cap} sites")]
    Degree {
        /// Number of sites of the request.
        degree: u32,
        /// Largest number of sites.
        cap: u32,
    },
    /// The contact point is farther from the body than its radius and a lattice spacing.
    #[error(
        "contact {contact} is {} {unit} from the surface; at most {} {unit} (radius + lattice spacing) is allowed. Nearest surface point, in {unit} in the request's coordinates: {}",
        length(.distance), length(.limit),
        point(.surface), unit = unit(.unit_m)
    )]
    TooFar {
        /// Index of the contact.
        contact: usize,
        /// Distance to the nearest body, in units.
        distance: f64,
        /// Largest allowed distance, in units.
        limit: f64,
        /// Nearest point of a body, in units.
        surface: Point3<f64>,
        /// Unit of length, m.
        unit_m: f64,
    },
    /// A ray whose direction is zero or not finite.
    #[error("the direction of the ray is zero or not finite; pass a finite one of any length above zero")]
    RayDirection,
    /// A ray that starts farther than [`RAY_ORIGIN_MAX_M`] from the center of the object.
    #[error(
        "the ray starts more than {RAY_ORIGIN_MAX_M:e} m from the object; start it nearer: `shatter list` prints the object's bounds"
    )]
    RayOrigin,
    /// The ray misses the object.
    #[error(
        "the ray misses the object by {} {unit}; its point {} {unit} is the closest, to the surface point {} {unit}. Aim past this point, into the object, or reverse a ray that points away.",
        length(.distance), point(.ray), point(.surface), unit = unit(.unit_m)
    )]
    RayMissed {
        /// Point of the ray closest to the object, in units.
        ray: Point3<f64>,
        /// Point of the surface closest to the ray, in units.
        surface: Point3<f64>,
        /// Distance between the two, in units.
        distance: f64,
        /// Unit of length, m.
        unit_m: f64,
    },
    /// The object has no elasticity tables.
    #[error("body {body} has no elasticity tables; strike without `elastic`, enable it in the scene, or bake it again")]
    ElasticityUnprepared {
        /// Index of the body.
        body: usize,
    },
    /// The object has no anchors or no gravity, which the effect needs.
    #[error("the object is not prepared for the effect `{}`: give it `anchors` in the scene", .effect.name())]
    AnchorsUnprepared {
        /// Requested effect.
        effect: EffectKind,
    },
    /// The body has no vibrations, which the effect `dynamics` needs.
    #[error(
        "body {body} has no basis of displacements with masses, which the effect `dynamics` needs; bake it again with --elements quadratic or --examples 50, and without --elastic solve"
    )]
    DynamicsUnprepared {
        /// Index of the body.
        body: usize,
    },
    /// The anchored body has no vibrations, which the effect `dynamics` needs.
    #[error(
        "body {body} has no basis of displacements with masses for its anchors, which the effect `dynamics` needs; bake it again with --elements quadratic, and then the scene by `shatterd bake --scene FILE`"
    )]
    DynamicsAnchorsUnprepared {
        /// Index of the body.
        body: usize,
    },
    /// The effects `dynamics` and `gravity` together.
    #[error("the effect `dynamics` leaves out the weight: strike without it, or without `gravity`")]
    DynamicsGravity,
    /// The effect `dynamics` for a fragment.
    #[error("the effect `dynamics` is for whole objects: strike fragment {fragment} without it")]
    FragmentDynamics {
        /// Index of the fragment.
        fragment: u32,
    },
    /// The database holds no surface for the effect.
    #[error("the object is not prepared for the effect `{}`: bake it again", .effect.name())]
    AttributesUnprepared {
        /// Requested effect.
        effect: EffectKind,
    },
    /// The result that contains the fragment has no skins.
    #[error(
        "fragment {fragment} has no skin: the request that made it lacked the effect `skin`; repeat that request with it"
    )]
    SkinUnprepared {
        /// Index of the fragment.
        fragment: u32,
    },
    /// The object has no table for the lift.
    #[error("body {body} has no lift {lift}; enable it in the scene or bake it again (`shatterd inspect` prints why)")]
    LiftUnprepared {
        /// Index of the body.
        body: usize,
        /// Requested lift.
        lift: LiftKind,
    },
    /// The result has no such fragment.
    #[error("fragment {fragment} does not exist; the result has {}, counted from 0", counted((*.count).into(), "fragment"))]
    UnknownFragment {
        /// Requested fragment.
        fragment: u32,
        /// Number of fragments.
        count: u32,
    },
    /// The fragment has fewer than [`TETS_MIN`] whole tetrahedra and cannot be struck again. Fragments with an exact surface can.
    #[error(
        "fragment {fragment} is too small to be struck: it has fewer than {TETS_MIN} whole tetrahedra of the lattice; fragments with an exact surface have no such limit"
    )]
    FragmentSmall {
        /// Index of the fragment.
        fragment: u32,
    },
    /// The fragment has fewer than [`NODES_MIN`] nodes that may get different labels, so it cannot be divided.
    #[error("fragment {fragment} is too small to be divided: a single node of the object's mesh is inside")]
    FragmentUndivided {
        /// Index of the fragment.
        fragment: u32,
    },
    /// The fragment has more than [`SOLVED_NODES_MAX`] nodes, and the object's elastic lattice does not resolve it.
    #[error(
        "fragment {fragment} has {nodes} nodes, above the maximum of {SOLVED_NODES_MAX}, and is too thin for the elastic lattice; strike it without `elastic`"
    )]
    FragmentLarge {
        /// Index of the fragment.
        fragment: u32,
        /// Number of its nodes.
        nodes: usize,
    },
    /// Fragments do not have the requested lift.
    #[error("fragment {fragment} has no lift {lift}; fragments have `euclidean` and `interior` only")]
    FragmentLiftKind {
        /// Index of the fragment.
        fragment: u32,
        /// Requested lift.
        lift: LiftKind,
    },
    /// The lift of a fragment could not be computed.
    #[error("interior lift of fragment {fragment}: {source}")]
    FragmentLift {
        /// Index of the fragment.
        fragment: u32,
        /// Cause.
        source: LiftError,
    },
    /// The retained fragments belong to another object or another version of it. A fault of the service.
    #[error("the retained fragments belong to another object, or to another version of this one")]
    OtherObject,
    /// The elastic solve failed.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Index of the body.
        body: usize,
        /// Cause.
        source: ElasticityError,
    },
    /// The strain energy is not a valid density.
    #[error("strain energy of body {body}: {source}")]
    Field {
        /// Index of the body.
        body: usize,
        /// Cause.
        source: FieldError,
    },
    /// Labels do not fit the lattice. A fault of the service.
    #[error(transparent)]
    Tessellation(#[from] TessellationError),
    /// The output memory has other lengths than the fragments need. A fault of the service.
    #[error("the output sections have the lengths {given:?}; the fragments need {needed:?}")]
    SectionLengths {
        /// Lengths of the output memory.
        given: BulkCounts,
        /// Lengths that the fragments need.
        needed: BulkCounts,
    },
    /// Canceled at a checkpoint.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

fn length(length: &f64) -> String {
    fixed(&[*length])
}

/// Name of a unit of length, m.
fn unit(meters: &f64) -> String {
    let named = LengthUnit::ALL.iter().find(|own| own.meters() == *meters);
    named.map_or_else(|| format!("units of {} m", number(*meters)), ToString::to_string)
}

/// A point in the form that command lines accept.
fn point(point: &Point3<f64>) -> String {
    fixed(point.coords.as_slice())
}

impl FractureError {
    /// Error of the elasticity of body `body`.
    pub(in crate::pipeline) fn of_body(body: usize, source: ElasticityError) -> Self {
        match source {
            ElasticityError::Canceled(canceled) => Self::Canceled(canceled),
            source => Self::Elasticity { body, source },
        }
    }

    /// True if the request is at fault and would fail again, rather than the service.
    pub fn is_callers(&self) -> bool {
        !matches!(
            self,
            Self::Tessellation(_)
                | Self::SectionLengths { .. }
                | Self::Canceled(_)
                | Self::OtherObject
                | Self::Field { .. }
                | Self::Elasticity {
                    source: ElasticityError::Residual { .. } | ElasticityError::OtherLattice { .. },
                    ..
                }
        )
    }
}
