//! Comments with a meaning: our own marks, written and read here, and what slicers say of the lines that follow.
//!
//! ```text
//! ;TRUNNION version=0.1.0 plan=<sha256> profile=<name>
//! ;TRUNNION expect print=2 part=3 filament_mm=123.45678 multiplier=1
//! ;TRUNNION slot=2 part=3,5,11,13 A=70 C=90
//! ;TRUNNION print=2 part=3
//! ;TRUNNION end
//! ```
//!
//! Lengths mm, angles degrees.

use std::fmt;

use super::settings::Interior;

/// One of our marks.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// Once a print, in the header: what was sliced.
    Expect(Expect),
    /// Before each pose change.
    Slot(usize),
    /// Where the print changes.
    Print {
        /// In the order of the plan.
        print: usize,
        /// Its part.
        part: usize,
    },
    /// Behind the last move of the plan.
    End,
    /// One that says nothing to check.
    Other,
    /// One that cannot be read.
    Broken,
}

/// What was sliced for one print.
#[derive(Clone, Debug, PartialEq)]
pub struct Expect {
    /// In the order of the plan.
    pub print: usize,
    /// Its part.
    pub part: usize,
    /// Filament laid down while moving, mm.
    pub filament_mm: f64,
    /// The slicer's own factor on all flow (its extrusion multiplier), 1 for none.
    pub multiplier: f64,
    /// The cross-section that the slicer fills.
    pub bead: Bead,
    /// Widths of its lines, mm, where it states them once for the file and not line by line.
    pub widths: Vec<f64>,
    /// By how much it moves outer walls outward on purpose (XY size compensation), mm; `None` where it does not say.
    pub outset_mm: Option<f64>,
    /// Heights of its first layer and of all others, mm, where it states them once for the file and not layer by layer.
    pub heights_mm: Option<[f64; 2]>,
    /// Diameter of the filament that it counts with, mm; `None` where it does not say.
    pub diameter_mm: Option<f64>,
    /// Walls, solid layers and infill that it was set to.
    pub inside: Interior,
}

impl Expect {
    /// One that says no more than its filament.
    pub fn plain(print: usize, part: usize, filament_mm: f64) -> Self {
        let (bead, widths) = (Bead::Round, Vec::new());
        let (outset_mm, heights_mm, diameter_mm, inside) = (None, None, None, Interior::default());
        Self { print, part, filament_mm, multiplier: 1.0, bead, widths, outset_mm, heights_mm, diameter_mm, inside }
    }
}

/// A slicer's idea of a line's cross-section, `w` wide and `h` high.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bead {
    /// A rectangle with round sides: PrusaSlicer, Slic3r, OrcaSlicer.
    #[default]
    Round,
    /// The rectangle: Cura.
    Square,
    /// The rectangle, and lines as wide as the room that they fill, without a word of it: Cura from 5.0 on.
    Varied,
}

impl Bead {
    /// Its area, mm²; a line as wide as it is high is a round thread, and slicers keep the formula for thinner ones.
    pub fn area(self, width: f64, height: f64) -> f64 {
        use std::f64::consts::FRAC_PI_4;
        match self {
            Self::Square | Self::Varied if width > height => width * height,
            _ => (height * (width - height) + FRAC_PI_4 * height * height).max(0.0),
        }
    }

    /// How marks call those that they name.
    const NAMED: [(Self, &'static str); 2] = [(Self::Square, "square"), (Self::Varied, "varied")];
}

impl fmt::Display for Expect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { print, part, filament_mm, multiplier, bead, widths, outset_mm, heights_mm, diameter_mm, inside } =
            self;
        write!(f, ";TRUNNION expect print={print} part={part} filament_mm={filament_mm:.5} multiplier={multiplier}")?;
        if let Some((_, name)) = Bead::NAMED.iter().find(|(named, _)| named == bead) {
            write!(f, " bead={name}")?;
        }
        if let Some(outset) = outset_mm {
            write!(f, " outset_mm={outset}")?;
        }
        if let Some([first, other]) = heights_mm {
            write!(f, " heights_mm={first},{other}")?;
        }
        if let Some(diameter) = diameter_mm {
            write!(f, " diameter_mm={diameter}")?;
        }
        let Interior { walls, tops, bottoms, infill } = *inside;
        for (name, count) in INTERIOR.into_iter().zip([walls, tops, bottoms, infill.map(u32::from)]) {
            if let Some(count) = count {
                write!(f, " {name}={count}")?;
            }
        }
        if widths.is_empty() {
            return Ok(());
        }
        let widths: Vec<String> = widths.iter().map(f64::to_string).collect();
        write!(f, " widths_mm={}", widths.join(","))
    }
}

