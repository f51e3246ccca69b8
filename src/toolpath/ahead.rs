//! A setup's lines in the order in which they are written, read ahead of the writing so that both go on at once.
//!
//! ```text
//! Ahead::fill -> Batch -> Writer      one thread fills a batch while another writes the one before
//! ```
//!
//! What is in a batch, and so what is written, does not depend on the number of threads.

use std::ops::Range;

use super::inputs::{Chunk, Entry, RewriteError};
use super::items::{Item, Walk};
use crate::geom::Vec3;
use crate::motion::replay::{PlainMoved, PlainStep};

/// Moves, or other lines, that a batch holds: both batches fit into a processor's own memory.
const MOST: usize = 4096;

/// Lines that come one after the other.
#[derive(Default)]
pub(super) struct Batch {
    /// Plain moves.
    pub(super) moves: Vec<PlainMoved>,
    /// All else, each with how many of the moves come before it.
    pub(super) others: Vec<(usize, Other)>,
}

impl Batch {
    pub(super) fn is_empty(&self) -> bool {
        self.moves.is_empty() && self.others.is_empty()
    }

    fn is_full(&self) -> bool {
        self.moves.len().max(self.others.len()) >= MOST
    }

    fn clear(&mut self) {
        self.moves.clear();
        self.others.clear();
    }
}

/// What is no plain move.
pub(super) enum Other {
    /// A layer begins, by its place among the setup's; with its lead where another print was worked at before.
    Layer(usize, Option<Lead>),
    /// A line.
    Item(Item),
}

/// What is wanted of a lead that a travel of our own replaces.
pub(super) struct Lead {
    /// Its lines that pass.
    pub(super) kept: Vec<Range<usize>>,
    /// What it pushes more than it pulls: the slicer's own allowance for a restart, mm.
    pub(super) owed_mm: f64,
    /// Pauses among them.
    pub(super) pauses: Vec<Range<usize>>,
    /// Where the layer begins to extrude, slot frame.
    pub(super) start: Option<Vec3>,
}

impl Lead {
    /// Takes `walk` through the lead of `chunk`.
    fn through(chunk: &Chunk<'_>, walk: &mut Walk<'_>) -> Result<Self, RewriteError> {
        let mut lead = Self { kept: Vec::new(), pauses: Vec::new(), owed_mm: 0.0, start: None };
        if chunk.index == 0 {
            // It comes from the slicer's origin; what it pushes is not this print's.
            lead.kept.clone_from(&chunk.entry.input.sliced.lead);
        } else {
            while let Some(item) = walk.next(chunk.layer.body)? {
                match item {
                    Item::Keep(span) => lead.kept.push(span),
                    Item::Pause(span) => lead.pauses.push(span),
                    Item::Step(step) => lead.owed_mm += step.e,
                    // Another print went on meanwhile.
                    Item::FirmwareRetract(_) | Item::Wait(_) => {}
                }
            }
        }
        lead.start = walk.tip();
        Ok(lead)
    }
}

/// Reads the lines of a setup.
pub(super) struct Ahead<'a> {
    chunks: &'a [Chunk<'a>],
    /// By the entries' places in the setup.
    walks: Vec<Walk<'a>>,
    /// The layer in hand.
    layer: Option<usize>,
    /// The next one.
    next: usize,
}

impl<'a> Ahead<'a> {
    pub(super) fn new(group: &'a [Entry<'a>], chunks: &'a [Chunk<'a>]) -> Self {
        let walks = group.iter().map(|entry| entry.input.sliced.walk()).collect();
        Self { chunks, walks, layer: None, next: 0 }
    }

    /// Puts what comes next into `batch`, in place of what is in it; nothing at the end.
    pub(super) fn fill(&mut self, batch: &mut Batch) -> Result<(), RewriteError> {
        batch.clear();
        while !batch.is_full() {
            match self.layer {
                Some(layer) => {
                    if self.lines(layer, batch)? {
                        self.layer = None;
                    }
                }
                None if self.next == self.chunks.len() => break,
                None => self.begin(batch)?,
            }
        }
        Ok(())
    }

    fn begin(&mut self, batch: &mut Batch) -> Result<(), RewriteError> {
        let (index, chunk) = (self.next, &self.chunks[self.next]);
        let same = index > 0 && self.chunks[index - 1].position == chunk.position;
        let lead = if same { None } else { Some(Lead::through(chunk, &mut self.walks[chunk.position])?) };
        batch.others.push((batch.moves.len(), Other::Layer(index, lead)));
        self.layer = Some(index);
        self.next += 1;
        Ok(())
    }

    /// Lines of a layer; `true` at its end, `false` where the batch is full before.
    fn lines(&mut self, layer: usize, batch: &mut Batch) -> Result<bool, RewriteError> {
        let chunk = &self.chunks[layer];
        let (walk, end) = (&mut self.walks[chunk.position], chunk.layer.end);
        while !batch.is_full() {
            match walk.plain(end) {
                Some(PlainStep::Move(m)) => batch.moves.push(m),
                Some(PlainStep::Feed) => {}
                None => match walk.next(end)? {
                    Some(item) => batch.others.push((batch.moves.len(), Other::Item(item))),
                    None => return Ok(true),
                },
            }
        }
        Ok(false)
    }
}
