//! Jobs: this program again as a process of its own, its lines as they come, and words to it.
//!
//! A job has a process group, so that ending it ends its slicer too. One that prints has a terminal as its input: it is paused and
//! continued as by hand.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::time::Duration;

use super::routes::JobWord;
use crate::slicing::KEY_VARIABLE;

/// Set for a job: it reports how far it is as lines on its standard error.
pub const PROGRESS_VARIABLE: &str = "TRUNNION_PROGRESS";
/// A line longer than this is cut, bytes.
const MOST_LINE: u64 = 64 << 20;
const BETWEEN_SIGNALS: Duration = Duration::from_millis(30);

/// What a job says.
#[derive(Debug)]
pub(super) enum JobSaid {
    /// A line of its standard output.
    Result(String),
    /// A line of its standard error.
    Note(String),
    /// It has ended.
    Ended(Option<i32>),
}

/// A running job.
#[derive(Debug)]
pub(super) struct Job {
    /// Its number.
    pub(super) process: u32,
    /// The other end of its terminal.
    terminal: Option<File>,
}

/// What a job has of ours.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lent {
    /// A terminal, by which it is paused.
    pub(super) terminal: bool,
    /// The key of a server that the workbench was started with.
    pub(super) key: bool,
}

/// Starts the command of `words` in `folder`; `hear` gets what it says, in the order of each stream, and its end last.
///
/// # Errors
///
/// The system's.
pub(super) fn start(
    folder: &Path,
    words: &[String],
    lent: Lent,
    hear: impl Fn(JobSaid) + Send + Sync + 'static,
) -> std::io::Result<Job> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("--json").args(words).current_dir(folder).env(PROGRESS_VARIABLE, "lines");
    if !lent.key {
        command.env_remove(KEY_VARIABLE);
    }
    let (terminal, input) = if lent.terminal { terminal()? } else { (None, Stdio::null()) };
    command.stdin(input).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn()?;
    drop(command);
    let (out, err, process, hear) = (child.stdout.take(), child.stderr.take(), child.id(), Arc::new(hear));
    let of_results = hear.clone();
    let of_notes = hear.clone();
    let results = std::thread::spawn(move || {
        out.into_iter().for_each(|out| lines(out, |line| of_results(JobSaid::Result(line))))
    });
    let notes =
        std::thread::spawn(move || err.into_iter().for_each(|err| lines(err, |line| of_notes(JobSaid::Note(line)))));
    std::thread::spawn(move || {
        let _ = (results.join(), notes.join());
        hear(JobSaid::Ended(child.wait().ok().as_ref().and_then(code)));
    });
    Ok(Job { process, terminal })
}

/// Runs the command of `words` to its end: its exit code, standard output and lines of standard error.
///
/// # Errors
///
/// The system's.
pub(super) fn ask(folder: &Path, words: &[String]) -> std::io::Result<(Option<i32>, String, Vec<String>)> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg("--json").args(words).current_dir(folder).env_remove(KEY_VARIABLE).stdin(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let done = command.output()?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ok((code(&done.status), text(&done.stdout), text(&done.stderr).lines().map(str::to_owned).collect()))
}

/// Does something beside what is being answered.
pub(super) fn aside(work: impl FnOnce() + Send + 'static) {
    std::thread::spawn(work);
}

/// The exit code; of one that a signal ended, none.
fn code(status: &ExitStatus) -> Option<i32> {
    status.code()
}

fn lines(from: impl Read, hear: impl Fn(String)) {
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    while from.by_ref().take(MOST_LINE).read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
        hear(String::from_utf8_lossy(&line).trim_end_matches(['\n', '\r']).to_owned());
        line.clear();
    }
}

/// A terminal: the end that is kept, and the one that a process reads.
#[cfg(unix)]
fn terminal() -> std::io::Result<(Option<File>, Stdio)> {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::OpenOptionsExt;
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let name = ptsname(&master, Vec::new())?;
    let path = Path::new(std::ffi::OsStr::from_bytes(name.to_bytes()));
    let own = rustix::fs::OFlags::NOCTTY.bits() as i32;
    let slave = std::fs::OpenOptions::new().read(true).write(true).custom_flags(own).open(path)?;
    Ok((Some(File::from(master)), slave.into()))
}

#[cfg(not(unix))]
fn terminal() -> std::io::Result<(Option<File>, Stdio)> {
    Ok((None, Stdio::null()))
}

impl Job {
    /// Gives it a word; `prints` says whether it drives a printer, which is stopped as by Ctrl-C twice.
    ///
    /// # Errors
    ///
    /// The system's.
    pub(super) fn word(&mut self, word: JobWord, prints: bool) -> std::io::Result<()> {
        match word {
            JobWord::Stop if prints => {
                // Signals that come while one waits are one: a third makes sure of two.
                for _ in 0..3 {
                    self.signal(Signal::Interrupt)?;
                    std::thread::sleep(BETWEEN_SIGNALS);
                }
                Ok(())
            }
            JobWord::Stop => self.signal(Signal::End),
            JobWord::Pause => self.signal(Signal::Interrupt),
            JobWord::Continue => self.types("\n"),
            JobWord::Cancel => self.types("c\n"),
            JobWord::Yes => self.types("yes\n"),
        }
    }

    /// Ends it as by a word, in whatever state it is.
    pub(super) fn end(&self) {
        let _ = self.signal(Signal::End);
    }

    fn types(&mut self, text: &str) -> std::io::Result<()> {
        self.terminal.as_mut().map_or(Ok(()), |terminal| terminal.write_all(text.as_bytes()))
    }

    #[cfg(unix)]
    fn signal(&self, signal: Signal) -> std::io::Result<()> {
        use rustix::process::{Pid, Signal as Unix, kill_process, kill_process_group};
        let Some(process) = i32::try_from(self.process).ok().and_then(Pid::from_raw) else { return Ok(()) };
        let sent = match signal {
            Signal::Interrupt => kill_process(process, Unix::INT),
            Signal::End => kill_process_group(process, Unix::TERM),
        };
        Ok(sent?)
    }

    #[cfg(not(unix))]
    fn signal(&self, _: Signal) -> std::io::Result<()> {
        let _ = self.process;
        Err(std::io::ErrorKind::Unsupported.into())
    }
}

#[derive(Clone, Copy, Debug)]
enum Signal {
    Interrupt,
    End,
}
