//! A request: as it travels, and validated.

use crate::convention::Convention;
use crate::effect::Effects;
use crate::name::{OBJECT_NAME_MAX, object_name};
use crate::text::number;
use crate::{Error, ErrorKind, PROTOCOL_VERSION, text};
use bytemuck::{Pod, Zeroable};
use std::time::Duration;

mod contact;
mod partner;
mod ray;
mod settings;

pub use contact::{Contact, ContactWire};
pub use partner::ContactPartner;
pub use ray::squarable;
pub use settings::{ERROR_MAX, ITERATIONS_MAX, Lift, Quality, RequestedCriterion, RequestedSurface, TIME_MS_MAX};

/// First bytes of every request.
pub const REQUEST_MAGIC: u32 = u32::from_le_bytes(*b"SHTq");

/// Contacts that one request has room for.
pub const CONTACTS_MAX: usize = 8;

/// Default seed: zero, so that zeroed structs of the C interface have it.
pub const SEED_DEFAULT: u64 = 0;

/// A request as it travels. Reserved fields must be zero; the daemon copies it once and then validates it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RequestWire {
    /// [`REQUEST_MAGIC`].
    pub magic: u32,
    /// [`PROTOCOL_VERSION`].
    pub version: u32,
    /// 1: fragments. 2: the threshold alone. 3: the first hit of a ray alone.
    pub purpose: u32,
    /// Number of valid `contacts`, 1 to [`CONTACTS_MAX`].
    pub contact_count: u32,
    /// Number of the request on its connection, from 1 on in the order of sending; names it at the control service.
    pub sequence: u64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The client's listener, woken with the result or the error.
    pub listener: [u8; 16],
    /// Bytes of `object` that count.
    pub object_length: u32,
    /// 0: the preset's. 1: closed form. 2: optimized. 3: `degree_sites`. 4: verified. 5: inferred.
    pub degree: u32,
    /// Number of sites under degree 3, else zero.
    pub degree_sites: u32,
    /// 0: the object's default. 1: Euclidean. 2: interior. 3: surface diffusion.
    pub lift: u32,
    /// γ, J·m²; zero: the object's own.
    pub gamma_j_m2: f64,
    /// Effects to switch on, one bit each ([`crate::effect::Effect`]).
    pub effects_on: u64,
    /// Effects to switch off, one bit each.
    pub effects_off: u64,
    /// Largest estimated error of elastic energy and diagram, relative, at most [`ERROR_MAX`]; zero: the preset decides.
    pub error_max: f64,
    /// Time from the daemon's admission until the result is sent, ms, at most [`TIME_MS_MAX`]; zero: any.
    pub time_ms_max: f64,
    /// 0: +Y. 1: +Z.
    pub convention_up: u32,
    /// 0: right. 1: left.
    pub convention_hand: u32,
    /// 0: counter-clockwise seen from outside. 1: clockwise.
    pub convention_winding: u32,
    /// Fragments at most; zero: the object's cap.
    pub fragments_max: u32,
    /// Meters per unit of length of the caller, within [`METERS_PER_UNIT`](crate::convention::METERS_PER_UNIT); zero: 1.
    pub convention_meters_per_unit: f64,
    /// Handle of the result whose fragment is struck; zero: the object itself is struck.
    pub handle: u64,
    /// Bytes of the result at most; zero: the daemon's bucket.
    pub bytes_max: u64,
    /// UTF-8.
    pub object: [u8; OBJECT_NAME_MAX],
    /// Contacts; those beyond `contact_count` are zero.
    pub contacts: [ContactWire; CONTACTS_MAX],
    /// Source of displacements. 0: the preset says. 1: the solve. 2: the reduced basis, where it is exact enough.
    pub elastic: u64,
    /// Outer surface of the fragments. 0: the input's own, if the object has a mesh of it. 1: that of the lattice.
    pub surface: u64,
    /// Time from the daemon's admission within which the result is of use, ns; 0: any.
    pub deadline_ns: u64,
    /// Results of earlier requests that the client holds, as it counts them.
    pub held: u64,
    /// Fragment of the result of `handle`; zero without one.
    pub fragment: u32,
    /// 1: the service keeps the result, so that its fragments can be struck. 0: it does not.
    pub keep: u32,
    /// 0: the object's preset. 1: draft. 2: game. 3: film. 4: reference.
    pub quality: u32,
    /// 0: the preset's. Else one more than the iterations of a diagram at most, of which there may be [`ITERATIONS_MAX`].
    pub iterations: u32,
    /// Rule that decides whether the object breaks. 0: the object's. 1: the paper's, by γ. 2: by strength and energy.
    pub criterion: u64,
    /// Zero.
    pub reserved: [u64; 9],
}

