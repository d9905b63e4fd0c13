//! A connection to a service.

use crate::border::{Failure, border, end, given, room, text};
use crate::refusal::Refusal;
use crate::{Code, Facts, Object, Status};
use shatter_client::{Client, Deadline};
use std::borrow::Cow;
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// Version of this interface; what a struct or function means changes only with it.
pub const VERSION: u32 = 3;

/// A connection to a service. It outlives the daemon: what was under way when a daemon went away ends with `SHATTER_CODE_LOST`, what
/// comes next goes to the daemon that then serves. Any number of threads may use it at a time.
pub struct Service(pub(crate) Client);

/// Version of the interface of this library; compare it with `SHATTER_VERSION` of the header that you compiled with.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_version() -> u32 {
    VERSION
}

/// Connects to the service of that name; where `name` is NULL to that which the environment variable `SHATTER_SERVICE` names, or to
/// `default`. Without a daemon the refusal comes at
/// once, one that is starting is waited for. `service` is NULL afterwards where it failed. Free it with `shatter_service_free`.
///
/// Codes: `no_daemon`, `version_mismatch`, `busy` (no place for another client), `runtime_folder`, `service_name`, `transport`.
///
/// # Safety
/// `name` is NULL, or points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_connect(
    name: *const c_char,
    length: usize,
    timeout_ms: u64,
    service: Option<&mut MaybeUninit<Option<Box<Service>>>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        // SAFETY: handed on.
        let name = unsafe { service_name(name, length) };
        opened(service, name, |name| Client::connect(name, Deadline::ms(timeout_ms)))
    })
}

/// Connects as `shatter_connect` does, but waits for a daemon to appear.
///
/// # Safety
/// As of `shatter_connect`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_wait_for(
    name: *const c_char,
    length: usize,
    timeout_ms: u64,
    service: Option<&mut MaybeUninit<Option<Box<Service>>>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        // SAFETY: handed on.
        let name = unsafe { service_name(name, length) };
        opened(service, name, |name| Client::wait_for(name, Deadline::ms(timeout_ms)))
    })
}

/// The name, or that of the environment where it is null.
///
/// # Safety
/// As of `shatter_connect`.
unsafe fn service_name<'a>(name: *const c_char, length: usize) -> Result<Cow<'a, str>, Failure> {
    if name.is_null() {
        return Ok(Cow::Owned(shatter_client::default_service()?));
    }
    // SAFETY: handed on.
    unsafe { text("name", name, length) }.map(Cow::Borrowed)
}

fn opened(
    service: Option<&mut MaybeUninit<Option<Box<Service>>>>,
    name: Result<Cow<'_, str>, Failure>,
    open: impl FnOnce(&str) -> Result<Client, shatter_client::Error>,
) -> Result<(), Failure> {
    let service = given("service", service)?;
    service.write(None);
    service.write(Some(Box::new(Service(open(&name?)?))));
    Ok(())
}

/// Frees a connection; NULL is fine. Objects, tickets and answers that came from it live on by themselves.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_free(service: Option<Box<Service>>) {
    end(service);
}

/// How the service goes.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_status(
    service: Option<&Service>,
    timeout_ms: u64,
    status: Option<&mut MaybeUninit<Status>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let (service, place) = (given("service", service)?, given("status", status)?);
        place.write(Status::from(&service.0.status(Deadline::ms(timeout_ms))?));
        Ok(())
    })
}

/// All objects, ready or not, by name: the first `capacity` of them go to `facts`, how many there are to `count`. Ask with a capacity
/// of 0 and no `facts` first to learn how many.
///
/// # Safety
/// `facts` points to room for `capacity` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_service_objects(
    service: Option<&Service>,
    timeout_ms: u64,
    facts: *mut Facts,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let (service, count) = (given("service", service)?, given("count", count)?);
        count.write(0);
        // SAFETY: handed on.
        let places = unsafe { room("facts", facts, capacity) }?;
        let objects = service.0.objects(Deadline::ms(timeout_ms))?;
        for (place, object) in places.iter_mut().zip(&objects) {
            place.write(object.into());
        }
        count.write(objects.len());
        Ok(())
    })
}

/// The object of that name, ready to be struck. `object` is NULL afterwards where it failed. Free it with `shatter_object_free`.
///
/// Codes: `unknown_object`, `corrupt_object`, and those of a lost connection.
///
/// # Safety
/// `name` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_service_object(
    service: Option<&Service>,
    name: *const c_char,
    length: usize,
    timeout_ms: u64,
    object: Option<&mut MaybeUninit<Option<Box<Object>>>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let object = given("object", object)?;
        object.write(None);
        let service = given("service", service)?;
        // SAFETY: handed on.
        let name = unsafe { text("name", name, length) }?;
        object.write(Some(Box::new(Object(service.0.object(name, Deadline::ms(timeout_ms))?))));
        Ok(())
    })
}

/// Sleeps until the service has something for this connection, a few milliseconds have passed, or the timeout: between two looks at
/// tickets, for a thread that has nothing else to do.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_doze(
    service: Option<&Service>,
    timeout_ms: u64,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        given("service", service)?.0.wait_for_reply(Deadline::ms(timeout_ms));
        Ok(())
    })
}

/// Gives back the answer that the service keeps under `handle` (`ShatterSummary.handle`): its fragments cannot be struck any more.
///
/// Codes: `unknown_handle` if none is kept under it.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_release(
    service: Option<&Service>,
    handle: u64,
    timeout_ms: u64,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || Ok(given("service", service)?.0.release(handle, Deadline::ms(timeout_ms))?))
}
