//! `machine jog`: machines whose axes are not as their profiles say, simulated, and a person who looks at them.
//!
//! The person knows nothing of `motion`: what a turn does to the rim is worked out here, by a matrix written down again.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde_json::json;
use trunnion::calibrate::{JogFault, JogQuestion, JogSubject, Seen};
use trunnion::job::{
    Bench, JogRequest, JogResult, MachineAt, MachineError, Silent, SimulateRequest, World, jog, load_profile, simulate,
};
use trunnion::link::serial::{Address, Heard, Port};
use trunnion::link::sim::{Logged, Sim};
use trunnion::profile::{Sight, resolve};
use trunnion::publish::{Ask, ServerAddress, ServerAnswer, Trouble, Web};

use crate::support::{Numbers, fails, folder, note, said, seeds, trunnion, wait_for};

/// Start code of a Klipper whose commands turn the table.
const COMMANDED: &str =
    "G28\nMANUAL_STEPPER STEPPER=tilt SET_POSITION=0\nMANUAL_STEPPER STEPPER=rot SET_POSITION=0\nM109 S{nozzle_c}";

/// A machine as it is.
#[derive(Clone, Debug)]
pub(crate) struct Real {
    pub(crate) base: &'static str,
    pub(crate) letters: [char; 2],
    pub(crate) about: char,
    pub(crate) directions: [i32; 2],
    /// The tilt's word at level.
    pub(crate) level: f64,
    /// Quarter turns by which the person does not stand in front.
    pub(crate) stand: u8,
    /// Whether Y runs the wrong way.
    pub(crate) mirrored: bool,
    /// Whether Z does.
    pub(crate) sunk: bool,
    /// Whether Klipper's commands turn its table.
    pub(crate) steppers: bool,
}

impl Real {
    pub(crate) fn profile(&self) -> String {
        let Self { base, letters: [tilt, rotation], about, directions: [up, round], level, .. } = self;
        // Where it has stops, there is room on both sides, whatever the letters are.
        let stops = if *base == "hendrikjan-5d" { "min_deg = -360.0\nmax_deg = 360.0\n" } else { "" };
        let [tilts, turns] = if self.steppers { ["stepper = \"tilt\"\n", "stepper = \"rot\"\n"] } else { ["", ""] };
        let start =
            if self.steppers { format!("[dialect]\nstart = \"\"\"\n{COMMANDED}\"\"\"\n") } else { String::new() };
        format!(
            "extends = \"{base}\"\n{start}[kinematics.tilt]\n{tilts}letter = \"{tilt}\"\nabout = \"{about}\"\ndirection = {up}\nzero_deg = {level:?}\n\
             min_deg = -90.0\nmax_deg = 120.0\n[kinematics.rotation]\n{turns}letter = \"{rotation}\"\ndirection = {round}\n{stops}"
        )
    }

    /// Where the person sees a machine vector: right, away, up.
    fn seen(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = [x, if self.mirrored { -y } else { y }];
        let [x, y] = match self.stand {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        };
        [x, y, if self.sunk { -z } else { z }]
    }

    /// Where it stands when the test begins: X, Y, Z, tilt.
    fn stands_at(&self) -> [f64; 4] {
        let room = resolve("x.toml", &self.profile()).unwrap().0.limits;
        let [x, y] = [room.x_mm, room.y_mm].map(|[low, high]| (low + high) / 2.0);
        [x, y, room.z_mm[1] - 20.0, self.level]
    }

    /// What brings it there.
    fn made_ready(&self) -> [String; 6] {
        let (home, wait) = if self.base == "grblhal-ac" { ("$H", "G4 P0.01") } else { ("G28", "M400") };
        let ([x, y, z, level], tilt) = (self.stands_at(), self.letters[0]);
        let place = [format!("G1 Z{z} F900"), format!("G1 X{x} Y{y} F900"), format!("G1 {tilt}{level} F900")];
        let [up, across, tilted] = place;
        [home.to_owned(), "G90".to_owned(), up, across, tilted, wait.to_owned()]
    }

