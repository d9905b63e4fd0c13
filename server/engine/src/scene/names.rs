//! Names that are known, and the nearest to one that is not.

use shatter_fracture::scene::{self, brief};
use shatter_proto::{Error, ErrorKind};

/// Refuses the first of `keys` that is not among `all`, with the nearest that is. `table` is where they stand.
///
/// # Errors
/// `configuration` at the first unknown key.
pub fn known<'a>(table: &str, keys: impl Iterator<Item = &'a String>, all: &[&str]) -> Result<(), Error> {
    for key in keys {
        if !all.contains(&key.as_str()) {
            let key = brief(key);
            let path = if table.is_empty() { key.clone() } else { format!("{table}.{key}") };
            let message = format!("`{path}` is no key of a scene; `{}` is", nearest(&key, all));
            return Err(Error::new(ErrorKind::Configuration, path, message));
        }
    }
    Ok(())
}

/// The one of `all` that is nearest to `name`.
pub fn nearest<'a>(name: &str, all: &[&'a str]) -> &'a str {
    scene::nearest(name, all.iter().copied()).unwrap_or("")
}
