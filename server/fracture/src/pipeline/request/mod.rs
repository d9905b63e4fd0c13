//! Requests, and the context that every stage receives.

pub(super) mod budget;
pub(super) mod context;
pub(super) mod cost;
pub(super) mod fracture_request;
pub(super) mod observer;
pub(super) mod solver_settings;
pub(super) mod stage;
