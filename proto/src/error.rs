//! Errors: a kind, whose fault it is, whether to try again, and the offender.

use crate::text;
use bytemuck::{Pod, Zeroable};
use std::fmt;
use std::time::Duration;

/// Party at fault for an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultParty {
    /// The request is wrong; sending it again changes nothing.
    Caller,
    /// The service could not do what it should, or not now.
    Service,
    /// Something around both: no daemon, no memory, no rights.
    Environment,
}

impl FaultParty {
    /// The word used in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Caller => "caller",
            Self::Service => "service",
            Self::Environment => "environment",
        }
    }
}

/// Exit codes of both programs.
pub mod exit {
    /// Invalid input: mesh, database, request.
    pub const REFUSED: u8 = 3;
    /// No daemon, or lost.
    pub const ABSENT: u8 = 4;
    /// Busy or late.
    pub const BUSY: u8 = 5;
    /// A fault of the service.
    pub const OURS: u8 = 6;
    /// The reader of standard output went away: as a program that SIGPIPE ends.
    pub const CLOSED: u8 = 141;
    /// Ended by an interrupt; what was done may be kept.
    pub const INTERRUPTED: u8 = 130;
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $code:literal $kind:ident $name:literal $fault:ident $exit:ident $retry:literal;)*) => {
        /// One noun per rule.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        #[non_exhaustive]
        pub enum ErrorKind {
            $($(#[$doc])* $kind = $code,)*
        }

        impl ErrorKind {
            /// Every kind, in the order of its codes.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// The number on the wire.
            pub fn code(self) -> u32 {
                self as u32
            }

            /// The kind with this number, if there is one.
            pub fn from_code(code: u32) -> Option<Self> {
                match code {
                    $($code => Some(Self::$kind),)*
                    _ => None,
                }
            }

            /// The noun used in JSON and logs.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }

            /// Party at fault.
            pub fn fault(self) -> FaultParty {
                match self {
                    $(Self::$kind => FaultParty::$fault,)*
                }
            }

            /// Whether the same request may succeed a little later.
            pub fn retry(self) -> bool {
                match self {
                    $(Self::$kind => $retry,)*
                }
            }

            /// Exit code of a command that ends with it.
            pub fn exit_code(self) -> u8 {
                match self {
                    $(Self::$kind => exit::$exit,)*
                }
            }
        }
    };
}

kinds! {
    /// The bytes are not a request of this protocol.
    1 BadMagic "bad_magic" Caller REFUSED false;
    /// The other side speaks another version.
    2 VersionMismatch "version_mismatch" Environment ABSENT false;
    /// The kind of request does not exist.
    3 UnknownRequest "unknown_request" Caller REFUSED false;
    /// A reserved field or byte is not zero.
    4 ReservedField "reserved_field" Caller REFUSED false;
    /// The object's name is empty, too long or not UTF-8.
    5 ObjectName "object_name" Caller REFUSED false;
    /// The service has no object of this name.
    6 UnknownObject "unknown_object" Caller REFUSED false;
    /// The object's database could not be loaded, or does not fit its scene.
    7 CorruptObject "corrupt_object" Environment REFUSED false;
    /// The request has no contact, or more than eight.
    8 ContactCount "contact_count" Caller REFUSED false;
    /// A contact point is not finite.
    9 ContactPoint "contact_point" Caller REFUSED false;
    /// A contact point is farther from the body than its radius and a lattice spacing.
    10 ContactTooFar "contact_too_far" Caller REFUSED false;
    /// An impulse is zero or not finite, or the contacts cancel or press on anchors only.
    11 Impulse "impulse" Caller REFUSED false;
    /// A contact duration is negative or not finite.
    12 ContactDuration "contact_duration" Caller REFUSED false;
    /// A contact radius is not positive, not finite, or larger than the object.
    13 ContactRadius "contact_radius" Caller REFUSED false;
    /// γ is not above zero, or not finite.
    14 Gamma "gamma" Caller REFUSED false;
    /// The degree is zero, above the object's limit, or from an unknown rule.
    15 Degree "degree" Caller REFUSED false;
    /// The lift is unknown, or the object was not baked for it.
    16 Lift "lift" Caller REFUSED false;
    /// The effect does not exist in this version.
    17 UnknownEffect "unknown_effect" Caller REFUSED false;
    /// The preset is unknown, or a limit of time, error or iterations is out of range.
    18 Budget "budget" Caller REFUSED false;
    /// An invalid coordinate convention: an unknown number or name, or a unit of length out of range.
    19 Convention "convention" Caller REFUSED false;
    /// The service retains no result under this handle: it expired, was released or evicted, or never existed.
    20 UnknownHandle "unknown_handle" Caller REFUSED false;
    /// The result would exceed the limit of fragments or bytes.
    21 CapExceeded "cap_exceeded" Caller REFUSED false;
    /// The name of the service is not 1 to 32 letters, digits, `-` or `_`.
    22 ServiceName "service_name" Caller REFUSED false;
    /// A key or value of the configuration or scene is invalid.
    23 Configuration "configuration" Caller REFUSED false;
    /// An output file could not be written.
    24 Output "output" Environment REFUSED false;
    /// The displacement under this load cannot be computed.
    25 Unsolvable "unsolvable" Caller REFUSED false;
    /// The source of displacements is unknown.
    26 Elastic "elastic" Caller REFUSED false;
    /// An effect is both enabled and disabled, or an effect or table that it needs is missing.
    27 Effect "effect" Caller REFUSED false;
    /// The result has no such fragment.
    28 UnknownFragment "unknown_fragment" Caller REFUSED false;
    /// The fragment is too small to be struck again, or too thin for the elastic lattice.
    29 FragmentSize "fragment_size" Caller REFUSED false;
    /// A ray has no direction, is combined with other contacts, or is missing.
    30 Ray "ray" Caller REFUSED false;
    /// The ray misses the object.
    31 RayMissed "ray_missed" Caller REFUSED false;
    /// The ticket has already handed out its result or its error.
    32 TicketSpent "ticket_spent" Caller REFUSED false;
    /// The partner of a contact is invalid, missing at one of several contacts, or does not limit the energy.
    33 ContactPartner "contact_partner" Caller REFUSED false;
    /// The queue, the pool of results or the number of clients has reached its limit.
    40 Busy "busy" Service BUSY true;
    /// The deadline passed before the result was ready.
    41 Late "late" Service BUSY true;
    /// The daemon is stopping.
    42 Stopping "stopping" Service BUSY true;
    /// The request was canceled.
    43 Canceled "canceled" Caller REFUSED true;
    /// The request failed inside the service.
    44 Failed "failed" Service OURS false;
    /// The result is larger than the buckets of the daemon.
    45 ResultTooLarge "result_too_large" Service OURS false;
    /// The result did not pass the client's checks.
    46 BadResult "bad_result" Service OURS false;
    /// A call of the transport failed.
    47 Transport "transport" Service OURS false;
    /// The object's database has been found and is being loaded.
    48 Loading "loading" Service BUSY true;
    /// No daemon of this name runs.
    60 NoDaemon "no_daemon" Environment ABSENT true;
    /// The daemon ended during the request.
    61 Lost "lost" Environment ABSENT true;
    /// Another daemon of this name runs.
    62 SecondDaemon "second_daemon" Environment REFUSED false;
    /// The runtime folder cannot be used.
    63 RuntimeFolder "runtime_folder" Environment REFUSED false;
    /// The shared memory of the machine is full.
    64 SharedMemory "shared_memory" Environment BUSY true;
    /// The folder of databases cannot be read.
    65 DatabaseFolder "database_folder" Environment REFUSED false;
    /// The loopback port for health and metrics cannot be opened.
    66 Port "port" Environment REFUSED false;
}

/// An error. Shown and as a document, its texts hold no control characters: see [`text::message`].
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", text::message(message))]
pub struct Error {
    /// The rule.
    pub kind: ErrorKind,
    /// The offender: an index, key, bit or path, as short text; may be empty.
    pub at: String,
    /// One sentence for people.
    pub message: String,
    /// Time after which the same request may succeed; `None`: not known.
    pub retry_after: Option<Duration>,
}

/// As shown, with the rule and the offender: `main` prints an error that it returns by this.
impl fmt::Debug for Error {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{self} ({}", self.kind.name())?;
        match self.at.as_str() {
            "" => write!(to, ")"),
            at => write!(to, ", at `{}`)", text::quoted(at)),
        }
    }
}

impl Error {
    /// An error of kind `kind` at offender `at`.
    pub fn new(kind: ErrorKind, at: impl Into<String>, message: impl Into<String>) -> Self {
        Self { kind, at: at.into(), message: message.into(), retry_after: None }
    }

    /// The same, to be tried again after `wait`.
    #[must_use]
    pub fn after(self, wait: Duration) -> Self {
        Self { retry_after: Some(wait), ..self }
    }

    /// The document that both programs print under `--json`.
    pub fn document(&self) -> serde_json::Value {
        serde_json::json!({"error": {
            "kind": self.kind.name(),
            "message": text::message(&self.message),
            "fault": self.kind.fault().name(),
            "retry": self.kind.retry(),
            "retry_after_ms": self.retry_after.map(whole_ms),
            "at": text::quoted(&self.at),
        }})
    }
}

/// Milliseconds of `wait`, rounded up.
fn whole_ms(wait: Duration) -> u64 {
    u64::try_from(wait.as_micros().div_ceil(1000)).unwrap_or(u64::MAX)
}

/// An [`Error`] as it travels. Longer texts are cut.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ErrorWire {
    /// [`ErrorKind::code`].
    pub kind: u32,
    /// Bytes of `at` that count.
    pub at_length: u32,
    /// Bytes of `message` that count.
    pub message_length: u32,
    /// Microseconds after which to try again; 0: not known.
    pub retry_after_us: u32,
    /// UTF-8.
    pub at: [u8; 128],
    /// UTF-8.
    pub message: [u8; 256],
}

