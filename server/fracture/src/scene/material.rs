//! Materials: the numbers that turn an impulse into strain energy and strain energy into a threshold.

use super::names::{brief, nearest, toml_error};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The table of materials that comes with the crate, as text.
pub const MATERIALS: &str = include_str!("../../materials.toml");

/// What every number of a material but Poisson's ratio lies in, in its unit: no solid is beyond.
const POSSIBLE: std::ops::RangeInclusive<f64> = 1e-9..=1e18;

/// A homogeneous isotropic brittle material. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E, Pa; positive.
    pub young_pa: f64,
    /// Poisson's ratio ν; the range that the element handles is checked where it is used.
    pub poisson: f64,
    /// Density ρ, kg/m³; positive.
    pub density_kg_m3: f64,
    /// Tensile strength σ_t, Pa; positive.
    pub strength_pa: f64,
    /// Where the numbers come from.
    pub source: String,
}

impl Material {
    /// The material of that name in the table that comes with the crate, [`MATERIALS`].
    ///
    /// # Errors
    /// [`MaterialError::Unknown`], which names the nearest one.
    pub fn named(name: &str) -> Result<Self, MaterialError> {
        Materials::parse(MATERIALS)?.get(name).cloned()
    }

    /// Whether every number is possible; if not, the first key that is not, and its value.
    pub fn check(&self) -> Result<(), (&'static str, f64)> {
        let numbers =
            [("young_pa", self.young_pa), ("density_kg_m3", self.density_kg_m3), ("strength_pa", self.strength_pa)];
        numbers.into_iter().find(|(_, value)| !POSSIBLE.contains(value)).map_or(Ok(()), Err)
    }
}

/// What is wrong with a table of materials; the caller's fault, no use to retry.
#[derive(Debug, thiserror::Error)]
pub enum MaterialError {
    /// Not TOML, or a key too many or too few.
    #[error("materials cannot be read: {0}")]
    Unreadable(String),
    /// A number outside its range.
    #[error("material \"{material}\": {key} must be positive, 1e-9 to 1e18, got {value:e}")]
    NotPositive {
        /// The material's name.
        material: String,
        /// The offending key.
        key: &'static str,
        /// What it was.
        value: f64,
    },
    /// No material of this name.
    #[error("no material \"{name}\"; nearest is \"{nearest}\"; known: {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// The known name with the smallest edit distance.
        nearest: String,
        /// All names, comma-separated.
        known: String,
    },
}

/// Materials by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Materials(BTreeMap<String, Material>);

impl Materials {
    /// Reads a TOML text of one table per material and checks every number.
    pub fn parse(text: &str) -> Result<Self, MaterialError> {
        let unreadable = |error| MaterialError::Unreadable(toml_error(text, &error));
        let table: BTreeMap<String, Material> = toml::from_str(text).map_err(unreadable)?;
        for (name, material) in &table {
            let wrong = |(key, value)| MaterialError::NotPositive { material: brief(name), key, value };
            material.check().map_err(wrong)?;
        }
        Ok(Self(table))
    }

    /// The material called `name`, or an error that names the nearest one.
    pub fn get(&self, name: &str) -> Result<&Material, MaterialError> {
        self.0.get(name).ok_or_else(|| MaterialError::Unknown {
            name: name.to_owned(),
            nearest: nearest(name, self.names()).unwrap_or_default().to_owned(),
            known: brief(&self.names().collect::<Vec<_>>().join(", ")),
        })
    }

    /// Names in order.
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
    }

    #[test]
    fn numbers_out_of_range_and_unknown_keys_are_refused_by_name() {
        let text = "[x]\nyoung_pa = -1.0\npoisson = 0.2\ndensity_kg_m3 = 1.0\nstrength_pa = 1.0\nsource = \"\"\n";
        let error = Materials::parse(text).unwrap_err().to_string();
        assert!(error.contains("young_pa") && error.contains("\"x\""), "{error}");
        let error = Materials::parse(&format!("{text}color = 1\n")).unwrap_err().to_string();
        assert!(error.contains("color"), "{error}");
    }
}
