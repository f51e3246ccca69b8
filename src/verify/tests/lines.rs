//! Lines on top of each other, and lines whose filament fits no width: one more in a layer of the valid program.

use super::{FLOW, LAYER, Rule, WIDTH, program, run};
use crate::verify::Report;

/// Infill runs along Y between -3.8 and 3.8, one line at X 0 and the next 0.76 mm away.
const FROM: f64 = -3.8;

/// The program with one more line in the post's 21st layer, from `from` on and with `flow` of the usual filament, the header counting
/// that too.
fn with_line(from: [f64; 2], to: [f64; 2], flow: f64) -> String {
    with_line_in(&program(), from, to, flow)
}

/// The same with one more line in a program that was changed so before, behind those.
fn with_line_in(text: &str, from: [f64; 2], to: [f64; 2], flow: f64) -> String {
    let e = ((to[0] - from[0]).hypot(to[1] - from[1]) * FLOW * flow * 1e5).round() / 1e5;
    let key = "expect print=0 part=0 filament_mm=";
    let at = text.find(key).unwrap() + key.len();
    let end = at + text[at..].find('\n').unwrap();
    let filament = text[at..end].parse::<f64>().unwrap() + e;
    let text = format!("{}{filament:.5}{}", &text[..at], &text[end..]);
    let (layer, _) = text.match_indices(&format!("G1 Z{:.3}", 22.0 * LAYER)).next().unwrap();
    let line = format!(
        "G1 X{:.3} Y{:.3} F6000\nG1 X{:.3} Y{:.3} E{e:.5} F1800\n;TYPE:External perimeter\n",
        from[0], from[1], to[0], to[1]
    );
    format!("{}{line}{}", &text[..layer], &text[layer..])
}

fn report(text: &str) -> Report {
    run(text, &super::profile())
}

fn is_found(report: &Report, words: &str) -> bool {
    report.findings.iter().any(|f| f.rule == Rule::Flow && f.text.contains(words))
}

#[test]
fn a_line_on_top_of_another_is_found_from_four_millimetres_on() {
    for (beside, length, found) in [
        (0.0, 7.6, true),
        (0.1, 7.6, true),
        (-0.1, 7.6, true),
        (0.15, 7.6, true),
        (-0.15, 7.6, true),
        // Half way to the next line it is on top of neither.
        (0.17, 7.6, false),
        (0.38, 7.6, false),
        (0.76, 7.6, true),
        (0.0, 4.1, true),
        (0.0, 3.9, false),
    ] {
        let report = report(&with_line([beside, FROM], [beside, FROM + length], 1.0));
        assert_eq!(is_found(&report, "on top of"), found, "{beside} {length}: {:#?}", report.findings);
    }
}

#[test]
fn a_curve_laid_twice_is_one_stretch_however_short_its_lines() {
    // Along an infill line in steps of 0.5 mm.
    let steps = |count: u32, apart: f64| {
        let mut text = program();
        for k in 0..count {
            let from = FROM + f64::from(k) * apart;
            text = with_line_in(&text, [0.0, from], [0.0, from + 0.5], 1.0);
        }
        report(&text)
    };
    assert!(is_found(&steps(9, 0.5), "on top of"), "{:#?}", steps(9, 0.5).findings);
    // 0.5 mm at a time with other lines between is what infill does at its turns.
    let mut text = program();
    for k in 0..8 {
        let from = FROM + f64::from(k) * 0.9;
        text = with_line_in(&text, [0.0, from], [0.0, from + 0.5], 1.0);
        text = with_line_in(&text, [0.38, from], [0.38, from + 0.5], 1.0);
    }
    assert!(!is_found(&report(&text), "on top of"), "{:#?}", report(&text).findings);
}

#[test]
fn sparse_infill_may_go_over_more_of_an_earlier_row() {
    // Along rows of the layer's infill, one after the other, as the slicer's sparse infill both.
    let found = |role: &str, mm: f64| {
        let along = |text: String, k: u32| {
            let (x, long) = (0.76 * f64::from(k), (mm - 7.6 * f64::from(k)).min(7.6));
            if long > 0.0 { with_line_in(&text, [x, FROM], [x, FROM + long], 1.0) } else { text }
        };
        let line = (0..2).fold(program(), along);
        let (layer, _) = line.match_indices(&format!("G1 Z{:.3}", 22.0 * LAYER)).next().unwrap();
        let (before, after) = line.split_at(layer);
        let start = before.rfind(";TYPE:Solid infill").unwrap();
        let infill = before[start..].replace(";TYPE:Solid infill", role);
        let infill = infill.replace(";TYPE:External perimeter\nG1 X", &format!("{role}\nG1 X"));
        let text = format!("{}{infill}{after}", &before[..start]);
        is_found(&report(&text), "on top of")
    };
    for (role, mm, wanted) in [
        (";TYPE:Solid infill", 5.0, true),
        (";TYPE:Internal infill", 5.0, false),
        (";TYPE:Internal infill", 7.6, false),
        (";TYPE:Internal infill", 12.0, true),
    ] {
        assert_eq!(found(role, mm), wanted, "{role} {mm}");
    }
}

