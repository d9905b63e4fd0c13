//! What every stage of a strike is given.

use super::fracture_request::FractureRequest;
use super::observer::StageObserver;
use crate::cancel_token::CancelToken;
use crate::pipeline::prepared::object::PreparedObject;

/// One strike: what is struck, what is asked for, and who may stop and observe it. The memory that stages write into is a
/// [`Workspace`](crate::pipeline::Workspace), apart from it.
#[derive(Clone, Copy)]
pub struct StrikeContext<'a> {
    /// The object.
    pub prepared: &'a PreparedObject,
    /// What is asked for; it does not change while the strike is computed.
    pub request: &'a FractureRequest,
    /// Polled by every stage.
    pub cancel: &'a CancelToken,
    /// Sees every stage and effect.
    pub observer: &'a dyn StageObserver,
}

impl<'a> StrikeContext<'a> {
    /// Of a strike that nothing stops and nothing observes is `StrikeContext::new(prepared, request, &CancelToken::default(), &())`.
    pub fn new(
        prepared: &'a PreparedObject,
        request: &'a FractureRequest,
        cancel: &'a CancelToken,
        observer: &'a dyn StageObserver,
    ) -> Self {
        Self { prepared, request, cancel, observer }
    }

    /// The same with another request.
    pub(in crate::pipeline) fn with_request<'b>(self, request: &'b FractureRequest) -> StrikeContext<'b>
    where
        'a: 'b,
    {
        StrikeContext { request, ..self }
    }
}
