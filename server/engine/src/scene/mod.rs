//! Scenes: the objects that are served, and what is simulated of each. What a scene does not name is neither loaded nor run.

mod anchors;
mod names;
mod object;
mod recipe;
mod tables;
mod warp;

pub use object::{OBJECT_KEYS, ObjectPolicy, SceneObject};
pub use recipe::BakeRecipe;
pub use tables::{OptionalDatabaseTable, tables};
pub use warp::WARP_KEYS;

use names::known;
use serde::de::DeserializeOwned;
use shatter_fracture::scene::{MATERIALS, Materials, brief, table_error, toml_error};
use shatter_proto::name::object_name;
use shatter_proto::{Error, ErrorKind};
use std::collections::BTreeMap;
use std::path::Path;

/// Reads a text file; refuses devices and pipes, whose reads may never end.
///
/// # Errors
/// Those of the file system, and one for what is no regular file.
pub fn read_text(path: &Path) -> std::io::Result<String> {
    if std::fs::metadata(path)?.is_file() {
        String::from_utf8(std::fs::read(path)?).map_err(|error| {
            std::io::Error::other(format!("not text in UTF-8 at byte {}", error.utf8_error().valid_up_to()))
        })
    } else {
        Err(std::io::Error::other("not a regular file"))
    }
}

/// A scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Title for people.
    pub title: String,
    /// Objects by the names under which they are served.
    pub objects: BTreeMap<String, SceneObject>,
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// `configuration`, `unknown_effect`, `effect`, `object_name`, naming the offender and the nearest that is known.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let at = path.display().to_string();
        let text = read_text(path)
            .map_err(|error| Error::new(ErrorKind::Configuration, at.clone(), format!("cannot read {at}: {error}")))?;
        Self::parse(&text, path.parent().unwrap_or(Path::new(""))).map_err(|error| Error {
            message: format!("{at}: {}", error.message),
            // An error of the TOML text has no key: it is at the file.
            at: if error.at.is_empty() { at } else { error.at },
            ..error
        })
    }

    /// Parses the text of a scene file; `folder` is the base of relative paths in it.
    ///
    /// # Errors
    /// Those of [`Self::load`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self, Error> {
        let wrong = |error: toml::de::Error| {
            Error::new(ErrorKind::Configuration, "", toml_error(text, &error, &object::RANGES))
        };
        let table: toml::Table = text.parse().map_err(wrong)?;
        known("", table.keys(), &["title", "objects"])?;
        let title = match table.get("title") {
            None => String::new(),
            Some(toml::Value::String(title)) => title.clone(),
            Some(other) => return Err(unsuitable("title", &other.to_string(), "a string")),
        };
        let materials = Materials::parse(MATERIALS);
        let materials = materials.map_err(|error| invalid("materials", error.to_string()))?;
        let objects = match table.get("objects") {
            Some(toml::Value::Table(objects)) if !objects.is_empty() => objects,
            Some(other) if !other.is_table() => {
                return Err(unsuitable("objects", &other.to_string(), "a table [objects.NAME] for each object"));
            }
            _ => return Err(invalid("objects", "missing; add at least one table [objects.NAME]")),
        };
        let object = |(name, value): (&String, &toml::Value)| {
            object_name(name)?;
            let toml::Value::Table(table) = value else {
                return Err(unsuitable(format!("objects.{name}"), &value.to_string(), "a table"));
            };
            Ok((name.clone(), SceneObject::read(name, table, &materials, folder)?))
        };
        let objects = objects.iter().map(object).collect::<Result<_, Error>>()?;
        recipe::check_unused_keys(&objects)?;
        Ok(Self { title, objects })
    }

    /// Names of the databases by object name.
    pub fn databases(&self) -> BTreeMap<String, String> {
        self.objects.iter().map(|(name, object)| (name.clone(), object.database.clone())).collect()
    }
}

/// Error for the `value` of a key, which must be as `range` says.
fn unsuitable(key: impl Into<String>, value: &str, range: &str) -> Error {
    let key = key.into();
    let message = format!("`{key}` is {}; it must be {range}", brief(value));
    Error::new(ErrorKind::Configuration, key, message)
}

/// Error for a value of another type, or out of its type's range, in the table at `path`; `ranges` as in [`table_error`].
fn wrong_type(path: &str, error: &toml::de::Error, ranges: &[(&str, &str)]) -> Error {
    let (key, message) = table_error(path, error, ranges);
    Error::new(ErrorKind::Configuration, key, message)
}

/// The elements of the list at `path`; an error names the element.
fn elements<T: DeserializeOwned>(path: &str, values: &[toml::Value]) -> Result<Vec<T>, Error> {
    let element = |(number, value): (usize, &toml::Value)| {
        value.clone().try_into().map_err(|error| wrong_type(&format!("{path}[{number}]"), &error, &[]))
    };
    values.iter().enumerate().map(element).collect()
}

/// Error for the value of a key.
fn invalid(key: impl Into<String>, why: impl std::fmt::Display) -> Error {
    let key = key.into();
    let message = format!("{key}: {why}");
    Error::new(ErrorKind::Configuration, key, message)
}

#[cfg(test)]
mod tests;