const _: () = assert!(size_of::<ErrorWire>() == 400);

impl From<&Error> for ErrorWire {
    fn from(error: &Error) -> Self {
        let mut wire = Self::zeroed();
        wire.kind = error.kind.code();
        let micros = |wait: Duration| u32::try_from(wait.as_micros()).unwrap_or(u32::MAX).max(1);
        wire.retry_after_us = error.retry_after.map_or(0, micros);
        wire.at_length = text::put(&mut wire.at, &error.at);
        wire.message_length = text::put(&mut wire.message, &error.message);
        wire
    }
}

impl From<&ErrorWire> for Error {
    /// Never fails: an unknown kind becomes [`ErrorKind::BadResult`], unreadable text is replaced.
    fn from(wire: &ErrorWire) -> Self {
        let message = text::show(&wire.message, wire.message_length);
        let retry_after = (wire.retry_after_us > 0).then(|| Duration::from_micros(wire.retry_after_us.into()));
        match ErrorKind::from_code(wire.kind) {
            Some(kind) => Self { kind, at: text::show(&wire.at, wire.at_length), message, retry_after },
            None => Self::new(ErrorKind::BadResult, wire.kind.to_string(), format!("unknown kind of error: {message}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_have_distinct_codes_and_names() {
        for (i, a) in ErrorKind::ALL.iter().enumerate() {
            assert_eq!(ErrorKind::from_code(a.code()), Some(*a));
            assert!(ErrorKind::ALL[..i].iter().all(|b| b.name() != a.name()), "{a:?}");
        }
        assert_eq!(ErrorKind::from_code(0), None);
    }

    #[test]
    fn an_error_displays_as_a_sentence() {
        let error = Error::new(ErrorKind::Impulse, "contacts[1].impulse_ns", "the impulse is zero");
        assert_eq!(format!("{error:?}"), "the impulse is zero (impulse, at `contacts[1].impulse_ns`)");
        assert_eq!(format!("{:?}", Error::new(ErrorKind::Stopping, "", "no more")), "no more (stopping)");
    }

    #[test]
    fn errors_round_trip() {
        let error = Error::new(ErrorKind::Impulse, "contacts[1].impulse_ns", "the impulse is zero");
        assert_eq!(Error::from(&ErrorWire::from(&error)), error);
        let busy = Error::new(ErrorKind::Busy, "queue", "full").after(Duration::from_micros(1500));
        assert_eq!(Error::from(&ErrorWire::from(&busy)), busy);
        assert_eq!(busy.document()["error"]["retry_after_ms"], 2, "whole milliseconds, rounded up");
        let long = Error::new(ErrorKind::Failed, "ü".repeat(99), "é".repeat(999));
        let back = Error::from(&ErrorWire::from(&long));
        assert_eq!((back.at.len(), back.message.len()), (128, 256));
    }
}
