//! Codes that every function returns.

use shatter_client::ErrorKind;

/// Result code of a call. Zero: success. Any other value names the rule that was violated. `ShatterError` adds who is at fault, whether
/// to try again, and the argument, field or path in question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Code {
    /// Success.
    Ok = 0,
    /// The bytes are not a request of this protocol.
    BadMagic = 1,
    /// The daemon speaks another version of the protocol than this library.
    VersionMismatch = 2,
    /// The kind of request does not exist.
    UnknownRequest = 3,
    /// A reserved field is not zero.
    ReservedField = 4,
    /// The object's name is empty, too long or not UTF-8.
    ObjectName = 5,
    /// The service has no object of this name.
    UnknownObject = 6,
    /// The object's database could not be loaded.
    CorruptObject = 7,
    /// No contact, or more than a request can hold.
    ContactCount = 8,
    /// A contact point is not finite.
    ContactPoint = 9,
    /// A contact point is farther from the body than its radius and a lattice spacing.
    ContactTooFar = 10,
    /// An impulse is zero or not finite, or the contacts cancel or press on anchors only.
    Impulse = 11,
    /// A contact duration is negative or not finite.
    ContactDuration = 12,
    /// A contact radius is not positive, not finite, or larger than the object.
    ContactRadius = 13,
    /// γ is not above zero, or not finite.
    Gamma = 14,
    /// The degree is zero, above the object's limit, or from an unknown rule.
    Degree = 15,
    /// The lift is unknown, or the object was not baked for it.
    Lift = 16,
    /// The effect does not exist in this version.
    UnknownEffect = 17,
    /// The preset is unknown, or a limit of time, error or iterations is out of range.
    Budget = 18,
    /// An invalid coordinate convention: an unknown number or name, or a unit of length out of range.
    Convention = 19,
    /// The service retains no result under this handle: it expired, was released or evicted, or never existed.
    UnknownHandle = 20,
    /// The result would exceed the limit of fragments or bytes.
    CapExceeded = 21,
    /// The name of the service is not 1 to 32 letters, digits, `-` or `_`.
    ServiceName = 22,
    /// A key or value of the configuration or scene is invalid.
    Configuration = 23,
    /// An output file could not be written.
    Output = 24,
    /// The displacement under this load cannot be computed.
    Unsolvable = 25,
    /// The source of displacements is unknown.
    Elastic = 26,
    /// An effect is both enabled and disabled, or an effect or table that it needs is missing.
    Effect = 27,
    /// The result has no such fragment.
    UnknownFragment = 28,
    /// The fragment is too small to be struck again, or too thin for the elastic lattice.
    FragmentSize = 29,
    /// A ray has no direction, is combined with other contacts, or is missing.
    Ray = 30,
    /// The ray misses the object.
    RayMissed = 31,
    /// The ticket has already handed out its result or its error.
    TicketSpent = 32,
    /// The partner of a contact is invalid, missing at one of several contacts, or does not limit the energy.
    ContactPartner = 33,
    /// The queue, the pool of results or the number of clients has reached its limit.
    Busy = 40,
    /// The deadline passed before the result was ready.
    Late = 41,
    /// The daemon is stopping.
    Stopping = 42,
    /// The request was canceled.
    Canceled = 43,
    /// The request failed inside the service.
    Failed = 44,
    /// The result is larger than the buckets of the daemon.
    ResultTooLarge = 45,
    /// The result did not pass the client's checks.
    BadResult = 46,
    /// A call of the transport failed.
    Transport = 47,
    /// The object's database has been found and is being loaded: send the request again later.
    Loading = 48,
    /// No daemon of this name runs.
    NoDaemon = 60,
    /// The daemon ended during the request.
    Lost = 61,
    /// Another daemon of this name runs.
    SecondDaemon = 62,
    /// The runtime folder cannot be used.
    RuntimeFolder = 63,
    /// The shared memory of the machine is full.
    SharedMemory = 64,
    /// The folder of databases cannot be read.
    DatabaseFolder = 65,
    /// The loopback port for health and metrics cannot be opened.
    Port = 66,
    /// An argument cannot be used: it is NULL but must not be, its text is not UTF-8, or its number has no meaning.
    Argument = 200,
    /// A panic inside this library, caught at the C boundary. Free the handles of the call, and do not use them otherwise.
    Panicked = 201,
}

