//! What M-codes have set and left in force: heat, fans, limits.
//!
//! Prints of one setup take turns layer by layer, and prints of one plan may be sliced with different settings. Each must
//! find at its turn what its own slicer left it with, not what the print before it set.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::gcode::meaning::{Effect, Firmware, Heater, effect, index_letter};
use crate::gcode::{Command, LineKind, LineRules, ParsedLine};
use crate::profile::JointSettings;

/// What a line sets.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Nozzle(u32),
    Bed,
    Chamber,
    Fan(u32),
    /// Limits, flow compensation: what stays until the next such line; with the extruder or pin it is for.
    Setting(Command, u32),
    /// The same by name, its first two words.
    Named(String),
}

/// What is in force, each with its words.
#[derive(Clone, Debug, Default)]
pub(super) struct Modal(BTreeMap<Key, Words>);

/// Numbers by letter, or the whole line where it is a name and its values.
#[derive(Clone, Debug, PartialEq)]
enum Words {
    Letters(BTreeMap<u8, f64>),
    Line(String),
}

impl Modal {
    /// The heat that a print begins with.
    pub(super) fn heated(nozzle: Option<f64>, bed: Option<f64>) -> Self {
        let mut modal = Self::default();
        for (key, value) in [(Key::Nozzle(0), nozzle), (Key::Bed, bed)] {
            if let Some(celsius) = value {
                modal.set(key, [(b'S', celsius)]);
            }
        }
        modal
    }

    /// The same, but with the first layers' own fan and nozzle.
    pub(super) fn with_joint(mut self, joint: &JointSettings) -> Self {
        if let Some(share) = joint.fan {
            self.set(Key::Fan(0), [(b'S', fan_words(share))]);
        }
        if let Some(celsius) = joint.nozzle_c {
            self.set(Key::Nozzle(0), [(b'S', celsius)]);
        }
        self
    }

    /// Takes note of a line in the words of `firmware` that is passed on.
    pub(super) fn note(&mut self, firmware: Firmware, line: &[u8]) {
        let mut parsed = ParsedLine::default();
        if parsed.read(line).is_err() {
            return;
        }
        match effect(firmware, &parsed) {
            Effect::Heat { heater, target_c: Some(celsius), .. } => {
                let key = match heater {
                    Heater::Nozzle => Key::Nozzle(0),
                    Heater::OtherNozzle(tool) => Key::Nozzle(tool),
                    Heater::Bed => Key::Bed,
                    Heater::Chamber => Key::Chamber,
                };
                self.set(key, [(b'S', celsius)]);
            }
            // A hundredth of a step of the 255 is below what any fan is set to.
            Effect::Fan { index, share } => self.set(Key::Fan(index), [(b'S', fan_words(share))]),
            Effect::Setting | Effect::Factor { .. } => self.setting(&parsed),
            _ => {}
        }
    }

    fn setting(&mut self, parsed: &ParsedLine) {
        let Some(&command) = parsed.commands.first() else {
            let line = String::from_utf8_lossy(&parsed.text).into_owned();
            let name: Vec<&str> = line.split_ascii_whitespace().take(1).collect();
            let key = Key::Named(name.join(" ").to_ascii_uppercase());
            self.0.insert(key, Words::Line(line));
            return;
        };
        let index = index_letter(command).and_then(|letter| parsed.value(letter)).unwrap_or(0.0) as u32;
        let words = parsed.words.iter().filter_map(|w| Some((w.letter, w.value?)));
        self.set(Key::Setting(command, index), words);
    }

    fn set(&mut self, key: Key, words: impl IntoIterator<Item = (u8, f64)>) {
        let known = self.0.entry(key).or_insert_with(|| Words::Letters(BTreeMap::new()));
        if let Words::Letters(known) = known {
            known.extend(words);
        }
    }

