//! Target `profile`: `tests/it/fuzzed/bodies/profile.rs`, which the tests call too.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::run("profile", data));
