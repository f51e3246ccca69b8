//! Sliced G-code as prints and layers.
//!
//! A layer begins right behind the last extrusion of the one before: its *lead* (retraction, travel, marks) comes before
//! its first extrusion, its *body* from there on. A lead may be replaced by a travel of our own; a body never changes but
//! by translation.
//!
//! Coordinates are those of the file: slot frame, mm.

use std::ops::Range;

use super::policy::{CommandPolicy, Stage, keeps_comment, policy};
use crate::gcode::marks::Bead;
use crate::gcode::meaning::{Effect, Firmware, Hazard, Heater, effect};
use crate::gcode::{LineKind, ParseError, ParsedLine, lines};
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::{Arc, Controller, Move, Reading, ReplayError, Step, flatten};

/// A move of three axes and filament, positions known.
#[derive(Clone, Debug, PartialEq)]
pub struct Step3 {
    /// Before, mm.
    pub from: Vec3,
    /// After, mm.
    pub to: Vec3,
    /// Filament, mm.
    pub e: f64,
    /// Feed, mm/min.
    pub feed: Option<f64>,
    /// An arc in XY.
    pub arc: Option<Arc>,
    /// The span of its comment in the file, with `;`.
    pub comment: Range<usize>,
    /// Line in the file.
    pub line: u32,
}

impl Step3 {
    /// Whether filament is laid down: pushed while the tip moves.
    pub fn prints(&self) -> bool {
        self.e > 0.0 && (self.from != self.to || self.arc.is_some())
    }
}

/// One line of a layer.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A move.
    Step(Step3),
    /// G10 (`true`) or G11.
    FirmwareRetract(bool),
    /// Bytes of the file to pass on as they stand.
    Keep(Range<usize>),
}

/// A layer of one print.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// The height of its first extrusion, mm, slot frame.
    pub z: f64,
    /// Up to the first extrusion.
    pub lead: Vec<Item>,
    /// From there on.
    pub body: Vec<Item>,
}

/// One print as sliced.
#[derive(Clone, Debug)]
pub struct SlicedPrint {
    /// Its layers, lowest first.
    pub layers: Vec<Layer>,
    /// The box of all extrusion, mm, slot frame.
    pub extrusion: Bounds,
    /// Filament laid down, mm.
    pub filament_mm: f64,
    /// Whose words its lines are.
    pub firmware: Firmware,
    /// Commands of its start and end code that were left out and might be missed, each once.
    pub replaced: Vec<String>,
    /// The slicer's own factor on all flow (its extrusion multiplier); 1 where the file does not say.
    pub multiplier: f64,
    /// The cross-section that its slicer fills.
    pub bead: Bead,
    /// By how much the slicer moves outer walls outward on purpose, mm; `None` where the file does not say.
    pub outset_mm: Option<f64>,
    /// Widths of its lines, mm, that the head states; empty where the lines state their own.
    pub widths_mm: Vec<f64>,
    /// Waits (G4) between its first and last extrusion, s. They are left out of what is written.
    pub waits_s: f64,
    /// Nozzle temperature set before the first extrusion.
    pub nozzle_c: Option<f64>,
    /// Bed temperature set before the first extrusion.
    pub bed_c: Option<f64>,
    /// Comments before the first extrusion.
    pub prologue: Vec<Range<usize>>,
    /// Comments after the last extrusion.
    pub epilogue: Vec<Range<usize>>,
}

/// A print with the name the slicer gave it.
#[derive(Clone, Debug)]
pub struct Segment {
    /// The object label, where the slicer wrote one of ours (`print-03..`).
    pub print: Option<usize>,
    /// The print.
    pub sliced: SlicedPrint,
}