    /// What a person answers who sees the axes go by so much.
    fn looks(&self, by: [f64; 5]) -> Seen {
        let [x, y, z] = self.seen([by[0], by[1], by[2]]);
        let straight =
            [(x, [Seen::Left, Seen::Right]), (y, [Seen::Towards, Seen::Away]), (z, [Seen::Closer, Seen::Apart])];
        if let Some((way, both)) = straight.into_iter().find(|(way, _)| way.abs() > 1.0) {
            return both[usize::from(way > 0.0)];
        }
        let turned = by[4] * f64::from(self.directions[1]);
        if turned.abs() > 1.0 {
            return if turned > 0.0 { Seen::Anticlockwise } else { Seen::Clockwise };
        }
        let angle = (by[3] * f64::from(self.directions[0])).to_radians();
        if angle == 0.0 {
            return Seen::Nothing;
        }
        // How high the rim's point in this direction comes (right-handed about machine X or Y).
        let rises = |[x, y]: [f64; 2]| if self.about == 'X' { y * angle.sin() } else { -x * angle.sin() };
        // The machine's directions that the person sees near and on the right.
        let at = |wanted: [f64; 2]| {
            let all = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
            all.into_iter().find(|[x, y]| self.seen([*x, *y, 0.0])[..2] == wanted).unwrap()
        };
        let [near, right] = [rises(at([0.0, -1.0])), rises(at([1.0, 0.0]))];
        match () {
            () if near.abs() > right.abs() && near > 0.0 => Seen::NearRose,
            () if near.abs() > right.abs() => Seen::NearSank,
            () if right > 0.0 => Seen::RightRose,
            () => Seen::RightSank,
        }
    }
}

/// What the simulated printer logs, to be read while it runs.
#[derive(Clone, Default)]
pub(crate) struct Log(Arc<Mutex<Vec<u8>>>);

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Log {
    /// X, Y, Z, tilt and rotation words where each move ended.
    fn poses(&self) -> Vec<[f64; 5]> {
        let text = String::from_utf8(self.0.lock().unwrap().clone()).unwrap();
        let numbers = |line: &str| -> Option<[f64; 5]> {
            let (_, at) = line.split_once(" pose ")?;
            let all: Vec<f64> = at.split(' ').map(|word| word.parse().unwrap()).collect();
            Some(all[..5].try_into().unwrap())
        };
        text.lines().filter_map(numbers).collect()
    }
}

/// A port, at the profile's own speed.
pub(crate) fn at(address: &Address) -> MachineAt {
    MachineAt::Port { address: address.clone(), baud: None }
}

/// Sends lines to a printer and waits for each answer.
fn by_hand(address: &Address, lines: &[&str]) {
    let mut port = Port::open(address, 115_200).unwrap();
    for line in lines {
        let mut left = format!("{line}\n").into_bytes();
        let mut heard = Vec::new();
        while !String::from_utf8_lossy(&heard).lines().any(|line| line.starts_with("ok")) {
            let sent = port.write(&left);
            left.drain(..sent);
            match port.read(Duration::from_millis(20), !left.is_empty()) {
                Heard::Bytes(bytes) => heard.extend_from_slice(bytes),
                Heard::Gone(why) => panic!("{line}: {why}"),
                Heard::Nothing => {}
            }
            let text = String::from_utf8_lossy(&heard).into_owned();
            assert!(!["error:", "Error", "!!"].iter().any(|words| text.contains(words)), "{line}: {text}");
        }
    }
}

/// Runs a printer as `real` is, and hands its address and log to `with`.
pub(crate) fn printer<T>(real: &Real, folder: &Path, with: impl FnOnce(&Address, &Log) -> T) -> T {
    let own = folder.join("real.toml");
    std::fs::write(&own, real.profile()).unwrap();
    let world = World::here(&Silent);
    let machine = load_profile(&own.to_str().unwrap().into(), &world).unwrap();
    // Only grblHAL tells its letters.
    let quirks = if real.base == "grblhal-ac" {
        vec!["latches-errors".to_owned(), "work-offset".to_owned()]
    } else {
        Vec::new()
    };
    let sim = simulate(&SimulateRequest { quirks, ..SimulateRequest::default() }, &machine).unwrap();
    let (log, ended, place) = (Log::default(), AtomicBool::new(false), Mutex::new(None));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let world = World::here(&Silent);
            let mut own = log.clone();
            Bench::new(sim, None, Some(&mut own), &world)
                .serve("tcp:0", &ended, |at| *place.lock().unwrap() = Some(Address::parse(at)))
                .unwrap();
        });
        wait_for("the printer", || place.lock().unwrap().is_some());
        let address = place.lock().unwrap().clone().unwrap();
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| with(&address, &log)));
        ended.store(true, Ordering::Relaxed);
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Whoever stands by a machine that is `real`, has made it ready, and looks.
pub(crate) struct Person<'a> {
    real: &'a Real,
    log: &'a Log,
    /// Moves that ended before the test.
    before: usize,
    moved: Mutex<usize>,
}

