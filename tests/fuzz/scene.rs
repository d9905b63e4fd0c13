//! Entry point for libFuzzer of [`Target::Scene`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{Target, prepare};

fuzz_target!(init: prepare(Target::Scene), |input: &[u8]| {
    Target::Scene.run(input);
});
