//! Where the conversation with the printer stands. Each phase owns what only it needs.
//!
//! ```text
//! Hello --ok--> Flow --doubt--> Probe --the printer's count--> Flow ...  Over
//!   ^            |  ^             |
//!   |   fresh    |  '--Offline<---'   the link is gone; back: Hello where nothing was sent, else Probe
//!   '------------'
//! ```

use super::stop::Outcome;
use crate::link::Time;

/// The phases of the conversation.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phase {
    /// Nobody has answered yet.
    Hello {
        /// When it was asked last.
        asked: Option<Time>,
        /// How often.
        tries: u32,
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
    /// What it has answered, to be confirmed.
    pub(super) answer: Option<i64>,
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
        Self { doubt, greeted: false, asked: None, tries: 0, answer: None }
    }

    /// How often the same count must come.
    pub(super) fn confirmations(&self) -> u32 {
        match self.doubt {
            Doubt::Answer(_) => 1,
            Doubt::Link => 2,
        }
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
