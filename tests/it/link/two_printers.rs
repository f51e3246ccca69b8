//! One process, two printers: two ports, two files, two protocols. What befalls one is none of the other's.

use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use trunnion::job::{
    At, Bench, MachineSource, Operator, Outputs, SendError, SendOptions, SendRequest, Sending, Silent, SimulateRequest,
    Source, Verified, Wire, World, load_profile, simulate,
};
use trunnion::link::serial::Address;

use super::real::{gcode, wanted};
use crate::support::folder;

/// Nothing here may take longer.
const LIMIT: Duration = crate::support::PATIENCE;

pub(super) fn machine(protocol: &str) -> MachineSource {
    let toml = format!(
        "extends = \"generic-ac\"\n[machine]\nname = \"{protocol}\"\n[dialect]\nfirmware = \"{protocol}\"\n\
         start = \"G28\\nM109 S{{nozzle_c}} ; GCODE_AXIS=A GCODE_AXIS=C\"\n[link]\nprotocol = \"{protocol}\"\nrehome = \"G28\"\n"
    );
    MachineSource::Toml(Source::Bytes { name: format!("{protocol}.toml"), bytes: toml.into_bytes() })
}

/// A simulated printer until `ended`; where it is goes to `place`, and what it has executed comes back.
pub(super) fn printer(protocol: &str, faults: &[&str], place: &OnceLock<String>, ended: &AtomicBool) -> Vec<String> {
    let world = World::here(&Silent);
    let request = SimulateRequest {
        faults: faults.iter().map(|fault| (*fault).to_owned()).collect(),
        heat: 50.0,
        ..SimulateRequest::default()
    };
    let sim = simulate(&request, &load_profile(&machine(protocol), &world).unwrap()).unwrap();
    let mut log = Vec::new();
    let bench = Bench::new(sim, None, Some(&mut log), &world);
    bench.serve("tcp:0", ended, |at| drop(place.set(at.to_owned()))).unwrap();
    let text = String::from_utf8(log).unwrap();
    text.lines().map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
}

/// The blocks of a printer's log.
fn blocks(log: &[String]) -> Vec<String> {
    let own = ["M105", "M110", "M115", "M400", "M114"];
    let lines = log.iter().filter_map(|line| line.strip_prefix("line "));
    lines.filter(|line| !own.iter().any(|word| line.starts_with(word))).map(super::real::plain).collect()
}

/// Whoever stands by one of the two: `hold` is called in the middle of the print, once.
struct Watcher<'a> {
    line: AtomicU32,
    held: AtomicBool,
    asked: AtomicU32,
    middle: u32,
    hold: &'a (dyn Fn() -> u32 + Sync),
    resends: AtomicU32,
}

impl<'a> Watcher<'a> {
    fn new(middle: u32, hold: &'a (dyn Fn() -> u32 + Sync)) -> Self {
        let zero = || AtomicU32::new(0);
        Self { line: zero(), held: AtomicBool::new(false), asked: zero(), middle, hold, resends: zero() }
    }
}

impl Operator for Watcher<'_> {
    fn told(&self, what: &Sending<'_>, at: At) {
        self.line.store(at.line, Ordering::SeqCst);
        if let Sending::Resend { .. } = what {
            self.resends.fetch_add(1, Ordering::SeqCst);
        }
    }

    /// Asked each time something may be sent, so that by then the print is under way.
    fn interrupts(&self) -> u32 {
        if self.asked.fetch_add(1, Ordering::SeqCst) > self.middle && !self.held.swap(true, Ordering::SeqCst) {
            return (self.hold)();
        }
        0
    }
}

fn print(file: &Path, protocol: &str, place: &OnceLock<String>, operator: &dyn Operator) -> Result<(), SendError> {
    wait_for(|| place.get().is_some());
    let place = place.get().unwrap();
    let world = World::here(&Silent);
    let machine = load_profile(&machine(protocol), &world).unwrap();
    let program = Verified::unverified(std::fs::read(file).unwrap());
    let options = SendOptions::default();
    let request = SendRequest { path: file, program: &program, machine: &machine, plan: None, options: &options };
    let journal = Outputs::new([file]).claim(&file.with_extension("journal")).unwrap();
    let wire = Wire { address: &Address::parse(place), journal: &journal };
    trunnion::job::send(&request, &wire, &world, operator)
}

/// Ends the printers however a test ends: one that panics would wait for them for ever.
pub(super) struct Ends<'a>(pub(super) &'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

