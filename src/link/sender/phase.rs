//! Where the conversation with the printer stands. Each phase owns what only it needs.
//!
//! ```text
//! Hello --ok--> Flow --doubt--> Probe --the printer's count--> Flow ...  Over
//!   ^            |  ^             |
//!   |   fresh    |  '--Offline<---'   the link is gone; back: Hello where nothing was sent, else Probe
//!   '------------'
//! ```
//!
//! Before its first question a conversation waits until no answer has come for a while: an earlier host may have left some unread.

use std::time::Duration;

use super::outcome::Outcome;
use crate::link::Time;

/// Nothing is asked before no answer has come for this long.
const QUIET: Time = Duration::from_millis(250);

/// A printer that answers without end is asked all the same.
const NEVER_QUIET: Time = Duration::from_secs(5);

/// The phases of the conversation.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phase {
    /// Nobody has answered yet.
    Hello {
        /// When it was asked last; `None` as long as answers to an earlier host may still arrive.
        asked: Option<Time>,
        /// How often.
        tries: u32,
        /// The wait before the first question, once it has begun.
        quiet: Option<Quiet>,
    },
    /// Lines go out and are answered.
    Flow(Session),
    /// A doubt: nothing goes out before the printer has said its count.
    Probe(CounterProbe),
    /// The link is gone.
    Offline(Session),
    /// The end, and how it came.
    Over(Outcome),
}

/// What has been said so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Session {
    /// Nothing that moves or heats has been sent: whatever is odd, the greeting begins again. With the greetings so far.
    Fresh {
        /// Greetings so far.
        hellos: u32,
    },
    /// From here on a doubt is no fresh start.
    Begun(Begun),
}

/// A conversation in which something that moves or heats has been sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Begun {
    /// Identity and our own lines go out one at a time; no block before they are proven.
    Opening {
        /// Behind a break of the link, or of the host.
        again: bool,
    },
    /// Blocks may go.
    Open,
}

/// The question for the printer's count.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CounterProbe {
    pub(super) doubt: Doubt,
    /// A greeting has come: the printer may have been reset.
    pub(super) greeted: bool,
    /// When it was asked last.
    pub(super) asked: Option<Time>,
    /// How often.
    pub(super) tries: u32,
    /// What it has answered, and how often in a row.
    pub(super) answer: Option<(i64, u32)>,
    /// Whose question its answers can be to.
    pub(super) witness: Witness,
    /// A count that does not fit has been asked for anew, from the silence on.
    pub(super) anew: bool,
}

/// The wait until no answer comes any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Quiet {
    until: Time,
    at_most: Time,
}

impl Quiet {
    /// Begins to wait at `now`.
    pub(super) fn from(now: Time) -> Self {
        Self { until: now + QUIET, at_most: now + NEVER_QUIET }
    }

    /// An answer has come, to whomever.
    pub(super) fn disturb(&mut self, now: Time) {
        self.until = self.until.max(now + QUIET).min(self.at_most);
    }

    pub(super) fn is_over(&self, now: Time) -> bool {
        now >= self.until
    }
}

/// Whose question an answer is to. The firmwares' texts do not say: `Last Line: 7` is the same to every host.
///
/// The printer is to repeat a word that nobody else has used: firmwares repeat a line that they do not know. What comes behind that can only be
/// an answer to this host, since lines are executed in the order in which they are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Witness {
    /// Nothing is asked before it is quiet.
    Quiet(Option<Quiet>),
    /// The word has gone out.
    Called {
        /// When, the last time.
        at: Time,
        /// How often.
        times: u32,
        /// Whether the printer has answered anything since, and when last.
        answered: Option<Time>,
    },
    /// Answers are to this host.
    Ours {
        /// Whether the word has come back; a firmware that does not repeat it is believed only what it says several times.
        proved: bool,
    },
}

/// What is in doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Doubt {
    /// An answer.
    Answer(Begun),
    /// Everything since the link broke: an answer counts only when it comes twice, and the printer is identified again.
    Link,
}