/// Why a sliced file cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SlicedError {
    /// Binary G-code.
    #[error(
        "{file}: binary G-code; switch off \"Supports binary G-code\" (Printer Settings > General) or binary_gcode = 0, and slice again"
    )]
    Binary {
        /// The file.
        file: String,
    },
    /// A line that is not G-code.
    #[error("{file}:{line}: {source}")]
    Parse {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// What is wrong.
        source: ParseError,
    },
    /// A line without a safe meaning.
    #[error("{file}:{line}: {source}")]
    Replay {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// What is wrong.
        source: ReplayError,
    },
    /// A command whose effect at a tilt nobody knows.
    #[error("{file}:{line}: {text:?} cannot be rewritten safely; remove it from the slicer's custom G-code")]
    Command {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// The line.
        text: String,
    },
    /// Extrusion from an unknown place.
    #[error("{file}:{line}: extrusion before X, Y and Z are known")]
    UnknownPosition {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
    },
    /// No extrusion at all.
    #[error(
        "{file}: nothing is extruded; the slicer dropped the part, or the file is not for a printer that extrudes with E"
    )]
    NoExtrusion {
        /// The file.
        file: String,
    },
    /// Objects printed all at once.
    #[error(
        "{file}:{line}: the printing of {label:?} is interrupted by other objects; switch on \"complete individual objects\" and slice again"
    )]
    Interleaved {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
        /// The label that came back.
        label: String,
    },
    /// Not what the slicer says it laid.
    #[error(
        "{file}: {counted_mm:.2} mm of filament are laid down, and the file says that {stated_mm:.2} mm are used; it was changed after \
         slicing, or is damaged; slice again"
    )]
    Filament {
        /// The file.
        file: String,
        /// What its moves add up to.
        counted_mm: f64,
        /// What its comment says.
        stated_mm: f64,
    },
    /// The end is missing.
    #[error(
        "{file}: the slicer's own closing comments are missing (\"filament used\"): the file was cut short; slice again"
    )]
    Torn {
        /// The file.
        file: String,
    },
    /// Our own output.
    #[error("{file}:{line}: already rewritten by trunnion; give the slicer's own file")]
    Rewritten {
        /// The file.
        file: String,
        /// Counted from 1.
        line: u32,
    },
}

/// Extrusions whose heights differ by less than this are one layer, mm: the last printed digit.
const SAME_LAYER: f64 = 1.5e-3;

/// How sliced files are read for a machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct InputWords<'a> {
    /// Whose words a file is taken to be in where it does not say so itself (`gcode_flavor`, `;FLAVOR:`).
    pub firmware: Firmware,
    /// Commands that the profile lets pass although nobody knows or follows what they do (`[dialect] allow`).
    pub allow: &'a [String],
}

/// Reads `bytes` as one or several prints; `file` is for the messages.
///
/// # Errors
///
/// [`SlicedError`] with file and line for everything that cannot be rewritten safely.
pub fn read_sliced(bytes: &[u8], file: &str, words: InputWords<'_>) -> Result<Vec<Segment>, SlicedError> {
    if bytes.starts_with(b"GCDE") {
        return Err(SlicedError::Binary { file: file.to_owned() });
    }
    let mut reader = Reader::new(file, bytes, words);
    let mut parsed = ParsedLine::default();
    for line in lines(bytes) {
        reader.line = line.number;
        parsed.read(line.bytes).map_err(|source| SlicedError::Parse {
            file: file.to_owned(),
            line: line.number,
            source,
        })?;
        let start = line.bytes.as_ptr() as usize - bytes.as_ptr() as usize;
        reader.take(&parsed, start, line.bytes)?;
    }
    reader.finish()
}

/// How much of a file's beginning and end is searched for its flavour; PrusaSlicer's settings at the end are some 15 kB.
const FLAVOR_WITHIN: usize = 64 * 1024;

/// The firmware that the file says it is for.
fn stated_firmware(bytes: &[u8]) -> Option<Firmware> {
    let parts = [&bytes[..bytes.len().min(FLAVOR_WITHIN)], &bytes[bytes.len().saturating_sub(FLAVOR_WITHIN)..]];
    parts.iter().find_map(|part| {
        [&b"; gcode_flavor = "[..], b";FLAVOR:"].iter().find_map(|key| {
            let rest = &part[memchr::memmem::find(part, key)? + key.len()..];
            let end = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
            Firmware::of_flavor(&String::from_utf8_lossy(&rest[..end]))
        })
    })
}

/// The cross-section of the slicer that the file says it is from.
fn stated_bead(bytes: &[u8]) -> Bead {
    let head = &bytes[..bytes.len().min(FLAVOR_WITHIN)];
    let cura = [&b";Generated with Cura"[..], b";FLAVOR:"].iter().any(|key| memchr::memmem::find(head, key).is_some());
    if cura { Bead::Square } else { Bead::Round }
}

