//! Elastic collision of two bodies in a point, by Hertz theory.
//!
//! Based on: K. L. Johnson, *Contact Mechanics* (1985), sections 4.2 (spheres at rest) and 11.4 (spheres that collide).
//!
//! The theory covers local deformation only: bodies are thick compared with the contact, and waves cross them in less than its duration.
//! Crushing of brittle bodies and plastic flow of metals make contacts longer and wider; the force is then larger here than in reality.

/// Duration of a collision divided by δ/v: 2∫₀¹ (1 − x^(5/2))^(-1/2) dx = 2√π Γ(7/5)/Γ(9/10).
pub const DURATION: f64 = 2.943_275_184_324_706;

/// An isotropic elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticMaterial {
    /// Young's modulus, Pa.
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl ElasticMaterial {
    /// Structural steel (EN 1993-1-1, 3.2.6).
    pub const STEEL: Self = Self { young_pa: 210e9, poisson: 0.3 };
    /// Concrete C30/37 (EN 1992-1-1, table 3.1).
    pub const CONCRETE: Self = Self { young_pa: 33e9, poisson: 0.2 };

    /// (1 − ν²)/E, 1/Pa.
    fn compliance(self) -> f64 {
        (1.0 - self.poisson * self.poisson) / self.young_pa
    }
}

/// One of two bodies in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactBody {
    /// Material of the body.
    pub material: ElasticMaterial,
    /// Mass, kg; infinite for a body that does not move.
    pub mass_kg: f64,
    /// Radius of its surface at the contact, m; infinite for a plane, negative for a concave surface.
    pub radius_m: f64,
}

impl ContactBody {
    /// A plane that does not move: floors and walls.
    pub fn ground(material: ElasticMaterial) -> Self {
        Self { material, mass_kg: f64::INFINITY, radius_m: f64::INFINITY }
    }
}

/// Reason why a contact has no duration and radius.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContactError {
    /// A Young's modulus or mass that is not positive, or a speed that is not positive and finite.
    #[error("{key}: {value} is not positive")]
    NotPositive {
        /// Name of the number.
        key: &'static str,
        /// The number.
        value: f64,
    },
    /// A Poisson's ratio outside of −1 to 1/2.
    #[error("poisson: {0} is not between -1 and 0.5")]
    Poisson(f64),
    /// Neither body moves.
    #[error("mass_kg: one of the two bodies must have a finite mass")]
    NoMass,
    /// Two planes, or a concave surface around a body that is not smaller, do not meet in a point.
    #[error(
        "radius_m: surfaces of radii {0} and {1} m do not meet in a point, so that Hertz theory has no contact for them; give one of them a finite radius, or set duration and radius of the contact yourself"
    )]
    NoPoint(f64, f64),
    /// The numbers are so large or small that a value of the contact would be zero or infinite.
    #[error(
        "speed_m_s, young_pa, mass_kg or radius_m: too large or too small, the contact would have the {key} {value}"
    )]
    Range {
        /// Name of the value of the contact.
        key: &'static str,
        /// The value.
        value: f64,
    },
}

/// Contact of two bodies in a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzContact {
    /// δ, the largest approach of the bodies, m.
    pub approach_m: f64,
    /// a, the radius of the contact area at the largest approach, m.
    pub radius_m: f64,
    /// F, the force at the largest approach, N.
    pub force_n: f64,
    /// τ, the duration from the first touch to the last, s.
    pub duration_s: f64,
}

impl HertzContact {
    /// Contact of two bodies whose centers approach each other at `speed_m_s` along the line between them. With 1/E* = Σ(1 − ν²)/E, 1/R =
    /// Σ1/r and 1/m* = Σ1/m:
    ///
    /// δ = (15 m* v² / (16 E* √R))^(2/5), a = √(R δ), F = 4/3 E* √R δ^(3/2), τ = [`DURATION`] · δ/v ≈ 2.87 (m*² / (R E*² v))^(1/5).
    ///
    /// The service applies half a period of a sine with the area of the impulse. Its peak is 15 % below F for a collision that loses no
    /// energy, and 57 % below F for bodies that stay together.
    ///
    /// # Errors
    /// [`ContactError`], by what is wrong.
    pub fn of(one: &ContactBody, other: &ContactBody, speed_m_s: f64) -> Result<Self, ContactError> {
        let inverse = 1.0 / positive("mass_kg", one.mass_kg)? + 1.0 / positive("mass_kg", other.mass_kg)?;
        if inverse == 0.0 {
            return Err(ContactError::NoMass);
        }
        Self::of_mass(one, other, speed_m_s, 1.0 / inverse)
    }

    /// Contact as [`Self::of`], for an effective mass other than that of a central collision: `impulse_ns` stopped `speed_m_s`, so m* =
    /// J/v. A body that is hit off-center turns away and counts as lighter. J/v is used only where it is less than the m* of [`Self::of`],
    /// because a simulator's resting contacts carry impulses at zero speed.
    ///
    /// # Errors
    /// [`ContactError`], by what is wrong.
    pub fn of_impulse(
        one: &ContactBody,
        other: &ContactBody,
        speed_m_s: f64,
        impulse_ns: f64,
    ) -> Result<Self, ContactError> {
        let seen = positive("impulse_ns", impulse_ns)? / finite("speed_m_s", speed_m_s)?;
        let inverse = 1.0 / positive("mass_kg", one.mass_kg)? + 1.0 / positive("mass_kg", other.mass_kg)?;
        Self::of_mass(one, other, speed_m_s, seen.min(1.0 / inverse))
    }

    /// The same with the effective mass m*, kg.
    fn of_mass(one: &ContactBody, other: &ContactBody, speed_m_s: f64, mass_kg: f64) -> Result<Self, ContactError> {
        let speed_m_s = finite("speed_m_s", speed_m_s)?;
        let mass_kg = finite("mass_kg", mass_kg)?;
        for ElasticMaterial { young_pa, poisson } in [one.material, other.material] {
            finite("young_pa", young_pa)?;
            if !(-1.0..=0.5).contains(&poisson) {
                return Err(ContactError::Poisson(poisson));
            }
        }
        let modulus_pa = 1.0 / (one.material.compliance() + other.material.compliance());
        let curvature = 1.0 / one.radius_m + 1.0 / other.radius_m;
        if !(curvature > 0.0 && curvature.is_finite()) {
            return Err(ContactError::NoPoint(one.radius_m, other.radius_m));
        }
        let radius_m = 1.0 / curvature;
        let stiffness = modulus_pa * radius_m.sqrt();
        let approach_m = (15.0 * mass_kg * speed_m_s * speed_m_s / (16.0 * stiffness)).powf(0.4);
        let in_range = |key, value: f64| match value.is_normal() {
            true => Ok(value),
            false => Err(ContactError::Range { key, value }),
        };
        Ok(Self {
            approach_m: in_range("approach", approach_m)?,
            radius_m: in_range("radius", (radius_m * approach_m).sqrt())?,
            force_n: in_range("force", 4.0 / 3.0 * stiffness * approach_m.powf(1.5))?,
            duration_s: in_range("duration", DURATION * approach_m / speed_m_s)?,
        })
    }
}

/// `value` if it is positive; it may be infinite.
fn positive(key: &'static str, value: f64) -> Result<f64, ContactError> {
    if value > 0.0 { Ok(value) } else { Err(ContactError::NotPositive { key, value }) }
}

/// `value` if it is positive and finite.
fn finite(key: &'static str, value: f64) -> Result<f64, ContactError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(ContactError::NotPositive { key, value }) }
}
