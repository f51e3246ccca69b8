//! The settings that a slicer's output says it was made with.

use std::collections::BTreeMap;

/// How much of the end of a file is searched: PrusaSlicer's block is some 15 kB, user G-code in it may add more.
const TAIL_BYTES: usize = 256 * 1024;

/// The `; key = value` comments at the end of sliced G-code, as PrusaSlicer, SuperSlicer, Slic3r and the built-in
/// slicer write them; empty where there are none.
///
/// Keys are the slicer's own (`temperature`, `bed_temperature`, `filament_diameter`, `layer_height`, ..), values are
/// verbatim; one value per extruder is separated by commas. Where a key occurs twice the last one counts. Bytes that
/// are not UTF-8 are replaced. Only the last 256 KiB are searched.
pub fn config_values(gcode: &[u8]) -> BTreeMap<String, String> {
    let tail = String::from_utf8_lossy(&gcode[gcode.len().saturating_sub(TAIL_BYTES)..]).into_owned();
    tail.lines().filter_map(config_line).collect()
}

fn config_line(line: &str) -> Option<(String, String)> {
    let (key, value) = line.trim_end().strip_prefix("; ")?.split_once(" =")?;
    let is_key = !key.is_empty() && key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    is_key.then(|| (key.to_owned(), value.trim_start().to_owned()))
}

/// The `key = value` lines of a configuration: an exported `.ini`, or a sliced file used as one.
pub(super) fn ini_values(text: &str) -> BTreeMap<String, String> {
    let ini = text.lines().filter(|line| !line.trim_start().starts_with(['#', ';', '['])).filter_map(|line| {
        let (key, value) = line.split_once('=')?;
        Some((key.trim().to_owned(), value.trim().to_owned()))
    });
    // A G-code file has no `key = value` lines outside comments that could be mistaken for settings.
    let mut values = config_values(text.as_bytes());
    values.extend(ini);
    values
}

#[cfg(test)]
mod tests {
    use super::{config_values, ini_values};

    #[test]
    fn the_block_at_the_end_is_read() {
        let gcode = b"G1 X1 E1\n; filament used [mm] = 1.0\n\n; temperature = 215,220\n; start_gcode = \n\
                      ; bed_temperature = 60\n; notes = a = b\n";
        let values = config_values(gcode);
        assert_eq!(values["temperature"], "215,220");
        assert_eq!(values["bed_temperature"], "60");
        assert_eq!(values["start_gcode"], "");
        assert_eq!(values["notes"], "a = b");
        assert_eq!(values.len(), 4);
    }

    #[test]
    fn an_ini_and_a_sliced_file_are_both_configurations() {
        assert_eq!(ini_values("# made by\nlayer_height = 0.15\n[x]\n")["layer_height"], "0.15");
        assert_eq!(ini_values("G1 X1\n; layer_height = 0.3\n")["layer_height"], "0.3");
    }
}
