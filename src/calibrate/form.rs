//! A file of touches that are still to be made, for a person to fill in.

use std::fmt::Write as _;

use super::touches::{ChainCandidate, Feature, Of, Tip, TipShape, TouchShape};

/// A file to be filled in: the `tip`, the `features` and, for each of `poses`, a touch without its `at_mm`.
pub fn form(tip: &Tip, features: &[Feature], poses: &[ChainCandidate], [tilt, rotation]: [char; 2]) -> String {
    let shape = if tip.shape == TipShape::Flat { "flat" } else { "ball" };
    let mut out = format!(
        "# Touches to be made. At each: turn the table to the angles, lower the tip onto what is named, the paper between them, and write what\n\
         # the machine shows as X, Y, Z into at_mm. Touches without at_mm are left out. What each key means: docs/how-to/machine.md.\n\
         \n[tip]\n# \"flat\": a nozzle's end; \"ball\": a probe's ball. paper_mm: what is between tip and table. repeats_to_mm: how well one touch repeats.\n\
         shape = {shape:?}\nradius_mm = {:?}\npaper_mm = {:?}\nrepeats_to_mm = {:?}\noffset_mm = {:?}\n",
        tip.radius_mm, tip.paper_mm, tip.repeats_to_mm, tip.offset_mm
    );
    if let Some(by_eye) = tip.by_eye_mm {
        let _ = writeln!(out, "# by_eye_mm: how well X and Y repeat over a mark.\nby_eye_mm = {by_eye:?}");
    }
    for feature in features {
        let _ = match feature.shape {
            TouchShape::Mark { height, known } => {
                let known = known.map_or_else(String::new, |at| format!("table_mm = {at:?}\n"));
                write!(out, "\n[[mark]]\nname = {:?}\nheight_mm = {height:?}\n{known}", feature.name)
            }
            TouchShape::Ball { radius } => {
                write!(out, "\n[[ball]]\nname = {:?}\ndiameter_mm = {:?}\n", feature.name, radius * 2.0)
            }
        };
    }
    for (index, pose) in poses.iter().enumerate() {
        let name = match pose.of {
            Of::Table => "table",
            Of::Feature(index) => &features[index].name,
        };
        let [a, c] = pose.words_deg;
        let [x, y, z] = [pose.tip.x, pose.tip.y, pose.tip.z].map(|v| (v * 10.0).round() / 10.0 + 0.0);
        let _ = write!(
            out,
            "\n# {}: {tilt}{a} {rotation}{c}, near X{x:.1} Y{y:.1} Z{z:.1}\n[[touch]]\nof = {name:?}\ntilt_deg = {a:?}\nrotation_deg = {c:?}\nat_mm = []\n",
            index + 1
        );
    }
    out
}
