//! The settings that sliced G-code says it was made with: one table of names, for everybody who asks.
//!
//! ```text
//! PrusaSlicer, SuperSlicer, Slic3r, OrcaSlicer, built-in    ; layer_height = 0.2         a block at the end (Bambu Studio: at the head)
//! Cura's engine                                             ;Layer height: 0.2           in the head
//! Cura's window                                             ;SETTING_3 {..}              at the end, only what differs from the machine's
//! Simplify3D                                                ;   layerHeight,0.2          in the head
//! ```
//!
//! Lengths mm, degrees Celsius. Where a setting has a value for each extruder the first one is taken.

use std::collections::BTreeMap;

/// How much of the end of a file is searched: PrusaSlicer's block is some 15 kB, user G-code in it may add more.
const TAIL_BYTES: usize = 256 * 1024;
/// And of its beginning: thumbnails may stand before the settings.
const HEAD_BYTES: usize = 128 * 1024;

/// A setting, whatever its slicer calls it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Of all layers but the first.
    LayerHeight,
    /// Of the first; may be a share of the others' (`150%`).
    FirstLayerHeight,
    /// Bore of the nozzle.
    Nozzle,
    /// Diameter of the filament.
    Filament,
    /// Width of the lines, where it is one for all.
    LineWidth,
    /// Factor on all flow.
    Multiplier,
    /// By how much outer walls are moved outward.
    Outset,
    /// Layers of changing height.
    AdaptiveLayers,
    /// One line that rises all the way.
    Spiral,
    /// Outer walls that tremble on purpose.
    FuzzySkin,
    /// Lengths of E are volumes.
    VolumetricE,
    /// Nozzle temperature.
    NozzleHeat,
    /// The same for the first layer.
    FirstNozzleHeat,
    /// Bed temperature.
    BedHeat,
    /// The same for the first layer.
    FirstBedHeat,
    /// Number of walls.
    Walls,
    /// How thick they are together.
    WallThickness,
    /// Solid layers below a top surface.
    Tops,
    /// How thick these are together.
    TopThickness,
    /// Solid layers above a bottom surface.
    Bottoms,
    /// How thick these are together.
    BottomThickness,
    /// Share of the interior that is filled.
    Infill,
}

/// The names of a setting, PrusaSlicer's first.
const NAMES: [(Setting, &[&str]); 22] = [
    (Setting::LayerHeight, &["layer_height", "Layer height", "layerHeight"]),
    (Setting::FirstLayerHeight, &["first_layer_height", "initial_layer_print_height", "layer_height_0"]),
    (Setting::Nozzle, &["nozzle_diameter", "machine_nozzle_size", "extruderDiameter"]),
    (Setting::Filament, &["filament_diameter", "material_diameter", "filamentDiameters"]),
    (Setting::LineWidth, &["extrusion_width", "line_width", "extruderWidth"]),
    (Setting::Multiplier, &["extrusion_multiplier", "filament_flow_ratio", "extrusionMultiplier"]),
    (Setting::Outset, &["xy_size_compensation", "xy_contour_compensation", "xy_offset"]),
    (Setting::AdaptiveLayers, &["adaptive_slicing"]),
    (Setting::Spiral, &["spiral_vase", "spiral_mode", "magic_spiralize", "vaseMode"]),
    (Setting::FuzzySkin, &["fuzzy_skin", "magic_fuzzy_skin_enabled"]),
    (Setting::VolumetricE, &["use_volumetric_e"]),
    (Setting::NozzleHeat, &["temperature", "nozzle_temperature", "material_print_temperature"]),
    (
        Setting::FirstNozzleHeat,
        &["first_layer_temperature", "nozzle_temperature_initial_layer", "material_print_temperature_layer_0"],
    ),
    (Setting::BedHeat, &["bed_temperature", "hot_plate_temp", "material_bed_temperature"]),
    (
        Setting::FirstBedHeat,
        &["first_layer_bed_temperature", "hot_plate_temp_initial_layer", "material_bed_temperature_layer_0"],
    ),
    (Setting::Walls, &["perimeters", "wall_loops", "wall_line_count", "perimeterOutlines"]),
    (Setting::WallThickness, &["wall_thickness"]),
    (Setting::Tops, &["top_solid_layers", "top_shell_layers", "top_layers", "topSolidLayers"]),
    (Setting::TopThickness, &["top_thickness", "top_bottom_thickness"]),
    (Setting::Bottoms, &["bottom_solid_layers", "bottom_shell_layers", "bottom_layers", "bottomSolidLayers"]),
    (Setting::BottomThickness, &["bottom_thickness", "top_bottom_thickness"]),
    (Setting::Infill, &["fill_density", "sparse_infill_density", "infill_sparse_density", "infillPercentage"]),
];

/// What a file's settings want inside a part; `None` where they do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Interior {
    /// Number of walls.
    pub walls: Option<u32>,
    /// Solid layers below a top surface.
    pub tops: Option<u32>,
    /// Solid layers above a bottom surface.
    pub bottoms: Option<u32>,
    /// Whether there is any infill.
    pub infill: Option<bool>,
}

