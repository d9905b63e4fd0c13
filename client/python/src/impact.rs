//! Impacts from keyword arguments.

use crate::argument;
use crate::error::{raised, wrong};
use crate::result::FragmentOfResult;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString, PyTuple};
use shatter_client::{
    ContactPartner as Striker, DisplacementSource, Effect, Impact, Lift, Quality, RequestedCriterion, RequestedSurface,
};
use shatter_proto::name::{nearest, suggestion};
use shatter_proto::text::quoted;
use std::time::Duration;

/// Body that strikes an object at a contact, and how fast.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct ContactPartner {
    mass_kg: f64,
    speed: f64,
    id: u64,
    center: [f64; 3],
    inertia: [f64; 6],
}

#[pymethods]
impl ContactPartner {
    #[new]
    #[pyo3(signature = (mass_kg, speed, *, id = 0, center = None, inertia = None))]
    fn new(
        #[pyo3(from_py_with = argument::mass_kg)] mass_kg: f64,
        #[pyo3(from_py_with = argument::speed)] speed: f64,
        #[pyo3(from_py_with = argument::partner_id)] id: u64,
        #[pyo3(from_py_with = argument::center)] center: Option<[f64; 3]>,
        #[pyo3(from_py_with = argument::inertia)] inertia: Option<[f64; 6]>,
    ) -> Self {
        Self { mass_kg, speed, id, center: center.unwrap_or_default(), inertia: inertia.unwrap_or_default() }
    }

    fn __repr__(&self) -> String {
        format!("ContactPartner(mass_kg={}, speed={}, id={})", self.mass_kg, self.speed, self.id)
    }
}

impl From<&ContactPartner> for Striker {
    fn from(given: &ContactPartner) -> Self {
        Self::new(given.id, given.mass_kg, given.speed).rotating(given.center, given.inertia)
    }
}

/// One contact of an impact: point, impulse, duration, radius.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Contact {
    point: [f64; 3],
    impulse: [f64; 3],
    duration_s: Option<f64>,
    radius: Option<f64>,
    ray: Option<[f64; 3]>,
    partner: Option<Py<ContactPartner>>,
}

#[pymethods]
impl Contact {
    #[new]
    #[pyo3(
        signature = (point, impulse, *, duration_s = None, radius = None, ray = None, partner = None, **unknown),
        text_signature = "(point, impulse, *, duration_s=None, radius=None, ray=None, partner=None)"
    )]
    fn new(
        #[pyo3(from_py_with = argument::point)] point: [f64; 3],
        #[pyo3(from_py_with = argument::impulse)] impulse: [f64; 3],
        duration_s: Option<f64>,
        radius: Option<f64>,
        #[pyo3(from_py_with = argument::ray)] ray: Option<[f64; 3]>,
        partner: Option<Py<ContactPartner>>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        match unknown.and_then(|unknown| unknown.keys().get_item(0).ok()) {
            Some(name) => Err(no_argument(&name.to_string())),
            None => Ok(Self { point, impulse, duration_s, radius, ray, partner }),
        }
    }

    fn __repr__(&self) -> String {
        format!("Contact(point={:?}, impulse={:?})", self.point, self.impulse)
    }
}

/// Error for an unknown keyword of [`Contact`].
fn no_argument(name: &str) -> PyErr {
    let likely = suggestion(name, &["point", "impulse", "duration_s", "radius", "ray", "partner"]);
    PyTypeError::new_err(format!("Contact() has no argument '{}'; {likely}", quoted(name)))
}

/// An impact with these contacts.
///
/// # Errors
/// `TypeError` for anything else than contacts, `ArgumentError` without any.
pub fn at(contacts: &[Bound<'_, PyAny>]) -> PyResult<Impact> {
    let read = |given: &Bound<'_, PyAny>| match given.cast::<Contact>() {
        Ok(contact) => Ok(shatter_client::Contact::from(contact.get())),
        Err(_) => Err(no_contact(given)),
    };
    let contacts: Vec<shatter_client::Contact> = contacts.iter().map(read).collect::<PyResult<_>>()?;
    match contacts.is_empty() {
        true => Err(wrong("an impact needs at least one Contact")),
        false => Ok(Impact::new(contacts)),
    }
}

/// Error for an argument that is not a contact.
fn no_contact(given: &Bound<'_, PyAny>) -> PyErr {
    let kind = given.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    let list = if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
        "; write an asterisk before a sequence of contacts: strike(*contacts)"
    } else {
        ""
    };
    PyTypeError::new_err(format!("contacts are of the type shatter.Contact, not {}{list}", quoted(&kind)))
}

impl From<&Contact> for shatter_client::Contact {
    fn from(given: &Contact) -> Self {
        let contact = Self::new(given.point).impulse(given.impulse);
        let contact = given.ray.map_or(contact, |direction| contact.ray(direction));
        let contact = given.duration_s.map_or(contact, |duration_s| contact.duration(duration_s));
        let contact = given.radius.map_or(contact, |radius| contact.radius(radius));
        Self { partner: given.partner.as_ref().map(|partner| partner.get().into()), ..contact }
    }
}

/// A number of sites, or the rule that sets it.
pub struct Degree(shatter_client::DegreeRule);

