//! Materials: constants that relate impulse, strain energy and threshold.

use super::names::{brief, nearest, toml_error};
use crate::elasticity::POISSON_MAX;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Text of the crate's table of materials.
pub const MATERIALS: &str = include_str!("../../materials.toml");

/// Range of all numbers of a material except Poisson's ratio, in their units; wider than that of any solid.
const POSSIBLE: std::ops::RangeInclusive<f64> = 1e-9..=1e18;

/// A homogeneous isotropic brittle material. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E, Pa; positive.
    pub young_pa: f64,
    /// Poisson's ratio ν; the elasticity checks its range.
    pub poisson: f64,
    /// Density ρ, kg/m³; positive.
    pub density_kg_m3: f64,
    /// Tensile strength σ_t, Pa; positive.
    pub strength_pa: f64,
    /// Source of the numbers.
    pub source: String,
}

impl Material {
    /// The material of that name in the table that comes with the crate, [`MATERIALS`].
    ///
    /// # Errors
    /// [`MaterialError::Unknown`], which names all materials.
    pub fn named(name: &str) -> Result<Self, MaterialError> {
        Materials::parse(MATERIALS)?.get(name).cloned()
    }

    /// Checks the range of every number; returns the first invalid key and its value.
    ///
    /// # Errors
    /// The first key whose value is not possible, and that value.
    pub fn check(&self) -> Result<(), (&'static str, f64)> {
        let numbers =
            [("young_pa", self.young_pa), ("density_kg_m3", self.density_kg_m3), ("strength_pa", self.strength_pa)];
        let wrong = numbers.into_iter().find(|(_, value)| !POSSIBLE.contains(value));
        let is_solid = self.poisson > -1.0 && self.poisson <= POISSON_MAX;
        wrong.or((!is_solid).then_some(("poisson", self.poisson))).map_or(Ok(()), Err)
    }
}

/// Errors of a table of materials. The caller is at fault; a retry does not help.
#[derive(thiserror::Error)]
pub enum MaterialError {
    /// The text is not valid TOML, or has unknown or missing keys.
    #[error("materials cannot be read: {0}")]
    Unreadable(String),
    /// A number is outside its range.
    #[error("material \"{material}\": {key} must be {}, got {value:e}", possible(key))]
    OutOfRange {
        /// Name of the material.
        material: String,
        /// The offending key.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// No material has the requested name.
    #[error("no material \"{name}\"; {}known: {known}", nearest.as_ref().map_or(String::new(), |nearest| format!("nearest is \"{nearest}\"; ")))]
    Unknown {
        /// Requested name.
        name: String,
        /// Known name with the smallest edit distance, if one is similar.
        nearest: Option<String>,
        /// All names, comma-separated.
        known: String,
    },
}

/// Possible values of a number, in words.
fn possible(key: &str) -> String {
    match key {
        "poisson" => format!("above -1, and at most {POISSON_MAX}, since linear tetrahedra are too stiff beyond"),
        _ => "positive, 1e-9 to 1e18".to_owned(),
    }
}

/// Materials by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Materials(BTreeMap<String, Material>);

impl Materials {
    /// Reads a TOML text with one table per material and checks every number.
    ///
    /// # Errors
    /// [`MaterialError`]: a text that is no such table, or an impossible number.
    pub fn parse(text: &str) -> Result<Self, MaterialError> {
        let unreadable = |error| MaterialError::Unreadable(toml_error(text, &error, &[]));
        let table: BTreeMap<String, Material> = toml::from_str(text).map_err(unreadable)?;
        for (name, material) in &table {
            let wrong = |(key, value)| MaterialError::OutOfRange { material: brief(name), key, value };
            material.check().map_err(wrong)?;
        }
        Ok(Self(table))
    }

    /// The material called `name`, or an error with the nearest known name.
    ///
    /// # Errors
    /// [`MaterialError`] for an unknown name.
    pub fn get(&self, name: &str) -> Result<&Material, MaterialError> {
        self.0.get(name).ok_or_else(|| MaterialError::Unknown {
            name: brief(name),
            nearest: nearest(name, self.names()).map(str::to_owned),
            known: brief(&self.names().collect::<Vec<_>>().join(", ")),
        })
    }

    /// Names in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_materials_are_valid_and_carry_sources() {
        let materials = Materials::parse(MATERIALS).unwrap();
        for name in ["glass", "ceramic", "stone", "concrete", "plaster", "ice"] {
            let material = materials.get(name).unwrap();
            assert!(material.source.len() > 20 && (0.0..=0.45).contains(&material.poisson), "{name}");
        }
    }

    #[test]
    fn an_unknown_material_is_refused_with_the_nearest() {
        let error = Materials::parse(MATERIALS).unwrap().get("plastre").unwrap_err().to_string();
        assert!(error.contains("nearest is \"plaster\""), "{error}");
        let error = Materials::parse(MATERIALS).unwrap().get("oak").unwrap_err().to_string();
        assert!(error.starts_with("no material \"oak\"; known: ceramic, concrete,"), "{error}");
    }

    #[test]
    fn numbers_out_of_range_and_unknown_keys_are_refused_by_name() {
        let text = "[x]\nyoung_pa = -1.0\npoisson = 0.2\ndensity_kg_m3 = 1.0\nstrength_pa = 1.0\nsource = \"\"\n";
        let error = Materials::parse(text).unwrap_err().to_string();
        assert!(error.contains("young_pa") && error.contains("\"x\""), "{error}");
        for poisson in ["0.46", "0.5", "-1.0", "nan"] {
            let text = text.replace("-1.0", "1.0").replace("poisson = 0.2", &format!("poisson = {poisson}"));
            let error = Materials::parse(&text).unwrap_err().to_string();
            assert!(error.contains("\"x\": poisson must be above -1, and at most 0.45"), "{error}");
        }
        let error = Materials::parse(&format!("{text}color = 1\n")).unwrap_err().to_string();
        assert!(error.contains("color"), "{error}");
    }
}
