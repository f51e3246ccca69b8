//! Grbl's side, and its heirs': real-time bytes, `ok` or `error:` a line, alarms, status reports.
//!
//! After Grbl 1.1h (`protocol.c`, `report.c`, `serial.c`) and grblHAL's latched errors.

use super::machine::Refusal;
use super::marlin::strip_number;
use super::{Logged, Queued, Sim, Took};
use crate::motion::lookahead::DEPTH;

/// Bytes that act when they arrive, wherever they stand.
pub(super) fn is_real_time(byte: u8) -> bool {
    matches!(byte, b'?' | b'!' | b'~' | 0x18 | 0x80..)
}

/// In so many reports once it tells its work offset.
const OFFSET_EVERY: u32 = 10;

/// Grbl's longest line; grblHAL and FluidNC take 255.
const LONGEST: usize = 80;
const LONGEST_HEIR: usize = 255;

impl Sim {
    pub(super) fn greet_grbl(&mut self) {
        let text = if self.quirks.latches_errors {
            "GrblHAL 1.1f ['$' or '$HELP' for help]"
        } else {
            "Grbl 1.1h ['$' for help]"
        };
        self.say(text);
        if self.alarm {
            self.say("[MSG:'$H'|'$X' to unlock]");
        }
    }

    pub(super) fn real_time(&mut self, byte: u8) {
        match byte {
            b'?' => {
                self.reports += 1;
                let text = self.status();
                self.say(&text);
            }
            b'!' => self.machine.planner.hold(self.now),
            b'~' => {
                self.machine.planner.release(self.now);
                if self.person {
                    self.machine.end_wait(self.now);
                }
            }
            0x18 => self.soft_reset(),
            _ => {}
        }
    }

    /// In motion the position is lost: ALARM:3. In hold it is not.
    fn soft_reset(&mut self) {
        let moving = !self.machine.planner.is_idle() && !self.machine.planner.is_held();
        self.machine.kill(self.now);
        self.queue.clear();
        self.rx.clear();
        (self.latched, self.person) = (0, false);
        if moving {
            self.alarm = true;
            self.say("ALARM:3");
        }
        self.note(Logged::Restarted);
        self.greet_grbl();
    }

    fn status(&self) -> String {
        let state = if self.alarm {
            "Alarm"
        } else if self.machine.planner.is_held() {
            "Hold:0"
        } else if self.machine.planner.is_idle() && self.queue.is_empty() {
            "Idle"
        } else {
            "Run"
        };
        let at = self.machine.planner.position(self.now);
        let off = &self.quirks.work_offset;
        let place: Vec<String> = at.iter().zip(off).map(|(at, off)| format!("{:.3}", at + off)).collect();
        let held: usize = self.queue.iter().map(|c| c.block.len() + 1).sum();
        let free = self.quirks.receive_buffer.saturating_sub(self.rx.len() + held);
        let offset = if self.reports.is_multiple_of(OFFSET_EVERY) {
            format!("|WCO:{}", off.map(|off| format!("{off:.3}")).join(","))
        } else {
            String::new()
        };
        format!("<{state}|MPos:{}|Bf:{},{free}|FS:0,0{offset}>", place.join(","), self.machine.planner.free())
    }

    pub(super) fn work_grbl(&mut self) {
        loop {
            if self.queue.is_empty() {
                let Some(line) = self.next_rx_line() else { return };
                self.queue.push_back(Queued { block: line, number: None, begun: false });
            }
            let Some(mut line) = self.queue.pop_front() else { return };
            let answer = if line.begun { None } else { self.grbl_system(&line.block) };
            if !line.begun && answer.is_none() {
                let code: Vec<u8> = strip_number(&without_comment(&line.block)).to_vec();
                line.block = code;
            }
            line.begun = true;
            match answer {
                Some(0) => self.say_ok("ok"),
                Some(code) => self.grbl_error(code),
                None => match self.machine.execute(self.now, &line.block) {
                    Took::Again | Took::At(_) | Took::Heat { .. } => {
                        self.queue.push_front(line);
                        return;
                    }
                    Took::Person(_) => {
                        self.person = true;
                        self.queue.push_front(line);
                        return;
                    }
                    Took::Refused(refusal) => self.grbl_refused(&refusal),
                    Took::Done | Took::Cold => {
                        self.note(Logged::Accepted(line.block));
                        self.say_ok("ok");
                    }
                },
            }
        }
    }

