//! Packing: first what comes of the published boxes and of boats in a bin, then how long some of it takes.
//!
//! `cargo bench -p trunnion-benches --bench pack` takes some five minutes: each of the 120 instances of Martello, Pisinger and Vigo has one second, each of 70 containers of Bischoff and Ratcliff two. With
//! `TRUNNION_BOXES=FOLDER` they are written there as texts, for `trunnion pack --boxes` and for `benches/compare/pack_py3dbp.py`. The latest
//! figures are in docs/explanation/measurements.md.

#[allow(dead_code)]
#[path = "../tests/it/packing/generator.rs"]
mod generator;
#[allow(dead_code)]
#[path = "../tests/it/packing/ratcliff.rs"]
mod ratcliff;
#[allow(dead_code)]
#[path = "../tests/it/packing/shapes.rs"]
mod shapes;

use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

use divan::Bencher;
use trunnion::pack::{
    BoxPacking, Ended, Instance, Method, PackGoal, PackSolid, Packed, Room, Turns, Watch, apart, check, fewest_runs,
    pack, pack_models, volume,
};

const CLASSES: [i64; 6] = [1, 4, 5, 6, 7, 8];
/// Time for each instance, s.
const SECONDS: f64 = 1.0;
/// The published best of 50 and 100 boxes, all classes.
const PUBLISHED: [(usize, usize); 2] = [(50, 775), (100, 1510)];

fn main() {
    let mut said = String::new();
    for (boxes, published) in PUBLISHED {
        let (mut all, mut least) = (0, 0);
        for class in CLASSES {
            let (mut runs, mut bound) = (0, 0);
            for which in 1..=10 {
                let instance = generator::instance(class, boxes, which);
                written(&instance, class, boxes, which);
                let answer = timed(&instance, PackGoal::Runs, SECONDS);
                check(&instance, &answer.placed, true).expect("a packing");
                (runs, bound) = (runs + answer.runs, bound + answer.bound as usize);
            }
            let _ = writeln!(said, "class {class}, {boxes} boxes: {runs} runs, at least {bound}");
            (all, least) = (all + runs, least + bound);
        }
        let _ = writeln!(said, "{boxes} boxes: {all} runs, at least {least}; the published best is {published}");
    }
    for class in 1..=7 {
        let share = |which| {
            let instance = ratcliff::instance(class, which);
            let answer = timed(&instance, PackGoal::Filling, 2.0 * SECONDS);
            check(&instance, &answer.placed, false).expect("a packing");
            100.0 * instance.value(&answer.placed) / volume(&instance.space)
        };
        let _ = writeln!(said, "containers BR{class}: {:.2} %", (1..=10).map(share).sum::<f64>() / 10.0);
    }
    for (turns, liftable) in [(Turns::Z90, false), (Turns::Any, false), (Turns::Any, true)] {
        let began = Instant::now();
        let (solids, room) = (boats(), bin(turns, liftable));
        let done = in_the_bin(&solids, &room, 30_000_000);
        let seconds = began.elapsed().as_secs_f64();
        apart(&solids, &room, &done.put).expect("a packing");
        let (count, boxes) = (done.put.len(), done.boxes);
        let _ = writeln!(said, "boats, {turns:?}, liftable {liftable}: {count} (as boxes {boxes}), {seconds:.1} s");
    }
    let _ = std::io::stdout().write_all(said.as_bytes());
    divan::main();
}

fn timed(instance: &Instance, goal: PackGoal, seconds: f64) -> BoxPacking {
    let began = Instant::now();
    let mut asked = |_| (began.elapsed().as_secs_f64() > seconds).then_some(Ended::Time);
    pack(instance, goal, Method::Auto, 1, &mut Watch::new(u64::MAX, &mut asked)).expect("boxes that fit")
}

fn written(instance: &Instance, class: i64, boxes: usize, which: u64) {
    let Some(folder) = std::env::var_os("TRUNNION_BOXES") else { return };
    let lines: Vec<String> = instance.items.iter().map(|item| item.size.map(|s| s.to_string()).join(" ")).collect();
    let name = format!("class-{class}-{boxes}-{which:02}.txt");
    std::fs::write(std::path::Path::new(&folder).join(name), lines.join("\n") + "\n").expect("a folder");
}

fn boats() -> [PackSolid; 1] {
    [PackSolid::of(shapes::boat().iter(), 1.0, 200)]
}

fn bin(turns: Turns, liftable: bool) -> Room {
    Room { space_mm: [165.0, 165.0, 320.0], gap_mm: 1.0, turns, liftable }
}

fn in_the_bin(solids: &[PackSolid], room: &Room, steps: u64) -> Packed {
    let mut asked = |_| None;
    let mut watch = Watch::new(steps, &mut asked);
    pack_models(solids, room, PackGoal::Filling, Method::Auto, true, 1, &mut watch).expect("boats that fit")
}

#[divan::bench(args = CLASSES, sample_count = 5)]
fn bound_of_a_hundred_boxes(bencher: Bencher<'_, '_>, class: i64) {
    let instance = generator::instance(class, 100, 1);
    bencher.bench_local(|| fewest_runs(&instance));
}

#[divan::bench(args = CLASSES, sample_count = 3)]
fn a_million_steps(bencher: Bencher<'_, '_>, class: i64) {
    let instance = generator::instance(class, 100, 1);
    bencher.bench_local(|| {
        let mut asked = |_| None;
        pack(&instance, PackGoal::Runs, Method::Auto, 1, &mut Watch::new(1_000_000, &mut asked))
    });
}

#[divan::bench(sample_count = 3)]
fn a_bin_tested_facet_by_facet(bencher: Bencher<'_, '_>) {
    let (solids, room) = (boats(), bin(Turns::Any, false));
    let done = in_the_bin(&solids, &room, 8_000_000);
    bencher.bench_local(|| apart(&solids, &room, &done.put));
}