impl<'a> Person<'a> {
    pub(crate) fn at(real: &'a Real, address: &Address, log: &'a Log) -> Self {
        let lines = real.made_ready();
        by_hand(address, &lines.iter().map(String::as_str).collect::<Vec<_>>());
        Self::beside(real, log)
    }

    /// The same of a machine that is ready.
    fn beside(real: &'a Real, log: &'a Log) -> Self {
        let there = real.stands_at();
        // The log comes behind the last `ok`.
        let stands = |at: &[f64; 5]| at.iter().zip(&there).all(|(at, there)| (at - there).abs() < 1e-3);
        wait_for("the machine", || log.poses().last().is_some_and(stands));
        Self { real, log, before: log.poses().len(), moved: Mutex::new(0) }
    }

    pub(crate) fn answers(&self, question: &JogQuestion) -> Seen {
        let seen = match question.subject {
            JogSubject::Ready => Seen::Yes,
            JogSubject::Level => {
                let there = self.before + 2 * *self.moved.lock().unwrap();
                wait_for("the way back", || self.log.poses().len() >= there);
                let at = self.log.poses()[there - 1][3];
                if (at - self.real.level).abs() < 1e-3 { Seen::Yes } else { Seen::No }
            }
            JogSubject::Way | JogSubject::Table | JogSubject::Amount => {
                let mut moved = self.moved.lock().unwrap();
                *moved += 1;
                // Every step before it went there and back.
                let want = self.before + 2 * *moved - 1;
                wait_for("the move", || self.log.poses().len() >= want);
                let (poses, mut by) = (self.log.poses(), [0.0; 5]);
                by.iter_mut().enumerate().for_each(|(i, by)| *by = poses[want - 1][i] - poses[want - 2][i]);
                match (question.subject, self.real.looks(by)) {
                    (JogSubject::Amount, Seen::Nothing) => Seen::No,
                    (JogSubject::Amount, _) => Seen::Yes,
                    (_, seen) => seen,
                }
            }
        };
        assert!(question.answers.contains(&seen), "{question:?} {seen:?}");
        seen
    }
}

/// The test of a machine that `believed` describes and that is `real`; `answer` may say something else than what is seen.
fn tried(
    real: &Real,
    believed: &str,
    folder: &Path,
    answer: &dyn Fn(&JogQuestion, Seen) -> Option<Seen>,
) -> Result<JogResult, MachineError> {
    let own = folder.join("mine.toml");
    std::fs::write(&own, believed).unwrap();
    printer(real, folder, |address, log| {
        let person = Person::at(real, address, log);
        let request = JogRequest { machine: own.to_str().unwrap().into(), at: at(address) };
        let done = jog(&request, &|question, _| answer(question, person.answers(question)), &World::here(&Silent));
        // Whatever came of it, every axis is back where it was.
        // Marlin tells hundredths of where it stands.
        let near = |[one, other]: [[f64; 5]; 2]| one.iter().zip(other).all(|(one, other)| (one - other).abs() < 0.006);
        wait_for("the way back", || {
            let poses = log.poses();
            near([poses[poses.len() - 1], poses[person.before - 1]])
        });
        done
    })
}

fn honest(_: &JogQuestion, seen: Seen) -> Option<Seen> {
    Some(seen)
}

pub(crate) const BASES: [&str; 5] = ["generic-ac", "trident-5-axis", "grblhal-ac", "fractal-5-pro", "hendrikjan-5d"];