/// What a sliced file says of its settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings(BTreeMap<String, String>);

impl Settings {
    /// The settings in `gcode`; none where it has none. Of a key that occurs twice the last counts; bytes that are not UTF-8 are
    /// replaced.
    pub fn of(gcode: &[u8]) -> Self {
        let head = String::from_utf8_lossy(&gcode[..gcode.len().min(HEAD_BYTES)]).into_owned();
        let mut all: BTreeMap<String, String> = head.lines().filter_map(in_head).collect();
        let tail = String::from_utf8_lossy(&gcode[gcode.len().saturating_sub(TAIL_BYTES)..]).into_owned();
        all.extend(of_cura(&tail));
        all.extend(tail.lines().filter_map(in_block));
        Self(all)
    }

    /// As the file has it; one value per extruder is separated by commas or semicolons.
    pub fn text(&self, setting: Setting) -> Option<&str> {
        let names = NAMES.iter().find(|(known, _)| *known == setting).map_or(&[][..], |(_, names)| names);
        names.iter().find_map(|name| self.0.get(*name)).map(String::as_str)
    }

    /// The first extruder's value.
    pub fn number(&self, setting: Setting) -> Option<f64> {
        first(self.text(setting)?).parse().ok().filter(|v: &f64| v.is_finite())
    }

    /// A value above 0: what has no meaning there is not stated.
    pub fn positive(&self, setting: Setting) -> Option<f64> {
        self.number(setting).filter(|v| *v > 0.0)
    }

    /// Whether it is switched on.
    pub fn is_on(&self, setting: Setting) -> bool {
        self.text(setting).is_some_and(|text| first(text) == "1" || first(text).eq_ignore_ascii_case("true"))
    }

    /// Whether it is asked for at all, by whatever word: `external`, `2`, `3mm`; not where it is off, or nothing is said.
    pub fn is_asked(&self, setting: Setting) -> bool {
        self.text(setting).is_some_and(is_asked)
    }

    /// What is wanted inside a part. Cura's window states thicknesses where these were set and counts were not.
    pub fn inside(&self) -> Interior {
        let count = |count: Setting, thickness: Setting, each: Setting| {
            let stated = self.number(count).filter(|count| *count >= 0.0);
            let thick = || Some((self.number(thickness)? / self.positive(each)?).round().max(0.0));
            stated.or_else(thick).map(|count| count as u32)
        };
        Interior {
            walls: count(Setting::Walls, Setting::WallThickness, Setting::LineWidth),
            tops: count(Setting::Tops, Setting::TopThickness, Setting::LayerHeight),
            bottoms: count(Setting::Bottoms, Setting::BottomThickness, Setting::LayerHeight),
            infill: self.text(Setting::Infill).map(|text| is_asked(text.trim_end_matches('%'))),
        }
    }

    /// Whether all settings are there, as PrusaSlicer and its kin write them: what is not among them, the slicer does not know.
    pub fn is_whole_block(&self) -> bool {
        ["layer_height", "nozzle_diameter", "filament_diameter"].iter().all(|key| self.0.contains_key(*key))
    }

    /// Height of the first layer and of all others, where one holds for all others.
    pub fn heights_mm(&self) -> Option<[f64; 2]> {
        let other = self.positive(Setting::LayerHeight).filter(|_| !self.is_on(Setting::AdaptiveLayers))?;
        let first = match self.text(Setting::FirstLayerHeight).map(|text| first(text).strip_suffix('%').ok_or(text)) {
            None => return None,
            Some(Ok(percent)) => percent.trim().parse::<f64>().ok()? / 100.0 * other,
            Some(Err(_)) => self.number(Setting::FirstLayerHeight)?,
        };
        (first > 0.0).then_some([first, other])
    }
}

/// Whether a setting's value asks for anything.
pub fn is_asked(value: &str) -> bool {
    const NOTHING: [&str; 8] = ["", "0", "0%", "false", "none", "disabled", "no_brim", "nil"];
    let value = first(value).trim_matches('"').to_ascii_lowercase();
    !NOTHING.contains(&value.as_str()) && value.parse::<f64>() != Ok(0.0)
}

fn first(text: &str) -> &str {
    text.split([',', ';']).next().unwrap_or_default().trim()
}

/// The `; key = value` comments at the end of sliced G-code, as PrusaSlicer, SuperSlicer, Slic3r and the built-in
/// slicer write them; empty where there are none.
///
/// Keys are the slicer's own (`temperature`, `bed_temperature`, `filament_diameter`, `layer_height`, ..), values are
/// verbatim; one value per extruder is separated by commas. Where a key occurs twice the last one counts. Bytes that
/// are not UTF-8 are replaced. Only the last 256 KiB are searched.
pub fn config_values(gcode: &[u8]) -> BTreeMap<String, String> {
    let tail = String::from_utf8_lossy(&gcode[gcode.len().saturating_sub(TAIL_BYTES)..]).into_owned();
    tail.lines().filter_map(in_block).collect()
}

