//! Materials: constants that relate impulse, strain energy and threshold.

use super::names::{brief, nearest, toml_error};
use crate::elasticity::POISSON_MAX;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Text of the crate's table of materials.
pub const MATERIALS: &str = include_str!("../../materials.toml");

/// Range of all numbers of a material except Poisson's ratio, in their units; wider than that of any solid.
const POSSIBLE: std::ops::RangeInclusive<f64> = 1e-9..=1e18;

/// Key of the compressive strength.
const COMPRESSIVE: &str = "compressive_strength_pa";

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
    /// Toughness G_c, J/m²: the energy of a unit of crack area. `None` in materials of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toughness_j_m2: Option<f64>,
    /// Compressive strength σ_c, Pa; at least σ_t. `None` in materials of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compressive_strength_pa: Option<f64>,
    /// Weibull modulus of the strength. `None` in materials of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weibull_modulus: Option<f64>,
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
        let optional = |key, value: Option<f64>| value.map(|value| (key, value));
        let numbers = [
            Some(("young_pa", self.young_pa)),
            Some(("density_kg_m3", self.density_kg_m3)),
            Some(("strength_pa", self.strength_pa)),
            optional("toughness_j_m2", self.toughness_j_m2),
            optional(COMPRESSIVE, self.compressive_strength_pa),
            optional("weibull_modulus", self.weibull_modulus),
        ];
        let wrong = numbers.into_iter().flatten().find(|(_, value)| !POSSIBLE.contains(value));
        let is_solid = self.poisson > -1.0 && self.poisson <= POISSON_MAX;
        let weak = self.compressive_strength_pa.filter(|compressive_pa| *compressive_pa < self.strength_pa);
        let weak = weak.map(|value| (COMPRESSIVE, value));
        wrong.or((!is_solid).then_some(("poisson", self.poisson))).or(weak).map_or(Ok(()), Err)
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
        COMPRESSIVE => "1e-9 to 1e18, and at least strength_pa".to_owned(),
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
        for name in materials.names() {
            let material = materials.get(name).unwrap();
            let [toughness, compressive, modulus] =
                [material.toughness_j_m2, material.compressive_strength_pa, material.weibull_modulus]
                    .map(Option::unwrap);
            // The toughness K_c = √(E·G_c/(1 − ν²)) of brittle matter is 0.1 to 2 MPa·√m.
            let toughness_pa_m = (material.young_pa * toughness / (1.0 - material.poisson.powi(2))).sqrt();
            assert!((1e5..=2e6).contains(&toughness_pa_m), "{name}: {toughness_pa_m:e}");
            assert!((3.0..=25.0).contains(&(compressive / material.strength_pa)), "{name}");
            assert!((4.0..=20.0).contains(&modulus), "{name}");
            for symbol in ["G_c", "sigma_c", "Weibull"] {
                assert!(material.source.contains(symbol), "{name} has no source of {symbol}");
            }
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
        let text = text.replace("-1.0", "1.0");
        for (line, key) in [
            ("toughness_j_m2 = 0.0", "toughness_j_m2 must be positive"),
            ("weibull_modulus = nan", "weibull_modulus must be positive"),
            ("compressive_strength_pa = 0.5", "compressive_strength_pa must be 1e-9 to 1e18, and at least strength_pa"),
        ] {
            let error = Materials::parse(&format!("{text}{line}\n")).unwrap_err().to_string();
            assert!(error.contains(&format!("\"x\": {key}")), "{error}");
        }
    }

    #[test]
    fn tables_of_older_versions_are_read_and_written_without_the_new_numbers() {
        let text = "young_pa = 1.0\npoisson = 0.2\ndensity_kg_m3 = 1.0\nstrength_pa = 1.0\nsource = \"\"\n";
        let material: Material = toml::from_str(text).unwrap();
        assert_eq!(
            (material.toughness_j_m2, material.compressive_strength_pa, material.weibull_modulus),
            (None, None, None)
        );
        assert_eq!(toml::to_string(&material).unwrap(), text);
    }
}
