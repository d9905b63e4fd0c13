//! C interface of the client, a thin layer over `shatter-client`. cbindgen generates `client/include/shatter.h` from these files.
//!
//! Pointers that may be null are `Option`s of references and boxes, which C sees as plain pointers. Memory that C has not initialized is
//! `MaybeUninit`. Only text and arrays of the caller need `unsafe`. There is no global state, and no panic crosses the C boundary
//! (`border`).

mod answer;
mod border;
mod broken;
mod code;
mod facts;
mod host;
mod impact;
mod object;
mod refusal;
mod service;
mod ticket;

pub use answer::{Bond, Counter, Debris, Fragment, Hash, Hit, Hull, Look, NONE, Run, Skin, SkinVertex, Summary};
pub use broken::{
    Broken, Content, shatter_broken_bonds, shatter_broken_debris, shatter_broken_effects, shatter_broken_fragment,
    shatter_broken_free, shatter_broken_hash, shatter_broken_hull, shatter_broken_is_closed, shatter_broken_run,
    shatter_broken_skin, shatter_broken_stages, shatter_broken_summary, shatter_broken_write_glb,
};
pub use code::{Code, Fault};
pub use facts::{Facts, Status};
pub use host::{Convention, Hertz, Partner, shatter_convention_named, shatter_hertz, shatter_service_with_convention};
pub use impact::{Contact, Degree, Effect, Elastic, Impact, Lift, NO_ITERATIONS, Purpose, Quality};
pub use object::{
    Object, shatter_object_aim, shatter_object_even, shatter_object_facts, shatter_object_free, shatter_object_strike,
};
pub use refusal::Refusal;
pub use service::{
    Service, VERSION, shatter_connect, shatter_service_doze, shatter_service_free, shatter_service_object,
    shatter_service_objects, shatter_service_release, shatter_service_status, shatter_version, shatter_wait_for,
};
pub use ticket::{
    Progress, State, Ticket, shatter_ticket_free, shatter_ticket_poll, shatter_ticket_progress, shatter_ticket_wait,
};
