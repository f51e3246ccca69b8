//! Start, middle and end of real files as states, and lines that their firmware takes for something else: one change each, found by its
//! rule. What we write every firmware reads alike. (Each rule alone and each size of a fault: `src/verify/tests/states.rs` and `reading.rs`.)

use trunnion::gcode::meaning::Firmware;
use trunnion::gcode::{LineRules, ParsedLine, lines};

use crate::mutants::{Victim, report};
use crate::pipeline::{fixture, prepare};
use crate::sliced_files::unpack;
use crate::support::folder;

/// A change of a file's lines; in hand are the lines of the first print's mark, of one that lays filament, and of the end's mark.
type Change = fn(&mut Vec<String>, [usize; 3]);

/// Each change by name, with the rule that must name it.
const CHANGES: [(&str, &str, Change); 14] = [
    ("words in parentheses", "reading", |lines, [_, laying, _]| lines[laying] += " (Z-5)"),
    ("a long line", "reading", |lines, [_, laying, _]| {
        let long = format!("{}{} Y", lines[laying].split(" Y").next().unwrap(), "0".repeat(100));
        lines[laying] = long + lines[laying].split(" Y").nth(1).unwrap();
    }),
    ("a word twice", "reading", |lines, [_, laying, _]| lines[laying] = lines[laying].replace(" E", " E5 E")),
    ("not homed", "unknown-position", |lines, [first, ..]| {
        let at = lines[..first].iter().position(|line| line == "G28").unwrap();
        lines.remove(at);
    }),
    ("homed over the print", "command", |lines, [.., end]| lines.insert(end + 1, "G28".to_owned())),
    ("moved over the print", "command", |lines, [.., end]| lines.insert(end + 1, "G1 X0 Y0 F6000".to_owned())),
    ("hot at the end", "heat", |lines, _| lines.push("M104 S250".to_owned())),
    ("a nozzle that is not waited for", "heat", |lines, [first, ..]| {
        let at = lines[..first].iter().position(|line| line.starts_with("M109")).unwrap();
        lines[at] = "M109".to_owned();
    }),
    ("a bed that is not waited for", "heat", |lines, _| {
        lines.iter_mut().for_each(|line| *line = line.replace("M190", "M140"));
    }),
    ("a bed switched off", "heat", |lines, [_, laying, _]| lines.insert(laying, "M140 S0".to_owned())),
    ("an object left out", "command", |lines, [first, ..]| lines.insert(first, "M486 P0".to_owned())),
    ("a low speed", "setting", |lines, [_, laying, _]| lines.insert(laying, "M203 X5".to_owned())),
    ("a high acceleration", "setting", |lines, [_, laying, _]| lines.insert(laying, "M204 S100000".to_owned())),
    ("a feed of nearly nothing", "axis-rate", |lines, [_, laying, _]| lines[laying] += " F0.01"),
];

#[test]
fn each_state_that_is_wrong_is_found() {
    let victim = Victim::of("two-boxes");
    for (name, rule, change) in CHANGES {
        let file = victim.changed(|lines| {
            let find = |start: &str| lines.iter().position(|line| line.starts_with(start)).unwrap();
            let (first, end) = (find(";TRUNNION slot="), find(";TRUNNION end"));
            let middle = usize::midpoint(first, end);
            let lays = |line: &String| line.starts_with("G1 X") && line.contains(" Y") && line.contains(" E0.");
            let laying = middle + lines[middle..].iter().position(lays).unwrap();
            change(lines, [first, laying, end]);
        });
        let report = report(&file, &victim.plan);
        let found = report["findings"].as_array().unwrap();
        assert!(found.iter().any(|finding| finding["rule"] == rule), "{name}: {found:#?}");
    }
}

/// Every line of `file` that a firmware would read otherwise.
fn misread(file: &[u8]) -> Vec<String> {
    let mut parsed = ParsedLine::default();
    let mut all = Vec::new();
    for line in lines(file) {
        parsed.read(line.bytes).unwrap();
        for (name, firmware) in Firmware::NAMES {
            if let Some(wrong) = LineRules::of(firmware).misreading(line.bytes, &parsed) {
                all.push(format!("{name} {wrong}: {}", String::from_utf8_lossy(line.bytes)));
            }
        }
    }
    all
}

#[test]
fn what_we_write_all_five_firmwares_read_alike() {
    let folder = folder();
    let output = folder.path().join("out.gcode");
    for machine in ["generic-ac", "open5x-prusa", "fractal-5-pro", "grblhal-ac", "linuxcnc-xyzac-trt"] {
        prepare(&fixture("two-boxes"), machine, "builtin", &output, &[]);
        assert_eq!(misread(&std::fs::read(&output).unwrap()), Vec::<String>::new(), "{machine}");
    }
}

#[test]
fn what_slicers_write_is_read_alike_by_the_firmware_it_is_for() {
    for (name, firmware) in [
        ("ps_base_rel", Firmware::Marlin),
        ("ps_base_rel_crlf", Firmware::Marlin),
        ("ps_base720_arcs", Firmware::Marlin),
        ("ps_stem_abs", Firmware::Marlin),
        ("ps_armL_fwretract", Firmware::Marlin),
        ("ps_four_labels", Firmware::Marlin),
        ("ps_seq4", Firmware::Marlin),
        ("ps_klipper_macros", Firmware::Klipper),
        ("s3_rel_fwretract", Firmware::Marlin),
        ("s3_two_parts_merge", Firmware::Marlin),
        ("cu_four_parts", Firmware::Marlin),
        ("cu_seq3", Firmware::Marlin),
    ] {
        let Some(bytes) = unpack(name) else { return };
        let mut parsed = ParsedLine::default();
        for line in lines(&bytes) {
            parsed.read(line.bytes).unwrap();
            let wrong = LineRules::of(firmware).misreading(line.bytes, &parsed);
            assert_eq!(wrong, None, "{name}:{}: {}", line.number, String::from_utf8_lossy(line.bytes));
        }
    }
}