pub(crate) fn drawn(seed: u64) -> Real {
    let mut random = Numbers::seeded(seed);
    let mut below = |n: usize| (random.between(0.0, n as f64) as usize).min(n - 1);
    let base = BASES[below(5)];
    let own = resolve("x.toml", &format!("extends = \"{base}\"")).unwrap().0.kinematics;
    let mut letters = [own.tilt.letter, own.rotation.letter];
    if below(2) == 1 {
        letters.swap(0, 1);
    }
    Real {
        base,
        letters,
        about: ['X', 'Y'][below(2)],
        directions: [[1, -1][below(2)], [1, -1][below(2)]],
        // What is no axis of Klipper's yet stands nowhere else.
        level: if ["fractal-5-pro", "hendrikjan-5d"].contains(&base) { 0.0 } else { [0.0, 12.5][below(2)] },
        stand: below(4) as u8,
        mirrored: false,
        sunk: false,
        steppers: false,
    }
}

/// Several machines at a time: each waits more than it works.
pub(crate) fn side_by_side(seeds: std::ops::Range<u64>, one: impl Fn(u64) + Sync) {
    let all: Vec<u64> = seeds.collect();
    for some in all.chunks(8) {
        std::thread::scope(|scope| some.iter().for_each(|seed| drop(scope.spawn(|| one(*seed)))));
    }
}

#[test]
fn each_exchange_and_sign_is_found() {
    let exchanged = AtomicUsize::new(0);
    side_by_side(seeds(40, 400), |seed| {
        let (real, folder) = (drawn(seed), folder());
        let believed = format!("extends = \"{}\"\n", real.base);
        let done = tried(&real, &believed, folder.path(), &honest).unwrap_or_else(|e| panic!("{seed} {real:?}: {e}"));
        assert_eq!(done.unfit, None, "{seed} {real:?}");
        exchanged.fetch_add(usize::from(!done.changes.is_empty()), Ordering::Relaxed);
        let text = done.profile(Some(folder.path()), &World::here(&Silent));
        std::fs::write(folder.path().join("seen.toml"), &text).unwrap();
        let name = folder.path().join("seen.toml");
        let written = load_profile(&name.to_str().unwrap().into(), &World::here(&Silent)).unwrap().profile;
        let truth = resolve("real.toml", &real.profile()).unwrap().0.kinematics;
        let (tilt, rotation) = (&written.kinematics.tilt, &written.kinematics.rotation);
        assert_eq!(
            (tilt.letter, tilt.about, tilt.direction, tilt.zero_deg, rotation.letter, rotation.direction),
            (
                truth.tilt.letter,
                truth.tilt.about,
                truth.tilt.direction,
                truth.tilt.zero_deg,
                truth.rotation.letter,
                truth.rotation.direction
            ),
            "{seed} {real:?}: {text}"
        );
        assert_eq!(written.sight(), Sight::Seen(done.date.clone()), "{text}");
        // What is proved is what it said: another sign, and it counts no more.
        let mut other = written.clone();
        other.kinematics.tilt.direction *= -1;
        assert_eq!(other.sight(), Sight::Changed(done.date), "{text}");
        // Nobody needs another plan because somebody looked.
        let mut unseen = written.clone();
        (unseen.machine.jogged, unseen.machine.jogged_as) = (None, None);
        assert_eq!(unseen.canonical(), written.canonical());
    });
    let exchanged = exchanged.into_inner();
    note(&format!("{exchanged} machines were not as their profiles say"));
    assert!(exchanged > 20, "{exchanged}");
}

fn plain() -> Real {
    Real { stand: 0, level: 0.0, directions: [1, 1], about: 'X', letters: ['A', 'C'], base: "generic-ac", ..drawn(0) }
}

