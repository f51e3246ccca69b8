//! What describes no machine is refused with file and line, and what is not understood is said.

use super::{import, lay, request, small_ini, small_klipper, small_marlin, small_reprap, with_rest};
use crate::support::folder;

/// What the import says of files, of which the first is given, without their folder; `Ok` with the notes.
fn says(files: &[(&'static str, String)], set: &[(&str, &str)]) -> Result<Vec<String>, String> {
    let folder = folder();
    lay(folder.path(), &files.to_vec());
    let plain = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let done = with_rest(folder.path(), &[files[0].0], set).map_err(plain)?;
    Ok(done.notes.into_iter().map(plain).collect())
}

/// The refusal of one file.
fn refusal(name: &'static str, text: &str) -> String {
    refusal_of(&[(name, text.to_owned())])
}

fn refusal_of(files: &[(&'static str, String)]) -> String {
    says(files, &[]).expect_err(files[0].0)
}

fn one(what: &str, got: &str, wanted: &str) {
    assert!(got.contains(wanted), "{what}: {got:?} has no {wanted:?}");
}

#[test]
fn the_small_files_are_fine_as_they_are() {
    for (name, text) in [
        ("Configuration.h", small_marlin()),
        ("m.ini", small_ini()),
        ("printer.cfg", small_klipper()),
        ("config.g", small_reprap()),
    ] {
        assert_eq!(says(&[(name, text)], &[]), Ok(Vec::new()), "{name}");
    }
}

/// A machine that does not know the command with which the shipped start chooses its kinematics.
#[test]
fn an_ini_without_a_remap_for_the_identity_kinematics_is_told() {
    let without = small_ini().replace("REMAP = M429", "REMAP = M430");
    let notes = says(&[("m.ini", without)], &[]).unwrap();
    assert!(notes.len() == 1 && notes[0].contains("m.ini:2: no REMAP defines M429"), "{notes:?}");
}

#[test]
fn what_is_no_configuration_is_refused() {
    one("empty", &refusal("a.ini", " \n"), "a.ini: the file is empty");
    one("prose", &refusal("a.ini", "once upon a time\n"), "searched for the sections [KINS], [TRAJ] or [EMC]");
    one("hal alone", &refusal("a.hal", "setp a 1\n"), "give the ini that names them");
    let folder = folder();
    std::fs::write(folder.path().join("b.ini"), [0xff_u8, 0, 1, 0xfe]).unwrap();
    one("binary", &with_rest(folder.path(), &["b.ini"], &[]).unwrap_err(), "not a text file");
    one("none", &with_rest(folder.path(), &["c.ini"], &[]).unwrap_err(), "file not found");
    lay(folder.path(), &vec![("m.ini", small_ini()), ("k.cfg", small_klipper())]);
    one("two", &with_rest(folder.path(), &["m.ini", "k.cfg"], &[]).unwrap_err(), "it is Klipper's, and");
    // The kind is told by what is in it.
    lay(folder.path(), &vec![("odd.txt", small_reprap())]);
    assert_eq!(with_rest(folder.path(), &["odd.txt"], &[]).unwrap().firmware(), "reprapfirmware");
    one(
        "name",
        &import(&super::ImportProfile { name: Some("fibr3d".to_owned()), ..request(folder.path(), &["m.ini"]) })
            .unwrap_err(),
        "must not be a shipped profile's",
    );
}

/// A change of a good file, and what is said of it.
fn changed(good: &str, name: &'static str, changes: &[(&str, &str, &str)]) {
    for (from, to, wanted) in changes {
        assert!(good.contains(from), "{from:?} is not in {good}");
        one(to, &refusal(name, &good.replacen(from, to, 1)), wanted);
    }
}

#[test]
fn an_ini_that_makes_no_sense_is_refused_with_its_line() {
    let long = "x".repeat(100_000);
    changed(
        &small_ini(),
        "m.ini",
        &[
            (
                "LINEAR_UNITS = mm",
                "LINEAR_UNITS = furlong",
                "m.ini:5: LINEAR_UNITS = \"furlong\" is not a unit; known are mm",
            ),
            ("LINEAR_UNITS = mm\n", "", "m.ini: [TRAJ] has no LINEAR_UNITS"),
            (
                "MIN_LIMIT = -200",
                "MIN_LIMIT = minus",
                "m.ini:10: [AXIS_X] MIN_LIMIT is \"minus\", which is not a number",
            ),
            ("MIN_LIMIT = -200", "MIN_LIMIT = nan", "m.ini:10: [AXIS_X] MIN_LIMIT is \"nan\", which is not a number"),
            ("MIN_LIMIT = -200", &format!("MIN_LIMIT = {long}"), "xxx\".., which is not a number"),
            (
                "MIN_LIMIT = -200",
                "MIN_LIMIT = -200\nMIN_LIMIT = -150",
                "m.ini:11: [AXIS_X] MIN_LIMIT is -150 here, but -200 in ",
            ),
            ("MIN_LIMIT = -100\nMAX_LIMIT = 50", "MIN_LIMIT = 50\nMAX_LIMIT = -100", "m.ini:23: A goes from 50 ("),
            ("MIN_LIMIT = -200", "MIN_LIMIT = 300", "the lowest end must be below the highest"),
            ("[AXIS_A]\n", "[JOINT_3]\nMAX_LIMIT = -150\n[AXIS_A]\n", "m.ini:22: A goes from -100"),
            (
                "MIN_LIMIT = -100\nMAX_LIMIT = 50",
                "MIN_LIMIT = 300\nMAX_LIMIT = 350",
                "m.ini:22: kinematics.tilt.min_deg = 300.0: must be -180..180 deg",
            ),
            (
                "MIN_LIMIT = -100\nMAX_LIMIT = 50",
                "MIN_LIMIT = 20\nMAX_LIMIT = 50",
                "must be a range that includes level",
            ),
            ("MIN_LIMIT = -3600\n", "", "C has a limit on one side only"),
            ("[AXIS_C]\n", "[AXIS_C]\nWRAPPED_ROTARY = 1\n", "m.ini:26: [AXIS_C] WRAPPED_ROTARY"),
            ("XYZACU", "XYZAU", "this machine has no turning table: [TRAJ] COORDINATES = \"XYZAU\""),
            (
                "xyzac-trt-kins sparm",
                "5axiskins sparm",
                "m.ini:2: kinematics \"5axiskins\" is not a table that tilts and turns",
            ),
            ("KINEMATICS", "KIN", "[KINS] has no KINEMATICS"),
            (
                "y-offset 20\n",
                "y-offset 20\nHALCMD = setp xyzac-trt-kins.y-offset 21\n",
                "m.ini:8: xyzac-trt-kins.y-offset is 21 here, but 20 in ",
            ),
            ("y-offset 20\n", "y-offset [NO]WHERE\n", "m.ini:7: \"[NO]WHERE\" is not in the ini"),
            ("y-offset 20\n", "y-offset 2O\n", "m.ini:7: xyzac-trt-kins.y-offset is \"2O\", which is not a number"),
            (
                "y-offset 20\n",
                "y-offset 20\nHALCMD = setp xyzac-trt-kins.tool-offset 5\n",
                "m.ini:8: xyzac-trt-kins.tool-offset is 5",
            ),
            ("[HAL]\n", "[HAL]\nHALFILE = gone.hal\n", "gone.hal: file not found; put it beside the ini"),
            ("[KINS]", "#INCLUDE gone.inc\n[KINS]", "gone.inc: file not found; put it beside the ini"),
        ],
    );
}

#[test]
fn files_that_name_each_other_in_a_circle_are_refused() {
    let ini = small_ini();
    let of =
        |inner: &str| vec![("m.ini", ini.replace("[HAL]\n", "[HAL]\nHALFILE = a.hal\n")), ("a.hal", inner.to_owned())];
    one(
        "itself",
        &refusal_of(&of("source a.hal\n")),
        "a.hal was read already: the files include each other in a circle",
    );
    one("the ini", &refusal("m.ini", &format!("#INCLUDE ./m.ini\n{ini}")), "in a circle");
    let klipper = small_klipper();
    one(
        "klipper",
        &refusal_of(&[("k.cfg", format!("{klipper}[include a.cfg]\n")), ("a.cfg", "[include ./k.cfg]\n".to_owned())]),
        "in a circle",
    );
    one("gone", &refusal("k.cfg", &format!("{klipper}[include gone.cfg]\n")), "gone.cfg: file not found");
    one("a star takes itself", &refusal("k.cfg", &format!("{klipper}[include *.cfg]\n")), "in a circle");
    assert_eq!(says(&[("k.cfg", format!("{klipper}[include none/*.cfg]\n"))], &[]), Ok(Vec::new()));
    let reprap = small_reprap();
    one("reprap", &refusal("config.g", &format!("{reprap}M98 P\"0:/sys/config.g\"\n")), "in a circle");
    one(
        "gone",
        &refusal("config.g", &format!("{reprap}M98 P\"more.g\"\n")),
        "more.g: file not found; copy it from the board",
    );
    // Twice the same file, one after the other, is no circle; without end it is told apart by its count.
    let twice =
        vec![("k.cfg", format!("{klipper}[include a.cfg]\n[include a.cfg]\n")), ("a.cfg", "[mcu]\n".to_owned())];
    assert_eq!(says(&twice, &[]), Ok(Vec::new()));
    let mut tree = vec![("k.cfg", format!("{klipper}[include 0.cfg]\n"))];
    for (i, name) in
        ["0.cfg", "1.cfg", "2.cfg", "3.cfg", "4.cfg", "5.cfg", "6.cfg", "7.cfg", "8.cfg"].into_iter().enumerate()
    {
        tree.push((name, format!("[include {0}.cfg]\n[include {0}.cfg]\n", i + 1)));
    }
    tree.push(("9.cfg", "[mcu]\n".to_owned()));
    one("too many", &refusal_of(&tree), "more than 200 files are named");
}

#[test]
fn a_printer_cfg_that_makes_no_sense_is_refused_with_its_line() {
    changed(
        &small_klipper(),
        "k.cfg",
        &[
            (
                "position_max: 150",
                "position_max: 15O",
                "k.cfg:6: [stepper_x] position_max is \"15O\", which is not a number",
            ),
            (
                "position_max: 150",
                "position_max: 150\nposition_max: 120",
                "k.cfg:7: [stepper_x] position_max is 120 here, but 150 in ",
            ),
            ("position_max: 150", "position_max: 150\nposition_min: 160", "X goes from 160 ("),
            ("kinematics: corexy", "kinematics: trunnion_bc", "k.cfg:2: kinematics \"trunnion_bc\" is unknown"),
            ("kinematics: corexy\n", "", "[printer] has no kinematics"),
            ("STEPPER=rot GCODE_AXIS=C", "STEPPER=rot GCODE_AXIS=", "[manual_stepper rot] has no letter"),
            ("STEPPER=rot GCODE_AXIS=C", "STEPPER=rot GCODE_AXIS=A", "A is the axis of tilt already"),
            (
                "  MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A",
                "  MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A\n  MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=B",
                "GCODE_AXIS of tilt is B here, but A in ",
            ),
            ("[manual_stepper rot]", "[servo rot]", "this machine has no turning table"),
            (
                "max_velocity: 200",
                "max_velocity: 0",
                "k.cfg:3: limits.max_feed_mm_per_min = 0.0: must be 1..120000 mm/min",
            ),
            (
                "[manual_stepper tilt]",
                "[manual_stepper tilt]\nposition_min: 5\nposition_max: 90",
                "must be a range that includes level",
            ),
        ],
    );
    // What is commented out is not there.
    let text = small_klipper().replace("[stepper_x]\nposition_max: 150", "[stepper_x]\n#position_max: 150");
    let folder = folder();
    lay(folder.path(), &vec![("k.cfg", text)]);
    assert!(with_rest(folder.path(), &["k.cfg"], &[]).unwrap().unanswered.contains(&"limits.x_mm"));
    let said = |text: String| says(&[("k.cfg", text)], &[]).unwrap().join("\n");
    one("no bed", &said(small_klipper().replace("heater_bed", "heater")), "there is no [heater_bed]");
    one(
        "delta",
        &said(small_klipper().replace("corexy", "delta")),
        "kinematics delta has no readable limits of X, Y and Z",
    );
    one(
        "template",
        &said(small_klipper().replace("AXIS=C", "AXIS=C LIMIT_VELOCITY={speed}")),
        "is computed by Klipper",
    );
    one("fast", &said(small_klipper().replace("max_accel: 2000", "max_accel: 20000")), "limits.junction_mm = ");
}

#[test]
fn a_config_g_that_makes_no_sense_is_refused_with_its_line() {
    changed(
        &small_reprap(),
        "config.g",
        &[
            ("X-100:100", "X-1,5:100", "config.g:3: M208 X is \"-1,5\", which is not a number"),
            (" Z-20:150", "\nM208 Z125 S1\nM208 Z-1 S0\nM208", "config.g:5: Z goes from 125 ("),
            (
                "A-90:90",
                "A200:300",
                "config.g:3: kinematics.tilt.min_deg = 200.0: must be -180..180 deg; if the machine does otherwise, pass",
            ),
            ("M203", "M208 X-90 S1\nM203", "config.g:4: M208 X is -90 here, but -100 in "),
            ("M203 X6000", "M203 X{60*100}", "config.g:4: M203 X is \"{60*100}\", which the firmware computes"),
            ("M203", "if true\n  M203", "config.g:5: M203 is under a condition"),
            ("A3 C4", "A3", "config.g:2: this machine has no turning table"),
            ("M203", "G20\nM203", "config.g:4: G20 switches to inches"),
        ],
    );
    let said = |text: String| says(&[("config.g", text)], &[]).unwrap().join("\n");
    one("delta", &said(small_reprap() + "M669 K3\n"), ": M669 K3 is not one of RepRapFirmware's plain kinematics");
    // The fork for robots, as on a published five-axis machine: it was noted alone.
    one(
        "robot",
        &refusal("config.g", &(small_reprap() + "M669 K13 B\"CoreXY5AC\"\n")),
        "makes the firmware follow the tip",
    );
    one("no bed", &said(small_reprap() + "M140 H-1\n"), "M190 would wait for ever");
    one(
        "under",
        &said(small_reprap() + "if fileexists(\"0:/sys/x.g\")\n  M98 P\"x.g\"\n"),
        "a conditional M98 is not followed",
    );
    assert_eq!(said(small_reprap() + "; M208 X-5:5\nM117 \"M208 X3\"\nif true\n  M117 \"x\"\nM201 A200\n"), "");
    // An answer goes over what no table does.
    let wide = small_reprap().replace("A-90:90", "A-200:200");
    let set = [("kinematics.tilt.min_deg", "-30"), ("kinematics.tilt.max_deg", "60")];
    assert_eq!(says(&[("config.g", wide)], &set), Ok(Vec::new()));
}

#[test]
fn which_axis_tilts_is_never_guessed() {
    let uv = small_reprap().replace(['A'], "U").replace("C4", "V4").replace("C2400", "V2400").replace("C300", "V300");
    let folder = folder();
    lay(folder.path(), &vec![("config.g", uv)]);
    let untold = import(&request(folder.path(), &["config.g"])).unwrap_err();
    for key in [
        "kinematics.tilt.letter (",
        "kinematics.tilt.about (",
        "kinematics.rotation.letter (",
        "kinematics.tilt.direction (",
    ] {
        one("asked", &untold, key);
    }
    assert!(!untold.contains("kinematics.tilt.min_deg"), "{untold}");
    let set = [
        ("kinematics.tilt.letter", "V"),
        ("kinematics.tilt.about", "Y"),
        ("kinematics.rotation.letter", "U"),
        ("kinematics.tilt.min_deg", "-9"),
        ("kinematics.tilt.max_deg", "9"),
    ];
    let done = with_rest(folder.path(), &["config.g"], &set).unwrap();
    let k = &done.profile.kinematics;
    // V's 2400 degrees a minute, and U's 1200.
    assert_eq!((k.tilt.max_deg_per_s, k.rotation.max_deg_per_s, k.rotation.max_deg), (40.0, 20.0, Some(90.0)));
    let set = [("kinematics.tilt.letter", "Q")];
    one(
        "no such axis",
        &with_rest(folder.path(), &["config.g"], &set).unwrap_err(),
        "no rotary axis is called Q; there are U (",
    );
}

#[test]
fn a_configuration_h_that_makes_no_sense_is_refused_with_its_line() {
    let long = format!("#define X_MIN_POS {}1{}", "(".repeat(50_000), ")".repeat(50_000));
    changed(
        &small_marlin(),
        "c.h",
        &[
            (
                "{ 200, 200, 10, 30, 40, 25 }",
                "{ 200, 200, 10, 25 }",
                "c.h:13: DEFAULT_MAX_FEEDRATE has 4 numbers, and this machine 5 axes",
            ),
            ("{ 200, 200, 10, 30, 40, 25 }", "200", "c.h:13: DEFAULT_MAX_FEEDRATE is \"200\", which is not a number"),
            (
                "X_MIN_POS -100",
                "X_MIN_POS X_LOW",
                "c.h:14: X_MIN_POS is \"X_LOW\", which is not a number in these files",
            ),
            ("X_MIN_POS -100", "X_MIN_POS (X_MIN_POS)", "c.h:14: X_MIN_POS is \"(X_MIN_POS)\", which is not a number"),
            ("#define X_MIN_POS -100", &long, "((((\".., which is not a number"),
            (
                "X_MIN_POS -100\n",
                "X_MIN_POS -100\n#define X_MIN_POS -90\n",
                "c.h:15: X_MIN_POS is -90 here, but -100 in c.h:14",
            ),
            (
                "I_MIN_POS -90\n#define I_MAX_POS 90",
                "I_MIN_POS 90\n#define I_MAX_POS -90",
                "c.h:21: A goes from 90 (c.h:20) to -90",
            ),
            ("#define J_DRIVER_TYPE", "//#define J_DRIVER_TYPE", "this machine has no turning table"),
            ("  #define AXIS5_ROTATES", "  //#define AXIS5_ROTATES", "there is only A"),
            ("#ifdef J_DRIVER_TYPE\n", "#if HAS_J\n", "this machine has no turning table"),
            ("AXIS4_NAME 'A'", "AXIS4_NAME 5", "c.h:6: AXIS4_NAME is \"5\", which is not a letter"),
            ("#endif\n#define DEFAULT", "#define DEFAULT", "c.h:9: this #if has no #endif"),
            ("#define DEFAULT", "#endif\n#define DEFAULT", "c.h:13: there is no #if before it"),
            (
                "#define DEFAULT",
                "#define PENTA_AXIS_HT\n#define DEFAULT",
                "c.h:13: PENTA_AXIS_HT is not a table that tilts and turns",
            ),
            (
                "#define DEFAULT",
                "#define BAUDRATE 0.5\n#define DEFAULT",
                "c.h:13: BAUDRATE is 0.5, which is not a whole number",
            ),
            (
                "#define DEFAULT",
                "#define BAUDRATE 50\n#define DEFAULT",
                "c.h:13: link.baud = 50: must be 300..12000000",
            ),
            ("#define DEFAULT", "#include \"gone.h\"\n#define DEFAULT", "gone.h: file not found"),
            ("#define DEFAULT", "#include \"./c.h\"\n#define DEFAULT", "in a circle"),
        ],
    );
    // The fork's table is like no other Marlin's: a start that does not end its following of the tip is none for it.
    let penta = small_marlin() + "#define PENTA_AXIS_TRT\n";
    let folder_of = folder();
    lay(folder_of.path(), &vec![("c.h", penta)]);
    let done = with_rest(folder_of.path(), &["c.h"], &[]).unwrap();
    assert_eq!(
        (done.like.name.as_str(), done.profile.link.identity.as_str()),
        ("hendrikjan-5d", "KINEMATICS:PENTA_AXIS_TRT")
    );
    assert!(done.profile.dialect.start.contains("G49\nG28"), "{}", done.profile.dialect.start);
    let mut like = request(folder_of.path(), &["c.h"]);
    (like.like, like.answers.rest) = (Some("generic-ac".into()), true);
    one(
        "like generic-ac",
        &import(&like).unwrap_err(),
        "\"G28\": a firmware with PENTA_AXIS may follow the tip from power-on",
    );
    // Comments, other branches and conditions that are not told give no key.
    let with = |more: &str| {
        let folder = folder();
        lay(folder.path(), &vec![("c.h", small_marlin() + more)]);
        let done = with_rest(folder.path(), &["c.h"], &[]).unwrap_or_else(|e| panic!("{more}: {e}"));
        (done.profile.link.baud, done.facts.iter().any(|fact| fact.key == "link.baud"), done.notes.join("\n"))
    };
    for (more, baud) in [
        ("#define BAUDRATE 9600\n", Some(9600)),
        ("//#define BAUDRATE 9600\n", None),
        ("/* #define BAUDRATE 1\n#define BAUDRATE 9600\n*/\n", None),
        ("#if 0\n#define BAUDRATE 9600\n#endif\n", None),
        (
            "#if DISABLED(X_ON) && (2 > 1 || HAS_A)\n#define BAUDRATE (96 * 100) // fast\n#else\n#define BAUDRATE 1\n#endif\n",
            Some(9600),
        ),
        (
            "#define X_ON\n#if ANY(X_ON, HAS_A)\n#ifndef BAUDRATE\n#define BAUDRATE \\\n 9600\n#endif\n#elif 1\n#define BAUDRATE 2\n#endif\n",
            Some(9600),
        ),
        ("#define BAUDRATE 1200\n#undef BAUDRATE\n#define BAUDRATE 9600UL\n", Some(9600)),
        ("#define T \"a // b /* c\"\n#error \"don't\"\n#define BAUDRATE 9600\n", Some(9600)),
    ] {
        let (found, stated, notes) = with(more);
        assert_eq!((stated.then_some(found), notes.as_str()), (baud, ""), "{more}");
    }
    for more in
        ["#if HAS_A\n#define BAUDRATE 9600\n#endif\n", "#if SOMEWHERE == 2\n#else\n#define BAUDRATE 9600\n#endif\n"]
    {
        let (_, stated, notes) = with(more);
        assert!(
            !stated && notes.contains("BAUDRATE is under a condition that these files do not decide"),
            "{more}: {notes}"
        );
    }
}
