//! Round trips: the shipped profiles with random numbers in them, written as their firmware's configuration by code that shares nothing with
//! the import, and read back: every key is the same, those of the files and all others.

use std::fmt::Write;

use trunnion::job::{ImportedProfile, Silent, World, load_profile};
use trunnion::profile::{Profile, TiltAxisName, resolve, shipped};

use super::{Files, import, lay, request};
use crate::support::{Numbers, folder};

const ROUNDS: u64 = 25;
/// Between a corner's deviation written as a speed and read again: the last digits of a square and its root.
const CORNER: f64 = 1e-9;

/// A multiple of a quarter, so that sixty of it and the 25.4th part of it are numbers that come back.
fn quarter(numbers: &mut Numbers, low: f64, high: f64) -> f64 {
    (numbers.between(low, high) * 4.0).round() / 4.0
}

fn yes(numbers: &mut Numbers) -> bool {
    numbers.between(0.0, 1.0) < 0.5
}

/// What the files say beside the profile: the fastest Z, mm/s.
struct Beside {
    z_mm_per_s: f64,
    /// Files, the first of which is given.
    files: Files,
}

/// The profile with other numbers in what every firmware states.
fn perturbed(name: &str, numbers: &mut Numbers) -> Profile {
    let (file, text) = shipped(name).unwrap();
    let mut profile = resolve(file, text).unwrap().0;
    let q = |numbers: &mut Numbers, low, high| quarter(numbers, low, high);
    let limits = &mut profile.limits;
    for ends in [&mut limits.x_mm, &mut limits.y_mm, &mut limits.z_mm] {
        *ends = [q(numbers, -300.0, -50.0), q(numbers, 50.0, 300.0)];
    }
    limits.max_feed_mm_per_min = 60.0 * q(numbers, 5.0, 200.0);
    limits.acceleration_mm_per_s2 = q(numbers, 500.0, 4000.0);
    limits.z_acceleration_mm_per_s2 = q(numbers, 10.0, 400.0);
    limits.turn_acceleration_deg_per_s2 = q(numbers, 10.0, 900.0);
    let kinematics = &mut profile.kinematics;
    (kinematics.tilt.min_deg, kinematics.tilt.max_deg) = (q(numbers, -120.0, 0.0), q(numbers, 5.0, 120.0));
    kinematics.tilt.max_deg_per_s = q(numbers, 1.0, 90.0);
    kinematics.rotation.max_deg_per_s = q(numbers, 1.0, 90.0);
    if kinematics.rotation.min_deg.is_some() {
        kinematics.rotation.min_deg = Some(q(numbers, -20000.0, -10.0));
        kinematics.rotation.max_deg = Some(q(numbers, 10.0, 20000.0));
    }
    profile
}

/// What no file of its firmware tells of the table, and nothing else is answered.
fn untold(error: &str, wanted: &Profile) -> Vec<(String, String)> {
    let k = &wanted.kinematics;
    let all = [
        ("tilt.letter", k.tilt.letter.to_string()),
        ("tilt.about", format!("{:?}", k.tilt.about)),
        ("tilt.direction", k.tilt.direction.to_string()),
        ("rotation.letter", k.rotation.letter.to_string()),
        ("rotation.direction", k.rotation.direction.to_string()),
    ];
    let asked = |key: &str| error.contains(&format!("kinematics.{key} ("));
    all.into_iter().filter(|(key, _)| asked(key)).map(|(key, value)| (format!("kinematics.{key}"), value)).collect()
}

