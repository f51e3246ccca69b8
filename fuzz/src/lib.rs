//! The fuzz targets' bodies, as the tests call them.

#[allow(dead_code, reason = "the tests begin with what some targets have made")]
#[path = "../../tests/it/fuzzed/bodies/mod.rs"]
mod bodies;

/// Runs the target `name` on `data`.
pub fn run(name: &str, data: &[u8]) {
    bodies::run(name, data);
}
