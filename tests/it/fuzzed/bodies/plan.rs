//! Bytes as a plan file: read by itself, and held against a model and a machine.

use std::path::PathBuf;

use trunnion::job::{MachineSource, PlanSource, Source, load_plan};
use trunnion::planning::Plan;
use trunnion::toolpath::slot_mesh;

use super::shelf::Shelf;
use super::{choice, profiles};

/// The model that the plans are of.
const MODEL: &[u8] = include_bytes!("../../../../fixtures/y-tree.stl");

fn model() -> Source {
    Source::Bytes { name: "y-tree.stl".to_owned(), bytes: MODEL.to_vec() }
}

/// The first byte says whether machine and model are given or looked for.
pub(super) fn plan(data: &[u8]) {
    let Some((how, bytes)) = choice(data) else { return };
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(plan) = Plan::parse("any.json", text) {
        let again = Plan::parse("again.json", &plan.to_text()).expect("what is written is read again");
        assert_eq!(again, plan, "another plan is read than was written");
        assert_eq!(again.sha256(), plan.sha256());
        for profile in profiles() {
            let _ = plan.check(&profile.kinematics(), plan.parts.len().min(1000));
        }
        let _ = plan.supports().count();
    }
    let shelf = Shelf([(PathBuf::from("y-tree.stl"), MODEL.to_vec())].into());
    let world = shelf.world();
    let machine = (how % 2 == 0).then(|| MachineSource::from("generic-ac"));
    let source = PlanSource {
        plan: Source::Bytes { name: "any.json".to_owned(), bytes: bytes.to_vec() },
        model: (how / 2 % 2 == 0).then(model),
        machine,
    };
    let checked = match load_plan(&source, &world) {
        Ok(checked) => checked,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let (table, workpiece) = (checked.machine.profile.kinematics(), checked.workpiece());
    for (_, print) in checked.prints() {
        let mesh = slot_mesh(&workpiece, &table, print, [125.0, 105.0]).mesh;
        assert!(mesh.vertices().iter().flatten().all(|v| v.is_finite()), "a print that is nowhere");
    }
}
