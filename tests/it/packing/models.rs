//! Models: more go into a run by their shapes than by their boxes; what is said to lie apart and to lift out does.

use trunnion::geom::{Mat3, Vec3};
use trunnion::pack::{Method, PackGoal, PackSolid, Packed, Put, Room, Turns, Watch, apart, lift, pack_models};

use super::shapes::{block, boat};

fn room(space_mm: [f64; 3], turns: Turns, liftable: bool) -> Room {
    Room { space_mm, gap_mm: 1.0, turns, liftable }
}

fn packed(solids: &[PackSolid], room: &Room, goal: PackGoal, steps: u64) -> Packed {
    let mut asked = |_| None;
    let done = pack_models(solids, room, goal, Method::Auto, true, 1, &mut Watch::new(steps, &mut asked)).unwrap();
    apart(solids, room, &done.put).unwrap();
    done
}

/// A boat in a farm's bin: at least a fifth more than their boxes allow, the best packing of which is known to be 82 or fewer.
#[test]
fn more_boats_than_boxes() {
    let solids = [PackSolid::of(boat().iter(), 1.0, 200)];
    let size = solids[0].bounds(&Mat3::identity()).size();
    assert!(size.x > 59.9 && size.y > 30.0 && size.z > 47.9, "{size}");
    let room = room([165.0, 165.0, 320.0], Turns::Any, false);
    let done = packed(&solids, &room, PackGoal::Filling, 8_000_000);
    assert!(done.put.len() >= 99, "{} boats, {} as boxes", done.put.len(), done.boxes);
    assert_eq!(done, packed(&solids, &room, PackGoal::Filling, 8_000_000), "the same steps, the same packing");
}

/// Each piece is lifted in small steps through all that is still there, by the exact test.
#[test]
fn what_is_said_to_lift_out_does() {
    let solids = [PackSolid::of(boat().iter(), 1.0, 5), PackSolid::of([&block([0.0; 3], [20.0, 30.0, 12.0])], 1.0, 4)];
    let room = room([90.0, 80.0, 110.0], Turns::Any, true);
    let done = packed(&solids, &room, PackGoal::Runs, 3_000_000);
    let lifts = lift(&solids, &room, &done.put);
    assert_eq!(lifts.len(), done.runs);
    let high = Room { space_mm: [90.0, 80.0, 400.0], gap_mm: 1e-3, ..room };
    for lift in &lifts {
        assert!(lift.locked.is_empty());
        let mut left: Vec<usize> = lift.order.clone();
        for &piece in &lift.order {
            left.retain(|&other| other != piece);
            for step in 0..110 {
                let moved = |p: usize| {
                    let by = if p == piece { Vec3::z() * f64::from(step) } else { Vec3::zeros() };
                    Put { shift: done.put[p].shift + by, ..done.put[p] }
                };
                let all: Vec<_> = left.iter().chain([&piece]).map(|&p| moved(p)).collect();
                apart(&solids, &high, &all).unwrap();
            }
        }
    }
}

/// Two C's, open to each other, with an arm of each between the arms of the other: neither comes out upward before the other, and that
/// is told.
#[test]
fn pieces_that_hold_each_other_are_told() {
    let clamp = |spine: f64| {
        let parts = [
            block([0.0, 0.0, 0.0], [20.0, 4.0, 2.0]),
            block([spine, 0.0, 2.0], [spine + 2.0, 4.0, 8.0]),
            block([0.0, 0.0, 8.0], [20.0, 4.0, 10.0]),
        ];
        PackSolid::of(parts.iter(), 1.0, 1)
    };
    let solids = [clamp(0.0), clamp(18.0)];
    let put =
        |model, x: f64, z: f64| Put { run: 0, model, copy: 0, turn: Mat3::identity(), shift: Vec3::new(x, 0.0, z) };
    let room = room([80.0; 3], Turns::None, false);
    let [one, two] = [put(0, 0.0, 0.0), put(1, 10.0, 4.0)];
    apart(&solids, &room, &[one, two]).unwrap();
    let told = &lift(&solids, &room, &[one, two])[0];
    assert_eq!((told.order.len(), told.locked.len()), (0, 2), "{told:?}");
    let beside = &lift(&solids, &room, &[one, put(1, 40.0, 0.0)])[0];
    assert_eq!((beside.order.clone(), beside.locked.len()), (vec![0, 1], 0));
    let above = &lift(&solids, &room, &[one, put(1, 4.0, 40.0)])[0];
    assert_eq!(above.order, [1, 0]);
}

/// Bounds hold where the best is known: cubes that fill the space but for their gaps.
#[test]
fn the_bound_of_models_is_one() {
    let cube = PackSolid::of([&block([0.0; 3], [10.0; 3])], 3.0, 9);
    let tight = room([21.0, 21.0, 21.0], Turns::None, true);
    let runs = packed(std::slice::from_ref(&cube), &tight, PackGoal::Runs, 200_000);
    assert_eq!(runs.runs, 2);
    assert!(runs.bound <= 2.0 && runs.bound >= 1.0);
    let filled = packed(std::slice::from_ref(&cube), &tight, PackGoal::Filling, 200_000);
    assert_eq!(filled.put.len(), 8);
    assert!(filled.bound >= 24.0 && filled.bound <= 27.0, "{}", filled.bound);
}

/// Angles of metal, which go into each other: boxes waste most of each; annealing is at least not worse.
#[test]
fn other_methods_gain_over_boxes_too() {
    let parts = [block([0.0; 3], [60.0, 20.0, 8.0]), block([0.0, 0.0, 8.0], [8.0, 20.0, 60.0])];
    let solids = [PackSolid::of(parts.iter(), 1.0, 40)];
    let room = room([125.0, 45.0, 130.0], Turns::Any, false);
    let by = |method, steps| {
        let mut asked = |_| None;
        let mut watch = Watch::new(steps, &mut asked);
        let done =
            pack_models(&solids, &room, PackGoal::Filling, method, method == Method::Auto, 1, &mut watch).unwrap();
        apart(&solids, &room, &done.put).unwrap();
        (done.boxes as usize, done.put.len())
    };
    let (boxes, covered) = by(Method::Coverings, 8_000_000);
    assert!(covered > boxes, "{covered} by coverings, {boxes} by boxes");
    let (_, cells) = by(Method::Auto, 4_000_000);
    assert!(cells > boxes, "{cells} by cells, {boxes} by boxes");
    let (_, annealed) = by(Method::Anneal, 3_000_000);
    assert!(annealed >= boxes, "{annealed} by annealing, {boxes} by boxes");
    crate::support::note(&format!("angles: boxes {boxes}, coverings {covered}, cells {cells}, annealing {annealed}"));
}