/// Writes, reads and compares.
fn round_trip(name: &str, write: impl Fn(&mut Profile, f64, &mut Numbers) -> Files) {
    for seed in 0..ROUNDS {
        let mut numbers = Numbers::seeded(seed);
        let mut wanted = perturbed(name, &mut numbers);
        let z_mm_per_s = quarter(&mut numbers, 1.0, 40.0);
        let beside = Beside { z_mm_per_s, files: write(&mut wanted, z_mm_per_s, &mut numbers) };
        let transition = &mut wanted.transition;
        transition.travel_mm_per_min = transition.travel_mm_per_min.min(wanted.limits.max_feed_mm_per_min);
        transition.z_mm_per_min = transition.z_mm_per_min.min(60.0 * beside.z_mm_per_s);
        let folder = folder();
        lay(folder.path(), &beside.files);
        // Marlin's two files do not name each other.
        let given = beside.files.iter().enumerate().filter(|(i, (name, _))| *i == 0 || name.ends_with(".h"));
        let mut asked = request(folder.path(), &given.map(|(_, (name, _))| *name).collect::<Vec<_>>());
        asked.answers.rest = true;
        asked.like = (name == "fibr3d").then(|| name.into());
        let done = import(&asked).or_else(|error| {
            asked.answers.set = untold(&error, &wanted);
            import(&asked)
        });
        let done = done.unwrap_or_else(|e| panic!("{name}, {seed}: {e}\n{:?}", beside.files));
        assert_eq!(done.like.name, name, "{seed}");
        wanted.machine = done.profile.machine.clone();
        let junction = done.profile.limits.junction_mm;
        assert!((junction - wanted.limits.junction_mm).abs() < CORNER, "{name}, {seed}: {junction}");
        wanted.limits.junction_mm = junction;
        assert_eq!(done.profile, wanted, "{name}, {seed}: {:?}", beside.files);
        if matches!(done.firmware(), "klipper" | "reprapfirmware") {
            lines_say_it(&done);
        }
        // The file is the profile.
        let place = folder.path().join("mine.toml");
        std::fs::write(&place, done.text(Some(folder.path()), &World::here(&Silent))).unwrap();
        let again = load_profile(&place.to_string_lossy().as_ref().into(), &World::here(&Silent)).unwrap();
        assert_eq!(again.profile, done.profile, "{name}, {seed}");
    }
}

/// A number that is simply written down stands in the line that is told for it.
fn lines_say_it(done: &ImportedProfile) {
    let same_unit = |key: &str| !key.ends_with("_per_s") && key.starts_with(['l', 'p']);
    let mut seen = 0;
    for fact in
        done.facts.iter().filter(|fact| same_unit(fact.key) && (fact.how.is_empty() || fact.how.starts_with("heater")))
    {
        let ends = fact.value.as_array().cloned().unwrap_or_else(|| vec![fact.value.clone()]);
        for (end, place) in ends.iter().zip(&fact.from) {
            let text = std::fs::read_to_string(&place.file).unwrap();
            let line = text.lines().nth(place.line - 1).unwrap();
            assert!(line.contains(&end.as_float().unwrap().to_string()), "{fact:?}: {line}");
            seen += 1;
        }
    }
    assert!(seen > 8, "{seen} numbers were looked up");
}