#[test]
fn what_tells_nothing_is_refused() {
    let code = |real: &Real, believed: &str, answer: &dyn Fn(&JogQuestion, Seen) -> Option<Seen>| {
        let error = tried(real, believed, folder().path(), answer).unwrap_err();
        (error.code().to_owned(), error.to_string())
    };
    let own = "extends = \"generic-ac\"\n";
    let saying = |subject: JogSubject, axis: char, says: Option<Seen>| {
        move |question: &JogQuestion, seen: Seen| {
            if question.subject == subject && question.axis == axis { says } else { Some(seen) }
        }
    };
    let (way, table) = (JogSubject::Way, JogSubject::Table);
    for (real, answer, wanted) in [
        (Real { mirrored: true, ..plain() }, None, "jog/mirrored"),
        (Real { sunk: true, ..plain() }, None, "jog/astray: Z"),
        (plain(), Some((JogSubject::Ready, ' ', Some(Seen::No))), "jog/not-ready"),
        (plain(), Some((way, 'X', Some(Seen::Unsure))), "jog/unseen: X"),
        (plain(), Some((way, 'X', Some(Seen::Nothing))), "jog/stuck: X"),
        (plain(), Some((way, 'X', Some(Seen::Apart))), "jog/astray: X"),
        (plain(), Some((way, 'Y', Some(Seen::Left))), "jog/astray: Y"),
        (plain(), Some((table, 'A', Some(Seen::Unsure))), "jog/unseen: A"),
        (plain(), Some((table, 'A', Some(Seen::Nothing))), "jog/other-table: A moves no part | C turns"),
        (plain(), Some((table, 'C', Some(Seen::NearRose))), "jog/other-table: A tilts | C tilts"),
        (plain(), Some((JogSubject::Amount, 'A', Some(Seen::No))), "jog/wrong-amount: A | 10"),
        (plain(), Some((JogSubject::Level, 'A', Some(Seen::No))), "jog/not-level: A0.00"),
        (plain(), Some((table, 'A', None)), "job/answer: A | no answer"),
    ] {
        let (code, text) = match answer {
            Some((subject, axis, says)) => code(&real, own, &saying(subject, axis, says)),
            None => code(&real, own, &honest),
        };
        let (of, facts) = wanted.split_once(": ").unwrap_or((wanted, ""));
        assert_eq!(code, of, "{text}");
        assert!(facts.split(" | ").all(|fact| text.contains(fact)), "{wanted}: {text}");
    }
    // A printer of three axes; Klipper's motors that commands turn.
    let three = std::thread::scope(|scope| {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let address = Address::parse(&format!("tcp:{}", listener.local_addr().unwrap()));
        scope.spawn(move || {
            let (mut host, _) = listener.accept().unwrap();
            let lines = std::io::BufReader::new(host.try_clone().unwrap());
            for line in std::io::BufRead::lines(lines).map_while(Result::ok) {
                let says = if line == "M115" {
                    "FIRMWARE_NAME:Marlin 2.1"
                } else {
                    "X:1.00 Y:2.00 Z:300.00 E:0.00 Count X:80"
                };
                host.write_all(format!("{says}\nok\n").as_bytes()).unwrap();
            }
        });
        let request = JogRequest { machine: "generic-ac".into(), at: at(&address) };
        jog(&request, &|_, _| panic!("nothing is asked"), &World::here(&Silent)).unwrap_err().to_string()
    });
    assert!(three.contains("no axis besides X, Y and Z"), "{three}");
    // Another firmware, and no room for the step.
    let (code_of, text) = code(&plain(), "extends = \"trident-5-axis\"\n", &honest);
    assert_eq!(code_of, "jog/other-firmware", "{text}");
    let (code_of, text) = code(&plain(), &format!("{own}[kinematics.tilt]\nmin_deg = -5.0\nmax_deg = 5.0\n"), &honest);
    assert!(code_of == "jog/no-room" && text.contains("A is at 0.00"), "{code_of}: {text}");
    let low = format!("{own}[limits]\nz_mm = [296.0, 301.0]\n");
    let (code_of, text) = code(&plain(), &low, &honest);
    assert!(code_of == "jog/no-room" && text.contains("Z is at "), "{code_of}: {text}");
}

#[test]
fn a_warm_nozzle_is_left_to_cool() {
    let folder = folder();
    let error = printer(&plain(), folder.path(), |address, _| {
        by_hand(address, &["G28", "M104 S200"]);
        let request = JogRequest { machine: "generic-ac".into(), at: at(address) };
        let yes = |question: &JogQuestion, _: &_| Some(question.answers[0]);
        jog(&request, &yes, &World::here(&Silent)).unwrap_err()
    });
    assert!(matches!(error, MachineError::Jog(JogFault::Hot { c, .. }) if c >= 200.0), "{error}");
}

