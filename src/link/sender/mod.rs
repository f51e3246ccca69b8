//! The host's side of the wire as a state machine: bytes and times in, bytes and events out.
//!
//! ```text
//! phase     where the conversation stands: hello, flow, probe, offline, over
//! activity  what is being done: print, drain, leave, away, return, cool
//! ledger    numbers: which lines are under way, answered, proven
//! ```
//!
//! An `ok` moves `credited`. Only proof moves `proven`: the answer to a numbered M105, ours or the file's (its `ok` alone carries
//! temperatures, so nothing else can be taken for it), or an error's `Last Line: n` together with `Resend: n+1`. Lines stay in the
//! ledger until proven, so that a doubled or lost `ok` is mended by the printer's own counter. Where a protocol has no
//! counter, what cannot be accounted for stops the print.
//!
//! A line goes out again only on the printer's word that it has not taken it; after a silence the printer is asked with a line
//! whose number is wrong on purpose (which it must refuse, naming its last one).
//!
//! This room knows no port, thread or clock: times are since any fixed moment.

mod activity;
mod aftermath;
mod brake;
mod flow;
mod grbl;
mod hello;
mod ledger;
mod listen;
mod locate;
mod notice;
mod obey;
mod outbox;
mod outcome;
mod phase;
mod probe;
mod stop;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

pub use aftermath::{AfterStop, StopWatch};
pub use locate::told_axes;
pub use notice::{Counts, Notice};
pub use outcome::{Outcome, StopReason};

use super::Time;
use super::journal::JournalSummary;
use super::place::Place;
use super::program::Program;
use super::protocol::{Accounting, Traits};
use super::reply::{Reply, Wording};
use super::settings::SenderSettings;
use super::wire::LineAssembler;
use activity::{Activity, PlaceAsked};
use brake::Brake;
use ledger::{Framing, Ledger, Purpose};
use listen::{Dialog, OwnOk};
use outbox::Outbox;
use phase::Phase;

/// The host's side of the wire.
#[derive(Clone, Debug)]
pub struct Sender {
    settings: SenderSettings,
    program: Arc<Program>,
    input: Input,
    outbox: Outbox,
    phase: Phase,
    activity: Activity,
    ledger: Ledger,
    /// Our own lines that are still to go out, before any block.
    own: VecDeque<Purpose>,
    next_block: u32,
    end_block: u32,
    acked_blocks: u32,
    /// Whether no other host has sent more of the program than this one.
    knows_all: bool,
    since_proof: u32,
    resends: u32,
    /// How often the printer was to repeat a word.
    calls: u32,
    /// Whether the journal knows that lines have gone out.
    recorded: bool,
    /// How often the printer has said that it has read the last proof, and not answered it.
    insisted: u32,
    /// What the printer has said of its bed.
    bed_c: Option<f64>,
    /// Where the printer has to be at the line that asks for it.
    place: Option<PlaceAsked>,
    printer: Printer,
    dialog: Dialog,
    watch: Watch,
    brake: Brake,
    /// What Grbl's status counts its places from, in the order of its axes.
    offset: Vec<f64>,
    /// Commands that the printer does not know: each is told once.
    unknown: Vec<String>,
    /// The printer waits for a person.
    user_wait: bool,
    /// The printer has paused by itself, and has not said that it goes on.
    paused_itself: bool,
    /// When the printer last showed life.
    heard: Time,
    /// When a line last went out or was taken.
    moved: Time,
    events: VecDeque<Notice>,
}

/// What arrives.
#[derive(Clone, Debug, Default)]
struct Input {
    lines: LineAssembler,
    heard: u32,
    garbled: u32,
    /// The last line that nobody understands, as it may be shown.
    strange: Option<String>,
}

/// What is known of the printer.
#[derive(Clone, Debug)]
struct Printer {
    identity: String,
    /// Some of its commands act before they are queued.
    emergency_parser: bool,
    /// An `ok` follows each of its `Resend:`.
    ok_follows_resend: bool,
    /// It has answered an M105 with temperatures.
    reports: bool,
    /// It waits for a line's end as long as it takes.
    reads_in_pieces: bool,
    /// Whether its parser is known to need no blank behind a line's number.
    spelling: Spelling,
    /// The most commands that it has said its queue has room for besides the one it answers, and what it has said last.
    queue: [usize; 2],
}

