//! Errors, written to memory of the caller.

use crate::{Code, Fault};
use std::ffi::c_char;

/// Error of a call. Every function that takes one writes it: `SHATTER_CODE_OK` and empty texts on success. Pass NULL if you do not need it.
/// Texts are UTF-8 and end with a zero; longer ones are truncated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct ErrorRecord {
    /// Code that the function returned.
    pub code: Code,
    /// Party at fault.
    pub fault: Fault,
    /// True if the same call may succeed a little later.
    pub retry: bool,
    /// Always zero.
    pub reserved: u32,
    /// Time after which the same call is likely to succeed, ms; 0: not known.
    pub retry_after_ms: f64,
    /// Name of the code, as in JSON and logs.
    pub name: [c_char; 32],
    /// Argument, index, key or path that caused the error; may be empty.
    pub at: [c_char; 128],
    /// One sentence for people.
    pub message: [c_char; 512],
}

impl ErrorRecord {
    /// No error.
    pub(crate) fn none() -> Self {
        Self::of(Code::Ok, Fault::None, "ok", "", "")
    }

    pub(crate) fn of(code: Code, fault: Fault, name: &str, at: &str, message: &str) -> Self {
        let (retry, reserved, retry_after_ms) = (false, 0, 0.0);
        Self { code, fault, retry, reserved, retry_after_ms, name: text(name), at: text(at), message: text(message) }
    }
}

impl From<&shatter_client::Error> for ErrorRecord {
    fn from(error: &shatter_client::Error) -> Self {
        let kind = error.kind;
        Self {
            retry: kind.retry(),
            retry_after_ms: error.retry_after.map_or(0.0, |wait| 1e3 * wait.as_secs_f64()),
            ..Self::of(kind.into(), kind.fault().into(), kind.name(), &error.at, &error.message)
        }
    }
}

/// `text` with a terminating zero, truncated between characters if it is longer.
pub(crate) fn text<const N: usize>(text: &str) -> [c_char; N] {
    let most = text.len().min(N.saturating_sub(1));
    let end = (0..=most).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
    let mut place = [0; N];
    for (slot, byte) in place.iter_mut().zip(&text.as_bytes()[..end]) {
        *slot = *byte as c_char;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_client::ErrorKind;
    use std::time::Duration;

    fn shown(text: &[c_char]) -> String {
        let bytes: Vec<u8> = text.iter().map(|byte| *byte as u8).take_while(|byte| *byte != 0).collect();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn long_texts_are_cut_at_a_character_boundary_with_a_trailing_zero() {
        assert_eq!(shown(&text::<8>("vase")), "vase");
        assert_eq!(shown(&text::<8>("1234567")), "1234567");
        assert_eq!(shown(&text::<8>("12345678")), "1234567");
        assert_eq!(shown(&text::<8>("123456é")), "123456");
        assert_eq!(shown(&text::<1>("é")), "");
    }

    #[test]
    fn errors_keep_their_message_and_fields() {
        let busy = shatter_client::Error::new(ErrorKind::Busy, "queue", "full").after(Duration::from_micros(1500));
        let busy = ErrorRecord::from(&busy);
        assert_eq!((busy.code, busy.fault, busy.retry, busy.retry_after_ms), (Code::Busy, Fault::Service, true, 1.5));
        assert_eq!([shown(&busy.name), shown(&busy.at), shown(&busy.message)], ["busy", "queue", "full"]);
        let absent = ErrorRecord::from(&shatter_client::Error::new(ErrorKind::Gamma, "", ""));
        assert_eq!((absent.retry, absent.retry_after_ms, absent.fault), (false, 0.0, Fault::Caller));
    }
}