#[test]
fn the_command_asks_by_numbers_and_writes_what_was_seen() {
    let folder = folder();
    let real = Real { letters: ['C', 'A'], directions: [-1, 1], ..plain() };
    printer(&real, folder.path(), |address, _| {
        by_hand(address, &["G28", "G90", "G1 Z150 F900", "G1 X0 Y0 F900"]);
        let own = folder.path().join("seen.toml");
        let run = |answers: &str| {
            let mut command = trunnion();
            command.args(["machine", "jog", "-m", "generic-ac", "-o"]).arg(&own).arg("--port").arg(address.to_string());
            let typed = folder.path().join("typed.txt");
            std::fs::write(&typed, answers).unwrap();
            command.stdin(std::fs::File::open(typed).unwrap()).output().unwrap()
        };
        // Ready; X right; Y away; Z up; A turns anticlockwise, by so much; C tilts, near side rose, by so much, level.
        let done = run("1\n\nseven\n1\n3\n5\n5\n1\n1\n1\n1\n");
        assert!(done.status.success(), "{}", said(&done));
        let text = std::fs::read_to_string(&own).unwrap();
        for line in [
            "extends = \"generic-ac\"",
            "jogged_as = \"generic-ac: C about X -1, level at 0; A +1\"",
            "letter = \"C\"  # A before",
            "letter = \"A\"  # C before",
            "direction = -1  # 1 before",
        ] {
            assert!(text.contains(line), "{line}: {text}");
        }
        assert!(said(&done).contains("from 1 to 8"), "{}", said(&done));
        std::fs::remove_file(&own).unwrap();
        let short = run("1\n1\n");
        assert_eq!(short.status.code(), Some(2), "{}", said(&short));
        let silent = run("");
        assert!(fails(&said(&silent), "job/answer: ready | no answer"), "{}", said(&silent));
        let odd = run("2\n");
        assert!(odd.status.code() == Some(1) && fails(&said(&odd), "jog/not-ready"), "{}", said(&odd));
        assert!(fails(&said(&short), "job/answer: Y | no answer") && !own.exists(), "{}", said(&short));
    });
}

/// Moonraker with a simulated Klipper behind it, in virtual time.
struct Behind {
    sim: Mutex<(Sim, Duration)>,
    log: Log,
    printing: bool,
}

impl Behind {
    fn runs(&self, line: &str) -> Result<(), String> {
        let (sim, now) = &mut *self.sim.lock().unwrap();
        sim.took(usize::MAX);
        sim.receive(*now, format!("{line}\n").as_bytes());
        let mut said = String::new();
        while !said.lines().any(|line| line.starts_with("ok")) {
            *now = sim.next_wake().unwrap_or(*now + Duration::from_millis(1)).max(*now);
            sim.advance(*now);
            said += std::str::from_utf8(sim.pending()).unwrap();
            sim.took(usize::MAX);
        }
        for (at, logged) in sim.take_log() {
            if let Logged::Pose([x, y, z, a, c, e]) = logged {
                let at = at.as_secs_f64();
                writeln!(self.log.clone(), "{at:.6} pose {x:.4} {y:.4} {z:.4} {a:.4} {c:.4} {e:.5}").unwrap();
            }
        }
        let no = said.lines().find(|line| line.starts_with("!!") || line.contains("Unknown command"));
        no.map_or(Ok(()), |no| Err(no.to_owned()))
    }
}

impl Web for Behind {
    fn ask(&self, ask: &Ask<'_>, _: &dyn Fn(usize)) -> Result<ServerAnswer, Trouble> {
        let path = ask.url.strip_prefix("http://here").unwrap();
        let plain = |text: &str| -> String {
            let mut parts = text.split('%');
            let first = parts.next().unwrap().to_owned();
            parts.fold(first, |all, part| {
                all + &char::from(u8::from_str_radix(&part[..2], 16).unwrap()).to_string() + &part[2..]
            })
        };
        let state = if self.printing { "printing" } else { "standby" };
        let (status, body) = if let Some(script) = path.strip_prefix("/printer/gcode/script?script=") {
            match self.runs(&plain(script)) {
                Ok(()) => (200, json!({"result": "ok"})),
                Err(words) => (400, json!({"error": {"message": words}})),
            }
        } else {
            let (sim, now) = &*self.sim.lock().unwrap();
            let [x, y, z, ..] = sim.position(*now);
            let [nozzle, _] = sim.temperatures(*now);
            let of = |object: serde_json::Value| (200, json!({"result": {"status": object}}));
            match path {
                "/printer/info" => (200, json!({"result": {"state": "ready"}})),
                "/printer/objects/query?print_stats" => of(json!({"print_stats": {"state": state}})),
                "/printer/objects/query?gcode_move=gcode_position" => {
                    of(json!({"gcode_move": {"gcode_position": [x, y, z, 0.0]}}))
                }
                "/printer/objects/query?extruder=temperature" => of(json!({"extruder": {"temperature": nozzle}})),
                "/printer/objects/query?extruder=target" => of(json!({"extruder": {"target": 0.0}})),
                other => panic!("{other}"),
            }
        };
        Ok(ServerAnswer { status, location: None, challenge: None, body: body.to_string().into_bytes() })
    }

