//! Prints for the tests of this room, each prepared once.

use std::sync::OnceLock;

use crate::fixtures::{Fixture, solid_box, two_boxes};
use crate::geom::Vec3;
use crate::input::{CheckedPlan, MachineSource, Source};
use crate::job::printer;
use crate::job::{PrepareRequest, PrepareResult, prepare};
use crate::link::{Program, SenderSettings};
use crate::profile::Profile;
use crate::slicing::SlicerChoice;
use crate::world::{Silent, World};

/// A print, prepared, and as it is sent.
pub(super) struct Prepared {
    pub(super) done: PrepareResult,
    pub(super) program: Program,
    settings: SenderSettings,
}

impl Prepared {
    fn of(fixture: &Fixture) -> Self {
        let model = Source::Bytes { name: fixture.file.to_owned(), bytes: fixture.stl() };
        let mut request = PrepareRequest::new(model, MachineSource::from("generic-ac"));
        request.slicing.slicer = SlicerChoice::BuiltIn;
        let done = prepare(&request, &World::here(&Silent)).unwrap();
        let profile = &done.planned.plan.machine.profile;
        let program = Program::read(done.gcode.program(), &printer::rules(profile).unwrap()).unwrap();
        let settings = printer::settings(profile).unwrap();
        Self { done, program, settings }
    }

    pub(super) fn plan(&self) -> &CheckedPlan {
        &self.done.planned.plan
    }

    pub(super) fn profile(&self) -> &Profile {
        &self.plan().machine.profile
    }

    pub(super) fn text(&self) -> &[u8] {
        self.done.gcode.program()
    }

    /// How it is sent, by a machine that is homed by these lines.
    pub(super) fn homed_by(&self, rehome: &str) -> SenderSettings {
        let mut settings = self.settings.clone();
        settings.retreat.home = rehome.lines().map(str::to_owned).collect();
        settings
    }
}

/// A post, and a beam out of its side that is printed at A90 C90.
pub(super) fn boxes() -> &'static Prepared {
    static DONE: OnceLock<Prepared> = OnceLock::new();
    DONE.get_or_init(|| Prepared::of(&two_boxes()))
}

/// A post of 4 x 4 x 3 mm: a layer has hardly more lines than a planner holds.
pub(super) fn tower() -> &'static Prepared {
    static DONE: OnceLock<Prepared> = OnceLock::new();
    let post = || solid_box(Vec3::new(0.0, 0.0, 0.0), Vec3::new(4.0, 4.0, 3.0));
    DONE.get_or_init(|| Prepared::of(&Fixture { file: "tower.stl", parts: vec![("post".to_owned(), post())] }))
}
