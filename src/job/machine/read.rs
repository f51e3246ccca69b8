//! What a connected machine says of itself, as one text that `import_profile` reads.

use std::time::Duration;

use super::error::MachineError;
use crate::gcode::meaning::Firmware;
use crate::input::Source;
use crate::job::printer::{PrinterError, Talk};
use crate::link::serial::Address;
use crate::publish::{Fingerprint, Inquiry, Key, MACHINE_KEYS, MOST_AXES, ServerAddress, configuration};
use crate::world::World;

/// Bits a second of most boards.
const USUAL_BAUD: u32 = 115_200;

/// Where the machine is.
#[derive(Clone, Debug)]
pub enum MachineAt {
    /// At a port, asked by lines.
    Port {
        /// The port.
        address: Address,
        /// Bits a second; `None` for the usual.
        baud: Option<u32>,
    },
    /// Behind a server.
    Server {
        /// The server.
        address: ServerAddress,
        /// What opens it.
        key: Option<Key>,
        /// How long it may say nothing.
        silence: Duration,
        /// The only certificate that is taken.
        fingerprint: Option<Fingerprint>,
    },
}

/// Asks a machine for its settings; nothing is moved, heated or changed. `name` is what the text is called in messages.
///
/// # Errors
///
/// [`MachineError::Printer`] and [`MachineError::Server`] for what does not answer, and [`MachineError::Speechless`] for a firmware that tells nothing
/// over a port.
pub fn read_machine(from: &MachineAt, name: &str, world: &World<'_>) -> Result<Source, MachineError> {
    let text = match from {
        MachineAt::Port { address, baud } => at_port(address, baud.unwrap_or(USUAL_BAUD), world)?,
        MachineAt::Server { address, key, silence, fingerprint } => {
            let asked = Inquiry { address, key: key.as_ref(), silence: *silence, fingerprint: *fingerprint };
            configuration(&asked, world.web)?
        }
    };
    Ok(Source::Bytes { name: name.to_owned(), bytes: text.into_bytes() })
}

fn at_port(address: &Address, baud: u32, world: &World<'_>) -> Result<String, MachineError> {
    let (mut talk, said) = Talk::open(address, baud, world)?;
    let mut kept = Kept(String::new());
    match talk.firmware() {
        Firmware::Klipper => return Err(MachineError::Speechless),
        Firmware::Grbl => {
            kept.take("$I", &said);
            kept.ask(&mut talk, "$$")?;
        }
        Firmware::RepRapFirmware => {
            kept.take("M115", &said);
            for i in 0..MOST_AXES {
                let answer = kept.ask(&mut talk, &format!("M409 K\"move.axes[{i}]\" F\"v\""))?;
                if answer.iter().any(|line| line.replace(' ', "").ends_with("\"result\":null}")) {
                    break;
                }
            }
            for key in MACHINE_KEYS {
                kept.ask(&mut talk, &format!("M409 K\"{key}\" F\"v\""))?;
            }
        }
        _ => {
            kept.take("M115", &said);
            kept.ask(&mut talk, "M503")?;
            // Not there in a firmware without software endstops: its limits are asked then.
            match kept.ask(&mut talk, "M211") {
                Err(MachineError::Printer(PrinterError::Refuses { answer, .. })) => kept.take("M211", &[answer]),
                done => drop(done?),
            }
        }
    }
    Ok(kept.0)
}

/// What was asked and answered, line by line.
struct Kept(String);

impl Kept {
    fn take(&mut self, asked: &str, said: &[String]) {
        self.0 += &format!(">>> {asked}\n");
        said.iter().for_each(|line| self.0 += &format!("{line}\n"));
    }

    fn ask(&mut self, talk: &mut Talk<'_>, line: &str) -> Result<Vec<String>, MachineError> {
        let said = talk.ask(line)?;
        self.take(line, &said);
        Ok(said)
    }
}
