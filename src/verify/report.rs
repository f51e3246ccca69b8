//! What verification says: findings by rule, and the file's figures.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

/// What a program must hold to; each is checked over the whole file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Every line is understood.
    Syntax,
    /// The profile's firmware reads every line as it is read here.
    Reading,
    /// Every command is known, and harmless where it is.
    Command,
    /// Settings are within the profile's range, and constant through a print.
    Setting,
    /// No axis is sent beyond its stops.
    AxisLimit,
    /// No axis is sent faster than its limit, or implausibly slowly.
    AxisRate,
    /// The table does not turn while filament is extruded.
    TurnWhileExtruding,
    /// Each print is made at the plan's pose.
    Pose,
    /// Filament is printed only inside the part being printed.
    OutsidePart,
    /// Filament is printed on or against something.
    InAir,
    /// The head keeps clear of the table and of everything printed.
    HeadCollision,
    /// The head keeps clear while the table turns, and of the frame always.
    TurnCollision,
    /// The filament extruded is the filament sliced.
    Filament,
    /// Each line uses the filament that its width and height need, no faster than the nozzle melts it.
    Flow,
    /// Surfaces are full, walls are whole, and infill does not stop.
    Fill,
    /// Nothing is extruded through a cold nozzle or onto a cold bed, nothing is heated too far, and all heaters are off at the end.
    Heat,
    /// Layers follow each other at the height of their lines, the first one on what carries it.
    LayerHeight,
    /// Each print lies where its part is: not moved, turned, scaled.
    Registration,
    /// Every layer of every part is in the file, and so is the profile's end code.
    Complete,
    /// Retracted filament is primed again before printing continues.
    Retract,
    /// Nothing is printed or passed over before the machine's position is known.
    UnknownPosition,
    /// The prints come in the plan's order, each once.
    Sequence,
    /// The print neither falls over nor comes off at any tilt.
    Standing,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// One breach of a rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The rule.
    pub rule: Rule,
    /// The line in the file, from 1.
    pub line: u32,
    /// The plan's slot, where one was going on.
    pub slot: Option<usize>,
    /// The part being printed, where one was.
    pub part: Option<usize>,
    /// What the file does, in the unit that `text` names; 0 where nothing is measured.
    pub measured: f64,
    /// What it may do at most (at least, where `text` says so).
    pub allowed: f64,
    /// One sentence.
    pub text: String,
}

/// What verification found; lengths mm.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The findings by line, at most [`KEPT_PER_RULE`] of each rule.
    pub findings: Vec<Finding>,
    /// All findings, kept or not, by rule; of collisions of the head, each of which is dear, the first thousand, and one for
    /// each twenty moves of a short program.
    pub counts: BTreeMap<Rule, usize>,
    /// The least distance between the head and everything that it does not print on, mm, over the whole file: in any direction, to
    /// 0.05 mm at a fixed pose and a proved lower bound while the table turns. The piece that carries the tip counts against
    /// prints whose part shares no face with the one being laid, and the table where that does not stand on it or is tilted; all other pieces
    /// against everything. At most [`CLEARANCE_CAP_MM`]; where something is hit, minus a bound of how deep.
    /// Beyond the collisions that `counts` has room for nothing is looked for.
    pub clearance_mm: f64,
    /// The line with that room; 0 where the cap was never undercut.
    pub clearance_line: u32,
    /// Where that is, at a fixed pose; `None` while the table turns, where something is hit, and where the cap was never undercut.
    pub clearance_at: Option<NearestApproach>,
    /// Where what is printed is held the fewest times over; `None` where nothing tips anything, and where nothing lies on the table.
    pub standing: Option<Standing>,
    /// Parts that lie beside each other and never touch, as joints do that are printed in place: how near their lines come, the narrowest
    /// first; those that stay 1 mm apart are not among them.
    pub joints: Vec<JointRoom>,
    /// Surfaces that two parts share, and how much of each is filled from both sides; the least filled first.
    pub interfaces: Vec<InterfaceFill>,
    /// What the table has to do.
    pub table: TableUse,
    /// Where printing goes on with an outer wall after a turn: a blob shows there. In the file's order, the first [`WALL_STARTS`].
    pub wall_starts: Vec<WallStart>,
    /// Settings of which the file states less than the profile has, and factors on all filament: what is missing by them is no finding.
    pub stated: Vec<StatedSetting>,
    /// Moves of any axis.
    pub moves: usize,
    /// Slots in which something was printed.
    pub slots: usize,
    /// Filament laid down while moving.
    pub filament_mm: f64,
    /// Time of all moves and waits as [`trace::Clock`](crate::trace::MotionClock) has it: with accelerations, without homing and heating.
    pub seconds_print: f64,
    /// What the replay has cost: places of the head that were held against what stands, and what was looked at for distances. The same
    /// on every computer; see `docs/explanation/costs.md`.
    #[serde(skip)]
    pub steps: u64,
}

/// Where the head comes nearest to something: two places in the table's frame, mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NearestApproach {
    /// On the head.
    pub head_mm: [f64; 3],
    /// On the table, or on what was printed.
    pub other_mm: [f64; 3],
    /// How much of the line's move is done then, from 0 to 1.
    pub share: f64,
}

/// The least room between the lines of two parts, seen from above.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointRoom {
    /// The parts.
    pub parts: [usize; 2],
    /// From the edge of one's line to that of the other's, mm; negative where they lie over each other, and fuse.
    pub gap_mm: f64,
    /// The later line of the two.
    pub line: u32,
    /// The tip's height there, machine coordinates, mm.
    pub z_mm: f64,
}

