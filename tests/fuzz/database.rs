//! Entry point for libFuzzer of [`Target::Database`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{Target, prepare};

fuzz_target!(init: prepare(Target::Database), |input: &[u8]| {
    Target::Database.run(input);
});
