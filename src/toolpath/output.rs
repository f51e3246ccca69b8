//! Blocks of the machine's dialect, written once and in one place.

use crate::gcode::meaning::{Firmware, ManualStepper};
use crate::gcode::{LineRules, push_fixed, push_units, round_to, units_of};
use crate::geom::Vec3;
use crate::motion::replay::Arc;
use crate::motion::{LinearLimits, OutOfLimits, Pose, TableKinematics};
use crate::profile::{Commands, Extrusion, FeedReference, Profile};

/// Decimals of coordinates, mm; of a head that turns, one more: a layer's height is then the sum of three words.
const LINEAR: [u32; 2] = [3, 4];
/// Decimals of angles, degrees.
const ANGULAR: u32 = 4;
/// Decimals of filament, mm.
const FILAMENT: u32 = 5;
/// Decimals of feeds.
const FEED: u32 = 2;
/// More than a block takes without its comment.
const MOST_BYTES: usize = 256;

/// The file as it grows, with what the machine has been told so far.
pub(super) struct Output<'a> {
    pub(super) bytes: Vec<u8>,
    profile: &'a Profile,
    table: TableKinematics,
    /// Decimals of coordinates.
    linear: u32,
    limits: LinearLimits,
    /// Where the head turns, at which pose it is.
    swivelled: Option<Pose>,
    /// X, Y, Z as last written, in units of their last decimal.
    at: [Option<i64>; 3],
    /// The same before rounding.
    given: [f64; 3],
    /// F as last written, in units of its last decimal.
    feed: Option<i64>,
    /// The same before rounding.
    given_feed: f64,
    /// Filament of absolute counting so far.
    extruded: f64,
    /// What rounding has left over, by print, so that each print's sum is right to half a digit.
    owed: Vec<f64>,
    /// Whose filament is being written; the last place is nobody's: retractions and primes.
    print: usize,
    /// The highest feed that had to be lowered.
    pub(super) lowered: Option<f64>,
    /// The first axis of a machine whose head turns that would have had to go beyond its stops.
    pub(super) beyond: Option<OutOfLimits>,
}

impl<'a> Output<'a> {
    pub(super) fn new(profile: &'a Profile, prints: usize) -> Self {
        let table = profile.kinematics();
        Self {
            bytes: Vec::new(),
            profile,
            linear: LINEAR[usize::from(table.head.is_some())],
            limits: profile.linear_limits(),
            swivelled: None,
            table,
            at: [None; 3],
            given: [f64::NAN; 3],
            feed: None,
            given_feed: f64::NAN,
            extruded: 0.0,
            owed: vec![0.0; prints + 1],
            print: prints,
            lowered: None,
            beyond: None,
        }
    }

    /// Whose words are written.
    pub(super) fn firmware(&self) -> Firmware {
        self.profile.firmware()
    }

    /// Where the tip is, if all is known.
    pub(super) fn tip(&self) -> Option<Vec3> {
        let words = self.words()?;
        if self.table.head.is_none() { Some(words) } else { Some(self.table.tip(words, self.swivelled?)) }
    }

    /// X, Y and Z as last written, if all are known.
    pub(super) fn words(&self) -> Option<Vec3> {
        let [x, y, z] = self.at;
        Some(Vec3::new(x? as f64, y? as f64, z? as f64) / 10_f64.powi(self.linear as i32))
    }

    /// The words for a tip.
    fn words_of(&mut self, tip: Vec3) -> Vec3 {
        let (Some(head), Some(pose)) = (&self.table.head, self.swivelled) else { return tip };
        let out = self.limits.violation(&head.axes(tip, pose));
        self.beyond = self.beyond.or(out);
        head.words(tip, pose)
    }

    /// A straight move to the words of X, Y and Z, of a head that turns.
    pub(super) fn go_words(&mut self, words: Vec3, feed: f64) {
        let bare = self.bytes.len();
        self.bytes.extend_from_slice(b"G1");
        let start = self.bytes.len();
        (0..3).for_each(|axis| self.coordinate(axis, words[axis]));
        if self.bytes.len() == start {
            return self.bytes.truncate(bare);
        }
        self.feed_word(feed);
        self.bytes.push(b'\n');
    }

