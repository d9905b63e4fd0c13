//! Checks of names, with suggestions.

use shatter_fracture::scene::brief;
use shatter_proto::name::suggestion;
use shatter_proto::{Error, ErrorKind};

/// Refuses the first of `keys` that is not in `all`, and suggests the nearest. `table` is the path of the table.
///
/// # Errors
/// `configuration` at the first unknown key.
pub fn known<'a>(table: &str, keys: impl Iterator<Item = &'a String>, all: &[&str]) -> Result<(), Error> {
    for key in keys {
        if !all.contains(&key.as_str()) {
            let key = brief(key);
            let path = if table.is_empty() { key.clone() } else { format!("{table}.{key}") };
            let message = format!("unknown key `{path}`; {}", suggestion(&key, all));
            return Err(Error::new(ErrorKind::Configuration, path, message));
        }
    }
    Ok(())
}
