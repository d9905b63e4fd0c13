//! What strikes an object: a plain struct, whose zeros are its defaults.

use crate::border::{Failure, elements, wrong};
use shatter_client::{Effects, ErrorKind};
use shatter_proto::request::CONTACTS_MAX;
use std::time::Duration;

/// For `iterations_max`: none at all.
pub const NO_ITERATIONS: u32 = u32::MAX;

/// Where and how hard an object is hit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Contact {
    /// Where, in the coordinates of the mesh file, m, +Y up. With a ray: where the ray begins.
    pub point_m: [f64; 3],
    /// Impulse handed to the object, N·s; not zero.
    pub impulse_ns: [f64; 3],
    /// Contact duration, s; 0: the object's default.
    pub duration_s: f64,
    /// Contact radius, m; 0: the object's default.
    pub radius_m: f64,
    /// Direction of a ray, of any length: the object is struck where the ray first meets it. Zero: there is no ray. For
    /// impacts of one contact; `ShatterSummary.hit` tells where it met.
    pub ray: [f64; 3],
}

/// One impact: contacts, and how the answer shall be computed. Zero is the default of everything but the contacts, so begin with
/// `ShatterImpact impact = {0};` (in C++ `{}`) and set what you need. The service names what it refuses.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Impact {
    /// 1 to 8 contacts; read during the call alone.
    pub contacts: *const Contact,
    /// How many.
    pub contact_count: usize,
    /// What for, a `ShatterPurpose`.
    pub purpose: u32,
    /// Where the number of sites comes from, a `ShatterDegree`.
    pub degree: u32,
    /// That number under `SHATTER_DEGREE_SITES`, else 0.
    pub degree_sites: u32,
    /// Which lift, a `ShatterLift`.
    pub lift: u32,
    /// Where displacements come from, a `ShatterElastic`.
    pub elastic: u32,
    /// Which preset says what nothing else says, a `ShatterQuality`.
    pub quality: u32,
    /// Iterations at most by which the pieces are centered; 0: the preset's. `SHATTER_NO_ITERATIONS`: none.
    pub iterations_max: u32,
    /// Refuse an answer of more fragments; 0: the object's cap.
    pub fragments_max: u32,
    /// Refuse an answer of more bytes; 0: the daemon's bucket.
    pub bytes_max: u64,
    /// γ, J·m²; 0: the object's own.
    pub gamma_j_m2: f64,
    /// Largest estimated relative error, of the elastic energy and of how the pieces are centered; 0: the preset's dials decide.
    pub error_max: f64,
    /// How long the service may take from when it takes the strike in until it sends the answer, ms: quality falls where that is
    /// short; 0: any time.
    pub time_ms_max: f64,
    /// After how long the answer is of no use, ms: strikes with less time left go first, one that cannot be in time is refused; 0: it
    /// always is of use.
    pub deadline_ms: f64,
    /// Everything random follows from it.
    pub seed: u64,
    /// Effects to switch on, `ShatterEffect`s joined by `|`.
    pub enable: u64,
    /// Effects to switch off.
    pub disable: u64,
    /// Handle of the kept answer whose fragment is struck (`ShatterSummary.handle`); 0: the object itself is.
    pub from_handle: u64,
    /// That fragment; 0 without a handle.
    pub from_fragment: u32,
    /// Whether the service keeps the answer for a while, so that its fragments can be struck.
    pub keep: bool,
    /// Zero.
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

choices! { Purpose Degree Lift Elastic Quality }

/// What a strike is for.
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

/// Where the number of sites comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Degree {
    /// From where the preset says.
    Preset = 0,
    /// The calibrated closed form.
    ClosedForm = 1,
    /// The full optimisation.
    Optimised = 2,
    /// `degree_sites`; breaks the object whatever γ says.
    Sites = 3,
    /// The inferred number, made to hold.
    Verified = 4,
    /// What the object has learned from its examples; the closed form where they do not reach.
    Inferred = 5,
}

impl Degree {
    const ALL: [Self; 6] =
        [Self::Preset, Self::ClosedForm, Self::Optimised, Self::Sites, Self::Verified, Self::Inferred];
}

/// In which space the cells are straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Lift {
    /// The object's default.
    Object = 0,
    /// Space itself.
    Euclidean = 1,
    /// That of interior distances.
    Interior = 2,
    /// That of diffusion on the surface, carried inside.
    SurfaceDiffusion = 3,
}

impl Lift {
    const ALL: [Self; 4] = [Self::Object, Self::Euclidean, Self::Interior, Self::SurfaceDiffusion];
}

/// Where displacements come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Elastic {
    /// From where the preset says.
    Preset = 0,
    /// The solve.
    Solve = 1,
    /// The object's reduced basis, where it has one that is exact enough for the impact; else the solve.
    Reduced = 2,
}

impl Elastic {
    const ALL: [Self; 3] = [Self::Preset, Self::Solve, Self::Reduced];
}

/// A preset: a bundle of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Quality {
    /// The object's.
    Object = 0,
    /// To try things out.
    Draft = 1,
    /// A strike within a frame.
    Game = 2,
    /// As fine as cracks are seen close up.
    Film = 3,
    /// What the others are measured by.
    Reference = 4,
}

impl Quality {
    const ALL: [Self; 5] = [Self::Object, Self::Draft, Self::Game, Self::Film, Self::Reference];
}

