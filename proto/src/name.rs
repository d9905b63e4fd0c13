//! Names of services and objects.

use crate::text::{is_invisible, quoted};
use crate::{Error, ErrorKind};
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
    ///
    /// # Errors
    /// `service_name`.
    pub fn new(name: &str) -> Result<Self, Error> {
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
        if (1..=SERVICE_NAME_MAX).contains(&name.len()) && name.bytes().all(plain) {
            return Ok(Self(name.to_owned()));
        }
        let name = quoted(name);
        let message = format!("`{name}` does not name a service: 1 to {SERVICE_NAME_MAX} letters, digits, `-`, `_`");
        Err(Error::new(ErrorKind::ServiceName, name, message))
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

/// Checks the name of an object: 1 to 64 bytes of UTF-8 without control characters, invisible ones or path separators.
///
/// # Errors
/// `object_name`.
pub fn object_name(name: &str) -> Result<(), Error> {
    let plain = |c: char| !is_invisible(c) && c != '/' && c != '\\';
    if (1..=OBJECT_NAME_MAX).contains(&name.len()) && name.chars().all(plain) {
        return Ok(());
    }
    let name = quoted(name);
    let message = format!(
        "`{name}` does not name an object: 1 to {OBJECT_NAME_MAX} bytes without `/`, `\\`, control or invisible characters"
    );
    Err(Error::new(ErrorKind::ObjectName, name, message))
}

/// Number of similar names that a message lists.
const NEAREST_MAX: usize = 3;

/// Number of names that a message lists if none is similar.
const LISTED_MAX: usize = 24;

/// Smallest length of a name that counts as the beginning of others.
const PREFIX_MIN: usize = 3;

/// The names most like `name`, the likeliest first: what a typing error may have meant.
///
/// Names that begin with `name`, and those with which it begins, come first. Others are ordered by edit distance (F. J. Damerau 1964,
/// V. I. Levenshtein 1966).
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let lower = name.to_lowercase();
    let length = name.chars().count();
    let distance_max = |own: &str| match own.chars().count() {
        own @ 0..=2 => own.max(2) - 1,
        own => (1 + own.max(length) / 3).min(own.max(length) / 2),
    };
    let begins = |one: &str, other: &str| one.len() >= PREFIX_MIN && other.starts_with(one);
    let is_begun = |own: &str| begins(&lower, own) || begins(own, &lower);
    // No distance is less than the difference of the lengths, and computing one takes their product in time and memory.
    let comparable =
        known.iter().filter(|own| is_begun(own) || own.chars().count().abs_diff(length) <= distance_max(own));
    let distance = |own: &str| if is_begun(own) { 0 } else { strsim::damerau_levenshtein(&lower, &own.to_lowercase()) };
    let mut rated: Vec<(usize, &str)> = comparable.map(|own| (distance(own), *own)).collect();
    rated.sort();
    let likely = |(distance, own): &(usize, &str)| *distance <= distance_max(own);
    rated.into_iter().filter(likely).take(NEAREST_MAX).map(|(_, own)| own).collect()
}

/// The part of a message that follows a name which is not among `known`: the nearest names, or those that there are.
pub fn suggestion(name: &str, known: &[&str]) -> String {
    let listed = |names: &[&str]| names.iter().map(|own| format!("`{}`", quoted(own))).collect::<Vec<_>>().join(", ");
    let likely = nearest(name, known);
    match (likely.as_slice(), known) {
        ([], []) => "there are none".to_owned(),
        ([], known) if known.len() > LISTED_MAX => {
            format!("there are {} others, {} among them", known.len(), listed(&known[..NEAREST_MAX]))
        }
        ([], [one]) => format!("there is `{}`", quoted(one)),
        ([], known) => format!("there are {}", listed(known)),
        (likely, _) => format!("did you mean {}?", listed(likely)),
    }
}

/// The error for an object that a service does not have; `known` are those that it has.
pub fn unknown_object(name: &str, known: &[&str]) -> Error {
    let shown = quoted(name);
    let message = format!("the service has no object `{shown}`; {}", suggestion(name, known));
    Error::new(ErrorKind::UnknownObject, shown, message)
}

/// The error for an object that no loaded database holds, while the one of the file name `file` is loaded: its object may have another name.
pub fn object_being_loaded(name: &str, file: &str) -> Error {
    let shown = quoted(name);
    let message = format!(
        "no loaded database holds `{shown}`, but `{}` is still being loaded; send it again later",
        quoted(file)
    );
    Error::new(ErrorKind::Loading, shown, message)
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
            assert_eq!(ServiceName::new(name).unwrap_err().kind, ErrorKind::ServiceName, "{name}");
        }
    }

    #[test]
    fn unknown_names_suggest_the_nearest() {
        let known = ["horse", "mug", "vase", "vase-2"];
        assert_eq!(nearest("vaze", &known), ["vase", "vase-2"]);
        assert_eq!(nearest("Mug", &known), ["mug"]);
        assert!(nearest("zeppelin", &known).is_empty());
        assert!(nearest("dog", &known).is_empty(), "one common letter of three is no typing error");
        assert_eq!(nearest("mgu", &["m2", "m3", "mug"]), ["mug"]);
        assert!(unknown_object("vaze", &known).message.ends_with("did you mean `vase`, `vase-2`?"));
        assert!(unknown_object("x", &[]).message.ends_with("there are none"));
        assert!(suggestion("zeppelin", &known).ends_with("`horse`, `mug`, `vase`, `vase-2`"));
    }

    #[test]
    fn errors_quote_no_more_than_the_beginning_of_a_long_name() {
        let long = "x".repeat(100_000);
        let known = ["horse", "mug"];
        let errors = [
            unknown_object(&long, &known),
            object_name(&long).unwrap_err(),
            ServiceName::new(&long).unwrap_err(),
            crate::effect::Effect::by_name(&long).unwrap_err(),
            crate::convention::Convention::by_name(&long).unwrap_err(),
            crate::request::Quality::by_name(&long).unwrap_err(),
        ];
        for error in errors {
            assert!(error.message.contains("… (100000 bytes)") && error.message.len() < 500, "{}", error.message);
            assert!(error.at.len() < 300, "{}", error.at);
        }
        // Distances to a long name would take the product of the lengths in memory.
        assert!(nearest(&"gum".repeat(1_000_000), &known).is_empty());
    }

    #[test]
    fn object_names_may_hold_spaces_and_letters_of_any_script() {
        for name in ["horse", "große Vase 3", "花瓶"] {
            assert!(object_name(name).is_ok(), "{name}");
        }
        for name in ["", "a/b", "a\nb", "a\u{202e}b", "a\u{2069}", "\u{200e}a", "a\u{200b}b", &"x".repeat(65)] {
            assert_eq!(object_name(name).unwrap_err().kind, ErrorKind::ObjectName, "{name}");
        }
    }
}
