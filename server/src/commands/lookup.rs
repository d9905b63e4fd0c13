//! Lookup of a database by the name of its object.

use super::CommandError;
use crate::catalog::is_database;
use crate::config::data_folder;
use shatter_fracture::database::EXTENSION;
use shatter_proto::name::suggestion;
use shatter_proto::text::quoted;
use std::path::{Path, PathBuf};

/// Finds the database `given`: a file, or the name of an object in `folder`, or else in the platform's folder.
///
/// # Errors
/// [`CommandError`] `unknown_object`, whose message names the nearest.
pub fn database(given: &Path, folder: Option<&Path>) -> Result<PathBuf, CommandError> {
    if given.exists() {
        return Ok(given.to_owned());
    }
    let name = given.to_str().filter(|name| Path::new(name).file_name().is_some_and(|own| own == *name));
    let Some(name) = name else { return Ok(given.to_owned()) };
    let folder = folder.map_or_else(data_folder, |folder| Ok(folder.to_owned()))?;
    let name = name.strip_suffix(&format!(".{EXTENSION}")).unwrap_or(name);
    let file = folder.join(format!("{name}.{EXTENSION}"));
    if file.exists() {
        return Ok(file);
    }
    let names = names(&folder);
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let hint = match known.as_slice() {
        [] => ", which contains no database; make one with `shatterd bake`".to_owned(),
        known => format!("; {}", suggestion(name, known)),
    };
    let (file, name) = (quoted(&given.display().to_string()), quoted(name));
    let message = format!("no file {file} and no object `{name}` in {}{hint}", folder.display());
    Err(CommandError::refused("unknown_object", name, message))
}

/// Names of the objects in `folder`, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path()).filter(|path| is_database(path));
    let mut names: Vec<String> =
        paths.filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_is_found_by_its_name_and_the_nearest_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("vase.shatter");
        std::fs::write(&file, "").unwrap();
        std::fs::write(folder.path().join("notes.txt"), "").unwrap();
        std::fs::write(folder.path().join(".vaze.shatter"), "").unwrap();
        assert_eq!(names(folder.path()), ["vase"]);
        let find = |given: &str| database(Path::new(given), Some(folder.path()));
        assert_eq!(find("vase"), Ok(file.clone()));
        assert_eq!(find("vase.shatter"), Ok(file.clone()));
        assert_eq!(find(file.to_str().unwrap()), Ok(file));
        let failure = find("vaze").unwrap_err();
        assert!(failure.kind() == "unknown_object" && failure.message().contains("`vase`"), "{failure:?}");
        // A path is not looked up as a name; the error comes from opening it.
        assert_eq!(find("no/such/file"), Ok(PathBuf::from("no/such/file")));
    }
}
