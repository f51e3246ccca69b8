//! The command: what it writes, says and asks.

use std::process::Stdio;

use trunnion::job::{Answers, ImportProfile, Silent, Source, World, import_profile};
use trunnion::profile::TiltAxisName;

use super::{kept, lay, small_ini, small_klipper, with_rest};
use crate::support::{fails, folder, said, states, trunnion};

#[test]
fn a_machine_is_described_by_its_ini() {
    let folder = folder();
    lay(folder.path(), &vec![("my machine.ini", small_ini())]);
    let run = |args: &[&str]| {
        let mut command = trunnion();
        command.env("XDG_CONFIG_HOME", folder.path()).current_dir(folder.path()).stdin(Stdio::null());
        command.args(["profile", "import", "my machine.ini"]).args(args).output().unwrap()
    };
    let untold = run(&[]);
    assert_eq!(untold.status.code(), Some(2), "{}", said(&untold));
    let all = "job/untold: table.radius_mm | process.nozzle_mm | linuxcnc-xyzac-trt | --keep-rest";
    assert!(fails(&said(&untold), all), "{}", said(&untold));
    let answers = ["--set", "table.radius_mm=75", "--set", "process.nozzle_mm=0.6", "--set", "limits.x_mm=[-150, 150]"];
    let done = run(&answers);
    assert!(done.status.success(), "{}", said(&done));
    let file = folder.path().join("trunnion/profiles/my-machine.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    for words in [
        "# my-machine: created by trunnion profile import from my machine.ini (linuxcnc), based on linuxcnc-xyzac-trt.",
        "extends = \"linuxcnc-xyzac-trt\"",
        "# my machine.ini:7, 8: the point of rotation and the offsets from it",
        "# my machine.ini:22\nmin_deg = -100.0\n",
        "# your answer\nradius_mm = 75\n",
        "# your answer\nx_mm = [-150, 150]\n",
        "The head ([[head.body]]) is that profile's",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("table.radius_mm") && text.matches("x_mm").count() == 1, "{text}");
    let check =
        trunnion().env("XDG_CONFIG_HOME", folder.path()).args(["profile", "check", "my-machine"]).output().unwrap();
    assert!(check.status.success(), "{}", said(&check));
    let again = run(&answers);
    assert!(again.status.code() == Some(2) && fails(&said(&again), "job/there: my-machine.toml"), "{}", said(&again));
    for (args, words) in [
        (&["--keep-rest", "--set", "limits.x_m=[0,1]"][..], "profile/unknown-key: \"limits.x_m\" | \"limits.x_mm\""),
        (&["--keep-rest", "--set", "limits.x_mm=[0,99999]"], "profile/range: limits.x_mm | 99999 | -10000..10000 mm"),
        (&["--keep-rest", "--like", "fibr3b"], "profile/no-such-profile: \"fibr3b\" | \"fibr3d\""),
        (&["--keep-rest", "-o", "my machine.ini"], "job/there: my machine.ini"),
    ] {
        let run = run(&[&["--name", "other"], args].concat());
        assert!(run.status.code() == Some(2) && fails(&said(&run), words), "{args:?}: {}", said(&run));
    }
    assert!(!folder.path().join("trunnion/profiles/other.toml").exists());
}

