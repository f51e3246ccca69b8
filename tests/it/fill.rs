//! What is inside a part is there: finished files whose insides are changed line by line, from nothing to gross, with the header's sums made to agree.
//!
//! Each change leaves outer walls, heights, travels and comments as they are, so that no sum and no comment tells of it. Of each the size from which
//! it is found is noted, and must be no more than what is stated here.

mod amounts;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

use crate::pipeline::{fixture, prepare};
use crate::support::{folder, installed, note, said, skip, soak, trunnion};

/// What a line is for, of the words of all slicers.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Outer,
    Inner,
    Solid,
    Sparse,
    Other,
}

fn kind(name: &str) -> Kind {
    match name {
        "External perimeter" | "WALL-OUTER" => Kind::Outer,
        "Perimeter" | "WALL-INNER" => Kind::Inner,
        "Solid infill" | "Top solid infill" | "SKIN" => Kind::Solid,
        "Internal infill" | "FILL" => Kind::Sparse,
        _ => Kind::Other,
    }
}

/// A printed line of a file.
struct Line {
    at: usize,
    from: [f64; 2],
    to: [f64; 2],
    e: f64,
    print: usize,
    /// Counted from the print's first, and from its last.
    layer: usize,
    from_top: usize,
    kind: Kind,
}

/// A finished file, its plan, and its printed lines.
struct Made {
    folder: tempfile::TempDir,
    lines: Vec<String>,
    plan: PathBuf,
    printed: Vec<Line>,
}

fn word(line: &str, letter: char) -> Option<f64> {
    line.split(' ').find_map(|w| w.strip_prefix(letter)?.parse().ok())
}

fn with_e(line: &str, e: f64) -> String {
    let words = line.split(' ').filter_map(|w| match w.starts_with('E') {
        true => (e > 0.0).then(|| format!("E{e:.5}")),
        false => Some(w.to_owned()),
    });
    words.collect::<Vec<_>>().join(" ")
}

impl Made {
    fn of(model: &str, slicer: &str) -> Self {
        Self::on("generic-ac", model, slicer)
    }

    fn on(machine: &str, model: &str, slicer: &str) -> Self {
        let folder = folder();
        let (file, plan) = (folder.path().join("whole.gcode"), folder.path().join("plan.json"));
        let document = prepare(&fixture(model), machine, slicer, &file, &["--plan-out", &plan.display().to_string()]);
        assert_eq!(document["verify"]["findings"], serde_json::json!([]), "{model}, {slicer}");
        let lines: Vec<String> = std::fs::read_to_string(&file).unwrap().lines().map(str::to_owned).collect();
        let printed = printed(&lines);
        Self { folder, lines, plan, printed }
    }

    fn layers(&self, print: usize) -> usize {
        self.printed.iter().filter(|line| line.print == print).map(|line| line.layer + 1).max().unwrap()
    }

    /// The file with each line's filament times `factor`.
    fn scaled(&self, factor: impl Fn(&Line) -> f64) -> Vec<String> {
        let (mut lines, mut more) = (self.lines.clone(), BTreeMap::new());
        for line in &self.printed {
            let e = line.e * factor(line);
            lines[line.at] = with_e(&lines[line.at], e);
            *more.entry(line.print).or_insert(0.0) += word(&lines[line.at], 'E').unwrap_or(0.0) - line.e;
        }
        agreed(lines, &more)
    }

    /// The file with a slit `mm` wide through one outer wall of each layer, at one place.
    fn slit(&self, mm: f64) -> Vec<String> {
        let (mut lines, mut more) = (self.lines.clone(), BTreeMap::new());
        let mut last = None;
        for line in self.printed.iter().filter(|line| line.kind == Kind::Outer) {
            let [dx, dy] = [line.to[0] - line.from[0], line.to[1] - line.from[1]];
            let length = dx.hypot(dy);
            let one = dx > 0.9 * length || (dx.abs() <= 0.9 * length && dy > 0.9 * length);
            if length < 8.0 || !one || last == Some((line.print, line.layer)) {
                continue;
            }
            last = Some((line.print, line.layer));
            let end = |share: f64| format!("G1 X{:.3} Y{:.3}", line.from[0] + dx * share, line.from[1] + dy * share);
            let (from, to) = ((length - mm) / 2.0 / length, (length + mm) / 2.0 / length);
            let e = [from, 1.0 - to].map(|share| format!("{:.5}", line.e * share));
            lines[line.at] = format!("{} E{}\n{}\n{} E{}", end(from), e[0], end(to), end(1.0), e[1]);
            let laid: f64 = e.iter().map(|e| e.parse::<f64>().unwrap()).sum();
            *more.entry(line.print).or_insert(0.0) += laid - line.e;
        }
        agreed(lines, &more)
    }

