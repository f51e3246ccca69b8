//! The table itself: command, the firmwares that know it so, and what it does there.
//!
//! A command may stand in several rows for several firmwares; the first row that fits counts.

use super::{Firmware, Hazard};
use crate::gcode::Command;

/// A command's kind of effect, its words not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Moves and modes.
    Motion,
    Home,
    /// G10.
    Offset,
    /// G92.
    Count,
    /// G11.
    Unretract,
    Dwell,
    Drain,
    Nozzle {
        waits: bool,
    },
    Bed {
        waits: bool,
    },
    Chamber {
        waits: bool,
    },
    HeatWait,
    /// M568: a tool's temperatures.
    ToolHeat,
    Fan,
    FanOff,
    Setting,
    Speed,
    Flow,
    Report,
    Label,
    Progress,
    Tool,
    /// Says what is so anyway.
    Idle,
    /// M18, M84.
    Motors,
    /// M200.
    Volumetric,
    Hazard(Hazard),
}

use Class::{
    Bed, Chamber, Count, Drain, Dwell, Fan, FanOff, Flow, HeatWait, Home, Idle, Label, Motion, Motors, Nozzle, Offset,
    Progress, Report, Setting, Speed, ToolHeat, Unretract, Volumetric,
};

/// Firmwares as bits.
type Set = u8;
const MARLIN: Set = 1;
const RRF: Set = 2;
const KLIPPER: Set = 4;
const GRBL: Set = 8;
const LINUXCNC: Set = 16;
const PRINTERS: Set = MARLIN | RRF | KLIPPER;
const NGC: Set = GRBL | LINUXCNC;
const ALL: Set = PRINTERS | NGC;

const fn bit(firmware: Firmware) -> Set {
    match firmware {
        Firmware::Marlin => MARLIN,
        Firmware::RepRapFirmware => RRF,
        Firmware::Klipper => KLIPPER,
        Firmware::Grbl => GRBL,
        Firmware::LinuxCnc => LINUXCNC,
    }
}

const fn hazard(hazard: Hazard) -> Class {
    Class::Hazard(hazard)
}

