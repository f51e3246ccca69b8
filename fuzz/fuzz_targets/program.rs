//! Target `program`: `tests/it/fuzzed/bodies/program.rs`, which the tests call too.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::run("program", data));
