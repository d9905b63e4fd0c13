//! References between materials, textures, samplers and images.

use super::{Defect, whole};
use serde_json::Value;
use std::collections::BTreeSet;

/// Place of a transformation, which can name another set of texture coordinates.
const TRANSFORM: &str = "/extensions/KHR_texture_transform";

/// Refuses references to textures, samplers and images that do not exist.
pub(super) fn check(materials: &[Value], textures: &[Value], samplers: usize, images: usize) -> Result<(), Defect> {
    for (index, texture) in textures.iter().enumerate() {
        let place = format!("texture {index}");
        exists(texture, "sampler", samplers, &place)?;
        exists(texture, "source", images, &place)?;
        // An extension names an image in another format.
        for extension in texture.get("extensions").and_then(Value::as_object).iter().flat_map(|all| all.values()) {
            exists(extension, "source", images, &place)?;
        }
    }
    let check = |(index, material)| of_material(material, textures.len(), &format!("material {index}"));
    materials.iter().enumerate().try_for_each(check)
}

/// Checks the textures of a material, and of its extensions: members whose names end with `Texture`.
fn of_material(value: &Value, textures: usize, place: &str) -> Result<(), Defect> {
    let Some(members) = value.as_object() else { return Ok(()) };
    for (key, member) in members.iter().filter(|(key, _)| *key != "extras") {
        if key.ends_with("Texture") {
            let place = format!("{place}, {key}");
            exists(member, "index", textures, &place)?;
            whole(member, "texCoord", &place)?;
            if let Some(transform) = member.pointer(TRANSFORM) {
                whole(transform, "texCoord", &place)?;
            }
        }
        of_material(member, textures, place)?;
    }
    Ok(())
}

/// Adds the sets of texture coordinates of a material and of its extensions. The material has been checked.
pub(super) fn texture_sets(value: &Value, sets: &mut BTreeSet<usize>) {
    for (key, member) in value.as_object().into_iter().flatten().filter(|(key, _)| *key != "extras") {
        if key.ends_with("Texture") {
            let own = member.pointer(TRANSFORM).and_then(|transform| transform.get("texCoord"));
            let set = own.or_else(|| member.get("texCoord")).and_then(Value::as_u64).unwrap_or(0);
            sets.insert(usize::try_from(set).unwrap_or(usize::MAX));
        }
        texture_sets(member, sets);
    }
}

/// Refuses an index beyond a list of so many elements.
fn exists(object: &Value, key: &str, count: usize, place: &str) -> Result<(), Defect> {
    match whole(object, key, place)? {
        Some(index) if index >= count => {
            Err(Defect::malformed(place, format!("its {key} is {index}, but there are {count} of them")))
        }
        _ => Ok(()),
    }
}