impl From<ErrorKind> for Code {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::BadMagic => Self::BadMagic,
            ErrorKind::VersionMismatch => Self::VersionMismatch,
            ErrorKind::UnknownRequest => Self::UnknownRequest,
            ErrorKind::ReservedField => Self::ReservedField,
            ErrorKind::ObjectName => Self::ObjectName,
            ErrorKind::UnknownObject => Self::UnknownObject,
            ErrorKind::CorruptObject => Self::CorruptObject,
            ErrorKind::ContactCount => Self::ContactCount,
            ErrorKind::ContactPoint => Self::ContactPoint,
            ErrorKind::ContactTooFar => Self::ContactTooFar,
            ErrorKind::Impulse => Self::Impulse,
            ErrorKind::ContactDuration => Self::ContactDuration,
            ErrorKind::ContactRadius => Self::ContactRadius,
            ErrorKind::Gamma => Self::Gamma,
            ErrorKind::Degree => Self::Degree,
            ErrorKind::Lift => Self::Lift,
            ErrorKind::UnknownEffect => Self::UnknownEffect,
            ErrorKind::Budget => Self::Budget,
            ErrorKind::Convention => Self::Convention,
            ErrorKind::UnknownHandle => Self::UnknownHandle,
            ErrorKind::CapExceeded => Self::CapExceeded,
            ErrorKind::ServiceName => Self::ServiceName,
            ErrorKind::Configuration => Self::Configuration,
            ErrorKind::Output => Self::Output,
            ErrorKind::Unsolvable => Self::Unsolvable,
            ErrorKind::Elastic => Self::Elastic,
            ErrorKind::Effect => Self::Effect,
            ErrorKind::UnknownFragment => Self::UnknownFragment,
            ErrorKind::FragmentSize => Self::FragmentSize,
            ErrorKind::Ray => Self::Ray,
            ErrorKind::RayMissed => Self::RayMissed,
            ErrorKind::TicketSpent => Self::TicketSpent,
            ErrorKind::ContactPartner => Self::ContactPartner,
            ErrorKind::Busy => Self::Busy,
            ErrorKind::Late => Self::Late,
            ErrorKind::Stopping => Self::Stopping,
            ErrorKind::Canceled => Self::Canceled,
            ErrorKind::Failed => Self::Failed,
            ErrorKind::ResultTooLarge => Self::ResultTooLarge,
            ErrorKind::BadResult => Self::BadResult,
            ErrorKind::Transport => Self::Transport,
            ErrorKind::Loading => Self::Loading,
            ErrorKind::NoDaemon => Self::NoDaemon,
            ErrorKind::Lost => Self::Lost,
            ErrorKind::SecondDaemon => Self::SecondDaemon,
            ErrorKind::RuntimeFolder => Self::RuntimeFolder,
            ErrorKind::SharedMemory => Self::SharedMemory,
            ErrorKind::DatabaseFolder => Self::DatabaseFolder,
            ErrorKind::Port => Self::Port,
            // An error kind without a code of its own; the test below fails for it.
            _ => Self::Failed,
        }
    }
}

/// Party at fault for an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Fault {
    /// No error.
    None = 0,
    /// The call is wrong; repeating it changes nothing.
    Caller = 1,
    /// The service or this library failed, or cannot do it now.
    Service = 2,
    /// The environment: no daemon, no memory, no permission.
    Environment = 3,
}

impl From<shatter_client::FaultParty> for Fault {
    fn from(fault: shatter_client::FaultParty) -> Self {
        match fault {
            shatter_client::FaultParty::Caller => Self::Caller,
            shatter_client::FaultParty::Service => Self::Service,
            shatter_client::FaultParty::Environment => Self::Environment,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_match_error_kinds() {
        for kind in ErrorKind::ALL {
            assert_eq!(Code::from(*kind) as u32, kind.code(), "{kind:?}");
            assert_eq!(format!("{:?}", Code::from(*kind)), format!("{kind:?}"));
        }
        for own in [Code::Ok, Code::Argument, Code::Panicked] {
            assert_eq!(ErrorKind::from_code(own as u32), None);
        }
    }
}
