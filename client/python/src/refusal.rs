//! Refusals as an exception.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;

pyo3::create_exception!(shatter, Refusal, PyException, "Why something was not done.");

/// The exception that `refusal` is, with its rule, offender, fault and advice as attributes.
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
