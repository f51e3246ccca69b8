//! What is known of the slicers that are separate programs, without running them.

use std::ffi::OsString;
use std::path::Path;

use super::config::ini_values;
use super::prusa::{self, Values};
use super::{SliceError, SliceJob, SliceSettings, SlicerChoice, cura, slic3r};
use crate::gcode::settings::is_asked;

/// A program that this version has a recipe for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Program {
    /// One that is configured by `.ini` files.
    Ini(Ini),
    CuraEngine,
}

/// The programs that came from Slic3r.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ini {
    PrusaSlicer,
    Slic3r,
}

impl Program {
    pub(super) const PRUSA_SLICER: Self = Self::Ini(Ini::PrusaSlicer);
    pub(super) const SLIC3R: Self = Self::Ini(Ini::Slic3r);

    /// The name, as a user would say it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::PRUSA_SLICER => "PrusaSlicer",
            Self::SLIC3R => "Slic3r",
            Self::CuraEngine => "CuraEngine",
        }
    }

    /// The names it is installed under, the likeliest first.
    pub(super) fn commands(self) -> &'static [&'static str] {
        match self {
            Self::PRUSA_SLICER => &["prusa-slicer", "PrusaSlicer", "prusa-slicer-console"],
            Self::SLIC3R => &["slic3r", "Slic3r"],
            Self::CuraEngine => &["CuraEngine", "curaengine", "cura-engine"],
        }
    }

    /// The program that wrote this help text, and its version.
    pub(super) fn identify(help: &str) -> Option<(Self, String)> {
        let prusa = prusa::version(help).map(|version| (Self::PRUSA_SLICER, version));
        let slic3r = || slic3r::version(help).map(|version| (Self::SLIC3R, version));
        prusa.or_else(slic3r).or_else(|| cura::version(help).map(|version| (Self::CuraEngine, version)))
    }
}

impl Ini {
    /// The configuration below the user's, as the text of an `.ini` file.
    pub(super) fn base(self, settings: &SliceSettings) -> String {
        prusa::ini(&match self {
            Self::PrusaSlicer => prusa::base(settings),
            Self::Slic3r => slic3r::base(settings),
        })
    }

    /// The configuration above the user's, whose texts are `configs`, as the text of an `.ini` file.
    ///
    /// The first layer's height must be the layer height in effect: the last one the user gives, else the settings'.
    /// As `100%` PrusaSlicer 2.5 takes it for 100 mm.
    pub(super) fn forced(self, settings: &SliceSettings, configs: &[String], job: &SliceJob) -> String {
        let given = configs.iter().rev().find_map(|text| ini_values(text).remove("layer_height"));
        let layer_height = given.unwrap_or_else(|| settings.layer_height_mm.to_string());
        let mut values: Values = match self {
            Self::PrusaSlicer => prusa::forced(&layer_height, job),
            Self::Slic3r => slic3r::forced(&layer_height, job),
        };
        for key in ["first_layer_temperature", "first_layer_bed_temperature"] {
            // Zero keeps M104 and M109 away; on the table the user's own first layer counts.
            if !(job.on_table && configs.iter().any(|text| ini_values(text).contains_key(key))) {
                values.insert(key, "0".to_owned());
            }
        }
        prusa::ini(&values)
    }

    pub(super) fn arguments(self, configs: &[&Path], mesh: &Path, output: &Path) -> Vec<OsString> {
        match self {
            Self::PrusaSlicer => prusa::arguments(configs, mesh, output),
            Self::Slic3r => slic3r::arguments(configs, mesh, output),
        }
    }
}

/// What only a slicer can be asked for that marks its lines: what is printed around a part, and infill higher than its layer.
const MARKED: [&str; 3] = ["skirts", "brim_width", "infill_every_layers"];
/// Settings that are not the user's to make here, but for start and end code, which the profile has.
const NOT_TAKEN: [&str; 14] = [
    "interior_brim_width",
    "brim_connections_width",
    "raft_layers",
    "support_material",
    "wipe_tower",
    "draft_shield",
    "complete_objects",
    "z_offset",
    "adhesion_type",
    "support_enable",
    "prime_tower_enable",
    // CuraEngine 4.13 cuts layers of changing height at their tops and not in their middles: the part comes out smaller or larger by half
    // a layer on every slope.
    "adaptive_layer_height_enabled",
    "magic_spiralize",
    // Its infill of several layers at once is not told apart from the lines of one.
    "infill_sparse_thickness",
];

/// What the user's configurations, the last of which counts, ask for of that, as `key = value`; `marks` where the slicer marks its
/// lines.
pub(super) fn not_taken(texts: &[String], marks: bool) -> Vec<String> {
    let mut values = Values::new();
    let mut given = std::collections::BTreeMap::new();
    texts.iter().for_each(|text| given.extend(ini_values(text)));
    // Infill as thick as the layers is none that is thicker.
    if given.get("infill_sparse_thickness") == given.get("layer_height") {
        given.remove("infill_sparse_thickness");
    }
    if given.get("infill_every_layers").is_some_and(|layers| layers == "1") {
        given.remove("infill_every_layers");
    }
    for key in MARKED.into_iter().filter(|_| !marks).chain(NOT_TAKEN) {
        if let Some(value) = given.remove(key).filter(|value| is_asked(value)) {
            values.insert(key, value);
        }
    }
    values.into_iter().map(|(key, value)| format!("{key} = {value}")).collect()
}

