//! Towers as they are printed: proved on the shipped profiles, carried out on a machine whose axes are elsewhere, and measured by their beads.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use trunnion::calibrate::{CalliperReading, DimensionKind, Readings, fit_tower};
use trunnion::geom::SplitMix64;
use trunnion::job::{self, Silent, TowerRequest, TowerResult, World};
use trunnion::profile::{Profile, SHIPPED};
use trunnion::trace::{Zone, read};

use super::shipped;
use super::touched::{Machine, normal};
use super::tower::{hidden, wrong};
use crate::support::{every, fails, folder, note, said, states, trunnion};

type V = Vector3<f64>;

/// A line of plastic as it lies on the table: both ends of its upper edge, the direction across it, its build direction, and its measures.
struct Bead {
    ends: [V; 2],
    across: V,
    along: V,
    up: V,
    width: f64,
    height: f64,
}

impl Bead {
    /// The farthest that it reaches: a box with square ends.
    fn farthest(&self, towards: &V) -> f64 {
        let side = (self.across.dot(towards).abs() + self.along.dot(towards).abs()) * self.width / 2.0;
        let ends = self.ends.map(|end| end.dot(towards));
        ends[0].max(ends[1]) + side + (-self.up.dot(towards) * self.height).max(0.0)
    }
}

/// What a machine lays of a program, by the part: the tip is where the program says, and the table where the machine has it.
fn laid(gcode: &[u8], profile: &Profile, machine: &Machine, parts: &[usize]) -> BTreeMap<usize, Vec<Bead>> {
    let trace = read(gcode, &profile.trace_setting());
    let table = profile.kinematics();
    let mut all: BTreeMap<usize, Vec<Bead>> = BTreeMap::new();
    for one in trace.moves().filter(|one| one.prints()) {
        let state = trace.state(&one);
        let (Some(print), Some(pose), Zone::Prints) = (state.print, state.pose(), state.zone) else { continue };
        let (Some([from, to]), Some(width), Some(height)) = (one.ends(), one.width, one.height) else { continue };
        if (to - from).norm() < 1e-6 {
            continue;
        }
        let words = [table.tilt.word_of(pose.tilt).deg(), table.rotation.word_of(pose.rotation).deg()];
        let lies = |p: V| machine.lies(words, p);
        let turned = |d: V| lies(d) - lies(V::zeros());
        let along = (to - from).normalize();
        let bead = Bead {
            ends: [lies(from), lies(to)],
            across: turned(along.cross(&V::z())),
            along: turned(along),
            up: turned(V::z()),
            width,
            height,
        };
        all.entry(parts[print as usize]).or_default().push(bead);
    }
    all
}

/// The dimensions of what was laid.
fn of_beads(done: &TowerResult, machine: &Machine) -> Vec<f64> {
    let parts: Vec<usize> = done.plan.prints().map(|(_, print)| print.part).collect();
    let beads = laid(done.gcode.program(), &done.machine.profile, machine, &parts);
    let profile = Machine { nominal: machine.nominal.clone(), by: [0.0; 13] };
    let words = done.tower.words_deg()[0];
    let most = |blocks: &[usize], towards: V| {
        let all = blocks.iter().flat_map(|block| &beads[block]);
        all.map(|bead| bead.farthest(&towards)).fold(f64::MIN, f64::max)
    };
    let of = |kind: DimensionKind| match kind {
        DimensionKind::Across(both, towards) => {
            let lies = |q: V| machine.lies(words, profile.place(words, q));
            let towards = lies(towards) - lies(V::zeros());
            most(&both, towards) + most(&both, -towards)
        }
        DimensionKind::Height(block) => most(&[block], V::z()),
    };
    done.tower.dimensions.iter().map(|one| of(one.kind)).collect()
}

fn made(name: &str) -> TowerResult {
    job::tower(&TowerRequest::new(name), None, &World::here(&Silent)).unwrap_or_else(|no| panic!("{name}: {no}"))
}

/// Every shipped machine whose table tilts and turns gets a tower that passes verification, in less time than it takes to read about
/// touches; and the others are refused by name.
#[test]
fn every_shipped_machine_gets_a_tower() {
    for (name, ..) in SHIPPED.iter().step_by(every(3)) {
        if !shipped(name).kinematics().is_table() {
            let refused = job::tower(&TowerRequest::new(*name), None, &World::here(&Silent)).err().unwrap();
            assert!(refused.code() == "input/chain", "{name}: {refused}");
            continue;
        }
        let done = made(name);
        let report = done.gcode.report().unwrap();
        let size = done.tower.blocks.iter().flat_map(|block| block.mesh().vertices().to_vec());
        let reach = size.map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        note(&format!(
            "{name}: tilt {}, {:.0} minutes, {:.1} m of filament, {:.0} mm across",
            done.tower.design.tilt_deg,
            done.seconds() / 60.0,
            report.filament_mm / 1000.0,
            2.0 * reach
        ));
        assert!(report.is_clean() && report.slots == 4 && reach < 40.0, "{name}");
        let slow = name.starts_with("linuxcnc");
        assert!(done.seconds() < if slow { 7200.0 } else { 3600.0 }, "{name}: {} s", done.seconds());
        assert!(done.plan.plan.supports().next().is_none());
        for (figure, error, angle) in &done.errors {
            assert!(error.is_none_or(|error| error < if *angle { 0.25 } else { 0.2 }), "{name}: {figure} to {error:?}");
        }
    }
}

