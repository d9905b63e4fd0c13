//! Studies of the engine at its limits: what it makes of input that nobody should send.

pub mod mutants;
