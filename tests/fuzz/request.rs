//! Entry point for libFuzzer of [`Target::Request`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{Target, prepare};

fuzz_target!(init: prepare(Target::Request), |input: &[u8]| {
    Target::Request.run(input);
});
