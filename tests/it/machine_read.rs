//! `machine read`: what firmwares say of themselves becomes a profile, and what they do not say is asked.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::Duration;

use serde_json::json;
use trunnion::job::{
    Answers, ImportProfile, ImportedProfile, JogRequest, MachineAt, MachineError, Silent, Source, World,
    import_profile, jog, load_profile, read_machine,
};
use trunnion::profile::{Sight, resolve};
use trunnion::publish::{Ask, ServerAddress, ServerAnswer, Trouble, Web};

use crate::jogged::{BASES, Person, Real, at, drawn, printer, side_by_side};
use crate::support::{folder, note, said, seeds, trunnion};

/// What nobody can tell but a person, answered as for a machine with the profile's own axes.
const DIRECTIONS: [(&str, &str); 2] = [("kinematics.tilt.direction", "1"), ("kinematics.rotation.direction", "1")];

fn request(text: Source, set: &[(&str, &str)]) -> ImportProfile {
    let set = set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    ImportProfile {
        files: vec![text],
        name: Some("mine".to_owned()),
        like: None,
        answers: Answers { file: None, set, rest: true },
    }
}

fn made(text: &str, set: &[(&str, &str)]) -> Result<ImportedProfile, MachineError> {
    let text = Source::Bytes { name: "mine.answers.txt".to_owned(), bytes: text.as_bytes().to_vec() };
    import_profile(&request(text, set), &World::here(&Silent))
}

/// Keys and values that a text states; none where it is refused.
fn facts(text: &str) -> Option<BTreeMap<&'static str, String>> {
    let done = made(text, &DIRECTIONS).ok()?;
    Some(done.facts.iter().map(|fact| (fact.key, fact.value.to_string())).collect())
}

#[test]
fn what_is_said_is_what_the_machine_has_and_the_rest_is_seen() {
    let by_firmware: Mutex<BTreeMap<&str, u32>> = Mutex::default();
    side_by_side(seeds(24, 200), |seed| {
        let real = Real { base: BASES[seed as usize % 3], ..drawn(seed) };
        let own = resolve("x.toml", &format!("extends = \"{}\"", real.base)).unwrap().0.kinematics;
        let letters = [own.tilt.letter, own.rotation.letter];
        let real = Real { letters: if seed / 3 % 2 == 0 { letters } else { [letters[1], letters[0]] }, ..real };
        *by_firmware.lock().unwrap().entry(real.base).or_default() += 1;
        let (folder, world) = (folder(), World::here(&Silent));
        printer(&real, folder.path(), |address, log| {
            let text = read_machine(&at(address), "mine.answers.txt", &world)
                .unwrap_or_else(|e| panic!("{seed} {real:?}: {e}"));
            let grbl = real.base == "grblhal-ac";
            let done = import_profile(&request(text, &DIRECTIONS), &world);
            let done = done.unwrap_or_else(|e| panic!("{seed} {real:?}: {e}"));
            let truth = resolve("real.toml", &real.profile()).unwrap().0;
            assert_eq!(done.profile.dialect.firmware, truth.dialect.firmware, "{seed}");
            assert_eq!(done.profile.limits.max_feed_mm_per_min, truth.limits.max_feed_mm_per_min, "{seed}");
            if !grbl {
                let (ours, theirs) = (&done.profile.limits, &truth.limits);
                assert_eq!((ours.x_mm, ours.y_mm, ours.z_mm), (theirs.x_mm, theirs.y_mm, theirs.z_mm), "{seed}");
            } else {
                assert!(["limits.x_mm", "limits.y_mm", "limits.z_mm"].iter().all(|key| done.unanswered.contains(key)));
            }
            // By the names of the letters; which of them tilts this machine says only when it moves.
            let rate = |letter: char| {
                let k = &truth.kinematics;
                if letter == k.tilt.letter { k.tilt.max_deg_per_s } else { k.rotation.max_deg_per_s }
            };
            let k = &done.profile.kinematics;
            for (letter, ours) in [(k.tilt.letter, k.tilt.max_deg_per_s), (k.rotation.letter, k.rotation.max_deg_per_s)]
            {
                assert!((ours - rate(letter)).abs() < 0.01, "{seed} {letter} {ours}");
            }
            assert_eq!(done.profile.sight(), Sight::Never, "nobody has looked yet");
            let file = folder.path().join("mine.toml");
            std::fs::write(&file, done.text(Some(folder.path()), &world)).unwrap();
            let person = Person::at(&real, address, log);
            let request = JogRequest { machine: file.to_str().unwrap().into(), at: at(address) };
            let seen = jog(&request, &|question, _| Some(person.answers(question)), &world);
            let seen = seen.unwrap_or_else(|e| panic!("{seed} {real:?}: {e}")).jogged;
            let t = &truth.kinematics;
            assert_eq!(
                (seen.tilt, seen.about, seen.tilt_direction, seen.rotation, seen.rotation_direction),
                (t.tilt.letter, real.about, t.tilt.direction, t.rotation.letter, t.rotation.direction),
                "{seed} {real:?}"
            );
        });
    });
    let by_firmware = by_firmware.into_inner().unwrap();
    note(&format!("{by_firmware:?}"));
    assert_eq!(by_firmware.len(), 3);
}

