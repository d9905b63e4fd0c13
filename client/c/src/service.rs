//! Connections to a service.

use crate::error::ErrorRecord;
use crate::ffi_boundary::{Failure, end, ffi_boundary, given, text, uninit_elements};
use crate::{Code, Facts, Object, Status};
use shatter_client::{Client, Deadline};
use std::borrow::Cow;
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// Version of this interface. The meaning of a struct or function changes only with this number.
pub const VERSION: u32 = 3;

/// A connection to a service. It outlives the daemon: calls and requests under way when a daemon goes away end with `SHATTER_CODE_LOST`;
/// later ones go to the daemon that then serves. Any number of threads may use it at a time.
pub struct Service(pub(crate) Client);

/// Version of the interface of this library. Compare it with `SHATTER_VERSION` of the header that you compiled with.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_version() -> u32 {
    VERSION
}

/// Connects to a service by name. If `name` is NULL, connects to the service that the environment variable `SHATTER_SERVICE` names, or to
/// `default`. Fails at once without a daemon; waits for a daemon that is starting. `service` is NULL after a failure. Free it with
/// `shatter_service_free`.
///
/// Codes: `no_daemon`, `version_mismatch`, `busy` (the service has as many clients as it may), `runtime_folder`, `service_name`,
/// `transport`.
///
/// # Safety
/// `name` is NULL, or points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_connect(
    name: *const c_char,
    length: usize,
    timeout_ms: u64,
    service: Option<&mut MaybeUninit<Option<Box<Service>>>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        // SAFETY: the caller keeps the contract of this function, which is the same.
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
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let name = unsafe { service_name(name, length) };
        opened(service, name, |name| Client::wait_for(name, Deadline::ms(timeout_ms)))
    })
}

/// The name as text; the default service if it is null.
///
/// # Safety
/// As of `shatter_connect`.
unsafe fn service_name<'a>(name: *const c_char, length: usize) -> Result<Cow<'a, str>, Failure> {
    if name.is_null() {
        return Ok(Cow::Owned(shatter_client::default_service()?));
    }
    // SAFETY: the caller keeps the contract of this function, which is the same.
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

/// Frees a connection; NULL is allowed. Objects, tickets and results that came from it stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_free(service: Option<Box<Service>>) {
    end(service);
}

/// State of the service.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_status(
    service: Option<&Service>,
    timeout_ms: u64,
    status: Option<&mut MaybeUninit<Status>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (service, place) = (given("service", service)?, given("status", status)?);
        place.write(Status::from(&service.0.status(Deadline::ms(timeout_ms))?));
        Ok(())
    })
}

/// All objects by name, ready or not. Writes the first `capacity` of them to `facts`, and the number of all to `count`. To learn the number
/// first, pass a capacity of 0 and NULL for `facts`.
///
/// # Safety
/// `facts` points to memory for `capacity` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_service_objects(
    service: Option<&Service>,
    timeout_ms: u64,
    facts: *mut Facts,
    capacity: usize,
    count: Option<&mut MaybeUninit<usize>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (service, count) = (given("service", service)?, given("count", count)?);
        count.write(0);
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let places = unsafe { uninit_elements("facts", facts, capacity) }?;
        let objects = service.0.objects(Deadline::ms(timeout_ms))?;
        for (place, object) in places.iter_mut().zip(&objects) {
            place.write(object.into());
        }
        count.write(objects.len());
        Ok(())
    })
}

/// Finds an object by name, ready to be struck. `object` is NULL after a failure. Free it with `shatter_object_free`.
///
/// Codes: `unknown_object`, `corrupt_object`, `loading`; `busy`, at once, if the connection has too many requests under way; and those of a
/// lost connection.
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
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let object = given("object", object)?;
        object.write(None);
        let service = given("service", service)?;
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let name = unsafe { text("name", name, length) }?;
        object.write(Some(Box::new(Object(service.0.object(name, Deadline::ms(timeout_ms))?))));
        Ok(())
    })
}

/// Sleeps until the service notifies this connection, a few milliseconds have passed, or the timeout. Use it between two polls of tickets,
/// in a thread that has nothing else to do.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_wait(
    service: Option<&Service>,
    timeout_ms: u64,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        given("service", service)?.0.wait_for_reply(Deadline::ms(timeout_ms));
        Ok(())
    })
}

/// Releases the result that the service keeps under `handle` (`ShatterSummary.handle`): its fragments cannot be struck any more.
///
/// Codes: `unknown_handle` if the service keeps no result under it; `busy`, at once, if the connection has too many requests under way; and
/// those of a lost connection.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_service_release(
    service: Option<&Service>,
    handle: u64,
    timeout_ms: u64,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || Ok(given("service", service)?.0.release(handle, Deadline::ms(timeout_ms))?))
}
