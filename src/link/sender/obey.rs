//! What a printer asks of its host is done, or shown.

use super::phase::Phase;
use super::{Notice, Sender, Time};
use crate::link::action::HostAction;

impl Sender {
    /// The printer asks for `action`, in the words `text`.
    pub(super) fn obey(&mut self, now: Time, action: HostAction, text: &str) {
        self.heard = now;
        let prints = matches!(self.phase, Phase::Flow(_) | Phase::Probe(_)) && !self.phase.is_fresh();
        match action {
            HostAction::Shown => self.note(format!("the printer's display: {text}")),
            HostAction::Unknown => self.note(format!("the printer asks for {text:?}, which is unknown and ignored")),
            _ if !prints => self.note(format!("the printer asks for {text:?}, but nothing is being printed")),
            HostAction::Pause | HostAction::Leave => self.pause_as_asked(text),
            HostAction::Cancel => {
                self.note(format!("the printer asks for {text:?}: the print is cancelled"));
                self.cancel();
            }
            HostAction::Resume => self.resume(),
            HostAction::Paused => {
                self.note(format!("the printer paused by itself ({text}); waiting for it"));
                self.paused_itself = true;
            }
            HostAction::Resumed => self.goes_on(now),
        }
    }

    /// The safe pause above the part.
    fn pause_as_asked(&mut self, text: &str) {
        let line = self.line_of(self.ledger.credited() + 1);
        self.event(Notice::Trouble { line, text: text.to_owned() });
        self.pause();
    }

    /// The printer's own pause is over: what is silent now is silent.
    pub(super) fn goes_on(&mut self, now: Time) {
        if std::mem::take(&mut self.paused_itself) {
            self.moved = now;
        }
    }
}
