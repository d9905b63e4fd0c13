//! Scenes: the objects that are served, and what is simulated of each. What a scene does not name is neither loaded nor run.

mod anchors;
mod names;
mod object;
mod recipe;
mod tables;
mod warp;

pub use object::{ObjectPolicy, SceneObject};
pub use recipe::BakeRecipe;
pub use tables::{OptionalDatabaseTable, tables};

use names::known;
use shatter_fracture::scene::{MATERIALS, Materials, toml_error};
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
        std::fs::read_to_string(path)
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
    ///
    ///
    /// # Errors
    /// `configuration`, `unknown_effect`, `effect`, `object_name`, naming the offender and the nearest that is known.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let at = path.display().to_string();
        let text = read_text(path)
            .map_err(|error| Error::new(ErrorKind::Configuration, at.clone(), format!("cannot read {at}: {error}")))?;
        Self::parse(&text, path.parent().unwrap_or(Path::new("")))
            .map_err(|error| Error { message: format!("{at}: {}", error.message), ..error })
    }

    /// Parses the text of a scene file; `folder` is the base of relative paths in it.
    ///
    /// # Errors
    /// Those of [`Self::load`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self, Error> {
        let wrong = |error: toml::de::Error| Error::new(ErrorKind::Configuration, "scene", toml_error(text, &error));
        let table: toml::Table = text.parse().map_err(wrong)?;
        known("", table.keys(), &["title", "objects"])?;
        let title = match table.get("title") {
            None => String::new(),
            Some(toml::Value::String(title)) => title.clone(),
            Some(_) => return Err(invalid("title", "must be a string")),
        };
        let materials = Materials::parse(MATERIALS);
        let materials = materials.map_err(|error| invalid("materials", error.to_string()))?;
        let objects = match table.get("objects") {
            Some(toml::Value::Table(objects)) if !objects.is_empty() => objects,
            _ => return Err(invalid("objects", "missing; add at least one table [objects.NAME]")),
        };
        let object = |(name, value): (&String, &toml::Value)| {
            object_name(name)?;
            let toml::Value::Table(table) = value else {
                return Err(invalid(format!("objects.{name}"), "must be a table"));
            };
            Ok((name.clone(), SceneObject::read(name, table, &materials, folder)?))
        };
        Ok(Self { title, objects: objects.iter().map(object).collect::<Result<_, Error>>()? })
    }

    /// Names of the databases by object name.
    pub fn databases(&self) -> BTreeMap<String, String> {
        self.objects.iter().map(|(name, object)| (name.clone(), object.database.clone())).collect()
    }
}

/// Error for the value of a key.
fn invalid(key: impl Into<String>, why: impl std::fmt::Display) -> Error {
    let key = key.into();
    let message = format!("{key}: {why}");
    Error::new(ErrorKind::Configuration, key, message)
}

#[cfg(test)]
mod tests;
