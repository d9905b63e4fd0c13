//! Impacts as plain structs, whose zeros are the defaults.

use crate::ffi_boundary::{Failure, elements, wrong};
use shatter_client::{ContactPartner, Effects, ErrorKind};
use shatter_proto::request::CONTACTS_MAX;
use std::time::Duration;

/// Value of `iterations_max` for no iterations.
pub const NO_ITERATIONS: u32 = u32::MAX;

/// One contact of an impact: point, impulse, duration, radius, and the body that strikes, if it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Contact {
    /// Contact point in the coordinates of the object, m, +Y up. With a ray: its origin.
    pub point_m: [f64; 3],
    /// Impulse on the object, N·s; not zero.
    pub impulse_ns: [f64; 3],
    /// Contact duration, s; 0: the object's default.
    pub duration_s: f64,
    /// Contact radius, m; 0: the object's default.
    pub radius_m: f64,
    /// Direction of a ray, of any length: the contact point is its first hit on the object. Zero: no ray. Only for impacts of one contact;
    /// `ShatterSummary.hit` has the hit.
    pub ray: [f64; 3],
    /// Number of the body that strikes the object here: contacts with the same number have the same partner, whose energy counts once.
    pub partner: u64,
    /// Mass of the partner, kg; `INFINITY`: it does not move. 0: there is no partner, and the energy of the impact has no limit; the next
    /// three fields are then 0. Set it for all contacts or for none.
    pub partner_mass_kg: f64,
    /// Closing speed of partner and object along the impulse, m/s; negative where they separate.
    pub speed_m_s: f64,
    /// Center of mass of the partner, m; of no effect without inertia.
    pub partner_center_m: [f64; 3],
    /// Inertia tensor of the partner about its center, kg·m²: xx, yy, zz, xy, xz, yz. Zero: it does not rotate.
    pub partner_inertia_kg_m2: [f64; 6],
}

impl Contact {
    /// The partner; `None` if no field of it is set.
    fn striker(&self) -> Option<ContactPartner> {
        let own = ContactPartner::new(self.partner, self.partner_mass_kg, self.speed_m_s);
        let own = own.rotating(self.partner_center_m, self.partner_inertia_kg_m2);
        (own != ContactPartner::new(0, 0.0, 0.0)).then_some(own)
    }
}

/// An impact: contacts, and options of the request. Zero is the default of everything except the contacts. Begin with `ShatterImpact impact
/// = {0};` (in C++ `{}`) and set the fields that you need. An error names the field that the service refuses.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Impact {
    /// 1 to 8 contacts, read only during the call.
    pub contacts: *const Contact,
    /// Number of contacts.
    pub contact_count: usize,
    /// Purpose, a `ShatterPurpose`.
    pub purpose: u32,
    /// Source of the number of sites, a `ShatterDegree`.
    pub degree: u32,
    /// Number of sites with `SHATTER_DEGREE_SITES`, else 0.
    pub degree_sites: u32,
    /// Lift, a `ShatterLift`.
    pub lift: u32,
    /// Source of the displacements, a `ShatterElastic`.
    pub elastic: u32,
    /// Preset of all settings that are not set here, a `ShatterQuality`.
    pub quality: u32,
    /// Largest number of iterations of the diagram; 0: the preset's. `SHATTER_NO_ITERATIONS`: none.
    pub iterations_max: u32,
    /// Largest number of fragments, beyond which the service refuses; 0: the object's cap.
    pub fragments_max: u32,
    /// Largest size of the result, bytes, beyond which the service refuses; 0: the size of the daemon's buckets.
    pub bytes_max: u64,
    /// γ, J·m²; 0: the object's own.
    pub gamma_j_m2: f64,
    /// Largest estimated relative error of the elastic energy and of the diagram; 0: the preset decides.
    pub error_max: f64,
    /// Time from the admission of the request until the service sends the result, ms. The service lowers the quality where that is too
    /// short. 0: no limit.
    pub time_ms_max: f64,
    /// Time after which the result is of no use, ms. The service serves requests with less time left first, and refuses one that cannot be
    /// in time. 0: no limit.
    pub deadline_ms: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Effects to switch on, `ShatterEffect`s joined by `|`.
    pub enable: u64,
    /// Effects to switch off.
    pub disable: u64,
    /// Handle of the kept result whose fragment is struck (`ShatterSummary.handle`); 0: the object itself is struck.
    pub from_handle: u64,
    /// Fragment of that result; 0 without a handle.
    pub from_fragment: u32,
    /// Outer surface of the fragments, a `ShatterSurface`. The fragments of a fragment keep its surface.
    pub surface: u32,
    /// True if the service keeps the result for a while, so that its fragments can be struck.
    pub keep: bool,
    /// Rule that decides whether the object breaks, a `ShatterCriterion`.
    pub criterion: u32,
    /// Always zero.
    pub reserved: [u64; 8],
}

