//! A printer that is asked line by line, beside any print.

use std::time::Duration;

use super::error::PrinterError;
use crate::gcode::meaning::Firmware;
use crate::link::serial::{Address, Heard, Port};
use crate::link::{Answered, Exchange, Protocol, Wording};
use crate::world::World;

/// A board that was reset by opening the port begins within this many of the waits below.
const HELLOS: u32 = 6;
/// How long a first word is waited for.
const HELLO: Duration = Duration::from_secs(3);
/// How long a printer may say nothing in the middle of an answer; moves of the jog test take two seconds.
const PATIENCE: Duration = Duration::from_secs(20);
/// How long an answer may take in all, whatever else is said meanwhile.
const LONGEST: Duration = Duration::from_secs(60);
/// Without a byte for this long, what came before is over.
const QUIET: Duration = Duration::from_millis(300);
const NAP: Duration = Duration::from_millis(50);

/// An open port with a printer that has said who it is.
pub(crate) struct Talk<'a> {
    port: Port,
    place: String,
    protocol: Protocol,
    world: &'a World<'a>,
}

impl<'a> Talk<'a> {
    /// Opens the port and asks who is there; what it says of itself comes with it.
    ///
    /// # Errors
    ///
    /// [`PrinterError::Port`], [`PrinterError::Mute`], [`PrinterError::Stranger`] and [`PrinterError::Gone`].
    pub(crate) fn open(
        address: &Address,
        baud: u32,
        world: &'a World<'a>,
    ) -> Result<(Self, Vec<String>), PrinterError> {
        let port = world.ports.open(address, baud)?;
        let mut talk = Self { port, place: address.to_string(), protocol: Protocol::Marlin, world };
        for _ in 0..HELLOS {
            talk.drain()?;
            let (answer, wording) = (talk.say("M115", Wording::Klipper, [HELLO; 2])?, Wording::Grbl);
            let said = match &answer {
                Answered::Ok(lines) | Answered::Silent(lines) => lines.join("\n"),
                Answered::Refused(words) => words.clone(),
            };
            let who = said.contains("FIRMWARE_NAME:").then(|| Firmware::introduced(&said));
            let protocol = who.and_then(|who| Protocol::ALL.into_iter().find(|one| Some(one.firmware()) == who));
            match (answer, protocol) {
                (Answered::Ok(lines), Some(protocol)) if protocol != Protocol::Grbl => {
                    talk.protocol = protocol;
                    // A board that was slow to begin answers earlier questions still.
                    talk.drain()?;
                    return Ok((talk, lines));
                }
                (Answered::Ok(_), None) if who.is_some() => {
                    return Err(PrinterError::Stranger { place: talk.place, says: said });
                }
                _ => {}
            }
            if protocol.is_some()
                || said.lines().any(|line| line.starts_with("error:") || line.to_ascii_lowercase().starts_with("grbl"))
            {
                talk.drain()?;
                if let Answered::Ok(lines) = talk.say("$I", wording, [HELLO; 2])? {
                    talk.protocol = Protocol::Grbl;
                    return Ok((talk, lines));
                }
            }
        }
        Err(PrinterError::Mute { place: talk.place, baud, seconds: (HELLO * HELLOS).as_secs() })
    }

    /// Whose words it takes.
    pub(crate) fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// Whose words it takes, as a profile has it.
    pub(crate) fn firmware(&self) -> Firmware {
        self.protocol.firmware()
    }

    /// Sends a line and waits for its answer.
    ///
    /// # Errors
    ///
    /// [`PrinterError::Refuses`] where it is not carried out, [`PrinterError::Halfway`] where no `ok` comes, and [`PrinterError::Gone`].
    pub(crate) fn ask(&mut self, line: &str) -> Result<Vec<String>, PrinterError> {
        let place = self.place.clone();
        match self.say(line, self.protocol.wording(), [PATIENCE, LONGEST])? {
            Answered::Ok(lines) => Ok(lines),
            Answered::Refused(answer) => Err(PrinterError::Refuses { place, line: line.to_owned(), answer }),
            Answered::Silent(_) => {
                Err(PrinterError::Halfway { place, line: line.to_owned(), seconds: PATIENCE.as_secs() })
            }
        }
    }

    /// Sends a line; how long silence is waited for, and an answer in all.
    fn say(
        &mut self,
        line: &str,
        wording: Wording,
        [patience, longest]: [Duration; 2],
    ) -> Result<Answered, PrinterError> {
        let mut left = format!("{line}\n").into_bytes();
        let begun = self.world.clock.now();
        let mut exchange = Exchange::begin(wording, begun);
        loop {
            let sent = self.port.write(&left);
            left.drain(..sent);
            match self.port.read(NAP, !left.is_empty()) {
                Heard::Bytes(bytes) => exchange.receive(self.world.clock.now(), bytes),
                Heard::Gone(why) => return Err(PrinterError::Gone { place: self.place.clone(), why }),
                Heard::Nothing => {}
            }
            let now = self.world.clock.now();
            if let Some(answer) = exchange.answer(now, patience) {
                return Ok(answer);
            }
            // Words alone are no answer, however many come.
            if now > begun + longest {
                return Ok(Answered::Silent(Vec::new()));
            }
        }
    }

    /// Drops what comes by itself, so that no old word is taken for an answer.
    fn drain(&mut self) -> Result<(), PrinterError> {
        let end = self.world.clock.now() + HELLO;
        loop {
            match self.port.read(QUIET, false) {
                Heard::Gone(why) => return Err(PrinterError::Gone { place: self.place.clone(), why }),
                Heard::Bytes(_) if self.world.clock.now() < end => {}
                _ => return Ok(()),
            }
        }
    }
}