    fn grbl_refused(&mut self, refusal: &Refusal) {
        match refusal {
            Refusal::Unknown => self.grbl_error(20),
            Refusal::NoFeed => self.grbl_error(22),
            Refusal::NotHomed => self.grbl_error(9),
            Refusal::Beyond(_) => {
                self.machine.planner.hold(self.now);
                self.machine.kill(self.now);
                self.alarm = true;
                self.rx.clear();
                self.say("ALARM:2");
                self.say("[MSG:Reset to continue]");
            }
        }
    }

    fn grbl_error(&mut self, code: u32) {
        if self.quirks.latches_errors {
            self.latched = code;
        }
        self.say_ok(&format!("error:{code}"));
    }

    /// What is not motion: blank lines, `$`, locks, lengths. 0 is `ok`; `None` leaves it to the machine.
    fn grbl_system(&mut self, line: &[u8]) -> Option<u32> {
        let longest = if self.quirks.latches_errors { LONGEST_HEIR } else { LONGEST };
        let text = without_comment(line);
        match text.as_slice() {
            b"" => {
                self.latched = 0;
                return Some(0);
            }
            b"$I" => {
                let own = format!("[VER:1.1h.20190830:]\n[OPT:V,{},{}]", DEPTH - 1, self.quirks.receive_buffer);
                self.quirks.identity.unwrap_or(&own).lines().for_each(|line| self.say(line));
                if self.quirks.latches_errors {
                    let [.., tilt, rotation] = self.said_axes().map(|axis| axis.letter);
                    let extruder = char::from(self.machine.model.reading.extruder);
                    self.say(&format!("[AXS:6:XYZ{tilt}{rotation}{extruder}]"));
                    self.say("[FIRMWARE:grblHAL]");
                }
            }
            b"$$" => self.say_numbered(),
            b"$X" => self.alarm = false,
            b"$H" => {
                self.alarm = false;
                self.latched = 0;
                self.machine.homed = false;
                return match self.machine.execute(self.now, b"G28") {
                    Took::Refused(_) | Took::Again => Some(8),
                    _ => None,
                };
            }
            _ => {
                if text.first() != Some(&b'$') {
                    return self.grbl_lock(&text, longest);
                }
            }
        }
        self.latched = 0;
        Some(0)
    }

    fn grbl_lock(&self, text: &[u8], longest: usize) -> Option<u32> {
        if text.len() > longest {
            return Some(11);
        }
        if self.alarm {
            return Some(9);
        }
        if self.latched > 0 {
            return Some(self.latched);
        }
        if let Some(star) = text.iter().position(|b| *b == b'*') {
            return Some(if star == 0 { 1 } else { 2 });
        }
        let unknown_m = text.iter().position(|b| *b == b'M').is_some_and(|at| {
            let number = super::marlin::integer(&text[at + 1..]);
            !matches!(number, 0..=5 | 7..=9 | 30 | 62..=68)
        });
        (unknown_m || text.contains(&b'E')).then_some(20)
    }
}

/// Upper case, no blanks, no comments: as Grbl's `protocol.c` takes a line.
fn without_comment(line: &[u8]) -> Vec<u8> {
    let mut inside = false;
    let mut out = Vec::with_capacity(line.len());
    for &byte in line {
        match byte {
            b'(' => inside = true,
            b')' => inside = false,
            b';' => break,
            _ if inside || byte <= b' ' => {}
            _ => out.push(byte.to_ascii_uppercase()),
        }
    }
    out
}