    fn wait(&self, _: Duration) {}
}

fn behind(real: &Real, folder: &Path, printing: bool) -> Behind {
    let own = folder.join("real.toml");
    std::fs::write(&own, real.profile()).unwrap();
    let machine = load_profile(&own.to_str().unwrap().into(), &World::here(&Silent)).unwrap();
    let sim = simulate(&SimulateRequest::default(), &machine).unwrap();
    Behind { sim: Mutex::new((sim, Duration::ZERO)), log: Log::default(), printing }
}

fn moonraker(server: &str) -> MachineAt {
    let address = ServerAddress::parse(server).unwrap();
    MachineAt::Server { address, key: None, silence: Duration::from_secs(1), fingerprint: None }
}

#[test]
fn klipper_s_axes_are_tried_through_moonraker() {
    for seed in 0..8 {
        let real = Real { base: "fractal-5-pro", level: 0.0, ..drawn(seed) };
        let letters = if seed % 2 == 0 { ['A', 'C'] } else { ['C', 'A'] };
        let (real, folder) = (Real { letters, ..real }, folder());
        let web = behind(&real, folder.path(), false);
        real.made_ready().iter().for_each(|line| web.runs(line).unwrap());
        let person = Person::beside(&real, &web.log);
        let request = JogRequest { machine: "fractal-5-pro".into(), at: moonraker("moonraker:http://here") };
        let world = World { web: &web, ..World::here(&Silent) };
        let done = jog(&request, &|question, _| Some(person.answers(question)), &world);
        let seen = done.unwrap_or_else(|e| panic!("{seed} {real:?}: {e}")).jogged;
        assert_eq!(
            (seen.tilt, seen.about, seen.tilt_direction, seen.rotation, seen.rotation_direction),
            (real.letters[0], real.about, real.directions[0], real.letters[1], real.directions[1]),
            "{seed} {real:?}"
        );
        assert_eq!(seen.level_deg, Some(0.0), "its start code has just put it there");
    }
    // A start code that homes a motor says nothing of where it stands when the table is level.
    let homes = "G28\nMANUAL_STEPPER STEPPER=tilt MOVE=-100 STOP_ON_ENDSTOP=1\nMANUAL_STEPPER STEPPER=tilt SET_POSITION=-95\n\
                 MANUAL_STEPPER STEPPER=tilt MOVE=0\nMANUAL_STEPPER STEPPER=tilt GCODE_AXIS=A\nMANUAL_STEPPER STEPPER=rot GCODE_AXIS=C\nM109 S{nozzle_c}";
    let steppers = "[kinematics.tilt]\nstepper = \"tilt\"\n[kinematics.rotation]\nstepper = \"rot\"\n";
    for (start, keys, level, seen) in [
        (homes, "", None, "A about X -1; C +1"),
        // Turns as commands, as in Klipper before 2025.
        (COMMANDED, steppers, Some(0.0), "tilt about X -1, level at 0; rot +1"),
    ] {
        let folder = folder();
        let real = Real { base: "fractal-5-pro", directions: [-1, 1], steppers: !keys.is_empty(), ..plain() };
        let own = folder.path().join("mine.toml");
        let text = format!("extends = \"fractal-5-pro\"\n[dialect]\nstart = \"\"\"\n{start}\"\"\"\n{keys}");
        std::fs::write(&own, text).unwrap();
        let web = behind(&real, folder.path(), false);
        real.made_ready().iter().for_each(|line| web.runs(line).unwrap());
        let person = Person::beside(&real, &web.log);
        let request = JogRequest { machine: own.to_str().unwrap().into(), at: moonraker("moonraker:http://here") };
        let world = World { web: &web, ..World::here(&Silent) };
        let done = jog(&request, &|question, _| Some(person.answers(question)), &world).unwrap();
        let text = done.profile(None, &world);
        assert!(done.jogged.level_deg == level && text.contains(seen), "{level:?}: {text}");
        assert!(text.contains("direction = -1  # 1 before"), "{text}");
    }
    // A print that runs is not disturbed, and no other server is driven.
    let folder = folder();
    let web = behind(&Real { base: "fractal-5-pro", ..plain() }, folder.path(), true);
    let world = World { web: &web, ..World::here(&Silent) };
    let code = |server: &str| {
        let request = JogRequest { machine: "fractal-5-pro".into(), at: moonraker(server) };
        jog(&request, &|_, _| panic!("nothing is asked"), &world).unwrap_err().code().to_owned()
    };
    assert_eq!(code("moonraker:http://here"), "server/not-idle");
    assert_eq!(code("duet:http://here"), "server/no-console");
    assert!(web.log.poses().is_empty(), "nothing moved");
}

