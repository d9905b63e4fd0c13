//! Requests under way.

use crate::argument;
use crate::error::raised;
use crate::result::FractureResult;
use crate::service::in_slices;
use pyo3::prelude::*;
use shatter_client::{ErrorKind, Poll, Progress};
use std::sync::{Mutex, PoisonError};

/// A request under way. It is canceled when the last reference to it goes before its result.
#[pyclass(frozen, module = "shatter")]
pub struct Ticket(Mutex<Option<shatter_client::Ticket>>);

impl Ticket {
    pub fn new(ticket: shatter_client::Ticket) -> Self {
        Self(Mutex::new(Some(ticket)))
    }

    fn with<T>(
        &self,
        ask: impl FnOnce(&mut shatter_client::Ticket) -> Result<T, shatter_client::Error>,
    ) -> Result<T, shatter_client::Error> {
        let mut place = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let spent =
            || shatter_client::Error::new(ErrorKind::Canceled, "ticket", "the ticket was canceled; strike again");
        ask(place.as_mut().ok_or_else(spent)?)
    }
}

#[pymethods]
impl Ticket {
    /// Waits for the result; Ctrl-C ends it. After ``late`` the ticket is still valid.
    #[pyo3(signature = (*, timeout_s = 60.0))]
    pub fn wait(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<FractureResult> {
        // The service may report `late` as well, for the request itself.
        let pending = |error: &shatter_client::Error| error.kind == ErrorKind::Late && error.at == "ticket";
        let result =
            in_slices(py, argument::duration(timeout_s), pending, |slice| self.with(|ticket| ticket.wait(slice)))?;
        Ok(FractureResult::new(result))
    }

    /// The result if there is one; never blocks. Once a frame is often enough.
    fn poll(&self, py: Python<'_>) -> PyResult<Option<FractureResult>> {
        match py.detach(|| self.with(shatter_client::Ticket::poll)).map_err(raised)? {
            Poll::Pending => Ok(None),
            Poll::Ready(result) => Ok(Some(FractureResult::new(result))),
        }
    }

    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<&'static str> {
        let progress = py.detach(|| self.with(|ticket| Ok(ticket.progress()))).map_err(raised)?;
        Ok(match progress {
            Progress::Waiting => "waiting",
            Progress::Ended => "ended",
            _ => "computing",
        })
    }

    fn cancel(&self, py: Python<'_>) {
        py.detach(|| self.0.lock().unwrap_or_else(PoisonError::into_inner).take());
    }
}
