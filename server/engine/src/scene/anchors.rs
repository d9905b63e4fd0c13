//! Anchors of an object in a scene.

use super::names::known;
use super::{elements, invalid, unsuitable, wrong_type};
use nalgebra::Vector3;
use serde::Deserialize;
use shatter_fracture::scene::{Anchors, DEFAULT_GRAVITY_M_S2, Region};
use shatter_proto::Error;
use shatter_proto::effect::{Effect, Effects};

/// Keys of an anchor.
const KEYS: [&str; 4] = ["center", "radius_m", "min", "max"];

/// Largest component of the gravity, m/s².
const GRAVITY_MAX_M_S2: f64 = 1e6;

/// Values of an anchor's table, after the keys have been checked.
#[derive(Deserialize)]
struct Values {
    center: Option<[f64; 3]>,
    radius_m: Option<f64>,
    min: Option<[f64; 3]>,
    max: Option<[f64; 3]>,
}

/// Reads the anchors and gravity of the object at `path`, for the effects `allowed`.
///
/// Refuses anchors without the effect, and the effect without anchors.
pub(super) fn read(
    path: &str,
    values: &[toml::Value],
    gravity_m_s2: Option<[f64; 3]>,
    allowed: Effects,
) -> Result<Anchors, Error> {
    let at = |key: &str| format!("{path}.{key}");
    let regions = regions(&at("anchors"), values)?;
    let needs = |effect: Effect| {
        format!(
            "needs the effect `{0}`, which is off; add \"{0}\" to `effects` (on for every request) or to `allow` (on for \
         requests that enable it)",
            effect.name()
        )
    };
    if allowed.has(Effect::Anchored) && regions.is_empty() {
        return Err(invalid(at("anchors"), "the effect `anchored` needs at least one anchor"));
    }
    if !regions.is_empty() && !allowed.has(Effect::Anchored) {
        return Err(invalid(at("anchors"), needs(Effect::Anchored)));
    }
    if gravity_m_s2.is_some() && !allowed.has(Effect::Gravity) {
        return Err(invalid(at("gravity_m_s2"), needs(Effect::Gravity)));
    }
    let gravity_m_s2 = gravity_m_s2.unwrap_or(DEFAULT_GRAVITY_M_S2);
    if !gravity_m_s2.iter().all(|g| g.abs() <= GRAVITY_MAX_M_S2) {
        return Err(unsuitable(
            at("gravity_m_s2"),
            &format!("{gravity_m_s2:?}"),
            "a list of 3 numbers from -1e6 to 1e6",
        ));
    }
    let gravity_m_s2 = allowed.has(Effect::Gravity).then(|| Vector3::from(gravity_m_s2));
    Ok(Anchors { regions, gravity_m_s2 })
}

/// Reads the balls and boxes of the list at `path`.
pub(super) fn regions(path: &str, values: &[toml::Value]) -> Result<Vec<Region>, Error> {
    let tables: Vec<toml::Table> = elements(path, values)?;
    tables.iter().enumerate().map(|(number, table)| region(&format!("{path}[{number}]"), table)).collect()
}

/// Reads a ball or a box.
fn region(path: &str, table: &toml::Table) -> Result<Region, Error> {
    known(path, table.keys(), &KEYS)?;
    let values = toml::Value::Table(table.clone()).try_into();
    let values: Values = values.map_err(|error| wrong_type(path, &error, &[]))?;
    let numbers = [values.center, values.min, values.max].into_iter().flatten().flatten();
    if let Some(number) = numbers.chain(values.radius_m).find(|number| !number.is_finite()) {
        return Err(invalid(path, format!("has the number {number}; all numbers must be finite")));
    }
    match values {
        Values { center: Some(center), radius_m: Some(radius_m), min: None, max: None } => {
            let positive = radius_m > 0.0;
            let ball = Region::Ball { center_m: center.into(), radius_m };
            let key = || format!("{path}.radius_m");
            positive.then_some(ball).ok_or_else(|| unsuitable(key(), &radius_m.to_string(), "a number above 0"))
        }
        Values { center: None, radius_m: None, min: Some(min), max: Some(max) } => {
            let ordered = min.iter().zip(&max).all(|(min, max)| min < max);
            let cuboid = Region::Cuboid { min_m: min.into(), max_m: max.into() };
            ordered
                .then_some(cuboid)
                .ok_or_else(|| invalid(format!("{path}.max"), "must be above `min` along every axis"))
        }
        _ => Err(invalid(path, "must be either a ball (`center` and `radius_m`) or a box (`min` and `max`)")),
    }
}
