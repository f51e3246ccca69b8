//! What became of a layer the last times it was judged: on the same supports, with the same behind it, it is the same again.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::OverhangRule;
use super::ground::SupportLines;
use super::memory::Memory;
use super::patch::Piece;

/// So many answers are kept of a layer: two kinds of supports are looked at side by side, each with and without droops, and one more round
/// of either asks much of it again.
const KEPT: usize = 8;

/// All that a layer's answer depends on beside the part and what it stands on.
#[derive(PartialEq)]
pub(super) struct Question {
    droops: bool,
    /// Of the lines that hold it: width, reach and ends, in this order.
    lines: [u8; 32],
    memory: Memory,
}

impl Question {
    /// How a layer with so much behind it lies on such `lines` of what is `held`, by a rule of which only [`OverhangRule::droops`] is ever another.
    pub(super) fn of(rule: &OverhangRule, lines: &[[[f64; 2]; 2]], held: &SupportLines, memory: Memory) -> Self {
        let mut digest = Sha256::new();
        let widths = [held.line_mm, held.beside_mm];
        widths.iter().chain(lines.iter().flatten().flatten()).for_each(|v| digest.update(v.to_bits().to_le_bytes()));
        Self { droops: rule.droops, lines: digest.finalize().into(), memory }
    }
}

/// What of a layer hangs and droops, and what is to be remembered of it.
#[derive(Clone, Default)]
pub(super) struct Answer {
    pub(super) pieces: Vec<Piece>,
    pub(super) memory: Memory,
}

/// The answers to the last questions about a layer.
#[derive(Default)]
pub(super) struct Answers(Mutex<VecDeque<(Question, Answer)>>);

impl Answers {
    /// The answer to `question`: the one known, or a `fresh` one, which is told what is behind the layer.
    pub(super) fn of(&self, question: Question, fresh: impl FnOnce(&Memory) -> Answer) -> Answer {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = all().iter().find(|(asked, _)| *asked == question).map(|(_, answer)| answer.clone());
        known.unwrap_or_else(|| {
            // Nobody waits meanwhile.
            let answer = fresh(&question.memory);
            let mut all = all();
            all.truncate(KEPT - 1);
            all.push_front((question, answer.clone()));
            answer
        })
    }
}
