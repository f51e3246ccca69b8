//! Rules `layer-height` and `complete`: each layer stands as high over the one before as its beads are, the first over what
//! carries the part, and every layer is there, up to the top.

use super::coverage::is_printed;
use super::prints::{Level, PrintedPart};
use super::report::{FindingPlace, Findings, Rule};

/// What a layer's height may be off, mm: well below what a nozzle bears, well above what digits lose.
pub(super) const HEIGHT_MM: f64 = 0.05;
/// Where no height is stated: what the filament of a layer of unusual height may be off what that height holds, relative.
const FLOW_OFF: f64 = 0.15;

/// Holds the layers of one print against each other and against the part.
pub(super) fn check(printed: &PrintedPart<'_>, findings: &mut Findings) {
    let (Some(first), Some(last)) = (printed.levels.first(), printed.levels.last()) else { return };
    let usual = usual_height(&printed.levels);
    begins(printed, first, usual, findings);
    for pair in printed.levels.windows(2) {
        follows(printed, &pair[0], &pair[1], usual, findings);
    }
    ends(printed, last, usual, findings);
}

fn place(printed: &PrintedPart<'_>, line: u32) -> FindingPlace {
    FindingPlace { line, slot: Some(printed.planned.slot), part: Some(printed.planned.part) }
}

/// The median height of the layers but the first.
fn usual_height(levels: &[Level]) -> f64 {
    let mut heights: Vec<f64> = levels.iter().skip(usize::from(levels.len() > 1)).map(Level::height).collect();
    heights.sort_by(f64::total_cmp);
    heights[heights.len() / 2]
}

/// The first layer begins at the part's lowest point, or above a piece that is too narrow to print.
fn begins(printed: &PrintedPart<'_>, first: &Level, usual: f64, findings: &mut Findings) {
    let height = first.stated.or(first.nominal).unwrap_or(usual);
    let bottom = printed.sections.range()[0] - printed.joint_mm;
    let off = first.z - height - bottom + printed.overlap_mm;
    // Half of an overlap that is not there, or is there twice, is seen where the height is stated.
    let most = if first.stated.is_some() && printed.overlap_mm > 0.0 {
        HEIGHT_MM.min(printed.overlap_mm / 2.0)
    } else {
        HEIGHT_MM
    };
    if off > usual / 2.0 && !(says_nothing(first) && holds_its_height(printed, first)) {
        if let Some(z) = printable_between(printed, bottom, first.z - height, usual) {
            findings.add(Rule::Complete, place(printed, first.line), [off, usual / 2.0], || {
                format!(
                    "part {} starts {off:.2} mm above its lowest point; the layer at Z {z:.2} is missing",
                    printed.planned.part
                )
            });
        }
    } else if off.abs() > most && (first.stated.is_some() || !holds_its_height(printed, first)) {
        findings.add(Rule::LayerHeight, place(printed, first.line), [off, most], || {
            let (part, which) = (printed.planned.part, if off > 0.0 { "high" } else { "low" });
            format!("part {part}: the first layer ({height:.2} mm high{}) is printed {:.3} mm too {which} (maximum {most} mm)", pressed(printed), off.abs())
        });
    }
}

/// What is asked of the first layer besides its height.
fn pressed(printed: &PrintedPart<'_>) -> String {
    match printed.overlap_mm {
        0.0 => String::new(),
        mm => format!(", [joint] overlap_mm = {mm}"),
    }
}

fn follows(printed: &PrintedPart<'_>, below: &Level, level: &Level, usual: f64, findings: &mut Findings) {
    let height = level.stated.or(level.nominal).unwrap_or(usual);
    let off = level.gap - height;
    if off.abs() <= HEIGHT_MM {
        return;
    }
    if off > usual / 2.0
        && let Some(z) = printable_between(printed, below.z, level.z - height, usual)
    {
        findings.add(Rule::Complete, place(printed, level.line), [off, HEIGHT_MM], || {
            format!(
                "part {} has a gap of {off:.2} mm below this layer; the layer at Z {z:.2} is missing",
                printed.planned.part
            )
        });
        return;
    }
    if level.stated.map_or_else(|| !holds_its_height(printed, level), |_| off <= usual / 2.0) {
        findings.add(Rule::LayerHeight, place(printed, level.line), [level.gap, height], || {
            format!(
                "the tip is {:.3} mm above the layer below, but the lines are {height:.3} mm high (tolerance {HEIGHT_MM} mm)",
                level.gap
            )
        });
    }
}

/// Whether neither the layer nor the file's settings say how high it is: then only its filament tells.
fn says_nothing(level: &Level) -> bool {
    level.stated.or(level.nominal).is_none()
}

/// Whether a layer without a stated height takes the filament that its gap holds: then it was meant to be so high.
fn holds_its_height(printed: &PrintedPart<'_>, level: &Level) -> bool {
    let width = printed.job.profile.process.line_width_mm;
    let (mut laid, mut held) = (0.0, 0.0);
    for &index in &level.beads {
        let m = printed.bead(index);
        let length = m.ends().map_or(0.0, |[from, to]| (to - from).norm());
        let (one, all) = (m.e * printed.filament_mm2, printed.flow.bead.area(width, level.gap) * length);
        // Thin lines that fill gaps say nothing of the height.
        if one > all * 0.5 || printed.flow.widths.is_empty() {
            (laid, held) = (laid + one, held + all * printed.flow.multiplier);
        }
    }
    held > 0.0 && (laid / held - 1.0).abs() <= FLOW_OFF
}

/// The last layer ends at the part's top, to within a layer, but for what is too narrow to print.
fn ends(printed: &PrintedPart<'_>, last: &Level, usual: f64, findings: &mut Findings) {
    let top = printed.sections.range()[1];
    let over = last.z - top;
    if over > usual + HEIGHT_MM {
        findings.add(Rule::LayerHeight, place(printed, last.line), [over, usual], || {
            format!(
                "part {} is printed {over:.2} mm higher than it is (maximum one layer, {usual:.2} mm)",
                printed.planned.part
            )
        });
    }
    if -over > usual
        && let Some(z) = printable_between(printed, last.z, top, usual)
    {
        findings.add(Rule::Complete, place(printed, last.line), [-over, usual], || {
            format!(
                "part {} stops {:.2} mm short of its top; the layer at Z {z:.2} is missing",
                printed.planned.part, -over
            )
        });
    }
}

/// The first height between `low` and `high`, in steps of a layer, at which whole layers are left out that any slicer prints.
fn printable_between(printed: &PrintedPart<'_>, low: f64, high: f64, layer: f64) -> Option<f64> {
    let width = printed.job.profile.process.line_width_mm;
    let count = ((high - low) / layer + 0.25).floor() as usize;
    let at = |k: usize| low + (k as f64 + 0.5) * layer;
    (0..count).map(at).find(|&z| is_printed(&printed.sections.at(z), width))
}
