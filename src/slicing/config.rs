//! A user's configuration as keys and values.

use std::collections::BTreeMap;

use crate::gcode::settings::config_values;

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
    use super::ini_values;

    #[test]
    fn an_ini_and_a_sliced_file_are_both_configurations() {
        assert_eq!(ini_values("# made by\nlayer_height = 0.15\n[x]\n")["layer_height"], "0.15");
        assert_eq!(ini_values("G1 X1\n; layer_height = 0.3\n")["layer_height"], "0.3");
    }
}
