//! The file by which a client tells absence from a mismatch. Its name carries no version, and a client of any version can
//! read the fields it needs to say what is wrong.

use crate::TRANSPORT_VERSION;
use serde::{Deserialize, Serialize};
use shatter_proto::{Error, ErrorKind, PROTOCOL_VERSION};

/// Information that a daemon publishes about itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DaemonInfo {
    /// Its [`PROTOCOL_VERSION`].
    pub protocol: u32,
    /// Its [`TRANSPORT_VERSION`].
    pub transport: String,
    /// Version of the program.
    #[serde(default)]
    pub program: String,
    /// Its process id.
    #[serde(default)]
    pub pid: u32,
    /// Token of its [`Instance`](crate::instance::Instance).
    #[serde(default)]
    pub instance: String,
}

impl DaemonInfo {
    /// Information of this build as process `pid`, with the transport instance of this token.
    pub fn ours(pid: u32, instance: &str) -> Self {
        Self {
            protocol: PROTOCOL_VERSION,
            transport: TRANSPORT_VERSION.to_owned(),
            program: env!("CARGO_PKG_VERSION").to_owned(),
            pid,
            instance: instance.to_owned(),
        }
    }

    /// The file's contents.
    pub fn to_json(&self) -> String {
        // A struct of numbers and strings always serializes.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// Reads the file's contents.
    ///
    /// # Errors
    /// `version_mismatch` at `hello` for a file that cannot be read.
    pub fn from_json(json: &str) -> Result<Self, Error> {
        serde_json::from_str(json).map_err(|error| {
            let message = format!("the daemon's hello cannot be read: {error}");
            Error::new(ErrorKind::VersionMismatch, "hello", message)
        })
    }

    /// Refuses a daemon that this build cannot talk to, naming both versions.
    ///
    /// # Errors
    /// `version_mismatch`, whose message names both versions.
    pub fn check(&self) -> Result<(), Error> {
        let theirs = format!("protocol {}, {}", self.protocol, self.transport);
        let ours = format!("protocol {PROTOCOL_VERSION}, {TRANSPORT_VERSION}");
        if theirs == ours {
            return Ok(());
        }
        let message = format!("the daemon speaks {theirs}; this client speaks {ours}");
        Err(Error::new(ErrorKind::VersionMismatch, theirs, message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mismatch_names_both_versions() {
        let other = r#"{"protocol": 9, "transport": "iceoryx2 1.0.0", "something": "new"}"#;
        let error = DaemonInfo::from_json(other).unwrap().check().unwrap_err();
        assert_eq!(error.kind, ErrorKind::VersionMismatch);
        let own = format!("protocol {PROTOCOL_VERSION}");
        for version in ["protocol 9", "iceoryx2 1.0.0", &own, "iceoryx2 0.10.0"] {
            assert!(error.message.contains(version), "{error}");
        }
        let ours = DaemonInfo::ours(7, "0123456789a");
        assert_eq!(DaemonInfo::from_json(&ours.to_json()).unwrap(), ours);
        assert!(ours.check().is_ok());
        assert_eq!(DaemonInfo::from_json("{").unwrap_err().kind, ErrorKind::VersionMismatch);
    }
}
