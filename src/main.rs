//! The `trunnion` command: arguments in, exit code out.
//!
//! Exit codes: 0 done, 1 done and the answer is no (findings, no plan), 2 usage or bad input, 3 the slicer failed,
//! 4 printer or wire, 130 interrupted.

fn main() -> std::process::ExitCode {
    trunnion::cli::run()
}
