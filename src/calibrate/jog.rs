//! Which axis of a machine does what, from small moves and what a person sees of them.
//!
//! One axis moves at a time, by [`JOG_MM`] or [`JOG_DEG`], and one question is put about it. Where X is seen to go tells where the person
//! stands, so that nobody has to be told where the front is. Y must go a quarter turn to the left of X, and Z away from the table: else the
//! machine's coordinates are left-handed, which no profile says. A rim that sinks on one side is a turn about the axis a quarter turn ahead of
//! that side, by the right hand.
//!
//! Frames: what is seen is in the person's own directions (right, away, up); what comes out is in the machine's.

use std::fmt;

/// How far X, Y and Z are moved, mm.
pub const JOG_MM: f64 = 5.0;
/// How far a rotary axis is turned, degrees.
pub const JOG_DEG: f64 = 10.0;

/// What a person sees of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The nozzle went to the right over the table.
    Right,
    /// It went away from the person.
    Away,
    /// It went to the left.
    Left,
    /// It went towards the person.
    Towards,
    /// The gap between nozzle and table grew.
    Apart,
    /// That gap shrank.
    Closer,
    /// The table's near side sank.
    NearSank,
    /// Its right side sank.
    RightSank,
    /// Its near side rose.
    NearRose,
    /// Its right side rose.
    RightRose,
    /// The table turned anticlockwise, seen from above.
    Anticlockwise,
    /// It turned clockwise.
    Clockwise,
    /// So it is.
    Yes,
    /// It is not so.
    No,
    /// Nothing moved.
    Nothing,
    /// Something else, or nobody saw.
    Unsure,
}

/// What can be seen of X, Y and Z.
const STRAIGHT: [Seen; 8] =
    [Seen::Right, Seen::Left, Seen::Away, Seen::Towards, Seen::Apart, Seen::Closer, Seen::Nothing, Seen::Unsure];
/// What can be seen of a rotary axis.
const ROTARY: [Seen; 8] = [
    Seen::NearRose,
    Seen::NearSank,
    Seen::RightRose,
    Seen::RightSank,
    Seen::Anticlockwise,
    Seen::Clockwise,
    Seen::Nothing,
    Seen::Unsure,
];
const EITHER: [Seen; 3] = [Seen::Yes, Seen::No, Seen::Unsure];

impl Seen {
    /// What a step the other way would have shown.
    pub fn opposite(self) -> Self {
        match self {
            Self::Right => Self::Left,
            Self::Left => Self::Right,
            Self::Away => Self::Towards,
            Self::Towards => Self::Away,
            Self::Apart => Self::Closer,
            Self::Closer => Self::Apart,
            Self::NearSank => Self::NearRose,
            Self::NearRose => Self::NearSank,
            Self::RightSank => Self::RightRose,
            Self::RightRose => Self::RightSank,
            Self::Anticlockwise => Self::Clockwise,
            Self::Clockwise => Self::Anticlockwise,
            other => other,
        }
    }

    /// Quarter turns from the person's right, anticlockwise from above, of the way that a nozzle went or of the axis about which a table tilted.
    fn quarter(self) -> Option<u8> {
        match self {
            Self::Right | Self::NearSank => Some(0),
            Self::Away | Self::RightSank => Some(1),
            Self::Left | Self::NearRose => Some(2),
            Self::Towards | Self::RightRose => Some(3),
            _ => None,
        }
    }
}

/// What is asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JogSubject {
    /// Whether all is as it must be before anything moves.
    Ready,
    /// Where the nozzle went.
    Way,
    /// What the table did.
    Table,
    /// Whether it was about so much.
    Amount,
    /// Whether the table is level where the axis stands.
    Level,
}

/// One question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JogQuestion {
    /// What is asked.
    pub subject: JogSubject,
    /// The axis; a blank for [`JogSubject::Ready`].
    pub axis: char,
    /// By how much it is moved before the question, and moved back after the answer, mm or degrees; 0 where nothing moves. Whoever has no room
    /// for it moves the other way, puts that in, and hands on [`Seen::opposite`].
    pub step: f64,
    /// Where its word stands, for [`JogSubject::Level`] where the machine tells; whoever asks puts it in.
    pub word: Option<f64>,
    /// What may be answered, in the order in which it is shown.
    pub answers: &'static [Seen],
}

/// What one rotary axis does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AxisRole {
    /// About X or Y, by the right hand or against it.
    Tilts { about: char, direction: i32 },
    /// About Z.
    Turns { direction: i32 },
    /// Nothing of the table.
    Still,
}

/// What the axes do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jogged {
    /// The letter that tilts the table.
    pub tilt: char,
    /// The machine axis that it tilts about, `'X'` or `'Y'`.
    pub about: char,
    /// +1 where a larger word turns it by the right hand, else -1.
    pub tilt_direction: i32,
    /// The word at which the table was seen level, degrees; `None` where the machine tells no word.
    pub level_deg: Option<f64>,
    /// The letter that turns it.
    pub rotation: char,
    /// As for the tilt.
    pub rotation_direction: i32,
}

