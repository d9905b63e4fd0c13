//! The boundary between C and the client: checks of arguments, conversion of errors, containment of panics.

use crate::error::ErrorRecord;
use crate::{Code, Fault};
use std::any::Any;
use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Longest text that a caller may pass, bytes: paths are the longest.
const TEXT_MAX: usize = 1 << 16;

/// Error of a call.
#[derive(Debug)]
pub(crate) enum Failure {
    /// An error of the client or the service.
    Refused(shatter_client::Error),
    /// An unusable argument.
    Argument {
        /// Name of the argument.
        at: &'static str,
        /// Reason.
        message: String,
    },
}

impl From<shatter_client::Error> for Failure {
    fn from(error: shatter_client::Error) -> Self {
        Self::Refused(error)
    }
}

/// Error for an unusable argument.
pub(crate) fn wrong(at: &'static str, message: impl Into<String>) -> Failure {
    Failure::Argument { at, message: message.into() }
}

/// Runs `work` and returns its code. Errors and panics become codes; `error`, if not NULL, gets the details.
pub(crate) fn ffi_boundary(
    error: Option<&mut MaybeUninit<ErrorRecord>>,
    work: impl FnOnce() -> Result<(), Failure>,
) -> Code {
    let said = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => ErrorRecord::none(),
        Ok(Err(Failure::Refused(refused))) => ErrorRecord::from(&refused),
        Ok(Err(Failure::Argument { at, message })) => {
            ErrorRecord::of(Code::Argument, Fault::Caller, "argument", at, &message)
        }
        Err(panic) => ErrorRecord::of(Code::Panicked, Fault::Service, "panicked", "", words(&*panic)),
    };
    if let Some(place) = error {
        place.write(said);
    }
    said.code
}

/// Drops a handle that C frees, and contains a panic of its destructor.
pub(crate) fn end<T>(handle: Option<Box<T>>) {
    // The panic hook of the process has printed the message already, and this function returns no code.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(handle)));
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let owned = || panic.downcast_ref::<String>().map(String::as_str);
    panic.downcast_ref::<&str>().copied().or_else(owned).unwrap_or("the library panicked")
}

/// The argument, or an error if it is null.
pub(crate) fn given<T>(at: &'static str, argument: Option<T>) -> Result<T, Failure> {
    argument.ok_or_else(|| wrong(at, format!("`{at}` is NULL; pass a valid pointer")))
}

/// `length` bytes from `data` on, or the bytes before the terminating zero if `length` is `SIZE_MAX`.
///
/// # Safety
/// Unless it is null, `data` points to that many bytes, which do not change during `'a`.
pub(crate) unsafe fn bytes<'a>(at: &'static str, data: *const c_char, length: usize) -> Result<&'a [u8], Failure> {
    if data.is_null() {
        return Err(wrong(at, format!("`{at}` is NULL; pass a valid pointer")));
    }
    if length == usize::MAX {
        // SAFETY: not null; the caller of the interface guarantees the terminating zero.
        return Ok(unsafe { CStr::from_ptr(data) }.to_bytes());
    }
    if length > TEXT_MAX {
        return Err(wrong(at, format!("`{at}` has {length} bytes; at most {TEXT_MAX} are allowed")));
    }
    // SAFETY: not null; the caller of the interface guarantees the length; bytes need no alignment.
    Ok(unsafe { std::slice::from_raw_parts(data.cast::<u8>(), length) })
}

/// The same as UTF-8 text.
///
/// # Safety
/// As of [`bytes`].
pub(crate) unsafe fn text<'a>(at: &'static str, data: *const c_char, length: usize) -> Result<&'a str, Failure> {
    // SAFETY: the caller keeps the contract of `bytes`.
    let bytes = unsafe { bytes(at, data, length) }?;
    std::str::from_utf8(bytes).map_err(|error| wrong(at, format!("`{at}` is not UTF-8: {error}")))
}

/// `count` elements from `data` on; `data` may be null if `count` is zero.
///
/// # Safety
/// Unless it is null or misaligned, `data` points to that many elements, which do not change during `'a`.
pub(crate) unsafe fn elements<'a, T>(at: &'static str, data: *const T, count: usize) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    usable(at, data, count)?;
    // SAFETY: neither null nor misaligned nor too long; the caller of the interface guarantees the rest.
    Ok(unsafe { std::slice::from_raw_parts(data, count) })
}

/// Uninitialized memory for `count` elements from `data` on.
///
/// # Safety
/// Unless it is null or misaligned, `data` points to memory for that many elements, which is accessed only through the result during `'a`.
pub(crate) unsafe fn uninit_elements<'a, T>(
    at: &'static str,
    data: *mut T,
    count: usize,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    usable(at, data, count)?;
    // SAFETY: neither null nor misaligned nor too long; the caller of the interface guarantees the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(data.cast::<MaybeUninit<T>>(), count) })
}

fn usable<T>(at: &'static str, data: *const T, count: usize) -> Result<(), Failure> {
    if data.is_null() {
        return Err(wrong(at, format!("`{at}` is NULL for {count} elements; pass a valid pointer")));
    }
    if !data.is_aligned() {
        return Err(wrong(at, format!("`{at}` is not aligned to {} bytes", align_of::<T>())));
    }
    match count.checked_mul(size_of::<T>()).is_some_and(|bytes| bytes <= isize::MAX as usize) {
        true => Ok(()),
        false => Err(wrong(at, format!("`{at}` has {count} elements, more than the address space can hold"))),
    }
}

#[cfg(test)]
mod tests;
