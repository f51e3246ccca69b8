//! The jobs as a library's user calls them: in a made-up world, from bytes, step by step.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use trunnion::job::{
    self, Arrangement, Bar, Clock, Files, LoadedModel, MachineSource, OwnWeb, PlanRequest, PlanResult, PlanSource,
    Ports, PoseChoice, PrepareRequest, PrintError, Prints, Progress, RewriteRequest, Silent, SliceRequest, SliceResult,
    Slicers, Source, VerifyRequest, World,
};
use trunnion::link::serial::{Address, Port, PortError, Server};
use trunnion::mesh::stl_binary;
use trunnion::profile::{Profile, resolve, shipped};
use trunnion::slicing::{BuiltIn, Slicer, SlicerChoice};
use trunnion::strategy::{StrategyError, Way};
use trunnion::world::{FileError, NoSlicer};

use crate::split::solids::{Shape, block};
use crate::support::{coded, fails, root};

/// Files that are on no disk.
struct Shelf(BTreeMap<PathBuf, Vec<u8>>);

impl Files for Shelf {
    fn size(&self, path: &Path) -> Result<u64, FileError> {
        self.read(path).map(|bytes| bytes.len() as u64)
    }

    fn read(&self, path: &Path) -> Result<Vec<u8>, FileError> {
        let missing = || FileError::Read { path: path.to_owned(), source: std::io::ErrorKind::NotFound.into() };
        self.0.get(path).cloned().ok_or_else(missing)
    }

    fn exists(&self, path: &Path) -> bool {
        self.0.contains_key(path)
    }
}

/// The same, each of which is there once: whoever looks again finds another file in its place.
struct ReadOnce {
    shelf: Shelf,
    read: RefCell<Vec<PathBuf>>,
}

impl Files for ReadOnce {
    fn size(&self, path: &Path) -> Result<u64, FileError> {
        self.shelf.size(path)
    }

    fn read(&self, path: &Path) -> Result<Vec<u8>, FileError> {
        let bytes = self.shelf.read(path)?;
        let again = self.read.borrow().contains(&path.to_owned());
        self.read.borrow_mut().push(path.to_owned());
        Ok(if again { b"no model".to_vec() } else { bytes })
    }

    fn exists(&self, path: &Path) -> bool {
        self.shelf.exists(path)
    }
}

/// A computer that has the built-in slicer, no ports, and a clock on which every look takes a second.
struct Made {
    looks: Cell<u64>,
}

impl Slicers for Made {
    fn find(&self, _: &SlicerChoice, _: &[PathBuf], _: Duration) -> Result<Box<dyn Slicer>, NoSlicer> {
        Ok(Box::new(BuiltIn))
    }
}

impl Clock for Made {
    fn now(&self) -> Duration {
        self.looks.set(self.looks.get() + 1);
        Duration::from_secs(self.looks.get())
    }

    fn sleep(&self, _: Duration) {}

    fn boot(&self) -> String {
        String::new()
    }
}

impl Ports for Made {
    fn open(&self, address: &Address, _: u32) -> Result<Port, PortError> {
        panic!("nobody asked for {address:?}")
    }

    fn serve(&self, place: &str) -> Result<Server, PortError> {
        panic!("nobody asked for {place}")
    }

    fn identity(&self, _: &Path, _: &Path) -> Option<String> {
        None
    }

    fn find_again(&self, address: &Address, _: Option<&str>, _: &Path) -> Address {
        address.clone()
    }
}

/// What somebody who watches has seen.
#[derive(Default)]
struct Seen(RefCell<Vec<String>>);

impl Progress for Seen {
    fn warning(&self, text: &str) {
        self.0.borrow_mut().push(text.to_owned());
    }

    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_> {
        self.0.borrow_mut().push(format!("{what} {of}"));
        Box::new(Silent)
    }

    fn reached(&self, done: &dyn Any) {
        let read = |model: &LoadedModel| format!("read {}", model.model.parts.len());
        let planned = |made: &PlanResult| format!("planned {}", made.best().slots.len());
        let sliced = |done: &SliceResult| format!("sliced {}", done.sliced.len());
        let told = done.downcast_ref().map(read);
        let told = told.or_else(|| done.downcast_ref().map(planned)).or_else(|| done.downcast_ref().map(sliced));
        self.0.borrow_mut().push(told.expect("a model, a plan or slices"));
    }
}

