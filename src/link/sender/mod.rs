//! The host's side of the wire as a state machine: bytes and times in, bytes and events out.
//!
//! ```text
//! numbers   proven <= credited < cursor <= last + 1
//!           |         |          '- next to go on the wire
//!           |         '- answered with an `ok`, which may be a false one
//!           '- known to be accepted: never sent again
//! ```
//!
//! Every line has a number, on the wire or only here. An `ok` moves `credited`. Only proof moves `proven`: the answer to a
//! numbered M105, ours or the file's (its `ok` alone carries temperatures, so nothing else can be taken for it), or an
//! error's `Last Line: n` together with `Resend: n+1`. Lines stay in the history until proven, so that a doubled or lost `ok`
//! is mended by the printer's own counter. Where a protocol has no counter, what cannot be accounted for stops the print.
//!
//! A line goes out again only on the printer's word that it has not taken it; after a silence the printer is asked with a line
//! whose number is wrong on purpose (which it must refuse, naming its last one).
//!
//! This room knows no port, thread or clock: times are since any fixed moment.

mod control;
mod flow;
mod grbl;
mod hello;
mod listen;
mod probe;
mod stop;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

pub use stop::{Outcome, Stop};

use super::journal::{Record, Standing};
use super::program::Program;
use super::reply::{Status, Temperatures};
use super::resume::Retreat;
use super::seams::{Filling, Seams};
use super::wire::{LineAssembler, Protocol};

/// Time since any fixed moment.
pub type Time = Duration;

/// How the wire is used.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The firmware's manners.
    pub protocol: Protocol,
    /// Most lines without an answer.
    pub window_lines: usize,
    /// Most bytes without an answer; the firmware's receive buffer less [`Settings::MARGIN`].
    pub window_bytes: usize,
    /// Blocks that the firmware's planner and queue hold: so many answered ones may not be executed.
    pub planner_blocks: u32,
    /// After this many lines a numbered M105 proves the count.
    pub prove_every: u32,
    /// Without a word for this long, beyond what the motion in hand takes, the printer is asked.
    pub silence: Time,
    /// The same while a command is in hand that may take minutes.
    pub long_silence: Time,
    /// No progress for this long stops the print, even if the printer shows life (a wait for a person does not).
    pub no_progress: Time,
    /// Questions without an answer before the printer counts as mute.
    pub questions: u32,
    /// Refusals of one line before the wire counts as broken.
    pub refusals: u32,
    /// Numbers begin anew here; Marlin counts in 32 bits.
    pub renumber_at: i64,
    /// What the printer must call itself; `None` takes any.
    pub identity: Option<String>,
    /// How the head leaves the part.
    pub retreat: Retreat,
}

impl Settings {
    /// What suits `protocol`: Marlin's BUFSIZE 4 and 128 bytes, Grbl's 128 bytes, one line at a time for the others.
    pub fn new(protocol: Protocol, retreat: Retreat) -> Self {
        let (window_lines, window_bytes) = match protocol {
            Protocol::Marlin => (4, 128 - Self::MARGIN),
            Protocol::RepRapFirmware => (1, 256 - Self::MARGIN),
            Protocol::Klipper => (8, 4096),
            Protocol::Grbl => (usize::MAX, 127),
        };
        Self {
            protocol,
            window_lines,
            window_bytes,
            planner_blocks: 24,
            prove_every: 32,
            silence: Duration::from_secs(4),
            long_silence: Duration::from_secs(300),
            no_progress: Duration::from_secs(3600),
            questions: 10,
            refusals: 10,
            renumber_at: 2_000_000_000,
            identity: None,
            retreat,
        }
    }

    /// Bytes of the receive buffer that are left free: a ring of 128 holds 127. The lines of the window fit into the firmware's
    /// command queue, so that a question, which comes after a silence, finds the buffer empty.
    pub const MARGIN: usize = 1;
}

/// What a line is for.
#[derive(Clone, Debug, PartialEq)]
enum What {
    Block(u32),
    /// M105: its answer proves everything before it.
    Proof,
    /// M115.
    Identify,
    /// A line of our own.
    Script(Box<[u8]>),
}

/// A line that was made and is not yet proven.
#[derive(Clone, Debug)]
struct Sent {
    what: What,
    bytes: usize,
    filling: Filling,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Hello { asked: Option<Time>, tries: u32 },
    Flow,
    Probe { asked: Option<Time>, tries: u32, answer: Option<i64>, confirm: u32 },
    Offline,
    Over,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    Print,
    /// No new block; with the step reached.
    Leave {
        cancel: bool,
        step: Step,
    },
    /// Back to the part after a pause.
    Return,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Draining,
    Leaving,
    Away,
}

