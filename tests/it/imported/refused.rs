//! What describes no machine is refused with file and line, and what is not understood is said.

use super::{import, lay, request, small_ini, small_klipper, small_marlin, small_reprap, with_rest};
use crate::support::{fails, folder, states};

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

/// A refusal, by its code and the facts of its sentence.
fn one(what: &str, got: &str, wanted: &str) {
    assert!(fails(got, wanted), "{what}: {got:?} is not {wanted:?}");
}

/// One of the notes has these facts.
fn noted(what: &str, notes: &str, facts: &str) {
    assert!(states(notes, facts), "{what}: {notes:?} has no {facts:?}");
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
    assert!(notes.len() == 1 && states(&notes[0], "m.ini:2 | REMAP | M429"), "{notes:?}");
}

#[test]
fn what_is_no_configuration_is_refused() {
    one("empty", &refusal("a.ini", " \n"), "import/file: a.ini | empty");
    one("prose", &refusal("a.ini", "once upon a time\n"), "import/file: a.ini | [KINS], [TRAJ] | [EMC]");
    one("hal alone", &refusal("a.hal", "setp a 1\n"), "import/file: a.hal | ini");
    let folder = folder();
    std::fs::write(folder.path().join("b.ini"), [0xff_u8, 0, 1, 0xfe]).unwrap();
    one("binary", &with_rest(folder.path(), &["b.ini"], &[]).unwrap_err(), "file/not-text: b.ini");
    one("none", &with_rest(folder.path(), &["c.ini"], &[]).unwrap_err(), "input/absent: c.ini");
    lay(folder.path(), &vec![("m.ini", small_ini()), ("k.cfg", small_klipper())]);
    one(
        "two",
        &with_rest(folder.path(), &["m.ini", "k.cfg"], &[]).unwrap_err(),
        "import/file: k.cfg | a Klipper file | m.ini | a LinuxCNC file",
    );
    // The kind is told by what is in it.
    lay(folder.path(), &vec![("odd.txt", small_reprap())]);
    assert_eq!(with_rest(folder.path(), &["odd.txt"], &[]).unwrap().firmware(), "reprapfirmware");
    one(
        "name",
        &import(&super::ImportProfile { name: Some("fibr3d".to_owned()), ..request(folder.path(), &["m.ini"]) })
            .unwrap_err(),
        "job/answer: name | fibr3d",
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
            ("LINEAR_UNITS = mm", "LINEAR_UNITS = furlong", "import/at: m.ini:5 | LINEAR_UNITS | \"furlong\" | mm"),
            ("LINEAR_UNITS = mm\n", "", "import/file: m.ini | [TRAJ] | LINEAR_UNITS"),
            ("MIN_LIMIT = -200", "MIN_LIMIT = minus", "import/at: m.ini:10 | [AXIS_X] MIN_LIMIT | \"minus\""),
            ("MIN_LIMIT = -200", "MIN_LIMIT = nan", "import/at: m.ini:10 | [AXIS_X] MIN_LIMIT | \"nan\""),
            ("MIN_LIMIT = -200", &format!("MIN_LIMIT = {long}"), "import/at: m.ini:10 | [AXIS_X] MIN_LIMIT | \".."),
            (
                "MIN_LIMIT = -200",
                "MIN_LIMIT = -200\nMIN_LIMIT = -150",
                "import/contradiction: m.ini:11 | [AXIS_X] MIN_LIMIT | -150 | -200 | m.ini:10",
            ),
            ("MIN_LIMIT = -100\nMAX_LIMIT = 50", "MIN_LIMIT = 50\nMAX_LIMIT = -100", "import/at: m.ini:23 | A | 50"),
            ("MIN_LIMIT = -200", "MIN_LIMIT = 300", "import/at: m.ini:11 | X | 300 (m.ini:10) | 200"),
            ("[AXIS_A]\n", "[JOINT_3]\nMAX_LIMIT = -150\n[AXIS_A]\n", "import/at: m.ini:22 | A | -100"),
            (
                "MIN_LIMIT = -100\nMAX_LIMIT = 50",
                "MIN_LIMIT = 300\nMAX_LIMIT = 350",
                "import/at: m.ini:22 | kinematics.tilt.min_deg | 300.0 | -180..180 deg",
            ),
            (
                "MIN_LIMIT = -100\nMAX_LIMIT = 50",
                "MIN_LIMIT = 20\nMAX_LIMIT = 50",
                "profile/range: m.ini:22 | kinematics.tilt.min_deg | 20..50",
            ),
            ("MIN_LIMIT = -3600\n", "", "import/at: m.ini:26 | C"),
            ("[AXIS_C]\n", "[AXIS_C]\nWRAPPED_ROTARY = 1\n", "import/at: m.ini:26 | [AXIS_C] WRAPPED_ROTARY"),
            ("XYZACU", "XYZAU", "import/at: m.ini:4 | [TRAJ] COORDINATES | \"XYZAU\""),
            ("xyzac-trt-kins sparm", "5axiskins sparm", "import/at: m.ini:2 | kinematics \"5axiskins\""),
            ("KINEMATICS", "KIN", "import/file: m.ini | [KINS] | KINEMATICS"),
            (
                "y-offset 20\n",
                "y-offset 20\nHALCMD = setp xyzac-trt-kins.y-offset 21\n",
                "import/contradiction: m.ini:8 | xyzac-trt-kins.y-offset | 21 | 20 | m.ini:7",
            ),
            ("y-offset 20\n", "y-offset [NO]WHERE\n", "import/at: m.ini:7 | \"[NO]WHERE\""),
            ("y-offset 20\n", "y-offset 2O\n", "import/at: m.ini:7 | xyzac-trt-kins.y-offset | \"2O\""),
            (
                "y-offset 20\n",
                "y-offset 20\nHALCMD = setp xyzac-trt-kins.tool-offset 5\n",
                "import/at: m.ini:8 | xyzac-trt-kins.tool-offset | 5",
            ),
            ("[HAL]\n", "[HAL]\nHALFILE = gone.hal\n", "import/at: m.ini:7 | gone.hal | ini"),
            ("[KINS]", "#INCLUDE gone.inc\n[KINS]", "import/at: m.ini:1 | gone.inc | ini"),
        ],
    );
}