    /// The findings of a rule in a changed file, with their sentences.
    fn findings(&self, lines: &[String], rule: &str) -> Vec<String> {
        let report = self.report(lines);
        let found = report["findings"].as_array().unwrap().iter().filter(|finding| finding["rule"] == rule);
        found.map(|finding| finding["text"].as_str().unwrap().to_owned()).collect()
    }

    fn report(&self, lines: &[String]) -> Value {
        let file = self.folder.path().join("changed.gcode");
        std::fs::write(&file, lines.join("\n")).unwrap();
        let run = trunnion().arg("verify").arg(file).arg("--plan").arg(&self.plan).arg("--json").output().unwrap();
        assert!(matches!(run.status.code(), Some(0 | 1)), "{}", said(&run));
        serde_json::from_slice(&run.stdout).unwrap()
    }

    /// The least size at which a change is found, of `sizes` from small to gross; all above it must be found too, and those from `must` on.
    fn swept(
        &self,
        (what, rule): (&str, &str),
        sizes: &[f64],
        must: f64,
        changed: impl Fn(f64) -> Vec<String>,
    ) -> String {
        let mut from = None;
        // In the suite the least that must be found and the grossest; all in a soak.
        let least = sizes.iter().copied().filter(|size| *size >= must).fold(f64::INFINITY, f64::min);
        let grossest = sizes.iter().copied().fold(0.0, f64::max);
        let asked = |size: &f64| soak().is_some() || *size == least || *size == grossest;
        for size in sizes.iter().copied().filter(asked) {
            let lines = changed(size);
            assert_ne!(lines, self.lines, "{what}, {size}: nothing was changed");
            let found = self.findings(&lines, rule);
            assert!(from.is_none() || !found.is_empty(), "{what}: found at {from:?}, and not at {size}");
            assert!(size < must || !found.is_empty(), "{what}: {size} is not found");
            from = from.or_else(|| (!found.is_empty()).then_some(size));
        }
        format!("{what}: from {} on", from.unwrap())
    }
}

/// The header's sums, made to agree.
fn agreed(mut lines: Vec<String>, more: &BTreeMap<usize, f64>) -> Vec<String> {
    for line in lines.iter_mut().filter(|line| line.starts_with(";TRUNNION expect ")) {
        let value = |key: &str| line.split(' ').find_map(|w| w.strip_prefix(key)).unwrap().to_owned();
        let (print, mm) = (value("print=").parse::<usize>().unwrap(), value("filament_mm="));
        let sum = mm.parse::<f64>().unwrap() + more.get(&print).unwrap_or(&0.0);
        *line = line.replace(&format!("filament_mm={mm}"), &format!("filament_mm={sum:.5}"));
    }
    lines
}

fn printed(lines: &[String]) -> Vec<Line> {
    let (mut at, mut z, mut print, mut role) = ([0.0; 2], 0.0, None, Kind::Other);
    let (mut all, mut heights) = (Vec::new(), Vec::new());
    for (index, line) in lines.iter().enumerate() {
        if let Some(name) = line.strip_prefix(";TYPE:") {
            role = kind(name);
        } else if let Some(rest) = line.strip_prefix(";TRUNNION print=") {
            print = rest.split(' ').next().unwrap().parse::<usize>().ok();
        } else if line.starts_with(";TRUNNION end") {
            print = None;
        }
        if !line.starts_with("G1 ") && !line.starts_with("G0 ") {
            continue;
        }
        let to = [word(line, 'X').unwrap_or(at[0]), word(line, 'Y').unwrap_or(at[1])];
        z = word(line, 'Z').unwrap_or(z);
        if let (Some(print), Some(e)) = (print, word(line, 'E').filter(|e| *e > 0.0))
            && to != at
        {
            all.push(Line { at: index, from: at, to, e, print, layer: 0, from_top: 0, kind: role });
            heights.push(z);
        }
        at = to;
    }
    let mut by_print: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (line, z) in all.iter().zip(&heights) {
        by_print.entry(line.print).or_default().push(*z);
    }
    for of in by_print.values_mut() {
        of.sort_by(f64::total_cmp);
        of.dedup();
    }
    for (line, z) in all.iter_mut().zip(&heights) {
        let of = &by_print[&line.print];
        line.layer = of.partition_point(|height| height < z);
        line.from_top = of.len() - 1 - line.layer;
    }
    all
}

/// One in how many of a kind's lines, by their place in the file.
fn one_in(line: &Line, count: f64) -> bool {
    (line.at as f64).rem_euclid(count) < 1.0
}