const _: () = assert!(size_of::<RequestWire>() == 1808);

/// Purpose of a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Fragments.
    #[default]
    Fragments,
    /// The load that just breaks the object, without fragments.
    Threshold,
    /// The point where the ray of the only contact first meets the object; there is no load.
    Aim,
}

/// Source of the number of sites.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DegreeRule {
    /// From where the preset says.
    #[default]
    Preset,
    /// Prediction learned from the object's examples; the calibrated closed form where they do not reach.
    Inferred,
    /// The inferred number, made to hold.
    Verified,
    /// The calibrated closed form.
    ClosedForm,
    /// The full optimization.
    Optimized,
    /// This many, at least 1.
    Sites(u32),
}

/// Source of displacements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplacementSource {
    /// From where the preset says.
    #[default]
    Preset,
    /// The object's reduced basis, where it has one that is exact enough for the impact; else the solve.
    Reduced,
    /// The solve.
    Solve,
}

/// A request as plain types. [`RequestWire::validate`] returns a valid one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// Name of the object.
    pub object: String,
    /// Purpose.
    pub purpose: Purpose,
    /// The coordinates of the contacts and of the result.
    pub convention: Convention,
    /// 1 to [`CONTACTS_MAX`].
    pub contacts: Vec<Contact>,
    /// Source of the number of sites.
    pub degree: DegreeRule,
    /// γ, J·m²; `None`: the object's own.
    pub gamma_j_m2: Option<f64>,
    /// Rule that decides whether the object breaks; `None`: the object's.
    pub criterion: Option<RequestedCriterion>,
    /// Which lift; `None`: the object's default.
    pub lift: Option<Lift>,
    /// Source of displacements.
    pub elastic: DisplacementSource,
    /// Outer surface of the fragments, of the object's surfaces; those of a fragment that is struck again keep its surface.
    pub surface: RequestedSurface,
    /// Preset of the settings that are not given; `None`: the object's.
    pub quality: Option<Quality>,
    /// Largest estimated relative error: elastic energy and diagram are refined until it is met. `None`: the preset decides.
    pub error_max: Option<f64>,
    /// Time from the daemon's admission until the result is sent, ms: quality falls where it would be exceeded.
    pub time_ms_max: Option<f64>,
    /// Iterations of a diagram at most; `None`: the preset's.
    pub iterations_max: Option<u32>,
    /// Effects to switch on.
    pub enable: Effects,
    /// Effects to switch off.
    pub disable: Effects,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Fragments at most; `None`: the object's cap.
    pub fragments_max: Option<u32>,
    /// Bytes of the result at most; `None`: the daemon's bucket.
    pub bytes_max: Option<u64>,
    /// Time from the daemon's admission within which the result is of use; `None`: any. The daemon serves requests with less time
    /// left first, and refuses one that cannot be in time at once.
    pub deadline: Option<Duration>,
    /// The fragment of a kept result that is struck; `None`: the object itself.
    pub from: Option<RetainedFragment>,
    /// Whether the service keeps the result, so that its fragments can be struck.
    pub keep: bool,
}

/// A fragment of a kept result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RetainedFragment {
    /// Handle of the result; not zero.
    pub handle: u64,
    /// Its id in that result.
    pub fragment: u32,
}