#[test]
fn files_that_name_each_other_in_a_circle_are_refused() {
    let ini = small_ini();
    let of =
        |inner: &str| vec![("m.ini", ini.replace("[HAL]\n", "[HAL]\nHALFILE = a.hal\n")), ("a.hal", inner.to_owned())];
    one("itself", &refusal_of(&of("source a.hal\n")), "import/at: a.hal:1 | a.hal | itself");
    one("the ini", &refusal("m.ini", &format!("#INCLUDE ./m.ini\n{ini}")), "import/at: m.ini:1 | itself");
    let klipper = small_klipper();
    one(
        "klipper",
        &refusal_of(&[("k.cfg", format!("{klipper}[include a.cfg]\n")), ("a.cfg", "[include ./k.cfg]\n".to_owned())]),
        "import/at: a.cfg:1 | k.cfg | itself",
    );
    one("gone", &refusal("k.cfg", &format!("{klipper}[include gone.cfg]\n")), "import/at: k.cfg:23 | gone.cfg");
    one(
        "a star takes itself",
        &refusal("k.cfg", &format!("{klipper}[include *.cfg]\n")),
        "import/at: k.cfg:23 | itself",
    );
    assert_eq!(says(&[("k.cfg", format!("{klipper}[include none/*.cfg]\n"))], &[]), Ok(Vec::new()));
    let reprap = small_reprap();
    one(
        "reprap",
        &refusal("config.g", &format!("{reprap}M98 P\"0:/sys/config.g\"\n")),
        "import/at: config.g:6 | itself",
    );
    one("gone", &refusal("config.g", &format!("{reprap}M98 P\"more.g\"\n")), "import/at: config.g:6 | more.g");
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
    one("too many", &refusal_of(&tree), "import/at: 8.cfg:2 | 200");
}

