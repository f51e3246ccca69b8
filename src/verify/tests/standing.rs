//! The post and the beam on a table that stands upright, held by more adhesion or by less: against statics by hand.

use super::{FLOW, LAYER, REACH, ReplayJob, Rule, WIDTH, model, plan, profile, program, verify};
use crate::planning::Workpiece;
use crate::verify::Report;

/// Of one square layer of ten: the loop, eleven lines of the zigzag and the ten steps between them, mm.
const LINE_MM: f64 = 4.0 * 9.2 + 11.0 * (7.6 + 2.0 * REACH) + 7.6;

fn held_by(adhesion_mpa: f64) -> Report {
    let (mut profile, plan, model) = (profile(), plan(), model());
    profile.process.adhesion_mpa = adhesion_mpa;
    let workpiece = Workpiece::place(&model, &plan.placement);
    verify(program().as_bytes(), &ReplayJob { profile: &profile, plan: &plan, workpiece: &workpiece })
}

/// How many times over the foot holds post and beam for each MPa, with the table upright: the post's middle is 30 mm from it, the beam's 53.
fn by_hand() -> (f64, f64) {
    let layer_g = LINE_MM * FLOW * std::f64::consts::PI / 4.0 * 1.75 * 1.75 * 1.24e-3;
    let (post, beam) = (150.0 * layer_g, 15.0 * layer_g);
    let tips = (post * 30.0 + beam * 53.0) * 9.80665e-3;
    (LINE_MM * WIDTH * 5.0 / tips, post + beam)
}

#[test]
fn what_holds_the_post_is_its_first_layer() {
    let (each_mpa, grams) = by_hand();
    let report = held_by(0.02);
    let standing = report.standing.clone().unwrap();
    assert!(report.is_clean(), "{:#?}", report.findings);
    assert_eq!(standing.tilt_deg, 90.0);
    assert!((standing.factor / (0.02 * each_mpa) - 1.0).abs() < 2e-3, "{standing:?} {}", 0.02 * each_mpa);
    assert!((standing.grams - grams).abs() < 0.01 && standing.pushed_factor < standing.factor, "{standing:?} {grams}");
}

/// From hardly to more than enough: a finding wherever it is not held once, and only there.
#[test]
fn what_is_not_held_falls() {
    let (each_mpa, _) = by_hand();
    for times in [0.0, 0.1, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 10.0] {
        let report = held_by(times / each_mpa);
        let found: Vec<Rule> = report.counts.keys().copied().collect();
        let wanted: &[Rule] = if times < 1.0 { &[Rule::Standing] } else { &[] };
        assert_eq!(found, wanted, "{times}: {:#?}", report.findings);
        let told = report.findings.iter().map(|finding| finding.measured).fold(f64::INFINITY, f64::min);
        assert!(times >= 1.0 || (told - times).abs() < 2e-3, "{times}: {told}");
    }
}

/// What was laid before the first layer is gone is no foot.
#[test]
fn a_print_whose_first_layer_is_missing_is_held_by_nothing_that_is_known() {
    let (plan, model, profile) = (plan(), model(), profile());
    let workpiece = Workpiece::place(&model, &plan.placement);
    let text = program();
    let from = text.find(";TYPE:External perimeter\nG1 Z0.400").unwrap();
    let to = text.find(&format!(";TYPE:External perimeter\nG1 Z{:.3}", 2.0 * LAYER)).unwrap();
    let without = format!("{}{}", &text[..from], &text[to..]);
    let report = verify(without.as_bytes(), &ReplayJob { profile: &profile, plan: &plan, workpiece: &workpiece });
    assert!(report.standing.is_none() && !report.is_clean(), "{:?}", report.standing);
}
