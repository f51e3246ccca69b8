//! Sliced G-code, read once: everything in it is checked, and where each layer begins and ends is noted.

use std::ops::Range;

use super::filament::{Filament, Stated};
use super::items::{Place, Step3, allows, command_name, comment_at, policies, refused};
use super::joint::Said;
use super::policy::{self, CommandPolicy, keeps_comment, takes_a_picture};
use super::sliced::{InputWords, LabelledPrint, Layer, SlicedPrint};
use super::source::{SlicedError, SlicedSource};
use super::stated;
use crate::gcode::checksum;
use crate::gcode::marks::{Bead, Hint, Role, hint};
use crate::gcode::meaning::{Effect, Firmware, Heater};
use crate::gcode::settings::{Setting, Settings};
use crate::gcode::{LineKind, ParsedLine, first_line, text_start};
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::{CHORD_MM, Controller, Move, PlainStep, Reading, Step, flatten};

/// Extrusions whose heights differ by less than this are one layer, mm: the last printed digit.
const SAME_LAYER: f64 = 1.5e-3;

/// Reads `bytes` as one or several prints; `file` is for the messages.
///
/// What comes back borrows the bytes and takes some hundred bytes a layer beside them.
///
/// # Errors
///
/// [`SlicedError`] with file and line for everything that cannot be rewritten safely.
pub fn read_sliced<'a>(
    bytes: &'a [u8],
    file: &'a str,
    words: InputWords<'a>,
) -> Result<Vec<LabelledPrint<'a>>, SlicedError> {
    if bytes.starts_with(b"GCDE") {
        return Err(SlicedError::Binary { file: file.to_owned() });
    }
    // RS274 machines print no slicer's own words: what is not stated is a printer's.
    let unstated = if words.firmware.is_printer() { words.firmware } else { Firmware::Marlin };
    let firmware = stated::firmware(bytes).unwrap_or(unstated);
    let source = SlicedSource { file, bytes, firmware, allow: words.allow, supports: words.supports };
    let mut reader = Reader::new(source);
    let read = reader.read();
    // PrusaSlicer before 2.6 had no flavour for Klipper, whose users chose Marlin's and wrote macros.
    if reader.klipper || (read.is_err() && firmware == Firmware::Marlin && stated::has_klipper_macros(bytes)) {
        let mut reader = Reader::new(SlicedSource { firmware: Firmware::Klipper, ..source });
        reader.read()?;
        return reader.finish();
    }
    read?;
    reader.finish()
}

struct Reader<'a> {
    source: SlicedSource<'a>,
    /// Whether this has ended at a macro of Klipper's in a file that is taken to be Marlin's.
    klipper: bool,
    /// Behind the line in hand.
    place: Place,
    bead: Bead,
    widths_mm: Vec<f64>,
    settings: Settings,
    done: Vec<LabelledPrint<'a>>,
    label: Option<usize>,
    print: Open,
    /// Lines since the last extrusion that are no moves, with what is to be thought of them if no extrusion follows.
    pending: Vec<Pending>,
    /// Where the moves since then go.
    pending_reach: Bounds,
    /// Whether there is anything since then.
    since: bool,
    /// Where the last extrusion ended.
    laid_to: Option<Vec3>,
    /// Moves that lay filament.
    laying: usize,
    filament: Filament,
    /// Those of them that rise.
    rising: usize,
    /// Nozzle and bed as last set.
    heat: [Option<f64>; 2],
    /// What the slicer says that it lays.
    role: Role,
    /// And how wide, mm.
    width_mm: Option<f64>,
    /// And how high, mm.
    height_mm: Option<f64>,
    /// Where it last said the role, width and height of lines: it does not say them again for the next object.
    said: [Option<Range<usize>>; 3],
    /// Up to here it is the slicer's start code.
    start_code: usize,
    /// Whether the lines read last are a picture's.
    in_picture: bool,
}

