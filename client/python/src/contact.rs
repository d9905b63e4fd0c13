//! Durations and radii of collisions, by Hertz theory.

use crate::argument::{self, Body};
use crate::error::wrong;
use pyo3::prelude::*;
use shatter_export::contact::{self, ContactBody, ContactError, ElasticMaterial};
use shatter_proto::text::number;

/// Contact of two bodies in a point, by Hertz theory.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Hertz {
    approach_m: f64,
    radius_m: f64,
    force_n: f64,
    duration_s: f64,
}

/// Computes duration and radius of an elastic contact by Hertz theory (Johnson, *Contact Mechanics*, 1985, 11.4).
///
/// A body is its mass (kg, ``inf`` for a floor), radius at the contact (m, ``inf`` for a plane), Young's modulus (Pa) and Poisson's ratio;
/// :class:`Facts` has the moduli of objects. With ``impulse_ns`` the effective mass is at most the one that the impulse stops.
#[pyfunction]
#[pyo3(signature = (one, other, speed_m_s, *, impulse_ns = None))]
pub fn hertz(
    #[pyo3(from_py_with = argument::one)] one: Body,
    #[pyo3(from_py_with = argument::other)] other: Body,
    speed_m_s: f64,
    impulse_ns: Option<f64>,
) -> PyResult<Hertz> {
    let partner = |(mass_kg, radius_m, young_pa, poisson): Body| ContactBody {
        material: ElasticMaterial { young_pa, poisson },
        mass_kg,
        radius_m,
    };
    let (one, other) = (partner(one), partner(other));
    let found = match impulse_ns {
        Some(impulse_ns) => contact::HertzContact::of_impulse(&one, &other, speed_m_s, impulse_ns),
        None => contact::HertzContact::of(&one, &other, speed_m_s),
    };
    let contact::HertzContact { approach_m, radius_m, force_n, duration_s } =
        found.map_err(|error| wrong(refusal(error, one.mass_kg.min(other.mass_kg))))?;
    Ok(Hertz { approach_m, radius_m, force_n, duration_s })
}

/// Message of `error`, with the given numbers; `mass_kg` is the smaller mass.
fn refusal(error: ContactError, mass_kg: f64) -> String {
    match error {
        // The effective mass vanished, which was not given.
        ContactError::NotPositive { key: "mass_kg", value } if value == 0.0 && mass_kg > 0.0 => {
            let mass = number(mass_kg);
            format!("mass_kg: {mass} is too small, or speed_m_s too large for impulse_ns: the effective mass is 0")
        }
        ContactError::NotPositive { key, value } => format!("{key}: {} is not positive", number(value)),
        error => error.to_string(),
    }
}