#[test]
fn two_slanting_lines_share_what_runs_within_reach() {
    // From one line to 0.3 mm beside it: within 0.16 mm for 0.16 / 0.3 of 7.6 mm.
    let report = report(&with_line([0.0, FROM], [0.3, -FROM], 1.0));
    let found = report.findings.iter().find(|f| f.text.contains("on top of")).unwrap();
    assert!((found.measured - 7.6 * 0.16 / 0.3).abs() < 0.05, "{found:?}");
    // Across all of them it is on top of none for long.
    assert!(!is_found(&super::run(&with_line([FROM, 0.4], [-FROM, 0.4], 1.0), &super::profile()), "on top of"));
}

/// Where widths and heights are stated, one line may be off by a hundredth and what its last digits tell.
#[test]
fn a_line_of_stated_width_takes_the_filament_of_the_others() {
    let found = |flow: f64| {
        let text = with_line([FROM, 0.4], [-FROM, 0.4], flow);
        let said = format!("\n;WIDTH:{WIDTH}\n;HEIGHT:{LAYER}\n");
        let lines = text.lines().map(|line| match line.starts_with(";TYPE:") {
            true => format!("{line}{said}"),
            false => format!("{line}\n"),
        });
        is_found(&report(&lines.collect::<String>()), "of a line uses")
    };
    for (flow, wanted) in [
        (1.0, false),
        (1.008, false),
        (0.992, false),
        (1.015, true),
        (0.985, true),
        (1.4, true),
        (0.6, true),
        (0.05, true),
    ] {
        assert_eq!(found(flow), wanted, "{flow}");
    }
}

/// A program whose header says more of its first print.
fn saying(text: &str, words: &str) -> String {
    let at = text.find(";TRUNNION expect print=0").unwrap();
    let end = at + text[at..].find('\n').unwrap();
    format!("{} {words}{}", &text[..end], &text[end..])
}

/// The program as if its slicer stated widths in its head alone.
fn stated(text: String) -> String {
    saying(&text, "widths_mm=0.8")
}

#[test]
fn where_only_the_head_states_widths_a_line_is_of_one_of_them_or_fills_a_gap() {
    assert!(report(&stated(program())).is_clean(), "{:#?}", report(&stated(program())).findings);
    // Across the infill, as if it led somewhere else: with a full line's filament, then with less and less.
    for (flow, found) in [(1.0, false), (0.98, true), (0.9, true), (0.5, true), (0.1, true)] {
        let report = report(&stated(with_line([FROM, 0.4], [-FROM, 0.4], flow)));
        assert_eq!(is_found(&report, "fill no gap"), found, "{flow}: {:#?}", report.findings);
    }
    // Between two lines, thin.
    let report = report(&stated(with_line([0.38, FROM], [0.38, -FROM], 0.1)));
    assert!(!is_found(&report, "fill no gap"), "{:#?}", report.findings);
}

/// The program as if its slicer, of CuraEngine 5's kind, laid each line as wide as it has room for and said so nowhere.
fn varied(text: &str) -> String {
    saying(text, "bead=varied")
}

#[test]
fn where_lines_are_as_wide_as_they_have_room_for_a_wide_one_lies_over_none() {
    let found = |text: &str| is_found(&report(&varied(text)), "fill no gap");
    // Beside the outer wall, whose middle is at X -4.6, outside of it, where nothing else is: so far away, with so much filament.
    for (away, flow, wanted) in
        [(0.95, 1.3, false), (1.2, 1.3, true), (0.6, 1.5, true), (1.0, 1.9, false), (0.8, 1.9, true)]
    {
        let x = -4.6 - away;
        assert_eq!(found(&with_line([x, FROM], [x, -FROM], flow)), wanted, "{away} {flow}");
    }
    // Across the infill beside the wall, and in the room of another.
    assert!(found(&with_line([FROM, -4.0], [-FROM, -3.6], 1.5)));
    assert!(found(&with_line([0.38, FROM], [0.38, -FROM], 1.5)));
    // A thin one is all of a wall, or shares its place with another: here is neither.
    assert!(found(&with_line([-6.2, FROM], [-6.2, -FROM], 0.4)));
}

