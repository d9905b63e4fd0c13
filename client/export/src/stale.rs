//! Removal of files of an earlier export into the same folder, which could be mistaken for files of this one.
//!
//! The table of an export (`fragments.json`, or the model) names its files. A file is removed if the table that is about to be replaced
//! names it, if its name is one that only exports use, and if this export does not write it again. All other files stay.

use super::ExportError;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use serde_json::Value;
use std::io;
use std::path::Path;

/// Files that the table `fragments.json` names; empty without a table, or if another program wrote it.
pub(super) fn in_table(path: &Path) -> Vec<String> {
    // Only a regular file: reading a pipe would block.
    let text = Some(path).filter(|path| path.is_file()).and_then(|path| std::fs::read(path).ok());
    let table: Option<Value> = text.and_then(|text| serde_json::from_slice(&text).ok());
    let rows = table.as_ref().and_then(|table| table["fragments"].as_array()).into_iter().flatten();
    let named = rows.flat_map(|row| [&row["file"], &row["hull"]]).filter_map(Value::as_str);
    named.map(str::to_owned).collect()
}

/// Files that a model names in its folder `meshes`; empty without a model, if it is no valid XML, or if it has its meshes elsewhere.
pub(super) fn in_model(path: &Path, meshes: &str) -> Vec<String> {
    let Ok(text) = std::fs::read_to_string(path) else { return Vec::new() };
    let (mut reader, mut named, mut own, mut depth) = (Reader::from_str(&text), Vec::new(), false, 0_usize);
    loop {
        let Ok(event) = reader.read_event() else { return Vec::new() };
        match event {
            Event::Empty(element) if element.name().as_ref() == b"compiler" => {
                own = value(&element, "meshdir").is_some_and(|folder| folder == meshes);
            }
            Event::Empty(element) if element.name().as_ref() == b"mesh" => named.extend(value(&element, "file")),
            Event::Start(_) => depth += 1,
            Event::End(_) => depth = depth.saturating_sub(1),
            Event::Eof => break,
            _ => {}
        }
    }
    if own && depth == 0 { named } else { Vec::new() }
}

fn value(element: &BytesStart<'_>, key: &str) -> Option<String> {
    let found = element.try_get_attribute(key).ok()??;
    found.unescape_value().ok().map(|value| value.into_owned())
}

/// Removes those files `named` of `folder` that have a name which only exports use and are not among `kept`.
pub(super) fn remove<'a>(
    folder: &Path,
    named: &[String],
    kept: impl Iterator<Item = &'a str>,
) -> Result<(), ExportError> {
    let kept: Vec<&str> = kept.collect();
    for name in named.iter().filter(|name| is_ours(name) && !kept.contains(&name.as_str())) {
        let path = folder.join(name);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(ExportError::Write { path, source }),
            _ => {}
        }
    }
    Ok(())
}

/// True if `name` is `fragment_`, a number, perhaps an ending of an export, and `.obj`. Such a name is never a path to another folder.
fn is_ours(name: &str) -> bool {
    let rest = name.strip_prefix("fragment_").and_then(|rest| rest.strip_suffix(".obj"));
    let ending = rest.map(|rest| (rest.len(), rest.trim_start_matches(|digit: char| digit.is_ascii_digit())));
    ending.is_some_and(|(length, ending)| {
        let endings = ["", ".hull", "_outer", "_crack", "_hull", "_solid"];
        length >= ending.len() + 3 && endings.contains(&ending)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_exported_file_names_are_removed() {
        for ours in ["fragment_000.obj", "fragment_1234.hull.obj", "fragment_017_outer.obj", "fragment_017_solid.obj"] {
            assert!(is_ours(ours), "{ours}");
        }
        for other in ["fragment_.obj", "fragment_00.obj", "fragment_000.obj.bak", "fragment_000/../x.obj", "a.obj", ""]
        {
            assert!(!is_ours(other), "{other}");
        }
    }
}