/// `; key = value`
fn in_block(line: &str) -> Option<(String, String)> {
    let (key, value) = line.trim_end().strip_prefix("; ")?.split_once(" =")?;
    let is_key = !key.is_empty() && key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
    is_key.then(|| (key.to_owned(), value.trim_start().to_owned()))
}

/// The same, `;Layer height: 0.28` and `;   layerHeight,0.2`
fn in_head(line: &str) -> Option<(String, String)> {
    let known = |key: &str| NAMES.iter().any(|(_, names)| names.contains(&key));
    let rest = line.trim_end().strip_prefix(';')?;
    let pair = |mark: char| rest.split_once(mark).map(|(key, value)| (key.trim(), value.trim()));
    let plain = [pair(':'), pair(',')].into_iter().flatten().find(|(key, _)| known(key));
    plain.map(|(key, value)| (key.to_owned(), value.to_owned())).or_else(|| in_block(line))
}

/// What Cura's window keeps at the end of a file: JSON in pieces, whose texts are `key = value` lines with their line breaks
/// written `\n`, escaped once or twice.
fn of_cura(tail: &str) -> Vec<(String, String)> {
    let pieces: String = tail.lines().filter_map(|line| line.strip_prefix(";SETTING_3 ")).collect();
    let setting = |line: &str| {
        let (key, value) = line.trim_matches(['\\', '"']).split_once('=')?;
        Some((key.trim().to_owned(), value.trim_end_matches('\\').trim().to_owned()))
    };
    pieces.split("\\n").filter_map(setting).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(Settings::of(gcode).number(Setting::NozzleHeat), Some(215.0));
    }

    #[test]
    fn every_slicer_says_its_layer_height_in_its_own_words() {
        let block = "; layer_height = 0.3\n; first_layer_height = 0.35\n; nozzle_diameter = 0.6,0.4\n";
        let cura = ";FLAVOR:Marlin\n;Layer height: 0.28\nG1 X1 E1\n";
        let window = ";Layer height: 0.28\nG1 X1\n;SETTING_3 {\"global_quality\": \"[general]\\\\nversion = 4\\\\n\\\\n[values]\\\\nlayer_hei\n\
                      ;SETTING_3 ght = 0.28\\\\nlayer_height_0 = 0.3\\\\n\\\\n\", \"extruder_quality\": [\"[values]\\\\nline_width = 0.42\\\\n\"]}\n";
        let simplify = "; G-Code generated by Simplify3D(R)\n;   layerHeight,0.2\n;   extruderDiameter,0.4\n";
        let of = |text: &str| Settings::of(text.as_bytes());
        assert_eq!(of(block).heights_mm(), Some([0.35, 0.3]));
        assert_eq!(of(block).positive(Setting::Nozzle), Some(0.6));
        // The engine says nothing of the first layer.
        assert_eq!((of(cura).positive(Setting::LayerHeight), of(cura).heights_mm()), (Some(0.28), None));
        assert_eq!(of(window).heights_mm(), Some([0.3, 0.28]));
        assert_eq!(of(window).positive(Setting::LineWidth), Some(0.42));
        assert_eq!(of(simplify).positive(Setting::LayerHeight), Some(0.2));
        assert_eq!(of(simplify).positive(Setting::Nozzle), Some(0.4));
        assert_eq!(
            of("; layer_height = 0.2\n; first_layer_height = 150%\n").heights_mm(),
            Some([0.3, 0.2]).map(|[_, o]| [150.0 / 100.0 * 0.2, o])
        );
        assert_eq!(of("; layer_height = 0.2\n; first_layer_height = 0.2\n; adaptive_slicing = 1\n").heights_mm(), None);
        assert_eq!(of("G1 X1 E1\n"), Settings::default());
        assert!(of("; spiral_vase = 1\n").is_on(Setting::Spiral) && !of("; spiral_vase = 0\n").is_on(Setting::Spiral));
        let inside = |walls, tops, bottoms, infill| Interior { walls, tops, bottoms, infill };
        let prusa = "; perimeters = 3\n; top_solid_layers = 0\n; bottom_solid_layers = 4\n; fill_density = 15%\n";
        assert_eq!(of(prusa).inside(), inside(Some(3), Some(0), Some(4), Some(true)));
        let cura = ";Layer height: 0.2\n;SETTING_3 {\"global_quality\": \"[values]\\\\nwall_thickness = 0.4\\\\nline_width = 0.4\\\\ntop_thickness = \
                    0.8\\\\ninfill_sparse_density = 0\\\\n\"}\n";
        assert_eq!(of(cura).inside(), inside(Some(1), Some(4), None, Some(false)));
        assert_eq!(of("G1 X1 E1\n; fill_density = 0%\n").inside(), inside(None, None, None, Some(false)));
        for (value, asked) in
            [("none", false), ("0", false), ("external", true), ("all", true), ("true", true), ("0.0", false)]
        {
            assert_eq!(of(&format!("; fuzzy_skin = {value}\n")).is_asked(Setting::FuzzySkin), asked, "{value}");
        }
    }
}
