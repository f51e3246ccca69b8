//! Prints in the plan's order, with the moves between them, as one file for the machine.
//!
//! ```text
//! for each pose: retract - up along the tool - turn, one axis a block - over the next start - down - prime
//!   for each layer, lowest first: the print it belongs to, shifted; between different prints a travel of ours
//! ```

use std::collections::BTreeSet;
use std::ops::Range;

use super::clear::Obstacles;
use super::export::{BoxMismatch, SlotMesh, check_box, slot_mesh};
use super::joint::{Flow, Joint};
use super::modal::{Modal, translated};
use super::output::Output;
use super::sliced::{Item, Layer, SlicedPrint, Step3};
use crate::gcode::marks::{END_MARK, Expect, Hint, hint, print_mark, slot_mark, version_mark};
use crate::geom::{Bounds, Vec3};
use crate::motion::replay::flatten;
use crate::motion::{Pose, TableKinematics};
use crate::planning::{Head, Plan, Print, Printed, Workpiece, joint_gap_mm};
use crate::profile::Profile;

/// One print's sliced file.
pub struct Input<'a> {
    /// The print's number, in the order of [`Plan::prints`].
    pub print: usize,
    /// Where on the slicer's bed the print's box is centred.
    pub centre_mm: [f64; 2],
    /// The file, for messages.
    pub file: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
    /// Read from them.
    pub sliced: &'a SlicedPrint,
}

/// What the rewriter works for.
pub struct Job<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The hash of its text.
    pub plan_sha256: &'a str,
    /// The machine.
    pub profile: &'a Profile,
    /// The model on its table.
    pub workpiece: &'a Workpiece<'a>,
}

/// The file for the machine.
pub struct Rewritten {
    /// Its bytes.
    pub gcode: Vec<u8>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Why nothing was written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RewriteError {
    /// A print without a file.
    #[error(
        "no sliced file for print {print} (slot {slot}, part {part}); give one for each print of the plan, named print-{print:02}.."
    )]
    Missing {
        /// The print.
        print: usize,
        /// Its slot.
        slot: usize,
        /// Its part.
        part: usize,
    },
    /// Two files for one print, or one too many.
    #[error("{file}: print {print} {problem}")]
    Unexpected {
        /// The file.
        file: String,
        /// The print.
        print: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Not what was handed over.
    #[error("{file}: print {print} (part {part}): {source}")]
    Box {
        /// The file.
        file: String,
        /// The print.
        print: usize,
        /// The part.
        part: usize,
        /// The numbers.
        source: BoxMismatch,
    },
    /// Layers that go down again cannot be interleaved with another print's.
    #[error(
        "{file}:{line}: layer at z {z:.3} mm comes after a higher one; this print shares its setup with others, so its layers must go up"
    )]
    LayersDescend {
        /// The file.
        file: String,
        /// Its line.
        line: u32,
        /// The layer's height, slot frame.
        z: f64,
    },
}

/// Travels between prints of one pose go this far above the higher of both ends, mm: over strings and seams.
const HOP_MM: f64 = 1.0;

struct Entry<'a> {
    input: &'a Input<'a>,
    print: &'a Print,
    slot: usize,
    mesh: SlotMesh,
    joint: Joint,
}

