//! Entry point for libFuzzer of [`Target::Mesh`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{Target, prepare};

fuzz_target!(init: prepare(Target::Mesh), |input: &[u8]| {
    Target::Mesh.run(input);
});
