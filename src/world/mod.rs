//! What a job touches beyond its own values, as traits, and the real thing: this computer. It must not know models, plans or jobs.
//!
//! A job that reads its model from memory:
//!
//! ```
//! use std::path::Path;
//! use trunnion::input::load_model;
//! use trunnion::world::{Disk, FileError, Files, Silent, World};
//!
//! /// A folder with one model in it, all in memory.
//! struct Memory(Vec<u8>);
//!
//! impl Files for Memory {
//!     fn size(&self, _: &Path) -> Result<u64, FileError> {
//!         Ok(self.0.len() as u64)
//!     }
//!     fn read(&self, _: &Path) -> Result<Vec<u8>, FileError> {
//!         Ok(self.0.clone())
//!     }
//!     fn exists(&self, path: &Path) -> bool {
//!         path == Path::new("cube.stl")
//!     }
//! }
//!
//! let memory = Memory(Disk.read(Path::new("fixtures/cube.stl"))?);
//! let world = World { files: &memory, ..World::here(&Silent) };
//! assert_eq!(load_model(&"cube.stl".into(), &world)?.model.parts.len(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod desktop;
mod disk;
mod error;
pub(crate) mod interrupts;
mod journal;
mod leftovers;
mod names;
mod outputs;
#[cfg(feature = "tls")]
mod pinned;
mod progress;
mod shown;
mod slicers;
mod threads;
mod web;

use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::link::serial::{self, Address, Port, PortError, Server};
use crate::publish::Web;
use crate::slicing::{Interrupt, Slicer, SlicerChoice};
pub use desktop::open_in_browser;
pub use disk::{Disk, with_suffix};
pub use error::{FileError, NoSlicer, in_words, remedy};
pub(crate) use journal::{JournalFile, read as read_journal};
pub use outputs::{OutputFile, Outputs};
pub use progress::{Bar, Logging, Progress, Silent};
pub use shown::shown_line;
pub use slicers::Installed;
pub(crate) use slicers::scratch;
pub(crate) use threads::start_threads;
pub use web::{OwnWeb, key_from_environment};

/// What a job touches beyond its own values.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// What can be read.
    pub files: &'a dyn Files,
    /// What can slice.
    pub slicers: &'a dyn Slicers,
    /// What leads to printers.
    pub ports: &'a dyn Ports,
    /// What leads to servers.
    pub web: &'a dyn Web,
    /// The time.
    pub clock: &'a dyn Clock,
    /// Whoever watches.
    pub progress: &'a dyn Progress,
    /// Bytes of memory that reading an input may take, as far as that can be told beforehand; `None`: as many as there are.
    pub memory: Option<u64>,
}

/// Files as jobs read them.
pub trait Files {
    /// The size of a file that can be read, bytes.
    ///
    /// # Errors
    ///
    /// [`FileError::Read`], and what cannot be read whole: [`FileError::NotAFile`], [`FileError::TooLarge`].
    fn size(&self, path: &Path) -> Result<u64, FileError>;

    /// The whole of a file.
    ///
    /// # Errors
    ///
    /// As [`Files::size`].
    fn read(&self, path: &Path) -> Result<Vec<u8>, FileError>;

    /// Whether there is anything of this name.
    fn exists(&self, path: &Path) -> bool;

    /// The folder with the user's own profiles, where there can be one.
    fn own_profiles(&self) -> Option<PathBuf> {
        None
    }

    /// The TOML files of a folder, by name; none where it is not there.
    fn toml_files(&self, folder: &Path) -> Vec<PathBuf> {
        let _ = folder;
        Vec::new()
    }

    /// The names of all files of a folder, in order; none where it is not there.
    fn names_in(&self, folder: &Path) -> Vec<String> {
        let _ = folder;
        Vec::new()
    }

    /// The path of `file` as seen from `folder`; as it is where that cannot be told.
    fn seen_from(&self, file: &Path, folder: &Path) -> PathBuf {
        let _ = folder;
        file.to_owned()
    }
}

/// Slicers as jobs ask for them.
pub trait Slicers {
    /// The slicer of `choice`, over whose settings the user's own `configs` go, in rising order of precedence; it is given
    /// up after `timeout` for one print.
    ///
    /// # Errors
    ///
    /// [`NoSlicer`] where there is none that can be driven.
    fn find(&self, choice: &SlicerChoice, configs: &[PathBuf], timeout: Duration) -> Result<Box<dyn Slicer>, NoSlicer>;
}

