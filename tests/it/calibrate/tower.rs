//! The calibration tower: hidden machines found from dimensions that other code takes, what is determined, and what is refused.

use nalgebra::Vector3;
use trunnion::calibrate::{
    Block, CalliperReading, DimensionKind, Readings, TOWER_REPEATS_MM, Tower, TowerDesign, TowerError, TowerFit,
    Unknown, fit_tower, measured, tower_errors,
};
use trunnion::geom::SplitMix64;
use trunnion::profile::Profile;

use super::shipped;
use super::touched::{Machine, normal};
use crate::support::{note, soak};

type V = Vector3<f64>;

/// One with A, one with B, one that counts the other way, one whose letters are exchanged, and a small table.
const MACHINES: [&str; 5] = ["generic-ac", "fibr3d", "hendrikjan-5d", "pentos", "open5x-voron0"];

fn tower_of(profile: &Profile) -> Tower {
    Tower::of(&profile.kinematics(), TowerDesign::candidates(profile, "it", None).unwrap()[0])
}

/// Pivot up to 1.5 mm off, the rotation axis across up to 0.4 mm more, the tilt's zero up to a degree; posts that are printed later stand on
/// the roof: without that nothing would be printed.
pub(super) fn hidden(profile: &Profile, numbers: &mut SplitMix64) -> Machine {
    loop {
        let mut near = |reach: f64| (2.0 * numbers.unit() - 1.0) * reach;
        let mut by = [0.0; 13];
        by[..4].copy_from_slice(&[near(1.5), near(1.5), near(1.5), near(0.4)]);
        by[Unknown::OffsetZ as usize] = -by[Unknown::PivotZ as usize] + near(0.1);
        by[Unknown::TiltZero as usize] = near(1.0).to_radians();
        let machine = Machine { nominal: profile.kinematics(), by };
        let put = Machine { nominal: profile.kinematics(), by: [0.0; 13] };
        let [first, second] = [0, 1].map(|step| tower_of(profile).words_deg()[step]);
        let top = V::new(0.0, 0.0, 18.0);
        let [one, other] = [first, second].map(|words| machine.lies(words, put.place(words, top)));
        if (one - other).x.hypot((one - other).y) < 4.2 {
            return machine;
        }
    }
}

/// The corners of a block as they lie on the table of `machine`, every wall `wider` / 2 further out: other code than the one that is tested.
fn printed(machine: &Machine, tower: &Tower, block: &Block, wider: f64) -> Vec<V> {
    let profile = Machine { nominal: machine.nominal.clone(), by: [0.0; 13] };
    let words = tower.words_deg()[block.step];
    let (mesh, up) = (block.mesh(), block.up());
    let walls: Vec<(usize, V)> = (0..mesh.facets().len()).filter_map(|i| Some((i, mesh.normal(i)?))).collect();
    let outward = |corner: usize| {
        let mut normals: Vec<V> = Vec::new();
        for (facet, normal) in walls.iter().filter(|(_, normal)| normal.dot(&up).abs() < 1e-6) {
            let own = mesh.facets()[*facet].contains(&(corner as u32));
            if own && normals.iter().all(|known| (known - normal).norm() > 1e-6) {
                normals.push(*normal);
            }
        }
        normals.into_iter().sum::<V>()
    };
    let corner = |(i, q): (usize, &V)| machine.lies(words, profile.place(words, q + outward(i) * (wider / 2.0)));
    mesh.vertices().iter().enumerate().map(corner).collect()
}

/// What callipers without an error read.
fn exact(machine: &Machine, tower: &Tower, wider: f64) -> Vec<f64> {
    let corners: Vec<Vec<V>> = tower.blocks.iter().map(|block| printed(machine, tower, block, wider)).collect();
    let most = |blocks: &[usize], towards: V| {
        let all = blocks.iter().flat_map(|&block| &corners[block]);
        all.map(|q| q.dot(&towards)).fold(f64::MIN, f64::max)
    };
    // The jaws stand on the roof of the base as it was printed.
    let (profile, words) = (Machine { nominal: machine.nominal.clone(), by: [0.0; 13] }, tower.words_deg()[0]);
    let lies = |q: V| machine.lies(words, profile.place(words, q));
    let of = |kind: DimensionKind| match kind {
        DimensionKind::Across(both, towards) => {
            let towards = lies(towards) - lies(V::zeros());
            most(&both, towards) + most(&both, -towards)
        }
        DimensionKind::Height(block) => most(&[block], V::z()),
    };
    tower.dimensions.iter().map(|one| of(one.kind)).collect()
}

