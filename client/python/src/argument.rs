//! Arguments from Python, by name: an argument that cannot be used is named, with the values that are possible.

use crate::error::wrong;
use crate::result::FragmentOfResult;
use pyo3::prelude::*;
use pyo3::types::PyBool;
use shatter_proto::request::ITERATIONS_MAX;
use shatter_proto::text::quoted;
use std::fmt::Display;
use std::path::PathBuf;
use std::time::Duration;

/// Defines a function per argument that reads it with a reader of this module.
macro_rules! arguments {
    ($($function:ident($name:literal): $type:ty = $reader:ident;)*) => {
        $(pub fn $function(value: &Bound<'_, PyAny>) -> PyResult<$type> {
            $reader($name, value)
        })*
    };
}

arguments! {
    point("point"): [f64; 3] = vector;
    impulse("impulse"): [f64; 3] = vector;
    ray("ray"): Option<[f64; 3]> = optional_vector;
    ray_origin("origin"): [f64; 3] = vector;
    direction("direction"): [f64; 3] = vector;
    seed("seed"): u64 = whole;
    partner_id("id"): u64 = whole;
    mass_kg("mass_kg"): f64 = real;
    speed("speed"): f64 = real;
    center("center"): Option<[f64; 3]> = optional_vector;
    inertia("inertia"): Option<[f64; 6]> = optional_tensor;
    handle("handle"): u64 = whole;
    pieces("pieces"): u32 = count;
    iterations("iterations"): Option<u32> = optional_iterations;
    fragments_max("fragments_max"): Option<u32> = optional_limit;
    bytes_max("bytes_max"): Option<u64> = optional_limit;
    error("error"): Option<f64> = optional_number;
    time_ms("time_ms"): Option<f64> = optional_number;
    gamma_j_m2("gamma_j_m2"): Option<f64> = optional_number;
    object_name("name"): String = text;
    struck_fragment("origin"): Option<FragmentOfResult> = optional_fragment;
    aimed_fragment("fragment"): Option<FragmentOfResult> = optional_fragment;
    one("one"): Body = body;
    other("other"): Body = body;
    timeout_s("timeout_s"): f64 = seconds;
    deadline_s("deadline_s"): Option<Duration> = optional_seconds;
    output_file("path"): PathBuf = path;
    output_folder("folder"): PathBuf = path;
    materials_file("materials"): Option<PathBuf> = optional_path;
}

/// Mass (kg), radius (m), Young's modulus (Pa) and Poisson's ratio.
pub type Body = (f64, f64, f64, f64);

/// Error for the argument `name`, which must be as `wanted` says.
fn refused(name: &str, wanted: impl Display, value: &Bound<'_, PyAny>) -> PyErr {
    let found = value.repr().map_or_else(|_| "a value without a text".to_owned(), |text| text.to_string());
    wrong(format!("{name} must be {wanted}, not {}", quoted(&found)))
}