/// Every change of the inside of an upright print and two that are tilted by 45 degrees.
fn insides(slicer: &str) {
    let made = Made::of("y-tree", slicer);
    let outer = |line: &Line| line.kind == Kind::Outer;
    let kept = |keep: bool| if keep { 1.0 } else { 0.0 };
    let middle = made.layers(0) / 2;
    let fill = |what: &'static str| (what, "fill");
    let mut table = vec![format!("{slicer}:")];
    // The joints of both tilted prints: every so many lines but the outer wall are gone, down to all of them.
    table.push(made.swept(
        fill("share of a joint's first layer gone"),
        &[0.02, 0.05, 0.1, 0.2, 0.5, 1.0],
        0.2,
        |share| {
            made.scaled(|line| kept(line.print == 0 || line.layer > 0 || outer(line) || !one_in(line, 1.0 / share)))
        },
    ));
    table.push(made.swept(fill("first layer thinner by a share"), &[0.05, 0.1, 0.15, 0.2, 0.5], 0.2, |share| {
        made.scaled(|line| if line.layer == 0 && line.kind == Kind::Solid { 1.0 - share } else { 1.0 })
    }));
    table.push(made.swept(fill("top skin thinner by a share"), &[0.05, 0.1, 0.15, 0.2, 0.5, 1.0], 0.2, |share| {
        made.scaled(|line| if line.from_top == 0 && !outer(line) { 1.0 - share } else { 1.0 })
    }));
    table.push(made.swept(fill("share of all solid lines gone"), &[0.05, 0.1, 0.2, 0.5, 1.0], 0.2, |share| {
        made.scaled(|line| kept(line.kind != Kind::Solid || !one_in(line, 1.0 / share)))
    }));
    table.push(made.swept(fill("layers without inner walls"), &[1.0, 2.0, 5.0, 40.0], 1.0, |count| {
        let within = |line: &Line| line.layer >= middle && line.layer < middle + count as usize;
        made.scaled(|line| kept(line.kind != Kind::Inner || line.print != 0 || !within(line)))
    }));
    table.push(
        made.swept(fill("slit through each layer's outer wall, mm"), &[0.3, 0.6, 0.9, 1.3, 2.9], 1.3, |mm| {
            made.slit(mm)
        }),
    );
    note(&table.join("\n  "));
}

#[test]
fn inside_of_the_built_in_slicers_parts() {
    insides("builtin");
}

#[test]
fn inside_of_prusa_slicers_parts() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed: the insides of its parts are not changed");
    }
    insides("prusa-slicer");
}

#[test]
fn inside_of_cura_engines_parts() {
    if crate::cura_engine::is_there() {
        insides("cura");
    }
}

/// Infill that stops for some layers is found where lines above it lie in mid-air; where it is only next to nothing, by what it holds.
#[test]
fn infill_that_stops_for_some_layers() {
    let made = Made::of("bracket", "builtin");
    let middle = made.layers(0) / 2;
    let text = made.swept(("layers with a tenth of their infill", "fill"), &[1.0, 2.0, 4.0, 8.0, 16.0], 8.0, |count| {
        let within = |line: &Line| line.layer >= middle && line.layer < middle + count as usize;
        made.scaled(|line| if line.kind == Kind::Sparse && within(line) { 0.1 } else { 1.0 })
    });
    note(&text);
}

/// Who wants no tops says so in the profile; the finding tells how.
#[test]
fn tops_that_are_left_out_are_found_with_the_way_to_have_none() {
    let made = Made::of("two-boxes", "builtin");
    let is_top = |line: &Line| line.kind == Kind::Solid && line.from_top == 0;
    let found = made.findings(&made.scaled(|line| if is_top(line) { 0.0 } else { 1.0 }), "fill");
    assert!(found.iter().any(|text| text.contains("[process] top_layers = 0")), "{found:?}");
    let profile = made.folder.path().join("open.toml");
    std::fs::write(&profile, "extends = \"generic-ac\"\n[process]\ntop_layers = 0\n").unwrap();
    let out = made.folder.path().join("open.gcode");
    let document = prepare(&fixture("two-boxes"), &profile.display().to_string(), "builtin", &out, &[]);
    assert_eq!(document["verify"]["findings"], serde_json::json!([]));
}

/// What is pushed while the nozzle stands, and what primes lack: no single one is too much, and together they are.
#[test]
fn sums_of_primes_never_forget() {
    let made = Made::of("two-boxes", "builtin");
    let filament: f64 = made.printed.iter().map(|line| line.e).sum();
    let mut table = vec![format!("{filament:.0} mm of filament")];
    let standing = [("pushes of 0.29 mm", "G1 E0.29 F1800"), ("primes 0.29 mm short", "G1 E-1 F1800\nG1 E0.71 F1800")];
    for (what, words) in standing {
        let must = (0.03 * filament / 0.29).ceil() + 1.0;
        table.push(made.swept((what, "retract"), &[5.0, 50.0, 200.0, must, 2.0 * must], must, |count| {
            let mut lines = made.lines.clone();
            for line in made.printed.iter().skip(1).take(count as usize) {
                lines[line.at] = format!("{words}\n{} F1800", lines[line.at]);
            }
            lines
        }));
    }
    note(&table.join("\n  "));
}