/// What a strike simulates and sends beyond the bare pieces, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Effect {
    /// Strain energy from the deformation of the body; on by itself.
    Elastic = 0x1,
    /// Tension alone drives cracks.
    Tensile = 0x2,
    /// Interior distances; on by itself.
    Interior = 0x4,
    /// The degree from the object's examples; on by itself.
    Examples = 0x8,
    /// Slivers become part of a neighbor.
    Slivers = 0x10,
    /// Velocities of the fragments from the strain energy that is set free.
    Release = 0x20,
    /// Normals, one per vertex.
    Normals = 0x40,
    /// Texture coordinates of crack faces, one per vertex.
    Uv = 0x80,
    /// Which fragments touch, and how.
    Bonds = 0x100,
    /// Points on crack faces from which dust and chips come.
    Debris = 0x200,
    /// Convex proxies of the fragments for collisions.
    Hulls = 0x400,
    /// Cells follow what an artist says.
    Warp = 0x800,
    /// What lies in the scene's anchors does not move.
    Anchored = 0x1000,
    /// An anchored body has weight.
    Gravity = 0x2000,
    /// Outer faces look as the input does there.
    Attributes = 0x4000,
    /// The input's own triangles, cut as the object is.
    Skin = 0x8000,
}

impl Impact {
    /// As the client wants it.
    ///
    /// # Safety
    /// `contacts` is null or points to `contact_count` contacts.
    pub(crate) unsafe fn read(&self) -> Result<shatter_client::Impact, Failure> {
        // SAFETY: handed on.
        let impact = unsafe { self.contacts() }?;
        self.refine(impact.degree(self.degree()?))
    }

    /// What strikes alone have, and whether this one has it.
    pub(crate) fn of_a_blow(&self) -> [(&'static str, bool); 3] {
        [
            ("impact.contact_count", self.contact_count != 0),
            ("impact.degree", self.degree != 0 || self.degree_sites != 0),
            ("impact.from_handle", self.from_handle != 0 || self.from_fragment != 0),
        ]
    }

    /// `impact` with everything but contacts and degree.
    pub(crate) fn refine(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let impact = self.effects(self.dials(impact)?)?;
        if self.reserved != [0; 8] {
            let message = "reserved words must be zero";
            return Err(shatter_client::Error::new(ErrorKind::ReservedField, "impact.reserved", message).into());
        }
        self.origin(impact.seed(self.seed))
    }

    /// An impact of the contacts, and nothing else.
    ///
    /// # Safety
    /// As of [`Self::read`].
    unsafe fn contacts(&self) -> Result<shatter_client::Impact, Failure> {
        // Refused before a pointer is followed that far.
        let count = self.contact_count;
        if count == 0 || count > CONTACTS_MAX {
            let message = format!("{count} contacts: must be 1 to {CONTACTS_MAX}");
            return Err(shatter_client::Error::new(ErrorKind::ContactCount, count.to_string(), message).into());
        }
        // SAFETY: handed on.
        let contacts = unsafe { elements("impact.contacts", self.contacts, count) }?;
        Ok(shatter_client::Impact::new(contacts.iter().map(shatter_client::Contact::from)))
    }

    fn dials(&self, impact: shatter_client::Impact) -> Result<shatter_client::Impact, Failure> {
        let impact = match Purpose::of(ErrorKind::UnknownRequest, "impact.purpose", self.purpose)? {
            Purpose::Fragments => impact,
            Purpose::Threshold => impact.threshold_only(),
        };
        let impact = impact.elastic(match Elastic::of(ErrorKind::Elastic, "impact.elastic", self.elastic)? {
            Elastic::Preset => shatter_client::DisplacementSource::Preset,
            Elastic::Solve => shatter_client::DisplacementSource::Solve,
            Elastic::Reduced => shatter_client::DisplacementSource::Reduced,
        });
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
        let impact = told(impact, self.gamma_j_m2, shatter_client::Impact::gamma);
        let impact = told(impact, self.error_max, shatter_client::Impact::error);
        let impact = told(impact, self.time_ms_max, shatter_client::Impact::time_ms);
        self.caps(impact)
    }

    fn degree(&self) -> Result<shatter_client::DegreeRule, Failure> {
        let degree = Degree::of(ErrorKind::Degree, "impact.degree", self.degree)?;
        if degree != Degree::Sites && self.degree_sites != 0 {
            let message = "degree_sites must be zero unless that many sites are asked for";
            return Err(shatter_client::Error::new(ErrorKind::Degree, "impact.degree_sites", message).into());
        }
        Ok(match degree {
            Degree::Preset => shatter_client::DegreeRule::Preset,
            Degree::ClosedForm => shatter_client::DegreeRule::ClosedForm,
            Degree::Optimised => shatter_client::DegreeRule::Optimised,
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
        let deadline = Duration::try_from_secs_f64(1e-3 * self.deadline_ms)
            .map_err(|error| wrong("impact.deadline_ms", format!("a deadline of {} ms: {error}", self.deadline_ms)))?;
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
                let message = format!("fragment {fragment} of no answer: a handle says of which");
                let refusal = shatter_client::Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message);
                return Err(refusal.into());
            }
            (handle, fragment) => impact.from(handle, fragment),
        };
        Ok(if self.keep { impact.keep() } else { impact })
    }
}

/// Zero stands for "not said".
impl From<&Contact> for shatter_client::Contact {
    fn from(contact: &Contact) -> Self {
        let said = |value: f64| (value != 0.0).then_some(value);
        Self {
            ray: (contact.ray != [0.0; 3]).then_some(contact.ray),
            duration_s: said(contact.duration_s),
            radius_m: said(contact.radius_m),
            ..Self::new(contact.point_m).impulse(contact.impulse_ns)
        }
    }
}

/// Zero stands for "not said".
fn told(
    impact: shatter_client::Impact,
    value: f64,
    say: impl FnOnce(shatter_client::Impact, f64) -> shatter_client::Impact,
) -> shatter_client::Impact {
    if value == 0.0 { impact } else { say(impact, value) }
}

#[cfg(test)]
mod tests;