/// The print that is being read.
struct Open {
    layers: Vec<Layer>,
    /// Where the first layer's body begins; set with the first layer.
    start: Option<Place>,
    lead: Vec<Range<usize>>,
    prologue: Vec<Range<usize>>,
    replaced: Vec<String>,
    reach: Bounds,
    filament_mm: f64,
    first_layer: Vec<(Option<f64>, f64)>,
    second_layer: Vec<(Option<f64>, f64)>,
    /// Nozzle and bed when it began.
    heat: [Option<f64>; 2],
    /// The first line of a skirt or brim.
    adhesion: Option<u32>,
    /// Whether objects are named to the firmware.
    labelled: bool,
    pictures: bool,
}

impl Open {
    fn new() -> Self {
        Self {
            layers: Vec::new(),
            start: None,
            lead: Vec::new(),
            prologue: Vec::new(),
            replaced: Vec::new(),
            reach: Bounds::EMPTY,
            filament_mm: 0.0,
            first_layer: Vec::new(),
            second_layer: Vec::new(),
            heat: [None; 2],
            adhesion: None,
            labelled: false,
            pictures: false,
        }
    }
}

/// A line whose fate depends on whether extrusion follows.
struct Pending {
    span: Range<usize>,
    line: u32,
    /// Passed on if it does.
    kept: bool,
    /// Refused if extrusion comes before *and* after.
    suspect: bool,
    comment: bool,
    /// Kept, or refused, even when the pose changes around it (fans, limits).
    state: bool,
}

/// The line in hand: where it begins, and the state before it, which is asked for only where no layer has begun.
struct Here<'a> {
    start: usize,
    text: &'a [u8],
    before: Option<Controller>,
}

impl<'a> Reader<'a> {
    fn new(source: SlicedSource<'a>) -> Self {
        let (bytes, controller) = (source.bytes, Controller::new(Reading::sliced_for(source.firmware)));
        Self {
            source,
            klipper: false,
            place: Place { at: text_start(bytes), line: 0, controller },
            bead: stated::bead(bytes),
            widths_mm: stated::widths(bytes),
            settings: Settings::of(bytes),
            done: Vec::new(),
            label: None,
            print: Open::new(),
            pending: Vec::new(),
            pending_reach: Bounds::EMPTY,
            since: false,
            laid_to: None,
            laying: 0,
            filament: Filament::default(),
            rising: 0,
            heat: [None; 2],
            role: Role::Unknown,
            width_mm: None,
            height_mm: None,
            said: [None, None, None],
            start_code: stated::start_code(bytes),
            in_picture: false,
        }
    }

    fn file(&self) -> String {
        self.source.file.to_owned()
    }

    fn read(&mut self) -> Result<(), SlicedError> {
        let bytes = self.source.bytes;
        let mut parsed = ParsedLine::default();
        while self.place.at < bytes.len() {
            let start = self.place.at;
            if !self.print.layers.is_empty()
                && let Some(step) = self.place.plain(bytes)
            {
                if let PlainStep::Move(m) = step {
                    let prints = m.e > 0.0 && m.from != m.to;
                    if prints {
                        self.lay(m.from, m.to, m.e, start)?;
                    } else {
                        self.filament.move_alone(m.e);
                        self.travel(m.to);
                    }
                }
                continue;
            }
            let (text, length) = first_line(&bytes[start..]);
            self.place.at += length;
            self.place.line += 1;
            let (file, line) = (self.source.file, self.place.line);
            parsed.read(text).map_err(|source| SlicedError::Parse { file: file.to_owned(), line, source })?;
            if self.source.firmware == Firmware::Marlin && stated::is_klipper_macro(&parsed, text) {
                self.klipper = true;
                return Ok(());
            }
            self.take(&parsed, start, text)?;
        }
        Ok(())
    }

