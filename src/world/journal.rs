//! The journal on disk: written before the bytes it speaks of are sent, brought to the platter in groups.
//!
//! Behind its end lie zeros, [`RESERVE`] bytes at least, which are written over: when a disk runs full in the middle of a print,
//! the head can still leave the part with every line in the journal. (A file system that never writes in place may not
//! keep that promise; then nothing more is sent.)

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crossbeam_channel::{Sender, bounded};

use super::{Disk, FileError, Files, OutputFile};
use crate::link::{Counts, Header, JournalSummary, Record};

/// Acknowledgements are written this often, and brought to the disk with them.
const GROUP: Duration = Duration::from_millis(200);

/// What a pause writes, and more.
const RESERVE: u64 = 2048;
/// By this much the reserve is renewed.
const RENEWED: [u8; 8192] = [0; 8192];

pub(crate) struct JournalFile {
    path: PathBuf,
    file: File,
    /// Behind the last record.
    end: u64,
    /// Behind the zeros.
    room: u64,
    /// What could not be written yet, for want of room.
    held: Vec<u8>,
    /// To the thread that brings it to the disk; none where the system gives no thread.
    sync: Option<Sender<()>>,
    /// Whether a record has reached the disk: the first one does before a byte goes out.
    synced: bool,
    acked: i64,
    written: Instant,
}

impl JournalFile {
    /// A new journal, written over what was there: one that is still wanted has been put aside before.
    pub(crate) fn create(output: &OutputFile, header: &Header) -> Result<Self, FileError> {
        let failed = |source| FileError::Write { path: output.path().to_owned(), source };
        let mut file = output.create()?;
        let text = header.to_text();
        file.write_all(text.as_bytes()).map_err(failed)?;
        Self::over(output.path(), file, text.len() as u64)
    }

    /// The journal of a print that goes on.
    pub(crate) fn reopen(path: &Path) -> Result<Self, FileError> {
        let failed = |source| FileError::Write { path: path.to_owned(), source };
        let bytes = Disk.read(path)?;
        let written = memchr::memchr(0, &bytes).unwrap_or(bytes.len());
        // A torn last line would spoil the next.
        let end = memchr::memrchr(b'\n', &bytes[..written]).map_or(0, |i| i as u64 + 1);
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
        file.set_len(end).map_err(failed)?;
        Self::over(path, file, end)
    }

    fn over(path: &Path, file: File, end: u64) -> Result<Self, FileError> {
        let failed = |source| FileError::Write { path: path.to_owned(), source };
        let twin = file.try_clone().map_err(failed)?;
        let (sync, asked) = bounded::<()>(1);
        let beside = std::thread::Builder::new().spawn(move || {
            while asked.recv().is_ok() {
                let _ = twin.sync_data();
            }
        });
        let sync = beside.is_ok().then_some(sync);
        let (path, held) = (path.to_owned(), Vec::new());
        let mut journal =
            Self { path, file, end, room: end, held, sync, synced: false, acked: 0, written: Instant::now() };
        journal.renew().map_err(failed)?;
        // A journal that cannot reach the disk is found out now.
        journal.file.sync_data().map_err(failed)?;
        Ok(journal)
    }

    /// Keeps room for what a pause writes.
    ///
    /// # Errors
    ///
    /// The system's, where the disk takes no more; what is kept already can still be written.
    pub(crate) fn renew(&mut self) -> std::io::Result<()> {
        while self.room < self.end + RESERVE {
            self.file.seek(SeekFrom::Start(self.room))?;
            match self.file.write(&RENEWED)? {
                0 => return Err(ErrorKind::WriteZero.into()),
                n => self.room += n as u64,
            }
        }
        Ok(())
    }

    /// As on a disk that takes nothing.
    #[cfg(test)]
    pub(crate) fn takes_nothing(&mut self) {
        (self.file, self.room) = (File::open(&self.path).expect("it was written just now"), self.end);
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a record; `false` where the disk takes nothing, and nothing may be sent until it does.
    pub(crate) fn record(&mut self, record: &Record) -> bool {
        self.held.extend_from_slice(record.to_text().as_bytes());
        self.retry()
    }

    /// Tries again what was held.
    pub(crate) fn retry(&mut self) -> bool {
        while !self.held.is_empty() {
            let fits = self.end + self.held.len() as u64 <= self.room;
            if !fits && self.renew().is_err() {
                return false;
            }
            match self.at_end().and_then(|()| self.file.write(&self.held)) {
                Ok(0) | Err(_) => return false,
                Ok(n) => {
                    self.end += n as u64;
                    // More than was kept: the next zeros begin behind it.
                    self.room = self.room.max(self.end);
                    drop(self.held.drain(..n));
                    if !std::mem::replace(&mut self.synced, true) {
                        // A disk that cannot is found out where the journal is opened.
                        let _ = self.file.sync_data();
                    }
                }
            }
        }
        true
    }

    fn at_end(&mut self) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(self.end)).map(|_| ())
    }

    /// Writes how far the printer is, now and then.
    pub(crate) fn progress(&mut self, progress: Counts, now: bool) -> bool {
        if progress.proven == self.acked || (!now && self.written.elapsed() < GROUP) {
            return self.held.is_empty();
        }
        self.written = Instant::now();
        self.acked = progress.proven;
        let written = self.record(&Record::Ack { number: progress.proven, block: progress.acked });
        match &self.sync {
            Some(beside) => drop(beside.try_send(())),
            // Here it holds up the print for as long as the disk takes.
            None => drop(self.file.sync_data()),
        }
        written
    }
}

impl Drop for JournalFile {
    /// The zeros go; a host that is killed leaves them, which does no harm.
    fn drop(&mut self) {
        let _ = self.file.set_len(self.end);
    }
}

/// What a journal says.
pub(crate) fn read(path: &Path) -> Result<JournalSummary, FileError> {
    let text =
        String::from_utf8(Disk.read(path)?).map_err(|_| FileError::NotText { name: path.display().to_string() })?;
    JournalSummary::parse(&text).map_err(|source| FileError::Journal { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Outputs;

    #[test]
    fn zeros_never_go_over_records_that_are_longer_than_the_reserve() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("journal");
        let mut journal = JournalFile::create(&Outputs::new(None).claim(&path).unwrap(), &Header::default()).unwrap();
        // As after a while without room: more is held than one renewal keeps.
        let long = Record::Printer("x".repeat(3 * RENEWED.len()));
        assert!(journal.record(&long) && journal.record(&Record::Run { number: 3, block: 0 }));
        journal.renew().unwrap();
        assert!(journal.record(&Record::Ack { number: 9, block: 6 }));
        drop(journal);
        let text = Header::default().to_text() + &long.to_text() + "run 3 0\nack 9 6\n";
        assert!(std::fs::read_to_string(&path).unwrap() == text, "zeros between the records");
        assert_eq!(read(&path).unwrap().answered, 6);
    }
}
