//! What a byte may cost (`docs/explanation/costs.md`): steps are counted, which every computer has alike, and never seconds.

use trunnion::job::{self, CheckedPlan, PlanSource, Silent, Source, VerifyRequest, World};
use trunnion::mesh::{stl_binary, threemf};
use trunnion::verify::Report;

use crate::fuzzed::bodies::program::victims;
use crate::mutants::Victim;
use crate::split::solids::ball;
use crate::support::{Numbers, fails, folder, note, said, seeds, trunnion};

/// Steps of a changed file's replay for each of the clean one's.
const MOST: f64 = 3.0;
/// Findings that are listed.
const LISTED: usize = 1000;

struct Proved {
    plan: CheckedPlan,
    bytes: Vec<u8>,
}

impl Proved {
    fn of(victim: &Victim) -> Self {
        let source = PlanSource { plan: Source::File(victim.plan.clone()), model: None, machine: None };
        let plan = job::load_plan(&source, &World::here(&Silent)).unwrap();
        Self { plan, bytes: std::fs::read(victim.folder.path().join("whole.gcode")).unwrap() }
    }

    fn verify(&self, bytes: Vec<u8>) -> Report {
        let program = Source::Bytes { name: "changed.gcode".to_owned(), bytes };
        job::verify(&VerifyRequest { program: &program, plan: &self.plan }, &World::here(&Silent)).unwrap().report
    }
}

/// A flipped bit, another digit, any other byte.
fn changed(bytes: &[u8], random: &mut Numbers) -> (usize, Vec<u8>) {
    let below = |random: &mut Numbers, count: usize| (random.between(0.0, count as f64) as usize).min(count - 1);
    let at = below(random, bytes.len());
    let mut changed = bytes.to_vec();
    changed[at] = match below(random, 3) {
        0 => bytes[at] ^ 1 << below(random, 7),
        1 if bytes[at].is_ascii_digit() => b"0123456789.-"[below(random, 12)],
        _ => below(random, 256) as u8,
    };
    (at, changed)
}

#[test]
fn no_single_byte_of_a_finished_file_costs_more_than_three_clean_runs() {
    for name in ["two-boxes", "ding", "y-tree"] {
        bytes_are_borne(name, &Proved::of(&Victim::of(name)), seeds(8, 400));
    }
}

/// Files of some kilobytes, so that thousands of changes can be looked at: of a table under Marlin, of a head that turns, of a table under grblHAL.
#[test]
fn no_single_byte_of_a_small_file_costs_more_than_three_clean_runs() {
    for victim in victims() {
        let proved = Proved { plan: victim.plan().clone(), bytes: victim.program().to_vec() };
        let name = proved.plan.machine.name.clone();
        bytes_are_borne(&name, &proved, seeds(40, 3334));
    }
}

fn bytes_are_borne(name: &str, proved: &Proved, seeds: std::ops::Range<u64>) {
    let clean = proved.verify(proved.bytes.clone());
    assert!(clean.is_clean() && clean.steps > 100, "{clean:?}");
    let (mut dearest, mut most, mut with) = ((0.0, String::new()), 0, 0);
    let changes = seeds.clone().count();
    for seed in seeds {
        let (at, bytes) = changed(&proved.bytes, &mut Numbers::seeded(seed));
        let line = String::from_utf8_lossy(&bytes)
            .lines()
            .nth(proved.bytes[..at].iter().filter(|b| **b == b'\n').count())
            .unwrap_or("")
            .to_owned();
        let report = proved.verify(bytes);
        (most, with) = (most.max(report.count()), with + usize::from(!report.is_clean()));
        let cost = report.steps as f64 / clean.steps as f64;
        if cost > dearest.0 {
            dearest = (cost, format!("seed {seed}: {line:?} {:?}", report.counts));
        }
        assert!(report.findings.len() <= LISTED && report.moves <= clean.moves + 10_000, "seed {seed}: {line:?}");
        for (rule, count) in &report.counts {
            let listed = report.findings.iter().filter(|f| f.rule == *rule).count();
            assert!(
                listed == *count || listed == trunnion::verify::KEPT_PER_RULE,
                "seed {seed}: {rule} {count}, {listed} listed"
            );
        }
    }
    note(&format!(
        "{name}: {changes} changes of a byte, {with} with findings, {most} at most; the dearest {:.2} clean runs: {}",
        dearest.0, dearest.1
    ));
    assert!(dearest.0 <= MOST, "{name}: {dearest:?}");
}

