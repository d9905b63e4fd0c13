//! Context of one request.

use super::fracture_request::FractureRequest;
use super::observer::StageObserver;
use crate::cancel_token::CancelToken;
use crate::pipeline::prepared::object::PreparedObject;

/// One request with its object, cancellation and observer.
///
/// The memory that stages write into is separate: a [`Workspace`](crate::pipeline::Workspace).
#[derive(Clone, Copy)]
pub struct RequestContext<'a> {
    /// The object.
    pub prepared: &'a PreparedObject,
    /// The request, constant during the computation.
    pub request: &'a FractureRequest,
    /// Cancellation and time limit, polled by every stage.
    pub cancel: &'a CancelToken,
    /// Observer of every stage and effect.
    pub observer: &'a dyn StageObserver,
}

impl<'a> RequestContext<'a> {
    /// Context of one request. Without cancellation and observer, pass `&CancelToken::default()` and `&()`.
    pub fn new(
        prepared: &'a PreparedObject,
        request: &'a FractureRequest,
        cancel: &'a CancelToken,
        observer: &'a dyn StageObserver,
    ) -> Self {
        Self { prepared, request, cancel, observer }
    }

    /// The same context with another request.
    pub(in crate::pipeline) fn with_request<'b>(self, request: &'b FractureRequest) -> RequestContext<'b>
    where
        'a: 'b,
    {
        RequestContext { request, ..self }
    }
}