/// Why a test tells nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "jog/")]
pub enum JogFault {
    /// Somebody says that it must not begin.
    #[error("nothing was moved; home all axes, level and clear the table, raise the head, then run this again")]
    NotReady,
    /// A printer of another firmware than the profile's.
    #[error("the printer runs {found}, but the profile is for {wanted}; pass the profile of this machine with -m")]
    OtherFirmware {
        /// What answers.
        found: String,
        /// What the profile is for.
        wanted: String,
    },
    /// A warm nozzle.
    #[error("the nozzle is at {c:.0} deg C, or set to it (maximum {allowed:.0}); switch it off and let it cool")]
    Hot {
        /// Its temperature or target, degrees Celsius.
        c: f64,
        /// The highest.
        allowed: f64,
    },
    /// A printer that does not tell where it stands.
    #[error("the printer does not report where {axis} is; home it, then run this again")]
    NoPlace {
        /// The axis.
        axis: char,
    },
    /// A printer that does not tell whether its nozzle is cold.
    #[error("the printer does not report the nozzle's temperature; select its tool (T0), then run this again")]
    NoTemperature,
    /// An axis too near to its end.
    #[error("{axis} is at {word:.2}, without room for its test; move it to between {low:.2} and {high:.2} first")]
    NoRoom {
        /// The axis.
        axis: char,
        /// Its word.
        word: f64,
        /// The lowest word to begin at.
        low: f64,
        /// The highest.
        high: f64,
    },
    /// What happened was not seen.
    #[error("what {axis} does is not known, so nothing was written; run this again and watch {axis}")]
    Unseen {
        /// The axis.
        axis: char,
    },
    /// Nothing moved.
    #[error("{axis} did not move; check its motor, and that the firmware has an axis of this letter")]
    Stuck {
        /// The axis.
        axis: char,
    },
    /// Another way than it must go.
    #[error("{axis} must {wanted}; correct the firmware's axes first, because no profile describes this")]
    Astray {
        /// The axis.
        axis: char,
        /// What it must do.
        wanted: &'static str,
    },
    /// Left-handed coordinates.
    #[error(
        "X and Y are left-handed (with X to the right, Y must move the nozzle away from you); if the table moves, answer where the nozzle \
         went over it, and run this again; else every print is mirrored, and one of the two must be reversed in the firmware"
    )]
    Mirrored,
    /// Another angle than was sent.
    #[error("{axis} did not turn the table by about {JOG_DEG} degrees; correct its steps per degree in the firmware")]
    WrongAmount {
        /// The axis.
        axis: char,
    },
    /// A table that stands askew where its axis should be at its zero.
    #[error("the table is not level at {axis}{word}; level it with the machine's own controls, then run this again")]
    NotLevel {
        /// The axis.
        axis: char,
        /// Its word.
        word: String,
    },
    /// A table that this tool does not drive.
    #[error("{found}; the table must tilt by one axis and turn by another")]
    OtherTable {
        /// What the axes do.
        found: String,
    },
}

/// The axes of the test in order, and how far it is.
#[derive(Clone, Debug)]
pub struct Jog {
    /// Letters of the rotary axes.
    rotary: Vec<char>,
    /// Where the person stands: quarter turns from the person's right to machine +X.
    view: u8,
    found: Vec<(char, AxisRole)>,
    level_deg: Option<f64>,
    next: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Ready,
    /// X, Y or Z.
    Straight(usize),
    Way(usize),
    Amount(usize),
    Level(usize),
    Done,
}

const LINEAR: [char; 3] = ['X', 'Y', 'Z'];

impl Jog {
    /// A test of a machine with these rotary axes.
    pub fn new(rotary: &[char]) -> Self {
        Self { rotary: rotary.to_vec(), view: 0, found: Vec::new(), level_deg: None, next: Stage::Ready }
    }

    /// The next question; `None` at the end.
    pub fn question(&self) -> Option<JogQuestion> {
        let ask = |subject, axis, step, answers| JogQuestion { subject, axis, step, word: None, answers };
        Some(match self.next {
            Stage::Ready => ask(JogSubject::Ready, ' ', 0.0, &EITHER[..2]),
            Stage::Straight(i) => ask(JogSubject::Way, LINEAR[i], JOG_MM, &STRAIGHT[..]),
            Stage::Way(i) => ask(JogSubject::Table, self.rotary[i], JOG_DEG, &ROTARY[..]),
            Stage::Amount(i) => ask(JogSubject::Amount, self.rotary[i], JOG_DEG, &EITHER[..]),
            Stage::Level(i) => ask(JogSubject::Level, self.rotary[i], 0.0, &EITHER[..]),
            Stage::Done => return None,
        })
    }