/// The widths that the file's head states, as Slic3r and PrusaSlicer write them, where no line states its own.
fn stated_widths(bytes: &[u8]) -> Vec<f64> {
    if memchr::memmem::find(bytes, b"\n;WIDTH:").is_some() {
        return Vec::new();
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(FLAVOR_WITHIN)]);
    let width =
        |line: &str| line.strip_prefix("; ")?.split_once("extrusion width = ")?.1.split("mm").next()?.parse().ok();
    let mut widths: Vec<f64> = head.lines().filter_map(width).filter(|w| *w > 0.0).collect();
    widths.sort_by(f64::total_cmp);
    widths.dedup();
    widths
}

/// Whether a line is a macro that Klipper has from the start.
fn has_klipper_macros(bytes: &[u8]) -> bool {
    let mut parsed = ParsedLine::default();
    lines(bytes).any(|line| {
        let name = line.bytes.len() > 2 && line.bytes[..3].iter().all(|b| b.is_ascii_alphabetic() || *b == b'_');
        name && parsed.read(line.bytes).is_ok()
            && parsed.kind == LineKind::Macro
            && !matches!(effect(Firmware::Klipper, &parsed), Effect::Hazard(Hazard::Unknown))
    })
}

struct Reader<'a> {
    file: &'a str,
    bytes: &'a [u8],
    line: u32,
    firmware: Firmware,
    bead: Bead,
    widths_mm: Vec<f64>,
    allow: &'a [String],
    replaced: Vec<String>,
    controller: Controller,
    done: Vec<Segment>,
    label: Option<usize>,
    seen: Vec<usize>,
    layers: Vec<Layer>,
    /// Items since the last extrusion, with what is to be thought of them if no extrusion follows.
    pending: Vec<Pending>,
    extrusion: Bounds,
    filament_mm: f64,
    /// Moves that lay filament.
    laying: usize,
    /// Waits up to the last extrusion, and since.
    waits_s: [f64; 2],
    /// Nozzle and bed as last set.
    heat: [Option<f64>; 2],
    /// The same when the print began.
    heat_at_first: [Option<f64>; 2],
    prologue: Vec<Range<usize>>,
}

/// A line whose fate depends on whether extrusion follows.
struct Pending {
    item: Option<Item>,
    /// A line that is refused if extrusion comes before *and* after.
    suspect: Option<(u32, Range<usize>)>,
    comment: bool,
    /// Kept even when the pose changes around it (fans, limits).
    state: bool,
}

impl<'a> Reader<'a> {
    fn new(file: &'a str, bytes: &'a [u8], words: InputWords<'a>) -> Self {
        // RS274 machines print no slicer's own words: what is not stated is a printer's.
        let unstated = if words.firmware.is_printer() { words.firmware } else { Firmware::Marlin };
        let stated = stated_firmware(bytes).unwrap_or(unstated);
        // PrusaSlicer before 2.6 had no flavour for Klipper, whose users chose Marlin's and wrote macros.
        let firmware = if stated == Firmware::Marlin && has_klipper_macros(bytes) { Firmware::Klipper } else { stated };
        Self {
            file,
            bytes,
            line: 0,
            firmware,
            bead: stated_bead(bytes),
            widths_mm: stated_widths(bytes),
            allow: words.allow,
            replaced: Vec::new(),
            controller: Controller::new(Reading::sliced_for(firmware)),
            done: Vec::new(),
            label: None,
            seen: Vec::new(),
            layers: Vec::new(),
            pending: Vec::new(),
            extrusion: Bounds::EMPTY,
            filament_mm: 0.0,
            laying: 0,
            waits_s: [0.0; 2],
            heat: [None; 2],
            heat_at_first: [None; 2],
            prologue: Vec::new(),
        }
    }

