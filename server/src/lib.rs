//! `shatterd`: the brittle-fracture daemon.
//!
//! One thread waits (tokio: bells, timers, signals), the others compute (rayon). [`serve`] puts the parts together.

mod buckets;
mod catalog;
pub mod commands;
pub mod config;
pub mod error_mailbox;
pub mod event_source;
pub mod hot_reloader;
pub mod http_endpoints;
pub mod ipc;
pub mod jobs;
pub mod memory;
pub mod metrics;
pub mod panics;
pub mod pending_arrivals;
pub mod retained;
pub mod serve;
mod waiting_lists;
