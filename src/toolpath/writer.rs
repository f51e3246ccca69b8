//! The file for the machine, line by line: header, setups, travels between prints, the prints' own lines shifted.

mod heads;

use std::collections::BTreeSet;
use std::io::Write;
use std::ops::Range;

use super::ahead::{Ahead, Batch, Lead, Other};
use super::clear::Obstacles;
use super::inputs::{Chunk, Entry, RewriteError, RewriteJob};
use super::items::{Item, Step3};
use super::joint::{Flow, Said};
use super::modal::{Modal, is_joints, translated};
use super::output::Output;
use super::sliced::SlicedPrint;
use crate::gcode::marks::{END_MARK, Expect, Hint, WORDS_MARK, hint, print_mark, slot_mark, version_mark};
use crate::gcode::meaning::dwell_line;
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::{CHORD_MM, PlainMoved, flatten};
use crate::motion::{Pose, TableKinematics};
use crate::planning::{HOP_MM, Head, SwivelRoute};
use crate::profile::Commands;
use crate::spelling::counted;

/// How far beside a print the head waits, mm.
const BESIDE_MM: f64 = 5.0;
/// So many bytes are written at once.
const WRITTEN_AT_ONCE: usize = 1 << 18;

pub(super) struct Writer<'a> {
    job: &'a RewriteJob<'a>,
    table: &'a TableKinematics,
    head: &'a Head,
    /// How the head gets from pose to pose, where it is the head that turns.
    route: Option<SwivelRoute<'a>>,
    out: Output<'a>,
    sink: &'a mut (dyn Write + Send),
    /// Bytes that the sink has.
    written: u64,
    pose: Option<Pose>,
    /// Parts of setups that are done.
    printed: Vec<usize>,
    /// Corners of what supports were laid in setups before, table frame.
    supports: Vec<Vec<Vec3>>,
    /// The print that the nozzle is at, not retracted.
    current: Option<usize>,
    /// Whether the tip is at the height proved clear, as it is while the table turns.
    above_all: bool,
    /// What kept lines have set.
    in_force: Modal,
    /// The same for each print alone, by its number.
    of_print: Vec<Modal>,
    warnings: Vec<String>,
    /// What the layer's lines take of the filament that was sliced, how high they are, where and how fast they are laid.
    flow: Flow,
    /// The layer's number in its print.
    layer: usize,
    /// Whether it has the fan and the nozzle of `[joint]`.
    joins: bool,
    /// What each print's slicer has said of its lines last.
    said: Vec<Said>,
    /// Above this the tip clears everything that stands at this pose, mm.
    clear_height: f64,
    /// How often a person is waited for.
    pauses: usize,
    /// How long is waited beside parts, s.
    waits_s: f64,
    /// Commands that the machine's firmware does not have, told once.
    untranslated: BTreeSet<String>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(
        job: &'a RewriteJob<'a>,
        table: &'a TableKinematics,
        head: &'a Head,
        prints: usize,
        sink: &'a mut (dyn Write + Send),
    ) -> Self {
        Self {
            job,
            table,
            head,
            route: SwivelRoute::of(job.profile),
            out: Output::new(job.profile, prints),
            sink,
            written: 0,
            pose: None,
            printed: Vec::new(),
            supports: Vec::new(),
            current: None,
            above_all: false,
            in_force: Modal::default(),
            of_print: vec![Modal::default(); prints],
            warnings: Vec::new(),
            flow: Flow::default(),
            layer: 0,
            joins: false,
            said: vec![Said::default(); prints],
            clear_height: f64::INFINITY,
            pauses: 0,
            waits_s: 0.0,
            untranslated: BTreeSet::new(),
        }
    }

    /// Writes what is left; comes back with how many bytes were written, the highest feed that had to be lowered, and what the
    /// user should know.
    pub(super) fn finish(mut self) -> Result<(u64, Option<f64>, Vec<String>), RewriteError> {
        self.hand_over(0)?;
        if let Some(out) = self.out.beyond {
            return Err(RewriteError::Beyond(out));
        }
        if self.pauses > 0 {
            self.warnings.push(format!(
                "the head waits above the print, with the filament retracted, in {} (M600, M0 or similar)",
                counted(self.pauses, "user pause")
            ));
        }
        if self.waits_s > 0.0 {
            self.warnings.push(format!(
                "{:.0} s of dwells (G4) of the sliced files take place beside the part and above the print, with the filament retracted",
                self.waits_s
            ));
        }
        self.sink.flush().map_err(RewriteError::Write)?;
        Ok((self.written, self.out.lowered, self.warnings))
    }

    /// Gives the sink what there is, if it is more than `most` bytes.
    #[inline]
    fn hand_over(&mut self, most: usize) -> Result<(), RewriteError> {
        if self.out.bytes.len() > most {
            self.sink.write_all(&self.out.bytes).map_err(RewriteError::Write)?;
            self.written += self.out.bytes.len() as u64;
            self.out.bytes.clear();
        }
        Ok(())
    }

    pub(super) fn header(&mut self, entries: &[Entry<'_>]) {
        let profile = self.job.profile;
        let version = env!("CARGO_PKG_VERSION");
        self.out.line(&format!("; generated by trunnion {version} for {} (5-axis)", profile.machine.name));
        let plan = self.job.plan_sha256;
        self.out.line(&version_mark(plan, &profile.machine.name));
        self.out.line(WORDS_MARK);
        self.out.bytes.extend_from_slice(self.job.head.as_bytes());
        for entry in entries {
            let sliced = entry.input.sliced;
            let (filament_mm, multiplier) = (sliced.filament_mm + entry.joint.added_mm, sliced.multiplier);
            let (print, part, bead) = (entry.input.print, entry.print.part, sliced.bead);
            let (widths, outset_mm) = (sliced.widths_mm.clone(), sliced.outset_mm);
            let (heights_mm, diameter_mm) = (sliced.heights_mm, sliced.filament_diameter_mm());
            let expect = Expect::plain(print, part, filament_mm);
            let inside = sliced.settings.inside();
            let expect = Expect { multiplier, bead, widths, outset_mm, heights_mm, diameter_mm, inside, ..expect };
            self.out.line(&expect.to_string());
        }
        if let Some(first) = of_a_part(entries) {
            for span in &first.input.sliced.prologue {
                self.out.keep(without_date(first.input.sliced.text(span)));
            }
        }
        let of = |pick: fn(&SlicedPrint<'_>) -> Option<f64>, default: f64| {
            entries.iter().find_map(|e| pick(e.input.sliced)).unwrap_or(default)
        };
        let nozzle = of(|s| s.nozzle_c, profile.process.nozzle_c);
        let bed = of(|s| s.bed_c, profile.process.bed_c);
        self.in_force = Modal::heated(Some(nozzle), Some(bed));
        for entry in entries {
            let sliced = entry.input.sliced;
            // What `[joint]` changes must have something to come back to.
            let own = sliced.nozzle_c.or(profile.joint.nozzle_c.and(Some(nozzle)));
            self.of_print[entry.input.print] = Modal::heated(own, sliced.bed_c);
        }
        if profile.dialect.commands == Commands::Rs274 {
            self.warnings.push(format!(
                "this file does not control heat: M104, M106 and similar are comments for {}; have the nozzle at {nozzle} C and the bed at {bed} \
                 C before its first line is printed",
                profile.dialect.firmware
            ));
        }
        self.custom_code(&profile.dialect.start, nozzle, bed);
        self.out.begin_counting();
        // A prime line leaves the nozzle full; the first print begins as all do, with the filament pulled back.
        let pull_mm = profile.pulls_after_start_mm();
        if pull_mm > 0.0 {
            self.out.filament(-pull_mm, profile.transition.retract_mm_per_s * 60.0, b"");
        }
        // Up first, wherever homing has left X and Y.
        match &self.route {
            Some(route) => self.out.raise(route.height(0.0, None, Pose::LEVEL), profile.transition.z_mm_per_min),
            None => self.out.go_z(self.safe_height(), profile.transition.z_mm_per_min),
        }
    }

    pub(super) fn footer(&mut self, entries: &[Entry<'_>]) {
        self.retract();
        let level = self.pose.map(|pose| Pose { tilt: Pose::LEVEL.tilt, ..pose });
        match level {
            Some(level) if self.route.is_some() => self.leave(level, None),
            _ => self.out.go_z(self.safe_height(), self.job.profile.transition.z_mm_per_min),
        }
        if let Some(level) = level {
            self.out.turn(self.pose, level);
        }
        self.out.line(END_MARK);
        self.custom_code(&self.job.profile.dialect.end, 0.0, 0.0);
        let laid_mm: f64 = entries.iter().map(|entry| entry.input.sliced.filament_mm + entry.joint.added_mm).sum();
        self.out.line(&format!("; filament used [mm] = {laid_mm:.2}"));
        if let Some(first) = of_a_part(entries) {
            for span in &first.input.sliced.epilogue {
                self.out.keep(first.input.sliced.text(span));
            }
        }
    }

    fn custom_code(&mut self, template: &str, nozzle: f64, bed: f64) {
        let text = template.trim().replace("{nozzle_c}", &nozzle.to_string()).replace("{bed_c}", &bed.to_string());
        text.lines().for_each(|line| self.out.line(line));
    }

    /// Above the sphere that the table and everything printed sweep about the pivot; the axis's end where it is lower.
    fn safe_height(&self) -> f64 {
        let reach =
            self.standing().into_iter().chain(self.job.profile.table_slab()).map(|p| p.norm()).fold(0.0, f64::max);
        let top = self.table.pivot.z + self.table.offset.norm() + reach + self.job.profile.transition.clearance_mm;
        top.min(self.job.profile.limits.z_mm[1])
    }

    /// All prints of one pose, layer by layer.
    pub(super) fn setup(&mut self, group: &[Entry<'_>], chunks: &[Chunk<'_>]) -> Result<(), RewriteError> {
        let pose = group[0].print.pose(self.table);
        self.change_pose(pose, group);
        let printing = parts(group);
        let obstacles = Obstacles::at(pose, &self.printed, &printing, &self.supports, self.job, self.table, self.head);
        self.clear_height = obstacles.over_all;
        let open: Vec<bool> = group.iter().map(|e| obstacles.free_within(e.print.part, &region(e))).collect();
        let place = Place { chunks, obstacles: &obstacles, open: &open };
        let mut ahead = Ahead::new(group, chunks);
        let (mut now, mut then) = (Batch::default(), Batch::default());
        ahead.fill(&mut now)?;
        let mut layer = 0;
        while !now.is_empty() {
            let (filled, written) = rayon::join(|| ahead.fill(&mut then), || self.batch(&now, &mut layer, &place));
            written?;
            filled?;
            std::mem::swap(&mut now, &mut then);
        }
        self.printed.extend(printing);
        self.supports.extend(group.iter().filter(|entry| entry.holds).map(|entry| corners(entry, self.table)));
        Ok(())
    }

    /// Leaves along the tool, turns the table, and waits above.
    fn change_pose(&mut self, pose: Pose, group: &[Entry<'_>]) {
        let transition = &self.job.profile.transition;
        self.retract();
        let moves = self.pose != Some(pose) || self.out.tip().is_none();
        if moves && self.route.is_some() {
            self.leave(pose, Some(group));
            self.above_all = true;
        } else if moves {
            let height = self.safe_height();
            self.out.go_z(height, transition.z_mm_per_min);
            self.above_all = true;
            if let (Some([x, y]), Some(_)) = (transition.park_mm, self.pose) {
                self.out.go(Vec3::new(x, y, height), 0.0, transition.travel_mm_per_min, b"");
            }
        }
        let parts = parts(group);
        let (print, table) = (group[0].print, self.table);
        let words = [(table.tilt.letter, print.tilt_deg), (table.rotation.letter, print.rotation_deg)];
        self.out.line(&slot_mark(group[0].slot, &parts, words));
        self.out.turn(self.pose, pose);
        self.pose = Some(pose);
    }

    /// Corners of all that was printed, table frame.
    fn standing(&self) -> Vec<Vec3> {
        let parts = self.printed.iter().flat_map(|&p| self.job.workpiece.parts[p].vertices().iter().copied());
        parts.chain(self.supports.iter().flatten().copied()).collect()
    }

    /// Where the head's way along the tool ends; a head that turns is held against its axes where it is written.
    fn highest(&self) -> f64 {
        if self.route.is_some() { f64::INFINITY } else { self.job.profile.limits.z_mm[1] }
    }

    fn retract(&mut self) {
        if self.current.take().is_some() {
            let t = &self.job.profile.transition;
            self.out.filament(-t.retract_mm, t.retract_mm_per_s * 60.0, b"");
        }
    }

    /// Goes to where `chunk` begins to extrude, primed.
    fn enter(&mut self, chunk: &Chunk<'_>, lead: &Lead, obstacles: &Obstacles<'_>) {
        let transition = &self.job.profile.transition;
        self.retract();
        let turned = self.above_all && !self.printed.is_empty();
        let sliced = chunk.entry.input.sliced;
        let Some(start) = lead.start else { return };
        let start = start + self.shift(chunk.entry);
        let (print, part) = (chunk.entry.input.print, chunk.entry.print.part);
        if self.above_all && self.route.is_some() {
            self.arrive(start);
        } else {
            let height = self.travel_height(start, obstacles);
            self.out.go_z(height, transition.z_mm_per_min);
            self.out.go(Vec3::new(start.x, start.y, height), 0.0, transition.travel_mm_per_min, b"");
        }
        self.above_all = false;
        self.out.line(&print_mark(print, part));
        let above = self.out.tip();
        // What the lead itself sets need not be set twice.
        let mut wanted = self.of_print[print].clone();
        lead.kept.iter().for_each(|span| wanted.note(sliced.firmware, sliced.text(span)));
        if self.joins {
            wanted = wanted.with_joint(&self.job.profile.joint);
        }
        for line in self.in_force.change_to(&wanted) {
            self.out.keep(line.as_bytes());
            self.in_force.note(self.out.firmware(), line.as_bytes());
        }
        lead.kept.iter().for_each(|span| self.keep(chunk.entry, span));
        if let (false, Some(above)) = (lead.pauses.is_empty(), above) {
            // The head is retracted here, and above the start.
            self.out.go_z(self.pause_height(above.z), transition.z_mm_per_min);
            lead.pauses.iter().for_each(|span| self.out.keep(sliced.text(span)));
            self.pauses += lead.pauses.len();
        }
        self.out.go(start, 0.0, transition.z_mm_per_min, b"");
        let oozed = if turned { transition.prime_mm } else { 0.0 };
        let prime = transition.retract_mm + lead.owed_mm.max(0.0) + oozed;
        self.out.filament(prime, transition.retract_mm_per_s * 60.0, b"");
        self.current = Some(print);
        self.out.lays_for(print);
    }

    /// Where a print's layer in hand lies in the machine.
    fn shift(&self, entry: &Entry<'_>) -> Vec3 {
        entry.mesh.to_machine - Vec3::z() * self.flow.lower_mm
    }

    /// Begins a layer; behind the last that `[joint]` reaches, what the print's own slicer has set comes back. The nozzle is not waited
    /// for: it stands on the part.
    fn begin_layer(&mut self, chunk: &Chunk<'_>, goes_on: bool) {
        let (joint, print) = (&chunk.entry.joint, chunk.entry.input.print);
        let joined = std::mem::replace(&mut self.joins, joint.reaches(chunk.index));
        self.layer = chunk.index;
        self.flow = joint.layer(chunk.index, &self.said[print]);
        if goes_on && joined && !self.joins {
            for line in self.in_force.change_to(&self.of_print[print]) {
                self.out.keep(line.replace("M109", "M104").as_bytes());
                self.in_force.note(self.out.firmware(), line.as_bytes());
            }
        }
    }

    /// A little above both ends if that is free, else above everything that stands at this pose.
    fn travel_height(&self, start: Vec3, obstacles: &Obstacles<'_>) -> f64 {
        let limit = self.highest();
        let Some(tip) = self.out.tip() else { return self.safe_height() };
        if self.above_all {
            // Just turned: straight across and straight down.
            return tip.z.max(start.z);
        }
        let low = (tip.z.max(start.z) + HOP_MM).min(limit);
        let raised = |p: Vec3| Vec3::new(p.x, p.y, low);
        if obstacles.well_free(raised(tip), raised(start)) { low } else { obstacles.over_all.max(low).min(limit) }
    }

    /// Waits for a person: pulls back, goes up along the tool clear of everything that stands, and comes back the same way.
    fn pause(&mut self, entry: &Entry<'_>, span: &Range<usize>) {
        self.pauses += usize::from(self.above(|writer, _, _| writer.out.keep(entry.input.sliced.text(span))));
    }

    /// Waits so that plastic sets: clear of everything that stands and beside what is printed.
    fn wait(&mut self, entry: &Entry<'_>, seconds: f64) {
        let waited = self.above(|writer, tip, height| {
            let travel = writer.job.profile.transition.travel_mm_per_min;
            let beside = writer.beside(entry, tip);
            if let Some([x, y]) = beside {
                writer.out.go(Vec3::new(x, y, height), 0.0, travel, b"");
            }
            writer.out.line(&dwell_line(writer.out.firmware(), seconds));
            if beside.is_some() {
                writer.out.go(Vec3::new(tip.x, tip.y, height), 0.0, travel, b"");
            }
        });
        self.waits_s += if waited { seconds } else { 0.0 };
    }

    /// Pulls back and goes up clear of everything that stands; `there` does something, from where the tip was and how high it is now; and
    /// comes back the same way. `false`, and nothing done, where nobody knows where the tip is.
    fn above(&mut self, there: impl FnOnce(&mut Self, Vec3, f64)) -> bool {
        let Some(tip) = self.out.tip() else { return false };
        let transition = &self.job.profile.transition;
        let (pulled, feed) = (transition.retract_mm, transition.retract_mm_per_s * 60.0);
        let height = self.pause_height(tip.z);
        self.out.filament(-pulled, feed, b"");
        self.out.go_z(height, transition.z_mm_per_min);
        there(self, tip, height);
        self.out.go(tip, 0.0, transition.z_mm_per_min, b"");
        self.out.filament(pulled, feed, b"");
        true
    }

    /// The nearest place beside a print that the axes reach.
    fn beside(&self, entry: &Entry<'_>, tip: Vec3) -> Option<[f64; 2]> {
        let (around, limits) = (region(entry), &self.job.profile.limits);
        let (low, high) = (around.min, around.max);
        let sides = [
            [low.x - BESIDE_MM, tip.y],
            [high.x + BESIDE_MM, tip.y],
            [tip.x, low.y - BESIDE_MM],
            [tip.x, high.y + BESIDE_MM],
        ];
        let reached = |[x, y]: &[f64; 2]| match (&self.table.head, self.pose) {
            (Some(head), Some(pose)) => {
                let tip = Vec3::new(*x, *y, self.pause_height(tip.z));
                self.job.profile.linear_limits().violation(&head.axes(tip, pose)).is_none()
            }
            _ => (limits.x_mm[0]..=limits.x_mm[1]).contains(x) && (limits.y_mm[0]..=limits.y_mm[1]).contains(y),
        };
        let away = |[x, y]: &[f64; 2]| (x - tip.x).abs() + (y - tip.y).abs();
        sides.into_iter().filter(reached).min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// Above all that stands, what is being printed among it; the axis's end where it is lower.
    fn pause_height(&self, tip_z: f64) -> f64 {
        let own = tip_z + self.job.profile.transition.clearance_mm;
        self.clear_height.max(own).min(self.highest())
    }

    /// A line of a print that passes, in the machine's own words.
    fn keep(&mut self, entry: &Entry<'_>, span: &Range<usize>) {
        let line = entry.input.sliced.text(span);
        if line.starts_with(b";") {
            return self.remark(entry, line);
        }
        let firmware = entry.input.sliced.firmware;
        self.of_print[entry.input.print].note(firmware, line);
        if self.joins && is_joints(&self.job.profile.joint, firmware, line) {
            return;
        }
        self.in_force.note(firmware, line);
        match translated(line, firmware, self.out.firmware()) {
            Some(line) => self.out.keep(&line),
            None => {
                let text = String::from_utf8_lossy(line).trim().to_owned();
                let name = text.split_ascii_whitespace().next().unwrap_or_default().to_owned();
                if self.untranslated.insert(name.clone()) {
                    let (from, to) = (firmware.name(), self.out.firmware().name());
                    self.warnings
                        .push(format!("{name} of the sliced file ({from}) has no counterpart on {to} and is omitted"));
                }
            }
        }
    }

    /// A comment of a print, and what it says of the lines that follow it: a height that is not the sliced one is stated as it is.
    fn remark(&mut self, entry: &Entry<'_>, line: &[u8]) {
        if let Some(hint) = hint(&line[1..]) {
            let said = &mut self.said[entry.input.print];
            said.hear(&hint);
            (self.flow.share, self.flow.height_mm) = entry.joint.flow(self.layer, said);
            if let (Some(mm), Hint::Height(_)) = (self.flow.height_mm, hint) {
                return self.out.line(&format!(";HEIGHT:{mm:.3}"));
            }
        }
        self.out.keep(line);
    }

    /// One line of a print, shifted into the machine.
    fn item(&mut self, item: &Item, entry: &Entry<'_>, obstacles: Option<&Obstacles<'_>>) {
        match item {
            Item::Keep(span) => self.keep(entry, span),
            Item::Pause(span) => self.pause(entry, span),
            Item::Wait(seconds) => self.wait(entry, *seconds),
            Item::FirmwareRetract(pull) => self.out.line(if *pull { "G10" } else { "G11" }),
            Item::Step(step) => self.step(step, entry, obstacles),
        }
    }

    /// Writes a batch; `layer` is the one in hand.
    fn batch(&mut self, batch: &Batch, layer: &mut usize, place: &Place<'_>) -> Result<(), RewriteError> {
        let mut done = 0;
        for (before, other) in &batch.others {
            self.moves(&batch.moves[done..*before], &place.chunks[*layer], place)?;
            done = *before;
            match other {
                Other::Layer(index, lead) => {
                    *layer = *index;
                    let chunk = &place.chunks[*index];
                    self.begin_layer(chunk, lead.is_none());
                    if let Some(lead) = lead {
                        self.enter(chunk, lead, place.obstacles);
                    }
                }
                Other::Item(item) => {
                    let chunk = &place.chunks[*layer];
                    self.item(item, chunk.entry, place.obstacles_of(chunk));
                    self.hand_over(WRITTEN_AT_ONCE)?;
                }
            }
        }
        self.moves(&batch.moves[done..], &place.chunks[*layer], place)
    }

    /// Moves of a layer with nothing else between them.
    fn moves(&mut self, moves: &[PlainMoved], chunk: &Chunk<'_>, place: &Place<'_>) -> Result<(), RewriteError> {
        let (shift, travel) = (self.shift(chunk.entry), self.job.profile.transition.travel_mm_per_min);
        let obstacles = place.obstacles_of(chunk);
        for m in moves {
            let stays = m.from == m.to;
            let prints = m.e > 0.0 && !stays;
            if stays || (obstacles.is_some() && !prints) {
                self.step(&(*m).into(), chunk.entry, obstacles);
            } else {
                let feed = m.feed.unwrap_or(travel);
                let (e, feed) =
                    if prints { (m.e * self.flow.share, feed.min(self.flow.most_feed)) } else { (m.e, feed) };
                self.out.go_plain(m.to + shift, e, feed);
            }
            self.hand_over(WRITTEN_AT_ONCE)?;
        }
        Ok(())
    }

    fn step(&mut self, step: &Step3, entry: &Entry<'_>, obstacles: Option<&Obstacles<'_>>) {
        let shift = self.shift(entry);
        let prints = step.prints();
        let e = if prints { step.e * self.flow.share } else { step.e };
        let (from, to) = (step.from + shift, step.to + shift);
        let feed = step.feed.unwrap_or(self.job.profile.transition.travel_mm_per_min);
        let feed = if prints { feed.min(self.flow.most_feed) } else { feed };
        let comment = entry.input.sliced.text(&step.comment);
        if step.from == step.to && step.arc.is_none() {
            self.out.filament(e, feed, comment);
            return;
        }
        if let (Some(obstacles), true) = (obstacles, !prints)
            && !obstacles.free(entry.print.part, from, to)
        {
            self.over(from, to, e, feed, obstacles);
            return;
        }
        match &step.arc {
            Some(arc) if self.job.profile.dialect.arcs && self.route.is_none() => {
                self.out.go_round(to, arc, e, feed, comment)
            }
            Some(arc) => {
                let points = flatten(from, to, arc, CHORD_MM);
                let share = e / points.len() as f64;
                points.into_iter().for_each(|p| self.out.go(p, share, feed, b""));
            }
            None => self.out.go(to, e, feed, comment),
        }
    }

    /// A travel that would touch something: up, across, down.
    fn over(&mut self, from: Vec3, to: Vec3, e: f64, feed: f64, obstacles: &Obstacles<'_>) {
        let z_feed = self.job.profile.transition.z_mm_per_min;
        let height = obstacles.over_all.max(from.z).max(to.z).min(self.highest());
        self.out.filament(e, feed, b"");
        self.out.go_z(height, z_feed);
        self.out.go(Vec3::new(to.x, to.y, height), 0.0, feed, b"");
        self.out.go(to, 0.0, z_feed, b"");
    }
}

/// `; generated by NAME VERSION on DATE at TIME` without the date: the same input makes the same bytes.
fn without_date(line: &[u8]) -> &[u8] {
    let dated = line.starts_with(b"; generated by ");
    let cut =
        dated.then(|| line.windows(6).position(|w| w.starts_with(b" on ") && w[4..].iter().all(u8::is_ascii_digit)));
    &line[..cut.flatten().unwrap_or(line.len())]
}

/// Where the layers of a setup are printed.
struct Place<'a> {
    chunks: &'a [Chunk<'a>],
    obstacles: &'a Obstacles<'a>,
    /// Whether an entry's travels clear all obstacles, wherever they go; by its place in the setup.
    open: &'a [bool],
}

impl Place<'_> {
    /// What the travels of a layer may touch.
    fn obstacles_of(&self, chunk: &Chunk<'_>) -> Option<&Obstacles<'_>> {
        (!self.open[chunk.position]).then_some(self.obstacles)
    }
}

/// The corners of the boxes of all layers of supports, and of the first one on the table; table frame.
fn corners(entry: &Entry<'_>, table: &TableKinematics) -> Vec<Vec3> {
    let back = table.forward(entry.print.pose(table)).inverse();
    let layers = entry.input.sliced.layers.iter().map(|layer| layer.extrusion);
    let foot = layers.clone().next().map(|first| Bounds { min: Vec3::new(first.min.x, first.min.y, 0.0), ..first });
    let boxes = layers.chain(foot);
    boxes.flat_map(|one| one.corners()).map(|p| back.point((p + entry.mesh.to_machine).into()).at).collect()
}

/// The first that was sliced by the user's slicer: supports have no settings of their own to tell.
fn of_a_part<'b, 'a>(entries: &'b [Entry<'a>]) -> Option<&'b Entry<'a>> {
    entries.iter().find(|entry| !entry.holds)
}

/// The parts of a setup, each once.
fn parts(group: &[Entry<'_>]) -> Vec<usize> {
    group.iter().filter(|entry| !entry.holds).map(|entry| entry.print.part).collect()
}

/// Where an entry's tip goes, machine coordinates.
fn region(entry: &Entry<'_>) -> Bounds {
    let (extrusion, reach) = (&entry.input.sliced.extrusion, &entry.input.sliced.reach);
    let shift = entry.mesh.to_machine;
    let min = Vec3::new(reach.min.x, reach.min.y, extrusion.min.z - entry.joint.lower_mm);
    let max = Vec3::new(reach.max.x, reach.max.y, extrusion.max.z);
    Bounds { min: min + shift, max: max + shift }
}
