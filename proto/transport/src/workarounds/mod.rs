//! Workarounds for iceoryx2 0.10.0, to be deleted by an upgrade.
//!
//! Each file covers one symptom. Its head names the reproduction, the upstream issue, and the code to delete, here and in the callers,
//! once a release fixes it. No other file of the project works around the transport; the test `workarounds` of `shatter-tests` checks
//! that.
//!
//! | file | symptom |
//! |---|---|
//! | [`lost_wakeups`] | a notification is lost, a timeout of zero never ends |
//! | [`response_pool`] | growing pools panic, a failed loan stays counted, a full buffer blocks every thread |
//! | [`aligned_blocks`] | an alignment is applied to every element |
//! | [`shared_memory`], [`populated_pages`] | a full `/dev/shm` kills with SIGBUS |
//! | [`private_segments`] | other users see names of segments, and can take them |
//! | [`dead_daemon`] | a server stays connected after it was killed |
//! | [`dead_clients`] | two processes that clean up race, a living client is taken for a dead one |
//! | [`stale_segments`] | segments and nodes of killed processes stay |
//! | [`left_behind`] | a daemon that was killed while starting leaves a service that cannot be opened |
//! | [`client_entry`] | a corrupt segment stops every client |
//! | [`unclear_errors`] | a failure does not say which limit of the process was reached |
//!
//! Not worked around: a process of the same user can write to the transport's management memory and crash the daemon (the user is
//! the trust domain), and both sides need exactly the same version (pinned in `Cargo.toml`, checked by
//! [`DaemonInfo`](crate::daemon_info::DaemonInfo)).

pub mod aligned_blocks;
pub mod client_entry;
pub mod dead_clients;
pub mod dead_daemon;
pub mod left_behind;
pub mod lost_wakeups;
pub mod populated_pages;
pub mod private_segments;
pub mod response_pool;
pub mod shared_memory;
pub mod stale_segments;
pub mod unclear_errors;