/// Reads an argument that may be `None`.
fn optional<T>(
    name: &str,
    value: &Bound<'_, PyAny>,
    read: impl FnOnce(&str, &Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Option<T>> {
    if value.is_none() { Ok(None) } else { read(name, value).map(Some) }
}

fn vector(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let numbers = value.extract::<[f64; 3]>().ok().filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    numbers.ok_or_else(|| refused(name, format!("3 finite numbers, for example {name}=(0.1, 0.0, -0.2)"), value))
}

fn optional_vector(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<[f64; 3]>> {
    optional(name, value, vector)
}

/// The entries of a symmetric tensor. The daemon decides whether they are allowed.
fn optional_tensor(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<[f64; 6]>> {
    let wanted = "6 numbers: xx, yy, zz, xy, xz, yz";
    optional(name, value, |name, value| value.extract().map_err(|_| refused(name, wanted, value)))
}

/// A number. The daemon decides whether it is allowed.
fn real(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    number(value).ok_or_else(|| refused(name, "a number", value))
}

/// Extracts a whole number. `True` and `False` are refused, although Python counts them as numbers.
fn number<T: for<'a, 'py> FromPyObject<'a, 'py>>(value: &Bound<'_, PyAny>) -> Option<T> {
    if value.is_instance_of::<PyBool>() { None } else { value.extract().ok() }
}

/// A whole number without a sign, with the largest one of its type.
trait Whole: for<'a, 'py> FromPyObject<'a, 'py> + Display {
    const LARGEST: Self;
}

impl Whole for u32 {
    const LARGEST: Self = Self::MAX;
}

impl Whole for u64 {
    const LARGEST: Self = Self::MAX;
}

fn whole<T: Whole>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<T> {
    number(value).ok_or_else(|| refused(name, format!("a whole number from 0 to {}", T::LARGEST), value))
}

/// A limit. 0 is refused: the protocol means no limit by it, which is `None` here.
fn optional_limit<T: Whole + Default + PartialEq>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<T>> {
    let wanted = || format!("a whole number from 1 to {}, or None for no limit", T::LARGEST);
    let read = |_: &str, value: &Bound<'_, PyAny>| {
        number::<T>(value).filter(|limit| *limit != T::default()).ok_or_else(|| refused(name, wanted(), value))
    };
    optional(name, value, read)
}

/// A number, which may be `None`. The daemon decides whether it is allowed.
fn optional_number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    optional(name, value, real)
}

/// A text without lone surrogates.
fn text(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.extract().map_err(|_| refused(name, "a str that UTF-8 can hold", value))
}

/// A number of pieces. The daemon decides whether it is allowed.
fn count(name: &str, value: &Bound<'_, PyAny>) -> PyResult<u32> {
    number(value).ok_or_else(|| refused(name, "a whole number from 1 to 512", value))
}

/// A number of iterations. The daemon decides whether it is allowed.
fn optional_iterations(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<u32>> {
    let read = |name: &str, value: &Bound<'_, PyAny>| {
        number(value).ok_or_else(|| refused(name, format!("a whole number from 0 to {ITERATIONS_MAX}"), value))
    };
    optional(name, value, read)
}

fn optional_fragment(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<FragmentOfResult>> {
    optional(name, value, |name, value| {
        let wanted = format!(
            "a pair of whole numbers, the handle of a kept result and the id of its fragment: {name}=(result.handle, fragment.id)"
        );
        value.extract().map_err(|_| refused(name, wanted, value))
    })
}

fn body(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Body> {
    let wanted = "4 numbers: mass (kg), radius (m), Young's modulus (Pa), Poisson's ratio";
    value.extract().map_err(|_| refused(name, wanted, value))
}

/// Largest number of seconds that a message names; a [`Duration`] holds less than 2⁶⁴ of them.
const SECONDS_MAX: f64 = 1.8e19;

/// A number of seconds that a [`Duration`] holds.
fn seconds(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let seconds = value.extract::<f64>().ok().filter(|seconds| Duration::try_from_secs_f64(*seconds).is_ok());
    seconds.ok_or_else(|| refused(name, format!("a number of seconds from 0 to {SECONDS_MAX:e}"), value))
}

/// Reads a path that is not empty.
fn path(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    let path: PathBuf = value.extract().map_err(|_| refused(name, "a str, or an os.PathLike of one", value))?;
    if path.as_os_str().is_empty() {
        return Err(wrong(format!("{name} is empty; it must name the output")));
    }
    Ok(path)
}

/// Reads a path of an input file, which may be `None`. An empty one names no file, which its reader reports.
fn optional_path(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<PathBuf>> {
    optional(name, value, |name, value| {
        value.extract().map_err(|_| refused(name, "a str, or an os.PathLike of one", value))
    })
}

/// The duration of a checked number of seconds. Signatures of Python show a default as a number alone.
pub fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

fn optional_seconds(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<Duration>> {
    Ok(optional(name, value, seconds)?.map(duration))
}
