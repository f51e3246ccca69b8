//! A finished file to the server that drives a printer: OctoPrint, Moonraker, or a Duet's own.
//!
//! ```text
//! Delivery{ file, where to } + &dyn Web --deliver--> Delivered     every request and every answer; nothing here opens a socket
//! ```
//!
//! Addresses and names are checked before anything is sent:
//!
//! ```
//! use trunnion::gcode::meaning::Firmware;
//! use trunnion::publish::{BadInput, Kind, ServerAddress, file_name};
//!
//! let address = ServerAddress::parse("moonraker:http://printer.local:7125/")?;
//! assert_eq!((address.kind, address.url()), (Kind::Moonraker, "http://printer.local:7125"));
//!
//! // Moonraker drives Klipper alone, so that a program for Marlin is refused before anything is sent.
//! assert!(address.kind.takes(Firmware::Klipper, "fractal-5-pro").is_ok());
//! assert!(matches!(address.kind.takes(Firmware::Marlin, "generic-ac"), Err(BadInput::Firmware { .. })));
//!
//! // A login in an address would come into logs; a name with a folder in it would be another file there.
//! assert_eq!(ServerAddress::parse("duet:http://me:word@printer.local"), Err(BadInput::Secret));
//! assert_eq!(file_name("bracket.gcode")?, "bracket.gcode");
//! assert!(file_name("../bracket.gcode").is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A server is asked who it is, what it has under the file's name and how much room it has; the file goes there once, is compared
//! with what arrived, and is started only where that was asked for and the server says that its printer stands idle. What was lost
//! on the way is looked for before it is sent again, so that there is never a second copy, and what arrived in part is taken away.
//! A key is in no error, no text and no value that can be printed.
//!
//! Sizes in bytes, times in seconds, filament in millimetres.
//!
//! Sources: docs.octoprint.org "REST API" (1.11), moonraker.readthedocs.io "External API", the wiki page "HTTP requests" and
//! `Developer-documentation/OpenAPI.yaml` (3.6.0) of RepRapFirmware.
//!
//! This room must not know profiles, plans or files.

mod address;
mod api;
mod configuration;
mod console;
mod deliver;
mod duet;
mod fault;
mod fingerprint;
mod form;
mod line;
mod moonraker;
mod octoprint;
#[cfg(test)]
mod tests;
mod web;

pub use address::{BadInput, Key, Kind, ServerAddress, file_name};
pub use api::{Delivered, Delivery};
pub use configuration::{Inquiry, MACHINE_KEYS, MOST_AXES, configuration};
pub use console::ServerConsole;
pub use deliver::deliver;
pub use fault::{PublishError, ServerFault};
pub use fingerprint::Fingerprint;
pub use web::{Ask, HttpMethod, ServerAnswer, Trouble, Web};

/// What a file takes: as we state it, or as a server shows it; `None` where nobody says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UploadFigures {
    /// Time to print, s.
    pub seconds: Option<f64>,
    /// Filament, mm.
    pub filament_mm: Option<f64>,
    /// Layers of all prints together.
    pub layers: Option<u64>,
}
