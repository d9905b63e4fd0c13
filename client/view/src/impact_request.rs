//! Requests of the page as impacts of the client.

use serde_json::{Map, Value};
use shatter_client::{Contact, DegreeRule, Effect, Impact, Lift, Quality, RequestedSurface};
use shatter_proto::{Error, ErrorKind};

/// Keys of a request that describe an impact.
const KEYS: [&str; 13] = [
    "contacts",
    "degree",
    "lift",
    "quality",
    "surface",
    "enable",
    "disable",
    "seed",
    "error",
    "time_ms",
    "keep",
    "from",
    "gamma_j_m2",
];

/// An error of the request's text.
pub(crate) fn invalid(at: &str, what: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::UnknownRequest, at, format!("`{at}` of the request: {what}"))
}

/// Reads the impact of a request.
///
/// # Errors
/// `unknown_request` for a key or a value that does not fit; `degree`, `lift`, `budget`, `unknown_effect` for unknown names.
pub(crate) fn impact(value: &Value) -> Result<Impact, Error> {
    let object = value.as_object().ok_or_else(|| invalid("impact", "must be an object"))?;
    if let Some(unknown) = object.keys().find(|key| !KEYS.contains(&key.as_str())) {
        return Err(invalid(unknown, format!("unknown; possible keys are {}", KEYS.join(", "))));
    }
    let contacts = object.get("contacts").and_then(Value::as_array);
    let contacts = contacts.ok_or_else(|| invalid("contacts", "must be a list"))?;
    let contacts = contacts.iter().map(contact).collect::<Result<Vec<_>, _>>()?;
    let mut impact = Impact::new(contacts);
    if let Some(rule) = object.get("degree") {
        impact = impact.degree(degree(rule)?);
    }
    if let Some(name) = text(object, "lift")? {
        impact = impact.lift(lift(name)?);
    }
    if let Some(name) = text(object, "quality")? {
        impact = impact.quality(Quality::by_name(name)?);
    }
    if let Some(name) = text(object, "surface")? {
        let surface = RequestedSurface::ALL.into_iter().find(|own| own.name() == name);
        impact = impact.surface(surface.ok_or_else(|| invalid("surface", "must be `exact` or `lattice`"))?);
    }
    for effect in effects(value, "enable")? {
        impact = impact.enable(effect);
    }
    for effect in effects(value, "disable")? {
        impact = impact.disable(effect);
    }
    if let Some(seed) = object.get("seed") {
        impact = impact.seed(whole(seed, "seed")?);
    }
    if let Some(error) = number(object, "error")? {
        impact = impact.error(error);
    }
    if let Some(time_ms) = number(object, "time_ms")? {
        impact = impact.time_ms(time_ms);
    }
    if let Some(gamma) = number(object, "gamma_j_m2")? {
        impact = impact.gamma(gamma);
    }
    if object.get("keep").and_then(Value::as_bool) == Some(true) {
        impact = impact.keep();
    }
    match object.get("from") {
        None => Ok(impact),
        Some(from) => {
            let (handle, fragment) = origin(from)?;
            Ok(impact.from(handle, fragment))
        }
    }
}

fn contact(value: &Value) -> Result<Contact, Error> {
    let object = value.as_object().ok_or_else(|| invalid("contacts", "must be a list of objects"))?;
    let keys = ["point_m", "ray", "impulse_ns", "impulse_along_ray_ns", "radius_m", "duration_s"];
    if let Some(unknown) = object.keys().find(|key| !keys.contains(&key.as_str())) {
        return Err(invalid(unknown, format!("unknown; possible keys are {}", keys.join(", "))));
    }
    let point = object.get("point_m").ok_or_else(|| invalid("point_m", "missing"))?;
    let mut contact = Contact::new(vector(point, "point_m")?);
    if let Some(ray) = object.get("ray") {
        contact = contact.ray(vector(ray, "ray")?);
    }
    if let Some(impulse) = object.get("impulse_ns") {
        contact = contact.impulse(vector(impulse, "impulse_ns")?);
    }
    if let Some(impulse) = number(object, "impulse_along_ray_ns")? {
        contact = contact.impulse_along_ray(impulse);
    }
    if let Some(radius_m) = number(object, "radius_m")? {
        contact = contact.radius(radius_m);
    }
    if let Some(duration_s) = number(object, "duration_s")? {
        contact = contact.duration(duration_s);
    }
    Ok(contact)
}

fn number(object: &Map<String, Value>, key: &str) -> Result<Option<f64>, Error> {
    let read = |value: &Value| value.as_f64().ok_or_else(|| invalid(key, "must be a number"));
    object.get(key).map(read).transpose()
}

