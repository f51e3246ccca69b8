//! Building sequences: the two studies of section 5.4 and the candelabrum's, figures 7 and 14 to 17.

use std::collections::BTreeSet;

use trunnion::assembly::upright;
use trunnion::fixtures::{Fixture, candelabrum as menorah, two_boxes as boxes};
use trunnion::geom::Vec3;
use trunnion::job::{Arrangement, PlanRequest, PlanResult, PoseChoice, Silent, Source, World, plan, sequences};
use trunnion::mesh::{Model, stl_binary_parts};
use trunnion::planning::{Priority, TimeSlot};

use super::super::item::{Item, Row};
use super::super::scene::{BLUE, GREY, sheet};
use super::super::sources::{degrees, model};
use super::optima::{fibr3d, turned};
use super::pictures::{at_pose, whole};

/// The direction of the paper's rotation (0, 90): along the beam, which in our models reaches along +X.
const LYING: &str = "+x";

/// A direction of the file by its axis; `None` for another.
fn axis(d: &Vec3) -> Option<&'static str> {
    let axes = [
        ("+x", Vec3::x()),
        ("-x", -Vec3::x()),
        ("+y", Vec3::y()),
        ("-y", -Vec3::y()),
        ("+z", Vec3::z()),
        ("-z", -Vec3::z()),
    ];
    axes.into_iter().find(|(_, axis)| degrees(d, axis) < 0.1).map(|(name, _)| name)
}

/// Slots of parts with the directions of the file along which they are built, `0 +z | 1 +x`; parts of a slot in order.
fn in_words(model: &Model, up: [f64; 3], slots: &[TimeSlot]) -> Option<String> {
    let turn = upright(&model.parts, Vec3::from(up)).rotation.transpose();
    let slot = |slot: &TimeSlot| {
        let one = |print: &trunnion::planning::Print| {
            Some(format!("{} {}", print.part, axis(&(turn * Vec3::from(print.up)))?))
        };
        let mut all: Vec<String> = slot.prints.iter().map(one).collect::<Option<_>>()?;
        all.sort();
        Some(all.join(", "))
    };
    Some(slots.iter().map(slot).collect::<Option<Vec<_>>>()?.join(" | "))
}

/// Every sequence of a model in every way that it can stand, whose parts are built along what the paper allows each of them; and how many
/// there are in all.
pub(super) fn feasible(fixture: &Fixture, allowed: &[&[&str]]) -> Result<(Vec<String>, usize), String> {
    let source = Source::Bytes { name: fixture.file.to_owned(), bytes: fixture.stl() };
    let mut request = PlanRequest::new(source, "generic-ac");
    request.arrangement = Arrangement { standing: PoseChoice::Any, snap_mm: 0.0, ..Arrangement::default() };
    let model = model(fixture.clone());
    let (mut found, mut count) = (BTreeSet::new(), 0);
    let done = sequences(&request, usize::MAX, &World::here(&Silent), |up, slots| {
        count += 1;
        let words = up.and_then(|up| in_words(&model, up, &slots));
        found.extend(words.filter(|words| {
            words.split([',', '|']).map(str::trim).all(|one| {
                let (part, along) = one.split_once(' ').unwrap_or_default();
                part.parse().is_ok_and(|part: usize| allowed[part].contains(&along))
            })
        }));
    });
    done.map_err(|error| error.to_string())?;
    Ok((found.into_iter().collect(), count))
}

/// Rows for what the paper lists and what is found.
pub(super) fn listed(fixture: &Fixture, allowed: &[&[&str]], printed: &[(&str, String)]) -> Vec<Row> {
    let (found, count) = match feasible(fixture, allowed) {
        Ok(found) => found,
        Err(error) => return vec![Row::same("sequences", "a list", error)],
    };
    let mut rows = vec![
        Row::absolute("distinct feasible sequences", printed.len() as f64, found.len() as f64, 0.0, "sequences")
            .because(format!(
                "of the orientations that the paper allows each part; without that limit there are {count}"
            )),
    ];
    for (name, wanted) in printed {
        let ours = found.iter().find(|one| *one == wanted).cloned();
        rows.push(Row::same(*name, wanted.clone(), ours.unwrap_or_else(|| "not found".to_owned())));
    }
    rows
}

/// Figure 7 and the first study.
pub(super) fn two_boxes() -> Item {
    let fixture = boxes();
    let (z, x) = ("+z", LYING);
    let printed = [("L2", format!("0 {z} | 1 {x}")), ("L4", format!("0 {x} | 1 {x}"))];
    let one = |parts: &[usize], words: &str| whole(&fixture, parts, words);
    let frames = vec![one(&[0, 1], "the object"), one(&[0], "part 0"), one(&[1], "part 1")];
    Item::figure("7", "First case-study with two simple parts, and its sequences (section 5.4)")
        .picture("", sheet("Figure 7", 3, frames, Vec::new()))
        .rows(listed(&fixture, &[&[z, x], &[z, x]], &printed))
        .note("A sequence is slots of parts with the direction of the model along which each is built; the paper's rotation (0, 90) is +x here.")
}

/// Parts of slots, as `0 | 1 | 3 5`.
fn slots_of(parts: &[&[usize]]) -> String {
    let slot = |parts: &&[usize]| {
        let mut parts = parts.to_vec();
        parts.sort_unstable();
        parts.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
    };
    parts.iter().map(slot).collect::<Vec<_>>().join(" | ")
}