    fn take(&mut self, parsed: &ParsedLine, start: usize, text: &[u8]) -> Result<(), SlicedError> {
        let whole = start..start + text.len();
        if parsed.kind == LineKind::Empty {
            let comment = &text[parsed.comment.clone()];
            if comment.starts_with(b"TRUNNION ") {
                return Err(SlicedError::Rewritten { file: self.file.to_owned(), line: self.line });
            }
            self.relabel(comment)?;
            if !comment.is_empty() && keeps_comment(comment) {
                self.pending.push(Pending {
                    item: Some(Item::Keep(whole)),
                    suspect: None,
                    comment: true,
                    state: false,
                });
            }
            return Ok(());
        }
        let source = |source| SlicedError::Replay { file: self.file.to_owned(), line: self.line, source };
        let step = self.controller.step(parsed).map_err(source)?;
        if self.pending.last().is_none_or(|p| p.comment) && self.layers.is_empty() {
            // Marks the end of the file's head even where the line itself leaves nothing behind.
            self.pending.push(Pending { item: None, suspect: None, comment: false, state: false });
        }
        match step {
            Step::Nothing | Step::ExtruderSet(_) => {}
            Step::Move(m) => self.take_move(&m, parsed, start, text.len())?,
            Step::Effect(Effect::Dwell(seconds)) => self.waits_s[1] += seconds.max(0.0),
            Step::Effect(Effect::Retract(pull)) => self.push(Item::FirmwareRetract(pull)),
            Step::Effect(effect) => {
                if effect == Effect::Label {
                    self.relabel(&text[parsed.code.clone()])?;
                }
                self.temperature(effect);
                self.by_policy(effect, parsed, whole);
            }
        }
        Ok(())
    }

    fn by_policy(&mut self, effect: Effect, parsed: &ParsedLine, whole: Range<usize>) {
        use CommandPolicy::{Drop, Keep, Refuse, Replace};
        let name = command_name(parsed);
        let allowed = self.allow.iter().any(|a| a.eq_ignore_ascii_case(&name));
        let policies = [Stage::Outside, Stage::Within].map(|stage| policy(effect, stage, allowed));
        if policies[0] == Replace && self.pending.iter().all(|p| p.suspect.is_none()) && !self.replaced.contains(&name)
        {
            self.replaced.push(name);
        }
        let keep = || Some(Item::Keep(whole.clone()));
        let pending = match policies {
            // Refused wherever it stands: as if extrusion had come before and after.
            [Refuse, _] => Pending { item: None, suspect: Some((self.line, whole)), comment: false, state: true },
            [Keep, Refuse] => Pending { item: keep(), suspect: Some((self.line, whole)), comment: false, state: false },
            [_, Refuse] => Pending { item: None, suspect: Some((self.line, whole)), comment: false, state: false },
            [Keep, _] => Pending { item: keep(), suspect: None, comment: false, state: true },
            [Drop | Replace, Keep] => Pending { item: keep(), suspect: None, comment: false, state: false },
            [Drop | Replace, Drop | Replace] => return,
        };
        self.pending.push(pending);
    }

    fn push(&mut self, item: Item) {
        self.pending.push(Pending { item: Some(item), suspect: None, comment: false, state: false });
    }

    fn temperature(&mut self, effect: Effect) {
        let Effect::Heat { heater, target_c: Some(target), .. } = effect else { return };
        let slot = match heater {
            Heater::Nozzle => 0,
            Heater::Bed => 1,
            // Another tool's heat is none of ours.
            Heater::OtherNozzle(_) | Heater::Chamber => return,
        };
        if target > 0.0 {
            self.heat[slot] = Some(target);
        }
    }