impl Request {
    /// The request as it travels, of the client with that listener. The connection that sends it sets `sequence` and `held`.
    ///
    /// # Errors
    /// Those of [`RequestWire::validate`], as the daemon would find them.
    pub fn wire(&self, listener: [u8; 16]) -> Result<RequestWire, Error> {
        if self.contacts.is_empty() || self.contacts.len() > CONTACTS_MAX {
            return Err(contact_count(self.contacts.len()));
        }
        let mut wire = RequestWire::zeroed();
        wire.magic = REQUEST_MAGIC;
        wire.version = PROTOCOL_VERSION;
        wire.purpose = match self.purpose {
            Purpose::Fragments => 1,
            Purpose::Threshold => 2,
            Purpose::Aim => 3,
        };
        wire.contact_count = self.contacts.len() as u32;
        (wire.seed, wire.listener) = (self.seed, listener);
        object_name(&self.object)?;
        wire.object_length = text::put(&mut wire.object, &self.object);
        (wire.degree, wire.degree_sites) = match self.degree {
            DegreeRule::Preset => (0, 0),
            DegreeRule::Inferred => (5, 0),
            DegreeRule::Verified => (4, 0),
            DegreeRule::ClosedForm => (1, 0),
            DegreeRule::Optimized => (2, 0),
            DegreeRule::Sites(sites) => (3, sites),
        };
        wire.elastic = match self.elastic {
            DisplacementSource::Preset => 0,
            DisplacementSource::Solve => 1,
            DisplacementSource::Reduced => 2,
        };
        wire.set_settings(self)?;
        wire.set_convention(&self.convention)?;
        (wire.effects_on, wire.effects_off) = (self.enable.bits(), self.disable.bits());
        wire.gamma_j_m2 = given(self.gamma_j_m2, |_| gamma(0.0))?;
        wire.fragments_max = self.fragments_max.unwrap_or(0);
        wire.bytes_max = self.bytes_max.unwrap_or(0);
        let nanos = |deadline: Duration| u64::try_from(deadline.as_nanos()).unwrap_or(u64::MAX).max(1);
        wire.deadline_ns = self.deadline.map_or(0, nanos);
        wire.keep = u32::from(self.keep);
        if let Some(RetainedFragment { handle, fragment }) = self.from {
            if handle == 0 {
                return Err(unknown_handle(0));
            }
            (wire.handle, wire.fragment) = (handle, fragment);
        }
        for (i, (slot, contact)) in wire.contacts.iter_mut().zip(&self.contacts).enumerate() {
            *slot = contact.wire(i)?;
        }
        wire.validate()?;
        Ok(wire)
    }
}

/// Zero stands for "not given" on the wire, so a given zero is an error here.
fn given(value: Option<f64>, refuse: impl Fn(f64) -> Error) -> Result<f64, Error> {
    match value {
        Some(0.0) => Err(refuse(0.0)),
        Some(value) => Ok(value),
        None => Ok(0.0),
    }
}

impl RequestWire {
    /// Validates a private copy of a request. Never panics, whatever the bytes.
    ///
    /// # Errors
    /// `bad_magic`, `version_mismatch`, `reserved_field`, `unknown_request`, `object_name`, `unknown_effect`, `convention`,
    /// `contact_count`, `contact_point`, `impulse`, `contact_duration`, `contact_radius`, `contact_partner`, `ray`, `degree`, `gamma`,
    /// `lift`, `elastic`, `budget`, `unknown_fragment`: the first field that does not fit.
    pub fn validate(&self) -> Result<Request, Error> {
        head(self.magic, self.version)?;
        self.reserved()?;
        let purpose = match self.purpose {
            1 => Purpose::Fragments,
            2 => Purpose::Threshold,
            3 => Purpose::Aim,
            other => return Err(Error::new(ErrorKind::UnknownRequest, other.to_string(), "purpose must be 1, 2 or 3")),
        };
        let object = text::get(&self.object, self.object_length).ok_or_else(|| {
            Error::new(ErrorKind::ObjectName, "object", "the object's name is not UTF-8 of at most 64 bytes")
        })?;
        object_name(object)?;
        let enable = Effects::from_bits("effects_on", self.effects_on)?;
        let disable = Effects::from_bits("effects_off", self.effects_off)?;
        Ok(Request {
            object: object.to_owned(),
            purpose,
            convention: self.convention()?,
            contacts: self.contacts(purpose)?,
            degree: self.degree()?,
            gamma_j_m2: self.gamma()?,
            criterion: self.criterion()?,
            lift: self.lift()?,
            elastic: self.elastic()?,
            surface: self.surface()?,
            quality: self.quality()?,
            error_max: self.error_max()?,
            time_ms_max: self.time_ms_max()?,
            iterations_max: self.iterations_max()?,
            enable,
            disable,
            seed: self.seed,
            fragments_max: (self.fragments_max > 0).then_some(self.fragments_max),
            bytes_max: (self.bytes_max > 0).then_some(self.bytes_max),
            deadline: (self.deadline_ns > 0).then(|| Duration::from_nanos(self.deadline_ns)),
            from: self.from()?,
            keep: self.keep()?,
        })
    }