macro_rules! choices {
    ($($choice:ident)*) => {
        $(impl $choice {
            fn of(kind: ErrorKind, at: &str, number: u32) -> Result<Self, Failure> {
                let most = Self::ALL.len() - 1;
                let unknown = || shatter_client::Error::new(kind, at, format!("{at} {number}: must be 0 to {most}"));
                Ok(Self::ALL.get(number as usize).copied().ok_or_else(unknown)?)
            }
        })*
    };
}

choices! { Purpose Degree Lift Elastic Surface Criterion Quality }

/// Purpose of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Fragments.
    Fragments = 0,
    /// The load that just breaks the object (`ShatterSummary.threshold_impulse_factor`), without fragments.
    Threshold = 1,
}

impl Purpose {
    const ALL: [Self; 2] = [Self::Fragments, Self::Threshold];
}

/// Source of the number of sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Degree {
    /// The source that the preset names.
    Preset = 0,
    /// The calibrated closed form.
    ClosedForm = 1,
    /// The full optimization.
    Optimized = 2,
    /// `degree_sites`; breaks the object whatever γ is.
    Sites = 3,
    /// The inferred number, corrected until the criterion holds.
    Verified = 4,
    /// The number learned from the object's examples; the closed form where the examples do not reach.
    Inferred = 5,
}

impl Degree {
    const ALL: [Self; 6] =
        [Self::Preset, Self::ClosedForm, Self::Optimized, Self::Sites, Self::Verified, Self::Inferred];
}

/// Space in which the cells are straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Lift {
    /// The object's default.
    Object = 0,
    /// Euclidean space.
    Euclidean = 1,
    /// Space of interior distances.
    Interior = 2,
    /// Space of diffusion on the surface, extended to the interior.
    SurfaceDiffusion = 3,
}

impl Lift {
    const ALL: [Self; 4] = [Self::Object, Self::Euclidean, Self::Interior, Self::SurfaceDiffusion];
}

/// Source of the displacements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Elastic {
    /// The source that the preset names.
    Preset = 0,
    /// An elastic solve.
    Solve = 1,
    /// The object's reduced basis, if it has one that is accurate enough for the impact; else the solve.
    Reduced = 2,
}

impl Elastic {
    const ALL: [Self; 3] = [Self::Preset, Self::Solve, Self::Reduced];
}

/// Outer surface of the fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Surface {
    /// The input surface itself, if the object has a mesh of it; else the lattice's.
    Exact = 0,
    /// The lattice's, with fewer triangles.
    Lattice = 1,
}

impl Surface {
    const ALL: [Self; 2] = [Self::Exact, Self::Lattice];
}

/// Rule that decides whether an object breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Criterion {
    /// The object's.
    Object = 0,
    /// The paper's: the first moment of the energy exceeds γ.
    Paper = 1,
    /// Strength and energy.
    Strength = 2,
}

impl Criterion {
    const ALL: [Self; 3] = [Self::Object, Self::Paper, Self::Strength];
}

/// A preset of the settings that an impact does not set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Quality {
    /// The object's preset.
    Object = 0,
    /// Coarse, for trying things out.
    Draft = 1,
    /// For a request within a frame.
    Game = 2,
    /// As fine as close-up views of cracks need.
    Film = 3,
    /// The reference that the other presets are measured against.
    Reference = 4,
}

impl Quality {
    const ALL: [Self; 5] = [Self::Object, Self::Draft, Self::Game, Self::Film, Self::Reference];
}