#[test]
fn a_printer_cfg_that_makes_no_sense_is_refused_with_its_line() {
    changed(
        &small_klipper(),
        "k.cfg",
        &[
            ("position_max: 150", "position_max: 15O", "import/at: k.cfg:6 | [stepper_x] position_max | \"15O\""),
            (
                "position_max: 150",
                "position_max: 150\nposition_max: 120",
                "import/contradiction: k.cfg:7 | [stepper_x] position_max | 120 | 150 | k.cfg:6",
            ),
            (
                "position_max: 150",
                "position_max: 150\nposition_min: 160",
                "import/at: k.cfg:6 | X | 160 (k.cfg:7) | 150",
            ),
            ("kinematics: corexy", "kinematics: trunnion_bc", "import/at: k.cfg:2 | kinematics | \"trunnion_bc\""),
            ("kinematics: corexy\n", "", "import/file: k.cfg | [printer] | kinematics"),
            (
                "STEPPER=rot GCODE_AXIS=C",
                "STEPPER=rot GCODE_AXIS=",
                "import/at: k.cfg:16 | [manual_stepper rot] | GCODE_AXIS",
            ),
            ("STEPPER=rot GCODE_AXIS=C", "STEPPER=rot GCODE_AXIS=A", "import/at: k.cfg:20 | A | tilt | k.cfg:15"),
            (
                "  MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A",
                "  MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A\n  MANUAL_STEPPER STEPPER=tilt GCODE_AXIS=B",
                "import/contradiction: k.cfg:16 | GCODE_AXIS | tilt | B | A",
            ),
            ("[manual_stepper rot]", "[servo rot]", "import/at: k.cfg:15 | only A"),
            (
                "max_velocity: 200",
                "max_velocity: 0",
                "import/at: k.cfg:3 | limits.max_feed_mm_per_min | 0.0 | 1..120000 mm/min",
            ),
            (
                "[manual_stepper tilt]",
                "[manual_stepper tilt]\nposition_min: 5\nposition_max: 90",
                "profile/range: k.cfg:12 | kinematics.tilt.min_deg | 5..90",
            ),
        ],
    );
    // What is commented out is not there.
    let text = small_klipper().replace("[stepper_x]\nposition_max: 150", "[stepper_x]\n#position_max: 150");
    let folder = folder();
    lay(folder.path(), &vec![("k.cfg", text)]);
    assert!(with_rest(folder.path(), &["k.cfg"], &[]).unwrap().unanswered.contains(&"limits.x_mm"));
    let said = |text: String| says(&[("k.cfg", text)], &[]).unwrap().join("\n");
    noted("no bed", &said(small_klipper().replace("heater_bed", "heater")), "[heater_bed] | M140 and M190");
    noted("delta", &said(small_klipper().replace("corexy", "delta")), "k.cfg:2 | kinematics delta | X, Y and Z");
    let template = said(small_klipper().replace("AXIS=C", "AXIS=C LIMIT_VELOCITY={speed}"));
    noted("template", &template, "k.cfg:20 | LIMIT_VELOCITY | {speed}");
    noted(
        "fast",
        &said(small_klipper().replace("max_accel: 2000", "max_accel: 20000")),
        "k.cfg:4 | limits.junction_mm | 0.001..1 mm",
    );
}

