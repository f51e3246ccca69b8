//! The Cura script, loaded and run as Cura does it, in a harness that needs no Cura.

use std::path::Path;
use std::process::Command;

use crate::support::{folder, python, root, said, skip};

/// What Cura would have saved and shown.
pub(crate) struct Saved {
    /// The file.
    pub(crate) gcode: String,
    /// The harness's stderr: `MESSAGE: ..` for the user, `EXCEPTION: ..` for Cura's log.
    pub(crate) said: String,
}

/// `gcode` as Cura would save it with our script calling `binary` for `plan`; `None`, said aloud, without Python.
///
/// `settings` are further ones of the script, `KEY=VALUE`, or options of the harness.
pub(crate) fn through_cura(
    binary: &Path,
    gcode: &str,
    plan: &Path,
    print: Option<usize>,
    settings: &[&str],
) -> Option<Saved> {
    let Some(python) = python(&["python3"], "json") else {
        skip("python3 is not installed");
        return None;
    };
    let folder = folder();
    let (input, output) = (folder.path().join("in.gcode"), folder.path().join("out.gcode"));
    std::fs::write(&input, gcode).unwrap();
    let mut command = Command::new(python);
    command.arg(root().join("tests/harness/cura_harness.py")).arg(root().join("integrations/cura/Trunnion.py"));
    command.args([&input, &output]).env("PYTHONDONTWRITEBYTECODE", "1");
    let number = print.map(|number| number.to_string()).unwrap_or_default();
    let own =
        [format!("binary={}", binary.display()), format!("plan={}", plan.display()), format!("print_number={number}")];
    for setting in own.iter().map(String::as_str).chain(settings.iter().copied()) {
        if setting.starts_with("--") {
            command.arg(setting);
        } else {
            command.args(["--set", setting]);
        }
    }
    let run = command.output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    Some(Saved { gcode: std::fs::read_to_string(&output).unwrap(), said: said(&run) })
}

/// A cube of two layers as CuraEngine writes it, with a comment in latin script.
const CUBE: &str = "\
;FLAVOR:Marlin
;TIME:42
;Generated with Cura_SteamEngine 4.13.0 für würfel
M140 S60
M104 S210
G28
G92 E0
;LAYER_COUNT:2
;LAYER:0
M107
G0 F6000 X90 Y90 Z0.2
;TYPE:WALL-OUTER
G1 F1200 X110 E0.66\r
;TIME_ELAPSED:20
;LAYER:1
G0 X90 Y90 Z0.4
G1 X110 E1.32
;TIME_ELAPSED:42
M104 S0
;End of Gcode
";

/// `CUBE` through the stand-in for the command, which does what `behaviour` says.
fn through_fake(behaviour: &str, print: Option<usize>, settings: &[&str]) -> Option<(Saved, String)> {
    let folder = folder();
    let plan = folder.path().join("my plan.json");
    std::fs::write(&plan, format!("{behaviour}\n")).unwrap();
    let saved = through_cura(&root().join("tests/harness/fake_trunnion"), CUBE, &plan, print, settings)?;
    let arguments = std::fs::read_to_string(folder.path().join("my plan.json.arguments")).unwrap_or_default();
    Some((saved, arguments.replace(&plan.display().to_string(), "PLAN")))
}

/// Comments and one line for the display are all that such a file holds.
fn assert_prints_nothing(saved: &Saved, why: &str) {
    let harmless = |line: &str| line.is_empty() || line.starts_with(';') || line.starts_with("M117 ");
    // A carriage return ends a line for some firmwares.
    let lines: Vec<&str> = saved.gcode.split(['\n', '\r']).collect();
    assert!(lines.iter().all(|line| harmless(line)), "{}", saved.gcode);
    assert_eq!(lines.iter().filter(|line| line.starts_with("M117 trunnion: ")).count(), 1, "{}", saved.gcode);
    assert!(saved.gcode.contains(why), "{}", saved.gcode);
    assert!(!saved.said.contains("EXCEPTION"), "{}", saved.said);
}

#[cfg(unix)]
#[test]
fn cura_saves_what_the_command_wrote() {
    let Some((saved, arguments)) = through_fake("edit", Some(3), &[]) else { return };
    let wanted = CUBE.replace(";LAYER:0\n", ";TRUNNION slot=0 part=0 A=0 C=0\n;LAYER:0\n");
    // Cura puts its own mark behind the first entry.
    assert_eq!(saved.gcode.replace(";POSTPROCESSED\n", ""), wanted);
    assert!(saved.gcode.contains("A=0 C=0\n;POSTPROCESSED\n;LAYER:0"), "{}", saved.gcode);
    assert!(arguments.starts_with("--plan PLAN --print 3 ") && arguments.ends_with("cura.gcode\n"), "{arguments}");
    assert!(!saved.said.contains("MESSAGE"), "{}", saved.said);
}

#[cfg(unix)]
#[test]
fn without_a_print_number_none_is_given() {
    let Some((_, arguments)) = through_fake("edit", None, &[]) else { return };
    assert!(!arguments.is_empty() && !arguments.contains("--print"), "{arguments}");
}

#[cfg(unix)]
#[test]
fn a_refusal_saves_a_file_that_cannot_print() {
    let Some((saved, _)) = through_fake("refuse", None, &[]) else { return };
    assert_prints_nothing(&saved, "cube.gcode:7: \"G28\" cannot be rewritten safely");
    assert!(saved.said.contains("MESSAGE: cube.gcode:7: \"G28\" cannot be rewritten safely"), "{}", saved.said);
}

#[cfg(unix)]
#[test]
fn a_command_that_fails_hangs_or_does_nothing_saves_a_file_that_cannot_print() {
    for (behaviour, settings, why) in [
        ("silent", &[][..], "exit code 3"),
        ("idle", &[], "rewrote nothing"),
        ("empty", &[], "rewrote nothing"),
        ("hang", &["timeout_s=1"], "no answer from trunnion within 1 s"),
        ("refuse", &["--no-messages"], "cannot be rewritten safely"),
        ("edit", &["--forget=timeout_s"], "KeyError: 'timeout_s'"),
        ("edit", &["print_number=-1"], "is not a whole number"),
        ("edit", &["binary=no-such-program"], "cannot start 'no-such-program'"),
        ("edit", &["plan=no-such-plan.json"], "no plan file 'no-such-plan.json'"),
        ("edit", &["plan="], "no plan file ''"),
    ] {
        let Some((saved, _)) = through_fake(behaviour, None, settings) else { return };
        assert_prints_nothing(&saved, why);
    }
}

#[test]
fn the_script_is_python_as_old_as_curas() {
    let Some(python) = python(&["python3"], "ast") else { return skip("python3 is not installed") };
    // Cura 4.13 brings Python 3.7.
    let code = "import ast, sys; ast.parse(open(sys.argv[1]).read(), feature_version=(3, 7))";
    let output = Command::new(python).args(["-c", code]).arg(root().join("integrations/cura/Trunnion.py")).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", said(&output));
}