/// As in a drawer: the beads of a machine whose axes are where the profile has them measure as drawn, and those of others tell by how much
/// they are not.
#[test]
fn what_a_hidden_machine_prints_tells_where_its_axes_are() {
    let mut numbers = SplitMix64::seeded(47);
    for name in ["generic-ac", "fibr3d", "pentos", "hendrikjan-5d"] {
        let done = made(name);
        let profile = &done.machine.profile;
        let exact = of_beads(&done, &Machine { nominal: profile.kinematics(), by: [0.0; 13] });
        for (one, mm) in done.tower.dimensions.iter().zip(&exact) {
            assert!(
                (one.drawn_mm - mm).abs() < 0.03,
                "{name}: {} is drawn as {} and laid as {mm}",
                one.name,
                one.drawn_mm
            );
        }
        let mut worst = 0.0_f64;
        for _ in 0..8 {
            let machine = hidden(profile, &mut numbers);
            let mut all = Vec::new();
            for (index, mm) in of_beads(&done, &machine).into_iter().enumerate() {
                all.extend([0, 1].map(|_| CalliperReading {
                    number: index + 1,
                    line: 1,
                    mm: mm + normal(&mut numbers) * 0.01,
                }));
            }
            let k = &profile.kinematics;
            let zeros = [k.tilt.zero_deg, k.rotation.zero_deg, 0.0];
            let (design, printed_with) = (done.tower.design, [k.pivot_mm, k.offset_mm, zeros]);
            let readings = Readings { design, printed_with, repeats_mm: 0.05, readings: all, left_out: Vec::new() };
            let found = fit_tower(profile, name, "t.toml", &readings).unwrap();
            for (unknown, off, _) in wrong(&found, &machine).into_iter().filter(|(unknown, ..)| (*unknown as usize) < 3)
            {
                worst = worst.max(off.abs());
                assert!(off.abs() < 0.1, "{name}: {unknown:?} is wrong by {off}");
            }
        }
        note(&format!("{name}: from the beads of 8 hidden machines the pivot is wrong by {worst:.3} mm at most"));
    }
}

/// The command: a folder with all that is needed, readings typed in, a profile that extends the machine's.
#[test]
fn a_tower_is_made_measured_and_becomes_a_profile() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let own = "extends = \"generic-ac\"\n[machine]\nname = \"mine\"\n[kinematics]\npivot_mm = [10.0, -5.0, -30.0]\n";
    std::fs::write(path("machine.toml"), own).unwrap();
    let run = |args: &[&str]| trunnion().args(args).current_dir(folder.path()).output().unwrap();
    let calibrate = |args: &[&str]| run(&[&["profile", "calibrate", "-m", "machine.toml"], args].concat());
    let made = calibrate(&["--tower", "tower"]);
    assert!(made.status.success(), "{}", said(&made));
    assert!(states(&said(&made), "offset Z | not determined") && states(&said(&made), "verified"), "{}", said(&made));
    for file in ["tower.gcode", "tower.json", "tower.3mf", "sheet.svg", "measured.toml"] {
        assert!(path("tower").join(file).is_file(), "{file}");
    }
    // Proved once more, from the files alone.
    let proved = run(&["verify", "tower/tower.gcode", "--plan", "tower/tower.json"]);
    assert!(proved.status.success(), "{}", said(&proved));

    let empty = calibrate(&["tower/measured.toml"]);
    assert_eq!(empty.status.code(), Some(2), "{}", said(&empty));
    assert!(fails(&said(&empty), "tower/missing: 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 | left_out"), "{}", said(&empty));

    // What was typed in is never overwritten.
    let form = std::fs::read_to_string(path("tower/measured.toml")).unwrap();
    let drawn: Vec<f64> =
        form.lines().filter_map(|l| l.split_once("drawn as ")?.1.strip_suffix(" mm")?.parse().ok()).collect();
    assert_eq!(drawn.len(), 10);
    let mut typed = form.clone();
    // Half a millimetre along the tilt axis: twice that between posts of before and after half a turn.
    for (index, mm) in drawn.iter().enumerate() {
        let mm = mm + [1.0, -1.0].get(index).unwrap_or(&0.0);
        typed = typed.replacen("mm = []", &format!("mm = [{mm:.2}, {:.2}]", mm + 0.02), 1);
    }
    std::fs::write(path("tower/measured.toml"), &typed).unwrap();
    let again = calibrate(&["--tower", "tower"]);
    assert!(fails(&said(&again), "job/there: tower/measured.toml"), "{}", said(&again));
    assert_eq!(std::fs::read_to_string(path("tower/measured.toml")).unwrap(), typed);

    let done = calibrate(&["tower/measured.toml", "-o", "found.toml"]);
    assert!(done.status.success(), "{}", said(&done));
    let shown = run(&["profile", "show", "found.toml", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    let pivot: Vec<f64> = (0..3).map(|i| shown["kinematics"]["pivot_mm"][i].as_f64().unwrap()).collect();
    assert!((pivot[0] - 10.0).abs() > 0.45 && (pivot[0] - 10.0).abs() < 0.55, "{pivot:?}");
    assert!((pivot[1] + 5.0).abs() < 0.05 && (pivot[2] + 30.0).abs() < 0.05, "{pivot:?}");
    assert_eq!(shown["machine"]["name"], "mine");
    let text = std::fs::read_to_string(path("found.toml")).unwrap();
    assert!(
        text.starts_with("# From 10 dimensions of a tower in \"tower/measured.toml\"") && text.contains("pivot X 0.0"),
        "{text}"
    );

    // With the new profile the tower is another.
    let other = run(&["profile", "calibrate", "-m", "found.toml", "tower/measured.toml"]);
    assert!(fails(&said(&other), "tower/other-machine: kinematics.pivot_mm"), "{}", said(&other));
    let small = run(&["profile", "calibrate", "-m", "generic-ac", "--tower", "flat", "--tilt", "80"]);
    assert!(fails(&said(&small), "tower/range: A | 75"), "{}", said(&small));
    assert!(!path("flat/tower.gcode").exists());
}