/// The same with so much of the filament of all infill.
fn with_thin_infill(flow: f64) -> String {
    let mut is_infill = false;
    let mut print = 0;
    let mut totals = [0.0_f64; 2];
    let text = program();
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            if let Some(role) = line.strip_prefix(";TYPE:") {
                is_infill = role == "Solid infill";
            }
            print = if line.starts_with(";TRUNNION print=1") { 1 } else { print };
            let Some((head, e)) = line.split_once(" E").filter(|_| line.contains(" F1800")) else {
                return line.to_owned();
            };
            let (e, rest) = e.split_once(' ').unwrap();
            let e = e.parse::<f64>().unwrap() * if is_infill { flow } else { 1.0 };
            totals[print] += (e * 1e5).round() / 1e5;
            format!("{head} E{e:.5} {rest}")
        })
        .collect();
    let expected = |line: &String| {
        let Some((head, _)) = line.split_once(" filament_mm=") else { return line.clone() };
        format!("{head} filament_mm={:.5}", totals[usize::from(head.contains("print=1"))])
    };
    lines.iter().map(expected).collect::<Vec<_>>().join("\n") + "\n"
}

/// Where no line has a stated width, all lines of one kind may be too thin alike: no other line of the layer tells.
#[test]
fn infill_that_is_too_thin_everywhere_is_found() {
    for (flow, found) in [(1.0, false), (0.98, false), (0.94, true), (0.8, true)] {
        let report = report(&stated(with_thin_infill(flow)));
        assert_eq!(is_found(&report, "the lines of part 0 use"), found, "{flow}: {:#?}", report.findings);
    }
}

/// Lines of no known width across those of the infill, each `mm` long along it.
fn with_odd_lines(text: &str, count: usize, mm: f64) -> String {
    (0..count).fold(text.to_owned(), |text, k| {
        let (x, y) = (-3.6 + 1.8 * (k % 4) as f64, -3.4 + 0.9 * (k / 4) as f64);
        // No two are alike.
        with_line_in(&text, [x, y], [x + mm, y + 0.3], 0.3 + 0.05 * k as f64)
    })
}

#[test]
fn odd_lines_are_let_pass_where_they_are_short_and_few() {
    let found =
        |count: usize, mm: f64| is_found(&report(&stated(with_odd_lines(&program(), count, mm))), "fill no gap");
    for (mm, wanted) in [(1.9, false), (2.1, true), (4.0, true)] {
        assert_eq!(found(1, mm), wanted, "{mm}");
    }
    // An eighth of the layer's lines, some 110 mm.
    for (count, wanted) in [(4, false), (16, true)] {
        assert_eq!(found(count, 1.5), wanted, "{count}");
    }
}

#[test]
fn lines_of_two_hatches_that_meet_end_to_end_are_laid_once() {
    // Each line of the second hatch goes on where one of the first ends, 0.3 mm before that.
    let hatches = |share: f64| {
        let mut text = program();
        for (from, long) in [(-3.0, 1.5), (-1.5 - share, 1.5)] {
            for k in 0..14 {
                let x = -3.6 + 0.5 * f64::from(k);
                text = with_line_in(&text, [x, from], [x, from + long], 1.0);
            }
        }
        let report = report(&text);
        let on_top = |f: &&crate::verify::Finding| f.text.contains("on top of");
        report.findings.iter().filter(on_top).map(|f| f.measured).sum::<f64>()
    };
    // Against the infill below them both run alike.
    let (apart, met) = (hatches(-0.1), hatches(0.3));
    assert!((met - apart).abs() < 0.5, "{apart} {met}");
    assert!(hatches(1.2) > apart + 5.0, "{}", hatches(1.2));
}

/// PrusaSlicer joins rows of infill along a wall, and those of a bridge too: down a row, 0.06 mm across, and back over it.
#[test]
fn only_infill_and_bridges_turn_back_on_themselves() {
    for (role, found) in [
        ("Bridge infill", false),
        ("Solid infill", false),
        ("Internal infill", false),
        ("Perimeter", true),
        ("External perimeter", true),
    ] {
        let (down, back) = (4.1 * FLOW, 7.0 * FLOW);
        let text = program();
        let key = "expect print=0 part=0 filament_mm=";
        let at = text.find(key).unwrap() + key.len();
        let end = at + text[at..].find('\n').unwrap();
        let filament = text[at..end].parse::<f64>().unwrap() + down + back;
        let text = format!("{}{filament:.5}{}", &text[..at], &text[end..]);
        let (layer, _) = text.match_indices(&format!("G1 Z{:.3}", 22.0 * LAYER)).next().unwrap();
        let hairpin = format!(
            ";TYPE:{role}\nG1 X0.350 Y0.300 F6000\nG1 X0.350 Y-3.800 E{down:.5} F1800\nG1 X0.410 Y-3.800 E0.00100\n\
             G1 X0.410 Y3.200 E{back:.5}\n;TYPE:External perimeter\n"
        );
        let report = report(&format!("{}{hairpin}{}", &text[..layer], &text[layer..]));
        assert_eq!(is_found(&report, "on top of"), found, "{role}: {:#?}", report.findings);
    }
}