/// Whether a program says that what it was to slice begins in a point or an edge, too narrow for any line of the first layer.
pub(super) fn begins_in_nothing(said: &str) -> bool {
    ["no extrusions in the first layer", "empty initial layer"].iter().any(|words| said.contains(words))
}

/// The refusal of a slicer whose command line this version has no recipe for.
pub(super) fn not_driven(choice: &SlicerChoice) -> Option<SliceError> {
    let (slicer, remedy) = match choice {
        SlicerChoice::Orca => (
            "OrcaSlicer's command line",
            "use trunnion as its post-processing script, or --slicer prusa-slicer or builtin",
        ),
        _ => return None,
    };
    Some(SliceError::NotDriven { slicer: slicer.to_owned(), remedy })
}

/// Whether sliced G-code extrudes anywhere: a move with X or Y and a positive E.
pub(super) fn extrudes(gcode: &[u8]) -> bool {
    gcode.split(|&b| b == b'\n').any(|line| {
        let mut words = line.split(|&b| b == b' ');
        let moves = matches!(words.next(), Some(b"G1" | b"G2" | b"G3"));
        let mut found = [false; 2];
        for word in words.take_while(|word| !word.starts_with(b";")) {
            match word.split_first() {
                Some((b'X' | b'Y', _)) => found[0] = true,
                Some((b'E', amount)) => found[1] = !amount.starts_with(b"-"),
                _ => {}
            }
        }
        moves && found == [true; 2]
    })
}

/// The last lines of a program's complaint, at most six, without blank ones and traces.
pub(super) fn last_lines(text: &str) -> String {
    let lines: Vec<&str> =
        text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.contains("[trace]")).collect();
    let last = &lines[lines.len().saturating_sub(6)..];
    if last.is_empty() { "it wrote nothing to stderr".to_owned() } else { last.join(" | ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_are_not_taken_are_named_with_the_value_that_counts() {
        let texts =
            ["skirts = 1\nbrim_width = 0\nfill_density = 40%\n", "brim_width = 3\nskirts = 0\nsupport_material = 1\n"];
        let texts = texts.map(str::to_owned);
        assert_eq!(not_taken(&texts, false), ["brim_width = 3", "support_material = 1"]);
        assert_eq!(not_taken(&texts, true), ["support_material = 1"]);
        let cura = "adhesion_type = none\nsupport_enable = true\n".to_owned();
        assert_eq!(not_taken(&[cura], false), ["support_enable = true"]);
        let cura = "adaptive_layer_height_enabled = true\nmagic_spiralize = false\n".to_owned();
        assert_eq!(not_taken(&[cura], false), ["adaptive_layer_height_enabled = true"]);
        let higher = "infill_every_layers = 2\n".to_owned();
        assert_eq!(not_taken(std::slice::from_ref(&higher), false), ["infill_every_layers = 2"]);
        assert_eq!(not_taken(&[higher], true), Vec::<String>::new());
        assert_eq!(not_taken(&["infill_every_layers = 1\n".to_owned()], false), Vec::<String>::new());
        assert_eq!(not_taken(&[], false), Vec::<String>::new());
    }

    #[test]
    fn the_layer_height_in_effect_is_the_last_one_given() {
        let job = SliceJob {
            name: "x".into(),
            on_table: true,
            bed_mm: [200.0; 2],
            adhesion: crate::slicing::Adhesion::default(),
        };
        let forced = |configs: &[&str]| {
            let configs: Vec<String> = configs.iter().map(|s| (*s).to_owned()).collect();
            Ini::PrusaSlicer.forced(&SliceSettings::default(), &configs, &job)
        };
        assert!(forced(&[]).contains("first_layer_height = 0.2\n"));
        let got = forced(&["layer_height = 0.1\n", "layer_height=0.3\n", "perimeters = 3\n"]);
        assert!(got.contains("first_layer_height = 0.3\n"), "{got}");
        assert!(got.contains("first_layer_temperature = 0\n"), "{got}");
        let got = forced(&["first_layer_temperature = 230\n"]);
        assert!(!got.contains("first_layer_temperature") && got.contains("first_layer_bed_temperature = 0\n"), "{got}");
    }

    #[test]
    fn a_file_of_travels_extrudes_nothing() {
        assert!(!extrudes(b"G1 X1 Y1 F7200\nG1 E1 F2400\nG1 X2 E-1\n; G1 X1 E1\nM83 ; G1 X1 E2\n"));
        assert!(extrudes(b"G1 X1 Y1 F7200\nG1 X2 E.1\n"));
    }

    #[test]
    fn orca_is_refused_with_a_remedy() {
        assert!(not_driven(&SlicerChoice::Orca).unwrap().to_string().contains("post-processing"));
        assert!(not_driven(&SlicerChoice::Auto).is_none());
    }
}
