//! Detection of files and folders of the wrong kind by name, before their contents are parsed.

use super::CommandError;
use crate::catalog::is_hidden;
use clap::error::{ContextKind, ContextValue};
use shatter_fracture::database::EXTENSION;
use shatter_proto::name::nearest;
use shatter_proto::text::message;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Extensions of mesh files.
const MESHES: [&str; 8] = ["obj", "ply", "stl", "gltf", "glb", "msh", "vtk", "mesh"];

/// Maximum number of names that a message lists.
const LISTED_MAX: usize = 5;

/// Kind of file that a command expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpectedFile {
    /// A mesh file.
    Mesh,
    /// A database, or a share of one.
    Database,
    /// A scene.
    Scene,
    /// A configuration of the daemon.
    Configuration,
}

impl ExpectedFile {
    fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh (.obj, .ply, .stl, .gltf, .glb, .msh, .vtk or .mesh)",
            Self::Database => "database (.shatter) or share of one",
            Self::Scene => "scene (a TOML file with a table [objects.NAME] for each object)",
            Self::Configuration => "configuration (a TOML file like `config/shatterd.toml` of the project)",
        }
    }

    fn kind(self) -> &'static str {
        match self {
            Self::Mesh => "unknown_format",
            Self::Database => "database_file",
            Self::Scene | Self::Configuration => "configuration",
        }
    }

    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Mesh => &MESHES,
            Self::Database => &[EXTENSION, "share"],
            Self::Scene | Self::Configuration => &["toml"],
        }
    }
}

/// Refuses a path whose name shows that it is of another kind, and advises what to do.
///
/// # Errors
/// `unreadable_file` for a path that does not exist but resembles one; `unknown_format`, `database_file`, `configuration`.
pub fn check(path: &Path, wanted: ExpectedFile) -> Result<(), CommandError> {
    let Some(why) = mistake_message(path, wanted) else { return Ok(()) };
    let at = path.display().to_string();
    let kind = if path.exists() { wanted.kind() } else { "unreadable_file" };
    Err(CommandError::refused(kind, at.clone(), format!("{at} {why}")))
}

/// Adds to a usage error about missing arguments that a mesh among the words of the command line has a misspelled name.
pub fn explain_missing(error: &mut clap::Error, words: impl Iterator<Item = OsString>) {
    if error.kind() != clap::error::ErrorKind::MissingRequiredArgument {
        return;
    }
    let mut meshes = words.map(PathBuf::from).filter(|word| !word.exists() && has_ending(word, ExpectedFile::Mesh));
    let tip =
        meshes.find_map(|mesh| Some(format!("{} {}", mesh.display(), mistake_message(&mesh, ExpectedFile::Mesh)?)));
    let Some(tip) = tip else { return };
    let mut tips = match error.remove(ContextKind::Suggested) {
        Some(ContextValue::StyledStrs(tips)) => tips,
        _ => Vec::new(),
    };
    tips.push(message(&tip).into());
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
}

fn has_ending(path: &Path, wanted: ExpectedFile) -> bool {
    let ending = path.extension();
    ending.is_some_and(|own| wanted.endings().iter().any(|ending| own.eq_ignore_ascii_case(ending)))
}