/// Effects that a request simulates or adds to the result, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Effect {
    /// Strain energy from the deformation of the body; on by default.
    Elastic = 0x1,
    /// Only tension drives cracks.
    Tensile = 0x2,
    /// Interior distances; on by default.
    Interior = 0x4,
    /// The degree from the object's examples; on by default.
    Examples = 0x8,
    /// Slivers are merged into a neighbor.
    Slivers = 0x10,
    /// Velocities of the fragments from the released strain energy.
    Release = 0x20,
    /// Normals, one per vertex.
    Normals = 0x40,
    /// Texture coordinates of crack faces, one per vertex.
    Uv = 0x80,
    /// Contact areas between fragments.
    Bonds = 0x100,
    /// Points on crack faces from which dust and chips come.
    Debris = 0x200,
    /// Convex proxies of the fragments for collisions.
    Hulls = 0x400,
    /// Cells follow an artist's controls.
    Warp = 0x800,
    /// Nodes in the scene's anchors do not move.
    Anchored = 0x1000,
    /// An anchored body has weight.
    Gravity = 0x2000,
    /// Normals, texture coordinates and materials of the input on outer faces.
    Attributes = 0x4000,
    /// The input's own triangles, cut along the cracks.
    Skin = 0x8000,
    /// Slow vibrations of the body follow a short contact only in part.
    Dynamics = 0x10000,
}

impl Impact {
    /// The impact as the client takes it.
    ///
    /// # Safety
    /// `contacts` is null or points to `contact_count` contacts.
    pub(crate) unsafe fn read(&self) -> Result<shatter_client::Impact, Failure> {
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let impact = unsafe { self.contacts() }?;
        self.refine(impact.degree(self.degree()?))
    }

