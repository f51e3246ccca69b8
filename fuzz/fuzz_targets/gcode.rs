//! Target `gcode`: `tests/it/fuzzed/bodies/gcode.rs`, which the tests call too.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| trunnion_fuzz::run("gcode", data));