fn keys(profile: &Profile) -> [[f64; 3]; 3] {
    let k = &profile.kinematics;
    [k.pivot_mm, k.offset_mm, [k.tilt.zero_deg, k.rotation.zero_deg, 0.0]]
}

/// `times` readings of each dimension.
fn readings(profile: &Profile, tower: &Tower, exact: &[f64], times: usize, mut noise: impl FnMut() -> f64) -> Readings {
    let mut all = Vec::new();
    for (index, mm) in exact.iter().enumerate() {
        all.extend((0..times).map(|_| CalliperReading { number: index + 1, line: index + 1, mm: mm + noise() }));
    }
    let (design, printed_with) = (tower.design, keys(profile));
    Readings { design, printed_with, repeats_mm: TOWER_REPEATS_MM, readings: all, left_out: Vec::new() }
}

fn fitted(profile: &Profile, readings: &Readings) -> Result<TowerFit, TowerError> {
    fit_tower(profile, "it", "t.toml", readings)
}

/// By how much each figure is wrong, mm or degrees, and whether its interval holds it.
pub(super) fn wrong(fit: &TowerFit, machine: &Machine) -> Vec<(Unknown, f64, bool)> {
    let of = |e: &trunnion::calibrate::Estimate| {
        let off = fit.chain.by()[e.unknown as usize] - machine.by[e.unknown as usize];
        let off = if e.unknown.is_angle() { off.to_degrees() } else { off };
        (e.unknown, off, off.abs() <= e.error)
    };
    fit.estimates.iter().map(of).collect()
}

fn is_pivot(unknown: Unknown) -> bool {
    (unknown as usize) < 3
}

#[test]
fn the_dimensions_are_those_of_other_code() {
    let mut numbers = SplitMix64::seeded(40);
    for name in MACHINES {
        let profile = shipped(name);
        let tower = tower_of(&profile);
        for _ in 0..20 {
            let mut machine = hidden(&profile, &mut numbers);
            for bend in 7..12 {
                machine.by[bend] = (2.0 * numbers.unit() - 1.0) * 0.01;
            }
            machine.by[6] = 0.02;
            let wider = 0.1 * numbers.unit();
            let ours = measured(&profile.kinematics(), &tower, &machine.by, wider);
            for (ours, theirs) in ours.iter().zip(exact(&machine, &tower, wider)) {
                assert!((ours - theirs).abs() < 1e-9, "{name}: {ours} {theirs}");
            }
        }
    }
}

/// Exact readings give the exact machine, and lines of any width change nothing.
#[test]
fn a_wider_line_cancels() {
    let mut numbers = SplitMix64::seeded(42);
    for name in MACHINES {
        let profile = shipped(name);
        let tower = tower_of(&profile);
        let machine = hidden(&profile, &mut numbers);
        for wider in [-0.05, 0.0, 0.05, 0.2] {
            let read = readings(&profile, &tower, &exact(&machine, &tower, wider), 1, || 0.0);
            let found = fitted(&profile, &read).unwrap();
            for (unknown, off, _) in wrong(&found, &machine) {
                assert!(off.abs() < 1e-5, "{name}, {wider}: {unknown:?} is wrong by {off}");
            }
            assert!((found.wider_mm.unwrap()[0] - wider).abs() < 1e-6, "{name}: {:?}", found.wider_mm);
        }
    }
}

