//! Objects of the service.

use crate::error::ErrorRecord;
use crate::ffi_boundary::{elements, end, ffi_boundary, given, wrong};
use crate::{Code, Facts, Hit, Impact, Ticket};
use shatter_client::{Deadline, Ray};
use std::mem::MaybeUninit;

/// An object that can be struck. Any number of threads may use it at a time.
pub struct Object(pub(crate) shatter_client::Object);

/// Facts of the object, as the service reported them when the object was requested.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_object_facts(
    object: Option<&Object>,
    facts: Option<&mut MaybeUninit<Facts>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (object, place) = (given("object", object)?, given("facts", facts)?);
        place.write(object.0.facts().into());
        Ok(())
    })
}

/// Sends a request and returns at once; the ticket fetches the result. `ticket` is NULL after a failure. Free it with
/// `shatter_ticket_free`. The first request after the daemon was lost connects to its successor, which takes some milliseconds.
///
/// Codes: every error that the daemon would find in the impact's own fields; `busy` if the connection has too many requests under way;
/// `lost` if the request reached no daemon, `no_daemon` while no daemon runs.
///
/// # Safety
/// `impact->contacts` points to `impact->contact_count` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_object_strike(
    object: Option<&Object>,
    impact: Option<&Impact>,
    ticket: Option<&mut MaybeUninit<Option<Box<Ticket>>>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let ticket = given("ticket", ticket)?;
        ticket.write(None);
        let (object, impact) = (given("object", object)?, given("impact", impact)?);
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let impact = unsafe { impact.read() }?;
        ticket.write(Some(Box::new(Ticket(object.0.strike(&impact)?))));
        Ok(())
    })
}

/// Finds the first hit of the ray from `origin_m` along `direction` on the object; waits for the service. With a `handle`, the target is
/// fragment `fragment` of the result that the service keeps under it; 0: the object.
///
/// Codes: `ray` for a direction that is zero or not finite, `ray_missed` with the closest approach, and those of
/// `shatter_object_strike`.
///
/// # Safety
/// `origin_m` and `direction` point to three numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_object_aim(
    object: Option<&Object>,
    origin_m: *const f64,
    direction: *const f64,
    handle: u64,
    fragment: u32,
    timeout_ms: u64,
    hit: Option<&mut MaybeUninit<Hit>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (object, place) = (given("object", object)?, given("hit", hit)?);
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let (origin_m, direction) =
            unsafe { (elements("origin_m", origin_m, 3)?, elements("direction", direction, 3)?) };
        let three = |numbers: &[f64]| [numbers[0], numbers[1], numbers[2]];
        let ray = Ray { origin_m: three(origin_m), direction: three(direction) };
        let deadline = Deadline::ms(timeout_ms);
        let found = match handle {
            0 => object.0.aim(ray, deadline)?,
            handle => object.0.aim_at_fragment(handle, fragment, ray, deadline)?,
        };
        place.write(Some(found).into());
        Ok(())
    })
}

/// Sends a request that divides the object into `pieces` fragments of equal size, without an impact: for hosts that want fragments ahead of
/// time. `impact` sets seed, effects, quality, lift and caps, and has no contacts, degree or handle; NULL: all defaults. Waits, at most
/// `timeout_ms`, only if the object has several bodies: the service is then asked where they are. `ticket` is NULL after a failure.
///
/// Codes: those of `shatter_object_strike`; `argument` for contacts, a degree or a handle.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_object_even(
    object: Option<&Object>,
    pieces: u32,
    impact: Option<&Impact>,
    timeout_ms: u64,
    ticket: Option<&mut MaybeUninit<Option<Box<Ticket>>>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let ticket = given("ticket", ticket)?;
        ticket.write(None);
        let object = given("object", object)?;
        for (at, said) in impact.map_or([("", false); 3], Impact::impact_only_fields) {
            if said {
                return Err(wrong(at, format!("{at} is set; leave it zero for an even division")));
            }
        }
        let even = object.0.even(pieces, Deadline::ms(timeout_ms))?;
        let even = impact.map_or(Ok(even.clone()), |impact| impact.refine(even))?;
        ticket.write(Some(Box::new(Ticket(object.0.strike(&even)?))));
        Ok(())
    })
}

/// Frees an object; NULL is allowed. Its tickets and results stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_object_free(object: Option<Box<Object>>) {
    end(object);
}