/// `(letter, numbers, firmwares, class)`
type Row = (u8, &'static [u32], Set, Class);

const ROWS: &[Row] = &[
    // Moves, planes, units, distance and feed modes.
    (b'G', &[0, 1, 2, 3, 17, 21, 90, 91, 94], ALL, Motion),
    (b'G', &[93], RRF | NGC, Motion),
    (b'G', &[40, 49, 61, 80], NGC, Motion),
    (b'G', &[64], NGC, hazard(Hazard::Blend)),
    // Marlin's fork with `PENTA_AXIS_TRT`: whatever followed the tip lets go of it. Marlin itself does not know it, and says so.
    (b'G', &[49], MARLIN, Motion),
    (b'M', &[82, 83], PRINTERS, Motion),
    (b'G', &[4], ALL, Dwell),
    (b'G', &[10], ALL, Offset),
    (b'G', &[11], PRINTERS, Unretract),
    (b'G', &[28], ALL, Home),
    (b'G', &[92], ALL, Count),
    (b'G', &[20, 70], ALL, hazard(Hazard::Units)),
    (b'G', &[18, 19], ALL, hazard(Hazard::Unknown)),
    (b'G', &[52, 53, 54, 55, 56, 57, 58, 59, 68, 69, 43], ALL, hazard(Hazard::Shift)),
    (b'G', &[60], PRINTERS, Report),
    (b'G', &[12, 22, 23, 26, 27, 29, 30, 32, 33, 34, 35, 38, 42, 61, 76, 80, 425], PRINTERS, hazard(Hazard::Moves)),
    // Heat.
    (b'M', &[104], PRINTERS, Nozzle { waits: false }),
    (b'M', &[109], PRINTERS, Nozzle { waits: true }),
    (b'M', &[140], PRINTERS, Bed { waits: false }),
    (b'M', &[190], PRINTERS, Bed { waits: true }),
    (b'M', &[141], PRINTERS, Chamber { waits: false }),
    (b'M', &[191], PRINTERS, Chamber { waits: true }),
    (b'M', &[116], RRF, HeatWait),
    (b'M', &[568], RRF, ToolHeat),
    (b'M', &[106], PRINTERS, Fan),
    (b'M', &[107], PRINTERS, FanOff),
    // What stays in force and moves nothing.
    // Firmware retraction on the others.
    (b'M', &[208], RRF, hazard(Hazard::Guard)),
    (
        b'M',
        &[113, 154, 155, 201, 202, 203, 204, 205, 207, 208, 412, 413, 566, 572, 591, 593, 595, 710, 900],
        PRINTERS,
        Setting,
    ),
    (b'M', &[220], PRINTERS, Speed),
    (b'M', &[221], PRINTERS, Flow),
    (b'M', &[17], PRINTERS, Idle),
    (b'M', &[400], PRINTERS, Drain),
    // What only speaks.
    (b'M', &[20, 27, 31, 105, 114, 115, 117, 118, 119, 150, 240, 250, 300, 355, 503, 862], PRINTERS, Report),
    (b'M', &[36, 122, 408, 409], RRF, Report),
    (b'M', &[486], PRINTERS, Label),
    (b'M', &[73, 75, 76, 77, 78], PRINTERS, Progress),
    (b'M', &[555], MARLIN, Progress),
    // What must not happen unseen.
    (b'M', &[6, 163, 164, 165, 563, 605], PRINTERS | LINUXCNC, hazard(Hazard::Tool)),
    (b'M', &[18, 84], PRINTERS, Motors),
    (b'M', &[200], PRINTERS, Volumetric),
    (b'M', &[149], MARLIN, hazard(Hazard::Units)),
    (
        b'M',
        &[206, 218, 290, 374, 375, 376, 420, 421, 425, 428, 557, 561, 579, 592, 851, 852],
        PRINTERS,
        hazard(Hazard::Shift),
    ),
    (b'M', &[92, 350, 501, 502, 569, 584, 665, 666, 667, 669], PRINTERS, hazard(Hazard::Steps)),
    (b'M', &[428, 429, 430], LINUXCNC, hazard(Hazard::Steps)),
    (b'M', &[0], RRF, hazard(Hazard::Stop)),
    (b'M', &[0, 1], ALL, hazard(Hazard::Person)),
    (b'M', &[25, 226, 600, 601, 602], PRINTERS, hazard(Hazard::Person)),
    (b'M', &[60], LINUXCNC, hazard(Hazard::Person)),
    (b'M', &[2, 30], NGC, hazard(Hazard::End)),
    (b'M', &[2, 81], PRINTERS, hazard(Hazard::End)),
    (b'M', &[112, 524, 997, 999], PRINTERS, hazard(Hazard::Stop)),
    (
        b'M',
        &[21, 22, 23, 24, 26, 28, 29, 30, 32, 33, 37, 38, 500, 504, 559, 560, 808, 928],
        PRINTERS,
        hazard(Hazard::File),
    ),
    (b'M', &[110], PRINTERS, hazard(Hazard::Counter)),
    (b'M', &[108, 410, 876], PRINTERS, hazard(Hazard::OutOfBand)),
    (b'M', &[48, 125, 280, 401, 402, 603, 701, 702, 871], PRINTERS, hazard(Hazard::Moves)),
    (
        b'M',
        &[
            85, 111, 120, 121, 209, 211, 301, 302, 303, 304, 305, 309, 404, 540, 564, 906, 907, 908, 911, 912, 913,
            914, 915,
        ],
        PRINTERS,
        hazard(Hazard::Guard),
    ),
    (b'M', &[3, 4, 5, 7, 8, 9], ALL, hazard(Hazard::Output)),
    (b'M', &[42, 80, 126, 127, 128, 129, 380, 381], PRINTERS, hazard(Hazard::Output)),
    (b'M', &[62, 63, 64, 65, 67, 68], NGC, hazard(Hazard::Output)),
];

/// What `command` does on `firmware`.
pub(super) fn class(firmware: Firmware, command: Command) -> Class {
    let set = bit(firmware);
    if command.letter == b'T' {
        return Class::Tool;
    }
    // Of the G-codes with a point those are known that the rows mean without it; but G92.1 and its kin clear offsets.
    if command.minor > 0 {
        return match (command.letter, command.number) {
            // G43.4: the firmware follows the tip, so that a turn moves it along.
            (b'G', 43 | 92 | 59) => hazard(Hazard::Shift),
            (b'G', 61) if set & NGC != 0 => Motion,
            (b'G', 38) => hazard(Hazard::Moves),
            (b'M', 862) if set & PRINTERS != 0 => Report,
            _ => hazard(Hazard::Unknown),
        };
    }
    let fits = |row: &&Row| row.0 == command.letter && row.2 & set != 0 && row.1.contains(&command.number);
    ROWS.iter().find(fits).map_or(hazard(Hazard::Unknown), |row| row.3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_command_stands_twice_for_one_firmware_but_where_the_first_row_is_meant_to_win() {
        let mut twice = Vec::new();
        for (at, (letter, numbers, set, class)) in ROWS.iter().enumerate() {
            for number in *numbers {
                let before = ROWS[..at].iter().find(|r| r.0 == *letter && r.2 & set != 0 && r.1.contains(number));
                if before.is_some_and(|r| r.2 & set == *set && r.3 != *class) {
                    twice.push(format!("{}{number}", char::from(*letter)));
                }
            }
        }
        assert_eq!(twice, Vec::<String>::new(), "a row that no firmware reaches");
    }
}
