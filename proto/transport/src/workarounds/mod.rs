//! Workarounds for iceoryx2 0.10.0, deleted as upgrades make them unnecessary.
//!
//! Each file covers one symptom. Its first comment names the reproduction, the upstream issue, and the code to delete, here and in
//! the callers, once a release fixes it. No other file of the project contains workarounds for the transport; the test
//! `workarounds` of `shatter-tests` checks that.
//!
//! | file | symptom |
//! |---|---|
//! | [`lost_wakeups`] | a notification is lost; a wait with a timeout of zero never returns |
//! | [`response_pool`] | growing pools panic; a failed loan stays counted; a full buffer blocks every thread |
//! | [`aligned_blocks`] | an alignment is applied to every element |
//! | [`shared_memory`], [`populated_pages`] | a write to a full `/dev/shm` ends the process with SIGBUS |
//! | [`private_segments`] | other users can list the names of segments, and can occupy them |
//! | [`dead_daemon`] | clients stay connected to a server that was killed |
//! | [`dead_clients`] | two processes that clean up race; a living client is treated as dead |
//! | [`stale_segments`] | segments and nodes of killed processes are not removed |
//! | [`left_behind`] | a daemon killed while starting leaves a service that cannot be opened |
//! | [`client_entry`] | a corrupt segment prevents every client from connecting |
//! | [`few_descriptors`] | a server without descriptors never recovers |
//! | [`forked_processes`] | a forked process takes the ports of its parent |
//! | [`unclear_errors`] | an error does not name the process limit that was reached |
//!
//! Two limitations remain. A process of the same user can write to the transport's management memory and crash the daemon; all
//! processes of one user trust each other. Both sides need exactly the same version of iceoryx2, which `Cargo.toml` pins and
//! [`DaemonInfo`](crate::daemon_info::DaemonInfo) checks.

pub mod aligned_blocks;
pub mod client_entry;
pub mod dead_clients;
pub mod dead_daemon;
pub mod few_descriptors;
pub mod forked_processes;
pub mod left_behind;
pub mod lost_wakeups;
pub mod populated_pages;
pub mod private_segments;
pub mod response_pool;
pub mod shared_memory;
pub mod stale_segments;
pub mod unclear_errors;