#[test]
fn its_document_has_every_line_and_what_check_would_refuse() {
    let folder = folder();
    lay(folder.path(), &vec![("printer.cfg", small_klipper())]);
    let mut command = trunnion();
    let command = command.current_dir(folder.path()).args([
        "profile",
        "import",
        "printer.cfg",
        "--json",
        "--keep-rest",
        "-o",
        "k.toml",
    ]);
    // So far away that the tip does not reach it.
    let directions = ["--set", "kinematics.tilt.direction=1", "--set", "kinematics.rotation.direction=-1"];
    let run = command.args(["--set", "kinematics.pivot_mm=[0, 900, 0]"]).args(directions).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let document: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(
        (&document["profile"], &document["firmware"], &document["like"]),
        (&"k".into(), &"klipper".into(), &"fractal-5-pro".into())
    );
    let stated = document["stated"].as_array().unwrap();
    let of =
        |key: &str| stated.iter().find(|fact| fact["key"] == key).unwrap_or_else(|| panic!("no {key}: {document}"));
    assert_eq!(of("limits.max_feed_mm_per_min")["value"], 12000.0);
    assert_eq!(of("limits.max_feed_mm_per_min")["from"][0], serde_json::json!({"file": "printer.cfg", "line": 3}));
    assert!(states(document["refused"][0].as_str().unwrap(), "middle"), "{document}");
    let unanswered: Vec<&str> =
        document["unanswered"].as_array().unwrap().iter().map(|key| key.as_str().unwrap()).collect();
    assert!(
        unanswered.contains(&"kinematics.offset_mm") && !unanswered.contains(&"kinematics.pivot_mm"),
        "{unanswered:?}"
    );
}

#[test]
fn what_is_missing_is_asked_until_nothing_is() {
    let folder = folder();
    lay(folder.path(), &vec![("printer.cfg", small_klipper().replace("AXIS=C", "AXIS=B"))]);
    let world = World::here(&Silent);
    let files = vec![Source::from(&folder.path().join("printer.cfg"))];
    let mut request = ImportProfile { files, name: Some("mine".to_owned()), like: None, answers: Answers::default() };
    let asked = std::cell::RefCell::new(Vec::new());
    // Once it is known which axis tilts, how far it goes is asked, since no line says.
    // A direction is asked for until there is one.
    let lines = "B\nY\n-20\n70\nA\n90\n[100, 50, 2]\n\n0.5\n\n1\n-1\n";
    let show = |key: &str, _: &str| asked.borrow_mut().push(key.to_owned());
    let ended = request.clone().ask("".as_bytes(), show, &world).unwrap_err();
    assert!(ended.code() == "job/answer" && states(&ended.to_string(), "kinematics.tilt.letter"), "{ended}");
    asked.borrow_mut().clear();
    let done = request.ask(lines.as_bytes(), show, &world).and_then(|()| import_profile(&request, &world));
    let done = done.unwrap_or_else(|e| panic!("{e}: {:?}", asked.borrow()));
    assert_eq!(asked.borrow().len(), 12, "{:?}", asked.borrow());
    let tilt = &done.profile.kinematics.tilt;
    assert_eq!(
        (tilt.letter, done.like.name.as_str(), done.profile.table.radius_mm),
        ('B', "pentos", 90.0),
        "{:?}",
        asked.borrow()
    );
}

/// Two steppers of which no line says which tilts: taken from the profile that the machine is like, they came out exchanged, with the
/// file's own line as where that comes from.
#[test]
fn letters_and_directions_are_never_another_machines() {
    let folder = folder();
    let text = small_klipper().replace("AXIS=A", "AXIS=B").replace("AXIS=C", "AXIS=A");
    lay(folder.path(), &vec![("printer.cfg", text)]);
    let of = |set: &[(&str, &str)]| kept(folder.path(), &["printer.cfg"], set);
    let refused = of(&[]).unwrap_err();
    for key in ["tilt.letter", "tilt.about", "tilt.direction", "rotation.letter", "rotation.direction"] {
        assert!(refused.contains(&format!("kinematics.{key} (")), "{key}: {refused}");
    }
    assert!(fails(&refused, "job/untold: --keep-rest") && !refused.contains("table.radius_mm"), "{refused}");
    let own = [
        ("kinematics.tilt.letter", "B"),
        ("kinematics.tilt.about", "X"),
        ("kinematics.tilt.direction", "-1"),
        ("kinematics.rotation.letter", "A"),
        ("kinematics.rotation.direction", "1"),
    ];
    for left_out in 0..own.len() {
        let rest: Vec<_> = own.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, pair)| *pair).collect();
        let refused = of(&rest).unwrap_err();
        assert!(fails(&refused, &format!("job/untold: {}", own[left_out].0)), "{}: {refused}", own[left_out].0);
    }
    let kinematics = of(&own).unwrap().profile.kinematics;
    assert_eq!(
        (kinematics.tilt.letter, kinematics.rotation.letter, kinematics.tilt.about),
        ('B', 'A', TiltAxisName::X)
    );
}