    fn take(&mut self, parsed: &ParsedLine, start: usize, text: &'a [u8]) -> Result<(), SlicedError> {
        let whole = start..start + text.len();
        if parsed.kind == LineKind::Empty {
            let comment = &text[parsed.comment.clone()];
            if comment.starts_with(b"TRUNNION ") {
                return Err(SlicedError::Rewritten { file: self.file(), line: self.place.line });
            }
            self.relabel(comment)?;
            self.named(comment, &whole)?;
            let picture = policy::picture(comment);
            self.in_picture = picture.unwrap_or(self.in_picture);
            if !comment.is_empty() && picture.is_none() && !self.in_picture && keeps_comment(comment) {
                self.pend(whole, Pending { kept: true, comment: true, ..Pending::NOTHING });
            }
            return Ok(());
        }
        // One that was cut short ends here.
        self.in_picture = false;
        let before = self.print.layers.is_empty().then(|| self.place.controller.clone());
        let (file, line) = (self.source.file, self.place.line);
        let source = |source| SlicedError::Replay { file: file.to_owned(), line, source };
        if takes_a_picture(parsed) && !allows(parsed, self.source.allow) {
            self.print.pictures = true;
            return Ok(());
        }
        if let Some(letter) = twice(parsed) {
            return Err(SlicedError::Twice { file: self.file(), line, letter });
        }
        let step = self.place.controller.step(parsed).map_err(source)?;
        if self.pending.last().is_none_or(|p| p.comment) && self.print.layers.is_empty() {
            // Marks the end of the file's head even where the line itself leaves nothing behind.
            self.pend(0..0, Pending::NOTHING);
        }
        match step {
            Step::Nothing | Step::ExtruderSet(_) | Step::Effect(Effect::Retract(_)) => {}
            Step::Move(m) => self.take_move(&m, parsed, &Here { start, text, before })?,
            Step::Effect(effect) => {
                if effect == Effect::Label {
                    self.print.labelled = true;
                    self.relabel(&text[parsed.code.clone()])?;
                }
                self.temperature(effect);
                self.by_policy(effect, parsed, whole);
            }
        }
        Ok(())
    }

    fn pend(&mut self, span: Range<usize>, pending: Pending) {
        self.pending.push(Pending { span, line: self.place.line, ..pending });
        self.since = true;
    }

    /// Files a line away by what it does.
    fn by_policy(&mut self, effect: Effect, parsed: &ParsedLine, whole: Range<usize>) {
        use CommandPolicy::{Drop, Keep, Pause, Refuse, Replace};
        let policies = policies(effect, parsed, self.source.allow);
        // What waits for a person between extrusions is made there.
        let left_out = policies[0] == Replace && (policies[1] != Pause || self.print.layers.is_empty());
        if left_out && self.pending.iter().all(|p| !p.suspect) {
            self.replaced(&command_name(parsed));
        }
        let none = Pending::NOTHING;
        let pending = match policies {
            // Refused wherever it stands: as if extrusion had come before and after.
            [Refuse, _] => Pending { suspect: true, state: true, ..none },
            [Keep, Refuse] => Pending { kept: true, suspect: true, ..none },
            [_, Refuse] => Pending { suspect: true, ..none },
            [Keep, _] => Pending { kept: true, state: true, ..none },
            [Drop | Replace, Keep] => Pending { kept: true, ..none },
            // Made where it stands between extrusions; at either end it is the start or end code's.
            [_, Pause] | [Pause, _] => return,
            [Drop | Replace, Drop | Replace] => return,
        };
        self.pend(whole, pending);
    }

    /// Notes something of the start or end code that is left out and might be missed.
    fn replaced(&mut self, name: &str) {
        if !self.print.replaced.iter().any(|known| known == name) {
            self.print.replaced.push(name.to_owned());
        }
    }