/// LinuxCNC: mm or inches, degrees or radians, an axis or its joint the narrower, the offsets said in three ways.
fn linuxcnc(profile: &mut Profile, z_mm_per_s: f64, numbers: &mut Numbers) -> Files {
    let (inch, radian) = (yes(numbers), yes(numbers));
    let mm = |v: f64| if inch { v / 25.4 } else { v };
    let deg = |v: f64| if radian { v.to_radians() } else { v };
    let about_y = profile.kinematics.tilt.about == TiltAxisName::Y;
    let (kins, tilt, beside) = if about_y { ("xyzbc-trt-kins", 'B', 0) } else { ("xyzac-trt-kins", 'A', 1) };
    let mut d = [0.0, 0.0, quarter(numbers, -40.0, 40.0)];
    d[beside] = quarter(numbers, -40.0, 40.0);
    let r = [(); 3].map(|()| quarter(numbers, -20.0, 20.0));
    profile.kinematics.pivot_mm = [r[0] + d[0], r[1] + d[1], r[2] + d[2]];
    profile.kinematics.offset_mm = d.map(|v| 0.0 - v);
    let conventional = yes(numbers);
    let direction = if conventional { -1 } else { 1 };
    (profile.kinematics.tilt.direction, profile.kinematics.rotation.direction) = (direction, direction);

    let (l, k) = (&profile.limits, &profile.kinematics);
    let feed = l.max_feed_mm_per_min / 60.0;
    let more = quarter(numbers, 0.0, 9.0);
    let turn = l.turn_acceleration_deg_per_s2;
    let rotation = [k.rotation.min_deg.unwrap(), k.rotation.max_deg.unwrap()];
    let mut text = format!(
        "[KINS]\nKINEMATICS = {kins} sparm=identityfirst\n[TRAJ]\n  COORDINATES = X Y Z {tilt} C U\nLINEAR_UNITS = {}\nANGULAR_UNITS = {}\n",
        if inch { "inch" } else { "mm" },
        if radian { "rad" } else { "degree" }
    );
    let axes = [
        ('X', l.x_mm.map(mm), mm(feed), mm(l.acceleration_mm_per_s2 + more)),
        ('Y', l.y_mm.map(mm), mm(feed + more), mm(l.acceleration_mm_per_s2)),
        ('Z', l.z_mm.map(mm), mm(z_mm_per_s), mm(l.z_acceleration_mm_per_s2)),
        (tilt, [k.tilt.min_deg, k.tilt.max_deg].map(deg), deg(k.tilt.max_deg_per_s), deg(turn)),
        ('C', rotation.map(deg), deg(k.rotation.max_deg_per_s), deg(turn + more)),
    ];
    for (joint, (letter, ends, rate, acceleration)) in axes.into_iter().enumerate() {
        // The narrower of both counts, and either may leave one out.
        let both = [format!("AXIS_{letter}"), format!("JOINT_{joint}")];
        for (key, value, wider) in [
            ("MIN_LIMIT", ends[0], -7.0),
            ("MAX_LIMIT", ends[1], 7.0),
            ("MAX_VELOCITY", rate, 7.0),
            ("MAX_ACCELERATION", acceleration, 7.0),
        ] {
            let first = usize::from(yes(numbers));
            let _ = writeln!(text, "[{}]\n {key}={value}", both[first]);
            if yes(numbers) {
                let _ = writeln!(text, "[{}]\n{key}   =   {}   ", both[1 - first], value + wider);
            }
        }
    }
    let name = ["x", "y"][beside];
    let (across, up) = (mm(d[beside]), mm(d[2]));
    let mut files: Files = Vec::new();
    let mut pins = format!("setp {kins}.x-rot-point {}\nsetp {kins}.y-rot-point {}\n", mm(r[0]), mm(r[1]));
    let _ = writeln!(pins, "setp {kins}.z-rot-point {} # above", mm(r[2]));
    let _ = writeln!(pins, "setp {kins}.conventional-directions {}", if conventional { "TRUE" } else { "0" });
    match numbers.between(0.0, 3.0) as u32 {
        0 => {
            let _ = writeln!(
                pins,
                "net :a {kins}.{name}-offset => gui.a\nnet up gui.u <= {kins}.z-offset\nsets :a {across}\nsets up {up}"
            );
        }
        1 => {
            text += &format!("[OFFSETS]\nACROSS = {across}\n#INCLUDE up.inc\n");
            files.push(("up.inc", format!("UP = {up}\n")));
            let _ =
                writeln!(pins, "setp {kins}.{name}-offset [OFFSETS]ACROSS\nsetp {kins}.z-offset \\\n  [OFFSETS](UP)");
        }
        _ => {
            let _ = writeln!(pins, "setp   {kins}.{name}-offset\t{across}\nsetp {kins}.z-offset {up}");
        }
    }
    if yes(numbers) {
        text += "[HAL]\nHALFILE = LIB:basic_sim.tcl -no_sim_spindle\nHALFILE = m.hal\n";
        files.push(("m.hal", "# pins\nloadrt [KINS]KINEMATICS\nsource more.hal\n".to_owned()));
        files.push(("more.hal", pins));
    } else {
        text += "[HAL]\n";
        let pins = pins.replace("\\\n", "");
        pins.lines().for_each(|line| text += &format!("HALCMD = {line}\n"));
    }
    files.insert(0, ("m.ini", text));
    files
}

