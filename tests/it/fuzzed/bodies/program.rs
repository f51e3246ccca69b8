//! Bytes as a finished program of which a plan is known: what verifying, judging without the plan, showing, sending and a dry run make of it.

use std::path::Path;
use std::sync::OnceLock;

use trunnion::job::{
    CheckedPlan, MachineSource, RefereeRequest, SendOptions, SendRequest, Source, Verified, VerifyRequest, dry_run,
    referee, rehearse, show, verify,
};
use trunnion::verify::{KEPT_PER_RULE, Report};

use super::choice;
use super::rewrite::Made;
use super::shelf::Shelf;

/// Steps of a replay, as many clean ones, and as many again for each time that the bytes are longer: a dozen words and blocks are changed, and each
/// alone costs three at most (docs/explanation/costs.md).
const MOST_CLEAN_RUNS: f64 = 36.0;

/// A program that is found without fault, and the steps of its replay.
pub(crate) struct Victim {
    made: Made,
    steps: u64,
}

/// A table of two axes that Marlin turns, a head that turns, and a table under grblHAL.
pub(crate) fn victims() -> &'static [Victim] {
    static ALL: OnceLock<Vec<Victim>> = OnceLock::new();
    let victim = |machine: &str| {
        let made = Made::on(machine);
        let report = replayed(&made, &made.program).0;
        assert!(report.is_clean() && report.steps > 100, "{machine}: {:?}", report.counts);
        Victim { made, steps: report.steps }
    };
    ALL.get_or_init(|| ["generic-ac", "generic-hh", "grblhal-ac"].map(victim).into())
}

impl Victim {
    pub(crate) fn program(&self) -> &[u8] {
        &self.made.program
    }

    pub(crate) fn plan(&self) -> &CheckedPlan {
        &self.made.plan
    }
}

/// What is said of the bytes by the plan; the program where that is nothing.
fn replayed(made: &Made, bytes: &[u8]) -> (Report, Option<Verified<Vec<u8>>>) {
    let program = Source::Bytes { name: "any.gcode".to_owned(), bytes: bytes.to_vec() };
    let shelf = Shelf::empty();
    let request = VerifyRequest { program: &program, plan: &made.plan };
    let done = verify(&request, &shelf.world()).expect("bytes in hand are read");
    (done.report.clone(), done.verified().ok())
}

/// The first byte chooses the victim in whose place the bytes are.
pub(super) fn program(data: &[u8]) {
    let Some((how, bytes)) = choice(data) else { return };
    let victim = &victims()[usize::from(how) % victims().len()];
    let made = &victim.made;
    let (report, verified) = replayed(made, bytes);
    listed(&report);
    let longer = (bytes.len() as f64 / made.program.len() as f64).max(1.0);
    let runs = report.steps as f64 / victim.steps as f64 / longer;
    assert!(runs <= MOST_CLEAN_RUNS, "{runs:.1} clean runs: {:?}", report.counts);
    let shelf = Shelf::empty();
    let world = shelf.world();
    match show("any.gcode", bytes, &made.plan, &report, &world) {
        Ok(shown) => assert!(shown.rooms.iter().all(|room| room.mm.is_finite()), "a room that is no number"),
        Err(error) => assert!(verified.is_none() && !error.to_string().is_empty(), "verified, and not shown: {error}"),
    }
    let source = Source::Bytes { name: "any.gcode".to_owned(), bytes: bytes.to_vec() };
    let machine = MachineSource::from(made.plan.machine.profile.clone());
    match referee(&RefereeRequest { program: &source, machine: &machine }, &world) {
        Ok(done) => {
            listed(&done.refereed.report);
            let found = &done.refereed.report;
            assert!(verified.is_none() || found.is_clean(), "verified, and judged otherwise: {:?}", found.counts);
        }
        Err(error) => assert!(verified.is_none(), "verified, and not judged: {error}"),
    }
    sent(made, bytes, verified);
}

/// As many findings as are told, and numbers that are some.
fn listed(report: &Report) {
    let figures = [report.clearance_mm, report.filament_mm, report.seconds_print];
    assert!(figures.iter().all(|v| v.is_finite()), "{figures:?}");
    for (rule, count) in &report.counts {
        let listed = report.findings.iter().filter(|finding| finding.rule == *rule).count();
        assert!(listed == *count || (listed == KEPT_PER_RULE && listed < *count), "{rule}: {listed} of {count}");
    }
}

/// Verified or at somebody's own risk: through the simulated printer to the end, or refused with a reason.
fn sent(made: &Made, bytes: &[u8], verified: Option<Verified<Vec<u8>>>) {
    let proved = verified.is_some();
    let program = verified.unwrap_or_else(|| Verified::unverified(bytes.to_vec()));
    let (options, shelf) = (SendOptions::default(), Shelf::empty());
    let machine = &made.plan.machine;
    let request = SendRequest {
        path: Path::new("any.gcode"),
        program: &program,
        machine,
        plan: Some(&made.plan),
        options: &options,
    };
    match rehearse(&request, &shelf.world()) {
        Ok(done) => {
            assert!(done.seconds.is_finite() && done.seconds_print.is_finite(), "{done:?}");
            assert!(
                !proved || (done.clamped == 0 && done.troubles.is_empty()),
                "verified, and printed otherwise: {done:?}"
            );
        }
        Err(error) => assert!(!proved && !error.to_string().is_empty(), "verified, and not printed: {error}"),
    }
    match dry_run(bytes, &made.plan) {
        Ok(done) => assert!(!done.gcode.is_empty(), "a dry run without lines"),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