    fn take_move(&mut self, m: &Move, parsed: &ParsedLine, start: usize, length: usize) -> Result<(), SlicedError> {
        let pushes = m.e > 0.0 && (m.written != 0 || m.arc.is_some());
        let comment = match parsed.comment.is_empty() {
            true => 0..0,
            false => start + parsed.comment.start - 1..start + length,
        };
        let Some((from, to)) = m.from.tip().zip(m.to.tip()) else {
            if pushes {
                // What made the position unknown is the better thing to name.
                if let (false, Some((number, span))) =
                    (self.layers.is_empty(), self.pending.iter().find_map(|p| p.suspect.clone()))
                {
                    return Err(self.refused(number, span));
                }
                return Err(SlicedError::UnknownPosition { file: self.file.to_owned(), line: self.line });
            }
            // The way to the first known place is ours; filament moved on it still counts.
            if m.e != 0.0 {
                let nowhere = Vec3::zeros();
                self.push(Item::Step(Step3 {
                    from: nowhere,
                    to: nowhere,
                    e: m.e,
                    feed: m.feed,
                    arc: None,
                    comment,
                    line: self.line,
                }));
            }
            return Ok(());
        };
        let step = Step3 { from, to, e: m.e, feed: m.feed, arc: m.arc, comment, line: self.line };
        if !step.prints() {
            self.push(Item::Step(step));
            return Ok(());
        }
        self.extrusion.add(from);
        self.extrusion.add(to);
        if let Some(arc) = &step.arc {
            flatten(from, to, arc, 0.01).into_iter().for_each(|p| self.extrusion.add(p));
        }
        self.filament_mm += step.e;
        self.laying += 1;
        let waited = std::mem::take(&mut self.waits_s[1]);
        if !self.layers.is_empty() {
            self.waits_s[0] += waited;
        }
        self.begin_layer_if_new(from.z)?;
        if let Some(layer) = self.layers.last_mut() {
            layer.body.push(Item::Step(step));
        }
        Ok(())
    }

    /// Files the pending lines away, now that extrusion at height `z` follows them.
    fn begin_layer_if_new(&mut self, z: f64) -> Result<(), SlicedError> {
        let first = self.layers.is_empty();
        let pending = std::mem::take(&mut self.pending);
        if first {
            self.heat_at_first = self.heat;
            let mut lead = Vec::new();
            // The file's own head: comments before anything is commanded. Later ones belong to the first layer.
            let head = pending.iter().take_while(|p| p.comment).count();
            for (index, line) in pending.into_iter().enumerate() {
                if let (Some((number, span)), true) = (&line.suspect, line.state) {
                    return Err(self.refused(*number, span.clone()));
                }
                match line.item {
                    Some(Item::Keep(span)) if index < head => self.prologue.push(span),
                    Some(item @ Item::Keep(_)) if line.state || line.comment => lead.push(item),
                    Some(Item::Keep(_)) | None => {}
                    Some(item) => lead.push(item),
                }
            }
            self.layers.push(Layer { z, lead, body: Vec::new() });
            return Ok(());
        }
        if let Some((number, span)) = pending.iter().find_map(|p| p.suspect.clone()) {
            return Err(self.refused(number, span));
        }
        let items = pending.into_iter().filter_map(|p| p.item);
        let new = self.layers.last().is_some_and(|layer| (layer.z - z).abs() > SAME_LAYER);
        if new {
            self.layers.push(Layer { z, lead: items.collect(), body: Vec::new() });
        } else if let Some(layer) = self.layers.last_mut() {
            layer.body.extend(items);
        }
        Ok(())
    }

    fn refused(&self, line: u32, span: Range<usize>) -> SlicedError {
        let text = String::from_utf8_lossy(&self.bytes[span]).trim().chars().take(60).collect();
        SlicedError::Command { file: self.file.to_owned(), line, text }
    }

    /// A label that names one of our prints closes the print before it.
    fn relabel(&mut self, comment: &[u8]) -> Result<(), SlicedError> {
        let Some(print) = label(comment) else { return Ok(()) };
        if self.label == Some(print) {
            return Ok(());
        }
        if self.seen.contains(&print) {
            let label = String::from_utf8_lossy(comment).trim().to_owned();
            return Err(SlicedError::Interleaved { file: self.file.to_owned(), line: self.line, label });
        }
        if self.label.is_some() && !self.layers.is_empty() {
            let lead: Vec<Pending> = std::mem::take(&mut self.pending);
            self.close();
            // Fans and limits set on the way to the next object belong to it; its travel does not.
            self.pending = lead.into_iter().filter(|p| p.state || p.suspect.is_some()).collect();
        }
        self.seen.push(print);
        self.label = Some(print);
        Ok(())
    }

