//! Tools for developers and evaluators: studies, pictures, the demonstration, and the load generator. Not published.

#![allow(clippy::missing_errors_doc, clippy::missing_panics_doc, reason = "not published")]

pub mod commands;
pub mod demo;
pub mod load;
pub mod picture;
pub mod report;
pub mod study;