    /// Takes what was seen of the step forwards, and the word at which the axis stands where that was asked about and the machine tells it.
    ///
    /// # Errors
    ///
    /// [`JogFault`]; the test has ended then.
    pub fn answer(&mut self, seen: Seen, word: Option<f64>) -> Result<(), JogFault> {
        let Some(question) = self.question() else { return Ok(()) };
        let axis = question.axis;
        match seen {
            Seen::Unsure => return Err(JogFault::Unseen { axis }),
            Seen::Nothing if matches!(self.next, Stage::Straight(_)) => return Err(JogFault::Stuck { axis }),
            _ => {}
        }
        self.next = match self.next {
            Stage::Ready if seen != Seen::Yes => return Err(JogFault::NotReady),
            Stage::Ready => Stage::Straight(0),
            Stage::Straight(i) => self.straight(i, seen)?,
            Stage::Way(i) => self.rotary(i, seen),
            Stage::Amount(_) if seen != Seen::Yes => return Err(JogFault::WrongAmount { axis }),
            Stage::Amount(i) if self.tilts(i) => Stage::Level(i),
            Stage::Amount(i) => self.behind(i),
            Stage::Level(_) if seen != Seen::Yes => {
                let word = word.map_or_else(String::new, |word| format!("{word:.2}"));
                return Err(JogFault::NotLevel { axis, word });
            }
            Stage::Level(i) => {
                self.level_deg = word;
                self.behind(i)
            }
            Stage::Done => Stage::Done,
        };
        Ok(())
    }

    fn straight(&mut self, i: usize, seen: Seen) -> Result<Stage, JogFault> {
        let astray = |wanted| JogFault::Astray { axis: LINEAR[i], wanted };
        match (i, seen.quarter()) {
            (0, Some(quarter)) => self.view = quarter,
            (0, None) => return Err(astray("move the nozzle level over the table")),
            (1, Some(quarter)) => match (quarter + 4 - self.view) % 4 {
                1 => {}
                3 => return Err(JogFault::Mirrored),
                _ => return Err(astray("move the nozzle at a right angle to X")),
            },
            (1, None) => return Err(astray("move the nozzle level over the table")),
            _ if seen != Seen::Apart => return Err(astray("move the nozzle away from the table")),
            _ => {}
        }
        Ok(if i + 1 < LINEAR.len() { Stage::Straight(i + 1) } else { self.way(0) })
    }

    fn rotary(&mut self, i: usize, seen: Seen) -> Stage {
        let role = match (seen, seen.quarter()) {
            (Seen::Anticlockwise, _) => AxisRole::Turns { direction: 1 },
            (Seen::Clockwise, _) => AxisRole::Turns { direction: -1 },
            (_, Some(quarter)) => {
                let machine = (quarter + 4 - self.view) % 4;
                let about = if machine.is_multiple_of(2) { 'X' } else { 'Y' };
                AxisRole::Tilts { about, direction: if machine < 2 { 1 } else { -1 } }
            }
            _ => AxisRole::Still,
        };
        self.found.push((self.rotary[i], role));
        if role == AxisRole::Still { self.behind(i) } else { Stage::Amount(i) }
    }

    fn tilts(&self, i: usize) -> bool {
        let letter = self.rotary[i];
        self.found.iter().any(|(of, role)| *of == letter && matches!(role, AxisRole::Tilts { .. }))
    }

    fn behind(&self, i: usize) -> Stage {
        self.way(i + 1)
    }

    fn way(&self, i: usize) -> Stage {
        if i < self.rotary.len() { Stage::Way(i) } else { Stage::Done }
    }

    /// What the axes do, at the end of the test.
    ///
    /// # Errors
    ///
    /// [`JogFault::OtherTable`] where it is not one that tilts and one that turns.
    pub fn found(&self) -> Result<Jogged, JogFault> {
        let tilts = self.found.iter().filter_map(|(letter, role)| match role {
            AxisRole::Tilts { about, direction } => Some((*letter, *about, *direction)),
            _ => None,
        });
        let turns = self.found.iter().filter_map(|(letter, role)| match role {
            AxisRole::Turns { direction } => Some((*letter, *direction)),
            _ => None,
        });
        match (&tilts.collect::<Vec<_>>()[..], &turns.collect::<Vec<_>>()[..]) {
            (&[(tilt, about, tilt_direction)], &[(rotation, rotation_direction)]) => {
                let level_deg = self.level_deg;
                Ok(Jogged { tilt, about, tilt_direction, level_deg, rotation, rotation_direction })
            }
            _ => {
                let each: Vec<String> = self.found.iter().map(|(letter, role)| format!("{letter} {role}")).collect();
                Err(JogFault::OtherTable { found: each.join(", ") })
            }
        }
    }
}

impl fmt::Display for AxisRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tilts { about, .. } => write!(f, "tilts the table about {about}"),
            Self::Turns { .. } => f.write_str("turns the table"),
            Self::Still => f.write_str("moves no part of the table"),
        }
    }
}
