//! The link: lines a second and processor time a line, in process and over a pseudo-terminal.
//!
//! In process both ends run on one thread in virtual time, so that wall time is processor time. Over the pseudo-terminal the two
//! commands talk to each other, on two cores and (with `taskset`) on one; lines a second and the processor time of both are
//! printed first. The window makes the difference: Marlin's usual 128 bytes hold two or three five-axis lines, and so many
//! are carried by one exchange of the two processes; the wide one is that of a firmware with 2048 bytes and 32 commands.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use divan::Bencher;
use divan::counter::ItemsCount;
use trunnion::geom::Vec3;
use trunnion::link::sim::{MachineModel, Quirks, Script, Sim};
use trunnion::link::{Heaters, Loopback, Outcome, Program, ProgramRules, Protocol, Retreat, Sender, SenderSettings};
use trunnion::motion::LinearLimits;
use trunnion::profile::{resolve, shipped};

const LINES: u32 = 20_000;

fn main() {
    let dir = tempfile::tempdir().expect("a folder");
    let wide = dir.path().join("wide.toml");
    let toml = "extends = \"generic-ac\"\n[machine]\nname = \"wide\"\n[link]\nbuffer = 2048\ncommands = 32\n";
    std::fs::write(&wide, toml).expect("written");
    for (name, profile, lines) in [("128 bytes", Path::new("generic-ac"), LINES * 2), ("2048 bytes", &wide, LINES * 10)]
    {
        for cores in [2, 1] {
            pty(dir.path(), name, profile, lines, cores);
        }
    }
    divan::main();
}

/// Moves of five axes, 55 bytes a line on the wire.
fn text(lines: u32) -> String {
    let mut text = "G21\nG90\nM83\nG28\nM109 S200\nG1 F12000\n".to_owned();
    for i in 0..lines {
        let x = f64::from(i % 200) * 0.1;
        text += &format!("G1 X{x:.3} Y{:.3} Z10.205 A31.125 C120.{:03} E0.00415\n", 50.125 + x, i % 1000);
    }
    text
}

fn ends(protocol: Protocol) -> (Arc<Program>, SenderSettings, MachineModel) {
    let (file, toml) = shipped("generic-ac").expect("shipped");
    let profile = resolve(file, toml).expect("resolves").0;
    let table = profile.kinematics();
    let axes = [table.tilt, table.rotation];
    let rules = ProgramRules { protocol, longest_line: 96, setting: profile.trace_setting() };
    let program = Arc::new(Program::read(text(LINES).as_bytes(), &rules).expect("a program"));
    let retreat = Retreat {
        axes: axes.clone(),
        z_max_mm: 300.0,
        lift_mm: 20.0,
        retract_mm: 2.0,
        retract_feed: 2100.0,
        travel_feed: 6000.0,
        z_feed: 900.0,
        extruder: b'E',
        heaters: Heaters::Off,
        turning: Default::default(),
        head: None,
        home: Vec::new(),
    };
    let model = MachineModel {
        reading: profile.reading(),
        axes,
        limits: LinearLimits { min: Vec3::new(-150.0, -200.0, -80.0), max: Vec3::new(150.0, 200.0, 320.0) },
        head: None,
        home_mm: [-150.0, -200.0, 320.0],
        rates: profile.trace_setting().rates,
        accelerations: profile.accelerations(),
        coldest_extrusion_c: 170.0,
        heat_factor: 1.0,
        person: Duration::from_secs(30),
    };
    (program, SenderSettings::new(protocol, retreat), model)
}

/// Host and simulated printer on one thread, faults none.
#[divan::bench(args = ["marlin", "rrf", "klipper"])]
fn in_process(bencher: Bencher<'_, '_>, name: &str) {
    let protocol = Protocol::named(name).expect("a protocol");
    let (program, settings, model) = ends(protocol);
    bencher.counter(ItemsCount::new(program.len())).bench_local(|| {
        let sim = Sim::new(protocol, model.clone(), Quirks::of(protocol), Script::none()).without_log();
        let mut link = Loopback::new(Sender::new(Arc::clone(&program), settings.clone()), sim);
        assert_eq!(link.run(Duration::from_secs(1_000_000)), Some(Outcome::Done));
    });
}

/// Taking a file apart, times of all blocks included.
#[divan::bench]
fn read_program(bencher: Bencher<'_, '_>) {
    let text = text(LINES);
    let (file, toml) = shipped("generic-ac").expect("shipped");
    let setting = resolve(file, toml).expect("resolves").0.trace_setting();
    let rules = ProgramRules { protocol: Protocol::Marlin, longest_line: 96, setting };
    bencher.counter(ItemsCount::new(LINES)).bench_local(|| Program::read(text.as_bytes(), &rules).expect("a program"));
}

/// Processor seconds of a process so far, from Linux's `/proc`; 0 elsewhere.
fn processor(id: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}

/// The command as `cargo build --release` leaves it, beside this bench's own folder.
fn binary() -> PathBuf {
    let own = std::env::current_exe().expect("a running program");
    let binary = own.ancestors().nth(2).expect("target/release/deps").join("trunnion");
    assert!(binary.is_file(), "{} is not there: cargo build --release", binary.display());
    binary
}

/// The command, on one core where `cores` is 1.
fn trunnion(cores: u32) -> Command {
    let binary = &binary();
    if cores > 1 {
        return Command::new(binary);
    }
    let mut command = Command::new("taskset");
    command.args(["-c", "0"]).arg(binary);
    command
}

/// `trunnion send` to `trunnion simulate`.
#[expect(clippy::print_stdout, reason = "a bench prints its figures")]
fn pty(dir: &Path, name: &str, profile: &Path, lines: u32, cores: u32) {
    let (file, link) = (dir.join("a.gcode"), dir.join("tty"));
    std::fs::write(&file, text(lines)).expect("written");
    let mut printer = trunnion(cores);
    printer.args(["simulate", "-q", "--speed", "max", "--heat", "100", "-m"]).arg(profile).arg("--link").arg(&link);
    let Ok(mut printer) = printer.spawn() else {
        println!("pty, {name}, one core: taskset is not installed");
        return;
    };
    let start = Instant::now();
    while !link.exists() && start.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let start = Instant::now();
    let mut host = trunnion(cores);
    host.args(["send", "-q", "--unverified", "-m"]).arg(profile).arg("--port").arg(&link).arg(&file);
    let mut host = host.stderr(Stdio::null()).spawn().expect("the host");
    let mut used = 0.0;
    while host.try_wait().expect("the host").is_none() && start.elapsed() < Duration::from_secs(60) {
        used = processor(host.id());
        std::thread::sleep(Duration::from_millis(5));
    }
    let seconds = start.elapsed().as_secs_f64();
    let ended = host.wait().expect("the host");
    let (lines, machine) = (f64::from(lines), processor(printer.id()));
    println!(
        "pty, {name}, {cores} cores: {:.0} lines/s; processor time a line: host {:.1} us, printer {:.1} us; {ended}",
        lines / seconds,
        used / lines * 1e6,
        machine / lines * 1e6
    );
    let _ = (printer.kill(), printer.wait());
}
