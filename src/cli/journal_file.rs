//! The journal on disk: written before the bytes it speaks of are sent, brought to the platter in groups.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crossbeam_channel::{Sender, bounded};

use super::Failure;
use crate::link::{Header, JournalError, Progress, Record, Standing};

/// Acknowledgements are written this often, and brought to the disk with them.
const GROUP: Duration = Duration::from_millis(200);

pub(super) struct JournalFile {
    path: PathBuf,
    file: File,
    /// What could not be written yet, for want of room.
    held: Vec<u8>,
    sync: Sender<()>,
    acked: i64,
    written: Instant,
}

impl JournalFile {
    /// A new journal; one of an earlier print is put aside.
    pub(super) fn create(path: &Path, header: &Header) -> Result<Self, Failure> {
        let failed = |source| Failure::Write { path: path.to_owned(), source };
        let file = File::create(path).map_err(failed)?;
        let mut journal = Self::over(path, file)?;
        journal.file.write_all(header.to_text().as_bytes()).map_err(failed)?;
        // A journal that cannot reach the disk is found out now.
        journal.file.sync_data().or_else(not_a_file).map_err(failed)?;
        Ok(journal)
    }

    /// The journal of a print that goes on.
    pub(super) fn reopen(path: &Path) -> Result<Self, Failure> {
        let failed = |source| Failure::Write { path: path.to_owned(), source };
        let mut file = OpenOptions::new().read(true).append(true).open(path).map_err(failed)?;
        // A torn last line would spoil the next.
        if std::fs::read(path).is_ok_and(|bytes| !bytes.ends_with(b"\n")) {
            let whole = std::fs::read(path).map_err(failed)?;
            let end = whole.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
            file.set_len(end as u64).map_err(failed)?;
        }
        file.flush().map_err(failed)?;
        Self::over(path, file)
    }

    fn over(path: &Path, file: File) -> Result<Self, Failure> {
        let failed = |source| Failure::Write { path: path.to_owned(), source };
        let twin = file.try_clone().map_err(failed)?;
        let (sync, asked) = bounded::<()>(1);
        std::thread::spawn(move || {
            while asked.recv().is_ok() {
                let _ = twin.sync_data();
            }
        });
        Ok(Self { path: path.to_owned(), file, held: Vec::new(), sync, acked: 0, written: Instant::now() })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a record; `false` where the disk takes nothing, and nothing may be sent until it does.
    pub(super) fn record(&mut self, record: &Record) -> bool {
        self.held.extend_from_slice(record.to_text().as_bytes());
        self.retry()
    }

    /// Tries again what was held.
    pub(super) fn retry(&mut self) -> bool {
        while !self.held.is_empty() {
            match self.file.write(&self.held) {
                Ok(0) | Err(_) => return false,
                Ok(n) => drop(self.held.drain(..n)),
            }
        }
        true
    }

    /// Writes how far the printer is, now and then.
    pub(super) fn progress(&mut self, progress: Progress, now: bool) -> bool {
        if progress.proven == self.acked || (!now && self.written.elapsed() < GROUP) {
            return self.held.is_empty();
        }
        self.written = Instant::now();
        self.acked = progress.proven;
        let written = self.record(&Record::Ack { number: progress.proven, block: progress.acked });
        let _ = self.sync.try_send(());
        written
    }
}

/// Pipes and character devices cannot be synchronised, and need not.
fn not_a_file(error: std::io::Error) -> std::io::Result<()> {
    if error.kind() == std::io::ErrorKind::InvalidInput { Ok(()) } else { Err(error) }
}

/// What a journal says.
pub(super) fn read(path: &Path) -> Result<Standing, Failure> {
    // A device would be read without end.
    if path.exists() && !path.is_file() {
        return Err(Failure::Usage(format!("{}: not a file", path.display())));
    }
    let text = super::files::read_text(path)?;
    Standing::parse(&text).map_err(|e: JournalError| Failure::Usage(format!("{}: {e}", path.display())))
}

/// What tells this boot of the host from any other; empty where the system does not say.
pub(super) fn boot() -> String {
    std::fs::read_to_string("/proc/sys/kernel/random/boot_id").map(|id| id.trim().to_owned()).unwrap_or_default()
}