/// What the host should know or keep.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The printer answered; what it calls itself.
    Connected(String),
    /// To be written to the journal before the next bytes are taken.
    Journal(Record),
    /// A line goes out again.
    Resend {
        /// Its number on the wire.
        number: i64,
        /// Its line of the file, where it is one of the file's.
        file_line: Option<u32>,
        /// Why.
        why: &'static str,
    },
    /// Temperatures.
    Temperatures(Temperatures),
    /// The printer's own word of where it is.
    Position(Vec<(u8, f64)>),
    /// Grbl's status.
    Status(Status),
    /// The printer waits for a person.
    UserWait,
    /// Something worth a line on the screen.
    Note(String),
    /// The head is away from the part.
    Paused,
    /// The print goes on.
    Resumed,
    /// No more events will come.
    Over(Outcome),
}

/// How far the print is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Blocks answered.
    pub acked: u32,
    /// Blocks on the wire at least once.
    pub sent: u32,
    /// All blocks.
    pub of: u32,
    /// Lines sent again.
    pub resends: u32,
    /// The highest number known to be accepted.
    pub proven: i64,
    /// The highest number ever made.
    pub last: i64,
}

/// The host's side of the wire.
#[derive(Clone, Debug)]
pub struct Sender {
    settings: Settings,
    program: Arc<Program>,
    lines: LineAssembler,
    out: Vec<u8>,
    taken: usize,
    /// Lines `proven + 1 ..= proven + history.len()`.
    history: VecDeque<Sent>,
    proven: i64,
    credited: i64,
    cursor: i64,
    bytes_out: usize,
    seams: Seams,
    next_block: u32,
    end_block: u32,
    acked_blocks: u32,
    resends: u32,
    since_proof: u32,
    scripts: VecDeque<What>,
    stage: Stage,
    goal: Goal,
    /// Identified and proven: blocks may go.
    ready: bool,
    /// Something that moves or heats has been put on the wire: from here on a doubt is no fresh start.
    begun: bool,
    finishing: bool,
    /// The heaters' last lines are under way.
    cooling: bool,
    /// A pause that waits until the head is back on the part.
    pause_behind: bool,
    /// The way back from a pause, to be worked out when the printer has said where it is.
    way_back_owed: bool,
    identity: String,
    emergency_parser: bool,
    /// While this number is not credited, one line at a time.
    narrow: i64,
    /// A number refused, how often, and how many refusals of lines behind it are still under way.
    refused: (i64, u32, u32),
    swallow_ok: bool,
    resends_end_with_ok: bool,
    hold_until: Option<Time>,
    renumber: bool,
    renumbering: u8,
    hellos: u32,
    unanswered: u32,
    rx_total: usize,
    pending_last: Option<(i64, Time)>,
    pending_error: Option<(String, Time)>,
    greeting: bool,
    user_wait: bool,
    heard: Time,
    moved: Time,
    asked: Time,
    lost_at_least_once: bool,
    idle_seen: Option<Time>,
    /// Where the file has brought the axes, until the printer's own word of it comes.
    believed: Vec<(u8, f64)>,
    elsewhere: Option<Stop>,
    noise: (u32, u32),
    outcome: Option<Outcome>,
    events: VecDeque<Event>,
}

impl Sender {
    /// A sender for a print from its beginning. The first [`Sender::poll`] starts it.
    pub fn new(program: Arc<Program>, settings: Settings) -> Self {
        let end_block = program.len();
        Self::with_blocks(program, settings, 0..end_block)
    }

    /// A sender for a part of the program, first `prologue`, then `blocks`.
    ///
    /// For a re-entry after a reset: `prologue` brings the machine to the state that the first block expects. When its last line is
    /// proven [`Record::Back`] is to be journalled; until then nothing of it counts as done.
    pub fn reentering(program: Arc<Program>, settings: Settings, prologue: &[String], first: u32) -> Self {
        let end = program.len();
        let mut sender = Self::with_blocks(program, settings, first.min(end)..end);
        sender.prepend(prologue);
        if !prologue.is_empty() {
            // Only when the way is proven is the head back.
            sender.goal = Goal::Return;
        }
        sender
    }

    /// A sender that goes on with a print whose printer may still be counting: nothing moves before its counter agrees
    /// with `standing`.
    pub fn resuming(program: Arc<Program>, settings: Settings, standing: &Standing) -> Self {
        let end = program.len();
        let mut sender = Self::with_blocks(program, settings, 0..end);
        sender.take_standing(standing);
        sender
    }

