//! Entry point for libFuzzer of [`FuzzTarget::Toml`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{FuzzTarget, prepare};

fuzz_target!(init: prepare(FuzzTarget::Toml), |input: &[u8]| {
    FuzzTarget::Toml.run(input);
});
