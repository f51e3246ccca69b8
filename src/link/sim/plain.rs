//! Klipper's pty and `RepRapFirmware` over USB: one `ok` a line.
//!
//! Klipper ignores numbers and checksums; `RepRapFirmware` drops a line with a wrong checksum without a word.

use super::machine::Refusal;
use super::marlin::{integer, strip_number};
use super::{Logged, Queued, Sim, Took};
use crate::link::protocol::Protocol;
use crate::link::wire::checksum;

impl Sim {
    pub(super) fn work_plain(&mut self) {
        // Both look for it while they receive.
        if memchr::memmem::find(self.rx.make_contiguous(), b"M112").is_some() {
            let emergency = Queued { block: b"M112".to_vec(), number: None, begun: true };
            self.queue.clear();
            self.answer_plain(&emergency);
            return;
        }
        loop {
            if self.queue.is_empty() {
                let Some(line) = self.next_rx_line() else { return };
                let Some(block) = self.plain_line(&line) else { continue };
                self.queue.push_back(Queued { block, number: None, begun: false });
            }
            if !self.execute_plain() {
                return;
            }
        }
    }

    /// The block of a line; `None` where nothing more is to be said or done.
    fn plain_line(&mut self, line: &[u8]) -> Option<Vec<u8>> {
        let code = line.split(|b| *b == b';').next().unwrap_or_default().trim_ascii();
        if self.protocol == Protocol::Klipper {
            let body = code.split(|b| *b == b'*').next().unwrap_or_default();
            let block = strip_number(body).to_vec();
            if block.is_empty() {
                self.say_ok("ok");
                return None;
            }
            return Some(block);
        }
        if code.is_empty() {
            return None;
        }
        if let Some(star) = code.iter().rposition(|b| *b == b'*') {
            if i64::from(checksum(&code[..star])) != integer(&code[star + 1..]) {
                if self.quirks.tells_bad_sums {
                    self.say(&format!("Checksum error on line {}", integer(code.get(1..).unwrap_or_default())));
                    self.say_ok("ok");
                }
                return None;
            }
            return Some(strip_number(&code[..star]).to_vec());
        }
        Some(strip_number(code).to_vec())
    }

    fn execute_plain(&mut self) -> bool {
        let Some(mut command) = self.queue.pop_front() else { return false };
        if !command.begun {
            command.begun = true;
            if self.answer_plain(&command) {
                return true;
            }
        }
        match self.machine.execute(self.now, &command.block) {
            Took::Again | Took::At(_) | Took::Heat { .. } | Took::Person(_) => {
                self.queue.push_front(command);
                false
            }
            Took::Refused(refusal) => {
                self.refuse_plain(&command.block, &refusal);
                true
            }
            Took::Cold => {
                if self.protocol == Protocol::Klipper {
                    self.say("!! Extrude below minimum temp");
                    self.say("// See the 'min_extrude_temp' config option for details");
                } else {
                    self.say("Error: not extruding, tool too cold");
                }
                self.say_ok("ok");
                true
            }
            Took::Done => {
                self.note(Logged::Accepted(command.block));
                self.say_ok("ok");
                true
            }
        }
    }

    fn refuse_plain(&mut self, block: &[u8], refusal: &Refusal) {
        let text = String::from_utf8_lossy(block).into_owned();
        let klipper = self.protocol == Protocol::Klipper;
        let said = match refusal {
            Refusal::Unknown if klipper => format!("// Unknown command:\"{text}\""),
            Refusal::Unknown => format!("Error: Bad command: {text}"),
            Refusal::Beyond([x, y, z, .., e]) if klipper => {
                format!("!! Move out of range: {x:.3} {y:.3} {z:.3} [{e:.3}]")
            }
            Refusal::Beyond(_) => "Error: G0/G1: target position outside machine limits".to_owned(),
            Refusal::NotHomed if klipper => "!! Must home axis first".to_owned(),
            Refusal::NotHomed => "Error: G0/G1: insufficient axes homed".to_owned(),
            Refusal::NoFeed => "// no feed rate yet".to_owned(),
        };
        self.say(&said);
        self.say_ok("ok");
    }

    fn answer_plain(&mut self, command: &Queued) -> bool {
        let klipper = self.protocol == Protocol::Klipper;
        let head: Vec<u8> = command.block.iter().copied().take(4).collect();
        match head.as_slice() {
            b"M105" => {
                let (nozzle, bed) = (&self.machine.nozzle, &self.machine.bed);
                let (n, b) = (nozzle.at(self.now), bed.at(self.now));
                let text = if klipper {
                    format!("ok B:{b:.1} /{:.1} T0:{n:.1} /{:.1}", bed.target(), nozzle.target())
                } else {
                    format!("ok T:{n:.1} /{:.1} B:{b:.1} /{:.1}", nozzle.target(), bed.target())
                };
                self.note(Logged::Accepted(command.block.clone()));
                self.say_ok(&text);
                return true;
            }
            b"M115" if klipper => {
                let text = self.quirks.answer("ok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.13.0-1");
                self.say_ok(&text);
                return true;
            }
            b"M115" => {
                let name = &self.quirks.name;
                let own =
                    format!("FIRMWARE_NAME: RepRapFirmware for {name} FIRMWARE_VERSION: 3.6.0 ELECTRONICS: {name}");
                let text = self.quirks.answer(self.quirks.identity.unwrap_or(&own));
                self.say(&text);
                self.say_ok("ok");
                return true;
            }
            b"M114" => {
                let text = self.where_it_is();
                self.say(&text);
            }
            b"M409" if !klipper => {
                self.say_model(&command.block);
                self.say_ok("ok");
                return true;
            }
            b"M112" => {
                if klipper {
                    self.say("// Klipper state: Shutdown");
                    self.say("!! Shutdown due to M112 command");
                    self.say("ok");
                }
                self.die();
                return true;
            }
            _ => {}
        }
        false
    }
}