fn fixture(name: &str) -> Source {
    let path = root().join("fixtures").join(name);
    Source::Bytes { name: name.to_owned(), bytes: std::fs::read(path).unwrap() }
}

fn generic() -> Profile {
    let (file, text) = shipped("generic-ac").unwrap();
    resolve(file, text).unwrap().0
}

fn builtin() -> PrepareRequest {
    let mut request = PrepareRequest::new(fixture("two-boxes.stl"), "generic-ac");
    request.slicing.slicer = SlicerChoice::BuiltIn;
    request
}

#[test]
fn the_main_job_needs_nothing_but_its_world() {
    let (made, seen) = (Made { looks: Cell::new(0) }, Seen::default());
    let Source::Bytes { bytes, .. } = fixture("two-boxes.stl") else { unreachable!() };
    let shelf = Shelf(BTreeMap::from([(PathBuf::from("two-boxes.stl"), bytes)]));
    let world = World {
        files: &shelf,
        slicers: &made,
        ports: &made,
        web: &OwnWeb,
        clock: &made,
        progress: &seen,
        memory: None,
    };
    let request = PrepareRequest::new("two-boxes.stl", generic());
    let done = job::prepare(&request, &world).unwrap();
    assert_eq!(*seen.0.borrow(), ["read 2", "planned 2", "slicing 2", "sliced 2"]);
    assert_eq!((done.slicer.name.as_str(), done.warnings.len()), ("built-in slicer", 0));
    let report = done.gcode.report().unwrap();
    assert!(report.is_clean() && report.slots == 2, "{report:?}");
    // Times are the clock's, whole seconds here, and none is counted twice.
    let s = done.seconds;
    let sum = s.read + s.orient + s.plan + s.slice + s.rewrite + s.verify;
    assert!(sum > 5.0 && sum.fract() == 0.0 && sum < made.looks.get() as f64, "{s:?}");
    // The program does not depend on the world.
    let here = job::prepare(&builtin(), &World::here(&Silent)).unwrap();
    assert!(here.gcode.program() == done.gcode.program());
}

#[test]
fn each_step_by_itself_gives_the_program_of_the_main_job() {
    let (world, whole) = (World::here(&Silent), builtin());
    let expected = job::prepare(&whole, &world).unwrap();
    let request = PlanRequest {
        arrangement: whole.arrangement,
        options: whole.plan,
        ..PlanRequest::new(whole.model, whole.machine)
    };
    let text = job::plan(&request, &world).unwrap().plan.plan.to_text().into_bytes();
    let file = Source::Bytes { name: "plan.json".to_owned(), bytes: text };
    let source = PlanSource { plan: file, model: Some(fixture("two-boxes.stl")), machine: None };
    let plan = &job::load_plan(&source, &world).unwrap();
    let prints = &Prints::of(plan, whole.slicing.bed);
    let sliced = job::slice(&SliceRequest { plan, prints, options: &whole.slicing }, &world).unwrap().sliced;
    let named = sliced.into_iter().zip(&prints.names);
    let sliced = named.map(|(bytes, name)| Source::Bytes { name: name.clone(), bytes }).collect();
    let request = RewriteRequest { plan, sliced, print: None, bed: whole.slicing.bed };
    let program = job::rewrite(&request, &world).unwrap().gcode;
    assert!(program.program() == expected.gcode.program());
    // What is cut short is no verified program.
    let half = program.program()[..program.program().len() / 2].to_vec();
    let half = Source::Bytes { name: "half.gcode".to_owned(), bytes: half };
    let done = job::verify(&VerifyRequest { program: &half, plan }, &world).unwrap();
    assert!(!done.report.is_clean());
    let Err(PrintError::Rejected(rejected)) = done.verified() else { panic!("half a program is verified") };
    assert!(rejected.to_string().contains("findings: line "), "{rejected}");
}

