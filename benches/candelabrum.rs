//! The whole job on the candelabrum (18 parts, 15,190 facets, generic A/C table, built-in slicer), step by step.
//!
//! `cargo bench -p trunnion-benches` prints the times; the latest figures are in docs/explanation/measurements.md. Run on one thread
//! (`RAYON_NUM_THREADS=1`) the times are CPU times.

use divan::Bencher;
use trunnion::mesh::{Model, ReadOptions, read_model};
use trunnion::orient::{Multistart, ObjectiveSettings, Staircase};
use trunnion::planning::{Goal, MachineRef, ModelRef, Options, PartRef, Plan, Planned, Workpiece, orientations, plan};
use trunnion::profile::{Profile, resolve, shipped};
use trunnion::slicing::{Adhesion, BuiltIn, SliceJob, Slicer};
use trunnion::toolpath::{Input, InputWords, LabelledPrint, RewriteJob, print_name, read_sliced, rewrite, slot_mesh};
use trunnion::trace;
use trunnion::verify;
use trunnion::view::{DrawnMachine, DrawnProgram, Scene, Shapes};

fn main() {
    divan::main();
}

const BED: [f64; 2] = [250.0, 250.0];

fn profile() -> Profile {
    let (file, text) = shipped("generic-ac").expect("shipped");
    resolve(file, text).expect("resolves").0
}

fn bytes() -> Vec<u8> {
    std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/candelabrum.stl")).expect("fixture")
}

fn model() -> Model {
    read_model(&bytes(), "candelabrum.stl", &ReadOptions::default()).expect("reads")
}

fn planned(model: &Model, profile: &Profile) -> Planned {
    let (goal, objective, search) = (
        Goal::parse("bss", &ObjectiveSettings::default()).expect("a goal"),
        Staircase { layer_mm: 0.2 },
        Multistart::default(),
    );
    let options = Options::new(&goal, &objective, &search);
    let workpiece = Workpiece::place(model, &Workpiece::centred(model));
    let directions = orientations(&workpiece, &options);
    plan(&workpiece, profile, &directions, &options).expect("feasible").swap_remove(0)
}

fn whole_plan(model: &Model, planned: Planned) -> Plan {
    Plan {
        format: Plan::FORMAT.to_owned(),
        version: Plan::VERSION,
        made_by: String::new(),
        model: ModelRef { file: String::new(), sha256: String::new(), unit: "mm".to_owned() },
        machine: MachineRef { profile: String::new(), sha256: String::new() },
        machine_values: None,
        placement: Workpiece::centred(model),
        bridge_mm: None,
        parts: model.parts.iter().map(|p| PartRef { id: p.id, name: p.name.clone() }).collect(),
        slots: planned.slots,
    }
}

fn sliced(plan: &Plan, workpiece: &Workpiece<'_>, profile: &Profile) -> Vec<Vec<u8>> {
    let table = profile.kinematics();
    let slice = |(index, (_, print)): (usize, (usize, &trunnion::planning::Print))| {
        let slot = slot_mesh(workpiece, &table, print, [BED[0] / 2.0, BED[1] / 2.0]);
        let job = SliceJob {
            name: print_name(index, "part"),
            on_table: slot.on_table,
            bed_mm: BED,
            adhesion: Adhesion::default(),
        };
        BuiltIn.slice(&slot.mesh, &profile.process, &job).expect("slices").gcode
    };
    plan.prints().enumerate().map(slice).collect()
}

/// Everything up to the sliced files, and the rewritten file.
struct Made {
    profile: Profile,
    model: Model,
    plan: Plan,
    sliced: Vec<Vec<u8>>,
}

impl Made {
    fn new() -> Self {
        let (profile, model) = (profile(), model());
        let plan = whole_plan(&model, planned(&model, &profile));
        let workpiece = Workpiece::place(&model, &plan.placement);
        let sliced = sliced(&plan, &workpiece, &profile);
        Self { profile, model, plan, sliced }
    }

    fn workpiece(&self) -> Workpiece<'_> {
        Workpiece::place(&self.model, &self.plan.placement)
    }

    fn rewritten(&self) -> Vec<u8> {
        let workpiece = self.workpiece();
        let segments: Vec<LabelledPrint<'_>> = self
            .sliced
            .iter()
            .map(|bytes| read_sliced(bytes, "bench", InputWords::default()).expect("reads").remove(0))
            .collect();
        let inputs: Vec<Input<'_>> = segments
            .iter()
            .enumerate()
            .map(|(print, segment)| Input {
                print,
                centre_mm: [BED[0] / 2.0, BED[1] / 2.0],
                file: "bench",
                sliced: &segment.sliced,
            })
            .collect();
        let job =
            RewriteJob { plan: &self.plan, plan_sha256: "", profile: &self.profile, workpiece: &workpiece, head: "" };
        let mut gcode = Vec::new();
        rewrite(&inputs, &job, &mut gcode).expect("rewrites");
        gcode
    }
}

#[divan::bench]
fn a_read(bencher: Bencher<'_, '_>) {
    let bytes = bytes();
    bencher.bench(|| read_model(&bytes, "candelabrum.stl", &ReadOptions::default()).expect("reads"));
}

#[divan::bench]
fn b_orient_and_plan(bencher: Bencher<'_, '_>) {
    let (profile, model) = (profile(), model());
    bencher.bench(|| planned(&model, &profile));
}

#[divan::bench(sample_count = 5)]
fn c_slice(bencher: Bencher<'_, '_>) {
    let made = Made::new();
    let workpiece = made.workpiece();
    bencher.bench(|| sliced(&made.plan, &workpiece, &made.profile));
}

#[divan::bench(sample_count = 10)]
fn d_rewrite(bencher: Bencher<'_, '_>) {
    let made = Made::new();
    bencher.counter(divan::counter::BytesCount::new(made.rewritten().len())).bench(|| made.rewritten());
}

#[divan::bench(sample_count = 5)]
fn e_verify(bencher: Bencher<'_, '_>) {
    let made = Made::new();
    let (bytes, workpiece) = (made.rewritten(), made.workpiece());
    let job = verify::ReplayJob { profile: &made.profile, plan: &made.plan, workpiece: &workpiece };
    bencher
        .counter(divan::counter::BytesCount::new(bytes.len()))
        .bench(|| assert!(verify::verify(&bytes, &job).is_clean()));
}

/// What the page of `preview` takes besides verification: the trace, its columns, the text, compression.
#[divan::bench(sample_count = 10)]
fn f_preview(bencher: Bencher<'_, '_>) {
    let made = Made::new();
    let (bytes, profile) = (made.rewritten(), &made.profile);
    let machine = || {
        let (head, frame) = (profile.head_bodies(), profile.fixed_bodies());
        DrawnMachine::of(profile.kinematics(), profile.linear_limits(), &profile.table_slab(), &head, &frame)
    };
    bencher.counter(divan::counter::BytesCount::new(bytes.len())).bench(|| {
        let trace = trace::read(&bytes, &profile.trace_setting());
        let program = Some(DrawnProgram::of(&trace, &bytes, &profile.kinematics(), 'E'));
        Scene { machine: machine(), shapes: Shapes::of(&made.workpiece().parts), program }.packed()
    });
}
