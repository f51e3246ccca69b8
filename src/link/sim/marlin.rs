//! Marlin's side: numbers, checksums, resends, queue, busy, reports, emergency commands.
//!
//! After `queue.cpp` (`get_serial_commands`, `flush_and_request_resend`, `ok_to_send`) and `language.h`.

use std::time::Duration;

use super::heat::HeatedMass;
use super::machine::Refusal;
use super::{Logged, Queued, Sim, SimFault, Time, Took};
use crate::link::wire::checksum;

pub(super) const BUSY_EVERY: Time = Duration::from_secs(2);
const WAIT_REPORT: Time = Duration::from_secs(1);

/// What is wrong with a line.
enum WireError {
    Number { stated: i64 },
    Checksum,
    NoChecksum,
    NoNumber,
}

impl WireError {
    fn in_marlins_words(&self, last: i64) -> String {
        let what = match self {
            Self::Number { .. } => "Line Number is not Last Line Number+1",
            Self::Checksum => "checksum mismatch",
            Self::NoChecksum => "No Checksum with line number",
            Self::NoNumber => "No Line Number with checksum",
        };
        format!("{what}, Last Line: {last}")
    }

    /// After Repetier-Firmware's `gcode.cpp`.
    fn in_repetiers_words(&self, last: i64) -> String {
        match self {
            Self::Number { stated } => format!("expected line {} got {stated}", last + 1),
            Self::Checksum => "Wrong checksum".to_owned(),
            Self::NoChecksum | Self::NoNumber => "Missing checksum".to_owned(),
        }
    }
}

impl Sim {
    pub(super) fn work_marlin(&mut self) {
        if !self.quirks.loop_time.is_zero() {
            self.turn_marlin();
            return;
        }
        loop {
            let mut did = false;
            if self.quirks.emergency_parser {
                self.scan_emergency();
            }
            while self.queue.len() < self.quirks.queue && !self.dead {
                let Some(line) = self.next_rx_line() else { break };
                self.read_marlin(&line);
                did = true;
            }
            while !self.dead && self.execute_front() {
                did = true;
            }
            if !did || self.dead {
                return;
            }
        }
    }

    /// One turn of the main loop, where it is time for one: what has arrived goes into the queue, one command is executed.
    fn turn_marlin(&mut self) {
        if self.quirks.emergency_parser {
            self.scan_emergency();
        }
        if self.dead || self.now < self.next_loop {
            return;
        }
        self.next_loop = self.now + self.quirks.loop_time;
        self.read_as_prusa();
        while self.queue.len() < self.quirks.queue && !self.dead {
            let Some(byte) = self.rx.pop_front() else { break };
            if matches!(byte, b'\n' | b'\r') {
                let line = std::mem::take(&mut self.line_in);
                self.read_marlin(&line);
            } else {
                self.line_in.push(byte);
                self.line_at = self.now;
            }
        }
        if !self.dead {
            self.execute_front();
        }
    }

    /// What Prusa's `get_command` does before it reads on.
    fn read_as_prusa(&mut self) {
        if !self.quirks.prusa_reading {
            return;
        }
        if self.rx.len() + 1 >= self.quirks.receive_buffer {
            self.rx.clear();
            self.say("Full RX Buffer");
        }
        if !self.line_in.is_empty() && self.now > self.line_at + Duration::from_secs(2) {
            self.line_in.clear();
            self.say("RX timeout");
        }
    }

    /// M112, M108 and M410 at the beginning of any waiting line act at once.
    fn scan_emergency(&mut self) {
        let rx: Vec<u8> = self.rx.iter().copied().collect();
        for line in rx.split(|b| *b == b'\n') {
            let code = strip_number(line);
            if code.starts_with(b"M112") {
                self.rx.clear();
                self.kill_by_m112();
                return;
            }
            if code.starts_with(b"M108") {
                self.machine.end_wait(self.now);
            }
        }
    }

    fn kill_by_m112(&mut self) {
        self.say("echo:M112 Shutdown");
        self.say("Error:Printer halted. kill() called!");
        self.die();
    }

