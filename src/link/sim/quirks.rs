//! How one printer differs from another of its firmware.

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
    /// Temperatures with the blank behind the slash: `T:21.30/ 0.00`.
    pub blank_behind_slash: bool,
    /// grblHAL latches an error until a blank line, `$` or reset.
    pub latches_errors: bool,
    /// Bits a second in each direction; 0 for none.
    pub baud: u32,
    /// What it is called.
    pub name: String,
    /// Its own number, for M115.
    pub uuid: String,
    /// `AXIS_COUNT` of M115.
    pub axes: u32,
}

impl Quirks {
    /// An ordinary firmware of this protocol.
    pub fn of(protocol: Protocol) -> Self {
        Self {
            advanced_ok: false,
            ok_after_resend: true,
            silent_duplicates: true,
            emergency_parser: true,
            busy: true,
            queue: 4,
            receive_buffer: if protocol == Protocol::RepRapFirmware { 256 } else { 128 },
            overflows: matches!(protocol, Protocol::Marlin | Protocol::Grbl),
            repetier_errors: false,
            sprinter_errors: false,
            smoothie_resends: false,
            blank_behind_slash: false,
            latches_errors: false,
            baud: 0,
            name: "trunnion".to_owned(),
            uuid: "cede2a2f-41a2-4748-9b12-c55c62f367ff".to_owned(),
            axes: 5,
        }
    }
}
