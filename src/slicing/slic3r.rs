//! Slic3r: what differs from PrusaSlicer. Measured with 1.3.0.

use std::ffi::OsString;
use std::path::Path;

use super::prusa::{Values, common_base, common_forced};
use super::{SliceJob, SliceSettings};

/// The version in what `--help` prints, for instance `1.3.0`; `None` if this is not Slic3r.
pub(super) fn version(help: &str) -> Option<String> {
    let rest = help.lines().find_map(|line| line.strip_prefix("Slic3r "))?;
    let version: String = rest.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
    (!version.is_empty()).then_some(version)
}

/// The configuration that lies under the user's own.
pub(super) fn base(s: &SliceSettings) -> Values {
    let mut values = common_base(s);
    // 1.3 knows no Marlin flavour; this one writes the same words.
    values.insert("gcode_flavor", "reprap".to_owned());
    values
}

/// What the user's configuration must not change; `layer_height` is the one in effect.
pub(super) fn forced(layer_height: &str, job: &SliceJob) -> Values {
    let mut values = common_forced(layer_height, job);
    let more = [
        ("interior_brim_width", "0"),
        ("brim_connections_width", "0"),
        ("gcode_arcs", "0"),
        // It does not state that such lines are higher than their layer.
        ("infill_every_layers", "1"),
        // It looks for temperature words in the start code, comments too, and stays silent when it finds them.
        ("start_gcode", "; M104, M109, M140 and M190 are left to the rewriter"),
    ];
    values.extend(more.map(|(key, value)| (key, value.to_owned())));
    values
}

/// The command line: configurations in rising order of precedence, then the mesh and the output.
pub(super) fn arguments(configs: &[&Path], mesh: &Path, output: &Path) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = vec!["--no-gui".into(), "--dont-arrange".into()];
    for config in configs {
        arguments.extend(["--load".into(), config.as_os_str().to_owned()]);
    }
    arguments.extend(["--output".into(), output.as_os_str().to_owned(), mesh.as_os_str().to_owned()]);
    arguments
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_version_is_found_in_the_help_text() {
        let help = "Slic3r 1.3.0 is a STL-to-GCODE translator for RepRap 3D printers\n";
        assert_eq!(super::version(help).as_deref(), Some("1.3.0"));
        assert_eq!(super::version("PrusaSlicer-2.5.0+UNKNOWN based on Slic3r (with GUI support)"), None);
    }
}
