//! The border between C and the client: arguments, results, and what must not pass.

use crate::refusal::Refusal;
use crate::{Code, Fault};
use std::any::Any;
use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Longest text that a caller may hand over, bytes: paths are the longest.
const TEXT_MAX: usize = 1 << 16;

/// Why a call came to nothing.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The client or the service refused.
    Refused(shatter_client::Error),
    /// An argument cannot be used.
    Argument {
        /// Which.
        at: &'static str,
        /// What of it.
        message: String,
    },
}

impl From<shatter_client::Error> for Failure {
    fn from(refusal: shatter_client::Error) -> Self {
        Self::Refused(refusal)
    }
}

/// An argument that cannot be used.
pub(crate) fn wrong(at: &'static str, message: impl Into<String>) -> Failure {
    Failure::Argument { at, message: message.into() }
}

/// Does the work of a function: what it fails by, panics included, becomes a code, and `refusal` says the same in words.
pub(crate) fn border(refusal: Option<&mut MaybeUninit<Refusal>>, work: impl FnOnce() -> Result<(), Failure>) -> Code {
    let said = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => Refusal::none(),
        Ok(Err(Failure::Refused(refused))) => Refusal::from(&refused),
        Ok(Err(Failure::Argument { at, message })) => {
            Refusal::of(Code::Argument, Fault::Caller, "argument", at, &message)
        }
        Err(panic) => Refusal::of(Code::Panicked, Fault::Service, "panicked", "", words(&*panic)),
    };
    if let Some(place) = refusal {
        place.write(said);
    }
    said.code
}

/// Drops what C gives back; what panics then is left as it is.
pub(crate) fn end<T>(handle: Option<Box<T>>) {
    // The hook of the process has said already what went wrong, and nobody waits for an answer.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(handle)));
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let owned = || panic.downcast_ref::<String>().map(String::as_str);
    panic.downcast_ref::<&str>().copied().or_else(owned).unwrap_or("the library panicked")
}

/// An argument that must be there.
pub(crate) fn given<T>(at: &'static str, argument: Option<T>) -> Result<T, Failure> {
    argument.ok_or_else(|| wrong(at, format!("`{at}` is null")))
}

/// `length` bytes from `data` on, or those before a zero if `length` is `SIZE_MAX`.
///
/// # Safety
/// Unless it is null, `data` points to that many bytes, which nobody changes during `'a`.
pub(crate) unsafe fn bytes<'a>(at: &'static str, data: *const c_char, length: usize) -> Result<&'a [u8], Failure> {
    if data.is_null() {
        return Err(wrong(at, format!("`{at}` is null")));
    }
    if length == usize::MAX {
        // SAFETY: not null, and the caller of the interface vouches for the zero behind the text.
        return Ok(unsafe { CStr::from_ptr(data) }.to_bytes());
    }
    if length > TEXT_MAX {
        return Err(wrong(at, format!("`{at}` of {length} bytes: at most {TEXT_MAX}")));
    }
    // SAFETY: not null, of a length that the caller of the interface vouches for; bytes are aligned anywhere.
    Ok(unsafe { std::slice::from_raw_parts(data.cast::<u8>(), length) })
}

/// The same as UTF-8.
///
/// # Safety
/// As of [`bytes`].
pub(crate) unsafe fn text<'a>(at: &'static str, data: *const c_char, length: usize) -> Result<&'a str, Failure> {
    // SAFETY: handed on.
    let bytes = unsafe { bytes(at, data, length) }?;
    std::str::from_utf8(bytes).map_err(|error| wrong(at, format!("`{at}` is not UTF-8: {error}")))
}

/// `count` elements from `data` on; none of them need be there if `count` is zero.
///
/// # Safety
/// Unless it is null or not aligned, `data` points to that many, which nobody changes during `'a`.
pub(crate) unsafe fn elements<'a, T>(at: &'static str, data: *const T, count: usize) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    usable(at, data, count)?;
    // SAFETY: neither null nor misaligned nor too long; for the rest the caller of the interface vouches.
    Ok(unsafe { std::slice::from_raw_parts(data, count) })
}

/// Room for `count` elements from `data` on.
///
/// # Safety
/// Unless it is null or not aligned, `data` points to that much room, which is nobody else's during `'a`.
pub(crate) unsafe fn room<'a, T>(
    at: &'static str,
    data: *mut T,
    count: usize,
) -> Result<&'a mut [MaybeUninit<T>], Failure> {
    if count == 0 {
        return Ok(&mut []);
    }
    usable(at, data, count)?;
    // SAFETY: neither null nor misaligned nor too long; for the rest the caller of the interface vouches.
    Ok(unsafe { std::slice::from_raw_parts_mut(data.cast::<MaybeUninit<T>>(), count) })
}

fn usable<T>(at: &'static str, data: *const T, count: usize) -> Result<(), Failure> {
    if data.is_null() {
        return Err(wrong(at, format!("`{at}` is null, for {count} elements")));
    }
    if !data.is_aligned() {
        return Err(wrong(at, format!("`{at}` is not aligned to {} bytes", align_of::<T>())));
    }
    match count.checked_mul(size_of::<T>()).is_some_and(|bytes| bytes <= isize::MAX as usize) {
        true => Ok(()),
        false => Err(wrong(at, format!("`{at}` of {count} elements: more than memory holds"))),
    }
}

#[cfg(test)]
mod tests;