/// Klipper's own following of the tip: its section tells which axis tilts, and a line that switches it on is noted.
#[test]
fn a_pivot_coord_tells_the_axes_and_must_not_be_on() {
    let folder = folder();
    let section = |tilt: &str, turn: &str| {
        format!(
            "[pivot_coord]\ncontrol_0: manual_stepper {turn}\nrotate_axis_0: z\noffset_x_0: 75\ncontrol_1: manual_stepper {tilt}\n\
             rotate_axis_1: y\noffset_z_1: -10\n[gcode_macro ON]\ngcode:\n  PIVOT_COORD ACTIVATE=1\n  BED_MESH_CALIBRATE\n"
        )
    };
    // The steppers' names say otherwise, and do not count.
    let text = small_klipper().replace("AXIS=A", "AXIS=B").replace("AXIS=C", "AXIS=A") + &section("rot", "tilt");
    lay(folder.path(), &vec![("printer.cfg", text.clone()), ("half.cfg", text.replace("rotate_axis_1: y", ""))]);
    let directions = super::DIRECTIONS.map(|key| (key, "1"));
    let done = kept(folder.path(), &["printer.cfg"], &directions).unwrap();
    let kinematics = &done.profile.kinematics;
    assert_eq!(
        (kinematics.tilt.letter, kinematics.rotation.letter, kinematics.tilt.about),
        ('A', 'B', TiltAxisName::Y)
    );
    let line = |text: &str| done.notes.iter().filter(|note| note.contains(text)).count();
    for words in ["offset_x_0 = 75, offset_z_1 = -10", "PIVOT_COORD ACTIVATE=0 into dialect.start", "BED_MESH_CLEAR"] {
        assert_eq!(line(words), 1, "{words}: {:?}", done.notes);
    }
    // Half of it tells nothing.
    assert!(kept(folder.path(), &["half.cfg"], &directions).unwrap_err().contains("kinematics.tilt.letter ("));
}

