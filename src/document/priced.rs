//! What `printable` recommends, in figures and in words.

use serde_json::{Value, json};

use crate::geom::Vec3;
use crate::orient::{PoseRole, Priced, Process, Recommendation, Runner, to_angles};

/// Adds the recommendation to a result's document.
pub(super) fn recommendation(made: &Recommendation, process: &Process, document: &mut Value) {
    document["recommended"] = pose(&made.recommended);
    document["reasons"] = reasons(made).into();
    document["as_it_lies"] = pose(&made.as_it_lies);
    document["own"] = made.own.as_ref().map_or(Value::Null, pose);
    let runner = |runner: &Runner| {
        let mut document = pose(&runner.pose);
        document["role"] = runner.role.name().into();
        document
    };
    document["alternatives"] = made.runners.iter().map(runner).collect();
    document["process"] = json!({
        "layer_mm": process.layer_mm, "line_mm": process.line_mm, "walls": process.walls, "infill": process.infill,
        "wall_mm_per_s": process.wall_mm_per_s, "infill_mm_per_s": process.infill_mm_per_s,
        "support_density": process.support, "overhang_deg": process.overhang.deg(),
    });
}

/// A direction as a list; minus nothing is nothing.
pub(super) fn plain(up: &Vec3) -> [f64; 3] {
    [up.x + 0.0, up.y + 0.0, up.z + 0.0]
}

fn pose(pose: &Priced) -> Value {
    let (alpha, beta) = to_angles(&pose.up);
    json!({
        "up": plain(&pose.up), "alpha_deg": alpha.to_degrees() + 0.0, "beta_deg": beta.to_degrees() + 0.0,
        "price_min": pose.price_min, "grams": grams(pose), "minutes": minutes(pose),
        "support_grams": pose.supports.grams, "support_minutes": pose.supports.minutes,
        "support_volume_mm3": pose.support_mm3, "support_on_part_mm3": pose.on_part_mm3,
        "scar_mm2": pose.scar_mm2, "scar_min": pose.scar_min, "steps_min": pose.steps_min, "risk_min": pose.risk_min,
        "height_mm": pose.height_mm, "stepped_area_mm2": pose.stepped_mm2, "footprint_mm2": pose.footprint_mm2,
        "tipping_deg": pose.tipping_deg, "tipping_held_deg": pose.held_deg, "stands": pose.stands,
    })
}

/// Filament of part and supports, g.
pub(super) fn grams(pose: &Priced) -> f64 {
    pose.part.grams + pose.supports.grams
}

/// Printing time of part and supports, min.
pub(super) fn minutes(pose: &Priced) -> f64 {
    pose.part.minutes + pose.supports.minutes
}

/// Poses nearer than this are one for a reader.
const SAME: f64 = 1e-3;

/// Why the recommended pose: how it stands, what it needs, what the others would cost more, and of what.
pub fn reasons(made: &Recommendation) -> Vec<String> {
    let best = &made.recommended;
    let mut all = vec![standing(best), supports(best)];
    let differs = |other: &Priced| (other.up - best.up).norm() > SAME;
    let mut others: Vec<(String, &Priced)> = vec![("as in the file".to_owned(), &made.as_it_lies)];
    others.extend(made.own.iter().map(|own| ("your own pose".to_owned(), own)));
    others.extend(made.runners.iter().map(|r| (pose_of(r.role).to_owned(), &r.pose)));
    let mut told: Vec<&Priced> = Vec::new();
    for (name, other) in others.into_iter().filter(|(_, other)| differs(other)) {
        if told.iter().all(|known| (known.up - other.up).norm() > SAME) {
            all.push(against(&name, best, other));
            told.push(other);
        }
    }
    if !differs(&made.as_it_lies) {
        all.push("it is the file's own pose".to_owned());
    }
    all
}

fn pose_of(role: PoseRole) -> &'static str {
    match role {
        PoseRole::LeastSupport => "the pose with the least support",
        PoseRole::Flattest => "the flattest pose",
        PoseRole::Lowest => "the lowest pose",
        PoseRole::BestSurface => "the pose with the best surface",
    }
}

fn standing(pose: &Priced) -> String {
    let (area, tipping) = (pose.footprint_mm2, pose.tipping_deg);
    if pose.stands {
        return format!("it stands by itself: {area:.1} mm2 of first layer, stable up to a tilt of {tipping:.1} deg");
    }
    let why = if tipping <= 0.0 { "falls over".to_owned() } else { format!("tips over beyond {tipping:.1} deg") };
    let held = if pose.support_mm3 > 0.0 {
        format!(", and with its supports it tips over beyond {:.1} deg", pose.held_deg)
    } else {
        String::new()
    };
    format!(
        "it does not stand safely by itself: it {why}{held} ({area:.1} mm2 of first layer); a brim (process.brim_mm) may help"
    )
}

fn supports(pose: &Priced) -> String {
    if pose.support_mm3 <= 0.0 {
        return "it needs no supports".to_owned();
    }
    let (grams, minutes) = (pose.supports.grams, pose.supports.minutes);
    let on_part = match pose.on_part_mm3 {
        some if some > 0.0 => format!(", {some:.0} mm3 of it on the part"),
        _ => ", all of it on the bed".to_owned(),
    };
    format!("supports take {grams:.1} g and {minutes:.1} min ({:.0} mm3 of columns{on_part})", pose.support_mm3)
}

/// What `other` costs more, and by what for the most part.
fn against(name: &str, best: &Priced, other: &Priced) -> String {
    let more = other.price_min - best.price_min;
    let part = |p: &Priced| p.part.minutes + p.part.grams;
    let support = |p: &Priced| p.supports.minutes + p.supports.grams;
    let differences = [
        (support(other) - support(best), "for supports"),
        (other.scar_min - best.scar_min, "for cleaning supported areas"),
        (other.risk_min - best.risk_min, "for the risk of coming loose"),
        (other.steps_min - best.steps_min, "for layer steps on its slopes"),
        (part(other) - part(best), "for its height"),
    ];
    let (most, of) = differences.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, ""));
    if more.abs() < 0.005 * best.price_min {
        return format!(
            "{name} costs the same within half a percent, and has {:.1} mm2 of bed contact",
            other.footprint_mm2
        );
    }
    if more < 0.0 {
        let (contact, least) = (other.footprint_mm2, best.footprint_mm2);
        let why = match best.stands && !other.stands {
            true => "does not stand safely by itself".to_owned(),
            false if contact < least => {
                format!("has only {contact:.1} mm2 of bed contact (recommended pose: {least:.1} mm2)")
            }
            false => "leans from a level pose".to_owned(),
        };
        return format!("{name} would cost {:.1} min less, but {why}", -more);
    }
    format!("{name} would cost {more:.1} min more: {most:.1} min {of}")
}