/// Names of what a print was set to inside, in the order of [`Interior`]; infill is 1 or 0.
const INTERIOR: [&str; 4] = ["walls", "tops", "bottoms", "infill"];

/// The beginning of every mark, behind the `;`.
const OWN: &[u8] = b"TRUNNION";

/// Our mark in `comment` (without its `;`); `None` where it is none of ours.
pub fn mark(comment: &[u8]) -> Option<Mark> {
    let rest = comment.strip_prefix(OWN)?;
    Some(own(&String::from_utf8_lossy(rest)))
}

/// The mark that begins a print.
pub fn print_mark(print: usize, part: usize) -> String {
    format!(";TRUNNION print={print} part={part}")
}

/// The mark before a pose change: the slot, its setup's parts, and the words of both axes.
pub fn slot_mark(slot: usize, parts: &[usize], [tilt, rotation]: [(u8, f64); 2]) -> String {
    let parts: Vec<String> = parts.iter().map(usize::to_string).collect();
    let (a, c) = (char::from(tilt.0), char::from(rotation.0));
    format!(";TRUNNION slot={slot} part={} {a}={} {c}={}", parts.join(","), tilt.1, rotation.1)
}

/// The first mark of a file.
pub fn version_mark(plan_sha256: &str, profile: &str) -> String {
    format!(";TRUNNION version={} plan={plan_sha256} profile={profile}", env!("CARGO_PKG_VERSION"))
}

/// How far down a file its first mark may stand, bytes.
const HEAD: usize = 1 << 12;

/// The hash of the plan by which a program was made, whether or not it is whole: it begins with the mark of a version.
pub fn made_by(program: &[u8]) -> Option<String> {
    let head = String::from_utf8_lossy(&program[..program.len().min(HEAD)]).into_owned();
    let first = head.lines().find_map(|line| line.strip_prefix(";TRUNNION version="))?;
    first.split(' ').find_map(|word| word.strip_prefix("plan=")).map(str::to_owned)
}

/// The hash of the plan by which a program was finished: it begins with the mark of a version and has that of the end.
pub fn finished_by(program: &[u8]) -> Option<String> {
    let has_end = || program.rsplit(|b| *b == b'\n').any(|line| line.trim_ascii_end() == END_MARK.as_bytes());
    made_by(program).filter(|_| has_end())
}

/// The mark behind the last move of the plan.
pub const END_MARK: &str = ";TRUNNION end";

/// The comment by which servers take a file's closing comments for those of a slicer whose words they know: Moonraker looks for the name
/// of one, then anything, then " on".
pub const WORDS_MARK: &str = "; figures at the end are in the words of PrusaSlicer 2 on purpose: servers read them";

/// What a whole program takes, as servers read it from comments at its end: Moonraker (`metadata.py`, of PrusaSlicer's) time and layers,
/// RepRapFirmware (`FileInfoParser`) time and, as `total layer number`, layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// All moves and waits, s.
    pub seconds: f64,
    /// Layers of all prints together.
    pub layers: usize,
}

impl fmt::Display for Totals {
    /// Whole lines; time in whole seconds, at least one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.seconds.round().max(1.0) as u64;
        let (days, hours, minutes, seconds) = (all / 86_400, all / 3_600 % 24, all / 60 % 60, all % 60);
        write!(f, "; estimated printing time (normal mode) =")?;
        // From the first unit that is not 0 on.
        for (count, name, worth) in [(days, "d", 86_400), (hours, "h", 3_600), (minutes, "m", 60), (seconds, "s", 1)] {
            if all >= worth {
                write!(f, " {count}{name}")?;
            }
        }
        let layers = self.layers;
        writeln!(f, "\n; total layers count = {layers}\n; total layer number: {layers}")
    }
}

