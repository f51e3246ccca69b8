//! The printers that PrusaSlicer knows, with the settings that their makers give: each is printed, or refused for what is truly in the way.
//!
//! The presets are the installed program's own (`share/PrusaSlicer/profiles`, a file for each vendor): sections that inherit from each other, each
//! printer with the names of its print and filament.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::pipeline::fixture;
use crate::support::{folder, installed, note, on_path, said, skip, trunnion};

type Values = BTreeMap<String, String>;
/// By kind (`printer`, `print`, `filament`) and name.
type Sections = BTreeMap<(String, String), Values>;

/// The presets beside the `prusa-slicer` that is found first.
fn presets() -> Option<PathBuf> {
    let program = on_path("prusa-slicer")?;
    let places = ["../files/usr/share/PrusaSlicer/profiles", "../share/PrusaSlicer/profiles"];
    places.iter().map(|place| program.parent().unwrap().join(place)).find(|folder| folder.is_dir())
}

fn sections(text: &str) -> Sections {
    let (mut all, mut current) = (Sections::new(), None);
    for line in text.lines().filter(|line| !line.trim_start().starts_with(['#', ';'])) {
        if let Some(head) = line.trim().strip_prefix('[') {
            let named = head.trim_end_matches(']').split_once(':');
            current = named.map(|(kind, name)| (kind.to_owned(), name.trim().to_owned()));
        } else if let (Some(key), Some((name, value))) = (&current, line.split_once('=')) {
            all.entry(key.clone()).or_default().insert(name.trim().to_owned(), value.trim().to_owned());
        }
    }
    all
}

/// A section with what it inherits, later parents over earlier ones.
fn whole(all: &Sections, kind: &str, name: &str) -> Option<Values> {
    let own = all.get(&(kind.to_owned(), name.to_owned()))?;
    let parents = own.get("inherits").map(String::as_str).unwrap_or_default();
    let parents = parents.split(';').map(str::trim).filter(|parent| !parent.is_empty());
    let mut values = Values::new();
    parents.filter_map(|parent| whole(all, kind, parent)).for_each(|parent| values.extend(parent));
    values.extend(own.clone());
    Some(values)
}

/// What a user exports for a printer: its own settings, and those of its print and its first filament.
fn configuration(all: &Sections, printer: &str) -> Option<String> {
    let machine = whole(all, "printer", printer)?;
    let named = |key: &str| machine.get(key)?.split(';').next().map(|name| name.trim().trim_matches('"').to_owned());
    let filament = whole(all, "filament", &named("default_filament_profile")?)?;
    let print = whole(all, "print", &named("default_print_profile")?)?;
    let mut values = filament;
    values.extend(print);
    values.extend(machine.clone());
    values.retain(|key, _| !key.starts_with("compatible_") && key != "inherits" && key != "renamed_from");
    (machine.get("printer_technology").is_none_or(|kind| kind == "FFF"))
        .then(|| values.iter().map(|(key, value)| format!("{key} = {value}\n")).collect())
}

/// The first printer of each vendor with one nozzle of the profile's size, and the first three of all with several extruders.
fn chosen(folder: &Path) -> Vec<(String, String)> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|end| end == "ini"));
    files.sort();
    let (mut found, mut several) = (Vec::new(), 0);
    for file in files {
        let all = sections(&String::from_utf8_lossy(&std::fs::read(&file).unwrap()));
        let printers = all.keys().filter(|(kind, name)| kind == "printer" && !name.starts_with('*'));
        let mut one = false;
        for (_, name) in printers {
            let Some(text) = configuration(&all, name) else { continue };
            let nozzles = text.lines().find_map(|line| line.strip_prefix("nozzle_diameter = ")).unwrap_or_default();
            let wanted = match nozzles.split_once(',') {
                None => nozzles == "0.4" && !std::mem::replace(&mut one, true),
                Some((first, _)) => first == "0.4" && several < 3,
            };
            several += usize::from(wanted && nozzles.contains(','));
            if wanted {
                found.push((format!("{}: {name}", file.file_stem().unwrap().display()), text));
            }
        }
    }
    found
}

/// What may be in the way of a stock configuration on our machine, in the words that are told.
const TRUE_CAUSES: [&str; 4] = [
    "sliced for filament of 2.85 mm",
    "sliced for filament of 3 mm",
    "max_flow_mm3_per_s",
    "Machine limits cannot be emitted",
];

#[test]
fn stock_printers_are_printed_or_refused_for_their_true_cause() {
    let (true, Some(presets)) = (installed("prusa-slicer"), presets()) else {
        return skip("prusa-slicer with its presets is not installed: they are not tried");
    };
    let folder = folder();
    let (config, output) = (folder.path().join("stock.ini"), folder.path().join("out.gcode"));
    let (mut printed, mut refused) = (0, Vec::new());
    for (name, text) in chosen(&presets) {
        std::fs::write(&config, text).unwrap();
        let mut command = trunnion();
        command.args(["prepare", &fixture("two-boxes"), "-m", "generic-ac", "--slicer", "prusa-slicer", "-q", "-o"]);
        let run = command.arg(&output).arg("--slicer-config").arg(&config).output().unwrap();
        assert_eq!(run.status.success(), output.exists(), "{name}: {}", said(&run));
        let _ = std::fs::remove_file(&output);
        if run.status.success() {
            printed += 1;
            continue;
        }
        let text = said(&run);
        let cause = TRUE_CAUSES.iter().find(|cause| text.contains(**cause));
        refused.push(format!("{name}: {}", cause.unwrap_or_else(|| panic!("{name}: {text}"))));
    }
    note(&format!("stock printers: {printed} printed, {} refused\n  {}", refused.len(), refused.join("\n  ")));
    assert!(printed >= 15 && printed > 3 * refused.len(), "{printed}, {refused:?}");
}