/// One word too much turns the table by a degree for the rest of a setup: said once, and not asked further.
#[test]
fn a_stray_word_of_the_table_is_said_once() {
    let victim = Victim::of("y-tree");
    let proved = Proved::of(&victim);
    let clean = proved.verify(proved.bytes.clone());
    let text = String::from_utf8(proved.bytes.clone()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let lays: Vec<usize> =
        (0..lines.len()).filter(|&i| lines[i].starts_with("G1") && lines[i].contains(" E")).collect();
    for (share, word) in [(0.7, " A1"), (0.8, " A0.1"), (0.3, " C3")] {
        let mut changed: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
        changed[lays[(lays.len() as f64 * share) as usize]] += word;
        let report = proved.verify(changed.join("\n").into_bytes());
        let cost = report.steps as f64 / clean.steps as f64;
        note(&format!("y-tree with {word} at {share}: {} findings, {cost:.2} clean runs", report.count()));
        assert!(
            !report.is_clean() && report.count() <= 20 && cost <= 1.0,
            "{word} at {share}: {:?} {cost}",
            report.counts
        );
    }
}

/// What reading takes at the least, as `docs/explanation/costs.md` has it: whole MB.
fn needed_mb(bytes: usize, facets: usize, moves: usize) -> usize {
    (8_000_000 + bytes + 95 * facets + 39 * moves).div_ceil(1_000_000)
}

/// The document of a call that is held to `most` MB.
fn held(folder: &std::path::Path, words: &[&str], most: usize) -> (Option<i32>, serde_json::Value, String) {
    let most = most.to_string();
    let run = trunnion().current_dir(folder).args(words).args(["--json", "--max-memory", &most]).output().unwrap();
    (run.status.code(), serde_json::from_slice(&run.stdout).unwrap_or_default(), said(&run))
}

#[test]
fn what_takes_more_memory_than_it_may_is_refused_before_the_work() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mesh = ball(20.0, 120).mesh();
    let placed: Vec<_> = (0..3).map(|i| (format!("ball {i}"), &mesh)).collect();
    for (name, bytes, facets) in
        [("ball.stl", stl_binary(&mesh), mesh.facets().len()), ("ball.3mf", threemf(&placed), 3 * mesh.facets().len())]
    {
        std::fs::write(at(name), &bytes).unwrap();
        let needs = needed_mb(bytes.len(), facets, 0);
        // Its size alone would do.
        assert!(needed_mb(bytes.len(), 0, 0) < needs - 1, "{name}: {facets} facets need {needs} MB");
        for words in [
            &["inspect"][..],
            &["orient"],
            &["plan", "-m", "generic-ac"],
            &["prepare", "-m", "generic-ac", "-o", "out.gcode"],
            &["preview", "-m", "generic-ac", "-o", "out.html"],
            &["support", "-o", "out.stl"],
            &["split", "-m", "generic-ac", "-o", "out.3mf"],
            &["pack", "--space", "200,200,200", "-o", "out"],
        ] {
            let words = [&words[..1], &[name], &words[1..]].concat();
            let (code, document, said) = held(folder.path(), &words, needs - 1);
            assert_eq!((code, document["code"].as_str()), (Some(2), Some("input/memory")), "{words:?}: {said}");
            assert!(
                fails(&said, &format!("input/memory: {name} | {needs} MB | {} MB", needs - 1)),
                "{words:?}: {said}"
            );
        }
        let (code, document, said) = held(folder.path(), &["inspect", name], needs);
        let count: u64 =
            document["parts"].as_array().unwrap().iter().map(|part| part["facets"].as_u64().unwrap()).sum();
        assert_eq!((code, count), (Some(0), facets as u64), "{name}: {said}");
    }
    for name in ["out.gcode", "out.html", "out.stl", "out.3mf"] {
        assert!(!at(name).exists(), "{name} is there");
    }
    assert_eq!(std::fs::read_dir(at("out")).unwrap().count(), 0, "plates are there");
}

#[test]
fn a_program_that_takes_more_memory_than_it_may_is_not_followed() {
    let victim = Victim::of("two-boxes");
    let folder = victim.folder.path();
    let whole = std::fs::read_to_string(folder.join("whole.gcode")).unwrap();
    let own = whole.lines().filter(|line| line.starts_with("G1 ") || line.starts_with("G0 ")).count();
    let long = whole.clone() + &"G1 X1 Y1\n".repeat(100_000);
    std::fs::write(folder.join("long.gcode"), &long).unwrap();
    let needs = needed_mb(long.len(), 0, own + 100_000);
    assert!(needed_mb(long.len(), 0, 0) < needs - 1, "{needs}");
    let plan = victim.plan.to_str().unwrap();
    for words in [
        &["verify", "long.gcode", "--plan", plan][..],
        &["verify", "long.gcode", "-m", "generic-ac"],
        &["preview", "long.gcode", "--plan", plan, "-o", "out.html"],
        &["rewrite", "long.gcode", "--plan", plan, "-o", "out.gcode"],
        &["send", "long.gcode", "--plan", plan, "--dry-run"],
        &["send", "long.gcode", "--unverified", "-m", "generic-ac", "--dry-run"],
        &["publish", "long.gcode", "--plan", plan, "--to", "octoprint:http://127.0.0.1:9"],
        &["publish", "long.gcode", "--unverified", "--to", "octoprint:http://127.0.0.1:9"],
    ] {
        let (code, document, said) = held(folder, words, needs - 1);
        assert_eq!((code, document["code"].as_str()), (Some(2), Some("input/memory")), "{words:?}: {said}");
    }
    assert!(!folder.join("out.html").exists() && !folder.join("out.gcode").exists());
    let (code, _, said) = held(folder, &["verify", "whole.gcode", "--plan", plan], needs);
    assert_eq!(code, Some(0), "{said}");
}