/// What a mark states of a print's interior; `None` where a count is none.
fn interior<'a>(value: impl Fn(&str) -> Option<&'a str>) -> Option<Interior> {
    let counts = INTERIOR.map(|key| value(key).map(|count| count.parse::<u32>().ok()));
    let all = counts.iter().all(|count| *count != Some(None));
    let [walls, tops, bottoms, infill] = counts.map(Option::flatten);
    all.then_some(Interior { walls, tops, bottoms, infill: infill.map(|share| share > 0) })
}

fn own(text: &str) -> Mark {
    let value = |key: &str| text.split_ascii_whitespace().find_map(|w| w.strip_prefix(key)?.strip_prefix('='));
    let whole = |key: &str| value(key).and_then(|v| v.parse::<usize>().ok());
    let number = |key: &str| value(key).and_then(|v| v.parse::<f64>().ok()).filter(|v| v.is_finite());
    let first = text.split_ascii_whitespace().next().unwrap_or_default();
    if first == "end" {
        return Mark::End;
    }
    if first == "expect" {
        // Files of earlier versions say nothing of a multiplier.
        let multiplier = if value("multiplier").is_some() { number("multiplier") } else { Some(1.0) };
        let bead = match value("bead") {
            None => Some(Bead::Round),
            Some(word) => Bead::NAMED.iter().find(|(_, name)| *name == word).map(|(bead, _)| *bead),
        };
        let length = |w: &str| w.parse::<f64>().ok().filter(|w| w.is_finite() && *w > 0.0);
        let lengths =
            |key| value(key).unwrap_or_default().split_terminator(',').map(length).collect::<Option<Vec<f64>>>();
        let (widths, heights, diameters) = (lengths("widths_mm"), lengths("heights_mm"), lengths("diameter_mm"));
        let Some(inside) = interior(value) else { return Mark::Broken };
        let (Some(print), Some(part), Some(filament_mm)) = (whole("print"), whole("part"), number("filament_mm"))
        else {
            return Mark::Broken;
        };
        let expect = Expect { outset_mm: number("outset_mm"), inside, ..Expect::plain(print, part, filament_mm) };
        return match (multiplier, bead, widths, heights.as_deref(), diameters.as_deref()) {
            (
                Some(multiplier),
                Some(bead),
                Some(widths),
                Some(heights @ ([] | [_, _])),
                Some(diameters @ ([] | [_])),
            ) => {
                let heights_mm = heights.first_chunk().copied();
                let diameter_mm = diameters.first().copied();
                Mark::Expect(Expect { multiplier, bead, widths, heights_mm, diameter_mm, ..expect })
            }
            _ => Mark::Broken,
        };
    }
    if first.starts_with("slot=") {
        return whole("slot").map_or(Mark::Broken, Mark::Slot);
    }
    if first.starts_with("print=") {
        return match (whole("print"), whole("part")) {
            (Some(print), Some(part)) => Mark::Print { print, part },
            _ => Mark::Broken,
        };
    }
    Mark::Other
}

/// What a line is for, as slicers name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Role {
    /// Not said.
    #[default]
    Unknown,
    /// The visible wall.
    OuterWall,
    /// Walls inside it.
    InnerWall,
    /// Walls that hang over.
    Overhang,
    /// Sparse infill.
    Infill,
    /// Solid infill and skins.
    Solid,
    /// Across a gap.
    Bridge,
    /// What is too narrow for whole lines.
    Gap,
    /// Smoothing what is there.
    Ironing,
    /// Supports and their interfaces.
    Support,
    /// Skirt, brim, wipe tower, raft.
    Adhesion,
}

impl Role {
    /// Its name in a sentence or a legend.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "not stated",
            Self::OuterWall => "outer wall",
            Self::InnerWall => "inner wall",
            Self::Overhang => "overhanging wall",
            Self::Infill => "infill",
            Self::Solid => "solid infill",
            Self::Bridge => "bridge",
            Self::Gap => "gap",
            Self::Ironing => "ironing",
            Self::Support => "support",
            Self::Adhesion => "skirt and brim",
        }
    }
}