impl CounterProbe {
    pub(super) fn of(doubt: Doubt) -> Self {
        let witness = match doubt {
            Doubt::Answer(_) => Witness::Ours { proved: true },
            Doubt::Link => Witness::Quiet(None),
        };
        Self { doubt, greeted: false, asked: None, tries: 0, answer: None, witness, anew: false }
    }

    /// How often the same count must come.
    pub(super) fn confirmations(&self) -> u32 {
        match (self.doubt, self.witness) {
            (Doubt::Answer(_), _) => 1,
            (Doubt::Link, Witness::Ours { proved: true }) => 2,
            (Doubt::Link, _) => 3,
        }
    }

    /// Whether what is answered is nothing that this host has asked.
    pub(super) fn is_deaf(&self) -> bool {
        !matches!(self.witness, Witness::Ours { .. })
    }

    /// Begins from the silence on: what has been answered so far counts for nothing.
    pub(super) fn begin_anew(&mut self) {
        (self.witness, self.answer, self.asked) = (Witness::Quiet(None), None, None);
    }

    /// Counts an answer; how often it has come in a row.
    pub(super) fn count(&mut self, found: i64) -> u32 {
        let times = self.answer.filter(|(said, _)| *said == found).map_or(1, |(_, times)| times + 1);
        self.answer = Some((found, times));
        times
    }
}

impl Doubt {
    /// How the conversation continues once it is settled.
    pub(super) fn settled(self) -> Begun {
        match self {
            Self::Answer(begun) => begun,
            Self::Link => Begun::Opening { again: true },
        }
    }
}

impl Phase {
    /// What has been said so far; `None` once it is over.
    pub(super) fn session(&self) -> Option<Session> {
        match self {
            Self::Hello { tries, .. } => Some(Session::Fresh { hellos: *tries }),
            Self::Flow(session) | Self::Offline(session) => Some(*session),
            Self::Probe(probe) => Some(Session::Begun(probe.doubt.settled())),
            Self::Over(_) => None,
        }
    }

    /// Whether the count is asked for behind a break of the link.
    pub(super) fn asks_after_break(&self) -> bool {
        matches!(self, Self::Probe(CounterProbe { doubt: Doubt::Link, .. }))
    }

    /// Whether what is answered is nothing that this host has asked.
    pub(super) fn is_deaf(&self) -> bool {
        match self {
            Self::Hello { asked, .. } => asked.is_none(),
            Self::Probe(probe) => probe.is_deaf(),
            _ => false,
        }
    }

    /// Whether nothing that moves or heats has been sent.
    pub(super) fn is_fresh(&self) -> bool {
        matches!(self.session(), Some(Session::Fresh { .. }))
    }

    /// Whether blocks may go.
    pub(super) fn is_open(&self) -> bool {
        self.session() == Some(Session::Begun(Begun::Open))
    }

    pub(super) fn is_over(&self) -> bool {
        matches!(self, Self::Over(_))
    }

    /// Something that moves or heats is sent.
    pub(super) fn begin(&mut self) {
        if let Self::Flow(session @ Session::Fresh { .. }) = self {
            *session = Session::Begun(Begun::Opening { again: false });
        }
    }

    /// Blocks may go from now on; `None` where they could already or cannot yet, else whether that is again.
    pub(super) fn open(&mut self) -> Option<bool> {
        let again = match self {
            Self::Flow(Session::Fresh { .. }) => false,
            Self::Flow(Session::Begun(Begun::Opening { again }))
            | Self::Probe(CounterProbe { doubt: Doubt::Answer(Begun::Opening { again }), .. }) => *again,
            _ => return None,
        };
        match self {
            Self::Flow(session) => *session = Session::Begun(Begun::Open),
            Self::Probe(probe) => probe.doubt = Doubt::Answer(Begun::Open),
            _ => {}
        }
        Some(again)
    }
}
