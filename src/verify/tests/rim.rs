//! The nozzle beside a table that stands upright, nearer to it or farther, with ends of several sizes.

use super::{ReplayJob, Rule, model_at, plan, profile, program_at, verify};
use crate::planning::Workpiece;
use crate::profile::BodySpec;
use crate::verify::Finding;

/// The table stands upright beside the nozzle, whose flat is turned to it: by its radius it reaches nearer to the table than the tip.
#[test]
fn the_rim_of_the_nozzle_keeps_out_of_a_tilted_table() {
    let needle = |radius: f64| {
        let mut profile = profile();
        let nozzle = profile.head.body.iter().find(|body| body.z_mm.is_some_and(|z| z[0] == 0.0)).unwrap().clone();
        profile.head.body = vec![BodySpec { r_mm: Some([radius; 2]), ..nozzle }];
        profile
    };
    for beam_mm in [0.0, 0.1, 0.3] {
        let (plan, model, text) = (plan(), model_at(beam_mm), program_at(beam_mm));
        let workpiece = Workpiece::place(&model, &plan.placement);
        // The lowest line lies half a width above the beam's underside.
        let tip_mm = beam_mm + 0.4;
        for radius in [0.2, tip_mm - 0.05, tip_mm - 0.02, tip_mm + 0.008, tip_mm + 0.02, tip_mm + 0.1, 1.5] {
            let profile = needle(radius);
            let report = verify(text.as_bytes(), &ReplayJob { profile: &profile, plan: &plan, workpiece: &workpiece });
            let about = format!("beam {beam_mm}, radius {radius:.3}: {:#?}", report.findings);
            let room = tip_mm - radius;
            if room > 0.0 {
                assert!(report.is_clean(), "{about}");
                assert!((report.clearance_mm - room).abs() < 0.012, "{}: {about}", report.clearance_mm);
            } else {
                assert_eq!(report.counts.keys().copied().collect::<Vec<_>>(), [Rule::HeadCollision], "{about}");
                let rim = |finding: &&Finding| finding.text.starts_with("the rim");
                let told = report.findings.iter().filter(rim).map(|finding| finding.measured).fold(0.0, f64::max);
                // Up to the depth to which the nozzle may iron what it prints on.
                assert!((told + room).abs() < 0.006 || -room > 0.8 && told > 0.79, "{told}: {about}");
                assert!(report.clearance_mm < 0.0, "{about}");
            }
        }
    }
}