/// What a slicer's comment says of the lines that follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hint {
    /// `TYPE:External perimeter`, `FEATURE: Outer wall`
    Role(Role),
    /// `WIDTH:0.45`, `LINE_WIDTH: 0.45`
    Width(f64),
    /// `HEIGHT:0.2`, `LAYER_HEIGHT: 0.2`
    Height(f64),
    /// `LAYER_CHANGE`, `LAYER:3`
    Layer,
}

/// The hint in `comment` (without its `;`); `None` for the many that hold none.
pub fn hint(comment: &[u8]) -> Option<Hint> {
    let comment = comment.strip_prefix(b" ").unwrap_or(comment);
    let text = || std::str::from_utf8(comment).ok();
    let after = |keys: [&str; 2]| keys.iter().find_map(|key| text()?.strip_prefix(key)).map(str::trim);
    let number = |keys| after(keys)?.parse::<f64>().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
    match comment.first()? {
        b'T' | b'F' => after(["TYPE:", "FEATURE:"]).map(|name| Hint::Role(role(name))),
        b'W' => number(["WIDTH:", "WIDTH :"]).map(Hint::Width),
        b'H' => number(["HEIGHT:", "HEIGHT :"]).map(Hint::Height),
        b'C' if comment.starts_with(b"CHANGE_LAYER") => Some(Hint::Layer),
        b'L' if comment.starts_with(b"LINE_WIDTH:") => number(["LINE_WIDTH:", "LINE_WIDTH :"]).map(Hint::Width),
        b'L' if comment.starts_with(b"LAYER_HEIGHT:") => number(["LAYER_HEIGHT:", "LAYER_HEIGHT :"]).map(Hint::Height),
        b'L' if comment.starts_with(b"LAYER_CHANGE") || comment.starts_with(b"LAYER:") => Some(Hint::Layer),
        _ => None,
    }
}

