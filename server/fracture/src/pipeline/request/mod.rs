//! What is asked of a strike, and the context that its stages get.

pub(super) mod budget;
pub(super) mod context;
pub(super) mod cost;
pub(super) mod fracture_request;
pub(super) mod observer;
pub(super) mod solver_settings;
pub(super) mod stage;
