//! A re-entry and what is printed behind it, as a program that `verify` judges.

use crate::gcode::ParsedLine;
use crate::input::CheckedPlan;
use crate::link::Reentry;
use crate::motion::replay::{Controller, Step};
use crate::profile::Profile;
use crate::verify::{Finding, ReplayJob as Proof, Rule, verify};

/// Over lines that are missing nothing may span more, mm: a hole is no bridge that somebody drew.
const HOLE_MM: f64 = 8.0;

/// What a remark says that holds until the next one says otherwise.
const HOLDS: [&[u8]; 6] = [b";TRUNNION slot=", b";TRUNNION print=", b";TYPE:", b";WIDTH:", b";HEIGHT:", b";Z:"];

fn key(line: &[u8]) -> Option<&'static [u8]> {
    HOLDS.into_iter().find(|key| line.starts_with(key))
}

/// What was printed, and the re-entry, as one program; lines are numbered from 1.
pub(super) struct ReentryPath {
    pub(super) text: Vec<u8>,
    /// The last line of what was printed.
    printed: u32,
    /// The line of homing behind which the table's pose is known, or the last of homing; the first move at least, with which the
    /// replay sees the table's pose lost.
    posed: u32,
    /// The last line of our own.
    own: u32,
}

impl ReentryPath {
    /// Lines up to `printed`, the loss of every position, homing as it is written, our own moves, and the lines from the re-entry to `until`:
    /// they go where material may stand already.
    pub(super) fn of(file: &[u8], printed: u32, entry: &Reentry, until: u32, profile: &Profile) -> Self {
        let mut path = Self { text: Vec::with_capacity(file.len()), printed: 0, posed: 0, own: 0 };
        let (mut again, mut stands) = (Vec::new(), Vec::<&[u8]>::new());
        for line in crate::gcode::lines(file).take_while(|l| l.number <= until.max(printed)) {
            let is_remark = line.bytes.trim_ascii_start().first().is_none_or(|b| *b == b';');
            // What begins in between begins, though its lines are left out.
            if line.number <= printed || (is_remark && line.number < entry.file_line) {
                path.push(line.bytes);
            }
            if line.number >= entry.file_line && line.number <= until {
                again.push(line.bytes);
            } else if let (true, Some(key)) = (line.number < entry.file_line, key(line.bytes)) {
                stands.retain(|other| !other.starts_with(key));
                stands.push(line.bytes);
            }
        }
        path.printed = path.own;
        // Motors that were off or a board that was reset: nobody knows where anything is, the table's angles included.
        path.push(b"M84");
        path.own_lines(entry, profile);
        if entry.file_line <= printed {
            stands.into_iter().for_each(|line| path.push(line));
        }
        let own = path.own;
        again.into_iter().for_each(|line| path.push(line));
        Self { own, ..path }
    }

    fn own_lines(&mut self, entry: &Reentry, profile: &Profile) {
        let mut controller = Controller::new(profile.reading());
        let mut read = ParsedLine::default();
        let mut moved = false;
        // G90 makes the extruder's words absolute, too, on some.
        let kept = ["G1", "G90", "G91", "G93", "G94", "G92E", "M82", "M83", "MANUAL_STEPPER"];
        let moves = |l: &str| kept.iter().any(|g| l.starts_with(g));
        for (index, line) in entry.lines.iter().enumerate() {
            let homes = entry.home.contains(&index);
            // What is pulled and primed is none of the file's filament.
            if !homes && (!moves(line) || (line.starts_with("G1") && line.contains('E'))) {
                continue;
            }
            self.push(line.as_bytes());
            let unknown = controller.at.pose().is_none();
            // A line that is not understood leaves the pose unknown.
            let step = read.read(line.as_bytes()).ok().and_then(|()| controller.step(&read).ok());
            let first = !moved && matches!(step, Some(Step::Move(_)));
            moved |= first;
            self.posed = if first || (homes && unknown) { self.own } else { self.posed };
        }
    }

    fn push(&mut self, line: &[u8]) {
        self.text.extend_from_slice(line);
        self.text.push(b'\n');
        self.own += 1;
    }

    /// What the head strikes on the way to the part or behind it, in words.
    pub(super) fn struck(&self, plan: &CheckedPlan, profile: &Profile) -> Option<String> {
        self.first(plan, profile, |finding| self.counts(finding))
    }

    /// What lies in the air behind the re-entry, in words.
    pub(super) fn hanging(&self, plan: &CheckedPlan, profile: &Profile) -> Option<String> {
        let mut careful = profile.clone();
        careful.process.bridge_mm = careful.process.bridge_mm.min(HOLE_MM);
        self.first(plan, &careful, |finding| self.hangs(finding))
    }

    fn first(&self, plan: &CheckedPlan, profile: &Profile, counts: impl Fn(&Finding) -> bool) -> Option<String> {
        let workpiece = plan.workpiece();
        let job = Proof { profile, plan: &plan.plan, workpiece: &workpiece };
        verify(&self.text, &job).findings.into_iter().find(|finding| counts(finding)).map(|finding| finding.text)
    }

    fn hangs(&self, finding: &Finding) -> bool {
        finding.rule == Rule::InAir && finding.line > self.own
    }

    /// Whether a finding stands against the re-entry. That homing itself touches nothing is the profile's word, as long as nobody
    /// knows where the table is; coming from home, X and Y may be anywhere, and are judged as that.
    fn counts(&self, finding: &Finding) -> bool {
        match finding.rule {
            _ if finding.line <= self.printed => false,
            // Where exactly a print was interrupted nobody knows: its last lines may stand in the way, and give way.
            _ if finding.is_shallow_travel() => false,
            Rule::HeadCollision | Rule::AxisLimit => true,
            Rule::TurnCollision => finding.line > self.posed,
            Rule::UnknownPosition => finding.line > self.own,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests;