    /// Fields that only impacts have, and whether each is set.
    pub(crate) fn impact_only_fields(&self) -> [(&'static str, bool); 3] {
        [
            ("impact.contact_count", self.contact_count != 0),
            ("impact.degree", self.degree != 0 || self.degree_sites != 0),
            ("impact.from_handle", self.from_handle != 0 || self.from_fragment != 0),
        ]
    }

    /// `impact` with every option except contacts and degree.
    pub(crate) fn refine(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let impact = self.effects(self.with_solver_settings(impact)?)?;
        if self.reserved != [0; 8] {
            let message = "reserved fields must be zero; initialize the struct with {0}";
            return Err(shatter_client::Error::new(ErrorKind::ReservedField, "impact.reserved", message).into());
        }
        self.origin(impact.seed(self.seed))
    }

    /// An impact of the contacts, without options.
    ///
    /// # Safety
    /// As of [`Self::read`].
    unsafe fn contacts(&self) -> Result<shatter_client::Impact, Failure> {
        // Refused before the pointer is followed.
        let count = self.contact_count;
        if count == 0 || count > CONTACTS_MAX {
            let message = format!("{count} contacts: must be 1 to {CONTACTS_MAX}");
            return Err(shatter_client::Error::new(ErrorKind::ContactCount, count.to_string(), message).into());
        }
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let contacts = unsafe { elements("impact.contacts", self.contacts, count) }?;
        Ok(shatter_client::Impact::new(contacts.iter().map(shatter_client::Contact::from)))
    }

    fn with_solver_settings(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let impact = match Purpose::of(ErrorKind::UnknownRequest, "impact.purpose", self.purpose)? {
            Purpose::Fragments => impact,
            Purpose::Threshold => impact.threshold_only(),
        };
        let impact = impact.elastic(match Elastic::of(ErrorKind::Elastic, "impact.elastic", self.elastic)? {
            Elastic::Preset => shatter_client::DisplacementSource::Preset,
            Elastic::Solve => shatter_client::DisplacementSource::Solve,
            Elastic::Reduced => shatter_client::DisplacementSource::Reduced,
        });
        let impact = impact.surface(match Surface::of(ErrorKind::Budget, "impact.surface", self.surface)? {
            Surface::Exact => shatter_client::RequestedSurface::Exact,
            Surface::Lattice => shatter_client::RequestedSurface::Lattice,
        });
        let impact = match Criterion::of(ErrorKind::Budget, "impact.criterion", self.criterion)? {
            Criterion::Object => impact,
            Criterion::Paper => impact.criterion(shatter_client::RequestedCriterion::Paper),
            Criterion::Strength => impact.criterion(shatter_client::RequestedCriterion::Strength),
        };
        let impact = match Lift::of(ErrorKind::Lift, "impact.lift", self.lift)? {
            Lift::Object => impact,
            Lift::Euclidean => impact.lift(shatter_client::Lift::Euclidean),
            Lift::Interior => impact.lift(shatter_client::Lift::Interior),
            Lift::SurfaceDiffusion => impact.lift(shatter_client::Lift::SurfaceDiffusion),
        };
        let impact = match Quality::of(ErrorKind::Budget, "impact.quality", self.quality)? {
            Quality::Object => impact,
            Quality::Draft => impact.quality(shatter_client::Quality::Draft),
            Quality::Game => impact.quality(shatter_client::Quality::Game),
            Quality::Film => impact.quality(shatter_client::Quality::Film),
            Quality::Reference => impact.quality(shatter_client::Quality::Reference),
        };
        let impact = match self.iterations_max {
            0 => impact,
            NO_ITERATIONS => impact.iterations(0),
            count => impact.iterations(count),
        };
        let impact = unless_zero(impact, self.gamma_j_m2, shatter_client::Impact::gamma);
        let impact = unless_zero(impact, self.error_max, shatter_client::Impact::error);
        let impact = unless_zero(impact, self.time_ms_max, shatter_client::Impact::time_ms);
        self.caps(impact)
    }

    fn degree(&self) -> Result<shatter_client::DegreeRule, Failure> {
        let degree = Degree::of(ErrorKind::Degree, "impact.degree", self.degree)?;
        if degree != Degree::Sites && self.degree_sites != 0 {
            let message = "degree_sites must be 0 unless degree is SHATTER_DEGREE_SITES";
            return Err(shatter_client::Error::new(ErrorKind::Degree, "impact.degree_sites", message).into());
        }
        Ok(match degree {
            Degree::Preset => shatter_client::DegreeRule::Preset,
            Degree::ClosedForm => shatter_client::DegreeRule::ClosedForm,
            Degree::Optimized => shatter_client::DegreeRule::Optimized,
            Degree::Sites => shatter_client::DegreeRule::Sites(self.degree_sites),
            Degree::Verified => shatter_client::DegreeRule::Verified,
            Degree::Inferred => shatter_client::DegreeRule::Inferred,
        })
    }

    fn caps(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let impact = if self.fragments_max > 0 { impact.fragments_max(self.fragments_max) } else { impact };
        let impact = if self.bytes_max > 0 { impact.bytes_max(self.bytes_max) } else { impact };
        if self.deadline_ms == 0.0 {
            return Ok(impact);
        }
        let deadline = Duration::try_from_secs_f64(1e-3 * self.deadline_ms).map_err(|error| {
            wrong("impact.deadline_ms", format!("a deadline of {:e} ms: {error}", self.deadline_ms))
        })?;
        Ok(impact.deadline(deadline))
    }

    fn effects(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let enable = Effects::from_bits("impact.enable", self.enable)?;
        let disable = Effects::from_bits("impact.disable", self.disable)?;
        let impact = enable.iter().fold(impact, shatter_client::Impact::enable);
        Ok(disable.iter().fold(impact, shatter_client::Impact::disable))
    }

    fn origin(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let impact = match (self.from_handle, self.from_fragment) {
            (0, 0) => impact,
            (0, fragment) => {
                let message =
                    format!("from_fragment is {fragment}, but from_handle is 0; set the handle of the result");
                let error = shatter_client::Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message);
                return Err(error.into());
            }
            (handle, fragment) => impact.from(handle, fragment),
        };
        Ok(if self.keep { impact.keep() } else { impact })
    }
}

/// Zero stands for the default.
impl From<&Contact> for shatter_client::Contact {
    fn from(contact: &Contact) -> Self {
        let said = |value: f64| (value != 0.0).then_some(value);
        Self {
            ray: (contact.ray != [0.0; 3]).then_some(contact.ray),
            duration_s: said(contact.duration_s),
            radius_m: said(contact.radius_m),
            partner: contact.striker(),
            ..Self::new(contact.point_m).impulse(contact.impulse_ns)
        }
    }
}

/// Applies `set` unless `value` is zero, which stands for the default.
fn unless_zero(
    impact: shatter_client::Impact,
    value: f64,
    set: impl FnOnce(shatter_client::Impact, f64) -> shatter_client::Impact,
) -> shatter_client::Impact {
    if value == 0.0 { impact } else { set(impact, value) }
}

#[cfg(test)]
mod tests;
