//! How one printer differs from another of its firmware.

use crate::link::Time;
use crate::link::protocol::Protocol;

/// How a firmware differs from its kind.
#[derive(Clone, Debug)]
pub struct Quirks {
    /// `ok N3 P15 B3`.
    pub advanced_ok: bool,
    /// An `ok` after `Resend:`.
    pub ok_after_resend: bool,
    /// Marlin from 2.1 drops a line that it already has without a word; older ones refuse it.
    pub silent_duplicates: bool,
    /// M112, M108 and M410 act before they are queued.
    pub emergency_parser: bool,
    /// Whether it repeats a line that begins with no command.
    pub repeats: bool,
    /// M112 as a line of its own stops it when that is read into the queue.
    pub reads_stop: bool,
    /// `echo:busy:` and `wait`.
    pub busy: bool,
    /// Commands that are queued.
    pub queue: usize,
    /// Bytes of the receive buffer; what does not fit is lost where `overflows`.
    pub receive_buffer: usize,
    /// An 8-bit UART: no flow control.
    pub overflows: bool,
    /// Wire errors in Repetier's words: `expected line 302 got 303`, `Resend:302`.
    pub repetier_errors: bool,
    /// Wire errors as Sprinter has them: `Serial Error:`, and no blank before a number.
    pub sprinter_errors: bool,
    /// A bad line is answered by `rs N4` and nothing else, as Smoothie does.
    pub smoothie_resends: bool,
    /// A checksum without a number is an error, as in Marlin before 1.1 and in Prusa's firmware.
    pub refuses_bare_sums: bool,
    /// A wrong checksum is told in `Checksum error on line 3`, behind which an `ok` follows all the same, as RepRapFirmware 2 does.
    pub tells_bad_sums: bool,
    /// Prusa's reading: half a line is dropped after two seconds, and a receive buffer without a free byte is emptied unread. Only with a
    /// `loop_time`.
    pub prusa_reading: bool,
    /// What it says of itself instead of its kind's own words, line by line.
    pub identity: Option<&'static str>,
    /// Temperatures with the blank behind the slash: `T:21.30/ 0.00`.
    pub blank_behind_slash: bool,
    /// Grbl's work offset, told in some of its reports, mm and degrees.
    pub work_offset: [f64; 5],
    /// grblHAL latches an error until a blank line, `$` or reset.
    pub latches_errors: bool,
    /// Bits a second in each direction; 0 for none.
    pub baud: u32,
    /// How long a byte is under way in each direction beside its time on the wire, as in an adapter to USB.
    pub latency: Time,
    /// Marlin's main loop takes so long: once in each the receive buffer is emptied into the queue, and one command is executed. Zero:
    /// all at once.
    pub loop_time: Time,
    /// What it is called.
    pub name: String,
    /// Its own number, for M115.
    pub uuid: String,
    /// `AXIS_COUNT` of M115.
    pub axes: u32,
    /// What the profile wants in the answer to M115 (`KINEMATICS:PENTA_AXIS_TRT`, a UUID); empty for nothing.
    pub wanted: String,
}

/// Firmwares of a name, as far as they differ on the wire.
impl Quirks {
    /// Marlin 1.0: no capabilities, a double is refused, M112 waits its turn.
    pub fn marlin_1_0(&mut self) {
        self.identity = Some(
            "FIRMWARE_NAME:Marlin V1; Sprinter/grbl mashup for gen6 FIRMWARE_URL:http://www.mendel-parts.com PROTOCOL_VERSION:1.0 \
             MACHINE_TYPE:Mendel EXTRUDER_COUNT:1",
        );
        (self.silent_duplicates, self.emergency_parser, self.refuses_bare_sums) = (false, false, true);
        self.reads_stop = false;
    }

    /// Marlin 1.1.9: a double is refused, and axes are not counted.
    pub fn marlin_1_1(&mut self) {
        self.identity = Some(
            "FIRMWARE_NAME:Marlin 1.1.9 (Github) SOURCE_CODE_URL:https://github.com/MarlinFirmware/Marlin PROTOCOL_VERSION:1.0 \
             MACHINE_TYPE:3D Printer EXTRUDER_COUNT:1 UUID:cede2a2f-41a2-4748-9b12-c55c62f367ff\n\
             Cap:SERIAL_XON_XOFF:0\nCap:EEPROM:1\nCap:VOLUMETRIC:1\nCap:AUTOREPORT_TEMP:1\nCap:EMERGENCY_PARSER:0",
        );
        (self.silent_duplicates, self.emergency_parser) = (false, false);
    }