    /// The lines, in Marlin's words, that bring what is in force to what `wanted` says; what `wanted` has never set is left
    /// alone, but fans are off until somebody sets them.
    pub(super) fn change_to(&self, wanted: &Self) -> Vec<String> {
        let mut wanted = wanted.0.clone();
        for key in self.0.keys().filter(|key| matches!(key, Key::Fan(_))) {
            let off = || Words::Letters(BTreeMap::from([(b'S', 0.0)]));
            wanted.entry(key.clone()).or_insert_with(off);
        }
        let new = |key: &Key, words: &Words| match (self.0.get(key), words) {
            (Some(Words::Letters(now)), Words::Letters(then)) => then.iter().any(|(l, v)| now.get(l) != Some(v)),
            (now, then) => now != Some(then),
        };
        wanted.iter().filter(|(key, words)| new(key, words)).map(|(key, words)| line(key, words)).collect()
    }
}

/// A fan's share of the 255.
fn fan_words(share: f64) -> f64 {
    (share * 25500.0).round() / 100.0
}

/// Whether the first layers have what `line` sets from `[joint]`.
pub(super) fn is_joints(joint: &JointSettings, firmware: Firmware, line: &[u8]) -> bool {
    let mut parsed = ParsedLine::default();
    if parsed.read(line).is_err() {
        return false;
    }
    match effect(firmware, &parsed) {
        Effect::Fan { index: 0, .. } => joint.fan.is_some(),
        Effect::Heat { heater: Heater::Nozzle, .. } => joint.nozzle_c.is_some(),
        _ => false,
    }
}

/// The command that sets `words`; a nozzle that changes is waited for.
fn line(key: &Key, words: &Words) -> String {
    let letters = match words {
        Words::Line(line) => return line.clone(),
        Words::Letters(letters) => letters,
    };
    let text: String = letters.iter().map(|(letter, value)| format!(" {}{value}", char::from(*letter))).collect();
    match key {
        Key::Fan(0) if letters.get(&b'S') == Some(&0.0) => "M107".to_owned(),
        Key::Fan(0) => format!("M106{text}"),
        Key::Fan(index) => format!("M106 P{index}{text}"),
        Key::Nozzle(0) => format!("M109{text}"),
        Key::Nozzle(tool) => format!("M109 T{tool}{text}"),
        Key::Bed => format!("M140{text}"),
        Key::Chamber => format!("M141{text}"),
        Key::Setting(command, _) => format!("{command}{text}"),
        Key::Named(name) => name.clone(),
    }
}

/// `line`, written for one firmware, in the words of another: as it stands where it means the same there, heat and fans spelt
/// anew, `None` where there is nothing like it.
pub(super) fn translated(line: &[u8], from: Firmware, to: Firmware) -> Option<Cow<'_, [u8]>> {
    if !to.is_printer() {
        return Some(Cow::Borrowed(line));
    }
    let mut parsed = ParsedLine::default();
    if parsed.read(line).is_err() {
        return (from == to).then_some(Cow::Borrowed(line));
    }
    let meant = effect(from, &parsed);
    if from == to || (meant == effect(to, &parsed) && !matches!(meant, Effect::Hazard(_))) {
        return Some(spelt(line, &parsed, to));
    }
    let text = match meant {
        Effect::Heat { heater: Heater::Nozzle, target_c: Some(c), waits } => {
            format!("M10{} S{c}", if waits { 9 } else { 4 })
        }
        Effect::Heat { heater: Heater::Bed, target_c: Some(c), waits } => {
            format!("M1{}0 S{c}", if waits { 9 } else { 4 })
        }
        Effect::Fan { index: 0, share } => format!("M106 S{}", fan_words(share)),
        _ => return None,
    };
    Some(Cow::Owned(text.into_bytes()))
}

