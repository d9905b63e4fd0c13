//! Entry point for libFuzzer of [`FuzzTarget::Request`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{FuzzTarget, prepare};

fuzz_target!(init: prepare(FuzzTarget::Request), |input: &[u8]| {
    FuzzTarget::Request.run(input);
});
