//! The science of Shatter as a plain library: from a surface mesh and an impact to closed fragment meshes.
//!
//! Data walks once through rooms named after the mathematics:
//! [`surface`] → [`lattice`] → [`elasticity`] → [`lift`] → [`centroidal`] → [`degree`] → [`tessellation`] →
//! [`fragment`]; [`hull`] stands for fragments in collisions, [`skin`] is what they look like, [`database`] keeps what depends on the
//! object alone, [`scene`] says what a scene wants, and
//! [`pipeline`] is the one walk through all of them. No room knows of processes, files of others, or clocks.
//!
//! Lengths inside the library are *local*: the object's bounding-box diagonal is 1 and its box is centered at the
//! origin ([`surface::LocalFrame`]). Physical units appear only in [`scene`], [`pipeline`] and [`fragment`].

pub mod accuracy;
pub mod cancel_token;
pub mod centroidal;
pub mod database;
pub mod degree;
mod dense;
pub mod elasticity;
pub mod fragment;
pub mod hull;
pub mod lattice;
pub mod lift;
mod memory;
pub mod pipeline;
pub mod random;
pub mod reference;
pub mod scene;
mod simd;
pub mod skin;
pub mod sparse;
pub mod surface;
pub mod tessellation;
mod triangle;
