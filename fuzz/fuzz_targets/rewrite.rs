//! Target `rewrite`: `tests/it/fuzzed/bodies/rewrite.rs`, which the tests call too.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::run("rewrite", data));