fn text<'a>(object: &'a Map<String, Value>, key: &str) -> Result<Option<&'a str>, Error> {
    let read = |value: &'a Value| value.as_str().ok_or_else(|| invalid(key, "must be a text"));
    object.get(key).map(read).transpose()
}

/// Three numbers.
fn vector(value: &Value, at: &str) -> Result<[f64; 3], Error> {
    let numbers: Option<Vec<f64>> = value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    let numbers = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    numbers.ok_or_else(|| invalid(at, "must be a list of three numbers"))
}

/// A whole number: as a number, or as text, because numbers of JavaScript are exact up to 2⁵³ only.
fn whole(value: &Value, at: &str) -> Result<u64, Error> {
    let parsed = value.as_u64().or_else(|| value.as_str().and_then(|text| text.parse().ok()));
    parsed.ok_or_else(|| invalid(at, "must be a whole number of at least 0"))
}

/// Handle and fragment.
fn origin(value: &Value) -> Result<(u64, u32), Error> {
    let Some([handle, fragment]) = value.as_array().map(Vec::as_slice) else {
        return Err(invalid("from", "must be a list of a handle and a fragment"));
    };
    let fragment = u32::try_from(whole(fragment, "from")?).map_err(|_| invalid("from", "no fragment has this id"))?;
    Ok((whole(handle, "from")?, fragment))
}

/// The effects that a request lists under `key`.
///
/// # Errors
/// `unknown_request` for a value that is no list of names, `unknown_effect`.
pub(crate) fn effects(request: &Value, key: &str) -> Result<Vec<Effect>, Error> {
    let Some(value) = request.get(key) else { return Ok(Vec::new()) };
    let names: Option<Vec<&str>> = value.as_array().and_then(|list| list.iter().map(Value::as_str).collect());
    let names = names.ok_or_else(|| invalid(key, "must be a list of names"))?;
    names.into_iter().map(Effect::by_name).collect()
}

fn degree(value: &Value) -> Result<DegreeRule, Error> {
    match value.as_str() {
        Some("inferred") => return Ok(DegreeRule::Inferred),
        Some("verified") => return Ok(DegreeRule::Verified),
        Some("closed_form") => return Ok(DegreeRule::ClosedForm),
        Some("optimised") => return Ok(DegreeRule::Optimized),
        _ => {}
    }
    let sites = value.as_u64().and_then(|sites| u32::try_from(sites).ok());
    let message = "must be a number of sites, or `inferred`, `verified`, `closed_form`, `optimised`";
    sites.map(DegreeRule::Sites).ok_or_else(|| invalid("degree", message))
}

fn lift(name: &str) -> Result<Lift, Error> {
    match name {
        "euclidean" => Ok(Lift::Euclidean),
        "interior" => Ok(Lift::Interior),
        "surface_diffusion" => Ok(Lift::SurfaceDiffusion),
        _ => Err(invalid("lift", "must be `euclidean`, `interior` or `surface_diffusion`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_request_becomes_the_same_impact_as_in_rust() {
        let request = json!({
            "contacts": [{"point_m": [0, 0.05, 1], "ray": [0, 0, -1], "impulse_along_ray_ns": 2, "radius_m": 0.01}],
            "seed": "18446744073709551615", "quality": "draft", "lift": "euclidean", "degree": 4, "keep": true,
            "enable": ["bonds"], "from": ["9", 3], "surface": "lattice",
        });
        let contact = Contact::new([0.0, 0.05, 1.0]).ray([0.0, 0.0, -1.0]).impulse([0.0, 0.0, -2.0]).radius(0.01);
        let wanted = Impact::new([contact]).seed(u64::MAX).quality(Quality::Draft).lift(Lift::Euclidean).keep();
        let wanted = wanted.degree(DegreeRule::Sites(4)).enable(Effect::Bonds).from(9, 3);
        assert_eq!(impact(&request).unwrap(), wanted.surface(RequestedSurface::Lattice));
    }

    #[test]
    fn what_does_not_fit_is_named() {
        for (request, at) in [
            (json!({}), "contacts"),
            (json!({"contacts": [], "speed": 1}), "speed"),
            (json!({"contacts": [{"point_m": [0, 0]}]}), "point_m"),
            (json!({"contacts": [], "seed": -1}), "seed"),
            (json!({"contacts": [], "from": ["x", 1]}), "from"),
            (json!({"contacts": [], "enable": ["bond"]}), "bond"),
            (json!({"contacts": [], "lift": "flat"}), "lift"),
        ] {
            assert_eq!(impact(&request).unwrap_err().at, at, "{request}");
        }
    }
}
