//! The lines of support in a sliced file, as a person reads them: PrusaSlicer's, Cura's and ours.
//!
//! Understood are G0 and G1 with absolute X, Y, Z, E absolute or relative (M82, M83, G92), and `;TYPE:` comments. Anything else that
//! would change what these mean is refused.

use std::collections::BTreeMap;

/// A line of filament: its ends, seen from above, and what it takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
    pub(crate) mm3: f64,
}

impl Line {
    /// From a place to the nearest of the line's middle, mm.
    pub(crate) fn distance(&self, at: [f64; 2]) -> f64 {
        let [dx, dy] = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let [x, y] = [at[0] - self.from[0], at[1] - self.from[1]];
        let square = dx * dx + dy * dy;
        let t = if square > 0.0 { ((x * dx + y * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
        (x - t * dx).hypot(y - t * dy)
    }
}

/// The lines of support at one height.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) top_mm: f64,
    pub(crate) lines: Vec<Line>,
}

/// The supports in a file, upward; its filament is so thick.
pub(crate) fn supports(text: &str, filament_mm: f64) -> Vec<Layer> {
    lines_of(text, filament_mm, &|role| role.to_ascii_uppercase().starts_with("SUPPORT"))
}

/// The lines whose role is asked for, upward.
///
/// # Panics
///
/// Where the file says something whose meaning is not known here.
pub(crate) fn lines_of(text: &str, filament_mm: f64, wanted: &dyn Fn(&str) -> bool) -> Vec<Layer> {
    let section = std::f64::consts::PI / 4.0 * filament_mm * filament_mm;
    let mut layers: BTreeMap<i64, Layer> = BTreeMap::new();
    let (mut at, mut e, mut relative, mut holds) = ([0.0_f64; 3], 0.0_f64, false, false);
    for line in text.lines() {
        if let Some(role) = line.strip_prefix(";TYPE:") {
            holds = wanted(role);
        }
        let words: Vec<&str> = line.split(';').next().unwrap_or_default().split_whitespace().collect();
        let value = |letter: char| words[1..].iter().find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        match words.first() {
            Some(&("G0" | "G1")) => {
                let to = [0, 1, 2].map(|k| value(['X', 'Y', 'Z'][k]).unwrap_or(at[k]));
                let laid = match value('E') {
                    Some(given) if relative => given,
                    Some(given) => given - std::mem::replace(&mut e, given),
                    None => 0.0,
                };
                if holds && laid > 0.0 && to[..2] != at[..2] {
                    let key = (to[2] * 1000.0).round() as i64;
                    let layer = layers.entry(key).or_insert_with(|| Layer { top_mm: to[2], lines: Vec::new() });
                    let line = Line { from: [at[0], at[1]], to: [to[0], to[1]], mm3: laid * section };
                    layer.lines.push(line);
                }
                at = to;
            }
            Some(&"G92") => {
                assert!(words[1..].iter().all(|word| word.starts_with('E')), "{line}");
                e = value('E').unwrap_or(0.0);
            }
            Some(&"M82") => relative = false,
            Some(&"M83") => relative = true,
            Some(&("G2" | "G3" | "G91" | "G20")) => panic!("not understood: {line}"),
            _ => {}
        }
    }
    layers.into_values().collect()
}