/// Klipper: `:` or `=`, comments, the axes in a file of a folder that is included with a star.
fn klipper(profile: &mut Profile, z_mm_per_s: f64, numbers: &mut Numbers) -> Files {
    let is = if yes(numbers) { ": " } else { " = " };
    let limits = &mut profile.limits;
    let corner = quarter(numbers, 5.0, 15.0);
    limits.junction_mm = corner * corner * (2.0_f64.sqrt() - 1.0) / limits.acceleration_mm_per_s2;
    limits.min_extrude_c = quarter(numbers, 100.0, 200.0);
    limits.e_acceleration_mm_per_s2 = quarter(numbers, 500.0, 5000.0);
    profile.link.max_nozzle_c = quarter(numbers, 200.0, 300.0);
    profile.link.max_bed_c = quarter(numbers, 60.0, 150.0);
    profile.process.nozzle_mm = 0.25 * quarter(numbers, 1.0, 3.0);
    profile.process.filament_mm = if yes(numbers) { 1.75 } else { 2.85 };
    if yes(numbers) {
        limits.x_mm[0] = 0.0;
    }
    let mut text = format!("[printer]\nkinematics{is}corexy\n[include axes/*.cfg]\n");
    let (l, k) = (&profile.limits, &profile.kinematics);
    for (key, value) in [
        ("max_velocity", l.max_feed_mm_per_min / 60.0),
        ("max_accel", l.acceleration_mm_per_s2),
        ("max_z_velocity", z_mm_per_s),
        ("max_z_accel", l.z_acceleration_mm_per_s2),
        ("square_corner_velocity", corner),
    ] {
        // Sections may come in pieces.
        let _ = writeln!(text, "[printer]\n{key}{is}{value} # {key}: 3");
    }
    for (axis, [low, high]) in [("x", l.x_mm), ("y", l.y_mm), ("z", l.z_mm)] {
        let _ = writeln!(text, "[stepper_{axis}]\nstep_pin{is}PF13\nposition_max{is}{high}");
        if low != 0.0 {
            let _ = writeln!(text, "position_min{is}{low} ; below");
        }
        let _ = writeln!(text, "#position_max{is}1");
    }
    let (heat, bed) = (profile.link.max_nozzle_c, profile.link.max_bed_c);
    let (nozzle, filament) = (profile.process.nozzle_mm, profile.process.filament_mm);
    let _ = write!(
        text,
        "[extruder]\nnozzle_diameter{is}{nozzle}\nfilament_diameter{is}{filament}\nmax_temp{is}{heat}\nmin_extrude_temp{is}{}\n\
         max_extrude_only_accel{is}{}\n[heater_bed]\nmax_temp{is}{bed}\n#*# <---------------------- SAVE_CONFIG ---------------------->\n\
         #*# [heater_bed]\n#*# pid_kp = 20\n",
        l.min_extrude_c, l.e_acceleration_mm_per_s2
    );
    // One speed in the section, the other where the letter is given.
    let turn = l.turn_acceleration_deg_per_s2;
    let (t, r) = (&k.tilt, &k.rotation);
    let axes = format!(
        "[manual_stepper swing]\nposition_min{is}{}\nposition_max{is}{}\nvelocity{is}5\naccel{is}{turn}\n\
         [manual_stepper turner]\nvelocity{is}{}\naccel{is}0\n[delayed_gcode axes]\ninitial_duration{is}1\ngcode{is}\n\
         \x20   MANUAL_STEPPER STEPPER=swing GCODE_AXIS=\n    manual_stepper stepper=swing gcode_axis={} limit_velocity={}\n\
         \x20   MANUAL_STEPPER STEPPER=turner GCODE_AXIS={} LIMIT_ACCEL={} # turns\n",
        t.min_deg,
        t.max_deg,
        r.max_deg_per_s,
        t.letter,
        t.max_deg_per_s,
        r.letter,
        turn + 5.0
    );
    // The start code as a person would write it for these names.
    let (tilt, rotation) = (t.letter, r.letter);
    let lines = |which: &str, letter: char, rate: f64, acceleration: f64| {
        format!("MANUAL_STEPPER STEPPER={which} GCODE_AXIS={letter} LIMIT_VELOCITY={rate} LIMIT_ACCEL={acceleration}")
    };
    profile.dialect.start = format!(
        "G21\nG90\nMANUAL_STEPPER STEPPER=swing GCODE_AXIS=\nMANUAL_STEPPER STEPPER=turner GCODE_AXIS=\nG28\n\
         MANUAL_STEPPER STEPPER=swing SET_POSITION=0\nMANUAL_STEPPER STEPPER=turner SET_POSITION=0\n{}\n{}\n\
         M140 S{{bed_c}}\nM104 S{{nozzle_c}}\nM190 S{{bed_c}}\nM109 S{{nozzle_c}}",
        lines("swing", tilt, t.max_deg_per_s, turn),
        lines("turner", rotation, r.max_deg_per_s, turn + 5.0)
    );
    profile.dialect.end = "M104 S0\nM140 S0\nM107\nM400\nMANUAL_STEPPER STEPPER=swing GCODE_AXIS=\n\
                           MANUAL_STEPPER STEPPER=turner GCODE_AXIS=\nM84"
        .to_owned();
    vec![("printer.cfg", text), ("axes/a.cfg", axes), ("axes/not.txt", "[stepper_x]\nposition_max: 1\n".to_owned())]
}

