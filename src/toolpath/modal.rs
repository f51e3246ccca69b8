//! What M-codes have set and left in force: heat, fans, limits.
//!
//! Prints of one setup take turns layer by layer, and prints of one plan may be sliced with different settings. Each must
//! find at its turn what its own slicer left it with, not what the print before it set.

use std::collections::BTreeMap;

use crate::gcode::ParsedLine;

/// Settings by command (with the tool or fan they are for) and letter.
#[derive(Clone, Debug, Default)]
pub(super) struct Modal(BTreeMap<(u32, u32), BTreeMap<u8, f64>>);

const NOZZLE: u32 = 104;
const BED: u32 = 140;
const FAN: u32 = 106;
/// Speed and flow of everything, percent; 100 where nobody has set them.
const FACTORS: [u32; 2] = [220, 221];
/// Limits, flow compensation: what stays until the next such line.
const OTHERS: [u32; 11] = [201, 203, 204, 205, 207, 208, 220, 221, 572, 593, 900];

impl Modal {
    /// The heat that a print begins with.
    pub(super) fn heated(nozzle: Option<f64>, bed: Option<f64>) -> Self {
        let mut modal = Self::default();
        for (code, value) in [(NOZZLE, nozzle), (BED, bed)] {
            if let Some(celsius) = value {
                modal.0.insert((code, 0), BTreeMap::from([(b'S', celsius)]));
            }
        }
        modal
    }

    /// Takes note of a line that is passed on.
    pub(super) fn note(&mut self, line: &[u8]) {
        let mut parsed = ParsedLine::default();
        let Some(code) = parsed.read(line).ok().and_then(|()| parsed.commands.first().copied()) else { return };
        let of = |letter: u8| parsed.value(letter).unwrap_or(0.0) as u32;
        let (key, words) = match (code.letter, code.number) {
            (b'M', 104 | 109) => ((NOZZLE, of(b'T')), parsed.value(b'S').or(parsed.value(b'R')).map(|s| (b'S', s))),
            (b'M', 140 | 190) => ((BED, 0), parsed.value(b'S').or(parsed.value(b'R')).map(|s| (b'S', s))),
            (b'M', 106) => ((FAN, of(b'P')), Some((b'S', parsed.value(b'S').unwrap_or(255.0)))),
            (b'M', 107) => ((FAN, of(b'P')), Some((b'S', 0.0))),
            (b'M', number) if OTHERS.contains(&number) => {
                let known = self.0.entry((number, of(b'D'))).or_default();
                known.extend(parsed.words.iter().filter_map(|w| Some((w.letter, w.value?))));
                return;
            }
            _ => return,
        };
        self.0.entry(key).or_default().extend(words);
    }

    /// The lines that bring what is in force to what `wanted` says; what `wanted` has never set is left alone, but
    /// fans are off and factors 100 % until somebody sets them.
    pub(super) fn change_to(&self, wanted: &Self) -> Vec<String> {
        let mut wanted = wanted.0.clone();
        for key in self.0.keys().filter(|key| key.0 == FAN || FACTORS.contains(&key.0)) {
            let unset = if key.0 == FAN { 0.0 } else { 100.0 };
            wanted.entry(*key).or_default().entry(b'S').or_insert(unset);
        }
        let differs = |key: &(u32, u32), letter: &u8, value: &f64| {
            self.0.get(key).and_then(|words| words.get(letter)).is_none_or(|now| now != value)
        };
        let mut lines = Vec::new();
        for (key, words) in &wanted {
            if words.iter().any(|(letter, value)| differs(key, letter, value)) {
                lines.push(line(*key, words));
            }
        }
        lines
    }
}

/// The command that sets `words`; a nozzle that changes is waited for.
fn line((code, index): (u32, u32), words: &BTreeMap<u8, f64>) -> String {
    let text: String = words.iter().map(|(letter, value)| format!(" {}{value}", char::from(*letter))).collect();
    match (code, index) {
        (FAN, 0) if words.get(&b'S') == Some(&0.0) => "M107".to_owned(),
        (FAN, 1..) => format!("M106 P{index}{text}"),
        (NOZZLE, 0) => format!("M109{text}"),
        (NOZZLE, _) => format!("M109 T{index}{text}"),
        _ => format!("M{code}{text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(lines: &[&str]) -> Modal {
        let mut modal = Modal::default();
        lines.iter().for_each(|l| modal.note(l.as_bytes()));
        modal
    }

    #[test]
    fn a_print_finds_its_own_fan_heat_and_limits() {
        let here = after(&["M106 S255", "M104 S200 T0 ; x", "M204 P500", "M204 T900", "M221 S95"]);
        let there = after(&["M106 S89.25", "M109 S215", "M204 P800 T900"]);
        let change = here.change_to(&there);
        assert_eq!(change, ["M109 S215", "M106 S89.25", "M204 P800 T900", "M221 S100"]);
        assert_eq!(here.change_to(&after(&["M204 P500"])), ["M107", "M221 S100"]);
    }

    #[test]
    fn nothing_is_said_twice() {
        let one = after(&["M106", "M140 S60", ";M106 S3", "M900 K0.05", "M117 S5"]);
        let same = after(&["M106 S255", "M190 S60", "M900 K0.05"]);
        assert_eq!(one.change_to(&same), Vec::<String>::new());
    }
}
