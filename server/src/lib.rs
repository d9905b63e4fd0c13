//! `shatterd`: the brittle-fracture daemon.
//!
//! One thread runs the event loop (tokio: wake-ups, timers, signals); worker threads compute (rayon). [`serve`] connects the parts.

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
mod loaded_databases;
pub mod memory;
pub mod metrics;
pub mod panics;
pub mod pending_arrivals;
mod pending_list_requests;
pub mod retained;
pub mod serve;
