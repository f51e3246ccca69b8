//! The printer link: fault matrix, transcripts, soak, the real pty, and Python programs at either end.

#[cfg(unix)]
mod bad_day;
mod bench_machine;
mod faults;
mod fuzz;
mod kept_place;
mod pacing;
mod pause;
mod phases;
#[cfg(unix)]
mod places;
#[cfg(unix)]
mod prepared;
mod prologue;
#[cfg(unix)]
mod promised;
#[cfg(unix)]
mod python;
#[cfg(unix)]
mod real;
#[cfg(unix)]
mod reentry;
mod refusals;
#[cfg(unix)]
mod screen;
mod second_resume;
#[cfg(unix)]
mod several;
mod shipped;
#[cfg(unix)]
mod terminal;
mod transcripts;
#[cfg(unix)]
mod two_printers;
#[cfg(unix)]
mod unfollowed;
mod wire;
