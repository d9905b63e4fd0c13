//! `shatterd`: the brittle-fracture daemon, and what people look at.
//!
//! One thread waits (tokio: bells, timers, signals), the others compute (rayon). [`serve`] puts the parts together.

pub mod arrivals;
mod catalog;
pub mod clock;
pub mod commands;
pub mod config;
mod cost;
pub mod demo;
pub mod ears;
pub mod engine;
pub mod ipc;
pub mod jobs;
pub mod kept;
pub mod librarian;
mod lists;
pub mod memory;
pub mod metrics;
pub mod operations;
pub mod panics;
pub mod picture;
pub mod report;
pub mod scene;
pub mod serve;
pub mod study;
pub mod verdicts;
pub mod wire;
