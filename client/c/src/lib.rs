//! C interface of the client, a thin layer over `shatter-client`. cbindgen generates `client/include/shatter.h` from these files.
//!
//! Pointers that may be null are `Option`s of references and boxes, which C sees as plain pointers. Memory that C has not initialized is
//! `MaybeUninit`. Only text and arrays of the caller need `unsafe`. There is no global state, and no panic crosses the C boundary
//! (`ffi_boundary`).

mod code;
mod error;
mod facts;
mod ffi_boundary;
mod host;
mod impact;
mod object;
mod result;
mod result_rows;
mod service;
mod ticket;

pub use code::{Code, Fault};
pub use error::ErrorRecord;
pub use facts::{Facts, Status};
pub use host::{Convention, Hertz, Partner, shatter_convention_named, shatter_hertz, shatter_service_with_convention};
pub use impact::{Contact, Degree, Effect, Elastic, Impact, Lift, NO_ITERATIONS, Purpose, Quality};
pub use object::{
    Object, shatter_object_aim, shatter_object_even, shatter_object_facts, shatter_object_free, shatter_object_strike,
};
pub use result::{
    Content, FractureResult, shatter_result_bonds, shatter_result_debris, shatter_result_effects,
    shatter_result_fragment, shatter_result_free, shatter_result_hash, shatter_result_hull, shatter_result_is_closed,
    shatter_result_run, shatter_result_skin, shatter_result_stages, shatter_result_summary, shatter_result_write_glb,
};
pub use result_rows::{
    Bond, Counter, Debris, Fragment, Hash, Hit, Hull, NONE, Run, Skin, SkinVertex, Summary, VertexAttributes,
};
pub use service::{
    Service, VERSION, shatter_connect, shatter_service_free, shatter_service_object, shatter_service_objects,
    shatter_service_release, shatter_service_status, shatter_service_wait, shatter_version, shatter_wait_for,
};
pub use ticket::{
    Progress, State, Ticket, shatter_ticket_free, shatter_ticket_poll, shatter_ticket_progress, shatter_ticket_wait,
};
