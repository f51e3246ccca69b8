//! The program, line by line. What it says becomes straight motions, and on the way these checks are made of it: words, heat, filament,
//! limits, turns.

use super::machine::Machine;
use super::maths::{V, length, lerp, steps, sub};
use super::opinion::Check;
use std::f64::consts::TAU;
use std::ops::Range;

/// The print number of what lies outside of all prints: a prime line of the start code, ways between prints.
pub const NONE: usize = usize::MAX;

/// One straight move, or one chord of an arc: X, Y, Z, tilt and rotation, NaN where the machine has not been homed to a known place.
pub struct Motion {
    pub line: usize,
    from: [f64; 5],
    to: [f64; 5],
    /// Filament that it pushes, mm.
    pub e: f64,
    pub print: usize,
    /// Whether it is of a support, a skirt or a brim, by the comment before it.
    pub extra: bool,
}

impl Motion {
    pub fn tip(&self, t: f64) -> V {
        let [x, y, z, ..] = lerp(self.from, self.to, t);
        [x, y, z]
    }

    pub fn words(&self, t: f64) -> [f64; 2] {
        let [.., tilt, rotation] = lerp(self.from, self.to, t);
        [tilt, rotation]
    }

    pub fn way(&self) -> f64 {
        length(sub(self.tip(1.0), self.tip(0.0)))
    }

    pub fn turns(&self) -> bool {
        self.from[3..] != self.to[3..]
    }

    /// Whether an axis moves to a known place.
    fn moves(&self, mut axes: Range<usize>) -> bool {
        axes.any(|i| self.to[i] != self.from[i] && !self.to[i].is_nan())
    }

    pub fn is_known(&self) -> bool {
        !self.tip(0.0).iter().chain(&self.tip(1.0)).any(|x| x.is_nan())
    }

    pub fn is_bead(&self) -> bool {
        self.e > 0.0 && self.way() > 1e-9
    }
}

#[derive(Default)]
struct Heater {
    target: f64,
    waited: bool,
}

/// What lines set for the lines behind them.
#[derive(Default)]
struct State {
    line: usize,
    at: [f64; 5],
    homed: [bool; 3],
    e_at: f64,
    feed: f64,
    relative: bool,
    relative_e: bool,
    inverse_time: bool,
    nozzle: Heater,
    bed: Heater,
    /// Filament that is pulled back, mm, and whether the firmware has pulled it by itself.
    pulled: f64,
    firmware_pulled: bool,
    /// Filament that may be pushed beyond what was pulled, mm.
    push_from: f64,
    print: usize,
    extra: bool,
    printed: bool,
    ended: bool,
}

/// What is read of a program.
#[derive(Default)]
pub struct Program {
    pub motions: Vec<Motion>,
    /// Marks with their lines.
    pub marks: Vec<(usize, String)>,
    /// Number of lines that move anything.
    pub moves: usize,
    pub arcs: bool,
}

struct Reader<'a> {
    machine: &'a Machine,
    words: Check,
    heat: Check,
    filament: Check,
    limits: Check,
    turns: Check,
    program: Program,
    state: State,
}

/// Reads a program and makes the checks that need nothing but its lines.
pub fn read(machine: &Machine, text: &str) -> (Program, [Check; 5]) {
    let [words, heat, filament, limits, turns] = ["words", "heat", "filament", "limits", "turns"].map(Check::new);
    let at = [f64::NAN, f64::NAN, f64::NAN, machine.axes[0].zero, machine.axes[1].zero];
    let (homed, pulled) = ([machine.is_rs274(); 3], machine.retract);
    let state = State { at, homed, pulled, print: NONE, ..State::default() };
    let mut reader = Reader { machine, words, heat, filament, limits, turns, program: Program::default(), state };
    for (index, raw) in text.lines().enumerate() {
        reader.state.line = index + 1;
        let (code, comment) = raw.split_once(';').unwrap_or((raw, ""));
        let code = reader.without_parentheses(code);
        reader.mark(comment.trim());
        if !code.trim().is_empty() {
            reader.command(code.trim());
        }
    }
    reader.end();
    (reader.program, [reader.words, reader.heat, reader.filament, reader.limits, reader.turns])
}