/// What published five-axis machines have in their files, typed anew from those facts; each was refused at the first try.
#[test]
fn published_configurations_come_through() {
    let folder = folder();
    // A Duet 2 with a bed without heat, a mirrored Y, and the ends of Z in the other order.
    let duet = "M669 K0 X1:0:0:0:0 Y0:-1:0:0:0 Z0:0:1:0:0 U0:0:0:1:0 V0:0:0:0:1\nM584 X0 Y1 Z2 E3 U4 V5 ; drives\n\
                M203 X12000 Y12000 Z750 E1500 U5000 V12000\nM208 X-126:125   Y-92.3:50  Z125:-1 U-200:200 V-12000:12000\nM140 H-1\n";
    // Speeds beyond what a profile may have.
    let voron = "M669 K1\nM584 X0.6 Y0.5 Z0.0:0.4 B0.3 C0.2 E0.1\nM203 X180000 Y180000 Z1200:1200 B61200 C61200 E7200\n\
                 M208 X-58 Y-58 Z-20 B-110 C-1000000 S1\nM208 X115 Y115 Z85 B110 C1000000  S0\n";
    // A number that has lost its letter: no highest Y.
    let thesis = "M584 X0.0 Y0.1 Z0.2 A0.3 B0.4 E0.5\nM203 X600 Y600 Z45 A120 B45 E1200\nM208 X137 Y-233 Z84 S1\nM208 X641 217 Z363 S0\n";
    // Klipper that is given turns as commands, with the server's own macros elsewhere.
    let fractal = "[include mainsail.cfg]\n[printer]\nkinematics: corexy\nmax_velocity: 300\nmax_accel: 3000\n[stepper_x]\nposition_min: -150.0\n\
                   position_max: 150.0\n[stepper_y]\nposition_min: -297.05\nposition_max: 152.95\n[stepper_z]\nposition_min: -150.0\n\
                   position_max: 250.0\n[manual_stepper stepper_a]\nvelocity: 10\naccel: 100\n[manual_stepper stepper_b]\nvelocity: 20\naccel: 100\n\
                   endstop_pin: !PG13\n[heater_bed]\nmax_temp: 130\n[gcode_macro home_ab]\ngcode:\n  MANUAL_STEPPER STEPPER=stepper_b SET_POSITION=-1.8\n";
    let files = [("duet.g", duet), ("voron.g", voron), ("thesis.g", thesis), ("fractal.cfg", fractal)];
    lay(folder.path(), &files.map(|(name, text)| (name, text.to_owned())).to_vec());
    let of = |file: &str, set: &[(&str, &str)]| {
        let directions = super::DIRECTIONS.map(|key| (key, "1"));
        kept(folder.path(), &[file], &[set, &directions].concat()).unwrap_or_else(|e| panic!("{file}: {e}"))
    };
    let noted = |done: &trunnion::job::ImportedProfile, words: &str| {
        assert!(done.notes.iter().any(|note| states(note, words)), "{words}: {:?}", done.notes);
    };

    let letters = |tilt, rotation, about| {
        [("kinematics.tilt.letter", tilt), ("kinematics.rotation.letter", rotation), ("kinematics.tilt.about", about)]
    };
    let done = of("duet.g", &letters("U", "V", "Y"));
    assert_eq!(done.profile.limits.z_mm, [-1.0, 125.0]);
    noted(&done, "duet.g:4 | M208 Z125:-1 | -1:125");
    let tilt = &done.profile.kinematics.tilt;
    // No table tilts as far as the file lets it.
    assert_eq!((tilt.min_deg, tilt.max_deg, tilt.letter), (-180.0, 180.0, 'U'));

    let done = of("voron.g", &[]);
    assert_eq!(done.profile.limits.max_feed_mm_per_min, 120_000.0);
    let fact = done.facts.iter().find(|fact| fact.key == "limits.max_feed_mm_per_min").unwrap();
    assert!(states(&fact.how, "180000 | 120000"), "{}", fact.how);
    assert_eq!((done.profile.kinematics.tilt.letter, done.profile.kinematics.rotation.letter), ('B', 'C'));

    let answers = [&letters("A", "B", "X")[..], &[("limits.y_mm", "[-233, 217]")]].concat();
    let done = of("thesis.g", &answers);
    assert_eq!((done.profile.limits.x_mm, done.profile.limits.y_mm), ([137.0, 641.0], [-233.0, 217.0]));
    noted(&done, "thesis.g:4 | 217 | M208");

    let refused = kept(folder.path(), &["fractal.cfg"], &[]).unwrap_err();
    let which = "import/at: fractal.cfg:15 | --set kinematics.tilt.stepper=NAME | stepper_a, stepper_b";
    assert!(fails(&refused, which), "{refused}");
    let motors = [("kinematics.tilt.stepper", "stepper_b"), ("kinematics.rotation.stepper", "stepper_a")];
    let done = of("fractal.cfg", &[&motors[..], &[("kinematics.tilt.about", "X")]].concat());
    noted(&done, "fractal.cfg:1 | mainsail.cfg");
    let (tilt, rotation) = (&done.profile.kinematics.tilt, &done.profile.kinematics.rotation);
    assert_eq!((tilt.max_deg_per_s, rotation.max_deg_per_s), (20.0, 10.0));
    let start = &done.profile.dialect.start;
    assert!(start.contains("STEPPER=stepper_b SET_POSITION=0") && !start.contains("GCODE_AXIS"), "{start}");
    assert!(done.refusals.is_empty(), "{:?}", done.refusals);
    let wrong = [("kinematics.tilt.stepper", "swing"), ("kinematics.rotation.stepper", "stepper_a")];
    let refused = kept(folder.path(), &["fractal.cfg"], &wrong).unwrap_err();
    assert!(fails(&refused, "import/file: fractal.cfg | [manual_stepper swing] | stepper_a, stepper_b"), "{refused}");
}

