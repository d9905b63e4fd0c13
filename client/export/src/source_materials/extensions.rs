//! Extensions of materials, textures, samplers and images.

use super::Defect;
use serde_json::Value;
use std::collections::BTreeSet;

/// Beginnings of the names of extensions that concern materials only.
const OF_MATERIALS: [&str; 3] = ["KHR_materials_", "EXT_materials_", "ADOBE_materials_"];

/// Extensions that need only textures and images.
const OF_TEXTURES: [&str; 5] =
    ["KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds"];

/// The used and the required extensions of the new file: those of the document `root` that occur in its `lists`.
///
/// An extension that occurs without being declared is declared here.
pub(super) fn carried(root: &Value, lists: &[&Vec<Value>]) -> Result<(Vec<String>, Vec<String>), Defect> {
    let mut present = BTreeSet::new();
    lists.iter().copied().flatten().for_each(|value| collect(value, &mut present));
    let required = names(root, "extensionsRequired")?;
    if let Some(other) = required.iter().find(|name| !can_be_carried(name)) {
        return Err(Defect::Extension(other.clone()));
    }
    let of_lists = |mut names: Vec<String>| {
        names.retain(|name| present.contains(name.as_str()));
        names
    };
    let mut used = of_lists(names(root, "extensionsUsed")?);
    let undeclared: Vec<String> =
        present.iter().filter(|name| !used.iter().any(|used| used == *name)).map(|name| (*name).to_owned()).collect();
    used.extend(undeclared);
    Ok((used, of_lists(required)))
}

/// True if the extension needs nothing of the document but the lists that are copied.
fn can_be_carried(name: &str) -> bool {
    OF_MATERIALS.iter().any(|beginning| name.starts_with(beginning)) || OF_TEXTURES.contains(&name)
}

/// Names in a list of the document, each once; empty if it is missing.
fn names(root: &Value, key: &str) -> Result<Vec<String>, Defect> {
    let refused = || Defect::malformed(key, "is not a list of names");
    let list = match root.get(key) {
        None => return Ok(Vec::new()),
        Some(list) => list.as_array().ok_or_else(refused)?,
    };
    let mut names: Vec<String> = Vec::with_capacity(list.len());
    for name in list {
        let name = name.as_str().ok_or_else(refused)?;
        if !names.iter().any(|earlier| earlier == name) {
            names.push(name.to_owned());
        }
    }
    Ok(names)
}

/// Collects the names of extensions at any depth. `extras` belong to applications, so they are skipped.
fn collect<'a>(value: &'a Value, present: &mut BTreeSet<&'a str>) {
    match value {
        Value::Array(list) => list.iter().for_each(|value| collect(value, present)),
        Value::Object(members) => {
            if let Some(Value::Object(extensions)) = members.get("extensions") {
                present.extend(extensions.keys().map(String::as_str));
            }
            members.iter().filter(|(key, _)| *key != "extras").for_each(|(_, value)| collect(value, present));
        }
        _ => {}
    }
}