/// RepRapFirmware: limits with colons or by S, speeds a minute, heaters by their numbers, a file that is called.
fn reprap(profile: &mut Profile, z_mm_per_s: f64, numbers: &mut Numbers) -> Files {
    let limits = &mut profile.limits;
    let jerk = quarter(numbers, 5.0, 15.0);
    limits.junction_mm = jerk * jerk * (2.0_f64.sqrt() - 1.0) / limits.acceleration_mm_per_s2;
    limits.min_extrude_c = quarter(numbers, 100.0, 200.0);
    limits.e_acceleration_mm_per_s2 = quarter(numbers, 500.0, 5000.0);
    profile.link.max_nozzle_c = quarter(numbers, 200.0, 300.0);
    profile.link.max_bed_c = quarter(numbers, 60.0, 150.0);
    profile.process.nozzle_mm = 0.25 * quarter(numbers, 1.0, 3.0);
    profile.process.filament_mm = if yes(numbers) { 1.75 } else { 2.85 };
    let (l, k) = (&profile.limits, &profile.kinematics);
    let (t, r) = (&k.tilt, &k.rotation);
    let (a, c) = (t.letter, r.letter);
    let more = quarter(numbers, 0.0, 9.0);
    let mut text = format!(
        "; a board's file, M208 X1:2\nG90\nM83\nM550 P\"It; is (mine)\"\nM669 K1\nM584 X0.6 Y0.5 Z0.0:0.4 {a}0.3 E0.1\nM584 {c}5\nM92 X{{80*2}} Y80\n\
         if !exists(global.x)\n  global x = 1\n"
    );
    let mut ends = vec![('X', l.x_mm), ('Y', l.y_mm), ('Z', l.z_mm), (a, [t.min_deg, t.max_deg])];
    ends.extend(r.min_deg.zip(r.max_deg).map(|(low, high)| (c, [low, high])));
    if yes(numbers) {
        for (letter, [low, high]) in &ends {
            let _ = writeln!(text, "M208 {letter}{low}:{high} ; ends");
        }
    } else {
        let row = |i: usize| ends.iter().map(|(letter, ends)| format!(" {letter}{}", ends[i])).collect::<String>();
        let _ = write!(text, "M208{} S1\nm208{} S0\n", row(0), row(1));
    }
    let feed = l.max_feed_mm_per_min;
    let _ = writeln!(
        text,
        "M203 X{feed} Y{} Z{}:{} {a}{} {c}{} E3600 I6",
        feed + more,
        z_mm_per_s * 60.0,
        z_mm_per_s * 60.0,
        t.max_deg_per_s * 60.0,
        r.max_deg_per_s * 60.0
    );
    // The least of the axes' and the print's acceleration.
    let (all, turn) = (l.acceleration_mm_per_s2, l.turn_acceleration_deg_per_s2);
    let (own, print) = if yes(numbers) { (all, all + more) } else { (all + more, all) };
    let _ = writeln!(
        text,
        "M201 X{own} Y{} Z{} {a}{turn} {c}{} E{}\nM204 P{print} T9000\nM566 X{} Y{} Z9 {a}9 {c}9 P1",
        own + more,
        l.z_acceleration_mm_per_s2,
        turn + more,
        l.e_acceleration_mm_per_s2,
        (jerk + more) * 60.0,
        jerk * 60.0
    );
    let _ = writeln!(text, "M98 P\"/sys/heat.g\"");
    let heat = format!(
        "M308 S1 P\"temp1\"\nM143 H1 S{}\nM143 H0 S{}\nM143 H1 P1 T1 A2 C0 S99\nM140 H0\nM563 P0 S\"tool\" D0 H1 F0\nM563 P1 D1 H2\nM302 S{} R90\nM404 N{} D{}",
        profile.link.max_nozzle_c,
        profile.link.max_bed_c,
        l.min_extrude_c,
        profile.process.filament_mm,
        profile.process.nozzle_mm
    );
    vec![("config.g", text), ("heat.g", heat)]
}