/// What is answered is not looked for in the files, however wrong they are there.
#[test]
fn an_answer_goes_over_a_line_that_cannot_be() {
    let folder = folder();
    let text = super::small_reprap().replace("X-100:100 ", "") + "M208 X100 S1\nM208 X-100 S0\n";
    lay(folder.path(), &vec![("config.g", text)]);
    let wrong = with_rest(folder.path(), &["config.g"], &[]).unwrap_err();
    assert!(fails(&wrong, "import/at: config.g:7 | X | 100 | config.g:6 | -100"), "{wrong}");
    let done = with_rest(folder.path(), &["config.g"], &[("limits.x_mm", "[-100, 100]")]).unwrap();
    assert_eq!(done.profile.limits.x_mm, [-100.0, 100.0]);
}

/// Measures of a head are answers here, too: they go over what the file says of it, and else over what the other profile says.
#[test]
fn a_head_is_measured_beside_the_files() {
    let folder = folder();
    let machine = r#"{
  "_version": 1, "buildplate": {"w": 90, "d": 90, "t": 3}, "nozzle": {"tip": 0.8, "base": 8, "angle": 45, "length": 10},
  "limits": {"x": {"min": -60, "max": 70}, "y": {"min": -50, "max": 50}, "z": {"min": -20, "max": 90}},
  "collisionProxies": [{"part": "X", "type": "box", "sx": 36, "sy": 50, "sz": 60, "ox": 0, "oy": 40, "oz": 0}]
}"#;
    lay(folder.path(), &vec![("machine.json", machine.to_owned()), ("printer.cfg", small_klipper())]);
    let of =
        |file: &str, set: &[(&str, &str)]| with_rest(folder.path(), &[file], set).map(|done| done.profile.head.body);
    let names = |bodies: &[trunnion::profile::BodySpec]| bodies.iter().map(|b| b.name.clone()).collect::<Vec<_>>();
    let koala = of("machine.json", &[("head.cone_mm", "[5, 9]")]).unwrap();
    // The file's box is what stands lowest on the head; its beam was not drawn.
    assert_eq!(names(&koala), ["nozzle", "nozzle's shaft", "X box 1"]);
    assert_eq!((koala[0].z_mm, koala[0].r_mm, koala[1].z_mm), (Some([0.0, 5.0]), Some([0.4, 4.5]), Some([5.0, 15.0])));
    let beam = [("head.gantry_moves", "YZ"), ("head.gantry_mm", "[20, 40]"), ("head.gantry_z_mm", "[50, 70]")];
    let beam = of("machine.json", &beam).unwrap();
    assert_eq!((beam[3].min_mm, beam[3].max_mm), (Some([-160.0, 20.0, 50.0]), Some([170.0, 40.0, 70.0])));
    let klipper = of("printer.cfg", &[("head.block_z_mm", "[11, 60]")]).unwrap();
    assert_eq!(names(&klipper), ["nozzle", "nozzle's shaft", "block", "carriage", "gantry"]);
    assert_eq!(klipper[2].min_mm, Some([-10.0, -10.0, 11.0]));
    let wrong = of("printer.cfg", &[("head.blok_mm", "[1, 1, 1, 1]")]).unwrap_err();
    assert!(fails(&wrong, "job/answer: head.blok_mm | \"head.block_mm\""), "{wrong}");
}