    fn read_marlin(&mut self, line: &[u8]) {
        let text = line.split(|b| *b == b';').next().unwrap_or_default();
        if line.is_empty() || (text.is_empty() && line.contains(&b';')) {
            return;
        }
        if text == b"M112" && self.quirks.reads_stop {
            self.kill_by_m112();
            return;
        }
        if text.first() != Some(&b'N') {
            if self.quirks.refuses_bare_sums && text.contains(&b'*') {
                self.line_error(&WireError::NoNumber);
                return;
            }
            self.enqueue(text, None);
            return;
        }
        let renumbers = memchr::memmem::find(text, b"M110").is_some();
        let stated = if renumbers {
            let after = memchr::memmem::find(text, b"M110").map_or(0, |at| at + 4);
            let second = text[after..].iter().position(|b| *b == b'N');
            second.map_or(integer(&text[1..]), |at| integer(&text[after + at + 1..]))
        } else {
            integer(&text[1..])
        };
        if stated != self.last_number + 1 && !renumbers {
            let have = (self.last_number - 1..=self.last_number).contains(&stated);
            if have && self.quirks.silent_duplicates {
                return;
            }
            self.line_error(&WireError::Number { stated });
            return;
        }
        let Some(star) = text.iter().rposition(|b| *b == b'*') else {
            self.line_error(&WireError::NoChecksum);
            return;
        };
        if i64::from(checksum(&text[..star])) != integer(&text[star + 1..]) || self.refuses_anyway() {
            self.line_error(&WireError::Checksum);
            return;
        }
        self.last_number = stated;
        let block = strip_number(&text[..star]).to_vec();
        self.enqueue(&block, Some(stated));
    }

    fn refuses_anyway(&mut self) -> bool {
        self.endless || self.garble || self.spoiled_ok == Some(SimFault::ErrorOnly)
    }

    fn line_error(&mut self, error: &WireError) {
        if self.quirks.smoothie_resends {
            self.say(&format!("rs N{}", self.last_number + 1));
            return;
        }
        let text = if self.quirks.repetier_errors {
            error.in_repetiers_words(self.last_number)
        } else {
            error.in_marlins_words(self.last_number)
        };
        if self.quirks.sprinter_errors {
            self.say(&format!("Serial Error: {}", text.replace("Line: ", "Line:")));
        } else {
            self.say(&format!("Error:{text}"));
        }
        self.rx.clear();
        if self.spoiled_ok == Some(SimFault::ErrorOnly) {
            self.spoiled_ok = None;
            return;
        }
        let mut wanted = (self.last_number + 1).to_string();
        if std::mem::take(&mut self.garble) {
            wanted.push('7');
        }
        let blank = if self.quirks.repetier_errors || self.quirks.sprinter_errors { "" } else { " " };
        self.say(&format!("Resend:{blank}{wanted}"));
        if self.quirks.ok_after_resend {
            self.say("ok");
        }
    }

    fn enqueue(&mut self, block: &[u8], number: Option<i64>) {
        self.busy_next = self.busy_next.max(self.now + BUSY_EVERY);
        self.queue.push_back(Queued { block: block.to_vec(), number, begun: false });
    }

    /// Executes the oldest command as far as it goes; `true` where it is done.
    fn execute_front(&mut self) -> bool {
        let Some(mut command) = self.queue.pop_front() else { return false };
        if !command.begun {
            command.begun = true;
            self.busy_next = self.now + BUSY_EVERY;
            if self.answer_marlin(&command) {
                return true;
            }
        }
        match self.machine.execute(self.now, &command.block) {
            Took::Again | Took::At(_) => self.queue.push_front(command),
            Took::Heat { bed } => {
                self.heating = Some(bed);
                self.report_next.get_or_insert(self.now + WAIT_REPORT);
                self.queue.push_front(command);
            }
            Took::Person(_) => {
                self.person = true;
                self.queue.push_front(command);
            }
            done => {
                self.finish_marlin(&command, &done);
                return true;
            }
        }
        false
    }

    fn finish_marlin(&mut self, command: &Queued, done: &Took) {
        if self.heating.take().is_some() && self.report_every.is_zero() {
            self.report_next = None;
        }
        self.person = false;
        match done {
            Took::Cold => self.say("echo: cold extrusion prevented"),
            Took::Refused(Refusal::Unknown) => {
                let text = String::from_utf8_lossy(&command.block).into_owned();
                self.say(&format!("echo:Unknown command: \"{text}\""));
                self.acknowledge(command);
                return;
            }
            _ => {}
        }
        self.note(Logged::Accepted(command.block.clone()));
        self.acknowledge(command);
    }

    fn acknowledge(&mut self, command: &Queued) {
        if !self.quirks.advanced_ok {
            self.say_ok("ok");
            return;
        }
        let number = command.number.map_or(String::new(), |n| format!(" N{n}"));
        // The one that is answered is still in the queue.
        let (p, b) = (self.machine.planner.free(), self.quirks.queue.saturating_sub(self.queue.len() + 1));
        self.say_ok(&format!("ok{number} P{p} B{b}"));
    }

