//! A demanded order of prints: planned, prepared and verified in it, or refused with the reasons.

use serde_json::{Value, json};

use crate::pipeline::fixture;
use crate::support::{folder, trunnion};

/// Exit code and document of the verb on a fixture.
fn run(verb: &str, model: &str, words: &[&str]) -> (Option<i32>, Value) {
    let here = folder();
    let output: &[&str] = if verb == "prepare" { &["-o", "out.gcode"] } else { &[] };
    let done = trunnion()
        .arg(verb)
        .arg(fixture(model))
        .args(["-m", "generic-ac", "--json"])
        .args(output)
        .args(words)
        .current_dir(here.path())
        .output()
        .unwrap();
    (done.status.code(), serde_json::from_slice(&done.stdout).unwrap())
}

/// The parts of each slot.
fn slots(plan: &Value) -> Vec<Vec<u64>> {
    let parts = |slot: &Value| {
        let mut parts: Vec<u64> =
            slot["prints"].as_array().unwrap().iter().map(|print| print["part"].as_u64().unwrap()).collect();
        parts.sort_unstable();
        parts
    };
    plan["slots"].as_array().unwrap().iter().map(parts).collect()
}

#[test]
fn each_step_is_in_later_slots_than_the_one_before() {
    for (words, wanted) in [
        (&[][..], vec![vec![0], vec![1, 2]]),
        (&["--order", "0,2,1"], vec![vec![0], vec![2], vec![1]]),
        (&["--order", "0,1+2"], vec![vec![0], vec![1, 2]]),
        (&["--order", "2,1"], vec![vec![0], vec![2], vec![1]]),
        (&["--order", "1,2", "--slots", "only-single"], vec![vec![0], vec![1], vec![2]]),
    ] {
        let (code, plan) = run("plan", "y-tree", words);
        assert_eq!((code, slots(&plan)), (Some(0), wanted), "{words:?}");
    }
    // What is listed is all that has the order.
    let (_, listed) = run("plan", "y-tree", &["--all", "--order", "2,1"]);
    let listed = listed["sequences"].as_array().unwrap();
    let in_order = |slots: &Value| {
        let at = |part: u64| {
            slots
                .as_array()
                .unwrap()
                .iter()
                .position(|slot| slot["prints"].as_array().unwrap().iter().any(|print| print["part"] == part))
        };
        at(2) < at(1)
    };
    assert!(!listed.is_empty() && listed.iter().all(in_order), "{} sequences", listed.len());
}

#[test]
fn what_cannot_be_printed_in_the_order_is_refused_with_the_reasons() {
    let (code, no) = run("plan", "y-tree", &["--order", "1,0"]);
    assert_eq!(
        (code, &no["code"], &no["reasons"][0]["part"], &no["reasons"][0]["blocked_by"]),
        (Some(1), &"plan/no-plan".into(), &1.into(), &"support".into()),
        "{no}"
    );
    let (code, no) = run("prepare", "y-tree", &["--order", "2,0", "--slicer", "builtin"]);
    assert_eq!((code, &no["code"], &no["reasons"][0]["part"]), (Some(1), &"plan/no-plan".into(), &2.into()), "{no}");
    for (words, wanted) in [
        (&["--order", "0,3"][..], "setting/no-such-part"),
        (&["--order", "0,0"], "setting/words"),
        (&["--order", "0,,1"], "setting/words"),
        (&["--order", "first"], "setting/words"),
    ] {
        let (code, no) = run("plan", "y-tree", words);
        assert_eq!((code, &no["code"]), (Some(2), &wanted.into()), "{words:?}");
    }
    // One solid has parts only where it is cut: nobody asked for that way by its name.
    for (words, named) in [(&[][..], false), (&["--way", "cut"], true)] {
        let (code, no) = run("prepare", "hook", &[&["--order", "1,0", "--slicer", "builtin"], words].concat());
        assert_eq!((code, &no["code"]), (Some(1), &"strategy/no-way".into()), "{no}");
        assert_eq!(no["error"].as_str().unwrap().starts_with("--way cut"), named, "{no}");
    }
    let (code, no) = run("prepare", "hook", &["--order", "0", "--way", "supports"]);
    assert_eq!((code, &no["code"]), (Some(2), &"command/usage".into()));
}

#[test]
fn a_file_in_another_order_is_verified_and_has_the_same_size() {
    let prepared = |words: &[&str]| {
        let (code, document) = run("prepare", "y-tree", &[&["--slicer", "builtin"], words].concat());
        assert_eq!((code, &document["verify"]["findings"]), (Some(0), &json!([])), "{document}");
        document
    };
    let (free, ordered) = (prepared(&[]), prepared(&["--order", "0,2,1"]));
    assert_eq!(slots(&ordered["plan"]), [[0], [2], [1]]);
    let filament = |document: &Value| document["verify"]["filament_mm"].as_f64().unwrap();
    assert!((filament(&free) - filament(&ordered)).abs() < 0.02 * filament(&free));
    // The estimate of each part is of the whole.
    let seconds: f64 =
        ordered["plan"]["part_seconds"].as_array().unwrap().iter().map(|part| part.as_f64().unwrap()).sum();
    let whole = ordered["plan"]["seconds_print_estimate"].as_f64().unwrap();
    assert!(seconds > 0.5 * whole && seconds <= whole, "{seconds} of {whole}");
}
