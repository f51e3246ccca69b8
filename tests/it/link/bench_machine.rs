//! A small machine, a program, and both ends joined, for the tests of the link.

use std::sync::Arc;
use std::time::Duration;

use trunnion::geom::{Angle, Vec3};
use trunnion::link::sim::{Logged, MachineModel, Quirks, Script, Sim};
use trunnion::link::{Heaters, Loopback, Outcome, Program, ProgramRules, Protocol, Retreat, Sender, SenderSettings};
use trunnion::motion::replay::Reading;
use trunnion::motion::{Accelerations, AxisRange, LinearLimits};
use trunnion::trace::{FeedCount, Rates, TraceSetting};

fn axis(letter: u8, range: Option<(f64, f64)>) -> AxisRange {
    let range = range.map(|(low, high)| (Angle::from_deg(low), Angle::from_deg(high)));
    AxisRange { letter, direction: 1.0, zero: Angle::ZERO, range, max_rate: 0.5, absent: false }
}

const ACCELERATIONS: Accelerations =
    Accelerations { axes: [1000.0, 1000.0, 200.0, 100.0, 100.0, 2000.0], junction_mm: 0.02 };

pub(super) fn axes() -> [AxisRange; 2] {
    [axis(b'A', Some((-15.0, 90.0))), axis(b'C', None)]
}

fn reading() -> Reading {
    let [tilt, rotation] = axes();
    Reading { rotary: Some((tilt, rotation)), ..Reading::sliced() }
}

fn rates() -> Rates {
    let axes = [('A', 20.0), ('C', 30.0)];
    Rates { feed: FeedCount::Linear, max_feed: 12_000.0, rapid_is_free: false, axes }
}

pub(super) fn model() -> MachineModel {
    MachineModel {
        head: None,
        reading: reading(),
        axes: axes(),
        limits: LinearLimits { min: Vec3::new(-150.0, -150.0, -50.0), max: Vec3::new(150.0, 150.0, 300.0) },
        home_mm: [-150.0, -150.0, 300.0],
        rates: rates(),
        accelerations: ACCELERATIONS,
        coldest_extrusion_c: 170.0,
        heat_factor: 20.0,
        person: Duration::from_secs(40),
    }
}

pub(super) fn retreat() -> Retreat {
    Retreat {
        axes: axes(),
        z_max_mm: 300.0,
        head: None,
        lift_mm: 20.0,
        retract_mm: 2.0,
        retract_feed: 2100.0,
        travel_feed: 6000.0,
        z_feed: 900.0,
        extruder: b'E',
        heaters: Heaters::Off,
        turning: Default::default(),
        home: vec!["G28".to_owned()],
    }
}

pub(super) fn settings(protocol: Protocol) -> SenderSettings {
    SenderSettings::new(protocol, retreat())
}

/// Every line different, so that one lost and one doubled cannot hide each other.
pub(super) fn text(protocol: Protocol, moves: u32) -> String {
    text_at(protocol, moves, 1800)
}

/// The same at `feed` mm/min.
pub(super) fn text_at(protocol: Protocol, moves: u32, feed: u32) -> String {
    let mut text = match protocol {
        Protocol::Grbl => format!("G21\nG90\nF{feed}\n"),
        _ => format!("G21\nG90\nM83\nG28\nM140 S60\nM104 S200\nM109 S200\nG1 F{feed}\n"),
    };
    for i in 0..moves {
        let (x, y) = (f64::from(i % 97) - 48.0, f64::from(i) * 0.001 - 100.0);
        if i % 50 == 0 {
            text += &format!(";LAYER_CHANGE\nG1 Z{:.3}\n", 5.0 + f64::from(i) * 0.0002);
        }
        let e = if protocol == Protocol::Grbl { String::new() } else { format!(" E{:.5}", 0.02 + f64::from(i) * 1e-5) };
        text += &format!("G1 X{x:.3} Y{y:.3}{e}\n");
    }
    text
}