    /// A move of the word of Z alone, wherever X and Y are.
    pub(super) fn raise(&mut self, z: f64, feed: f64) {
        if self.at[2] != Some(units_of(z, self.linear)) {
            self.bytes.extend_from_slice(b"G1");
            self.coordinate(2, z);
            self.feed_word(feed);
            self.bytes.push(b'\n');
        }
    }

    /// From here on filament laid down belongs to `print`.
    pub(super) fn lays_for(&mut self, print: usize) {
        self.print = print;
    }

    pub(super) fn line(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(b'\n');
    }

    /// A line of sliced input as it stands; as a comment where the firmware would not know it.
    pub(super) fn keep(&mut self, line: &[u8]) {
        let line = self.shortened(line.trim_ascii());
        let is_comment = line.first() == Some(&b';');
        if self.profile.dialect.commands == Commands::Rs274 && !is_comment {
            self.bytes.push(b';');
        }
        self.bytes.extend_from_slice(line);
        self.bytes.push(b'\n');
    }

    /// A line that becomes a comment, no longer than the firmware takes.
    fn shortened<'b>(&self, line: &'b [u8]) -> &'b [u8] {
        let most = LineRules::of(self.firmware()).longest_comment().unwrap_or(usize::MAX);
        &line[..line.len().min(most - 1)]
    }

    /// How filament is counted from here on.
    pub(super) fn begin_counting(&mut self) {
        match (self.profile.dialect.extrusion, self.profile.dialect.commands) {
            (Extrusion::Relative, _) => self.line("M83"),
            (Extrusion::Absolute, Commands::Marlin) => {
                self.line("M82");
                self.line("G92 E0");
            }
            (Extrusion::Absolute, Commands::Rs274) => {
                let letter = self.profile.dialect.extruder;
                self.line(&format!("G92 {letter}0"));
            }
        }
    }

    /// A straight move to `to` with `e` mm of filament.
    pub(super) fn go(&mut self, to: Vec3, e: f64, feed: f64, comment: &[u8]) {
        self.block(b"G1", Some(to), None, e, feed, comment);
    }

    /// An arc.
    pub(super) fn go_round(&mut self, to: Vec3, arc: &Arc, e: f64, feed: f64, comment: &[u8]) {
        let code: &[u8] = if arc.clockwise { b"G2" } else { b"G3" };
        self.block(code, Some(to), Some(arc), e, feed, comment);
    }

    /// A move along the tool to a height, whatever X and Y are.
    pub(super) fn go_z(&mut self, z: f64, feed: f64) {
        match (self.swivelled, self.tip()) {
            (Some(_), Some(tip)) => self.go(Vec3::new(tip.x, tip.y, z), 0.0, feed, b""),
            _ => self.raise(z, feed),
        }
    }

    /// A straight move without a comment, as nearly all are.
    #[inline]
    pub(super) fn go_plain(&mut self, to: Vec3, e: f64, feed: f64) {
        self.block(b"G1", Some(to), None, e, feed, b"");
    }

    /// Filament alone.
    pub(super) fn filament(&mut self, e: f64, feed: f64, comment: &[u8]) {
        self.block(b"G1", None, None, e, feed, comment);
    }

    #[inline(always)]
    fn block(&mut self, code: &[u8], to: Option<Vec3>, arc: Option<&Arc>, e: f64, feed: f64, comment: &[u8]) {
        self.bytes.reserve(MOST_BYTES + comment.len());
        let start = self.bytes.len();
        self.bytes.extend_from_slice(code);
        let bare = self.bytes.len();
        if let Some(to) = to {
            let to = if self.swivelled.is_some() { self.words_of(to) } else { to };
            self.coordinate(0, to.x);
            self.coordinate(1, to.y);
            self.coordinate(2, to.z);
        }
        if let Some(arc) = arc {
            self.arc_words(arc);
        }
        if e != 0.0 {
            let laid = e > 0.0 && to.is_some();
            self.filament_word(e, if laid { self.print } else { self.owed.len() - 1 });
        }
        if self.bytes.len() == bare {
            // Nothing to move: no block, so that F does not change its meaning on a line of its own.
            self.bytes.truncate(start);
            return;
        }
        self.feed_word(feed);
        if !comment.is_empty() {
            self.bytes.push(b' ');
            self.bytes.extend_from_slice(comment.trim_ascii_end());
        }
        self.bytes.push(b'\n');
    }

    #[inline(always)]
    fn coordinate(&mut self, axis: usize, value: f64) {
        if value == self.given[axis] {
            return;
        }
        self.given[axis] = value;
        let units = units_of(value, self.linear);
        if self.at[axis] == Some(units) {
            return;
        }
        self.at[axis] = Some(units);
        self.bytes.extend_from_slice(&[b' ', b"XYZ"[axis]]);
        push_units(&mut self.bytes, units, self.linear);
    }

    fn arc_words(&mut self, arc: &Arc) {
        let words: &[(u8, f64)] = match arc.by_radius {
            Some(radius) => &[(b'R', radius)],
            None => &[(b'I', arc.to_centre[0]), (b'J', arc.to_centre[1])],
        };
        for &(letter, value) in words {
            self.bytes.extend_from_slice(&[b' ', letter]);
            push_fixed(&mut self.bytes, value, 5);
        }
        if arc.turns > 1 {
            self.bytes.extend_from_slice(b" P");
            push_fixed(&mut self.bytes, f64::from(arc.turns), 0);
        }
    }

    /// Filament with the remainder of all roundings before it carried on, so that the sum is right to half a digit.
    fn filament_word(&mut self, e: f64, account: usize) {
        let wanted = e + self.owed[account];
        let units = units_of(wanted, FILAMENT);
        let written = round_to(wanted, FILAMENT);
        self.owed[account] = wanted - written;
        self.extruded += written;
        self.bytes.extend_from_slice(&[b' ', self.profile.dialect.extruder as u8]);
        match self.profile.dialect.extrusion {
            Extrusion::Relative => push_units(&mut self.bytes, units, FILAMENT),
            Extrusion::Absolute => push_fixed(&mut self.bytes, self.extruded, FILAMENT),
        }
    }

    /// F where it changes, never above what the machine takes.
    #[inline]
    fn feed_word(&mut self, feed: f64) {
        if feed == self.given_feed {
            return;
        }
        self.given_feed = feed;
        let most = self.profile.limits.max_feed_mm_per_min;
        if feed > most {
            self.lowered = Some(self.lowered.map_or(feed, |f| f.max(feed)));
        }
        let units = units_of(feed.min(most), FEED);
        if self.feed != Some(units) {
            self.feed = Some(units);
            self.bytes.extend_from_slice(b" F");
            push_units(&mut self.bytes, units, FEED);
        }
    }

    /// Turns the table, one axis a block, each at its own rate: firmwares disagree on what F means for several at once.
    pub(super) fn turn(&mut self, from: Option<Pose>, to: Pose) {
        let tilt = self.table.tilt.clone();
        let rotation = self.table.rotation.clone();
        self.swivelled = self.table.head.as_ref().map(|_| to);
        let [before_turn, after_turn] = self.profile.transition.around_turn();
        let (steppers, mut turned) = (self.profile.steppers(), false);
        for (axis, before, after) in
            [(rotation, from.map(|p| p.rotation), to.rotation), (tilt, from.map(|p| p.tilt), to.tilt)]
        {
            let word = round_to(axis.word_of(after).deg(), ANGULAR);
            let was = before.map(|b| round_to(axis.word_of(b).deg(), ANGULAR));
            if was == Some(word) || axis.absent {
                continue;
            }
            if !std::mem::replace(&mut turned, true) {
                before_turn.iter().for_each(|line| self.line(line));
            }
            let degrees_per_min = axis.max_rate.to_degrees() * 60.0;
            let inverse = self.profile.dialect.feed == FeedReference::InverseTime;
            let feed = match (inverse, was) {
                (true, Some(was)) => degrees_per_min / (word - was).abs(),
                // From an unknown angle a whole turn is allowed for.
                (true, None) => degrees_per_min / 360.0,
                (false, _) => degrees_per_min,
            };
            if let Some(steppers) = &steppers {
                let name = &steppers[usize::from(axis.letter == self.table.rotation.letter)];
                self.line(&ManualStepper::go(name, word, axis.max_rate.to_degrees()));
                continue;
            }
            self.bytes.extend_from_slice(if inverse { b"G93 G1 " } else { b"G1 " });
            self.bytes.push(axis.letter);
            push_fixed(&mut self.bytes, word, ANGULAR);
            self.bytes.extend_from_slice(b" F");
            push_fixed(&mut self.bytes, (feed * 100.0 + 1e-6).floor() / 100.0, 2);
            self.bytes.push(b'\n');
            if inverse {
                self.line("G94");
            }
            // The next linear block must state its own F.
            self.feed = None;
            self.given_feed = f64::NAN;
        }
        if turned {
            after_turn.iter().for_each(|line| self.line(line));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(name: &str) -> Profile {
        let (file, text) = crate::profile::shipped(name).unwrap();
        crate::profile::resolve(file, text).unwrap().0
    }

    fn text(out: &Output<'_>) -> String {
        String::from_utf8(out.bytes.clone()).unwrap()
    }

    #[test]
    fn writes_only_what_changes() {
        let profile = profile("generic-ac");
        let mut out = Output::new(&profile, 1);
        out.go(Vec3::new(1.0, 2.0, 0.2), 0.0, 6000.0, b"");
        out.go(Vec3::new(1.0, 3.0, 0.2), 0.123456, 1200.0, b";seam");
        out.go(Vec3::new(1.0, 3.0, 0.2), 0.0, 900.0, b"");
        out.filament(-1.0, 2100.0, b"");
        assert_eq!(text(&out), "G1 X1 Y2 Z0.2 F6000\nG1 Y3 E0.12346 F1200 ;seam\nG1 E-1 F2100\n");
    }

    #[test]
    fn the_sum_of_rounded_filament_is_right() {
        let profile = profile("generic-ac");
        let mut out = Output::new(&profile, 1);
        out.lays_for(0);
        (0..1000).for_each(|i| out.go(Vec3::new(f64::from(i), 0.0, 0.0), 0.000_004_3, 600.0, b""));
        let sum: f64 =
            text(&out).lines().filter_map(|l| l.split(" E").nth(1)?.split(' ').next()?.parse::<f64>().ok()).sum();
        assert!((sum - 0.0043).abs() < 6e-6, "{sum}");
    }

    #[test]
    fn a_turn_is_one_axis_a_block_and_makes_the_next_feed_explicit() {
        let profile = profile("generic-ac");
        let mut out = Output::new(&profile, 1);
        out.go(Vec3::new(1.0, 2.0, 100.0), 0.0, 6000.0, b"");
        out.turn(Some(Pose::LEVEL), Pose::from_deg(70.0, -90.0));
        out.go(Vec3::new(5.0, 2.0, 100.0), 0.0, 6000.0, b"");
        assert_eq!(text(&out), "G1 X1 Y2 Z100 F6000\nG1 C-90 F1800\nG1 A70 F1200\nG1 X5 F6000\n");
    }

    #[test]
    fn rs274_counts_absolute_and_comments_what_it_does_not_know() {
        let profile = profile("linuxcnc-xyzac-trt");
        let mut out = Output::new(&profile, 1);
        out.begin_counting();
        out.keep(b"M106 S255");
        out.keep(b";TYPE:Perimeter");
        out.go(Vec3::new(1.0, 0.0, 0.0), 0.5, 600.0, b"");
        out.go(Vec3::new(2.0, 0.0, 0.0), 0.5, 600.0, b"");
        assert_eq!(text(&out), "G92 U0\n;M106 S255\n;TYPE:Perimeter\nG1 X1 Y0 Z0 U0.5 F600\nG1 X2 U1\n");
    }

    /// LinuxCNC ends the program at a line of 254 bytes, comments among them.
    #[test]
    fn a_comment_is_no_longer_than_its_firmware_takes() {
        let long = format!("; start_gcode = {}", "G1 X1\\n".repeat(100));
        for (machine, most) in [("linuxcnc-xyzac-trt", 250), ("generic-ac", long.len())] {
            let profile = profile(machine);
            let mut out = Output::new(&profile, 1);
            out.keep(long.as_bytes());
            assert_eq!(text(&out).trim_end_matches('\n').len(), most, "{machine}");
        }
    }
}