    fn with_blocks(program: Arc<Program>, settings: Settings, blocks: std::ops::Range<u32>) -> Self {
        Self {
            settings,
            program,
            lines: LineAssembler::default(),
            out: Vec::new(),
            taken: 0,
            history: VecDeque::new(),
            proven: 0,
            credited: 0,
            cursor: 1,
            bytes_out: 0,
            seams: Seams::default(),
            next_block: blocks.start,
            end_block: blocks.end,
            acked_blocks: blocks.start,
            resends: 0,
            since_proof: 0,
            scripts: VecDeque::new(),
            stage: Stage::Hello { asked: None, tries: 0 },
            goal: Goal::Print,
            ready: false,
            begun: false,
            finishing: false,
            cooling: false,
            pause_behind: false,
            way_back_owed: false,
            identity: String::new(),
            emergency_parser: false,
            narrow: 0,
            refused: (0, 0, 0),
            swallow_ok: false,
            resends_end_with_ok: true,
            hold_until: None,
            renumber: false,
            renumbering: 0,
            hellos: 0,
            unanswered: 0,
            rx_total: 0,
            pending_last: None,
            pending_error: None,
            greeting: false,
            user_wait: false,
            heard: Time::ZERO,
            moved: Time::ZERO,
            asked: Time::ZERO,
            lost_at_least_once: false,
            idle_seen: None,
            believed: Vec::new(),
            elsewhere: None,
            noise: (0, 0),
            outcome: None,
            events: VecDeque::new(),
        }
    }

    /// Takes bytes from the printer.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        self.lines.push(bytes);
        while let Some(line) = self.lines.next_line() {
            if self.stage == Stage::Over {
                continue;
            }
            self.noise.0 += 1;
            self.noise.1 += u32::from(line.iter().filter(|b| !b.is_ascii()).count() * 3 > line.len());
            let reply = super::reply::Reply::read(self.settings.protocol, line);
            if self.settings.protocol == Protocol::Klipper
                && let Some(identity) = line.strip_prefix(b"ok FIRMWARE_NAME")
            {
                let text = format!("FIRMWARE_NAME{}", String::from_utf8_lossy(identity));
                self.identify(&text);
            }
            self.hear(now, reply);
        }
    }

    /// Lets time pass: asks, gives up, and fills the window. To be called after every [`Sender::receive`] and at
    /// [`Sender::wake`].
    pub fn poll(&mut self, now: Time) {
        match self.stage {
            Stage::Hello { asked, tries } => self.greet(now, asked, tries),
            Stage::Probe { asked, tries, .. } => self.ask_again(now, asked, tries),
            Stage::Flow => {
                self.act_on_pending(now);
                self.watch(now);
                self.advance_goal(now);
                if self.settled(now) {
                    self.fill(now);
                }
            }
            Stage::Offline | Stage::Over => {}
        }
    }

    /// When to poll again though nothing arrived; `None` where nothing is waited for.
    pub fn wake(&self, now: Time) -> Option<Time> {
        let wait = match self.stage {
            Stage::Offline | Stage::Over => return None,
            _ if self.settings.protocol == Protocol::Grbl => grbl::STATUS_EVERY / 2,
            Stage::Flow if self.cursor - 1 == self.credited && self.goal_is_reached() => return None,
            _ if self.hold_until.is_some() => Duration::from_millis(101),
            _ => Duration::from_millis(250),
        };
        Some(now + wait)
    }

    /// Bytes for the port, in order.
    pub fn pending(&self) -> &[u8] {
        &self.out[self.taken..]
    }

    /// The port has taken `count` of [`Sender::pending`].
    pub fn took(&mut self, count: usize) {
        self.taken = (self.taken + count).min(self.out.len());
        if self.taken == self.out.len() {
            self.out.clear();
            self.taken = 0;
        }
    }

    /// The next event.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// How it ended, once it has.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// What the printer called itself.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// How far the print is.
    pub fn progress(&self) -> Progress {
        Progress {
            acked: self.acked_blocks,
            sent: self.next_block,
            of: self.end_block,
            resends: self.resends,
            proven: self.proven,
            last: self.last(),
        }
    }

    /// The program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    fn event(&mut self, event: Event) {
        self.events.push_back(event);
    }

    fn note(&mut self, text: impl Into<String>) {
        self.event(Event::Note(text.into()));
    }
}
