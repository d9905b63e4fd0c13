//! Rust client of `shatterd`.

pub mod export;
