//! The rewriter as a library's user calls it: into a sink, which may fail, on any number of threads.

use std::io::{Error, Write};

use trunnion::job::{self, CheckedPlan, PlanSource, PrepareRequest, Prints, Silent, SliceRequest, Source, World};
use trunnion::slicing::SlicerChoice;
use trunnion::toolpath::{Input, InputWords, RewriteError, RewriteJob, Rewritten, read_sliced, rewrite};

use crate::support::root;

/// The plan of two boxes, and its prints on the middle of a bed as the built-in slicer makes them.
struct Made {
    plan: CheckedPlan,
    centre_mm: [f64; 2],
    sliced: Vec<Vec<u8>>,
}

impl Made {
    fn new() -> Self {
        let world = World::here(&Silent);
        let path = root().join("fixtures/two-boxes.stl");
        let model = Source::Bytes { name: "two-boxes.stl".to_owned(), bytes: std::fs::read(path).unwrap() };
        let mut whole = PrepareRequest::new(model.clone(), "generic-ac");
        whole.slicing.slicer = SlicerChoice::BuiltIn;
        let text = job::prepare(&whole, &world).unwrap().planned.plan.plan.to_text().into_bytes();
        let file = Source::Bytes { name: "plan.json".to_owned(), bytes: text };
        let plan = job::load_plan(&PlanSource { plan: file, model: Some(model), machine: None }, &world).unwrap();
        let prints = Prints::of(&plan, whole.slicing.bed);
        let request = SliceRequest { plan: &plan, prints: &prints, options: &whole.slicing };
        let sliced = job::slice(&request, &world).unwrap().sliced;
        let centre_mm = whole.slicing.bed.middle_mm();
        Self { plan, centre_mm, sliced }
    }

    fn rewritten(&self, sink: &mut (dyn Write + Send)) -> Result<Rewritten, RewriteError> {
        let read = |bytes| read_sliced(bytes, "box.gcode", InputWords::default()).unwrap().remove(0).sliced;
        let all: Vec<_> = self.sliced.iter().map(|bytes| read(bytes)).collect();
        let centre_mm = self.centre_mm;
        let inputs =
            all.iter().enumerate().map(|(print, sliced)| Input { print, centre_mm, file: "box.gcode", sliced });
        let inputs: Vec<Input<'_>> = inputs.collect();
        let (plan, profile, workpiece) = (&self.plan.plan, &self.plan.machine.profile, &self.plan.workpiece());
        rewrite(&inputs, &RewriteJob { plan, plan_sha256: "", profile, workpiece, head: "" }, sink)
    }
}

/// Takes so many bytes and no more.
struct Disk {
    room: usize,
    taken: Vec<u8>,
    largest: usize,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.largest = self.largest.max(bytes.len());
        let taken = bytes.len().min(self.room - self.taken.len());
        if taken == 0 && !bytes.is_empty() {
            return Err(Error::other("the disk is full"));
        }
        self.taken.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn the_same_bytes_come_out_on_any_number_of_threads_in_pieces() {
    let made = Made::new();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut disk = Disk { room: usize::MAX, taken: Vec::new(), largest: 0 };
        let said = pool.install(|| made.rewritten(&mut disk)).unwrap();
        assert_eq!(said.bytes, disk.taken.len() as u64);
        disk
    };
    let (one, two) = (on(1), on(2));
    assert!(one.taken == two.taken && one.taken.len() > 100_000, "{}", one.taken.len());
    assert!(one.largest < one.taken.len() && one.largest < 1 << 19, "{} bytes at once", one.largest);
}

#[test]
fn a_sink_that_takes_no_more_ends_the_rewriting_with_its_own_words() {
    let made = Made::new();
    let mut whole = Vec::new();
    let said = made.rewritten(&mut whole).unwrap();
    assert_eq!(said.bytes, whole.len() as u64);
    for room in [0, 1000, whole.len() - 1] {
        let mut disk = Disk { room, taken: Vec::new(), largest: 0 };
        let error = made.rewritten(&mut disk).unwrap_err();
        let code: &str = (&error).into();
        assert!(code == "rewrite/write" && error.to_string().ends_with(": the disk is full"), "{room}: {error}");
        assert!(disk.taken[..] == whole[..room], "{room}");
    }
}
