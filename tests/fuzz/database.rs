//! Entry point for libFuzzer of [`FuzzTarget::Database`].

#![no_main]

use libfuzzer_sys::fuzz_target;
use shatter_tests::fuzz::{FuzzTarget, prepare};

fuzz_target!(init: prepare(FuzzTarget::Database), |input: &[u8]| {
    FuzzTarget::Database.run(input);
});