#[test]
fn a_request_that_cannot_be_is_refused_with_the_settings_name() {
    let world = World::here(&Silent);
    let mut request = PlanRequest::new(fixture("two-boxes.stl"), "generic-ac");
    request.options.overhang_deg = Some(95.0);
    let error = job::plan(&request, &world).unwrap_err();
    assert!(fails(&coded(error.code(), &error), "setting/out-of-range: overhang | 0 and 90 | got 95 deg"), "{error}");
    let mut request = builtin();
    request.slicing.bed = [250.0, 9000.0].into();
    let error = job::prepare(&request, &world).unwrap_err();
    assert!(fails(&coded(error.code(), &error), "setting/out-of-range: bed | 0 and 5000 | got 9000 mm"), "{error}");
    // A machine in code is held to what a file may hold: by itself, and one key against the other.
    let mut machine = generic();
    machine.kinematics.tilt.direction = 2;
    let error = job::load_profile(&MachineSource::from(machine), &world).unwrap_err();
    let wanted = "profile/range: profile generic-ac | kinematics.tilt.direction | 2 | 1 or -1";
    assert!(fails(&coded(error.code(), &error), wanted), "{error}");
    let mut machine = generic();
    machine.limits.z_mm = [300.0, 0.0];
    let said = job::load_profile(&MachineSource::from(machine), &world).unwrap_err().to_string();
    assert!(said.starts_with("profile generic-ac: limits.z_mm"), "{said}");
}

/// Whatever poses, distances and joints are tried, all of them are of the same bytes, and none is dropped because a file is not read again.
#[test]
fn a_model_is_read_once_however_many_poses_are_tried() {
    let model = |name: &str, shape: &Shape| (PathBuf::from(name), stl_binary(&shape.mesh()));
    let (bar, table) = (block(206.0, 40.0, 40.0), block(24.0, 24.0, 3.0).at(0.0, 0.0, 20.0));
    let table = table.and(&block(5.0, 5.0, 21.0).at(19.0, 0.0, 0.0)).and(&block(5.0, 5.0, 21.0));
    let files = [model("bar.stl", &bar), model("table.stl", &table), model("box.stl", &block(8.0, 8.0, 8.0))];
    let once = |job: &dyn Fn(&World<'_>)| {
        let files = ReadOnce { shelf: Shelf(files.clone().into()), read: RefCell::default() };
        job(&World { files: &files, ..World::here(&Silent) });
        let mut read = files.read.into_inner();
        read.sort();
        read
    };
    let prepared = |model: &str, how: Arrangement, way: Way| {
        let mut request = PrepareRequest { arrangement: how, ..PrepareRequest::new(model, "generic-ac") };
        request.slicing.slicer = SlicerChoice::BuiltIn;
        once(&|world| {
            let done = job::prepare(&request, world).unwrap();
            assert_eq!(done.planned.ways.iter().find(|tried| tried.chosen).map(|tried| tried.way), Some(way));
        })
    };
    let plain = Arrangement::default;
    // Too long as it was drawn, and over its rim in more poses; on its end it stands.
    assert_eq!(prepared("bar.stl", plain(), Way::Turned), [Path::new("bar.stl")]);
    // What hangs as it was drawn is turned over, joined, or held; with others beside it they are moved apart.
    assert_eq!(prepared("table.stl", plain(), Way::Turned), [Path::new("table.stl")]);
    let beside = vec![("box.stl".into(), 2)];
    let how = Arrangement { beside, standing: PoseChoice::Up([0.0, 0.0, -1.0]), ..plain() };
    assert_eq!(prepared("table.stl", how, Way::AsDrawn), ["box.stl", "table.stl"].map(Path::new));
    // In every way in which it can stand on a face.
    let how = Arrangement { standing: PoseChoice::Any, ..plain() };
    let request = PlanRequest { arrangement: how, ..PlanRequest::new("box.stl", "generic-ac") };
    let listed = once(&|world| {
        let mut stands = 0;
        job::sequences(&request, 100, world, |up, _| stands += usize::from(up.is_some())).unwrap();
        assert!(stands >= 3, "{stands}");
    });
    assert_eq!(listed, [Path::new("box.stl")]);
}

#[test]
fn where_there_is_no_plan_the_reasons_come_as_values() {
    let mut request = PlanRequest::new(fixture("caged.stl"), "generic-ac");
    request.options.remedies = false;
    let no = job::plan(&request, &World::here(&Silent)).unwrap_err();
    let StrategyError::NoPlan(no) = no else { panic!("{no}") };
    let (reasons, _) = no.reasons();
    assert!(!reasons.is_empty() && no.remedies.is_none());
    assert!(no.sheet().is_some_and(|sheet| sheet.marks.len() > 20));
}
