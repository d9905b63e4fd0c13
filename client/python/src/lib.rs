//! Python interface of the client: the module `shatter._shatter`, whose names `shatter` exports. They are documented in
//! `python/shatter/_shatter.pyi`.

mod argument;
mod array;
mod contact;
mod error;
mod fragment;
mod impact;
mod result;
mod service;
mod ticket;

use error::{ServiceError, ShatterError};
use pyo3::prelude::*;
use service::Service;
use shatter_client::{Convention, default_service};

/// Connects to a service by name; without a name to that of ``SHATTER_SERVICE``, or to ``default``.
///
/// Its results come in the coordinates of ``convention``.
///
/// The connection outlives the daemon: requests under way when a daemon goes away end as ``lost``; later ones go to its successor.
#[pyfunction]
#[pyo3(signature = (name = None, *, timeout_s = 1.0, convention = "gltf"))]
fn connect(
    py: Python<'_>,
    name: Option<&str>,
    #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    convention: &str,
) -> PyResult<Service> {
    let convention = Convention::by_name(convention).map_err(error::raised)?;
    Service::connect(py, &named(name)?, argument::duration(timeout_s), convention)
}

/// The name, or that of the default service.
fn named(name: Option<&str>) -> PyResult<String> {
    name.map_or_else(|| default_service().map_err(error::raised), |name| Ok(name.to_owned()))
}

/// Connects as :func:`connect` does, but waits for a daemon to appear.
#[pyfunction]
#[pyo3(signature = (name = None, *, timeout_s = 60.0, convention = "gltf"))]
fn wait_for(
    py: Python<'_>,
    name: Option<&str>,
    #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    convention: &str,
) -> PyResult<Service> {
    let convention = Convention::by_name(convention).map_err(error::raised)?;
    Service::wait_for(py, &named(name)?, argument::duration(timeout_s), convention)
}

#[pymodule]
fn _shatter(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("ShatterError", module.py().get_type::<ShatterError>())?;
    module.add("ArgumentError", error::argument_error(module.py())?)?;
    module.add("ServiceError", module.py().get_type::<ServiceError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(connect, module)?)?;
    module.add_function(wrap_pyfunction!(wait_for, module)?)?;
    module.add_function(wrap_pyfunction!(contact::hertz, module)?)?;
    module.add_class::<Service>()?;
    module.add_class::<service::Object>()?;
    module.add_class::<service::Facts>()?;
    module.add_class::<service::Status>()?;
    module.add_class::<impact::Contact>()?;
    module.add_class::<impact::ContactPartner>()?;
    module.add_class::<contact::Hertz>()?;
    module.add_class::<ticket::Ticket>()?;
    module.add_class::<result::FractureResult>()?;
    module.add_class::<result::Summary>()?;
    module.add_class::<result::Hit>()?;
    module.add_class::<result::Bond>()?;
    module.add_class::<result::Debris>()?;
    module.add_class::<fragment::Fragment>()?;
    module.add_class::<fragment::Run>()?;
    module.add_class::<fragment::Hull>()?;
    module.add_class::<fragment::Skin>()
}