/// The role of a slicer's name for it, in the words of PrusaSlicer, Cura, OrcaSlicer and their kin.
pub fn role(name: &str) -> Role {
    let name = name.to_ascii_lowercase();
    let has = |part: &str| name.contains(part);
    if has("support") {
        Role::Support
    } else if has("skirt") || has("brim") || has("tower") || has("raft") {
        Role::Adhesion
    } else if has("overhang") {
        Role::Overhang
    } else if has("bridge") {
        Role::Bridge
    } else if has("ironing") {
        Role::Ironing
    } else if has("gap") || has("thin") {
        Role::Gap
    } else if has("external") || has("outer") {
        Role::OuterWall
    } else if has("perimeter") || has("wall") {
        Role::InnerWall
    } else if has("solid") || has("skin") || has("surface") || has("top") || has("bottom") {
        Role::Solid
    } else if has("fill") || has("infill") {
        Role::Infill
    } else {
        Role::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_marks_are_read_as_they_are_written() {
        let expect = Expect {
            print: 2,
            part: 3,
            filament_mm: 1.5,
            multiplier: 0.95,
            bead: Bead::Square,
            widths: vec![0.4, 0.55],
            outset_mm: Some(-0.1),
            heights_mm: Some([0.35, 0.3]),
            diameter_mm: Some(1.73),
            inside: Interior { walls: Some(3), tops: Some(0), bottoms: None, infill: Some(true) },
        };
        assert_eq!(mark(&expect.to_string().as_bytes()[1..]), Some(Mark::Expect(expect.clone())));
        let varied = Expect { bead: Bead::Varied, ..expect.clone() };
        assert_eq!(mark(&varied.to_string().as_bytes()[1..]), Some(Mark::Expect(varied)));
        let old = mark(b"TRUNNION expect print=2 part=3 filament_mm=1.5");
        assert_eq!(
            old,
            Some(Mark::Expect(Expect {
                multiplier: 1.0,
                bead: Bead::Round,
                widths: Vec::new(),
                outset_mm: None,
                heights_mm: None,
                diameter_mm: None,
                inside: Interior::default(),
                ..expect
            }))
        );
        let wrong =
            ["bead=round", "multiplier=x", "heights_mm=0.2", "heights_mm=0.2,-1", "diameter_mm=0", "widths_mm=x"];
        for wrong in wrong.into_iter().chain(["walls=-1", "tops=x", "infill=0.2"]) {
            let text = format!("TRUNNION expect print=2 part=3 filament_mm=1.5 {wrong}");
            assert_eq!(mark(text.as_bytes()), Some(Mark::Broken), "{wrong}");
        }
        let slot = slot_mark(2, &[3, 5], [(b'A', 70.0), (b'C', -90.0)]);
        assert_eq!(slot, ";TRUNNION slot=2 part=3,5 A=70 C=-90");
        assert_eq!(mark(&slot.as_bytes()[1..]), Some(Mark::Slot(2)));
        assert_eq!(mark(&print_mark(1, 4).as_bytes()[1..]), Some(Mark::Print { print: 1, part: 4 }));
        assert_eq!(mark(b"TRUNNION print=x part=4"), Some(Mark::Broken));
        assert_eq!(mark(&END_MARK.as_bytes()[1..]), Some(Mark::End));
        assert_eq!(mark(&version_mark("ab", "c").as_bytes()[1..]), Some(Mark::Other));
        let whole = format!("{}\nG28\n{END_MARK}\nM84\n", version_mark("ab", "c"));
        assert_eq!(finished_by(whole.as_bytes()).as_deref(), Some("ab"));
        // Torn off, or sliced and not rewritten.
        assert_eq!(finished_by(&whole.as_bytes()[..whole.len() - 8]), None);
        assert_eq!(finished_by(format!("; a slicer's\nG28\n{END_MARK}\n").as_bytes()), None);
        assert_eq!(mark(b"TYPE:Skirt"), None);
    }

    #[test]
    fn totals_are_written_as_servers_read_them() {
        let time = |seconds| Totals { seconds, layers: 7 }.to_string().lines().next().unwrap().to_owned();
        assert_eq!(time(90_061.4), "; estimated printing time (normal mode) = 1d 1h 1m 1s");
        assert_eq!(time(3_600.0), "; estimated printing time (normal mode) = 1h 0m 0s");
        assert_eq!(time(59.6), "; estimated printing time (normal mode) = 1m 0s");
        assert_eq!(time(0.1), "; estimated printing time (normal mode) = 1s");
        let text = Totals { seconds: 5.0, layers: 7 }.to_string();
        assert!(text.ends_with("\n; total layers count = 7\n; total layer number: 7\n"), "{text}");
    }

    #[test]
    fn slicers_say_it_each_in_their_words() {
        for (text, wanted) in [
            ("TYPE:External perimeter", Role::OuterWall),
            ("TYPE:Perimeter", Role::InnerWall),
            ("TYPE:Overhang perimeter", Role::Overhang),
            ("TYPE:Internal infill", Role::Infill),
            ("TYPE:Solid infill", Role::Solid),
            ("TYPE:Top solid infill", Role::Solid),
            ("TYPE:Bridge infill", Role::Bridge),
            ("TYPE:Gap fill", Role::Gap),
            ("TYPE:Skirt/Brim", Role::Adhesion),
            ("TYPE:Support material interface", Role::Support),
            ("TYPE:Custom", Role::Unknown),
            ("TYPE:WALL-OUTER", Role::OuterWall),
            ("TYPE:SKIN", Role::Solid),
            ("TYPE:FILL", Role::Infill),
            (" FEATURE: Outer wall", Role::OuterWall),
            (" FEATURE: Bottom surface", Role::Solid),
            ("TYPE:Ironing", Role::Ironing),
        ] {
            assert_eq!(hint(text.as_bytes()), Some(Hint::Role(wanted)), "{text}");
        }
        assert_eq!(hint(b"WIDTH:0.45"), Some(Hint::Width(0.45)));
        assert_eq!(hint(b" LINE_WIDTH: 0.42"), Some(Hint::Width(0.42)));
        assert_eq!(hint(b"HEIGHT:0.2"), Some(Hint::Height(0.2)));
        assert_eq!(hint(b" LAYER_HEIGHT: 0.2"), Some(Hint::Height(0.2)));
        assert_eq!(
            (hint(b"LAYER_CHANGE"), hint(b"LAYER:3"), hint(b" CHANGE_LAYER")),
            (Some(Hint::Layer), Some(Hint::Layer), Some(Hint::Layer))
        );
        assert_eq!((hint(b"LAYER_COUNT:3"), hint(b"WIDTH:x"), hint(b"WIDTH:-1"), hint(b"")), (None, None, None, None));
    }
}