    /// Prusa's 8-bit firmware.
    pub fn prusa(&mut self) {
        self.identity = Some(
            "FIRMWARE_NAME:Prusa-Firmware 3.14.0-BETA1 based on Marlin FIRMWARE_URL:https://github.com/prusa3d/Prusa-Firmware \
             PROTOCOL_VERSION:1.0 MACHINE_TYPE:Prusa i3 MK3S EXTRUDER_COUNT:1 UUID:00000000-0000-0000-0000-000000000000",
        );
        (self.silent_duplicates, self.emergency_parser, self.refuses_bare_sums) = (false, false, true);
        self.prusa_reading = true;
    }

    /// RepRapFirmware 2.
    pub fn rrf_2(&mut self) {
        self.identity = Some(
            "FIRMWARE_NAME: RepRapFirmware for Duet 2 WiFi/Ethernet FIRMWARE_VERSION: 2.04RC1 ELECTRONICS: Duet WiFi 1.0 or 1.01 \
             FIRMWARE_DATE: 2019-07-14b1",
        );
        self.tells_bad_sums = true;
    }

    /// FluidNC 3: its options state no sizes.
    pub fn fluidnc(&mut self) {
        self.identity = Some("[VER:3.9 FluidNC v3.9.9:]\n[OPT:MPHS]\n[MSG: Machine: trunnion]");
    }
}

impl Quirks {
    /// An ordinary firmware of this protocol.
    pub fn of(protocol: Protocol) -> Self {
        Self {
            advanced_ok: false,
            ok_after_resend: true,
            silent_duplicates: true,
            emergency_parser: true,
            repeats: true,
            reads_stop: true,
            busy: true,
            queue: 4,
            receive_buffer: if protocol == Protocol::RepRapFirmware { 256 } else { 128 },
            overflows: matches!(protocol, Protocol::Marlin | Protocol::Grbl),
            repetier_errors: false,
            sprinter_errors: false,
            smoothie_resends: false,
            refuses_bare_sums: false,
            tells_bad_sums: false,
            prusa_reading: false,
            identity: None,
            blank_behind_slash: false,
            work_offset: [0.0; 5],
            latches_errors: false,
            baud: 0,
            latency: Time::ZERO,
            loop_time: Time::ZERO,
            name: "trunnion".to_owned(),
            uuid: "cede2a2f-41a2-4748-9b12-c55c62f367ff".to_owned(),
            axes: 5,
            wanted: String::new(),
        }
    }

    /// An answer to M115 with what the profile wants in it: in the place of the word with the same key, else behind all.
    pub(super) fn answer(&self, text: &str) -> String {
        let key = self.wanted.split_once(':').map(|(key, _)| format!("{key}:"));
        let same = |word: &&str| key.as_ref().is_some_and(|key| word.starts_with(key.as_str()));
        match text.split(' ').find(same) {
            _ if text.contains(&self.wanted) => text.to_owned(),
            Some(word) => text.replacen(word, &self.wanted, 1),
            None => format!("{text} {}", self.wanted),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulated_printer_is_the_one_that_the_profile_wants() {
        let of = |wanted: &str| {
            let quirks = Quirks { wanted: wanted.to_owned(), ..Quirks::of(Protocol::Marlin) };
            quirks.answer("FIRMWARE_NAME:Marlin KINEMATICS:Cartesian UUID:cede")
        };
        assert_eq!(of(""), "FIRMWARE_NAME:Marlin KINEMATICS:Cartesian UUID:cede");
        assert_eq!(of("cede"), of(""));
        assert_eq!(of("KINEMATICS:PENTA_AXIS_TRT"), "FIRMWARE_NAME:Marlin KINEMATICS:PENTA_AXIS_TRT UUID:cede");
        assert_eq!(of("12-34"), "FIRMWARE_NAME:Marlin KINEMATICS:Cartesian UUID:cede 12-34");
    }
}
