//! Exceptions of the module.

use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};

pyo3::create_exception!(shatter, ShatterError, PyException, "Base class of the exceptions of this module.");
pyo3::create_exception!(
    shatter,
    Refusal,
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

/// Exception for `refusal`, with its kind, position, fault and retry advice as attributes.
pub fn raised(refusal: shatter_client::Error) -> PyErr {
    Python::attach(|py| {
        let error = Refusal::new_err(shatter_proto::text::message(&refusal.message));
        let told = error.value(py);
        let set = || -> PyResult<()> {
            told.setattr("kind", refusal.kind.name())?;
            told.setattr("at", &refusal.at)?;
            told.setattr("fault", refusal.kind.fault().name())?;
            told.setattr("retry", refusal.kind.retry())?;
            told.setattr("retry_after_s", refusal.retry_after.map(|wait| wait.as_secs_f64()))
        };
        set().err().unwrap_or(error)
    })
}