fn mistake_message(path: &Path, wanted: ExpectedFile) -> Option<String> {
    let shown = path.display();
    if path.is_dir() {
        return Some(format!("is a folder, not a {}{}", wanted.name(), inside(path, wanted)));
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if let Err(error) = std::fs::metadata(path) {
        // The reader reports other causes, such as a loop of links, with the operating system's reason.
        if error.kind() != ErrorKind::NotFound {
            return None;
        }
        let beside = wanted.endings().iter().map(|ending| path.with_extension(ending)).find(|path| path.is_file());
        let likely = beside.or_else(|| similar(path, wanted));
        return likely.map(|likely| format!("does not exist; did you mean {}?", likely.display()));
    }
    let of = |kind: ExpectedFile| wanted != kind && kind.endings().contains(&ending.as_str());
    let advice = if of(ExpectedFile::Mesh) {
        format!(
            "has the extension of a mesh, and this command takes a {}; if it is a mesh, bake it: shatterd bake {shown} --name NAME",
            wanted.name()
        )
    } else if of(ExpectedFile::Database) {
        format!(
            "has the extension of a database, and this command takes a {}; show its contents: shatterd inspect {shown}",
            wanted.name()
        )
    } else if of(ExpectedFile::Scene) && wanted != ExpectedFile::Configuration {
        format!("is a TOML file, not a {}; if it is a scene: shatterd check {shown}", wanted.name())
    } else if wanted == ExpectedFile::Mesh && ending.is_empty() {
        format!("has no extension, so its format is unknown; expected a {}", wanted.name())
    } else {
        return None;
    };
    Some(advice)
}

/// The file of the wanted kind in the same folder whose name is most like that of `path`. Links without a target are no files.
fn similar(path: &Path, wanted: ExpectedFile) -> Option<PathBuf> {
    let folder = path.parent()?;
    let mut files: Vec<PathBuf> = files(folder_of(folder), wanted).filter(|file| file.is_file()).collect();
    files.sort();
    let stem = |file: &Path| file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let stems: Vec<String> = files.iter().filter_map(|file| stem(file)).collect();
    let likely = nearest(&stem(path)?, &stems.iter().map(String::as_str).collect::<Vec<_>>()).first().copied()?;
    let file = files.iter().find(|file| stem(file).as_deref() == Some(likely))?;
    Some(folder.join(file.file_name()?))
}

/// The folder to read for a relative path without folders.
fn folder_of(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// Files of the wanted kind in a folder.
fn files(folder: &Path, wanted: ExpectedFile) -> impl Iterator<Item = PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    entries.filter(move |path| !is_hidden(path) && has_ending(path, wanted))
}

/// List of the files of the wanted kind in a folder.
fn inside(folder: &Path, wanted: ExpectedFile) -> String {
    let mut names: Vec<String> = files(folder, wanted).map(|path| path.display().to_string()).collect();
    names.sort();
    let more = names.len().saturating_sub(LISTED_MAX);
    names.truncate(LISTED_MAX);
    match (names.as_slice(), more) {
        ([], _) => "; name one file".to_owned(),
        (names, 0) => format!("; in it: {}", names.join(", ")),
        (names, more) => format!("; in it: {} and {more} more", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_the_wrong_kind_are_reported_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["spot.obj", "mug.shatter", ".hid.shatter", "scene.toml", "plain", "notes.xyz"] {
            std::fs::write(path(name), "").unwrap();
        }
        let message_of =
            |name: &str, wanted| check(&path(name), wanted).err().map(|failure| failure.message().to_owned());
        for (name, wanted, part) in [
            ("spot.obj", ExpectedFile::Database, "shatterd bake"),
            ("spot.obj", ExpectedFile::Scene, "[objects.NAME]"),
            ("spot.obj", ExpectedFile::Configuration, "extension of a mesh"),
            ("mug.shatter", ExpectedFile::Mesh, "shatterd inspect"),
            ("mug.shatter", ExpectedFile::Scene, "extension of a database"),
            ("scene.toml", ExpectedFile::Mesh, "shatterd check"),
            ("plain", ExpectedFile::Mesh, "has no extension"),
            ("spot", ExpectedFile::Mesh, "spot.obj?"),
            ("spott.obj", ExpectedFile::Mesh, "spot.obj?"),
            ("", ExpectedFile::Mesh, "is a folder, not a mesh"),
            ("", ExpectedFile::Database, "mug.shatter"),
        ] {
            let message = message_of(name, wanted).unwrap_or_default();
            assert!(message.contains(part) && !message.contains(".hid"), "{name} {wanted:?}: {message}");
        }
        let missing = check(&path("spott.obj"), ExpectedFile::Mesh).unwrap_err();
        assert_eq!(missing.kind(), "unreadable_file", "not a format that is unknown");
        for (name, wanted) in [
            ("spot.obj", ExpectedFile::Mesh),
            ("mug.shatter", ExpectedFile::Database),
            ("scene.toml", ExpectedFile::Scene),
            ("scene.toml", ExpectedFile::Configuration),
            ("notes.xyz", ExpectedFile::Mesh),
            ("nothing.obj", ExpectedFile::Mesh),
        ] {
            assert_eq!(message_of(name, wanted), None, "{name} {wanted:?}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_without_a_target_are_not_suggested() {
        let folder = tempfile::tempdir().unwrap();
        for (name, target) in [("loop.obj", "loop.obj"), ("broken.obj", "missing.obj")] {
            let link = folder.path().join(name);
            std::os::unix::fs::symlink(target, &link).unwrap();
            assert_eq!(mistake_message(&link, ExpectedFile::Mesh), None, "{name}");
        }
        assert_eq!(mistake_message(&folder.path().join("brokn.obj"), ExpectedFile::Mesh), None);
    }
}
