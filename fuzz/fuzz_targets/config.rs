//! Target `config`: `tests/it/fuzzed/bodies/config.rs`, which the tests call too.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::run("config", data));
