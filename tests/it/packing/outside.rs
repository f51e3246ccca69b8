//! OR-tools' CP-SAT as a witness: least numbers of runs and most values of random boxes.

use std::process::{Command, Stdio};

use serde_json::{Value, json};
use trunnion::geom::SplitMix64;
use trunnion::pack::{Ended, Instance, Item, Method, PackGoal, Turns, fewest_runs, most_value};

use super::boxes::packed;
use crate::support::{folder, python, root, skip};

fn instance(seed: u64) -> Instance {
    let mut numbers = SplitMix64::seeded(seed);
    let mut length = || 3 + numbers.below(12) as i64;
    let items = (0..9).map(|_| {
        let size = [length(), length(), length()];
        Item { size, value: (size.iter().product::<i64>() % 97 + 1) as f64, up: [true; 3] }
    });
    let items = items.collect();
    Instance { space: [20, 20, 20], gap: 0, turns: Turns::None, items }
}

#[test]
fn or_tools_finds_the_same() {
    let Some(python) = python(&["python3", "/usr/bin/python3"], "ortools.sat.python.cp_model") else {
        return skip("no python3 with ortools: packings of boxes have no witness but brute force");
    };
    let folder = folder();
    let mut proved = 0;
    for seed in 1..=8 {
        let instance = instance(seed);
        for goal in [PackGoal::Runs, PackGoal::Filling] {
            let ours = packed(&instance, goal, Method::Auto, 3_000_000);
            let boxes: Vec<Value> =
                instance.items.iter().map(|i| json!([i.size[0], i.size[1], i.size[2], i.value as i64])).collect();
            let name = if goal == PackGoal::Runs { "runs" } else { "filling" };
            let asked = json!({"space": instance.space, "boxes": boxes, "goal": name, "most_runs": ours.runs.max(1)});
            let file = folder.path().join("boxes.json");
            std::fs::write(&file, asked.to_string()).unwrap();
            let script = root().join("benches/compare/pack_ortools.py");
            let output =
                Command::new(&python).arg(script).arg(&file).arg("20").stderr(Stdio::inherit()).output().unwrap();
            assert!(output.status.success());
            let theirs: Value = serde_json::from_slice(&output.stdout).unwrap();
            let best = theirs["best"].as_f64().unwrap();
            let own = if goal == PackGoal::Runs { ours.runs as f64 } else { instance.value(&ours.placed) };
            if theirs["proved"] == true {
                proved += 1;
                assert_eq!(own, best, "{seed} {name}");
                let bound = if goal == PackGoal::Runs { fewest_runs(&instance) as f64 } else { most_value(&instance) };
                assert!(
                    if goal == PackGoal::Runs { bound <= best } else { bound >= best * (1.0 - 1e-9) },
                    "{seed}: {bound}"
                );
            }
            assert!(ours.ended != Ended::Proved || own == best || theirs["proved"] == false, "{seed}");
        }
    }
    assert!(proved >= 12, "only {proved} of 16 were proved by OR-tools");
}
