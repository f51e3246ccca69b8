//! The printer link: fault matrix, transcripts, soak, the real pty, and Python programs at either end.

mod bench_machine;
mod faults;
mod pacing;
#[cfg(unix)]
mod prepared;
#[cfg(unix)]
mod python;
#[cfg(unix)]
mod real;
mod transcripts;