fn wait_for(mut there: impl FnMut() -> bool) {
    let until = Instant::now() + LIMIT;
    while !there() {
        assert!(Instant::now() < until, "the other one hangs");
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_printer_that_fails_half_way_leaves_the_other_alone() {
    let dir = folder();
    let files = ["marlin", "klipper"].map(|name| {
        let folder = dir.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        // Files of different lengths.
        gcode(&folder, if name == "marlin" { 1200 } else { 900 })
    });
    let (ended, failed, under_way) = (AtomicBool::new(false), AtomicBool::new(false), AtomicBool::new(false));
    // The failing one waits until the other is in the middle of its print; that one waits there until the first has failed.
    let wait_for_other = || {
        wait_for(|| under_way.load(Ordering::SeqCst));
        0
    };
    let wait_for_failure = || {
        under_way.store(true, Ordering::SeqCst);
        wait_for(|| failed.load(Ordering::SeqCst));
        0
    };
    let (failing, sound) = (Watcher::new(20, &wait_for_other), Watcher::new(20, &wait_for_failure));
    let places = [OnceLock::new(), OnceLock::new()];
    thread::scope(|scope| {
        let _end = Ends(&ended);
        let printers = [
            scope.spawn(|| printer("marlin", &["fatal@600"], &places[0], &ended)),
            scope.spawn(|| printer("klipper", &[], &places[1], &ended)),
        ];
        let broken = scope.spawn(|| {
            let result = print(&files[0], "marlin", &places[0], &failing);
            failed.store(true, Ordering::SeqCst);
            result
        });
        let printed = print(&files[1], "klipper", &places[1], &sound);
        let why = broken.join().unwrap().unwrap_err().to_string();
        ended.store(true, Ordering::SeqCst);
        let logs = printers.map(|printer| printer.join().unwrap());
        assert!(why.contains("Thermal Runaway"), "{why}");
        assert!(printed.is_ok(), "{printed:?}");
        let (half, whole) = (blocks(&logs[0]), blocks(&logs[1]));
        assert!(half.len() > 400 && half.len() < 1000 && wanted(&files[0]).starts_with(&half), "{} lines", half.len());
        assert!(logs[0].last().is_some_and(|l| l == "killed"), "{:?}", logs[0].last());
        assert_eq!(whole, wanted(&files[1]));
        assert!(!logs[1].iter().any(|l| l == "killed" || l == "restarted"));
    });
    assert_eq!(sound.resends.load(Ordering::SeqCst), 0);
    let journal = |file: &Path| std::fs::read_to_string(file.with_extension("journal")).unwrap();
    assert!(journal(&files[0]).contains("\nstopped ") && !journal(&files[0]).contains("\ndone\n"));
    assert!(journal(&files[1]).contains("\ndone\n"));
}

#[test]
fn an_emergency_stop_of_one_is_none_of_the_other() {
    let dir = folder();
    let files = ["one", "two"].map(|name| {
        let folder = dir.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        gcode(&folder, 600)
    });
    let (ended, stopped, under_way) = (AtomicBool::new(false), AtomicBool::new(false), AtomicBool::new(false));
    // Two interrupts at once: no pause, an emergency stop.
    let twice = || {
        wait_for(|| under_way.load(Ordering::SeqCst));
        2
    };
    let wait_for_stop = || {
        under_way.store(true, Ordering::SeqCst);
        wait_for(|| stopped.load(Ordering::SeqCst));
        0
    };
    let (first, second) = (Watcher::new(20, &twice), Watcher::new(20, &wait_for_stop));
    let places = [OnceLock::new(), OnceLock::new()];
    thread::scope(|scope| {
        let _end = Ends(&ended);
        let printers = [
            scope.spawn(|| printer("marlin", &[], &places[0], &ended)),
            scope.spawn(|| printer("marlin", &[], &places[1], &ended)),
        ];
        let cut = scope.spawn(|| {
            let result = print(&files[0], "marlin", &places[0], &first);
            stopped.store(true, Ordering::SeqCst);
            result
        });
        let printed = print(&files[1], "marlin", &places[1], &second);
        let why = cut.join().unwrap().unwrap_err().to_string();
        ended.store(true, Ordering::SeqCst);
        let logs = printers.map(|printer| printer.join().unwrap());
        assert!(why.contains("emergency stop"), "{why}");
        assert!(logs[0].iter().any(|l| l == "killed") && !logs[1].iter().any(|l| l == "killed"));
        assert!(printed.is_ok(), "{printed:?}");
        assert_eq!(blocks(&logs[1]), wanted(&files[1]));
    });
}