/// How lines begin: with a blank behind the number as everybody reads it, or without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spelling {
    /// Nobody knows yet.
    Long,
    /// The firmware's name says that it needs none.
    Tried {
        /// How often the first short line was tried, this time included.
        strikes: u32,
    },
    /// At the first of them it was silent, or refused one.
    Doubted {
        /// How often the first short line is tried, the next time included.
        strikes: u32,
    },
    /// A line without has been answered.
    Short,
    /// The first of them was never answered.
    Never,
}

/// What is remembered of a silence, by what settles it.
#[derive(Clone, Debug)]
enum Watch {
    Counter,
    /// Proofs in vain since the last answer.
    Proof {
        asked: Time,
        unanswered: u32,
    },
    /// The machine idles though lines are unanswered; the size of its receive buffer, 0 where it has not said.
    Status {
        asked: Time,
        idle_since: Option<Time>,
        buffer: usize,
    },
}

impl Input {
    fn next(&mut self, wording: Wording) -> Option<Reply> {
        let line = self.lines.next_line()?;
        self.heard += 1;
        self.garbled += u32::from(line.iter().filter(|b| !b.is_ascii()).count() * 3 > line.len());
        let reply = Reply::read(wording, line);
        if reply == Reply::Chatter {
            self.strange = Some(
                String::from_utf8_lossy(line)
                    .chars()
                    .take(60)
                    .filter(char::is_ascii)
                    .map(|c| if c.is_ascii_control() { '?' } else { c })
                    .collect(),
            );
        }
        Some(reply)
    }

    /// Whether bytes come, but no words.
    fn is_noise(&self) -> bool {
        self.heard > 3 && self.garbled * 2 > self.heard
    }

    /// Half a line belongs to nothing once the link is gone.
    fn forget(&mut self) {
        self.lines.clear();
    }
}

impl Watch {
    fn of(accounting: Accounting) -> Self {
        match accounting {
            Accounting::Counter => Self::Counter,
            Accounting::Proof => Self::Proof { asked: Time::ZERO, unanswered: 0 },
            Accounting::Status => Self::Status { asked: Time::ZERO, idle_since: None, buffer: 0 },
        }
    }
}

impl Sender {
    /// A sender for a print from its beginning. The first [`Sender::poll`] starts it.
    pub fn new(program: Arc<Program>, settings: SenderSettings) -> Self {
        let end_block = program.len();
        Self::with_blocks(program, settings, 0..end_block)
    }

    /// A sender for a part of the program, first `prologue`, then the blocks from `first` on.
    ///
    /// For a re-entry after a reset: `prologue` brings the machine to the state that the first block expects. When its last line is
    /// proven [`Record::Back`](super::Record::Back) is to be journalled; until then nothing of it counts as done.
    pub fn reentering(program: Arc<Program>, settings: SenderSettings, prologue: &[String], first: u32) -> Self {
        let end = program.len();
        let mut sender = Self::with_blocks(program, settings, first.min(end)..end);
        if !prologue.is_empty() {
            sender.queue(prologue);
            sender.knows_all = false;
            // Only when that is proven is the head back.
            sender.activity = Activity::Return { owed: false, pause_behind: false };
        }
        sender
    }

    /// A sender that resumes a print whose printer may still be counting: nothing moves before its counter agrees
    /// with `standing`.
    pub fn resuming(program: Arc<Program>, settings: SenderSettings, standing: &JournalSummary) -> Self {
        let end = program.len();
        let mut sender = Self::with_blocks(program, settings, 0..end);
        sender.take_standing(standing);
        sender.knows_all = false;
        sender
    }

    /// A sender that resumes a print whose printer does not count, but may still know where it is: nothing moves before its word
    /// fits one of `places`, in order; `away` where that is above the part, in a pause.
    pub fn locating(program: Arc<Program>, settings: SenderSettings, places: Vec<Place>, away: bool) -> Self {
        let end = program.len();
        let first = places.first().map_or(0, |place| place.block).min(end);
        let mut sender = Self::with_blocks(program, settings, first..end);
        sender.activity = Activity::Locate { places, away, asked: false, said: None };
        sender.knows_all = false;
        sender
    }