const MARLIN: &str = "\
Send: M115
Recv: FIRMWARE_NAME:Marlin 2.1.2.5 (Aug  1 2026) SOURCE_CODE_URL:github.com/MarlinFirmware/Marlin PROTOCOL_VERSION:1.0 \
MACHINE_TYPE:Bench Five KINEMATICS:Cartesian EXTRUDER_COUNT:1 AXIS_COUNT:5 UUID:cede
Recv: Cap:EEPROM:1
Recv: ok
Send: M503
Recv: echo:; Linear Units:
Recv: echo:  G21 ; (mm)
Recv: echo:; Max feedrates (units/s):
Recv: echo:  M203 X250.00 Y200.00 Z12.50 A25.00 C40.00 E60.00
Recv: echo:; Max Acceleration (units/s2):
Recv: echo:  M201 X1500.00 Y1200.00 Z100.00 A400.00 C600.00 E5000.00
Recv: echo:; Acceleration (units/s2) (P<print-accel> R<retract-accel> T<travel-accel>):
Recv: echo:  M204 P1000.00 R1000.00 T1000.00
Recv: echo:; Advanced (B<min_segment_time_us> S<min_feedrate> T<min_travel_feedrate> X<max_jerk> Y<max_jerk>):
Recv: echo:  M205 B20000.00 S0.00 T0.00 X8.00 Y10.00 Z0.40 E5.00
Recv: echo:; Bilinear Leveling:
Recv: echo:  M420 S1 Z10.00 ; Leveling ON
Recv: ok
Send: M211
Recv: echo:; Soft endstops:
Recv: echo:  M211 S1 ; ON
Recv: echo:  Min:  X-90.00 Y-80.00 Z0.00 A-20.00 C-99999.00   Max:  X90.00 Y85.00 Z240.00 A100.00 C99999.00
Recv: ok
";

#[test]
fn a_terminal_s_log_of_marlin_is_read_line_by_line() {
    let done = made(MARLIN, &DIRECTIONS).unwrap();
    let (k, l) = (&done.profile.kinematics, &done.profile.limits);
    assert_eq!((k.tilt.letter, k.rotation.letter, k.tilt.min_deg, k.tilt.max_deg), ('A', 'C', -20.0, 100.0));
    assert_eq!((k.tilt.max_deg_per_s, k.rotation.max_deg_per_s, k.rotation.stops_deg()), (25.0, 40.0, None));
    assert_eq!((l.x_mm, l.y_mm, l.z_mm), ([-90.0, 90.0], [-80.0, 85.0], [0.0, 240.0]));
    assert_eq!(
        (l.max_feed_mm_per_min, l.acceleration_mm_per_s2, l.z_acceleration_mm_per_s2),
        (12_000.0, 1000.0, 100.0)
    );
    // 8 mm/s round a corner of 90 degrees, at 1000 mm/s2.
    assert!((l.junction_mm - 64.0 * (2.0_f64.sqrt() - 1.0) / 1000.0).abs() < 1e-12, "{}", l.junction_mm);
    let text = done.text(None, &World::here(&Silent));
    assert!(text.contains("Bench Five") && text.contains("# mine.answers.txt:22"), "{text}");
    // As other hosts log it: with the time, with Windows' line ends.
    let whole = facts(MARLIN).unwrap();
    for time in ["22:59:43.907: ", "2026-11-28 19:00:00,123 - ", "[19:00:00] "] {
        let timed: String = MARLIN.lines().map(|line| format!("{time}{line}\r\n")).collect();
        assert_eq!(facts(&timed), Some(whole.clone()), "{time}");
    }
    // A mesh that is on is said, since the level table's heights are no tilted one's.
    assert!(
        done.notes.iter().any(|note| note.contains("mine.answers.txt:17") && note.contains("M420")),
        "{:?}",
        done.notes
    );
    assert_eq!(made(MARLIN, &[]).unwrap_err().code(), "job/untold", "directions are never another machine's");
}

