//! The one integration binary: every module is linked once, which is what takes the time on two cores.
#![expect(clippy::unwrap_used, reason = "a helper that cannot go on fails the test that called it")]

mod architecture;
mod bad_input;
mod columns;
mod configurations;
mod cura;
mod cura_engine;
mod files_and_streams;
mod filled;
mod hooks;
mod islands;
mod job;
mod kinematics;
mod layer_oracle;
mod link;
mod linuxcnc;
mod mutants;
mod mutated_slices;
mod oracle;
mod orient;
mod orient_numpy;
mod orient_sample;
mod orient_size;
mod own_settings;
mod pipeline;
mod plan_and_prepare;
mod planning;
mod practised;
mod rewriting;
mod rust_source;
mod sliced_files;
mod solids;
mod split;
mod support;
mod sweeps;
mod turns;
