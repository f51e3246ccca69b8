//! `machine jog`: machines whose axes are not as their profiles say, simulated, and a person who looks at them.
//!
//! The person knows nothing of `motion`: what a turn does to the rim is worked out here, by a matrix written down again.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use trunnion::calibrate::{JogFault, JogQuestion, JogSubject, Seen};
use trunnion::job::{
    Bench, JogRequest, JogResult, MachineError, Silent, SimulateRequest, World, jog, load_profile, simulate,
};
use trunnion::link::serial::{Address, Heard, Port};
use trunnion::profile::{Sight, resolve};

use crate::support::{Numbers, fails, folder, note, said, seeds, trunnion, wait_for};

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
}

impl Real {
    pub(crate) fn profile(&self) -> String {
        let Self { base, letters: [tilt, rotation], about, directions: [up, round], level, .. } = self;
        format!(
            "extends = \"{base}\"\n[kinematics.tilt]\nletter = \"{tilt}\"\nabout = \"{about}\"\ndirection = {up}\nzero_deg = {level:?}\n\
             min_deg = -90.0\nmax_deg = 120.0\n[kinematics.rotation]\nletter = \"{rotation}\"\ndirection = {round}\n"
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
    let quirks = if real.base == "grblhal-ac" { vec!["latches-errors".to_owned()] } else { Vec::new() };
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
        let (home, wait) = if real.base == "grblhal-ac" { ("$H", "G4 P0.01") } else { ("G28", "M400") };
        let (level, tilt) = (real.level, real.letters[0]);
        let room = resolve("x.toml", &real.profile()).unwrap().0.limits;
        let [x, y] = [room.x_mm, room.y_mm].map(|[low, high]| (low + high) / 2.0);
        let z = room.z_mm[1] - 20.0;
        let place = [format!("G1 Z{z} F900"), format!("G1 X{x} Y{y} F900"), format!("G1 {tilt}{level} F900")];
        by_hand(address, &[home, "G90", &place[0], &place[1], &place[2], wait]);
        // The log comes behind the last `ok`.
        let there = [x, y, z, level];
        let stands = |at: &[f64; 5]| at.iter().zip(&there).all(|(at, there)| (at - there).abs() < 1e-3);
        wait_for("the machine", || log.poses().last().is_some_and(stands));
        Self { real, log, before: log.poses().len(), moved: Mutex::new(0) }
    }

    pub(crate) fn answers(&self, question: &JogQuestion) -> Seen {
        let seen = match question.subject {
            JogSubject::Ready => Seen::Yes,
            JogSubject::Level => {
                let at = self.log.poses().last().unwrap()[3];
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
        let request = JogRequest { machine: own.to_str().unwrap().into(), address: address.clone(), baud: None };
        let done = jog(&request, &|question, _| answer(question, person.answers(question)), &World::here(&Silent));
        // Whatever came of it, every axis is back where it was.
        if done.as_ref().err().is_none_or(|error| error.code() != "job/answer") {
            wait_for("the way back", || log.poses().last() == log.poses().get(person.before - 1));
        }
        done
    })
}

fn honest(_: &JogQuestion, seen: Seen) -> Option<Seen> {
    Some(seen)
}

pub(crate) const BASES: [&str; 4] = ["generic-ac", "trident-5-axis", "grblhal-ac", "fractal-5-pro"];

pub(crate) fn drawn(seed: u64) -> Real {
    let mut random = Numbers::seeded(seed);
    let mut below = |n: usize| (random.between(0.0, n as f64) as usize).min(n - 1);
    let base = BASES[below(4)];
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
        level: if base == "fractal-5-pro" { 0.0 } else { [0.0, 12.5][below(2)] },
        stand: below(4) as u8,
        mirrored: false,
        sunk: false,
    }
}

#[test]
fn each_exchange_and_sign_is_found() {
    let mut exchanged = 0;
    for seed in seeds(40, 400) {
        let (real, folder) = (drawn(seed), folder());
        let believed = format!("extends = \"{}\"\n", real.base);
        let done = tried(&real, &believed, folder.path(), &honest).unwrap_or_else(|e| panic!("{seed} {real:?}: {e}"));
        assert_eq!(done.unfit, None, "{seed} {real:?}");
        exchanged += usize::from(!done.changes.is_empty());
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
    }
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
    let at = |subject: JogSubject, axis: char, says: Option<Seen>| {
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
            Some((subject, axis, says)) => code(&real, own, &at(subject, axis, says)),
            None => code(&real, own, &honest),
        };
        let (of, facts) = wanted.split_once(": ").unwrap_or((wanted, ""));
        assert_eq!(code, of, "{text}");
        assert!(facts.split(" | ").all(|fact| text.contains(fact)), "{wanted}: {text}");
    }
    // Another firmware, and no room for the step.
    let (code_of, text) = code(&plain(), "extends = \"trident-5-axis\"\n", &honest);
    assert_eq!(code_of, "jog/other-firmware", "{text}");
    let (code_of, text) = code(&plain(), &format!("{own}[kinematics.tilt]\nmax_deg = 5.0\n"), &honest);
    assert!(code_of == "jog/no-room" && text.contains("A is at 0.00"), "{code_of}: {text}");
    let low = format!("{own}[limits]\nz_mm = [0.0, 281.0]\n");
    let (code_of, text) = code(&plain(), &low, &honest);
    assert!(code_of == "jog/no-room" && text.contains("Z is at "), "{code_of}: {text}");
}

#[test]
fn a_warm_nozzle_is_left_to_cool() {
    let folder = folder();
    let error = printer(&plain(), folder.path(), |address, _| {
        by_hand(address, &["G28", "M104 S200"]);
        let request = JogRequest { machine: "generic-ac".into(), address: address.clone(), baud: None };
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
            "jogged_as = \"C about X -1, level at 0; A +1\"",
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
        assert!(fails(&said(&short), "job/answer: Y | no answer") && !own.exists(), "{}", said(&short));
    });
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