#[test]
fn half_an_answer_states_nothing_else() {
    let whole = facts(MARLIN).unwrap();
    let (mut refused, mut less) = (0, 0);
    for cut in 0..MARLIN.len() {
        match facts(&MARLIN[..cut]) {
            None => refused += 1,
            Some(some) => {
                let other = some.iter().filter(|(key, value)| whole.get(*key) != Some(value)).count();
                assert_eq!(other, 0, "{:?}: {some:?}", MARLIN[..cut].lines().last());
                less += 1;
            }
        }
    }
    assert!(refused > 100 && less > 100, "{refused} {less}");
    let lines: Vec<&str> = MARLIN.lines().collect();
    for without in 0..lines.len() {
        let text: String =
            lines.iter().enumerate().filter(|(i, _)| *i != without).map(|(_, l)| format!("{l}\n")).collect();
        let Some(some) = facts(&text) else { continue };
        let other = some.iter().filter(|(key, value)| whole.get(*key) != Some(value));
        assert_eq!(other.count(), 0, "without {:?}", lines[without]);
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_line() {
    for (from, to, code, words) in [
        ("AXIS_COUNT:5", "AXIS_COUNT:6", "import/at", "counts 6 axes"),
        ("G21 ; (mm)", "G20 ; (in)", "import/at", "reports inches"),
        (" A25.00 C40.00", "", "import/at", "M115 counts 5 axes"),
        ("A25.00 C40.00", "A25.00 C4O.00", "import/at", "M203 C must be a finite number"),
        ("Recv: echo:; Bilinear", "Recv: echo:  M203 X90.00\nRecv: echo:; Bilinear", "import/contradiction", "M203 X"),
        ("KINEMATICS:Cartesian", "KINEMATICS:PENTA_AXIS_HT", "import/at", "head of this machine tilts"),
        ("FIRMWARE_NAME:Marlin", "FIRMWARE_NAME:Klipper", "import/file", "not the configuration"),
        ("Recv: echo:  M203", "Recv: echo:  M209", "import/file", "M503"),
    ] {
        assert!(MARLIN.contains(from), "{from}");
        let error = made(&MARLIN.replace(from, to), &DIRECTIONS).unwrap_err();
        assert!(error.code() == code && error.to_string().contains(words), "{} {error}", error.code());
    }
    // Extruders with speeds of their own; grblHAL's names and passwords; a macro that speaks of M115.
    let own = "Recv: echo:  M203 T0 E60.00\nRecv: echo:  M203 T1 E40.00\nRecv: echo:  M201 T0 E1.00\nRecv: echo:  M201 T1 E2.00\n";
    let several =
        MARLIN.replace(" E60.00", "").replace("Recv: echo:; Bilinear", &format!("{own}Recv: echo:; Bilinear"));
    assert_eq!(
        made(&several, &DIRECTIONS).unwrap().profile.kinematics,
        made(MARLIN, &DIRECTIONS).unwrap().profile.kinematics
    );
    let grbl = "[AXS:5:XYZAC]\n$11=0.010\n$74=MyNet\n$75=secret\n$110=9000\n$111=8000\n$112=900\n$113=1200\n$114=2400\n$120=500\n";
    assert_eq!(made(grbl, &DIRECTIONS).unwrap().profile.limits.max_feed_mm_per_min, 8000.0);
    let named = format!("FIRMWARE_NAME:grblHAL PROTOCOL_VERSION:1.1\n{grbl}");
    assert_eq!(made(&named, &DIRECTIONS).unwrap().profile.kinematics.tilt.max_deg_per_s, 20.0);
    let speaks = "[printer]\nkinematics: corexy\n[gcode_macro M115]\ngcode:\n  RESPOND MSG=\"FIRMWARE_NAME:Marlin\"\n";
    assert!(made(speaks, &DIRECTIONS).unwrap_err().to_string().contains("rotary"), "it is a printer.cfg");
    let penta = made(&MARLIN.replace("KINEMATICS:Cartesian", "KINEMATICS:PENTA_AXIS_TRT"), &[]).unwrap();
    let k = &penta.profile.kinematics;
    assert_eq!((k.tilt.direction, k.rotation.direction), (-1, -1), "that fork's own way to count");
    assert_eq!(penta.profile.link.identity, "KINEMATICS:PENTA_AXIS_TRT");
}

/// A server of canned answers, by the path that is asked for.
struct Canned(BTreeMap<String, serde_json::Value>);

impl Web for Canned {
    fn ask(&self, ask: &Ask<'_>, _: &dyn Fn(usize)) -> Result<ServerAnswer, Trouble> {
        let path = ask.url.strip_prefix("http://here").unwrap();
        let body = self.0.get(path).map(|value| value.to_string().into_bytes());
        let status = if body.is_some() { 200 } else { 404 };
        Ok(ServerAnswer { status, location: None, challenge: None, body: body.unwrap_or_default() })
    }

    fn wait(&self, _: Duration) {}
}

fn behind(server: &str, answers: BTreeMap<String, serde_json::Value>) -> Result<Source, MachineError> {
    let address = ServerAddress::parse(server).unwrap();
    let at = MachineAt::Server { address, key: None, silence: Duration::from_secs(1), fingerprint: None };
    let canned = Canned(answers);
    read_machine(&at, "mine.answers.txt", &World { web: &canned, ..World::here(&Silent) })
}

#[test]
fn klipper_s_configuration_is_asked_of_moonraker() {
    let sections = json!({
        "printer": {"kinematics": "corexy", "max_velocity": "300", "max_accel": "3000"},
        "stepper_x": {"position_max": "150", "position_min": "-150"},
        "stepper_y": {"position_max": "152.95", "position_min": "-297.05"},
        "stepper_z": {"position_max": "250", "position_min": "-150"},
        "manual_stepper stepper_a": {"velocity": "10", "accel": "100"},
        "manual_stepper stepper_b": {"velocity": "20", "accel": "100", "position_min": "-5", "position_max": "90"},
        "extruder": {"nozzle_diameter": "0.6", "filament_diameter": "1.75", "max_temp": "280"},
        "heater_bed": {"max_temp": "110"},
        "gcode_macro ADD": {"gcode": "\nMANUAL_STEPPER STEPPER=stepper_a GCODE_AXIS=A\nMANUAL_STEPPER STEPPER=stepper_b GCODE_AXIS=B"},
    });
    let path = "/printer/objects/query?configfile=config".to_owned();
    let answer = json!({"result": {"status": {"configfile": {"config": sections}}}});
    let text = behind("moonraker:http://here", BTreeMap::from([(path.clone(), answer)])).unwrap();
    // Which of A and B tilts, no name says.
    let error = import_profile(&request(text.clone(), &DIRECTIONS), &World::here(&Silent)).unwrap_err();
    assert!(error.code() == "job/untold" && error.to_string().contains("kinematics.tilt.letter"), "{error}");
    let mut set = DIRECTIONS.to_vec();
    set.extend([("kinematics.tilt.letter", "B"), ("kinematics.tilt.about", "X"), ("kinematics.rotation.letter", "A")]);
    let done = import_profile(&request(text, &set), &World::here(&Silent)).unwrap();
    let k = &done.profile.kinematics;
    assert_eq!(
        (k.tilt.min_deg, k.tilt.max_deg, k.tilt.max_deg_per_s, k.rotation.max_deg_per_s),
        (-5.0, 90.0, 20.0, 10.0)
    );
    assert_eq!(done.profile.limits.y_mm, [-297.05, 152.95]);
    assert!(done.profile.dialect.start.contains("STEPPER=stepper_b GCODE_AXIS=B"), "{}", done.profile.dialect.start);
    let empty = json!({"result": {"status": {"configfile": {}}}});
    let error = behind("moonraker:http://here", BTreeMap::from([(path, empty)])).unwrap_err();
    assert_eq!(error.code(), "server/page", "{error}");
    assert_eq!(behind("octoprint:http://here", BTreeMap::new()).unwrap_err().code(), "server/no-configuration");
}

#[test]
fn a_duet_s_object_model_is_read_axis_by_axis() {
    let axis = |letter: &str, low: f64, high: f64, speed: f64| json!({"result": {"letter": letter, "min": low, "max": high, "speed": speed, "acceleration": 900.0, "jerk": 600.0}});
    let ask = |key: &str| {
        let escaped = key.replace('[', "%5B").replace(']', "%5D");
        format!("/rr_model?key={escaped}&flags=v")
    };
    let mut answers = BTreeMap::from([
        ("/rr_connect?password=reprap".to_owned(), json!({"err": 0})),
        ("/rr_disconnect".to_owned(), json!({"err": 0})),
        (
            ask("boards[0]"),
            json!({"result": {"firmwareName": "RepRapFirmware for Duet 3 Mini 5+", "firmwareVersion": "3.6.0", "name": "Mini"}}),
        ),
        (ask("move.axes[0]"), axis("X", -100.0, 110.0, 9000.0)),
        (ask("move.axes[1]"), axis("Y", -120.0, 120.0, 12_000.0)),
        (ask("move.axes[2]"), axis("Z", 0.0, 200.0, 900.0)),
        (ask("move.axes[3]"), axis("A", -30.0, 95.0, 1200.0)),
        (ask("move.axes[4]"), axis("C", -99_999.0, 99_999.0, 1800.0)),
        (ask("move.axes[5]"), json!({"result": null})),
        (ask("move.kinematics"), json!({"result": {"name": "coreXY"}})),
        (ask("network"), json!({"result": {"name": "trident"}})),
    ]);
    let read = |answers: &BTreeMap<String, serde_json::Value>| {
        let text = behind("duet:http://here", answers.clone()).unwrap();
        import_profile(&request(text, &DIRECTIONS), &World::here(&Silent))
    };
    let done = read(&answers).unwrap();
    let (k, l) = (&done.profile.kinematics, &done.profile.limits);
    assert_eq!((k.tilt.min_deg, k.tilt.max_deg, k.tilt.max_deg_per_s), (-30.0, 95.0, 20.0));
    assert_eq!((k.rotation.stops_deg(), k.rotation.max_deg_per_s), (None, 30.0));
    assert_eq!((l.x_mm, l.max_feed_mm_per_min), ([-100.0, 110.0], 9000.0));
    assert!(done.notes.is_empty() && done.profile.machine.about.contains("trident"), "{:?}", done.notes);
    // A fork that follows the tip itself; an axis that is told in part; a password.
    answers.insert(ask("move.kinematics"), json!({"result": {"name": "robot"}}));
    assert_eq!(read(&answers).unwrap_err().code(), "import/at");
    answers.insert(ask("move.axes[3]"), json!({"result": {"letter": "A", "min": -30.0}}));
    let error = read(&answers).unwrap_err();
    assert!(error.to_string().contains("move.axes[3] has no max"), "{error}");
    answers.insert("/rr_connect?password=reprap".to_owned(), json!({"err": 1}));
    assert_eq!(behind("duet:http://here", answers).unwrap_err().code(), "server/no-key");
}

#[test]
fn the_command_keeps_what_the_machine_said_beside_the_profile() {
    let folder = folder();
    let real = Real { base: "generic-ac", letters: ['A', 'C'], ..drawn(0) };
    printer(&real, folder.path(), |address, _| {
        let own = folder.path().join("mine.toml");
        let mut command = trunnion();
        command.args(["machine", "read", "--keep-rest", "--set", "kinematics.tilt.direction=1"]);
        command.args(["--set", "kinematics.rotation.direction=1", "--port", &address.to_string(), "-o"]).arg(&own);
        let done = command.output().unwrap();
        assert!(done.status.success(), "{}", said(&done));
        let kept = std::fs::read_to_string(folder.path().join("mine.answers.txt")).unwrap();
        assert!(kept.contains(">>> M503\n") && kept.contains("M203"), "{kept}");
        // The same again from what was kept, without the machine.
        let again = folder.path().join("again.toml");
        let mut command = trunnion();
        command.args(["profile", "import", "--keep-rest", "--set", "kinematics.tilt.direction=1"]);
        command.args(["--set", "kinematics.rotation.direction=1"]).arg(folder.path().join("mine.answers.txt"));
        let done = command.arg("-o").arg(&again).output().unwrap();
        assert!(done.status.success(), "{}", said(&done));
        let world = World::here(&Silent);
        let of = |path: &std::path::Path| load_profile(&path.to_str().unwrap().into(), &world).unwrap().profile;
        let (mut one, mut two) = (of(&own), of(&again));
        (one.machine.name, two.machine.name) = (String::new(), String::new());
        assert_eq!(one.limits, two.limits);
        assert_eq!(one.kinematics, two.kinematics);
    });
}

/// A firmware without software endstops knows no M211; then the limits are asked, and all else is told.
#[test]
fn marlin_without_endstops_tells_the_rest() {
    use std::io::{BufRead, BufReader, Write};
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = trunnion::link::serial::Address::parse(&format!("tcp:{}", listener.local_addr().unwrap()));
    let text = std::thread::scope(|scope| {
        scope.spawn(move || {
            let (mut host, _) = listener.accept().unwrap();
            for line in BufReader::new(host.try_clone().unwrap()).lines().map_while(Result::ok) {
                let of = |code: &str| {
                    let from = MARLIN.split(&format!("Send: {code}\n")).nth(1).unwrap();
                    from.split("Send:").next().unwrap().replace("Recv: ", "")
                };
                let says = match &*line {
                    "M211" => "echo:Unknown command: \"M211\"\nok\n".to_owned(),
                    code => of(code),
                };
                host.write_all(says.as_bytes()).unwrap();
            }
        });
        read_machine(&at(&address), "mine.answers.txt", &World::here(&Silent)).unwrap()
    });
    let done = import_profile(&request(text, &DIRECTIONS), &World::here(&Silent)).unwrap();
    assert_eq!(done.profile.limits.max_feed_mm_per_min, 12_000.0);
    assert!(["limits.x_mm", "limits.z_mm", "kinematics.tilt.max_deg"].iter().all(|key| done.unanswered.contains(key)));
    assert!(done.notes.iter().any(|note| note.contains("M211")), "{:?}", done.notes);
}

/// A port at which something else answers than a printer, or half of one.
#[test]
fn a_port_without_a_printer_is_told_as_such() {
    use std::io::{BufRead, BufReader, Write};
    // What each answers to each line.
    let answers = |kind: &'static str| {
        move |line: &str| match (kind, line) {
            ("half", "M115") => "FIRMWARE_NAME:Marlin 2.1 AXIS_COUNT:5\nok\n",
            ("half", _) => "echo:  M203 X1\n",
            ("deaf", "M115") => "FIRMWARE_NAME:Marlin 2.1 AXIS_COUNT:5\nok\n",
            ("deaf", _) => "echo:Unknown command: \"M503\"\nok\n",
            ("stranger", _) => "FIRMWARE_NAME:Smoothieware FIRMWARE_URL:x\nok\n",
            ("klipper", _) => "ok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.13\n",
            _ => "HTTP/1.1 400 Bad Request\n",
        }
    };
    let all = [
        ("half", "job/halfway", 4, "M503"),
        ("deaf", "job/refuses", 4, "M503"),
        ("stranger", "job/stranger", 4, "Smoothieware"),
        ("klipper", "job/speechless", 2, "moonraker"),
        ("page", "job/mute", 4, "115200 baud"),
        ("flood", "job/mute", 4, "115200 baud"),
    ];
    let one = |(kind, code, exit, words): (&'static str, &str, i32, &str)| {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let place = format!("tcp:{}", listener.local_addr().unwrap());
        let answer = answers(kind);
        std::thread::spawn(move || {
            let (mut host, _) = listener.accept().unwrap();
            if kind == "flood" {
                while host.write_all(b"wait\n").is_ok() {
                    std::thread::sleep(Duration::from_millis(50));
                }
            }
            let lines = BufReader::new(host.try_clone().unwrap()).lines();
            lines.map_while(Result::ok).for_each(|line| host.write_all(answer(&line).as_bytes()).unwrap_or_default());
        });
        let folder = folder();
        let own = folder.path().join("mine.toml");
        let run = trunnion().args(["machine", "read", "--port", &place, "-o"]).arg(&own).output().unwrap();
        assert_eq!(run.status.code(), Some(exit), "{kind}: {}", said(&run));
        assert!(crate::support::fails(&said(&run), &format!("{code}: {words}")), "{kind}: {}", said(&run));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{kind}: nothing is written");
    };
    std::thread::scope(|scope| {
        for case in all {
            scope.spawn(move || one(case));
        }
    });
}
