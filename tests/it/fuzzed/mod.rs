//! A short turn of each fuzz target (`fuzz/`, docs/explanation/fuzzing.md) with changes that are the same on every machine: nothing panics, overflows or
//! hangs, and what the targets promise holds.

pub(crate) mod bodies;
mod findings;
mod mutate;
mod seeds;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use self::bodies::{BODIES, run};
use self::mutate::{Mutator, words};
use self::seeds::seeds;
use crate::support::{PATIENCE, folder, note, processor_s, seeds as seeds_of_sweep};

/// What uses more of a processor hangs, s. The fuzzer, whose build is faster, allows 10.
const LONGEST_S: f64 = 60.0;

/// In a soak there are so many times as many changes, all others.
const SOAK: u64 = 50;

/// Keeps what failed where the fuzzer can repeat it, and says how.
fn kept(target: &str, data: &[u8], what: &str) -> String {
    let path = std::env::temp_dir().join(format!("trunnion-fuzz-{target}-{}", std::process::id()));
    let kept = std::fs::write(&path, data).map_or_else(|error| error.to_string(), |()| path.display().to_string());
    let shown = String::from_utf8_lossy(&data[..data.len().min(400)]).into_owned();
    format!(
        "{target}: {what}; {} bytes, kept in {kept}: cargo +nightly fuzz run -s none {target} {kept}\n{shown:?}",
        data.len()
    )
}

/// Why `body` does not bear `data`; `None` where it does.
fn failure(body: impl FnOnce(&[u8]), data: &[u8]) -> Option<String> {
    let error = catch_unwind(AssertUnwindSafe(|| body(data))).err()?;
    let text = error.downcast_ref::<String>().cloned();
    Some(text.or_else(|| error.downcast_ref::<&str>().map(|&text| text.to_owned())).unwrap_or_default())
}

/// Gives `inputs` to the target, one after the other.
fn bears(target: &'static str, inputs: impl Iterator<Item = Vec<u8>>) -> u64 {
    let (to_do, work) = channel::<Vec<u8>>();
    let (done, results) = channel();
    std::thread::spawn(move || {
        for data in work {
            if done.send(failure(|data| run(target, data), &data)).is_err() {
                return;
            }
        }
    });
    let mut count = 0;
    for data in inputs {
        to_do.send(data.clone()).unwrap();
        let (begun, used) = (Instant::now(), own_processor_s());
        let ended = loop {
            match results.recv_timeout(Duration::from_secs(1)) {
                Ok(result) => break Ok(result),
                Err(_) if own_processor_s() - used < LONGEST_S && begun.elapsed() < PATIENCE => {}
                Err(_) => break Err(()),
            }
        };
        match ended {
            Ok(None) => count += 1,
            Ok(Some(why)) => panic!("{}", kept(target, &data, &why)),
            Err(()) => panic!("{}", kept(target, &data, &format!("no end after {LONGEST_S} s"))),
        }
    }
    count
}

/// What this process has used of a processor, s.
fn own_processor_s() -> f64 {
    processor_s(std::process::id()).unwrap_or(0.0)
}

/// The seeds, what was found once, and so many changes of both.
fn survives(target: &'static str, most: u64) {
    let begun = Instant::now();
    let found: Vec<Vec<u8>> = findings::of(target).collect();
    let all = [seeds(target), found].concat();
    let longest = all.iter().map(Vec::len).max().unwrap_or(0) * 2;
    bears(target, all.iter().cloned());
    let words = words();
    let mutator = Mutator { seeds: &all, words: &words, longest };
    let count = bears(target, seeds_of_sweep(most, most * SOAK).map(|seed| mutator.bytes(seed)));
    note(&format!("{target}: {} seeds and {count} changes in {:.1} s", all.len(), begun.elapsed().as_secs_f64()));
}

#[test]
fn any_configuration_of_a_slicer_and_any_touches_are_read_or_refused() {
    survives("config", 1500);
}

#[test]
fn any_program_is_read_or_refused() {
    survives("gcode", 10_000);
}

#[test]
fn any_journal_is_read_or_refused() {
    survives("journal", 10_000);
}

#[test]
fn any_model_is_read_or_refused() {
    // An archive of thousands of bodies takes a second, and is no rarer than others: 50,000 took a quarter of an hour.
    survives("mesh", 400);
}

#[test]
fn any_plan_is_read_or_refused() {
    survives("plan", 10_000);
}

#[test]
fn any_profile_and_any_configuration_of_a_firmware_are_read_or_refused() {
    survives("profile", 1500);
}

#[test]
fn any_answers_are_borne() {
    survives("reply", 15_000);
}

#[test]
fn any_finished_program_is_judged_shown_and_sent_or_refused() {
    survives("program", 50);
}

#[test]
fn any_slice_is_rewritten_into_what_can_be_read_or_is_refused() {
    survives("rewrite", 100);
}

/// `TRUNNION_CORPUS=fuzz/corpus` lays the seeds out for the fuzzer.
#[test]
fn every_target_has_seeds_that_differ() {
    let own = folder();
    let to = std::env::var_os("TRUNNION_CORPUS").map_or_else(|| own.path().to_owned(), PathBuf::from);
    for (target, _) in BODIES {
        let all = [seeds(target), findings::of(target).collect()].concat();
        let different: std::collections::BTreeSet<&Vec<u8>> = all.iter().collect();
        assert!(different.len() >= 3 && different.len() == all.len(), "{target}: {} of {}", different.len(), all.len());
        std::fs::create_dir_all(to.join(target)).unwrap();
        for (number, seed) in all.iter().enumerate() {
            std::fs::write(to.join(target).join(format!("seed-{number:02}")), seed).unwrap();
        }
    }
}

#[test]
fn what_fails_is_told_and_kept() {
    let body = |data: &[u8]| assert!(!data.contains(&b'Z'), "a Z in {}", data.len());
    assert_eq!(failure(body, b"XY"), None);
    let why = failure(body, b"XYZ").unwrap();
    let text = kept("self-test", b"XYZ", &why);
    assert!(why == "a Z in 3" && text.contains("a Z in 3") && text.contains("\"XYZ\""), "{text}");
    let path = std::env::temp_dir().join(format!("trunnion-fuzz-self-test-{}", std::process::id()));
    assert_eq!(std::fs::read(&path).unwrap(), b"XYZ");
    std::fs::remove_file(path).unwrap();
}
