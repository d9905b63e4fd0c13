//! Entry point for libFuzzer of [`Target::Toml`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{Target, prepare};

fuzz_target!(init: prepare(Target::Toml), |input: &[u8]| {
    Target::Toml.run(input);
});