    fn with_blocks(program: Arc<Program>, settings: SenderSettings, blocks: std::ops::Range<u32>) -> Self {
        let traits = settings.protocol.traits();
        let framing = if traits.numbered { Framing::Numbered { blank: true } } else { Framing::Plain };
        let printer = Printer {
            identity: String::new(),
            emergency_parser: false,
            ok_follows_resend: true,
            reports: false,
            reads_in_pieces: false,
            spelling: Spelling::Long,
            queue: [0; 2],
        };
        Self {
            settings,
            program,
            input: Input::default(),
            outbox: Outbox::default(),
            phase: Phase::Hello { asked: None, tries: 0, quiet: None },
            activity: Activity::Print { ending: false },
            ledger: Ledger::new(framing),
            own: VecDeque::new(),
            next_block: blocks.start,
            end_block: blocks.end,
            acked_blocks: blocks.start,
            knows_all: true,
            since_proof: 0,
            resends: 0,
            calls: 0,
            recorded: false,
            insisted: 0,
            bed_c: None,
            place: None,
            printer,
            dialog: Dialog::default(),
            watch: Watch::of(traits.accounting),
            brake: Brake::default(),
            offset: Vec::new(),
            unknown: Vec::new(),
            user_wait: false,
            paused_itself: false,
            heard: Time::ZERO,
            moved: Time::ZERO,
            events: VecDeque::new(),
        }
    }

    fn traits(&self) -> &'static Traits {
        self.settings.protocol.traits()
    }

    /// Takes bytes from the printer.
    pub fn receive(&mut self, now: Time, bytes: &[u8]) {
        self.input.lines.push(bytes);
        while let Some(reply) = self.input.next(self.traits().wording) {
            if !matches!(self.phase, Phase::Offline(_) | Phase::Over(_)) {
                self.hear(now, reply);
            }
        }
    }

    /// Lets time pass: asks, gives up, and fills the window. To be called after every [`Sender::receive`] and at
    /// [`Sender::wake`].
    pub fn poll(&mut self, now: Time) {
        match self.phase {
            Phase::Hello { .. } => self.greet(now),
            Phase::Probe(_) => self.ask_again(now),
            Phase::Flow(_) => self.act(now),
            Phase::Offline(_) | Phase::Over(_) => {}
        }
    }

    /// What is to be done while lines flow; whatever ends that ends the rest.
    fn act(&mut self, now: Time) {
        self.act_on_errors(now);
        if matches!(self.phase, Phase::Flow(_)) {
            self.check_timeouts(now);
        }
        if matches!(self.phase, Phase::Flow(_)) {
            self.advance();
        }
        if matches!(self.phase, Phase::Flow(_)) && self.settled(now) {
            self.fill(now);
        }
    }

    /// When to poll again though nothing arrived; `None` where nothing is waited for.
    pub fn wake(&self, now: Time) -> Option<Time> {
        let wait = match self.phase {
            Phase::Offline(_) | Phase::Over(_) => return None,
            _ if matches!(self.watch, Watch::Status { .. }) => grbl::STATUS_EVERY / 2,
            Phase::Flow(_) if self.ledger.in_flight() == 0 && self.activity == Activity::Away => return None,
            _ if matches!(self.dialog.own_ok, OwnOk::Watched(_)) => Duration::from_millis(101),
            _ => Duration::from_millis(250),
        };
        Some(now + wait)
    }

    /// Bytes for the port, in order.
    pub fn pending(&self) -> &[u8] {
        self.outbox.pending()
    }

    /// The port has taken `count` of [`Sender::pending`].
    pub fn took(&mut self, count: usize) {
        self.outbox.took(count);
    }

    /// The next event.
    pub fn next_event(&mut self) -> Option<Notice> {
        self.events.pop_front()
    }

    /// How it ended, once it has.
    pub fn outcome(&self) -> Option<&Outcome> {
        if let Phase::Over(outcome) = &self.phase { Some(outcome) } else { None }
    }

    /// What the printer called itself.
    pub fn identity(&self) -> &str {
        &self.printer.identity
    }

    /// How far the print is.
    pub fn progress(&self) -> Counts {
        Counts {
            acked: self.acked_blocks,
            sent: self.next_block,
            of: self.end_block,
            resends: self.resends,
            proven: self.ledger.proven(),
            last: self.ledger.last(),
        }
    }

    /// No block from this one on was sent, by whichever host; `None` where an earlier one may have sent more.
    pub fn sent_at_most(&self) -> Option<u32> {
        (self.knows_all && self.next_block > 0).then_some(self.next_block)
    }

    /// Listens to the printer behind an emergency stop that went out at `now`.
    pub fn stop_watch(&self, now: Time) -> StopWatch {
        StopWatch::new(self.settings.protocol, now)
    }

    /// The program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    fn event(&mut self, event: Notice) {
        self.events.push_back(event);
    }

    fn note(&mut self, text: impl Into<String>) {
        self.event(Notice::Note(text.into()));
    }
}