/// One file for the machine from all prints of the plan.
///
/// # Errors
///
/// [`RewriteError`]; nothing is returned that could be printed.
pub fn rewrite(inputs: &[Input<'_>], job: &Job<'_>) -> Result<Rewritten, RewriteError> {
    let table = job.profile.kinematics();
    let entries = entries(inputs, job, &table)?;
    let head = Head::of(job.profile);
    let mut writer = Writer {
        job,
        table: &table,
        head: &head,
        out: Output::new(job.profile, entries.len()),
        pose: None,
        printed: Vec::new(),
        current: None,
        above_all: false,
        in_force: Modal::default(),
        of_print: vec![Modal::default(); entries.len()],
        warnings: Vec::new(),
        flow: Flow::default(),
        untranslated: BTreeSet::new(),
    };
    writer.header(&entries);
    let mut rest = entries.as_slice();
    for slot in &job.plan.slots {
        for setup in slot.setups() {
            let (group, after) = rest.split_at(setup.len());
            rest = after;
            writer.setup(group)?;
        }
    }
    writer.footer(&entries);
    if let Some(feed) = writer.out.lowered {
        let most = job.profile.limits.max_feed_mm_per_min;
        writer.warnings.push(format!("feeds up to {feed:.0} mm/min were lowered to the machine's {most:.0} mm/min"));
    }
    let mut replaced: Vec<&str> = entries.iter().flat_map(|e| &e.input.sliced.replaced).map(String::as_str).collect();
    replaced.sort_unstable();
    replaced.dedup();
    if !replaced.is_empty() {
        writer.warnings.push(format!(
            "{} of the slicer's own start or end code are left out: the profile's [dialect] start and end take their place",
            replaced.join(", ")
        ));
    }
    let waits_s: f64 = entries.iter().map(|entry| entry.input.sliced.waits_s).sum();
    if waits_s > 0.0 {
        writer.warnings.push(format!(
            "waits (G4) of {waits_s} s inside the prints are left out: a hot nozzle does not stand on the part"
        ));
    }
    Ok(Rewritten { gcode: writer.out.bytes, warnings: writer.warnings })
}

/// The inputs in printing order (a slot's setups one after the other), each checked against its mesh.
fn entries<'a>(
    inputs: &'a [Input<'a>],
    job: &'a Job<'_>,
    table: &TableKinematics,
) -> Result<Vec<Entry<'a>>, RewriteError> {
    let prints: Vec<(usize, &Print)> = job.plan.prints().collect();
    for (index, input) in inputs.iter().enumerate() {
        let problem = if input.print >= prints.len() {
            "is not in the plan"
        } else if inputs[..index].iter().any(|other| other.print == input.print) {
            "was given before"
        } else {
            continue;
        };
        return Err(RewriteError::Unexpected { file: input.file.to_owned(), print: input.print, problem });
    }
    let mut entries = Vec::new();
    let mut printed: Vec<Printed> = Vec::new();
    for slot in &job.plan.slots {
        for print in slot.setups().into_iter().flatten() {
            let index = prints.iter().position(|(_, p)| std::ptr::eq(*p, print)).unwrap_or_default();
            let Some(input) = inputs.iter().find(|i| i.print == index) else {
                return Err(RewriteError::Missing { print: index, slot: slot.id, part: print.part });
            };
            let mesh = slot_mesh(job.workpiece, table, print, input.centre_mm);
            check_box(&mesh, input.sliced, job.profile).map_err(|source| RewriteError::Box {
                file: input.file.to_owned(),
                print: index,
                part: print.part,
                source,
            })?;
            let up = Vec3::from(print.up);
            let gap = joint_gap_mm(job.workpiece, print.part, up, &printed);
            let joint = Joint::over(gap, input.sliced, &job.profile.process);
            printed.push(Printed { part: print.part, up, height_mm: input.sliced.extrusion.max.z });
            entries.push(Entry { input, print, slot: slot.id, mesh, joint });
        }
    }
    Ok(entries)
}

/// A layer of an entry, with its height in the machine.
struct Chunk<'a> {
    entry: &'a Entry<'a>,
    layer: &'a Layer,
    index: usize,
    z: f64,
}

struct Writer<'a> {
    job: &'a Job<'a>,
    table: &'a TableKinematics,
    head: &'a Head,
    out: Output<'a>,
    pose: Option<Pose>,
    /// Parts of setups that are done.
    printed: Vec<usize>,
    /// The print that the nozzle is at, not retracted.
    current: Option<usize>,
    /// Whether the tip is at the height proved clear, as it is while the table turns.
    above_all: bool,
    /// What kept lines have set.
    in_force: Modal,
    /// The same for each print alone, by its number.
    of_print: Vec<Modal>,
    warnings: Vec<String>,
    /// What the layer's lines take of the filament that was sliced, and its height where that is not the sliced one, mm.
    flow: Flow,
    /// Commands that the machine's firmware does not have, told once.
    untranslated: BTreeSet<String>,
}

