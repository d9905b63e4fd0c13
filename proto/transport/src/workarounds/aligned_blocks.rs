//! An alignment of the payload is applied to every element.
//!
//! **Symptom.** `response_payload_alignment(64)` on a slice of bytes reserves 64 bytes per byte. The derive of `ZeroCopySend` panics on
//! `repr(C, align(64))` in one attribute, and on tuple structs.
//!
//! **Reproduction** (iceoryx2 0.10.0). A pool of 1.14 GB became one of 73 GB.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** The 64-byte element [`AlignedBlock`], once a slice of bytes can be aligned as a whole: responses are then slices of bytes.

use shatter_proto::result::AlignedBlock;

const _: () = assert!(size_of::<AlignedBlock>() == 64 && align_of::<AlignedBlock>() == 64);
