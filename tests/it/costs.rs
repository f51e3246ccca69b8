//! What a byte may cost (`docs/explanation/costs.md`): steps are counted, which every computer has alike, and never seconds.

use trunnion::job::{self, CheckedPlan, PlanSource, Silent, Source, VerifyRequest, World};
use trunnion::verify::Report;

use crate::mutants::Victim;
use crate::support::{Numbers, note, seeds};

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
        let victim = Victim::of(name);
        let proved = Proved::of(&victim);
        let clean = proved.verify(proved.bytes.clone());
        assert!(clean.is_clean() && clean.steps > 1000, "{clean:?}");
        let (mut dearest, mut most, mut with, mut count) = ((0.0, String::new()), 0, 0, 0);
        for seed in seeds(8, 400) {
            let (at, bytes) = changed(&proved.bytes, &mut Numbers::seeded(seed));
            let line = String::from_utf8_lossy(&bytes)
                .lines()
                .nth(proved.bytes[..at].iter().filter(|b| **b == b'\n').count())
                .unwrap_or("")
                .to_owned();
            let report = proved.verify(bytes);
            (most, with, count) = (most.max(report.count()), with + usize::from(!report.is_clean()), count + 1);
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
            "{name}: {count} changes of a byte, {with} with findings, {most} at most; the dearest {:.2} clean runs: {}",
            dearest.0, dearest.1
        ));
        assert!(dearest.0 <= MOST, "{name}: {dearest:?}");
    }
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