impl Degree {
    /// The argument `degree` of an object that takes `sites_max` sites at most.
    ///
    /// # Errors
    /// `ArgumentError` for anything else than a whole number or the name of a rule.
    pub fn of(value: &Bound<'_, PyAny>, sites_max: u32) -> PyResult<Self> {
        if let (false, Ok(sites)) = (value.is_instance_of::<PyBool>(), value.extract::<u32>()) {
            // The service refuses 0 and numbers above the maximum.
            return Ok(Self(shatter_client::DegreeRule::Sites(sites)));
        }
        let (names, rules) = (RULES.map(|(name, _)| name).join(", "), &RULES);
        let text = value.str()?;
        let text = text.to_string_lossy();
        match value.cast::<PyString>() {
            Ok(_) => one_of("degree", &text, rules)
                .map(Self)
                .map_err(|error| wrong(format!("{error}; or pass a whole number from 1 to {sites_max}"))),
            Err(_) => {
                let text = quoted(&text);
                let message = format!("degree: {text} is not a whole number from 1 to {sites_max}, nor one of {names}");
                Err(wrong(message))
            }
        }
    }
}

/// Names of effects of the argument `key`: a list of them, or one alone.
///
/// # Errors
/// `ArgumentError` for anything else.
pub fn names(key: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    if let Ok(name) = value.extract::<String>() {
        return Ok(vec![name]);
    }
    value.extract().map_err(|_| wrong(format!("{key} must be a list of effect names, e.g. {key}=['hulls']")))
}

/// Options of a request.
pub struct Wish<'a> {
    pub degree: Option<Degree>,
    pub quality: Option<&'a str>,
    pub error: Option<f64>,
    pub time_ms: Option<f64>,
    pub iterations: Option<u32>,
    pub enable: Vec<String>,
    pub disable: Vec<String>,
    pub gamma_j_m2: Option<f64>,
    pub lift: Option<&'a str>,
    pub elastic: Option<&'a str>,
    pub surface: Option<&'a str>,
    pub criterion: Option<&'a str>,
    pub seed: u64,
    pub keep: bool,
    pub origin: Option<FragmentOfResult>,
    pub deadline: Option<Duration>,
    pub fragments_max: Option<u32>,
    pub bytes_max: Option<u64>,
}

impl Wish<'_> {
    /// `impact` with these options.
    pub fn describe(self, impact: Impact) -> PyResult<Impact> {
        let effect = |name: &String| Effect::by_name(name).map_err(raised);
        let mut impact = impact.seed(self.seed);
        if let Some(degree) = self.degree {
            impact = impact.degree(degree.0);
        }
        if let Some(name) = self.quality {
            impact = impact.quality(quality(name)?);
        }
        if let Some(name) = self.lift {
            impact = impact.lift(lift(name)?);
        }
        if let Some(name) = self.elastic {
            impact = impact.elastic(elastic(name)?);
        }
        if let Some(name) = self.surface {
            impact = impact.surface(surface(name)?);
        }
        if let Some(name) = self.criterion {
            impact = impact.criterion(criterion(name)?);
        }
        for name in &self.enable {
            impact = impact.enable(effect(name)?);
        }
        for name in &self.disable {
            impact = impact.disable(effect(name)?);
        }
        impact = self.error.into_iter().fold(impact, Impact::error);
        impact = self.time_ms.into_iter().fold(impact, Impact::time_ms);
        impact = self.iterations.into_iter().fold(impact, Impact::iterations);
        impact = self.gamma_j_m2.into_iter().fold(impact, Impact::gamma);
        impact = self.deadline.into_iter().fold(impact, Impact::deadline);
        impact = self.fragments_max.into_iter().fold(impact, Impact::fragments_max);
        impact = self.bytes_max.into_iter().fold(impact, Impact::bytes_max);
        impact = self.origin.into_iter().fold(impact, |impact, (handle, fragment)| impact.from(handle, fragment));
        Ok(if self.keep { impact.keep() } else { impact })
    }
}

/// Rules for the number of sites, by name.
const RULES: [(&str, shatter_client::DegreeRule); 4] = {
    use shatter_client::DegreeRule::{ClosedForm, Inferred, Optimized, Verified};
    [("closed_form", ClosedForm), ("inferred", Inferred), ("verified", Verified), ("optimised", Optimized)]
};

fn quality(name: &str) -> PyResult<Quality> {
    named("quality", name, &Quality::ALL.map(|quality| (quality.name(), quality)))
}

fn lift(name: &str) -> PyResult<Lift> {
    let lifts =
        [("euclidean", Lift::Euclidean), ("interior", Lift::Interior), ("surface_diffusion", Lift::SurfaceDiffusion)];
    named("lift", name, &lifts)
}

fn elastic(name: &str) -> PyResult<DisplacementSource> {
    named("elastic", name, &[("reduced", DisplacementSource::Reduced), ("solve", DisplacementSource::Solve)])
}

fn criterion(name: &str) -> PyResult<RequestedCriterion> {
    named("criterion", name, &RequestedCriterion::ALL.map(|criterion| (criterion.name(), criterion)))
}

fn surface(name: &str) -> PyResult<RequestedSurface> {
    named("surface", name, &RequestedSurface::ALL.map(|surface| (surface.name(), surface)))
}

fn named<T: Copy>(key: &str, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    one_of(key, name, choices).map_err(wrong)
}

/// Finds the choice with this name; the error lists all names, and suggests the nearest.
fn one_of<T: Copy>(key: &str, name: &str, choices: &[(&str, T)]) -> Result<T, String> {
    let found = choices.iter().find(|(own, _)| *own == name);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(own, _)| *own).collect();
        let hint = nearest(name, &names).first().map_or(String::new(), |likely| format!("; did you mean `{likely}`?"));
        format!("{key}: `{}` is not one of {}{hint}", quoted(name), names.join(", "))
    })
}
