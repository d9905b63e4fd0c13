//! Exceptions of the module.

use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};

pyo3::create_exception!(shatter, ShatterError, PyException, "Base class of the exceptions of this module.");
pyo3::create_exception!(
    shatter,
    ServiceError,
    ShatterError,
    "An error of the client or the service. The message is one sentence for people."
);

/// The class `ArgumentError`, which has two bases; `create_exception!` supports one.
static ARGUMENT_ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Class of the exceptions that [`wrong`] makes.
///
/// # Errors
/// Python has no memory for the class.
pub fn argument_error(py: Python<'_>) -> PyResult<&Bound<'_, PyType>> {
    let class = ARGUMENT_ERROR.get_or_try_init(py, || {
        let bases = (py.get_type::<ShatterError>(), py.get_type::<PyValueError>());
        let members = PyDict::new(py);
        members.set_item("__module__", "shatter")?;
        members.set_item("__doc__", "An argument that cannot be used.")?;
        let class = py.get_type::<PyType>().call1(("ArgumentError", bases, members))?;
        Ok::<_, PyErr>(class.cast_into::<PyType>()?.unbind())
    })?;
    Ok(class.bind(py))
}

/// Exception for an argument that cannot be used.
pub fn wrong(message: impl Into<String>) -> PyErr {
    let message = message.into();
    Python::attach(|py| match argument_error(py) {
        Ok(class) => PyErr::from_type(class.clone(), message),
        Err(error) => error,
    })
}

/// Exception for `error`, with its kind, position, fault and retry advice as attributes.
pub fn raised(error: shatter_client::Error) -> PyErr {
    Python::attach(|py| {
        let exception = ServiceError::new_err(shatter_proto::text::message(&error.message));
        let value = exception.value(py);
        let set = || -> PyResult<()> {
            value.setattr("kind", error.kind.name())?;
            value.setattr("at", &error.at)?;
            value.setattr("fault", error.kind.fault().name())?;
            value.setattr("retry", error.kind.retry())?;
            value.setattr("retry_after_s", error.retry_after.map(|wait| wait.as_secs_f64()))
        };
        set().err().unwrap_or(exception)
    })
}