/// A surface that two parts share, and how much of it lines of both reach.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InterfaceFill {
    /// The parts, the lower number first.
    pub parts: [usize; 2],
    /// Its area, mm².
    pub area_mm2: f64,
    /// The area that is within 0.15 mm of lines of both parts, mm².
    pub filled_mm2: f64,
    /// That, as a share of all.
    pub share: f64,
}

/// What a program asks of the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TableUse {
    /// How often it turns between printed lines.
    pub turns: usize,
    /// How long nothing is printed around these turns, s, at the speeds written: the nozzle is hot.
    pub waiting_s: f64,
    /// The longest of these times, s.
    pub longest_s: f64,
    /// The line with which printing goes on after it; 0 without turns.
    pub longest_line: u32,
    /// Of the lines with which printing goes on, those of outer walls: a blob shows there.
    pub starts_on_walls: usize,
    /// How far the rotation axis is from its zero at most, turns: so far are cables wound.
    pub wound_turns: f64,
    /// The line after which it is; 0 where it never turns.
    pub wound_line: u32,
    /// What the printed plastic pulls on the tilt axis with at most, N m; the table's own weight is not known.
    pub torque_nm: f64,
    /// The line at which it does.
    pub torque_line: u32,
}

/// A line of an outer wall with which printing goes on after the table has turned.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallStart {
    /// The line in the file.
    pub line: u32,
    /// The part that it is of.
    pub part: usize,
    /// Where it begins, table frame, mm.
    pub at_mm: [f64; 3],
}

/// A setting of which a file states less than the profile has, or another factor on all filament.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatedSetting {
    /// Its key in `[process]`; `multiplier` is the slicer's factor on all filament.
    pub setting: &'static str,
    /// What the file states; 0 infill for none.
    pub file: f64,
    /// What the profile has.
    pub profile: f64,
    /// The parts whose prints state it.
    pub parts: Vec<usize>,
}

/// How many times over something is held on the table, by what of its first layer lies there, at the worst of all poses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// Against its weight alone; infinite where that only holds it. On a tilted table at least 1.
    pub factor: f64,
    /// And against the nozzle's push where it was printed.
    pub pushed_factor: f64,
    /// The line after which it stands so.
    pub line: u32,
    /// How far the table is tilted there, degrees.
    pub tilt_deg: f64,
    /// What stands there, g.
    pub grams: f64,
}

/// How many findings of one rule are kept.
pub const KEPT_PER_RULE: usize = 20;
/// How many starts on outer walls are listed.
pub const WALL_STARTS: usize = 1000;
/// Room beyond this is not told apart, mm.
pub const CLEARANCE_CAP_MM: f64 = 50.0;

impl Report {
    /// Of a program of so many moves, nothing of which is checked yet.
    pub(super) fn of_moves(moves: usize, seconds_print: f64) -> Self {
        Self {
            findings: Vec::new(),
            counts: BTreeMap::new(),
            clearance_mm: CLEARANCE_CAP_MM,
            clearance_line: 0,
            clearance_at: None,
            standing: None,
            joints: Vec::new(),
            interfaces: Vec::new(),
            table: TableUse::default(),
            wall_starts: Vec::new(),
            stated: Vec::new(),
            moves,
            slots: 0,
            filament_mm: 0.0,
            seconds_print,
            steps: 0,
        }
    }

    /// Whether nothing was found.
    pub fn is_clean(&self) -> bool {
        self.counts.is_empty()
    }

    /// The number of all findings, kept or not.
    pub fn count(&self) -> usize {
        self.counts.values().sum()
    }
}

/// Findings as they come.
#[derive(Default)]
pub(super) struct Findings {
    kept: BTreeMap<Rule, Vec<Finding>>,
    counts: BTreeMap<Rule, usize>,
}

/// Where in the file and the plan.
#[derive(Clone, Copy, Default)]
pub(super) struct FindingPlace {
    pub(super) line: u32,
    pub(super) slot: Option<usize>,
    pub(super) part: Option<usize>,
}

impl Findings {
    /// Notes a breach; `text` is only made where it is kept.
    pub(super) fn add(
        &mut self,
        rule: Rule,
        at: FindingPlace,
        [measured, allowed]: [f64; 2],
        text: impl FnOnce() -> String,
    ) {
        *self.counts.entry(rule).or_default() += 1;
        let kept = self.kept.entry(rule).or_default();
        if kept.len() < KEPT_PER_RULE {
            kept.push(Finding { rule, line: at.line, slot: at.slot, part: at.part, measured, allowed, text: text() });
        }
    }

    /// Takes over findings made beside these.
    pub(super) fn absorb(&mut self, other: Self) {
        for (rule, count) in other.counts {
            *self.counts.entry(rule).or_default() += count;
        }
        for (rule, findings) in other.kept {
            let kept = self.kept.entry(rule).or_default();
            kept.extend(findings);
            kept.sort_by_key(|f| f.line);
            kept.truncate(KEPT_PER_RULE);
        }
    }

    /// Takes over findings that were made after these, as if they had been added one by one.
    pub(super) fn append(&mut self, later: Self) {
        for (rule, count) in later.counts {
            *self.counts.entry(rule).or_default() += count;
        }
        for (rule, findings) in later.kept {
            let kept = self.kept.entry(rule).or_default();
            let free = KEPT_PER_RULE.saturating_sub(kept.len());
            kept.extend(findings.into_iter().take(free));
        }
    }

    /// The kept findings by line, and the counts.
    pub(super) fn finish(self) -> (Vec<Finding>, BTreeMap<Rule, usize>) {
        let mut all: Vec<Finding> = self.kept.into_values().flatten().collect();
        all.sort_by_key(|f| (f.line, f.rule));
        (all, self.counts)
    }
}
