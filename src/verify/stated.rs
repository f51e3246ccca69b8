//! What a file states of its own settings where the profile asks for more: the check of `fill` believes it, as users slice with settings of
//! their own, so the report says that it did.

use super::evidence::{Checked, Evidence, Figures};
use super::prints::PrintedPart;
use super::report::{Findings, StatedSetting};

/// States each setting once, with all parts whose prints state the same of it.
pub(super) fn check(&Evidence { printed, .. }: &Evidence<'_>) -> Checked {
    let mut all: Vec<StatedSetting> = Vec::new();
    for print in printed.iter().flatten() {
        for (setting, file, profile) in less(print) {
            match all.iter_mut().find(|one| (one.setting, one.file) == (setting, file)) {
                Some(one) => one.parts.push(print.planned.part),
                None => all.push(StatedSetting { setting, file, profile, parts: vec![print.planned.part] }),
            }
        }
    }
    Checked { findings: Findings::default(), figures: Figures::Stated(all) }
}

/// The settings of which a print states less than the profile has, or another share of filament: their key in `[process]`, the file's value and
/// the profile's.
fn less(print: &PrintedPart<'_>) -> Vec<(&'static str, f64, f64)> {
    let (process, flow) = (&print.job.profile.process, &print.flow);
    let counts = [
        ("walls", flow.inside.walls, process.walls),
        ("top_layers", flow.inside.tops, process.top_layers),
        ("bottom_layers", flow.inside.bottoms, process.bottom_layers),
    ];
    let fewer = counts.into_iter().filter_map(|(key, file, profile)| {
        file.filter(|count| *count < profile).map(|count| (key, f64::from(count), f64::from(profile)))
    });
    let empty = (flow.inside.infill == Some(false) && process.infill > 0.0).then_some(("infill", 0.0, process.infill));
    let scaled = (flow.multiplier != 1.0).then_some(("multiplier", flow.multiplier, 1.0));
    fewer.chain(empty).chain(scaled).collect()
}