fn slots_of_plan(made: &PlanResult) -> String {
    let slots: Vec<Vec<usize>> =
        made.plan.plan.slots.iter().map(|slot| slot.prints.iter().map(|print| print.part).collect()).collect();
    slots_of(&slots.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

const ARMS: [usize; 8] = [3, 5, 7, 8, 11, 13, 15, 17];
const UPRIGHTS: [usize; 8] = [2, 4, 6, 9, 10, 12, 14, 16];
/// The second sequence that is printed, part by part.
const SINGLE: [usize; 18] = [0, 1, 3, 5, 7, 8, 11, 4, 10, 13, 2, 12, 15, 6, 14, 17, 9, 16];

/// The candelabrum in the paper's frame, planned.
fn planned(priority: Priority) -> Result<PlanResult, String> {
    let parts: Vec<_> = menorah().parts.iter().map(|(_, mesh)| turned(mesh)).collect();
    let bytes = stl_binary_parts(&parts.iter().collect::<Vec<_>>());
    let mut request = PlanRequest::new(Source::Bytes { name: "candelabrum.stl".to_owned(), bytes }, fibr3d()?);
    request.options.priority = priority;
    request.options.remedies = false;
    plan(&request, &World::here(&Silent)).map_err(|error| error.to_string())
}

/// Figures 14 to 17.
pub(super) fn candelabrum() -> Vec<Item> {
    match [Priority::Together, Priority::Single, Priority::OnlySingle].map(planned) {
        [Ok(together), Ok(single), Ok(only)] => {
            vec![arms(&together), uprights(&together), part_five(&single), last(&single, &only)]
        }
        _ => Vec::new(),
    }
}

/// Tilt and rotation of a part's print, degrees, rounded as the paper rounds them.
fn pose(made: &PlanResult, part: usize) -> Option<[f64; 2]> {
    let prints = made.plan.plan.slots.iter().flat_map(|slot| &slot.prints);
    prints
        .filter(|print| print.part == part)
        .map(|print| [print.tilt_deg.round() + 0.0, print.rotation_deg.round() + 0.0])
        .next()
}

fn pose_row(made: &PlanResult, part: usize, printed: [f64; 2]) -> Row {
    let words = |[a, c]: [f64; 2]| format!("({a}, {c})");
    Row::same(format!("part {part}: tilt, rotation"), words(printed), pose(made, part).map_or_else(String::new, words))
}

fn arms(made: &PlanResult) -> Item {
    let printed = slots_of(&[&[0], &[1], &ARMS, &UPRIGHTS]);
    let rotation = |part: usize| if [3, 5, 11, 13].contains(&part) { -90.0 } else { 90.0 };
    Item::figure("14", "Arms printed together: the third slot of the first sequence L1")
        .picture("standing in grey, printed in this slot in blue", at_pose("Figure 14", made, &[0, 1], &ARMS, 3))
        .row(Row::same("slots of L1", printed, slots_of_plan(made)))
        .rows(ARMS.map(|part| pose_row(made, part, [70.0, rotation(part)])))
        .row(Row::absolute("building sequence size, equation 8", 41.0, made.plans[0].sequence_size as f64, 0.0, "").because("computed from L1 as printed"))
        .note(
            "Positive angles turn the table itself, right-handed. In the frame of our file, where arms reach along +X and not along -Y, the \
             rotations are 180 and 0. The paper prints tilt and rotation and does not say which way is positive.",
        )
}

fn uprights(made: &PlanResult) -> Item {
    let before: Vec<usize> = [0, 1].into_iter().chain(ARMS).collect();
    Item::figure("15", "Uprights printed together: the last slot of L1")
        .picture("standing in grey, printed in this slot in blue", at_pose("Figure 15", made, &before, &UPRIGHTS, 2))
        .rows(UPRIGHTS.map(|part| pose_row(made, part, [0.0, 0.0])))
}

fn part_five(made: &PlanResult) -> Item {
    Item::figure("16", "Part 5 printed by itself in the sequence L2")
        .picture("standing in grey, part 5 in blue", at_pose("Figure 16", made, &[0, 1, 3], &[5], 5))
        .row(pose_row(made, 5, [70.0, -90.0]))
}

fn last(single: &PlanResult, only: &PlanResult) -> Item {
    let printed: Vec<String> = SINGLE.iter().map(usize::to_string).collect();
    let all: Vec<usize> = (0..18).collect();
    let slots = |made: &PlanResult| made.plan.plan.slots.len() as f64;
    let parts = &menorah();
    let frames = vec![whole(parts, &all, "all 18 parts")];
    let why = "the paper takes the first sequence that its recursion meets; ours is the best: of those with the least building sequence size and \
               staircase error one with the fewest turns of the table, so parts of one pose come after each other";
    Item::figure("17", "The finished candelabrum, and the sequence L2 of single parts")
        .picture("", sheet("Figure 17", 1, frames, vec![(BLUE, "parts"), (GREY, "table")]))
        .row(Row::absolute("slots of L2", 18.0, slots(single), 0.0, "slots"))
        .row(Row::absolute("slots without line 18", 18.0, slots(only), 0.0, "slots"))
        .row(Row::same(
            "the same sequence without line 18",
            "yes",
            if slots_of_plan(single) == slots_of_plan(only) { "yes" } else { "no" },
        ))
        .row(Row::open("order of parts", printed.join(" | "), slots_of_plan(single), why))
        .row(Row::open("poses of the table, one after the other", "11", single.plans[0].pose_changes.to_string(), why))
        .row(
            Row::absolute("building sequence size", 153.0, single.plans[0].sequence_size as f64, 0.0, "")
                .because("computed from L2 as printed"),
        )
}
