//! What a machine is moved by: lines at a port, or through Moonraker.

use super::error::MachineError;
use super::read::MachineAt;
use crate::gcode::meaning::Firmware;
use crate::job::printer::Talk;
use crate::link::{Protocol, Reply};
use crate::publish::{Inquiry, ServerConsole};
use crate::world::World;

/// A printer that takes lines.
pub(super) enum Means<'a> {
    /// At a port; what it said of itself.
    Port(Talk<'a>, Vec<String>),
    /// Klipper behind Moonraker.
    Server(ServerConsole<'a>),
}

impl<'a> Means<'a> {
    /// The printer at `at`; `baud` where that names none.
    pub(super) fn open(at: &'a MachineAt, baud: u32, world: &'a World<'a>) -> Result<Self, MachineError> {
        Ok(match at {
            MachineAt::Port { address, baud: own } => {
                let (talk, said) = Talk::open(address, own.unwrap_or(baud), world)?;
                Self::Port(talk, said)
            }
            MachineAt::Server { address, key, silence, fingerprint } => {
                let asked = Inquiry { address, key: key.as_ref(), silence: *silence, fingerprint: *fingerprint };
                Self::Server(ServerConsole::open(&asked, world.web)?)
            }
        })
    }

    pub(super) fn protocol(&self) -> Protocol {
        match self {
            Self::Port(talk, _) => talk.protocol(),
            Self::Server(_) => Protocol::Klipper,
        }
    }

    pub(super) fn firmware(&self) -> Firmware {
        self.protocol().firmware()
    }

    /// The letters of all axes in grblHAL's own order.
    pub(super) fn order(&self) -> Option<&str> {
        let Self::Port(_, said) = self else { return None };
        said.iter().find_map(|line| line.strip_prefix("[AXS:")?.split([':', ']']).nth(1))
    }

    pub(super) fn run(&mut self, line: &str) -> Result<(), MachineError> {
        match self {
            Self::Port(talk, _) => Ok(talk.ask(line).map(drop)?),
            Self::Server(console) => Ok(console.run(line)?),
        }
    }

    /// The words at which the axes stand, as far as the machine tells them.
    pub(super) fn position(&mut self) -> Result<Vec<(char, f64)>, MachineError> {
        let order = self.order().unwrap_or("XYZ").to_owned();
        let (asks, wording) = (if self.firmware() == Firmware::Grbl { "?" } else { "M114" }, self.protocol().wording());
        let said = match self {
            Self::Port(talk, _) => talk.ask(asks)?,
            Self::Server(console) => return Ok("XYZ".chars().zip(console.position()?).collect()),
        };
        for line in said {
            match Reply::read(wording, line.as_bytes()) {
                Reply::Position(words) => return Ok(words.into_iter().map(|(of, at)| (of.into(), at)).collect()),
                // Without letters it is unknown which number behind Z is whose.
                Reply::Status(status) => return Ok(order.chars().zip(status.position).collect()),
                _ => {}
            }
        }
        Ok(Vec::new())
    }

    /// The nozzle's temperature and what it shall become, degrees Celsius; `None` for a machine that heats nothing.
    pub(super) fn nozzle(&mut self) -> Result<Option<[f64; 2]>, MachineError> {
        let (grbl, wording) = (self.firmware() == Firmware::Grbl, self.protocol().wording());
        let talk = match self {
            Self::Server(console) => return Ok(Some(console.nozzle()?)),
            Self::Port(_, _) if grbl => return Ok(None),
            Self::Port(talk, _) => talk,
        };
        for line in talk.ask("M105")? {
            let answer = format!("ok {line}");
            if let Reply::Ok { report: Some(heat), .. } = Reply::read(wording, answer.as_bytes()) {
                return Ok(heat.nozzle);
            }
        }
        Ok(None)
    }
}