    fn from(&self) -> Result<Option<RetainedFragment>, Error> {
        match (self.handle, self.fragment) {
            (0, 0) => Ok(None),
            (0, fragment) => {
                let message =
                    format!("fragment {fragment} without a handle: pass the handle of the result that it belongs to");
                Err(Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message))
            }
            (handle, fragment) => Ok(Some(RetainedFragment { handle, fragment })),
        }
    }

    fn keep(&self) -> Result<bool, Error> {
        match self.keep {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(Error::new(ErrorKind::ReservedField, "keep", format!("keep must be 0 or 1, not {other}"))),
        }
    }

    fn contacts(&self, purpose: Purpose) -> Result<Vec<Contact>, Error> {
        let count = self.contact_count as usize;
        if count == 0 || count > CONTACTS_MAX {
            return Err(contact_count(count));
        }
        for (i, contact) in self.contacts.iter().enumerate().skip(count) {
            if bytemuck::bytes_of(contact).iter().any(|byte| *byte != 0) {
                let at = format!("contacts[{i}]");
                return Err(Error::new(ErrorKind::ReservedField, at, "contacts beyond contact_count must be zero"));
            }
        }
        let contacts = self.contacts[..count].iter().enumerate().map(|(i, contact)| contact.validate(i, purpose));
        let contacts = contacts.collect::<Result<Vec<_>, _>>()?;
        ray::check(&contacts, purpose)?;
        partner::check(&contacts)?;
        Ok(contacts)
    }

    fn degree(&self) -> Result<DegreeRule, Error> {
        match (self.degree, self.degree_sites) {
            (0, 0) => Ok(DegreeRule::Preset),
            (5, 0) => Ok(DegreeRule::Inferred),
            (1, 0) => Ok(DegreeRule::ClosedForm),
            (4, 0) => Ok(DegreeRule::Verified),
            (2, 0) => Ok(DegreeRule::Optimized),
            (3, 0) => Err(Error::new(
                ErrorKind::Degree,
                "0",
                "degree 0 is out of range; pass a whole number of sites, 1 to 512",
            )),
            (3, sites) => Ok(DegreeRule::Sites(sites)),
            (0..=2 | 4 | 5, sites) => {
                let at = sites.to_string();
                Err(Error::new(ErrorKind::Degree, at, "degree_sites must be zero unless that many sites are asked for"))
            }
            (other, _) => Err(Error::new(ErrorKind::Degree, other.to_string(), "no such source of a degree")),
        }
    }

    fn elastic(&self) -> Result<DisplacementSource, Error> {
        match self.elastic {
            0 => Ok(DisplacementSource::Preset),
            1 => Ok(DisplacementSource::Solve),
            2 => Ok(DisplacementSource::Reduced),
            other => Err(Error::new(ErrorKind::Elastic, other.to_string(), "elastic must be 0 to 2")),
        }
    }

    fn gamma(&self) -> Result<Option<f64>, Error> {
        match self.gamma_j_m2 {
            0.0 => Ok(None),
            value if value.is_finite() && value > 0.0 => Ok(Some(value)),
            value => Err(gamma(value)),
        }
    }

    /// Checks that reserved words are zero.
    fn reserved(&self) -> Result<(), Error> {
        if let Some(i) = self.reserved.iter().position(|word| *word != 0) {
            return Err(Error::new(ErrorKind::ReservedField, format!("reserved[{i}]"), "reserved words must be zero"));
        }
        Ok(())
    }
}

/// Checks magic and version of a request, shared with the control service.
pub(crate) fn head(magic: u32, version: u32) -> Result<(), Error> {
    if magic != REQUEST_MAGIC {
        return Err(Error::new(
            ErrorKind::BadMagic,
            format!("{magic:#010x}"),
            "the bytes are not a request of this protocol",
        ));
    }
    if version != PROTOCOL_VERSION {
        let message = format!("the request speaks protocol {version}, this side {PROTOCOL_VERSION}");
        return Err(Error::new(ErrorKind::VersionMismatch, version.to_string(), message));
    }
    Ok(())
}

/// The error for a handle under which the service keeps no result.
pub fn unknown_handle(handle: u64) -> Error {
    let message = format!(
        "the service keeps no result under the handle {handle}; check the number. If it is right, the result was released, its time is over, or another daemon gave the handle: repeat the impact that made it, with `keep` (--keep)"
    );
    Error::new(ErrorKind::UnknownHandle, handle.to_string(), message)
}

fn contact_count(count: usize) -> Error {
    let message = format!("{count} contacts: 1 to {CONTACTS_MAX} are possible");
    Error::new(ErrorKind::ContactCount, count.to_string(), message)
}

fn gamma(value: f64) -> Error {
    Error::new(ErrorKind::Gamma, "gamma_j_m2", format!("γ = {}: must be finite and above zero", number(value)))
}

#[cfg(test)]
mod tests;