/// Marlin: sums, names for numbers, branches that hold and others, comments.
fn marlin(profile: &mut Profile, z_mm_per_s: f64, numbers: &mut Numbers) -> Files {
    let limits = &mut profile.limits;
    limits.junction_mm = quarter(numbers, 5.0, 50.0) / 1024.0;
    limits.min_extrude_c = quarter(numbers, 100.0, 200.0);
    limits.e_acceleration_mm_per_s2 = quarter(numbers, 500.0, 5000.0);
    let whole = |numbers: &mut Numbers, low, high| numbers.between(low, high) as u32;
    let link = &mut profile.link;
    (link.max_nozzle_c, link.max_bed_c) = (quarter(numbers, 200.0, 300.0), quarter(numbers, 60.0, 150.0));
    (link.baud, link.buffer) = (whole(numbers, 9600.0, 1e6), whole(numbers, 64.0, 1024.0));
    (link.commands, link.planner) = (whole(numbers, 4.0, 32.0), whole(numbers, 8.0, 64.0));
    link.longest_line = whole(numbers, 64.0, 256.0);
    profile.process.filament_mm = if yes(numbers) { 1.75 } else { 2.85 };
    let about_y = profile.kinematics.tilt.about == TiltAxisName::Y;
    let mut penta = "//#define PENTA_AXIS_TRT\n".to_owned();
    if profile.link.identity.contains("PENTA_AXIS_TRT") {
        let (beside, name) = if about_y { (0, "X") } else { (1, "Y") };
        let mut d = [0.0, 0.0, quarter(numbers, -40.0, 40.0)];
        d[beside] = quarter(numbers, -40.0, 40.0);
        let m = [(); 3].map(|()| quarter(numbers, -20.0, 20.0));
        let k = &mut profile.kinematics;
        k.pivot_mm = [m[0] + d[0], m[1] + d[1], m[2] + d[2]];
        k.offset_mm = d.map(|v| 0.0 - v);
        (k.tilt.direction, k.rotation.direction) = (-1, if about_y { 1 } else { -1 });
        penta = format!(
            "#define PENTA_AXIS_TRT\n#if ANY(PENTA_AXIS_TRT, PENTA_AXIS_HT)\n  #define DEFAULT_MRZP_OFFSET_X {}\n  #define DEFAULT_MRZP_OFFSET_Y {}\n\
             \x20 #define DEFAULT_MRZP_OFFSET_Z {} // (mm)\n  #define DEFAULT_ROTATIONAL_JOINT_OFFSET_{name} ({})\n\
             \x20 #define DEFAULT_ROTATIONAL_JOINT_OFFSET_Z {}\n#endif\n",
            m[0], m[1], m[2], d[beside], d[2]
        );
    }
    let (l, k, link) = (&profile.limits, &profile.kinematics, &profile.link);
    let (t, r) = (&k.tilt, &k.rotation);
    let feed = l.max_feed_mm_per_min / 60.0;
    let more = quarter(numbers, 0.0, 9.0);
    let (all, turn) = (l.acceleration_mm_per_s2, l.turn_acceleration_deg_per_s2);
    let (own, print) = if yes(numbers) { (all, all + more) } else { (all + more, all) };
    let mut text = format!(
        "/**\n * #define X_MIN_POS 7\n */\n#pragma once\n#define CONFIGURATION_H_VERSION 02010300\n#define BAUDRATE {}\n\
         #define I_DRIVER_TYPE A4988\n  #define J_DRIVER_TYPE A4988 //:['A4988']\n//#define K_DRIVER_TYPE A4988\n\
         #ifdef I_DRIVER_TYPE\n  #define AXIS4_NAME '{}' // :['A', 'B', 'C']\n  #define AXIS4_ROTATES\n#endif\n\
         #ifdef J_DRIVER_TYPE\n  #define AXIS5_NAME '{}'\n  #define AXIS5_ROTATES\n#endif\n#ifdef K_DRIVER_TYPE\n  #define AXIS6_ROTATES\n#endif\n{penta}",
        link.baud, t.letter, r.letter
    );
    let [low, high] = l.x_mm;
    let _ = write!(
        text,
        "#define X_BED_SIZE {}\n#define X_MIN_POS {low}\n#define X_MAX_POS (X_BED_SIZE + 1.5*2)\n",
        high - 3.0
    );
    let mut ends = vec![("Y", l.y_mm), ("Z", l.z_mm), ("I", [t.min_deg, t.max_deg])];
    ends.extend(r.min_deg.zip(r.max_deg).map(|(low, high)| ("J", [low, high])));
    for (axis, [low, high]) in ends {
        let _ = write!(text, "#define {axis}_MIN_POS {low}\n#define {axis}_MAX_POS {high} /* up */\n");
    }
    let _ = write!(
        text,
        "#define DEFAULT_MAX_FEEDRATE {{ {}, {feed}, {z_mm_per_s}, {}, {}, 25 }}\n\
         #define DEFAULT_MAX_ACCELERATION      {{ {own}, {}, {}, {turn}, \\\n   {}, {} }}\n#define DEFAULT_ACCELERATION {print} // mm/s^2\n\
         //#define CLASSIC_JERK\n#if ENABLED(CLASSIC_JERK)\n  #define DEFAULT_XJERK 10.0\n#endif\n#if DISABLED(CLASSIC_JERK)\n\
         \x20 #define JUNCTION_DEVIATION_MM {}\n#endif\n#define EXTRUDE_MINTEMP {}\n#define DEFAULT_NOMINAL_FILAMENT_DIA {}\n",
        feed + more,
        t.max_deg_per_s,
        r.max_deg_per_s,
        own + more,
        l.z_acceleration_mm_per_s2,
        turn + more,
        l.e_acceleration_mm_per_s2,
        l.junction_mm,
        l.min_extrude_c,
        profile.process.filament_mm
    );
    let over = quarter(numbers, 5.0, 20.0);
    let _ = write!(
        text,
        "#define HEATER_0_MAXTEMP {}\n#define BED_MAXTEMP {}\n",
        link.max_nozzle_c + over,
        link.max_bed_c + 10.0
    );
    let card = yes(numbers);
    let adv = format!(
        "#define CONFIGURATION_ADV_H_VERSION 02010300\n#define HOTEND_OVERSHOOT {over}\n#define BUFSIZE {}\n#define MAX_CMD_SIZE {}\n{}#define SDSUPPORT\n\
         #if BOTH(SDSUPPORT, DIRECT_STEPPING)\n  #define BLOCK_BUFFER_SIZE 8\n#elif ENABLED(SDSUPPORT)\n  #define BLOCK_BUFFER_SIZE {}\n\
         #else\n  #define BLOCK_BUFFER_SIZE {}\n#endif\n#define RX_BUFFER_SIZE {}\n",
        link.commands,
        link.longest_line,
        if card { "" } else { "//" },
        if card { link.planner } else { 9 },
        if card { 9 } else { link.planner },
        link.buffer
    );
    vec![("Configuration.h", text), ("Configuration_adv.h", adv)]
}

#[test]
fn what_is_written_for_marlin_comes_back() {
    for name in ["generic-ac", "generic-bc", "hendrikjan-5d", "penta-trt-bc", "fibr3d"] {
        round_trip(name, marlin);
    }
}

#[test]
fn what_is_written_for_linuxcnc_comes_back() {
    round_trip("linuxcnc-xyzac-trt", linuxcnc);
    round_trip("linuxcnc-xyzbc-trt", linuxcnc);
}

#[test]
fn what_is_written_for_klipper_comes_back() {
    round_trip("fractal-5-pro", klipper);
    round_trip("pentos", klipper);
}

#[test]
fn what_is_written_for_reprapfirmware_comes_back() {
    round_trip("open5x-prusa", reprap);
    round_trip("open5x-voron0", reprap);
    round_trip("trident-5-axis", reprap);
}