/// `line` as it is where firmware `to` reads it so; else its command and words anew, without comments.
fn spelt<'a>(line: &'a [u8], parsed: &ParsedLine, to: Firmware) -> Cow<'a, [u8]> {
    let [command] = parsed.commands[..] else { return Cow::Borrowed(line) };
    if parsed.kind != LineKind::Words || LineRules::of(to).misreading(line, parsed).is_none() {
        return Cow::Borrowed(line);
    }
    let words = parsed.words.iter().enumerate();
    let first = |at: usize, letter: u8| parsed.words[..at].iter().all(|w| w.letter != letter);
    let letters =
        words.map(|(at, w)| (at, w.letter)).filter(|(at, letter)| first(*at, *letter)).map(|(_, letter)| letter);
    let word = |letter: u8| {
        let value = parsed.value(letter).map_or_else(String::new, |value| value.to_string());
        format!(" {}{value}", char::from(letter))
    };
    let words: String = letters.map(word).collect();
    Cow::Owned(format!("{command}{words}").into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(lines: &[&str]) -> Modal {
        let mut modal = Modal::default();
        lines.iter().for_each(|l| modal.note(Firmware::Marlin, l.as_bytes()));
        modal
    }

    #[test]
    fn a_print_finds_its_own_fan_heat_and_limits() {
        let here = after(&["M106 S255", "M104 S200 T0 ; x", "M204 P500", "M204 T900"]);
        let there = after(&["M106 S89.25", "M109 S215", "M204 P800 T900"]);
        let change = here.change_to(&there);
        assert_eq!(change, ["M109 S215", "M106 S89.25", "M204 P800 T900"]);
        assert_eq!(here.change_to(&after(&["M204 P500"])), ["M107"]);
    }

    #[test]
    fn what_is_set_by_name_is_said_again() {
        let by_name = |lines: &[&str]| {
            let mut modal = Modal::default();
            lines.iter().for_each(|l| modal.note(Firmware::Klipper, l.as_bytes()));
            modal
        };
        let here = by_name(&["SET_PRESSURE_ADVANCE ADVANCE=0.04"]);
        let there = by_name(&["SET_PRESSURE_ADVANCE ADVANCE=0.02"]);
        assert_eq!(here.change_to(&there), ["SET_PRESSURE_ADVANCE ADVANCE=0.02"]);
        assert_eq!(here.change_to(&here), Vec::<String>::new());
    }

    #[test]
    fn a_line_is_spelt_in_the_machines_own_words() {
        let said = |line: &str, from, to| {
            translated(line.as_bytes(), from, to).map(|l| String::from_utf8_lossy(&l).into_owned())
        };
        let (marlin, rrf, klipper) = (Firmware::Marlin, Firmware::RepRapFirmware, Firmware::Klipper);
        assert_eq!(said("G10 P0 S210", rrf, marlin).as_deref(), Some("M104 S210"));
        assert_eq!(said("M106 S0.5", rrf, marlin).as_deref(), Some("M106 S127.5"));
        assert_eq!(said("M204 P500", marlin, rrf).as_deref(), Some("M204 P500"));
        assert_eq!(said("SET_PRESSURE_ADVANCE ADVANCE=0.04", klipper, marlin), None);
        assert!(said("SET_PRESSURE_ADVANCE ADVANCE=0.04", klipper, klipper).is_some());
    }

    #[test]
    fn a_line_that_the_machine_would_read_otherwise_is_spelt_anew() {
        let said = |line: &str, to| {
            translated(line.as_bytes(), to, to).map(|l| String::from_utf8_lossy(&l).into_owned()).unwrap()
        };
        assert_eq!(said("m106s127.5", Firmware::Marlin), "M106 S127.5");
        assert_eq!(said("M106 S255 (on)", Firmware::Klipper), "M106 S255");
        assert_eq!(said("M0204 S800", Firmware::Klipper), "M204 S800");
        for whole in ["M106 S127.5 ; on", "M117 hello (you)", "M204 P800 T900", "m106 s9"] {
            assert_eq!(said(whole, Firmware::RepRapFirmware), whole);
        }
    }

    #[test]
    fn nothing_is_said_twice() {
        let one = after(&["M106", "M140 S60", ";M106 S3", "M900 K0.05", "M117 S5"]);
        let same = after(&["M106 S255", "M190 S60", "M900 K0.05"]);
        assert_eq!(one.change_to(&same), Vec::<String>::new());
    }
}