    /// Takes note of what the slicer says that it lays from here on.
    fn named(&mut self, comment: &[u8], whole: &Range<usize>) -> Result<(), SlicedError> {
        let role = match hint(comment) {
            Some(Hint::Role(role)) => role,
            Some(Hint::Width(mm)) => {
                self.width_mm = Some(mm);
                return self.say(1, whole);
            }
            Some(Hint::Height(mm)) => {
                self.height_mm = Some(mm);
                return self.say(2, whole);
            }
            Some(Hint::Layer) | None => return Ok(()),
        };
        self.say(0, whole)?;
        self.role = role;
        let name = String::from_utf8_lossy(comment).to_ascii_lowercase();
        let what = match role {
            Role::Support if !self.source.supports => "supports or a raft",
            Role::Adhesion if name.contains("tower") => "a wipe or prime tower",
            Role::Adhesion if name.contains("raft") => "a raft",
            _ => return Ok(()),
        };
        Err(SlicedError::Extra { file: self.file(), line: self.place.line, what })
    }

    fn say(&mut self, which: usize, whole: &Range<usize>) -> Result<(), SlicedError> {
        self.said[which] = Some(whole.clone());
        Ok(())
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

    fn take_move(&mut self, m: &Move, parsed: &ParsedLine, here: &Here<'_>) -> Result<(), SlicedError> {
        let pushes = m.e > 0.0 && (m.written != 0 || m.arc.is_some());
        if pushes && here.start >= self.start_code && m.from.tip().zip(m.to.tip()).is_none() {
            // What made the position unknown is the better thing to name.
            if let (false, Some(p)) = (self.print.layers.is_empty(), self.pending.iter().find(|p| p.suspect)) {
                return Err(refused(&self.source, p.line, p.span.clone()));
            }
            return Err(SlicedError::UnknownPosition { file: self.file(), line: self.place.line });
        }
        if here.start < self.start_code {
            // The profile's own start code takes its place, prime line and all.
            if pushes {
                self.replaced("a prime line");
            }
            return Ok(());
        }
        let comment = comment_at(parsed, here.start, here.text.len());
        let Some(step) = Step3::of(m, comment) else { return Ok(()) };
        if !step.prints() {
            self.filament.move_alone(m.e);
            self.travel(step.to);
            return Ok(());
        }
        if let Some(controller) = &here.before {
            let place = Place { at: here.start, line: self.place.line - 1, controller: controller.clone() };
            self.begin_print(place)?;
        }
        self.lay(step.from, step.to, step.e, here.start)?;
        // An arc may leave the box of its ends.
        if let (Some(arc), Some(layer), false) = (&step.arc, self.print.layers.last_mut(), self.role == Role::Adhesion)
        {
            flatten(step.from, step.to, arc, CHORD_MM).into_iter().for_each(|p| layer.extrusion.add(p));
        }
        Ok(())
    }

    /// Notes a move to `to` that lays nothing.
    #[inline]
    fn travel(&mut self, to: Vec3) {
        self.pending_reach.add(to);
        self.since = true;
    }

    /// Notes extrusion by the line that begins at `start`.
    #[inline]
    fn lay(&mut self, from: Vec3, to: Vec3, e: f64, start: usize) -> Result<(), SlicedError> {
        self.laying += 1;
        self.rising += usize::from(to.z > from.z);
        if self.since {
            self.pending_within()?;
        }
        let print = &mut self.print;
        print.filament_mm += e;
        if print.layers.last().is_none_or(|layer| (layer.z - from.z).abs() > SAME_LAYER) {
            let (body, line) = (start, self.place.line);
            print.layers.push(Layer { z: from.z, body, end: start, line, extrusion: Bounds::EMPTY });
        }
        if print.layers.len() <= 2 {
            let said = Said { width_mm: self.width_mm, height_mm: self.height_mm, role: self.role };
            let lines = match &print.layers[..] {
                [_] => Some(&mut print.first_layer),
                [first, second] if said.fills(second.z - first.z) => Some(&mut print.second_layer),
                _ => None,
            };
            if let Some(lines) = lines {
                match lines.last_mut() {
                    Some((width, filament)) if *width == self.width_mm => *filament += e,
                    _ => lines.push((self.width_mm, e)),
                }
            }
        }
        if self.role == Role::Adhesion {
            print.adhesion = print.adhesion.or(Some(self.place.line));
            print.reach.add(from);
            print.reach.add(to);
            if print.layers.len() > 1 {
                let what = "a skirt or brim of more than one layer, or a draft shield";
                return Err(SlicedError::Extra { file: self.source.file.to_owned(), line: self.place.line, what });
            }
        }
        if let Some(layer) = print.layers.last_mut() {
            layer.end = self.place.at;
            if self.role == Role::Adhesion {
                self.laid_to = None;
                return Ok(());
            }
            // Most extrusions go on where the last one ended.
            if self.laid_to != Some(from) || layer.extrusion.is_empty() {
                layer.extrusion.add(from);
            }
            layer.extrusion.add(to);
            self.laid_to = Some(to);
        }
        Ok(())
    }

    /// Takes the pending lines for part of the print, now that extrusion follows them.
    #[inline]
    fn pending_within(&mut self) -> Result<(), SlicedError> {
        self.since = false;
        if let Some(p) = self.pending.iter().find(|p| p.suspect) {
            return Err(refused(&self.source, p.line, p.span.clone()));
        }
        self.pending.clear();
        self.print.reach = self.print.reach.union(&self.pending_reach);
        self.pending_reach = Bounds::EMPTY;
        Ok(())
    }

    /// Files the lines before the first extrusion away, which begins at `place`.
    fn begin_print(&mut self, place: Place) -> Result<(), SlicedError> {
        self.print.heat = self.heat;
        self.print.start = Some(place);
        // The way to the first layer comes from the slicer's origin and is replaced by a move of ours.
        self.pending_reach = Bounds::EMPTY;
        // The file's own head: comments before anything is commanded. Later ones belong to the first layer.
        let head = self.pending.iter().take_while(|p| p.comment).count();
        for (index, line) in std::mem::take(&mut self.pending).into_iter().enumerate() {
            if line.suspect && line.state {
                return Err(refused(&self.source, line.line, line.span));
            }
            if line.kept && index < head {
                self.print.prologue.push(line.span);
            } else if line.kept && (line.state || line.comment) {
                self.print.lead.push(line.span);
            }
        }
        if !self.done.is_empty() {
            let lead = &mut self.print.lead;
            let known: Vec<_> = self.said.iter().flatten().filter(|span| !lead.contains(span)).cloned().collect();
            lead.splice(0..0, known);
        }
        Ok(())
    }

    /// A label that names one of our prints closes the print before it. PrusaSlicer lists all labels in the head, from 2.6 on, with nothing
    /// between a beginning and an end.
    fn relabel(&mut self, comment: &[u8]) -> Result<(), SlicedError> {
        if self.print.layers.is_empty() && stated::ends_label(comment) {
            self.label = None;
        }
        let Some(print) = stated::label(comment) else { return Ok(()) };
        if self.label == Some(print) {
            return Ok(());
        }
        if self.done.iter().any(|segment| segment.print == Some(print)) {
            let label = String::from_utf8_lossy(comment).trim().to_owned();
            return Err(SlicedError::Interleaved { file: self.file(), line: self.place.line, label });
        }
        if self.label.is_some() && !self.print.layers.is_empty() {
            let lead: Vec<Pending> = std::mem::take(&mut self.pending);
            self.close();
            // Fans and limits set on the way to the next object belong to it; its travel does not.
            self.pending = lead.into_iter().filter(|p| p.state || p.suspect).collect();
        }
        self.label = Some(print);
        Ok(())
    }

    fn close(&mut self) {
        let print = std::mem::replace(&mut self.print, Open::new());
        let Some(start) = print.start else { return };
        let boxes = print.layers.iter().map(|layer| &layer.extrusion);
        let extrusion = boxes.fold(Bounds::EMPTY, |all, layer| all.union(layer));
        let epilogue = self.pending.drain(..).filter(|p| p.comment && p.kept);
        let settings = &self.settings;
        // Heat that no line sets.
        let celsius = |of: [Setting; 2]| of.into_iter().find_map(|setting| settings.positive(setting));
        let sliced = SlicedPrint {
            extrusion,
            filament_mm: print.filament_mm,
            firmware: self.source.firmware,
            replaced: print.replaced,
            multiplier: settings.number(Setting::Multiplier).unwrap_or(1.0),
            bead: self.bead,
            widths_mm: self.widths_mm.clone(),
            outset_mm: stated::outset_mm(settings),
            heights_mm: settings.heights_mm().filter(|_| !stated::says_each_height(self.source.bytes)),
            adhesion: print.adhesion,
            labelled: print.labelled,
            pictures: print.pictures,
            nozzle_c: print.heat[0].or_else(|| celsius([Setting::FirstNozzleHeat, Setting::NozzleHeat])),
            bed_c: print.heat[1].or_else(|| celsius([Setting::FirstBedHeat, Setting::BedHeat])),
            settings: settings.clone(),
            prologue: print.prologue,
            epilogue: epilogue.map(|p| p.span).collect(),
            turn: None,
            source: self.source,
            lead: print.lead,
            start,
            // Both ends of every extrusion, and every travel between them.
            reach: extrusion.union(&print.reach),
            first_layer: print.first_layer,
            second_layer: print.second_layer,
            layers: print.layers,
        };
        self.pending_reach = Bounds::EMPTY;
        self.done.push(LabelledPrint { print: self.label, sliced });
    }

    fn finish(mut self) -> Result<Vec<LabelledPrint<'a>>, SlicedError> {
        if self.print.layers.is_empty() {
            return Err(SlicedError::NoExtrusion { file: self.file() });
        }
        if let Some(p) = self.pending.iter().find(|p| p.state && p.suspect) {
            return Err(refused(&self.source, p.line, p.span.clone()));
        }
        if 2 * self.rising > self.laying || self.settings.is_on(Setting::Spiral) {
            return Err(SlicedError::Spiral { file: self.file() });
        }
        if self.settings.is_asked(Setting::FuzzySkin) {
            return Err(SlicedError::Fuzzy { file: self.file() });
        }
        if self.settings.is_on(Setting::VolumetricE) || stated::has_volumetric_flavor(self.source.bytes) {
            return Err(SlicedError::Volumetric { file: self.file() });
        }
        self.close();
        if checksum::is_changed(self.source.bytes) {
            return Err(SlicedError::Changed { file: self.file() });
        }
        if let (true, Some(line)) = (self.done.len() > 1, self.done.iter().find_map(|segment| segment.sliced.adhesion))
        {
            let what = "a skirt or the brims of all objects before the first one";
            return Err(SlicedError::Extra { file: self.file(), line, what });
        }
        let laid_mm = self.done.iter().map(|segment| segment.sliced.filament_mm).sum();
        match self.filament.against(self.source.bytes, laid_mm, self.laying) {
            Stated::Right => Ok(self.done),
            Stated::Other(stated_mm) => {
                Err(SlicedError::Filament { file: self.file(), counted_mm: laid_mm, stated_mm })
            }
            Stated::Missing => Err(SlicedError::Torn { file: self.file() }),
        }
    }
}

impl Pending {
    /// A line that leaves nothing behind.
    const NOTHING: Self = Self { span: 0..0, line: 0, kept: false, suspect: false, comment: false, state: false };
}

/// A letter that a move has twice.
fn twice(parsed: &ParsedLine) -> Option<char> {
    let [command] = parsed.commands[..] else { return None };
    if !matches!((command.letter, command.number), (b'G', 0..=3 | 92)) {
        return None;
    }
    let mut seen = 0_u32;
    parsed.words.iter().find_map(|word| {
        let bit = 1 << (word.letter.to_ascii_uppercase().wrapping_sub(b'A') & 31);
        let again = seen & bit != 0;
        seen |= bit;
        again.then_some(char::from(word.letter))
    })
}

#[cfg(test)]
mod tests;
