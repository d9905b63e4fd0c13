//! Conversion of a simulator's contacts to impacts.
//!
//! A simulator of rigid bodies reports points, impulses and approach speeds of contacts. An impact also needs their duration and
//! radius, which [`HertzContact`] computes for one contact. [`ContactCollector`] handles all contacts of a step. It merges contacts
//! near each other and keeps at most as many as a request may have. It drops steps that are too weak, too slow, or too soon after
//! the last impact.
//!
//! ```
//! use shatter_export::contact::{ContactBody, ContactCollector, ContactEvent, ContactPolicy, ElasticMaterial};
//!
//! let ceramic = ElasticMaterial { young_pa: 70e9, poisson: 0.2 };
//! let steel_ball = ContactBody { material: ElasticMaterial::STEEL, mass_kg: 0.5, radius_m: 0.025 };
//! let mut contacts = ContactCollector::default();
//! let mug = ContactPolicy::new(ContactBody { material: ceramic, mass_kg: 0.6, radius_m: 0.04 }).impulse_min(0.05).cooldown(0.25);
//! contacts.watch("mug", mug);
//! // The simulator's report after a step, in the coordinates of the object.
//! let (point_m, impulse_ns) = ([0.0, 0.05, 0.04], [0.0, 0.0, -1.5]);
//! contacts.touch(&"mug", ContactEvent { point_m, impulse_ns, speed_m_s: 3.0, other: steel_ball });
//! for (object, merged) in contacts.step(0.016) {
//!     let merged = merged?; // A flat landing is an error here, not a silent loss.
//!     assert_eq!((object, merged.len()), ("mug", 1));
//!     // The client makes an impact of them: `Impact::of(&merged)`.
//! }
//! # Ok::<(), shatter_export::contact::ImpulseLost>(())
//! ```
//!
//! This module reads no clock and keeps only its inputs: the time of a step is simulation time.

mod collect;
mod hertz;
mod merge;
#[cfg(test)]
mod tests;

pub use collect::{ContactCollector, ContactPolicy};
pub use hertz::{ContactBody, ContactError, DURATION, ElasticMaterial, HertzContact};
pub use merge::{ContactEvent, ImpulseLost, LOSS_MAX, MergedContact};
pub use shatter_proto::request::CONTACTS_MAX;
