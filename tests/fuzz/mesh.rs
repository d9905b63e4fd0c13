//! Entry point for libFuzzer of [`FuzzTarget::Mesh`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{FuzzTarget, prepare};

fuzz_target!(init: prepare(FuzzTarget::Mesh), |input: &[u8]| {
    FuzzTarget::Mesh.run(input);
});
