//! Files of an earlier export into the same folder: pieces of another strike beside those of this one would be taken for its own.
//!
//! What an export wrote stands in its table (`fragments.json`, or the model). A file goes if the table that is about to be replaced
//! names it, its name is one that only exports give, and this export does not write it again; everything else stays.

use super::ExportError;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use serde_json::Value;
use std::io;
use std::path::Path;

/// Files that the table `fragments.json` names; none if there is none, or it is none of ours.
pub(super) fn in_table(path: &Path) -> Vec<String> {
    // A pipe would be waited for.
    let text = Some(path).filter(|path| path.is_file()).and_then(|path| std::fs::read(path).ok());
    let table: Option<Value> = text.and_then(|text| serde_json::from_slice(&text).ok());
    let rows = table.as_ref().and_then(|table| table["fragments"].as_array()).into_iter().flatten();
    let named = rows.flat_map(|row| [&row["file"], &row["hull"]]).filter_map(Value::as_str);
    named.map(str::to_owned).collect()
}

/// Files that a model names in its folder `meshes`; none if there is no model, or it has its meshes elsewhere.
pub(super) fn in_model(path: &Path, meshes: &str) -> Vec<String> {
    let Ok(text) = std::fs::read_to_string(path) else { return Vec::new() };
    let (mut reader, mut named, mut own) = (Reader::from_str(&text), Vec::new(), false);
    while let Ok(event) = reader.read_event() {
        match event {
            Event::Empty(element) if element.name().as_ref() == b"compiler" => {
                own = value(&element, "meshdir").is_some_and(|folder| folder == meshes);
            }
            Event::Empty(element) if element.name().as_ref() == b"mesh" => named.extend(value(&element, "file")),
            Event::Eof => break,
            _ => {}
        }
    }
    if own { named } else { Vec::new() }
}

fn value(element: &BytesStart<'_>, key: &str) -> Option<String> {
    let found = element.try_get_attribute(key).ok()??;
    found.unescape_value().ok().map(|value| value.into_owned())
}

/// Removes of `named`, files of `folder`, what exports alone call so and what is not among `kept`.
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

/// `fragment_`, a number, perhaps an ending of ours, and `.obj`; so never a path that leads elsewhere.
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
    fn only_names_of_exports_are_ours() {
        for ours in ["fragment_000.obj", "fragment_1234.hull.obj", "fragment_017_outer.obj", "fragment_017_solid.obj"] {
            assert!(is_ours(ours), "{ours}");
        }
        for other in ["fragment_.obj", "fragment_00.obj", "fragment_000.obj.bak", "fragment_000/../x.obj", "a.obj", ""]
        {
            assert!(!is_ours(other), "{other}");
        }
    }
}
