//! Both ways of the cable, and what befalls lines and answers on them.

use std::time::Duration;

use super::faults::{LATE, SLOW, spoil};
use super::{Sim, SimFault, grbl};
use crate::link::Time;
use crate::link::protocol::Protocol;

impl Sim {
    /// Bytes at the printer's end of the cable; faults befall whole lines.
    pub(super) fn arrive(&mut self, bytes: &[u8]) {
        if !self.script.is_active() {
            if !self.half_line.is_empty() {
                let held = std::mem::take(&mut self.half_line);
                self.buffer(&held);
            }
            self.buffer(bytes);
            return;
        }
        for &byte in bytes {
            if self.protocol == Protocol::Grbl && grbl::is_real_time(byte) {
                self.buffer(&[byte]);
                continue;
            }
            self.half_line.push(byte);
            if byte == b'\n' {
                let mut line = std::mem::take(&mut self.half_line);
                if line.len() > 1 {
                    let fault = self.script.next();
                    let draw = self.script.draw();
                    spoil(fault, &mut line, draw);
                    self.befall(fault);
                }
                self.buffer(&line);
                self.work();
            }
        }
    }

    /// Faults that are not the wire's.
    pub(super) fn befall(&mut self, fault: Option<SimFault>) {
        let Some(fault) = fault else { return };
        match fault {
            SimFault::LoseOk
            | SimFault::MangleOk
            | SimFault::SplitOk
            | SimFault::DoubleOk
            | SimFault::DelayOk
            | SimFault::Noise
            | SimFault::ErrorOnly => {
                self.spoiled_ok = Some(fault);
            }
            SimFault::GarbledResend => self.garble = true,
            SimFault::ResendNext => self.say(&format!("Resend: {}", self.last_number + 1)),
            SimFault::ResendOld => self.say("Resend: 1"),
            SimFault::EndlessResend => self.endless = true,
            SimFault::StrayOk => self.say("ok"),
            SimFault::FalseStart => self.say("start"),
            SimFault::StrangeError => self.say("Error:Probing Failed"),
            SimFault::Fatal => {
                self.say("Error:Thermal Runaway, system stopped! Heater_ID: 0");
                self.die();
            }
            SimFault::Mute => self.mute = true,
            SimFault::Reset => self.restart(Duration::from_millis(300)),
            SimFault::PowerLoss => self.restart(Duration::from_secs(5)),
            SimFault::HangUp => self.hang_up = true,
            SimFault::Slow => self.slow_until = self.now + SLOW,
            _ => {}
        }
    }

    pub(super) fn buffer(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if self.protocol == Protocol::Grbl && grbl::is_real_time(byte) {
                self.real_time(byte);
            } else if !self.quirks.overflows || self.rx.len() < self.quirks.receive_buffer {
                self.rx.push_back(byte);
            } else {
                self.overflowed += 1;
            }
        }
    }

    /// One whole line from the receive buffer, without its end.
    pub(super) fn next_rx_line(&mut self) -> Option<Vec<u8>> {
        let end = self.rx.iter().position(|b| matches!(b, b'\n' | b'\r'))?;
        let line: Vec<u8> = self.rx.drain(..end).collect();
        self.rx.pop_front();
        Some(line)
    }

    /// One line to the host.
    pub(super) fn say(&mut self, text: &str) {
        let mut line = text.as_bytes().to_vec();
        line.push(b'\n');
        self.emit(Duration::ZERO, line);
    }

    pub(super) fn emit(&mut self, delay: Time, line: Vec<u8>) {
        if self.mute {
            return;
        }
        self.reply_free = self.reply_free.max(self.now + delay) + self.byte_time().mul_f64(line.len() as f64);
        let heard = self.reply_free + self.quirks.latency;
        if self.late.is_empty() && heard <= self.now {
            self.out.extend_from_slice(&line);
        } else {
            self.late.push_back((heard, line));
        }
    }

    /// What a byte takes on the wire: ten bits.
    pub(super) fn byte_time(&self) -> Time {
        let baud = f64::from(self.quirks.baud);
        if baud > 0.0 { Duration::from_secs_f64(10.0 / baud) } else { Duration::ZERO }
    }

    pub(super) fn deliver(&mut self) {
        while self.late.front().is_some_and(|(at, _)| *at <= self.now) {
            if let Some((_, line)) = self.late.pop_front() {
                self.out.extend_from_slice(&line);
            }
        }
    }

    /// An `ok`, as the faults leave it.
    pub(super) fn say_ok(&mut self, text: &str) {
        match self.spoiled_ok.take() {
            None | Some(SimFault::ErrorOnly) => self.say(text),
            Some(SimFault::LoseOk) => {}
            Some(SimFault::MangleOk) => {
                let spoilt = text.replacen("ok", "o", 1);
                self.say(&spoilt);
            }
            Some(SimFault::DoubleOk) => {
                self.say(text);
                self.say(text);
            }
            Some(SimFault::DelayOk) => self.emit(LATE, [text.as_bytes(), b"\n"].concat()),
            Some(SimFault::Noise) => {
                self.emit(Duration::ZERO, b"\xff\xfe\0\x80ok?\xc3(\n".to_vec());
                self.say(text);
            }
            Some(_) => {
                let (first, second) = text.split_at(1);
                self.emit(Duration::ZERO, first.as_bytes().to_vec());
                self.emit(Duration::from_millis(700), [second.as_bytes(), b"\n"].concat());
            }
        }
    }
}
