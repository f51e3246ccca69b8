//! The printer link: fault matrix, transcripts, soak, the real pty, and Python programs at either end.

mod asked;
#[cfg(unix)]
mod bad_day;
mod bench_machine;
mod cooled;
mod faults;
mod fuzz;
mod kept_place;
mod kills;
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
mod slow;
mod stops;
#[cfg(unix)]
mod terminal;
mod transcripts;
#[cfg(unix)]
mod two_printers;
#[cfg(unix)]
mod unfollowed;
mod wire;

#[cfg(unix)]
pub(crate) use real::{Running, executed, gcode, interrupt, killed, profile, simulate, wanted};

/// Prints a verified file on the simulated printer, which must carry out every line of it and nothing else.
#[cfg(unix)]
pub(crate) fn sent(
    folder: &std::path::Path,
    machine: &std::path::Path,
    file: &std::path::Path,
    plan: &std::path::Path,
) {
    let (link, log) = (folder.join("tty"), folder.join("sim.log"));
    let _printer = real::simulate(&link, machine, &["--speed", "max", "--log", log.to_str().unwrap()]);
    let mut command = crate::support::trunnion();
    command.arg("send").arg(file).arg("--plan").arg(plan).arg("--port").arg(&link);
    let done = real::output(&mut command);
    assert!(done.status.success(), "{}", crate::support::said(&done));
    let own = |lines: Vec<String>| lines.into_iter().filter(|l| !l.starts_with("M400")).collect::<Vec<_>>();
    real::assert_same(&own(real::wanted(file)), &own(real::executed(&log)));
}