#[test]
fn hidden_machines_are_found_to_a_tenth() {
    let mut numbers = SplitMix64::seeded(43 + soak().unwrap_or(0));
    for name in MACHINES {
        let profile = shipped(name);
        let tower = tower_of(&profile);
        let (mut worst, mut held, mut all) = (Vec::new(), 0, 0);
        for seed in 0..240 {
            let machine = hidden(&profile, &mut numbers);
            let (wider, sigma) = (0.05 * (2.0 * numbers.unit() - 1.0), 0.03 + 0.02 * numbers.unit());
            let read = readings(&profile, &tower, &exact(&machine, &tower, wider), 2, || normal(&mut numbers) * sigma);
            let found = fitted(&profile, &read).unwrap_or_else(|no| panic!("{name} {seed}: {no}"));
            let off = wrong(&found, &machine);
            worst.push(off.iter().filter(|(u, ..)| is_pivot(*u)).map(|(_, off, _)| off.abs()).fold(0.0, f64::max));
            held += off.iter().filter(|(.., inside)| *inside).count();
            all += off.len();
        }
        worst.sort_by(f64::total_cmp);
        let share = held as f64 / all as f64;
        note(&format!(
            "{name} at {}: pivot off by {:.3} mm in the middle, {:.3} in 95 of 100, {:.3} at worst; {share:.3} of {all} intervals hold",
            tower.design.tilt_deg, worst[120], worst[228], worst[239]
        ));
        // The tower for a table of 50 mm has shorter arms.
        let most = if name == "open5x-voron0" { 0.15 } else { 0.1 };
        assert!(worst[228] < most, "{name}: {:?}", &worst[220..]);
        assert!((0.92..=0.985).contains(&share), "{name}: {share} of {all} intervals hold the truth");
    }
}

/// What is not measured is not determined, and named; the rest is still found.
#[test]
fn the_rank_tells_what_is_determined() {
    let profile = shipped("generic-ac");
    let tower = tower_of(&profile);
    let machine = hidden(&profile, &mut SplitMix64::seeded(44));
    let exact = exact(&machine, &tower, 0.03);
    let without = |left_out: &[usize]| {
        let mut read = readings(&profile, &tower, &exact, 2, || 0.0);
        read.readings.retain(|reading| !left_out.contains(&reading.number));
        read.left_out = left_out.to_vec();
        fitted(&profile, &read)
    };
    let never = ["offset Z", "zero of C"];
    for (left_out, lost) in [
        (&[][..], &[][..]),
        // One of a pair, of three heights and of two blocks may break off.
        (&[2], &[]),
        (&[9], &[]),
        (&[1, 2], &["pivot X"]),
        (&[5], &["pivot Y", "pivot Z"]),
        (&[9, 10], &["pivot Y", "pivot Z"]),
    ] {
        let found = without(left_out).unwrap();
        let missing = |name: &&str| found.undetermined.iter().any(|u| u == name);
        assert!(never.iter().all(missing) && lost.iter().all(missing), "{left_out:?}: {:?}", found.undetermined);
        if lost.is_empty() {
            assert_eq!(found.undetermined.len(), never.len(), "{left_out:?}: {:?}", found.undetermined);
            for (unknown, off, _) in wrong(&found, &machine) {
                assert!(off.abs() < 1e-5, "{left_out:?}: {unknown:?} is wrong by {off}");
            }
        }
    }
    let all: Vec<usize> = (1..=8).collect();
    assert!(matches!(without(&all), Err(TowerError::Untold { .. })));
    let errors = tower_errors(&profile, &tower, TOWER_REPEATS_MM);
    let told = |name: &str| errors.iter().find(|(n, ..)| n == name).unwrap().1;
    assert!(told("offset Z").is_none() && told("zero of C").is_none() && told("pivot Z").is_some_and(|mm| mm < 0.05));
}