impl Reader<'_> {
    fn end(&mut self) {
        let State { line, ended, printed, nozzle, bed, .. } = &self.state;
        self.words.figure = format!("{line} lines, {} moves", self.program.moves);
        let on = nozzle.target > 0.0 || bed.target > 0.0;
        self.heat.require(!on, || "a heater is on at the end");
        self.words.require(*ended, || "the end mark is missing");
        self.words.require(*printed, || "nothing is printed");
        if !self.machine.heats {
            self.heat = Check::without("heat", "the firmware heats nothing");
        }
    }

    fn strange(&mut self, what: impl Into<String>) {
        self.words.line(self.state.line, false, || what);
    }

    fn without_parentheses(&mut self, code: &str) -> String {
        if code.contains(['(', ')']) && !self.machine.is_rs274() {
            self.strange("this firmware does not read parentheses as a comment");
        }
        let mut depth = 0;
        let keep = |c: &char| {
            depth += i32::from(*c == '(');
            let outside = depth == 0;
            depth -= i32::from(*c == ')');
            outside
        };
        code.chars().filter(keep).collect()
    }

    fn mark(&mut self, comment: &str) {
        if let Some(kind) = comment.strip_prefix("TYPE:") {
            let kind = kind.to_lowercase();
            self.state.extra = ["support", "skirt", "brim"].iter().any(|word| kind.contains(word));
        }
        let Some(mark) = comment.strip_prefix("TRUNNION ") else { return };
        if let Some(rest) = mark.strip_prefix("print=") {
            let digits = rest.split(' ').next().unwrap_or("");
            (self.state.print, self.state.extra) = (digits.parse().unwrap_or(NONE), false);
        } else if mark == "end" {
            self.state.ended = true;
        } else if !mark.starts_with("slot=") {
            return;
        }
        self.program.marks.push((self.state.line, mark.to_owned()));
    }

    /// Whether a line is one of the profile's own, numbers in place of `{..}`.
    fn is_own(&self, code: &str) -> bool {
        let fits = |own: &String| match own.split_once('{') {
            None => own == code,
            Some((head, tail)) => {
                let tail = tail.split_once('}').map_or("", |(_, tail)| tail);
                let middle = code.strip_prefix(head).and_then(|rest| rest.strip_suffix(tail));
                middle.is_some_and(|middle| middle.parse::<f64>().is_ok())
            }
        };
        let own = if self.state.ended { &self.machine.end } else { &self.machine.start };
        own.iter().any(fits)
    }

    fn command(&mut self, code: &str) {
        let name = code.split_whitespace().next().unwrap_or("").to_owned();
        if name == "MANUAL_STEPPER" && code.contains("MOVE=") {
            return self.stepper(code);
        }
        let free_text = ["M117", "M118", "M486", "M73"].contains(&name.as_str());
        let Some(words) = (if free_text { Some(Vec::new()) } else { words(code) }) else {
            if !self.is_own(code) && !self.machine.allow.contains(&name) {
                self.strange(format!("{code} is not understood"));
            } else if !self.state.printed {
                self.state.homed = [true; 3];
            }
            return;
        };
        let key = if free_text { name } else { words.first().map_or(String::new(), |w| format!("{}{}", w.0, w.1)) };
        let word = |letter: char| words.iter().skip(1).find(|w| w.0 == letter).map(|w| w.1);
        let at_end = ["M104", "M140", "M106", "M107", "M73"].contains(&key.as_str());
        if self.state.ended && !at_end && !self.is_own(code) {
            self.strange(format!("{code} behind the end mark is not of the profile's end code"));
        }
        let (machine, state) = (self.machine, &mut self.state);
        match key.as_str() {
            "G0" | "G1" => {
                let (to, e) = self.target(&words);
                self.move_to(to, e);
            }
            "G2" | "G3" => self.arc(&words, key == "G2"),
            "G28" => self.home(&words),
            "G90" | "G91" => {
                state.relative = key == "G91";
                state.relative_e = if machine.g90_switches { state.relative } else { state.relative_e };
            }
            "M82" | "M83" => state.relative_e = key == "M83",
            "G92" if words.len() == 2 && words[1].0 == machine.extruder => state.e_at = words[1].1,
            "G93" | "G94" if machine.firmware == "linuxcnc" => state.inverse_time = key == "G93",
            "G10" | "G11" if words.len() == 1 && machine.heats => state.firmware_pulled = key == "G10",
            "M104" | "M109" | "M140" | "M190" => self.heater(&key, word('S').or(word('R'))),
            "M116" => [&mut state.nozzle, &mut state.bed].into_iter().for_each(|h| h.waited = h.target > 0.0),
            "M220" | "M221" if word('S') == Some(100.0) => {}
            "M486" if !code.contains(['P', 'C']) => {}
            "G21" | "G4" | "M73" | "M105" | "M106" | "M107" | "M117" | "M118" | "M201" | "M203" | "M204" | "M205"
            | "M207" | "M208" | "M400" | "M572" | "M900" | "T0" => {}
            _ if self.is_own(code) || machine.allow.contains(&key) => {}
            _ => self.strange(format!("{code} is unknown, or may not be here")),
        }
    }

    fn heater(&mut self, key: &str, target: Option<f64>) {
        let state = &mut self.state;
        let heater = if key.ends_with("40") || key.ends_with("90") { &mut state.bed } else { &mut state.nozzle };
        let waits = key == "M109" || key == "M190";
        let Some(target) = target else {
            if waits && self.machine.firmware == "klipper" {
                *heater = Heater::default();
            }
            return;
        };
        *heater = Heater { target, waited: target > 0.0 && (waits || heater.waited) };
        let text = || format!("heats to {target} degrees behind the end mark");
        self.heat.line(state.line, !state.ended || target <= 0.0, text);
    }

    fn home(&mut self, words: &[(char, f64)]) {
        if self.state.printed {
            self.strange("homes while something is on the table");
        }
        for (i, axis) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if words.len() == 1 || words.iter().any(|w| w.0 == axis) {
                (self.state.homed[i], self.state.at[i]) = (true, f64::NAN);
            }
        }
    }

    /// A turn of the table by a command with words such as `MOVE=90`.
    fn stepper(&mut self, code: &str) {
        let (words, axes) = (|| code.split_whitespace().skip(1), &self.machine.axes);
        let value = |key: &str| words().find_map(|word| word.strip_prefix(key));
        let plain = words().all(|w| ["STEPPER=", "MOVE=", "SPEED="].iter().any(|key| w.starts_with(key)));
        let [to, speed] = ["MOVE=", "SPEED="]
            .map(|key| value(key).and_then(|value| value.parse().ok().filter(|n: &f64| n.is_finite())));
        let axis = value("STEPPER=").and_then(|name| axes.iter().position(|a| a.stepper.as_deref() == Some(name)));
        let (true, Some(to), Some(speed), Some(axis)) = (plain, to, speed, axis) else {
            return self.strange(format!("{code} is not understood"));
        };
        let mut target = self.state.at;
        target[3 + axis] = to;
        let feed = std::mem::replace(&mut self.state.feed, speed * 60.0);
        self.move_to(target, 0.0);
        self.state.feed = feed;
        self.program.moves += 1;
    }

    /// The target of a move's words and the filament that it pushes.
    fn target(&mut self, words: &[(char, f64)]) -> ([f64; 5], f64) {
        let (mut to, mut e) = (self.state.at, 0.0);
        for &(letter, value) in &words[1..] {
            if let Some(i) = self.machine.ranges().iter().position(|(l, _)| *l == letter) {
                let by_command = i > 2 && self.machine.axes[i - 3].stepper.is_some();
                if by_command || (self.state.relative && to[i].is_nan()) {
                    self.strange(format!("{letter}{value} cannot be followed"));
                }
                to[i] = if self.state.relative { to[i] + value } else { value };
            } else if letter == self.machine.extruder {
                e = if self.state.relative_e { value } else { value - self.state.e_at };
                self.state.e_at += e;
            } else if letter == 'F' {
                self.state.feed = value;
            } else if !['I', 'J'].contains(&letter) || words[0].1 < 2.0 {
                self.strange(format!("{letter}{value} is not understood"));
            }
        }
        self.program.moves += usize::from(to != self.state.at || e != 0.0);
        (to, e)
    }

    /// An arc in the XY plane as chords that leave it by at most 0.003 mm.
    fn arc(&mut self, words: &[(char, f64)], clockwise: bool) {
        let value = |letter: char| words.iter().find(|w| w.0 == letter).map_or(0.0, |w| w.1);
        let (from, (to, e)) = (self.state.at, self.target(words));
        let centre = [from[0] + value('I'), from[1] + value('J')];
        let [start, end] = [from, to].map(|p| (p[1] - centre[1]).atan2(p[0] - centre[0]));
        let radii = [from, to].map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1]));
        if !((radii[0] - radii[1]).abs() < 0.02 && radii[0] > 0.003 && from[3..] == to[3..]) {
            return self.strange("an arc whose ends are not equally far from its centre");
        }
        self.program.arcs = true;
        let sign = if clockwise { -1.0 } else { 1.0 };
        let angle = (sign * (end - start)).rem_euclid(TAU);
        let angle = if angle < 1e-9 { TAU } else { angle };
        let count = steps(angle, 2.0 * (1.0 - 0.003 / radii[0]).acos());
        for i in 1..=count {
            let t = i as f64 / count as f64;
            let (sin, cos) = (start + sign * angle * t).sin_cos();
            let (radius, mut chord) = (radii[0] + (radii[1] - radii[0]) * t, lerp(from, to, t));
            (chord[0], chord[1]) = (centre[0] + radius * cos, centre[1] + radius * sin);
            self.move_to(if i == count { to } else { chord }, e / count as f64);
        }
    }

    fn move_to(&mut self, to: [f64; 5], e: f64) {
        let (line, machine) = (self.state.line, self.machine);
        if to[..3].iter().any(|x| x.abs() > 1e4) || to[3..].iter().any(|x| x.abs() > 1e5) {
            return self.limits.fail(format!("line {line}: a move so far that nothing else is looked at"));
        }
        if to[3..] != self.state.at[3..] {
            self.state.print = NONE;
        }
        let motion = Motion { line, from: self.state.at, to, e, print: self.state.print, extra: self.state.extra };
        if self.state.ended && !machine.end.iter().any(|l| l.starts_with("G0") || l.starts_with("G1")) {
            self.strange("moves behind the end mark");
        }
        self.check_limits(&motion);
        if motion.turns() {
            self.check_turn(&motion);
        }
        self.check_filament(&motion);
        self.state.at = to;
        if motion.from != motion.to || e != 0.0 {
            self.program.motions.push(motion);
        }
    }

    /// The feed of a move over some way, or of a turn over some degrees, a minute.
    fn feed_over(&self, way: f64) -> f64 {
        if self.state.inverse_time { self.state.feed * way } else { self.state.feed }
    }

    fn check_limits(&mut self, motion: &Motion) {
        let (line, machine) = (motion.line, self.machine);
        for (i, (axis, [low, high])) in machine.ranges().into_iter().enumerate() {
            let value = motion.to[i];
            self.limits.line(line, !(value < low - 1e-6 || value > high + 1e-6), || {
                format!("{axis}{value} must be between {low} and {high}")
            });
            self.limits.line(line, i > 2 || self.state.homed[i] || !motion.moves(i..i + 1), || {
                format!("{axis} moves before it was homed")
            });
        }
        let feed = self.feed_over(motion.way());
        self.limits.line(line, !(motion.moves(0..3) && (feed > machine.max_feed + 1e-6 || feed <= 0.0)), || {
            format!("F{feed} must be above 0 and at most {}", machine.max_feed)
        });
    }

    fn check_turn(&mut self, motion: &Motion) {
        let (line, turned) = (motion.line, [3, 4].map(|i| (motion.to[i] - motion.from[i]).abs()));
        self.turns.line(line, !(motion.moves(0..3) || turned.iter().all(|by| *by > 0.0)), || {
            "an axis of the table moves with others in one line: its rate is unknown".to_owned()
        });
        self.turns.line(line, motion.e == 0.0, || "the table turns while filament flows");
        for (by, axis) in turned.into_iter().zip(&self.machine.axes).filter(|(by, _)| *by > 0.0) {
            let rate = self.feed_over(by) / 60.0;
            self.turns.line(line, rate > 0.0 && rate <= axis.rate + 1e-6, || {
                format!("{rate} degrees a second, at most {}", axis.rate)
            });
        }
        let State { printed, firmware_pulled, pulled, .. } = self.state;
        self.turns.line(line, !printed || firmware_pulled || pulled >= 0.9 * self.machine.retract, || {
            format!("the table turns with only {pulled:.2} mm of filament pulled back")
        });
        self.state.push_from = self.machine.prime;
    }

    fn check_filament(&mut self, motion: &Motion) {
        if motion.e > 0.0 && self.machine.heats {
            self.check_heat(motion.line);
        }
        let (line, state) = (motion.line, &mut self.state);
        let (pulled, most) = (state.pulled, 0.3 + state.push_from);
        state.pulled -= motion.e;
        if !motion.is_bead() {
            let text = || format!("{:.2} mm more pushed than was pulled", -state.pulled);
            return self.filament.line(line, state.pulled >= -most, text);
        }
        state.printed = true;
        self.filament.line(line, !state.firmware_pulled && (-most..=0.3).contains(&pulled), || {
            format!("printed with {pulled:.2} mm of filament pulled back")
        });
        (state.pulled, state.push_from) = (0.0, 0.0);
    }

    fn check_heat(&mut self, line: usize) {
        let (State { nozzle, bed, .. }, machine) = (&self.state, self.machine);
        let heats_bed = machine.start.iter().any(|l| l.starts_with("M140") || l.starts_with("M190"));
        let nozzle_ready = nozzle.waited && nozzle.target >= machine.min_extrude;
        let bed_ready = !heats_bed || (bed.waited && bed.target > 0.0);
        for (name, heater, ready) in [("nozzle", nozzle, nozzle_ready), ("bed", bed, bed_ready)] {
            self.heat.line(line, ready, || {
                format!("filament is pushed, the {name} is set to {} and was not waited for", heater.target)
            });
        }
    }
}

/// Letters and numbers of a line; none where it is anything else, or a letter comes twice.
fn words(code: &str) -> Option<Vec<(char, f64)>> {
    let (mut found, mut rest) = (Vec::<(char, f64)>::new(), code);
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_uppercase() || found.iter().skip(1).any(|w| w.0 == letter) {
            return None;
        }
        let tail = &rest[1..];
        let end = tail.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(tail.len());
        found.push((letter, if end == 0 && !found.is_empty() { 0.0 } else { tail[..end].parse().ok()? }));
        rest = tail[end..].trim_start();
    }
    Some(found)
}
