//! Target `plan`: `tests/it/fuzzed/bodies/plan.rs`, which the tests call too.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::run("plan", data));
