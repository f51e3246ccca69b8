//! A program replayed against its plan, and the type that only such a replay gives: [`Verified`].

use super::error::{PrintError, Rejected};
use crate::gcode::marks::made_by;
use crate::input::{CheckedPlan, MachineSource, Source, load_profile};
use crate::trace::{self, Trace};
use crate::verify::{Refereed, ReplayJob, Report, verify_trace};
use crate::world::World;

/// A finished program and the plan it was made by.
#[derive(Clone, Copy, Debug)]
pub struct VerifyRequest<'a> {
    /// The program, G-code for the machine.
    pub program: &'a Source,
    /// Its plan.
    pub plan: &'a CheckedPlan,
}

/// What the replay says.
#[derive(Clone, Debug)]
pub struct VerifyResult {
    /// Findings and figures.
    pub report: Report,
    /// What the replay took.
    pub seconds: f64,
    program: Vec<u8>,
    /// The hash of the plan that the program was replayed by.
    plan: String,
}

impl VerifyResult {
    /// [`PrintError::MadeByAnother`] where there are findings, and the program names another plan than `plan` at its head: they may all be of the
    /// wrong part. A name is no proof, so that a program without findings is verified whatever it says.
    pub fn of_another(&self, file: &str, plan: &CheckedPlan) -> Option<PrintError> {
        let made_by = made_by(&self.program).filter(|by| *by != plan.sha256 && !self.report.is_clean())?;
        Some(PrintError::MadeByAnother { file: file.to_owned(), made_by, given: plan.sha256.clone() })
    }

    /// The program, if nothing was found wrong with it.
    ///
    /// # Errors
    ///
    /// [`PrintError::Rejected`] with the report.
    pub fn verified(self) -> Result<Verified<Vec<u8>>, PrintError> {
        let Self { report, seconds, program, plan } = self;
        if report.is_clean() {
            Ok(Verified { program, proof: Some(Proof { report, plan }) })
        } else {
            Err(PrintError::Rejected(Box::new(Rejected { report, seconds, program, plan: None, ways: Vec::new() })))
        }
    }
}

/// Replays a finished program on its machine's model. Findings are no error here; [`VerifyResult::verified`] makes them one.
///
/// # Errors
///
/// What keeps the program from being read.
pub fn verify(request: &VerifyRequest<'_>, world: &World<'_>) -> Result<VerifyResult, PrintError> {
    let program = request.program.program(world)?.into_owned();
    Ok(replayed(program, request.plan, world))
}

/// A finished program without its plan, and its machine.
#[derive(Clone, Copy, Debug)]
pub struct RefereeRequest<'a> {
    /// The program, G-code for the machine.
    pub program: &'a Source,
    /// The machine.
    pub machine: &'a MachineSource,
}

/// What a program does on its machine, by the rules that need no plan.
#[derive(Clone, Debug)]
pub struct RefereeResult {
    /// Findings, figures, and the rules that are not judged.
    pub refereed: Refereed,
    /// What the replay took.
    pub seconds: f64,
}

/// Replays a program of any origin on its machine's model. It proves less than [`verify`], so that no [`Verified`] comes of it.
///
/// # Errors
///
/// What keeps program or machine from being read; [`PrintError::Unjudged`] for a program of which no rule says anything.
pub fn referee(request: &RefereeRequest<'_>, world: &World<'_>) -> Result<RefereeResult, PrintError> {
    let machine = load_profile(request.machine, world)?;
    let program = request.program.program(world)?;
    let start = world.clock.now();
    let file = || request.program.name().into_owned();
    let refereed =
        crate::verify::referee(&program, &machine.profile).map_err(|why| PrintError::Unjudged { file: file(), why })?;
    Ok(RefereeResult { refereed, seconds: (world.clock.now() - start).as_secs_f64() })
}

/// The replay of bytes in hand.
pub(super) fn replayed(program: Vec<u8>, plan: &CheckedPlan, world: &World<'_>) -> VerifyResult {
    let start = world.clock.now();
    let trace = trace::read(&program, &plan.machine.profile.trace_setting());
    let result = replayed_as(program, &trace, plan, world);
    let seconds = (world.clock.now() - start).as_secs_f64();
    VerifyResult { seconds, ..result }
}

/// The same of bytes that have been read: `trace` must be theirs.
pub(super) fn replayed_as(program: Vec<u8>, trace: &Trace, plan: &CheckedPlan, world: &World<'_>) -> VerifyResult {
    let start = world.clock.now();
    let workpiece = plan.workpiece();
    let job = ReplayJob { profile: &plan.machine.profile, plan: &plan.plan, workpiece: &workpiece };
    let report = verify_trace(&program, trace, &job);
    let seconds = (world.clock.now() - start).as_secs_f64();
    VerifyResult { report, seconds, program, plan: plan.sha256.clone() }
}

/// A program for a machine of which a replay has proved that nothing is wrong with it.
///
/// Only a replay without findings makes one, or somebody who says in words that there was none: [`Verified::unverified`].
#[derive(Clone, Debug)]
pub struct Verified<P> {
    program: P,
    proof: Option<Proof>,
}

/// A replay without findings.
#[derive(Clone, Debug)]
struct Proof {
    report: Report,
    plan: String,
}

impl<P> Verified<P> {
    /// A program that nothing was proved of, sent at the caller's own risk: nothing is known of what the head will hit.
    pub fn unverified(program: P) -> Self {
        Self { program, proof: None }
    }

    /// The program.
    pub fn program(&self) -> &P {
        &self.program
    }

    /// What the replay said; `None` where there was none.
    pub fn report(&self) -> Option<&Report> {
        self.proof.as_ref().map(|proof| &proof.report)
    }

    /// What the replay by `plan` said; `None` where it was by another plan, and where there was none.
    pub fn report_by(&self, plan: &CheckedPlan) -> Option<&Report> {
        self.proof.as_ref().filter(|proof| proof.plan == plan.sha256).map(|proof| &proof.report)
    }
}