impl Writer<'_> {
    fn header(&mut self, entries: &[Entry<'_>]) {
        let profile = self.job.profile;
        let version = env!("CARGO_PKG_VERSION");
        self.out.line(&format!("; generated by trunnion {version} for {} (5-axis)", profile.machine.name));
        let plan = self.job.plan_sha256;
        self.out.line(&version_mark(plan, &profile.machine.name));
        for entry in entries {
            let sliced = entry.input.sliced;
            let (filament_mm, multiplier) = (sliced.filament_mm + entry.joint.added_mm, sliced.multiplier);
            let (print, part, bead) = (entry.input.print, entry.print.part, sliced.bead);
            let widths = sliced.widths_mm.clone();
            let outset_mm = sliced.outset_mm;
            let expect = Expect { print, part, filament_mm, multiplier, bead, widths, outset_mm };
            self.out.line(&expect.to_string());
        }
        if let Some(first) = entries.first() {
            for span in &first.input.sliced.prologue {
                self.out.keep(without_date(&first.input.bytes[span.clone()]));
            }
        }
        let of = |pick: fn(&SlicedPrint) -> Option<f64>, default: f64| {
            entries.iter().find_map(|e| pick(e.input.sliced)).unwrap_or(default)
        };
        let nozzle = of(|s| s.nozzle_c, profile.process.nozzle_c);
        let bed = of(|s| s.bed_c, profile.process.bed_c);
        self.in_force = Modal::heated(Some(nozzle), Some(bed));
        for entry in entries {
            let sliced = entry.input.sliced;
            self.of_print[entry.input.print] = Modal::heated(sliced.nozzle_c, sliced.bed_c);
        }
        self.custom_code(&profile.dialect.start, nozzle, bed);
        self.out.begin_counting();
        // Up first, wherever homing has left X and Y.
        self.out.go_z(self.safe_height(), profile.transition.z_mm_per_min);
    }

    fn footer(&mut self, entries: &[Entry<'_>]) {
        self.retract();
        self.out.go_z(self.safe_height(), self.job.profile.transition.z_mm_per_min);
        if let Some(pose) = self.pose {
            self.out.turn(self.pose, Pose { tilt: Pose::LEVEL.tilt, ..pose });
        }
        self.out.line(END_MARK);
        self.custom_code(&self.job.profile.dialect.end, 0.0, 0.0);
        if let Some(first) = entries.first() {
            for span in &first.input.sliced.epilogue {
                self.out.keep(&first.input.bytes[span.clone()]);
            }
        }
    }

    fn custom_code(&mut self, template: &str, nozzle: f64, bed: f64) {
        let text = template.trim().replace("{nozzle_c}", &nozzle.to_string()).replace("{bed_c}", &bed.to_string());
        text.lines().for_each(|line| self.out.line(line));
    }

    /// Above the sphere that the table and everything printed sweep about the pivot; the axis's end where it is lower.
    fn safe_height(&self) -> f64 {
        let points = self.printed.iter().flat_map(|&p| self.job.workpiece.parts[p].vertices().iter().copied());
        let reach = points.chain(self.job.profile.table_slab()).map(|p| p.norm()).fold(0.0, f64::max);
        let top = self.table.pivot.z + self.table.offset.norm() + reach + self.job.profile.transition.clearance_mm;
        top.min(self.job.profile.limits.z_mm[1])
    }

    /// All prints of one pose, layer by layer.
    fn setup(&mut self, group: &[Entry<'_>]) -> Result<(), RewriteError> {
        let pose = group[0].print.pose(self.table);
        self.change_pose(pose, group);
        let printing: Vec<usize> = group.iter().map(|e| e.print.part).collect();
        let stands = (&self.printed[..], &printing[..]);
        let obstacles = Obstacles::at(pose, stands, self.job.workpiece, self.table, self.job.profile, self.head);
        let open: Vec<bool> = group.iter().map(|e| obstacles.free_within(e.print.part, &region(e))).collect();
        for chunk in chunks(group)? {
            let same = self.current == Some(chunk.entry.input.print);
            if !same {
                self.enter(&chunk, &obstacles);
            }
            let position = group.iter().position(|e| std::ptr::eq(e, chunk.entry)).unwrap_or_default();
            let lead = if same { chunk.layer.lead.as_slice() } else { &[] };
            for item in lead.iter().chain(&chunk.layer.body) {
                self.flow = chunk.entry.joint.flow_of(chunk.index);
                self.item(item, chunk.entry, if open[position] { None } else { Some(&obstacles) });
            }
        }
        self.printed.extend(group.iter().map(|e| e.print.part));
        Ok(())
    }

    /// Leaves along the tool, turns the table, and waits above.
    fn change_pose(&mut self, pose: Pose, group: &[Entry<'_>]) {
        let transition = &self.job.profile.transition;
        self.retract();
        let height = self.safe_height();
        if self.pose != Some(pose) || self.out.tip().is_none() {
            self.out.go_z(height, transition.z_mm_per_min);
            self.above_all = true;
            if let (Some([x, y]), Some(_)) = (transition.park_mm, self.pose) {
                self.out.go(Vec3::new(x, y, height), 0.0, transition.travel_mm_per_min, b"");
            }
        }
        let parts: Vec<usize> = group.iter().map(|e| e.print.part).collect();
        let (print, table) = (group[0].print, self.table);
        let words = [(table.tilt.letter, print.tilt_deg), (table.rotation.letter, print.rotation_deg)];
        self.out.line(&slot_mark(group[0].slot, &parts, words));
        self.out.turn(self.pose, pose);
        self.pose = Some(pose);
    }

    fn retract(&mut self) {
        if self.current.take().is_some() {
            let t = &self.job.profile.transition;
            self.out.filament(-t.retract_mm, t.retract_mm_per_s * 60.0, b"");
        }
    }

    /// Goes to where `chunk` begins to extrude, primed.
    fn enter(&mut self, chunk: &Chunk<'_>, obstacles: &Obstacles<'_>) {
        let transition = &self.job.profile.transition;
        self.retract();
        let shift = chunk.entry.mesh.to_machine;
        let Some(first) = first_print(chunk.layer) else { return };
        let start = first.from + shift;
        let height = self.travel_height(start, obstacles);
        let (print, part) = (chunk.entry.input.print, chunk.entry.print.part);
        self.out.go_z(height, transition.z_mm_per_min);
        self.out.go(Vec3::new(start.x, start.y, height), 0.0, transition.travel_mm_per_min, b"");
        self.above_all = false;
        self.out.line(&print_mark(print, part));
        // What the lead itself sets need not be set twice.
        let mut wanted = self.of_print[print].clone();
        for item in &chunk.layer.lead {
            if let Item::Keep(span) = item {
                wanted.note(chunk.entry.input.sliced.firmware, &chunk.entry.input.bytes[span.clone()]);
            }
        }
        for line in self.in_force.change_to(&wanted) {
            self.out.keep(line.as_bytes());
            self.in_force.note(self.out.firmware(), line.as_bytes());
        }
        let mut owed = 0.0;
        self.flow = chunk.entry.joint.flow_of(chunk.index);
        for item in &chunk.layer.lead {
            match item {
                Item::Keep(span) => self.keep(chunk.entry, span),
                // What a lead of a later layer pushes more than it pulled is the slicer's own restart allowance.
                Item::Step(step) if chunk.index > 0 => owed += step.e,
                _ => {}
            }
        }
        self.out.go(start, 0.0, transition.z_mm_per_min, b"");
        let prime = transition.retract_mm + owed.max(0.0);
        self.out.filament(prime, transition.retract_mm_per_s * 60.0, b"");
        self.current = Some(print);
        self.out.lays_for(print);
    }

    /// A little above both ends if that is free, else above everything that stands at this pose.
    fn travel_height(&self, start: Vec3, obstacles: &Obstacles<'_>) -> f64 {
        let limit = self.job.profile.limits.z_mm[1];
        let Some(tip) = self.out.tip() else { return self.safe_height() };
        if self.above_all {
            // Just turned: straight across and straight down.
            return tip.z.max(start.z);
        }
        let low = (tip.z.max(start.z) + HOP_MM).min(limit);
        let raised = |p: Vec3| Vec3::new(p.x, p.y, low);
        if obstacles.well_free(raised(tip), raised(start)) { low } else { obstacles.over_all.max(low).min(limit) }
    }

    /// A line of a print that passes, in the machine's own words.
    fn keep(&mut self, entry: &Entry<'_>, span: &Range<usize>) {
        let line = &entry.input.bytes[span.clone()];
        if line.starts_with(b";") {
            let height = self.flow.height_mm.filter(|_| matches!(hint(&line[1..]), Some(Hint::Height(_))));
            match height {
                Some(mm) => self.out.line(&format!(";HEIGHT:{mm:.3}")),
                None => self.out.keep(line),
            }
            return;
        }
        let firmware = entry.input.sliced.firmware;
        self.in_force.note(firmware, line);
        self.of_print[entry.input.print].note(firmware, line);
        match translated(line, firmware, self.out.firmware()) {
            Some(line) => self.out.keep(&line),
            None => {
                let text = String::from_utf8_lossy(line).trim().to_owned();
                let name = text.split_ascii_whitespace().next().unwrap_or_default().to_owned();
                if self.untranslated.insert(name.clone()) {
                    let (from, to) = (firmware.name(), self.out.firmware().name());
                    self.warnings
                        .push(format!("{name} of the sliced file ({from}) has no counterpart on {to} and is left out"));
                }
            }
        }
    }

    /// One line of a print, shifted into the machine.
    fn item(&mut self, item: &Item, entry: &Entry<'_>, obstacles: Option<&Obstacles<'_>>) {
        match item {
            Item::Keep(span) => self.keep(entry, span),
            Item::FirmwareRetract(pull) => self.out.line(if *pull { "G10" } else { "G11" }),
            Item::Step(step) => self.step(step, entry, obstacles),
        }
    }

    fn step(&mut self, step: &Step3, entry: &Entry<'_>, obstacles: Option<&Obstacles<'_>>) {
        let shift = entry.mesh.to_machine;
        let step = &Step3 { e: if step.prints() { step.e * self.flow.share } else { step.e }, ..step.clone() };
        let (from, to) = (step.from + shift, step.to + shift);
        let feed = step.feed.unwrap_or(self.job.profile.transition.travel_mm_per_min);
        let comment = &entry.input.bytes[step.comment.clone()];
        if step.from == step.to && step.arc.is_none() {
            self.out.filament(step.e, feed, comment);
            return;
        }
        if let (Some(obstacles), true) = (obstacles, !step.prints())
            && !obstacles.free(entry.print.part, from, to)
        {
            self.over(from, to, step.e, feed, obstacles);
            return;
        }
        match &step.arc {
            Some(arc) if self.job.profile.dialect.arcs => self.out.go_round(to, arc, step.e, feed, comment),
            Some(arc) => {
                let points = flatten(from, to, arc, 0.01);
                let share = step.e / points.len() as f64;
                points.into_iter().for_each(|p| self.out.go(p, share, feed, b""));
            }
            None => self.out.go(to, step.e, feed, comment),
        }
    }

    /// A travel that would touch something: up, across, down.
    fn over(&mut self, from: Vec3, to: Vec3, e: f64, feed: f64, obstacles: &Obstacles<'_>) {
        let z_feed = self.job.profile.transition.z_mm_per_min;
        let height = obstacles.over_all.max(from.z).max(to.z).min(self.job.profile.limits.z_mm[1]);
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

/// Where an entry's tip goes, machine coordinates.
fn region(entry: &Entry<'_>) -> Bounds {
    let extrusion = &entry.input.sliced.extrusion;
    let mut bounds = Bounds { min: extrusion.min, max: extrusion.max };
    let layers = entry.input.sliced.layers.iter().enumerate();
    // The lead of the first layer comes from the slicer's origin and is replaced by a move of ours.
    for item in layers.flat_map(|(i, l)| l.lead.iter().filter(move |_| i > 0).chain(&l.body)) {
        if let Item::Step(step) = item {
            bounds.add(Vec3::new(step.to.x, step.to.y, step.to.z.clamp(extrusion.min.z, extrusion.max.z)));
        }
    }
    let shift = entry.mesh.to_machine;
    Bounds { min: bounds.min + shift, max: bounds.max + shift }
}

/// All layers of a group, lowest first; one print alone keeps its own order.
fn chunks<'a>(group: &'a [Entry<'a>]) -> Result<Vec<Chunk<'a>>, RewriteError> {
    let mut all = Vec::new();
    for entry in group {
        let mut highest = f64::NEG_INFINITY;
        for (index, layer) in entry.input.sliced.layers.iter().enumerate() {
            if group.len() > 1 && layer.z < highest {
                let line = first_print(layer).map_or(0, |s| s.line);
                return Err(RewriteError::LayersDescend { file: entry.input.file.to_owned(), line, z: layer.z });
            }
            highest = layer.z;
            all.push(Chunk { entry, layer, index, z: layer.z + entry.mesh.to_machine.z });
        }
    }
    if group.len() > 1 {
        all.sort_by(|a, b| a.z.total_cmp(&b.z));
    }
    Ok(all)
}

fn first_print(layer: &Layer) -> Option<&Step3> {
    layer.body.iter().find_map(|item| match item {
        Item::Step(step) if step.prints() => Some(step),
        _ => None,
    })
}
