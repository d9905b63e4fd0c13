//! Constants of a material that decide when it breaks.

use crate::scene::Material;
use std::f64::consts::PI;

/// Toughness K_c, Pa·√m, of a material without any: that of common silicates.
const TOUGHNESS_ASSUMED: f64 = 1e6;

/// Compressive over tensile strength of a material without a compressive one.
const COMPRESSIVE_RATIO_ASSUMED: f64 = 10.0;

/// Weibull modulus of a material without one.
const WEIBULL_ASSUMED: f64 = 10.0;

/// Source of the constants that materials of older versions lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ConstantsOrigin {
    /// The material has all of them.
    Material,
    /// The material of the same name in the table that comes with the crate.
    Name,
    /// Typical values of brittle matter.
    Assumed,
}

impl ConstantsOrigin {
    /// The source in words.
    #[must_use]
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Material => "as baked",
            Self::Name => "not in the database: those of the material of that name",
            Self::Assumed => {
                "not in the database: typical ones, K_c = 1 MPa·√m, ten times the tensile strength, modulus 10"
            }
        }
    }
}

/// Constants of the criterion by strength and energy. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthConstants {
    /// Young's modulus E, Pa.
    pub young_pa: f64,
    /// Poisson's ratio ν.
    pub poisson: f64,
    /// Tensile strength σ_t, Pa.
    pub strength_pa: f64,
    /// Compressive strength σ_c, Pa.
    pub compressive_strength_pa: f64,
    /// Toughness G_c, J/m².
    pub toughness_j_m2: f64,
    /// Weibull modulus of the strength.
    pub weibull_modulus: f64,
    /// Source of the last three; the least certain one.
    pub origin: ConstantsOrigin,
}

impl StrengthConstants {
    /// Constants of `material`, called `name`.
    ///
    /// What the material lacks is that of the shipped material of that name, or else assumed.
    pub fn of(name: &str, material: &Material) -> Self {
        let named = std::cell::LazyCell::new(|| Material::named(name).ok());
        let mut origin = ConstantsOrigin::Material;
        let mut pick = |own: fn(&Material) -> Option<f64>, assumed: f64| {
            let (value, source) = match (own(material), named.as_ref().and_then(own)) {
                (Some(value), _) => (value, ConstantsOrigin::Material),
                (None, Some(value)) => (value, ConstantsOrigin::Name),
                (None, None) => (assumed, ConstantsOrigin::Assumed),
            };
            origin = origin.max(source);
            value
        };
        let Material { young_pa, poisson, strength_pa, .. } = *material;
        let toughness_assumed = TOUGHNESS_ASSUMED.powi(2) * (1.0 - poisson * poisson) / young_pa;
        let toughness_j_m2 = pick(|own| own.toughness_j_m2, toughness_assumed);
        let compressive = pick(|own| own.compressive_strength_pa, COMPRESSIVE_RATIO_ASSUMED * strength_pa);
        let weibull_modulus = pick(|own| own.weibull_modulus, WEIBULL_ASSUMED);
        // That of the name may be below the own tensile strength.
        let compressive_strength_pa = compressive.max(strength_pa);
        Self { young_pa, poisson, strength_pa, compressive_strength_pa, toughness_j_m2, weibull_modulus, origin }
    }

    /// Constants of a material that withstands `scale` times the load, of bodies of every size.
    ///
    /// Strengths grow with `scale`, the toughness G_c with its square, as the elastic energy. ℓ_c stays.
    #[must_use]
    pub fn scaled(self, scale: f64) -> Self {
        Self {
            strength_pa: scale * self.strength_pa,
            compressive_strength_pa: scale * self.compressive_strength_pa,
            toughness_j_m2: scale * scale * self.toughness_j_m2,
            ..self
        }
    }

    /// Characteristic length ℓ_c = E·G_c/(π σ_t²), m: cracks shorter than about this do not lower the strength.
    ///
    /// Source: D. Taylor, *The Theory of Critical Distances* (2007), section 2.2.
    pub fn characteristic_length_m(&self) -> f64 {
        self.young_pa * self.toughness_j_m2 / (PI * self.strength_pa * self.strength_pa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_constants_are_those_of_the_name_or_assumed() {
        let glass = Material::named("glass").unwrap();
        let own = StrengthConstants::of("glass", &glass);
        assert_eq!((own.origin, own.toughness_j_m2), (ConstantsOrigin::Material, 7.9));
        let old = Material {
            toughness_j_m2: None,
            compressive_strength_pa: None,
            weibull_modulus: Some(6.0),
            ..glass.clone()
        };
        let named = StrengthConstants::of("glass", &old);
        assert_eq!((named.origin, named.toughness_j_m2, named.weibull_modulus), (ConstantsOrigin::Name, 7.9, 6.0));
        let assumed = StrengthConstants::of("bottle", &old);
        assert_eq!((assumed.origin, assumed.compressive_strength_pa), (ConstantsOrigin::Assumed, 4.5e8));
        assert!((assumed.toughness_j_m2 - 1e12 * (1.0 - 0.22 * 0.22) / 7e10).abs() < 1e-9);
        let strong = Material { strength_pa: 2e9, ..old };
        assert_eq!(StrengthConstants::of("glass", &strong).compressive_strength_pa, 2e9);
    }

    #[test]
    fn characteristic_lengths_are_those_of_the_formula() {
        let length =
            |name: &str| StrengthConstants::of(name, &Material::named(name).unwrap()).characteristic_length_m();
        assert!((length("glass") - 86.9e-6).abs() < 0.1e-6, "{}", length("glass"));
        let concrete = StrengthConstants::of("concrete", &Material::named("concrete").unwrap());
        let scaled = concrete.scaled(3.0);
        assert!((scaled.characteristic_length_m() / concrete.characteristic_length_m() - 1.0).abs() < 1e-12);
        assert_eq!(scaled.compressive_strength_pa, 3.0 * concrete.compressive_strength_pa);
        assert!((length("concrete") - 51.2e-3).abs() < 0.1e-3, "{}", length("concrete"));
    }
}
