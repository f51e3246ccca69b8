//! Bytes as one print's slice among good ones: refused, or a program that the replay reads to its end.

use std::sync::OnceLock;

use trunnion::gcode::marks::finished_by;
use trunnion::job::{
    self, CheckedPlan, PlanRequest, PrintError, Prints, RewriteRequest, SliceRequest, SlicingOptions, Source,
    VerifyRequest,
};
use trunnion::slicing::SlicerChoice;
use trunnion::trace::{What, read};
use trunnion::verify::Report;

use super::choice;
use super::gcode::finite;
use super::shelf::Shelf;

/// A model's plan, a slice of each of its prints, and the program.
pub(crate) struct Made {
    pub(super) plan: CheckedPlan,
    options: SlicingOptions,
    /// By print.
    pub(crate) slices: Vec<Vec<u8>>,
    /// Of all of them.
    pub(crate) program: Vec<u8>,
}

/// For the generic machine.
pub(crate) fn made() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| Made::on("generic-ac"))
}

/// The shipped fixture at a tenth of its size: slices of some kilobytes.
fn small() -> Vec<u8> {
    let mut bytes = include_bytes!("../../../../fixtures/y-tree.stl").to_vec();
    for facet in bytes[84..].chunks_exact_mut(50) {
        for number in facet[12..48].chunks_exact_mut(4) {
            let value = f32::from_le_bytes([number[0], number[1], number[2], number[3]]);
            number.copy_from_slice(&(value * 0.1).to_le_bytes());
        }
    }
    bytes
}

impl Made {
    /// A small tree of three parts, two of them printed at a tilt.
    pub(super) fn on(machine: &str) -> Self {
        let shelf = Shelf::empty();
        let world = shelf.world();
        let model = Source::Bytes { name: "y-tree.stl".to_owned(), bytes: small() };
        let mut request = PlanRequest::new(model, machine);
        request.options.overhang_deg = Some(40.0);
        let plan = job::plan(&request, &world).expect("a plan").plan;
        let options = SlicingOptions { slicer: SlicerChoice::BuiltIn, ..SlicingOptions::default() };
        let prints = Prints::of(&plan, options.bed);
        let request = SliceRequest { plan: &plan, prints: &prints, options: &options };
        let slices = job::slice(&request, &world).expect("slices").sliced;
        let mut made = Self { plan, options, slices, program: Vec::new() };
        made.program = made.rewritten(None).expect("a program");
        made
    }

    /// The program with these bytes in the place of the slice of one print.
    fn rewritten(&self, other: Option<(usize, &[u8])>) -> Result<Vec<u8>, PrintError> {
        let bytes = |print: usize| match other {
            Some((replaced, bytes)) if replaced == print => bytes.to_vec(),
            _ => self.slices[print].clone(),
        };
        let file = |print: usize| Source::Bytes { name: format!("print-{print:02}.gcode"), bytes: bytes(print) };
        let sliced = (0..self.slices.len()).map(file).collect();
        let request = RewriteRequest { plan: &self.plan, sliced, print: None, bed: self.options.bed };
        let shelf = Shelf::empty();
        Ok(job::rewrite(&request, &shelf.world())?.gcode.program().clone())
    }
}

/// The first byte chooses the print, or, from 192 on, that the bytes are a finished program to be verified.
pub(super) fn rewrite(data: &[u8]) {
    let Some((how, bytes)) = choice(data) else { return };
    let made = made();
    if how >= 192 {
        let shelf = Shelf::empty();
        let program = Source::Bytes { name: "any.gcode".to_owned(), bytes: bytes.to_vec() };
        let request = VerifyRequest { program: &program, plan: &made.plan };
        return sound(&job::verify(&request, &shelf.world()).expect("bytes in hand are read").report);
    }
    let program = match made.rewritten(Some((usize::from(how) % made.slices.len(), bytes))) {
        Ok(program) => program,
        Err(PrintError::Rejected(rejected)) => return sound(&rejected.report),
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    assert_eq!(finished_by(&program), Some(made.plan.sha256.clone()), "a finished program says so");
    let trace = read(&program, &made.plan.machine.profile.trace_setting());
    finite(&trace);
    let unread = trace.events.iter().find(|event| matches!(event.what, What::Refused(_) | What::BrokenMark(_)));
    assert!(unread.is_none(), "passed, and cannot be read: {unread:?}");
    assert!(trace.moves().filter(|m| m.prints()).all(|m| m.ends().is_some()), "it lays lines at unknown places");
}

/// A report in numbers.
fn sound(report: &Report) {
    let figures = [report.clearance_mm, report.filament_mm, report.seconds_print];
    assert!(figures.iter().all(|v| v.is_finite()), "{figures:?}");
}