    fn close(&mut self) {
        let epilogue = self.pending.drain(..).filter(|p| p.comment);
        let epilogue = epilogue.filter_map(|p| if let Some(Item::Keep(span)) = p.item { Some(span) } else { None });
        let sliced = SlicedPrint {
            layers: std::mem::take(&mut self.layers),
            extrusion: std::mem::replace(&mut self.extrusion, Bounds::EMPTY),
            filament_mm: std::mem::take(&mut self.filament_mm),
            firmware: self.firmware,
            replaced: std::mem::take(&mut self.replaced),
            multiplier: 1.0,
            bead: self.bead,
            widths_mm: self.widths_mm.clone(),
            outset_mm: None,
            waits_s: std::mem::take(&mut self.waits_s)[0],
            nozzle_c: self.heat_at_first[0],
            bed_c: self.heat_at_first[1],
            prologue: std::mem::take(&mut self.prologue),
            epilogue: epilogue.collect(),
        };
        self.done.push(Segment { print: self.label, sliced });
    }

    fn finish(mut self) -> Result<Vec<Segment>, SlicedError> {
        if self.layers.is_empty() {
            return Err(SlicedError::NoExtrusion { file: self.file.to_owned() });
        }
        if let Some((number, span)) = self.pending.iter().filter(|p| p.state).find_map(|p| p.suspect.clone()) {
            return Err(self.refused(number, span));
        }
        self.close();
        let counted_mm: f64 = self.done.iter().map(|segment| segment.sliced.filament_mm).sum();
        match stated_filament(self.bytes) {
            Some(stated_mm) if (stated_mm - counted_mm).abs() > STATED_MM + DIGIT_MM * self.laying as f64 => {
                Err(SlicedError::Filament { file: self.file.to_owned(), counted_mm, stated_mm })
            }
            None if states_its_filament(self.bytes) => Err(SlicedError::Torn { file: self.file.to_owned() }),
            _ => Ok(self.done),
        }
    }
}

/// Whether the file's head is that of a slicer that closes each file with the filament it takes.
fn states_its_filament(bytes: &[u8]) -> bool {
    const SLICERS: [&[u8]; 3] =
        [b"; generated by PrusaSlicer", b"; generated by Slic3r", b"; generated by trunnion built-in"];
    let head = &bytes[..bytes.len().min(FLAVOR_WITHIN)];
    SLICERS.iter().any(|name| memchr::memmem::find(head, name).is_some())
}

/// What a slicer's own sum may be off, mm: its last digit (Slic3r writes one).
const STATED_MM: f64 = 0.06;
/// And what the last digit of each move may add to that, mm.
const DIGIT_MM: f64 = 5e-6;

/// `; filament used [mm] = 1266.93` (PrusaSlicer), `; filament used = 1330.3mm (..)` (Slic3r); `None` without it, and where there are
/// several extruders.
fn stated_filament(bytes: &[u8]) -> Option<f64> {
    let key = b"\n; filament used";
    let at = memchr::memmem::rfind(bytes, b"\n; filament used [mm] =").or_else(|| memchr::memmem::rfind(bytes, key))?;
    let rest = &bytes[at + 1..];
    let line = String::from_utf8_lossy(&rest[..memchr::memchr(b'\n', rest).unwrap_or(rest.len())]).into_owned();
    let value = line.split_once('=')?.1.split('(').next()?.trim().trim_end_matches("mm");
    value.parse().ok().filter(|mm| *mm > 0.0)
}

/// The command that a line begins with, by its name: `M42`, `SET_PIN`.
fn command_name(parsed: &ParsedLine) -> String {
    match parsed.commands.first() {
        Some(command) => command.to_string(),
        None => String::from_utf8_lossy(&parsed.text).split([' ', '=']).next().unwrap_or_default().to_owned(),
    }
}

/// The name under which print `index` is handed to slicers.
pub fn print_name(index: usize, part: &str) -> String {
    let safe: String = part.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    format!("print-{index:02}-{safe}")
}