/// The time, from any moment on.
pub trait Clock {
    /// Now; never less than before.
    fn now(&self) -> Duration;

    /// Returns after `time`.
    fn sleep(&self, time: Duration);

    /// What tells this run of the operating system from any other; empty where nobody knows.
    fn boot(&self) -> String;

    /// The day by UTC, as `2026-11-28`; `None` where nobody knows.
    fn today(&self) -> Option<String> {
        None
    }

    /// A number that no other run has had.
    fn nonce(&self) -> u64 {
        // Its keys are the system's random numbers.
        RandomState::new().hash_one(self.now())
    }
}

/// Ports as jobs ask for them.
pub trait Ports {
    /// The port at `address`, at `baud` bits a second.
    ///
    /// # Errors
    ///
    /// [`PortError`] where it is not there, or cannot be had.
    fn open(&self, address: &Address, baud: u32) -> Result<Port, PortError>;

    /// A place where hosts can connect to a simulated printer: a link to be made to a pseudo-terminal, `tcp:PORT`, or
    /// `tcp:host:port`.
    ///
    /// # Errors
    ///
    /// [`PortError`] where it cannot be had.
    fn serve(&self, place: &str) -> Result<Server, PortError>;

    /// The name that a device keeps wherever it is plugged in, from the folder of such names.
    fn identity(&self, device: &Path, folder: &Path) -> Option<String>;

    /// Where the device of `identity` is now.
    fn find_again(&self, address: &Address, identity: Option<&str>, folder: &Path) -> Address;
}

/// This computer's ports.
#[derive(Clone, Copy, Debug, Default)]
pub struct OwnPorts;

impl Ports for OwnPorts {
    fn open(&self, address: &Address, baud: u32) -> Result<Port, PortError> {
        Port::open(address, baud)
    }

    fn serve(&self, place: &str) -> Result<Server, PortError> {
        Server::open(place)
    }

    fn identity(&self, device: &Path, folder: &Path) -> Option<String> {
        serial::identity(device, folder)
    }

    fn find_again(&self, address: &Address, identity: Option<&str>, folder: &Path) -> Address {
        serial::find_again(address, identity, folder)
    }
}

/// This computer's clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemClock;

impl Clock for SystemClock {
    fn now(&self) -> Duration {
        // The zero of the system's one clock: whoever prints counts from it, and nothing changes it.
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed()
    }

    fn sleep(&self, time: Duration) {
        std::thread::sleep(time);
    }

    fn today(&self) -> Option<String> {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).ok()?;
        let [year, month, day] = civil(i64::try_from(since.as_secs() / 86_400).ok()?);
        Some(format!("{year:04}-{month:02}-{day:02}"))
    }

    fn boot(&self) -> String {
        std::fs::read_to_string("/proc/sys/kernel/random/boot_id").map(|id| id.trim().to_owned()).unwrap_or_default()
    }
}

/// Year, month and day of so many days after 1970-01-01 (H. Hinnant, *chrono-Compatible Low-Level Date Algorithms*, `civil_from_days`).
fn civil(days: i64) -> [i64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    // Months from March on.
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    [year + era * 400 + i64::from(month <= 2), month, day]
}

impl<'a> World<'a> {
    /// This computer, with `progress` watching.
    pub fn here(progress: &'a dyn Progress) -> Self {
        Self {
            files: &Disk,
            slicers: &Installed { interrupt: |_| Interrupt::default() },
            ports: &OwnPorts,
            web: &OwnWeb,
            clock: &SystemClock,
            progress,
            memory: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::civil;

    #[test]
    fn days_are_dates() {
        for (days, date) in [
            (0, [1970, 1, 1]),
            (59, [1970, 3, 1]),
            (11_016, [2000, 2, 29]),
            (11_017, [2000, 3, 1]),
            (20_785, [2026, 11, 28]),
            (47_540, [2100, 2, 28]),
            (47_541, [2100, 3, 1]),
        ] {
            assert_eq!(civil(days), date, "{days}");
        }
    }
}
