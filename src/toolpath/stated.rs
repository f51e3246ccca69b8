//! What a sliced file says of itself: whose words it is in, the cross-section and widths of its lines, the names of
//! its objects. And the names under which we hand objects to slicers.

use crate::gcode::marks::Bead;
use crate::gcode::meaning::{Effect, Firmware, Hazard, effect};
use crate::gcode::settings::{Setting, Settings};
use crate::gcode::{LineKind, ParsedLine, lines};

/// How much of a file's beginning and end is searched for its flavour; PrusaSlicer's settings at the end are some 15 kB.
pub(super) const FLAVOR_WITHIN: usize = 64 * 1024;

/// The firmware that the file says it is for.
pub(super) fn firmware(bytes: &[u8]) -> Option<Firmware> {
    flavor(bytes).and_then(|name| Firmware::of_flavor(&name))
}

/// Whether it is for a Marlin whose E counts volumes, as Cura has one.
pub(super) fn has_volumetric_flavor(bytes: &[u8]) -> bool {
    flavor(bytes).is_some_and(|name| name.to_ascii_lowercase().contains("volumetric"))
}

/// The flavour as the file's beginning or end has it.
fn flavor(bytes: &[u8]) -> Option<String> {
    let parts = [&bytes[..bytes.len().min(FLAVOR_WITHIN)], &bytes[bytes.len().saturating_sub(FLAVOR_WITHIN)..]];
    parts.iter().find_map(|part| {
        [&b"; gcode_flavor = "[..], b";FLAVOR:"].iter().find_map(|key| {
            let rest = &part[memchr::memmem::find(part, key)? + key.len()..];
            let end = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
            Some(String::from_utf8_lossy(&rest[..end]).trim().to_owned())
        })
    })
}

/// The cross-section of the slicer that the file says it is from.
pub(super) fn bead(bytes: &[u8]) -> Bead {
    let head = &bytes[..bytes.len().min(FLAVOR_WITHIN)];
    let text = String::from_utf8_lossy(head);
    let version = text.split_once(";Generated with Cura_SteamEngine ").map(|(_, version)| version);
    match version.and_then(|version| version.split('.').next()?.parse::<u32>().ok()) {
        Some(5..) => Bead::Varied,
        _ if text.contains(";Generated with Cura") || text.contains(";FLAVOR:") => Bead::Square,
        _ => Bead::Round,
    }
}

/// The widths that the file's head states, as Slic3r and PrusaSlicer write them, where no line states its own.
pub(super) fn widths(bytes: &[u8]) -> Vec<f64> {
    if memchr::memmem::find(bytes, b"\n;WIDTH:").is_some() {
        return Vec::new();
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(FLAVOR_WITHIN)]);
    let width =
        |line: &str| line.strip_prefix("; ")?.split_once("extrusion width = ")?.1.split("mm").next()?.parse().ok();
    let mut widths: Vec<f64> = head.lines().filter_map(width).filter(|w| *w > 0.0).collect();
    widths.sort_by(f64::total_cmp);
    widths.dedup();
    widths
}

/// Where the slicer's start code ends: at its first mark of a layer; 0 in a file without any.
pub(super) fn start_code(bytes: &[u8]) -> usize {
    let marks = [&b"\n;LAYER_CHANGE"[..], b"\n;LAYER:", b"\n; CHANGE_LAYER"];
    marks.iter().filter_map(|mark| memchr::memmem::find(bytes, mark)).min().unwrap_or(0)
}

/// Whether layers state their own height, as PrusaSlicer, OrcaSlicer and the built-in slicer write it.
pub(super) fn says_each_height(bytes: &[u8]) -> bool {
    [&b"\n;HEIGHT:"[..], b"\n; LAYER_HEIGHT:"].iter().any(|key| memchr::memmem::find(bytes, key).is_some())
}

/// By how much the slicer moves outer walls outward; a slicer whose whole block of settings knows no such key compensates nothing.
pub(super) fn outset_mm(settings: &Settings) -> Option<f64> {
    match settings.text(Setting::Outset) {
        Some(_) => settings.number(Setting::Outset),
        None => settings.is_whole_block().then_some(0.0),
    }
}

/// Whether a line is a macro that Klipper has from the start.
pub(super) fn has_klipper_macros(bytes: &[u8]) -> bool {
    let mut parsed = ParsedLine::default();
    lines(bytes).any(|line| {
        begins_with_name(line.bytes) && parsed.read(line.bytes).is_ok() && is_klipper_macro(&parsed, line.bytes)
    })
}

/// The same of one line, whose words are `parsed`.
pub(super) fn is_klipper_macro(parsed: &ParsedLine, line: &[u8]) -> bool {
    parsed.kind == LineKind::Macro
        && begins_with_name(line)
        && !matches!(effect(Firmware::Klipper, parsed), Effect::Hazard(Hazard::Unknown))
}

fn begins_with_name(line: &[u8]) -> bool {
    line.len() > 2 && line[..3].iter().all(|b| b.is_ascii_alphabetic() || *b == b'_')
}

/// The name under which print `index` is handed to slicers.
pub fn print_name(index: usize, part: &str) -> String {
    let safe: String = part.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    format!("print-{index:02}-{safe}")
}

/// Whether a label says that an object ends.
pub(super) fn ends_label(comment: &[u8]) -> bool {
    let ends = ["stop printing object ", "M486 S-1", "EXCLUDE_OBJECT_END"];
    std::str::from_utf8(comment).is_ok_and(|text| ends.iter().any(|end| text.trim().starts_with(end)))
}

/// The print that an object label names: `; printing object print-03-arm id:0 copy 0`, `M486 Aprint-03-arm`,
/// `EXCLUDE_OBJECT_START NAME='print-03-arm_id_0_copy_0'`.
pub(super) fn label(comment: &[u8]) -> Option<usize> {
    let text = std::str::from_utf8(comment).ok()?.trim();
    let rest = text
        .strip_prefix("printing object ")
        .or_else(|| text.strip_prefix("M486 A"))
        .or_else(|| text.strip_prefix("EXCLUDE_OBJECT_START NAME=").map(|name| name.trim_start_matches('\'')))
        .or_else(|| text.strip_prefix("MESH:"))?;
    let name = rest.rsplit(['/', '\\']).next()?;
    let digits = name.strip_prefix("print-")?;
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cura_lays_walls_of_their_own_width_from_5_on() {
        for (head, wanted) in [
            (";FLAVOR:Marlin\n;Generated with Cura_SteamEngine 4.13.0\n", Bead::Square),
            (";FLAVOR:Marlin\n;Generated with Cura_SteamEngine 5.0.0\n", Bead::Varied),
            (";Generated with Cura_SteamEngine 5.8.1-beta\n", Bead::Varied),
            (";Generated with Cura_SteamEngine 10.0.0\n", Bead::Varied),
            // A build that does not say: as strict as can be.
            (";Generated with Cura_SteamEngine main\n", Bead::Square),
            (";FLAVOR:Marlin\n", Bead::Square),
            ("; generated by PrusaSlicer 2.9.2\n", Bead::Round),
        ] {
            assert_eq!(bead(head.as_bytes()), wanted, "{head}");
        }
    }
}