/// The level table's height is the first layer's affair: it stays, also where the tilt's zero is wrong.
#[test]
fn the_level_table_stays_as_high_as_it_is() {
    let mut numbers = SplitMix64::seeded(45);
    for name in MACHINES {
        let profile = shipped(name);
        let tower = tower_of(&profile);
        let machine = hidden(&profile, &mut numbers);
        let found = fitted(&profile, &readings(&profile, &tower, &exact(&machine, &tower, 0.0), 1, || 0.0)).unwrap();
        let [level, first] = tower.words_deg()[0];
        let height = |table: &trunnion::motion::TableKinematics| {
            let [tilt, rotation] = [level, first].map(trunnion::geom::Angle::from_deg);
            let pose =
                trunnion::motion::Pose { tilt: table.tilt.angle_of(tilt), rotation: table.rotation.angle_of(rotation) };
            table.forward(pose).translation.z
        };
        assert!((height(&found.table) - height(&profile.kinematics())).abs() < 1e-9, "{name}");
    }
}

#[test]
fn exchanged_and_mistyped_readings_are_named() {
    let mut numbers = SplitMix64::seeded(46);
    let profile = shipped("generic-ac");
    let tower = tower_of(&profile);
    let (mut named, mut all) = (0, 0);
    for _ in 0..6 {
        let mut machine = hidden(&profile, &mut numbers);
        machine.by.iter_mut().for_each(|by| *by *= 0.5);
        let exact = exact(&machine, &tower, 0.02);
        for i in 1..=Tower::DIMENSIONS {
            for j in i + 1..=Tower::DIMENSIONS {
                // What is as large as another by chance may be called by its number.
                if (exact[i - 1] - exact[j - 1]).abs() < 0.4 {
                    continue;
                }
                let mut read = readings(&profile, &tower, &exact, 2, || normal(&mut numbers) * 0.03);
                for reading in &mut read.readings {
                    reading.number = if reading.number == i {
                        j
                    } else if reading.number == j {
                        i
                    } else {
                        reading.number
                    };
                }
                all += 1;
                // E against F is told by the readings alone where they were drawn 0.7 mm apart.
                let why = fitted(&profile, &read).expect_err(&format!("{i} for {j}")).to_string();
                named += usize::from(why.contains(&format!("{i} and {j} seem")));
            }
        }
        for number in 1..=Tower::DIMENSIONS {
            let mut read = readings(&profile, &tower, &exact, 2, || normal(&mut numbers) * 0.03);
            // A digit: 11.05 for 24.05.
            read.readings.iter_mut().filter(|r| r.number == number).for_each(|r| r.mm += 13.0);
            match fitted(&profile, &read) {
                Err(TowerError::FarOff { number: told, line, .. }) => assert_eq!((told, line), (number, number)),
                other => panic!("{number}: {other:?}"),
            }
        }
        // What is wrong by a millimetre and still possible is found by what the others say of it.
        for number in 6..=8 {
            let mut read = readings(&profile, &tower, &exact, 2, || normal(&mut numbers) * 0.03);
            read.readings.iter_mut().filter(|r| r.number == number).for_each(|r| r.mm += 1.2);
            let why = fitted(&profile, &read).expect_err("no mistake");
            assert!(matches!(why, TowerError::Contradiction { .. } | TowerError::Unlevel { .. }), "{number}: {why}");
        }
    }
    note(&format!("{named} of {all} exchanges are named as such, the others as mistakes"));
    assert!(named * 10 > all * 8, "{named} of {all}");
}