/// Whoever has not looked is reminded, before a file is made and before it is sent.
#[test]
fn what_was_not_looked_at_is_said_until_it_was() {
    let folder = folder();
    let seen = "[machine]\njogged = \"2026-11-28\"\njogged_as = \"generic-ac: A about X +1, level at 0; C +1\"\n";
    let measured = "[head]\nmeasured = true\n";
    let other = "[kinematics.tilt]\ndirection = -1\n";
    std::fs::write(folder.path().join("part.gcode"), "G28\n").unwrap();
    for (text, words, silent) in [
        (String::new(), vec!["unknown", "trunnion machine jog -m mine.toml", "head of mine.toml is assumed"], vec![]),
        (seen.to_owned(), vec!["head of mine.toml is assumed"], vec!["machine jog"]),
        (measured.to_owned(), vec!["machine jog"], vec!["assumed"]),
        (format!("{seen}{measured}"), vec![], vec!["machine jog", "assumed"]),
        (format!("{seen}{measured}{other}"), vec!["changed after", "2026-11-28", "machine jog"], vec!["assumed"]),
    ] {
        std::fs::write(folder.path().join("mine.toml"), format!("extends = \"generic-ac\"\n{text}")).unwrap();
        for verb in [
            "send part.gcode --unverified -m mine.toml --port nowhere",
            "prepare cube.stl -m mine.toml --slicer builtin -o cube.gcode",
            "profile check mine.toml",
        ] {
            std::fs::copy(crate::pipeline::fixture("cube"), folder.path().join("cube.stl")).unwrap();
            let _ = std::fs::remove_file(folder.path().join("cube.gcode"));
            let run = trunnion().args(verb.split(' ')).current_dir(folder.path()).output().unwrap();
            assert_eq!(run.status.code(), Some(if verb.starts_with("send") { 4 } else { 0 }), "{}", said(&run));
            let said = said(&run);
            assert!(words.iter().all(|word| said.contains(word)), "{text}{verb}: {said}");
            assert!(!silent.iter().any(|word| said.contains(word)), "{text}{verb}: {said}");
        }
    }
}

/// `machine read` and `machine jog` of one machine, with their words.
pub(crate) fn both_verbs() -> Vec<(Vec<String>, std::process::Output)> {
    let folder = folder();
    let real = Real { directions: [-1, 1], ..plain() };
    printer(&real, folder.path(), |address, log| {
        Person::at(&real, address, log);
        let read = "machine read --json --keep-rest --set kinematics.tilt.direction=1 --set kinematics.rotation.direction=1 -o own.toml --port";
        let calls = [(read, ""), ("machine jog --json -m own.toml -o seen.toml --port", "1\n1\n3\n5\n1\n1\n1\n5\n1\n")];
        let call = |(words, typed): (&str, &str)| {
            let words: Vec<String> = words.split(' ').map(str::to_owned).chain([address.to_string()]).collect();
            let answers = folder.path().join("typed.txt");
            std::fs::write(&answers, typed).unwrap();
            let mut command = trunnion();
            let typed = std::fs::File::open(answers).unwrap();
            let run = command.args(&words).current_dir(folder.path()).stdin(typed).output().unwrap();
            assert!(run.status.success(), "{words:?}: {}", said(&run));
            (words, run)
        };
        calls.map(call).into_iter().collect()
    })
}
