//! Entry point for libFuzzer of [`FuzzTarget::Scene`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{FuzzTarget, prepare};

fuzz_target!(init: prepare(FuzzTarget::Scene), |input: &[u8]| {
    FuzzTarget::Scene.run(input);
});