#[test]
fn a_config_g_that_makes_no_sense_is_refused_with_its_line() {
    changed(
        &small_reprap(),
        "config.g",
        &[
            ("X-100:100", "X-1,5:100", "import/at: config.g:3 | M208 X | \"-1,5\""),
            (" Z-20:150", "\nM208 Z125 S1\nM208 Z-1 S0\nM208", "import/at: config.g:5 | Z | 125"),
            ("A-90:90", "A200:300", "import/at: config.g:3 | kinematics.tilt.min_deg | 200.0 | -180..180 deg | --set"),
            ("M203", "M208 X-90 S1\nM203", "import/contradiction: config.g:4 | M208 X | -90 | -100 | config.g:3"),
            ("M203 X6000", "M203 X{60*100}", "import/at: config.g:4 | M203 X | \"{60*100}\" | firmware"),
            ("M203", "if true\n  M203", "import/at: config.g:5 | M203"),
            ("A3 C4", "A3", "import/at: config.g:2 | only A"),
            ("M203", "G20\nM203", "import/at: config.g:4 | G20"),
        ],
    );
    let said = |text: String| says(&[("config.g", text)], &[]).unwrap().join("\n");
    noted("delta", &said(small_reprap() + "M669 K3\n"), "config.g:6 | M669 K3");
    // The fork for robots, as on a published five-axis machine: it was noted alone.
    one(
        "robot",
        &refusal("config.g", &(small_reprap() + "M669 K13 B\"CoreXY5AC\"\n")),
        "import/at: config.g:6 | M669 K13",
    );
    noted("no bed", &said(small_reprap() + "M140 H-1\n"), "config.g:6 | M140 H-1 | M190");
    let under = said(small_reprap() + "if fileexists(\"0:/sys/x.g\")\n  M98 P\"x.g\"\n");
    noted("under", &under, "config.g:7 | M98");
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
        assert!(fails(&untold, "job/untold") && untold.contains(key), "{key}: {untold}");
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
        "import/file: config.g | Q | U | V | config.g:2",
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
                "import/at: c.h:13 | DEFAULT_MAX_FEEDRATE | 4 numbers | 5 axes",
            ),
            ("{ 200, 200, 10, 30, 40, 25 }", "200", "import/at: c.h:13 | DEFAULT_MAX_FEEDRATE | \"200\""),
            ("X_MIN_POS -100", "X_MIN_POS X_LOW", "import/at: c.h:14 | X_MIN_POS | \"X_LOW\""),
            ("X_MIN_POS -100", "X_MIN_POS (X_MIN_POS)", "import/at: c.h:14 | X_MIN_POS | \"(X_MIN_POS)\""),
            ("#define X_MIN_POS -100", &long, "import/at: c.h:14 | X_MIN_POS | ((((\".."),
            (
                "X_MIN_POS -100\n",
                "X_MIN_POS -100\n#define X_MIN_POS -90\n",
                "import/contradiction: c.h:15 | X_MIN_POS | -90 | -100 | c.h:14",
            ),
            (
                "I_MIN_POS -90\n#define I_MAX_POS 90",
                "I_MIN_POS 90\n#define I_MAX_POS -90",
                "import/at: c.h:21 | A | 90 (c.h:20) | -90",
            ),
            ("#define J_DRIVER_TYPE", "//#define J_DRIVER_TYPE", "import/at: c.h:3 | only A"),
            ("  #define AXIS5_ROTATES", "  //#define AXIS5_ROTATES", "import/at: c.h:3 | only A"),
            ("#ifdef J_DRIVER_TYPE\n", "#if HAS_J\n", "import/at: c.h:3 | only A"),
            ("AXIS4_NAME 'A'", "AXIS4_NAME 5", "import/at: c.h:6 | AXIS4_NAME | \"5\""),
            ("#endif\n#define DEFAULT", "#define DEFAULT", "import/at: c.h:9 | #if | #endif"),
            ("#define DEFAULT", "#endif\n#define DEFAULT", "import/at: c.h:13 | #if"),
            ("#define DEFAULT", "#define PENTA_AXIS_HT\n#define DEFAULT", "import/at: c.h:13 | PENTA_AXIS_HT"),
            ("#define DEFAULT", "#define BAUDRATE 0.5\n#define DEFAULT", "import/at: c.h:13 | BAUDRATE | 0.5"),
            (
                "#define DEFAULT",
                "#define BAUDRATE 50\n#define DEFAULT",
                "import/at: c.h:13 | link.baud | 50 | 300..12000000",
            ),
            ("#define DEFAULT", "#include \"gone.h\"\n#define DEFAULT", "import/at: c.h:13 | gone.h"),
            ("#define DEFAULT", "#include \"./c.h\"\n#define DEFAULT", "import/at: c.h:13 | itself"),
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
        "profile/code: generic-ac | dialect.start | \"G28\" | PENTA_AXIS",
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
        assert!(!stated && states(&notes, "BAUDRATE"), "{more}: {notes}");
    }
}
