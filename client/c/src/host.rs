//! Coordinates of a host, and contacts of its simulation.

use crate::error::ErrorRecord;
use crate::ffi_boundary::{Failure, ffi_boundary, given, text, wrong};
use crate::{Code, Service};
use shatter_export::contact::{self, ContactError, ElasticMaterial};
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// Coordinates of a host. Zeros are the convention of glTF: +Y up, right-handed, counter-clockwise, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Convention {
    /// Up axis. 0: +Y. 1: +Z.
    pub up: u32,
    /// Handedness. 0: right-handed. 1: left-handed.
    pub hand: u32,
    /// Winding of triangles, seen from outside. 0: counter-clockwise. 1: clockwise.
    pub winding: u32,
    /// Always zero.
    pub reserved: u32,
    /// Length of the host's unit, m, 1e-6 to 1e6; 0: a meter.
    pub meters_per_unit: f64,
}

impl Convention {
    fn read(&self) -> Result<shatter_client::Convention, Failure> {
        if self.reserved != 0 {
            return Err(wrong("convention.reserved", "reserved fields must be zero; initialize the struct with {0}"));
        }
        Ok(shatter_client::Convention::of_numbers(self.up, self.hand, self.winding, self.meters_per_unit)?)
    }
}

/// Finds a convention by name: `gltf`, `godot`, `unity`, `unreal`, `blender` or `mujoco`.
///
/// Codes: `convention` for an unknown name.
///
/// # Safety
/// `name` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_convention_named(
    name: *const c_char,
    length: usize,
    convention: Option<&mut MaybeUninit<Convention>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("convention", convention)?;
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let name = unsafe { text("name", name, length) }?;
        let found = shatter_client::Convention::by_name(name)?;
        let (up, hand, winding) = (found.up as u32, found.hand as u32, found.winding as u32);
        place.write(Convention { up, hand, winding, reserved: 0, meters_per_unit: found.meters_per_unit });
        Ok(())
    })
}

/// Makes a connection for a host with these coordinates. The service reads impacts on objects taken from `hosted`, and writes their
/// results, in its axes, unit and winding; `_m`, `_ns`, `_m2` and `_m3` of contacts, fragments and their parts then stand for that unit.
/// Facts of objects (`ShatterFacts`) stay in meters with +Y up, and files stay in the convention of glTF. `hosted` is
/// NULL after a failure. Free both connections.
///
/// Codes: `convention` if the convention is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_with_convention(
    service: Option<&Service>,
    convention: Option<&Convention>,
    hosted: Option<&mut MaybeUninit<Option<Box<Service>>>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let hosted = given("hosted", hosted)?;
        hosted.write(None);
        let (service, convention) = (given("service", service)?, given("convention", convention)?.read()?);
        hosted.write(Some(Box::new(Service(service.0.with_convention(convention)))));
        Ok(())
    })
}

/// One of two bodies in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Partner {
    /// Young's modulus, Pa; for an object, see its `ShatterFacts`.
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Mass, kg; 0: it does not move.
    pub mass_kg: f64,
    /// Radius of its surface at the contact, m; 0: a plane. Negative: concave.
    pub radius_m: f64,
}

impl Partner {
    fn read(&self) -> contact::ContactBody {
        let or_infinite = |value: f64| if value == 0.0 { f64::INFINITY } else { value };
        contact::ContactBody {
            material: ElasticMaterial { young_pa: self.young_pa, poisson: self.poisson },
            mass_kg: or_infinite(self.mass_kg),
            radius_m: or_infinite(self.radius_m),
        }
    }
}

/// Contact of two bodies in a point, by Hertz theory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hertz {
    /// Largest approach, m.
    pub approach_m: f64,
    /// Radius of the contact area at the largest approach, m: the value for `ShatterContact.radius_m`, which is in the host's unit.
    pub radius_m: f64,
    /// Force at the largest approach, N.
    pub force_n: f64,
    /// Duration from the first touch to the last, s: the value for `ShatterContact.duration_s`.
    pub duration_s: f64,
}

/// Computes duration and radius of a contact by Hertz theory. `speed_m_s` is the approach speed along the normal before the step, which
/// `impulse_ns` stopped; an impulse of 0: that of a central collision of both masses. In SI units, whatever the convention.
///
/// Codes: `argument`, which names the number that cannot be used.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_hertz(
    one: Option<&Partner>,
    other: Option<&Partner>,
    speed_m_s: f64,
    impulse_ns: f64,
    hertz: Option<&mut MaybeUninit<Hertz>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("hertz", hertz)?;
        let (one, other) = (given("one", one)?.read(), given("other", other)?.read());
        let found = match impulse_ns {
            0.0 => contact::HertzContact::of(&one, &other, speed_m_s),
            _ => contact::HertzContact::of_impulse(&one, &other, speed_m_s, impulse_ns),
        };
        let contact::HertzContact { approach_m, radius_m, force_n, duration_s } =
            found.map_err(|error| unfit(&error))?;
        place.write(Hertz { approach_m, radius_m, force_n, duration_s });
        Ok(())
    })
}

fn unfit(error: &ContactError) -> Failure {
    let at = match error {
        ContactError::NotPositive { key, .. } => key,
        ContactError::Poisson(_) => "poisson",
        ContactError::NoMass => "mass_kg",
        ContactError::NoPoint(..) => "radius_m",
        _ => "contact",
    };
    wrong(at, error.to_string())
}