    /// Commands that answer at once; `true` where the command is dealt with.
    fn answer_marlin(&mut self, command: &Queued) -> bool {
        if command.block.trim_ascii().is_empty() {
            self.say("echo:Unknown command: \"\"");
            self.acknowledge(command);
            return true;
        }
        if !matches!(command.block.trim_ascii_start().first(), Some(b'G' | b'M' | b'T')) {
            let text = String::from_utf8_lossy(&command.block).into_owned();
            if self.quirks.repeats {
                self.say(&format!("echo:Unknown command: \"{text}\""));
            }
            self.acknowledge(command);
            return true;
        }
        let head: Vec<u8> = command.block.iter().copied().take(4).collect();
        match head.as_slice() {
            b"M105" => {
                let report = self.heat_report();
                self.note(Logged::Accepted(command.block.clone()));
                self.say_ok(&format!("ok {report}"));
                return true;
            }
            b"M114" => {
                let text = self.where_it_is();
                self.say(&text);
            }
            b"M115" => self.introduce(),
            b"M503" => self.say_settings(),
            b"M211" => self.say_ends(),
            b"M155" => {
                let seconds = integer(command.block.split(|b| *b == b'S').nth(1).unwrap_or_default()).clamp(0, 3600);
                self.report_every = Duration::from_secs(seconds.unsigned_abs());
                self.report_next = (seconds > 0).then_some(self.now + self.report_every);
                self.note(Logged::Accepted(command.block.clone()));
                self.acknowledge(command);
                return true;
            }
            b"M112" => {
                self.kill_by_m112();
                return true;
            }
            b"M108" | b"M410" => {
                self.machine.end_wait(self.now);
                self.acknowledge(command);
                return true;
            }
            _ => {}
        }
        false
    }

    fn introduce(&mut self) {
        if let Some(identity) = self.quirks.identity {
            identity.lines().for_each(|line| self.say(line));
            return;
        }
        let Self { quirks, .. } = self;
        let text = format!(
            "FIRMWARE_NAME:Marlin bugfix-2.1.x (Nov 21 2026) SOURCE_CODE_URL:github.com/MarlinFirmware/Marlin PROTOCOL_VERSION:1.0 \
             MACHINE_TYPE:{} KINEMATICS:Cartesian EXTRUDER_COUNT:1 AXIS_COUNT:{} UUID:{}",
            quirks.name, quirks.axes, quirks.uuid
        );
        let parser = u8::from(quirks.emergency_parser);
        let text = quirks.answer(&text);
        self.say(&text);
        self.say("Cap:SERIAL_XON_XOFF:0");
        self.say("Cap:AUTOREPORT_TEMP:1");
        self.say(&format!("Cap:EMERGENCY_PARSER:{parser}"));
    }

    /// `T:19.38 /0.00 B:19.38 /0.00 @:0 B@:0`
    pub(super) fn heat_report(&self) -> String {
        let (nozzle, bed) = (&self.machine.nozzle, &self.machine.bed);
        let slash = if self.quirks.blank_behind_slash { "/ " } else { " /" };
        let each = |heated: &HeatedMass| format!("{:.2}{slash}{:.2}", heated.at(self.now), heated.target());
        format!("T:{} B:{} @:0 B@:0", each(nozzle), each(bed))
    }

    /// M114 says where the last queued move ends, as Marlin does.
    pub(super) fn where_it_is(&self) -> String {
        let at = self.machine.planner.end();
        let letters = self.machine.model.axes.each_ref().map(|a| char::from(a.letter));
        let [x, y, z, tilt, rotation, e] = at;
        format!(
            "X:{x:.2} Y:{y:.2} Z:{z:.2} {}:{tilt:.2} {}:{rotation:.2} E:{e:.2} Count X:{} Y:{} Z:{}",
            letters[0],
            letters[1],
            (x * 80.0).round(),
            (y * 80.0).round(),
            (z * 400.0).round()
        )
    }

    /// Temperatures and signs of life that come by themselves.
    pub(super) fn report(&mut self) {
        if let Some(at) = self.report_next
            && at <= self.now
        {
            let waiting = if self.heating.is_some() { " W:?" } else { "" };
            let text = format!(" {}{waiting}", self.heat_report());
            self.say(&text);
            let every = if self.heating.is_some() { WAIT_REPORT } else { self.report_every };
            self.report_next = (!every.is_zero()).then_some(self.now + every);
        }
        let begun = self.queue.front().is_some_and(|c| c.begun);
        if self.quirks.busy && begun && self.busy_next <= self.now {
            self.busy_next = self.now + BUSY_EVERY;
            if self.person {
                self.say("echo:busy: paused for user");
            } else if self.heating.is_none() {
                self.say("echo:busy: processing");
            }
        }
    }
}

/// What follows `N<number>`.
pub(super) fn strip_number(text: &[u8]) -> &[u8] {
    if text.first() != Some(&b'N') {
        return text;
    }
    let digits = text[1..].iter().take_while(|b| b.is_ascii_digit() || **b == b'-').count();
    text[1 + digits..].trim_ascii_start()
}

/// As `strtol`: the number at the beginning, 0 for none.
pub(super) fn integer(text: &[u8]) -> i64 {
    let text = text.trim_ascii_start();
    let (negative, digits) = match text.strip_prefix(b"-") {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let value = digits.iter().take_while(|b| b.is_ascii_digit()).take(15).fold(0, |n, b| n * 10 + i64::from(b - b'0'));
    if negative { -value } else { value }
}