pub(super) fn program(protocol: Protocol, text: &str) -> Arc<Program> {
    let longest_line = if protocol == Protocol::Grbl { 80 } else { 96 };
    let rules = ProgramRules {
        protocol,
        longest_line,
        setting: TraceSetting { reading: reading(), rates: rates(), accelerations: ACCELERATIONS, swivel: None },
    };
    Arc::new(Program::read(text.as_bytes(), &rules).unwrap())
}

/// The two ends of a fresh link; Grbl's machine is homed.
pub(super) fn joined(program: &Arc<Program>, settings: SenderSettings, quirks: Quirks, script: Script) -> Loopback {
    let protocol = settings.protocol;
    let mut sim = Sim::new(protocol, model(), quirks, Script::none());
    if protocol == Protocol::Grbl {
        sim.receive(Duration::ZERO, b"$H\n");
        sim.advance(Duration::from_secs(30));
        let said = sim.pending().len();
        sim.took(said);
    }
    sim.set_script(script);
    sim.take_log();
    Loopback::new(Sender::new(Arc::clone(program), settings), sim)
}

/// What the printer executed of the program: its own lines (M105, M110, pauses) left out.
pub(super) fn executed(link: &mut Loopback) -> Vec<String> {
    let lines = link.sim.take_log().into_iter().filter_map(|(_, logged)| match logged {
        Logged::Accepted(block) => Some(without_padding(&String::from_utf8_lossy(&block))),
        _ => None,
    });
    lines
        .filter(|l| !["M105", "M110", "M115", "M400", "G4P0.01", "M114", "$H"].iter().any(|own| l.starts_with(own)))
        .collect()
}

/// A move without the zero that may pad its first fraction.
pub(super) fn without_padding(block: &str) -> String {
    let Some(point) = block.find('.').filter(|_| block.starts_with("G1")) else { return block.to_owned() };
    let end = block[point + 1..].find(|c: char| !c.is_ascii_digit()).map_or(block.len(), |n| point + 1 + n);
    format!("{}{}", block[..end].trim_end_matches('0'), &block[end..])
}

pub(super) fn blocks(program: &Program) -> Vec<String> {
    (0..program.len()).map(|i| String::from_utf8_lossy(program.block(i)).into_owned()).collect()
}

/// 0 missing, 0 doubled, in order.
#[track_caller]
pub(super) fn assert_once_each(program: &Program, executed: &[String]) {
    let wanted = blocks(program);
    let first = wanted.iter().zip(executed).position(|(w, e)| w != e).unwrap_or(wanted.len().min(executed.len()));
    assert!(
        wanted == executed,
        "{} sent, {} executed, first difference at {first}: {:?} / {:?}",
        wanted.len(),
        executed.len(),
        wanted.get(first),
        executed.get(first)
    );
}

/// Executed so far is a beginning of the program: nothing missing between, nothing doubled.
#[track_caller]
pub(super) fn assert_beginning(program: &Program, executed: &[String]) {
    let wanted = blocks(program);
    assert!(wanted.starts_with(executed), "{:?}", executed.iter().zip(&wanted).find(|(e, w)| e != w));
}

/// Runs to its end, which comes before a bound in virtual time: none hangs.
#[track_caller]
pub(super) fn end(link: &mut Loopback) -> Outcome {
    let bound = Duration::from_secs(4 * 3600);
    link.run(bound).unwrap_or_else(|| panic!("not ended after {bound:?}; last: {:?}", link.events().last()))
}

/// The last lines of the wire, for the message of a failing test.
pub(super) fn tail(link: &Loopback, count: usize) -> String {
    let mut text = String::new();
    for (at, heading, bytes) in link.recorded() {
        let arrow = if *heading == trunnion::link::Heading::Out { "->" } else { "<-" };
        for line in String::from_utf8_lossy(bytes).lines() {
            text += &format!("{:10.3} {arrow} {line}\n", at.as_secs_f64());
        }
    }
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(count)..].join("\n")
}
