//! `shatterd`: the brittle-fracture daemon.
//!
//! One thread waits (tokio: bells, timers, signals), the others compute (rayon). [`serve`] puts the parts together.

pub mod arrivals;
mod catalog;
pub mod commands;
pub mod config;
pub mod event_source;
pub mod ipc;
pub mod jobs;
pub mod kept;
pub mod librarian;
mod lists;
pub mod memory;
pub mod metrics;
pub mod operations;
pub mod panics;
pub mod serve;
pub mod verdicts;