/// The print that an object label names: `; printing object print-03-arm id:0 copy 0`, `M486 Aprint-03-arm`.
fn label(comment: &[u8]) -> Option<usize> {
    let text = std::str::from_utf8(comment).ok()?.trim();
    let rest = text
        .strip_prefix("printing object ")
        .or_else(|| text.strip_prefix("M486 A"))
        .or_else(|| text.strip_prefix("MESH:"))?;
    let name = rest.rsplit(['/', '\\']).next()?;
    let digits = name.strip_prefix("print-")?;
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> SlicedPrint {
        let mut all = read_sliced(text.as_bytes(), "t.gcode", InputWords::default()).unwrap();
        assert_eq!(all.len(), 1);
        all.remove(0).sliced
    }

    fn refused(text: &str) -> String {
        read_sliced(text.as_bytes(), "t.gcode", InputWords::default()).unwrap_err().to_string()
    }

    const TWO_LAYERS: &str = "; generated by hand\nM109 S215\nM140 S65\nG28\nG90\nM83\n;TYPE:Perimeter\nG1 X0 Y0 Z.2 F3000\nG1 X10 E1 F1200\nG1 Y10 E1\nG1 E-2\nG1 Z.4\nM106 S255\nG1 X0 Y0\nG1 E2\nG1 X10 E1\nM107\nM84\n; the end\n";

    #[test]
    fn layers_begin_behind_the_last_extrusion() {
        let print = one(TWO_LAYERS);
        assert_eq!(print.layers.len(), 2);
        assert_eq!((print.layers[0].z, print.layers[1].z), (0.2, 0.4));
        assert_eq!(print.layers[1].lead.len(), 5);
        assert_eq!(print.layers[1].body.len(), 1);
        assert_eq!(print.filament_mm, 3.0);
        assert_eq!((print.nozzle_c, print.bed_c), (Some(215.0), Some(65.0)));
        assert_eq!((print.extrusion.min, print.extrusion.max), (Vec3::new(0.0, 0.0, 0.2), Vec3::new(10.0, 10.0, 0.4)));
        assert_eq!((print.prologue.len(), print.epilogue.len(), print.layers[0].lead.len()), (1, 1, 1));
    }

    #[test]
    fn waits_are_counted_between_the_first_and_the_last_extrusion() {
        let waiting = TWO_LAYERS.replace("G28", "G28\nG4 S9").replace("M106", "G4 P1500\nG4 S2\nM106");
        assert_eq!(one(&waiting.replace("M107", "G4 S20\nM107")).waits_s, 3.5);
        assert_eq!(one(TWO_LAYERS).waits_s, 0.0);
    }

    #[test]
    fn what_cannot_be_rewritten_is_named_with_its_line() {
        let body = |line: &str| format!("G90\nM83\nG1 X0 Y0 Z.2\nG1 X9 E1\n{line}\nG1 X0 E1\n");
        assert!(refused(&body("G28")).contains("t.gcode:5: \"G28\" cannot be rewritten safely"));
        assert!(refused(&body("M600")).contains("t.gcode:5"));
        assert!(refused(&body("PAUSE")).contains("PAUSE"));
        for line in
            ["M206 Z5", "M428", "M290 Z-2", "M92 E90", "M221 S95", "T1", "M84", "M112", "G10 P0 Z5", "M104 S0\nM81"]
        {
            assert!(refused(&body(line)).contains("t.gcode:"), "{line}");
        }
        assert!(refused(&body("G20")).contains("inches"));
        assert!(refused(&body("G18")).contains("XY plane"));
        assert!(refused(&body("G1 X5 A3")).contains("A word"));
        assert!(refused("GCDE\x01\x00").contains("binary"));
        assert!(refused("G28\nM84\n").contains("nothing is extruded"));
        assert!(refused("M83\nG1 X5 E1\n").contains("before X, Y and Z are known"));
        assert!(refused(";TRUNNION slot=0\n").contains("already rewritten"));
        assert!(refused(&format!("M6 T1\n{TWO_LAYERS}")).contains("M6"));
    }

    #[test]
    fn sequential_objects_come_apart_by_their_labels() {
        let object = |n: usize| {
            format!(
                "; printing object print-{n:02}-x id:0 copy 0\nG1 X0 Y0 Z.2\nG1 X9 E1\n; stop printing object print-{n:02}-x id:0 copy 0\n"
            )
        };
        let text = format!("G90\nM83\n{}M107\nG1 X50\n{}", object(0), object(3));
        let all = read_sliced(text.as_bytes(), "t", InputWords::default()).unwrap();
        assert_eq!(all.iter().map(|s| s.print).collect::<Vec<_>>(), vec![Some(0), Some(3)]);
        assert_eq!(all[1].sliced.extrusion.max.x, 9.0);
        let mixed = format!("G90\nM83\n{}{}{}", object(0), object(3), object(0));
        assert!(refused(&mixed).contains("complete individual objects"));
    }
}
