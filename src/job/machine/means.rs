//! What a machine is moved by: lines at a port, or through Moonraker.

use super::error::MachineError;
use super::read::MachineAt;
use crate::gcode::meaning::Firmware;
use crate::job::printer::Talk;
use crate::link::{Protocol, Reply, Status, told_axes};
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
        said.iter().find_map(|line| told_axes(line))
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
        let (grbl, wording) = (self.firmware() == Firmware::Grbl, self.protocol().wording());
        let talk = match self {
            Self::Port(talk, _) => talk,
            Self::Server(console) => return Ok("XYZ".chars().zip(console.position()?).collect()),
        };
        // Grbl tells what the file's coordinates are off by in some of its reports only.
        for _ in 0..if grbl { MOST_REPORTS } else { 1 } {
            for line in talk.ask(if grbl { "?" } else { "M114" })? {
                match Reply::read(wording, line.as_bytes()) {
                    Reply::Position(words) => {
                        return Ok(words.into_iter().map(|(of, at)| (of.into(), at + 0.0)).collect());
                    }
                    // Without letters it is unknown which number behind Z is whose.
                    Reply::Status(Status { position, offset: Some(offset), .. }) => {
                        let off = offset.into_iter().chain(std::iter::repeat(0.0));
                        let words = position.into_iter().zip(off).map(|(at, off)| at - off + 0.0);
                        return Ok(order.chars().zip(words).collect());
                    }
                    _ => {}
                }
            }
        }
        Ok(Vec::new())
    }

    /// The hottest nozzle's temperature or target, degrees Celsius; 0 for a machine that heats nothing, `None` where it is not told.
    pub(super) fn hottest(&mut self) -> Result<Option<f64>, MachineError> {
        let grbl = self.firmware() == Firmware::Grbl;
        let talk = match self {
            Self::Server(console) => return Ok(console.nozzle()?.into_iter().reduce(f64::max)),
            Self::Port(_, _) if grbl => return Ok(Some(0.0)),
            Self::Port(talk, _) => talk,
        };
        Ok(hottest(&talk.ask("M105")?.join(" ")))
    }
}

/// So many of Grbl's reports have been without an offset that none has one.
const MOST_REPORTS: usize = 40;

/// The highest number of `T:21.3 /0.0 T1:240.0 /240.0 B:60.0 /60.0` that is a nozzle's; `None` without one, or where one is no number.
fn hottest(report: &str) -> Option<f64> {
    let spaced = report.replace('/', " /");
    let mut nozzle = false;
    let mut most: Option<f64> = None;
    for word in spaced.split_ascii_whitespace() {
        let number = match word.split_once(':') {
            Some((name, number)) => {
                nozzle = name.starts_with('T') && name[1..].chars().all(|c| c.is_ascii_digit());
                number
            }
            None => word.trim_start_matches('/'),
        };
        if nozzle && !number.is_empty() {
            let value = number.parse::<f64>().ok().filter(|c| c.is_finite())?;
            most = Some(most.map_or(value, |most| most.max(value)));
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::hottest;

    #[test]
    fn the_hottest_nozzle_counts_and_what_is_no_number_is_unknown() {
        for (report, wanted) in [
            ("T:21.3 /0.0 B:60.0 /60.0 @:0 B@:0", Some(21.3)),
            ("T:20.0 /0.0 T0:20.0 /0.0 T1:30.0 /240.0 @:0", Some(240.0)),
            ("B:22.0 /0.0 T0:22.0 /0.0", Some(22.0)),
            ("T:19.4/ 210.0 B:1/ 2", Some(210.0)),
            ("B:90.0 /90.0", None),
            ("T:nan /0.0", None),
            ("", None),
        ] {
            assert_eq!(hottest(report), wanted, "{report}");
        }
    }
}
