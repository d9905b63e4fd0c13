//! Names of services and objects.

use crate::{Kind, Refusal};
use std::fmt;

/// Longest name of a service, bytes: it becomes part of file and socket paths.
pub const SERVICE_NAME_MAX: usize = 32;

/// Longest name of an object, bytes of UTF-8.
pub const OBJECT_NAME_MAX: usize = 64;

/// The name of a service: 1 to 32 letters, digits, `-` or `_`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ServiceName(String);

impl ServiceName {
    /// Checks `name`.
    pub fn new(name: &str) -> Result<Self, Refusal> {
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
        if (1..=SERVICE_NAME_MAX).contains(&name.len()) && name.bytes().all(plain) {
            return Ok(Self(name.to_owned()));
        }
        let message = format!("`{name}` does not name a service: 1 to {SERVICE_NAME_MAX} letters, digits, `-`, `_`");
        Err(Refusal::new(Kind::ServiceName, name, message))
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for ServiceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Checks the name of an object: 1 to 64 bytes of UTF-8 without control characters or path separators.
pub fn object_name(name: &str) -> Result<(), Refusal> {
    let plain = |c: char| !c.is_control() && c != '/' && c != '\\';
    if (1..=OBJECT_NAME_MAX).contains(&name.len()) && name.chars().all(plain) {
        return Ok(());
    }
    let message =
        format!("`{name}` does not name an object: 1 to {OBJECT_NAME_MAX} bytes without `/`, `\\` or controls");
    Err(Refusal::new(Kind::ObjectName, name, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn service_names_are_plain_and_short() {
        for name in ["default", "a", "A-1_b", &"x".repeat(32)] {
            assert!(ServiceName::new(name).is_ok(), "{name}");
        }
        for name in ["", "a b", "a/b", "ä", ".", &"x".repeat(33)] {
            assert_eq!(ServiceName::new(name).unwrap_err().kind, Kind::ServiceName, "{name}");
        }
    }

    #[test]
    fn object_names_may_hold_spaces_and_letters_of_any_script() {
        for name in ["horse", "große Vase 3", "花瓶"] {
            assert!(object_name(name).is_ok(), "{name}");
        }
        for name in ["", "a/b", "a\nb", &"x".repeat(65)] {
            assert_eq!(object_name(name).unwrap_err().kind, Kind::ObjectName, "{name}");
        }
    }
}