#[test]
fn bad_forms_are_refused_at_their_line() {
    let profile = shipped("generic-ac");
    let tower = tower_of(&profile);
    let form = tower.form(&profile, 0.05);
    let full: String = {
        let mut number = 0;
        let line = |line: &str| {
            number += usize::from(line == "mm = []");
            let mm = tower.dimensions.get(number.max(1) - 1).map_or(0.0, |one| one.drawn_mm);
            if line == "mm = []" { format!("mm = [{mm:.2}, {mm:.2}]\n") } else { format!("{line}\n") }
        };
        form.lines().map(line).collect()
    };
    let read = Readings::parse("t.toml", &full).unwrap();
    assert_eq!((read.readings.len(), read.design), (20, tower.design));
    assert!(fitted(&profile, &read).unwrap().estimates.iter().all(|e| e.differs.abs() < 0.03));
    let at = full.lines().position(|line| line.starts_with("mm = ")).unwrap() + 1;
    let first = full.lines().nth(at - 1).unwrap();
    let with = |new: &str| Readings::parse("t.toml", &full.replacen(first, new, 1));
    let why = |new: &str| match with(new) {
        Err(TowerError::Value { line, why, .. }) => {
            assert_eq!(line, at, "{new}: {why}");
            why
        }
        other => panic!("{new}: {other:?}"),
    };
    // Decimal commas, in all ways in which they come.
    for comma in
        ["mm = 24,05", "mm = [24,05]", "mm = [24,15, 24,20]", "mm = \"24,05\"", "mm = [24,31]", "mm = [24,31, 24,28]"]
    {
        assert!(why(comma).contains("decimal comma; write 24."), "{comma}: {}", why(comma));
    }
    assert!(why("mm = [24.05, 23.05]").contains("dimension 1"));
    assert!(why("mm = [-3.0]").contains("between 0 and 1000"));
    assert!(why("mm = [nan]").contains("between 0 and 1000"));
    assert!(why("mm = \"much\"").contains("list of numbers"));
    assert!(with("mm = 24.05").is_ok() && with("mm = [24, 24]").is_ok() && with("mm = [24.05]").is_ok());
    assert!(matches!(with("mm = []"), Err(TowerError::Missing { numbers, .. }) if numbers == [1]));
    assert!(with("mm = []\nleft_out = true").is_ok_and(|read| read.left_out == [1]));
    let broken = |from: &str, to: &str| {
        let text = full.replacen(from, to, 1);
        assert_ne!(text, full, "{from}");
        Readings::parse("t.toml", &text)
            .and_then(|read| fitted(&profile, &read).map(|_| ()))
            .map_err(|no| <&str>::from(&no))
    };
    for (from, to, code) in [
        ("number = 2", "number = 1", "tower/value"),
        ("number = 2", "number = 11", "tower/value"),
        ("number = 2", "nummer = 2", "tower/syntax"),
        ("repeats_to_mm = 0.05", "repeats_to_mm = 5.0", "tower/value"),
        ("tilt_deg = 60.0", "tilt_deg = 0.0", "tower/value"),
        ("rotation_deg = [0.0, 180.0]", "rotation_deg = [0.0, 90.0]", "tower/value"),
        ("half_mm = 20.0", "half_mm = nan", "tower/value"),
        ("pivot_mm = [0.0, 0.0, -20.0]", "pivot_mm = [0.0, 0.0, -21.0]", "tower/other-machine"),
        ("zero_deg = [0.0, 0.0]", "zero_deg = [1.0, 0.0]", "tower/other-machine"),
        ("[tower]", "[tower", "tower/syntax"),
    ] {
        assert_eq!(broken(from, to), Err(code), "{to}");
    }
}

#[test]
fn machines_that_no_tower_fits_are_refused() {
    let of = |text: &str, tilt: Option<f64>| {
        TowerDesign::candidates(&super::profile(text), "it", tilt).map(|all| all.len()).map_err(|no| <&str>::from(&no))
    };
    let with = |keys: &str| format!("extends = \"generic-ac\"\n{keys}");
    let leaning = with("[kinematics.tilt]\nalong = [0.9997, 0.02, -0.01]\n");
    assert_eq!(of(&leaning, None), Err("tower/not-square"));
    assert_eq!(of(&with("[kinematics.rotation]\nmin_deg = -80.0\nmax_deg = 80.0\n"), None), Err("tower/range"));
    assert_eq!(of(&with("[kinematics.tilt]\nmin_deg = -5.0\nmax_deg = 12.0\n"), None), Err("tower/range"));
    assert_eq!(of(&with("[table]\nradius_mm = 15.0\n"), None), Err("tower/no-room"));
    for (tilt, fits) in [(45.0, true), (-12.0, true), (95.0, false), (5.0, false), (f64::NAN, false)] {
        assert_eq!(of(&with(""), Some(tilt)).is_ok(), fits, "{tilt}");
    }
}
