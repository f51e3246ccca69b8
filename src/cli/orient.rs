//! `trunnion orient`

use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::args::Orient as Verb;
use super::requests::outputs;
use super::{Console, Failure};
use crate::document;
use crate::job::{self, Compared, OrientOptions, OrientRequest, Oriented, OrientedPart, Output, PartChoice};
use crate::orient::{Picture, Stop, to_angles};

pub(super) fn run(args: &Verb, console: &Console) -> Result<(), Failure> {
    let mut outputs = outputs([args.model.model.as_path()]);
    let mut claim = |path: &Option<PathBuf>| path.as_deref().map(|path| outputs.claim(path)).transpose();
    let [oriented, drawn, viewed] = [claim(&args.output)?, claim(&args.landscape)?, claim(&args.view)?];
    let only_one = [&oriented, &drawn, &viewed].into_iter().any(Option::is_some);
    let request =
        OrientRequest { model: args.model.source()?, parts: chosen(args)?, only_one, options: args.options() };
    let done = job::orient(&request, &console.world())?;
    let part = &done.parts[0];
    if let Some(output) = &oriented {
        let as_3mf = output.path().extension().is_some_and(|end| end.eq_ignore_ascii_case("3mf"));
        output.write(&done.upright(part, as_3mf))?;
    }
    let draw = |output: &Option<Output>, picture: &dyn Fn() -> Picture| -> Result<(), Failure> {
        let Some(output) = output else { return Ok(()) };
        let png = picture().png().map_err(|e| Failure::Usage(format!("{}: {e}", output.path().display())))?;
        Ok(output.write(&png)?)
    };
    draw(&drawn, &|| done.landscape(part))?;
    draw(&viewed, &|| done.view(part))?;
    if console.json() {
        let parts: Vec<Value> = done.parts.iter().map(document::oriented).collect();
        console.document(&json!({"model": args.model.model.display().to_string(), "parts": parts}));
    } else {
        console.result(&done.parts.iter().map(text).collect::<String>());
    }
    Ok(())
}

impl Verb {
    fn options(&self) -> OrientOptions {
        OrientOptions {
            objectives: self.objective.clone(),
            method: self.method.clone(),
            budget: self.budget,
            seed: self.seed,
            overhang_deg: self.overhang,
            layer_mm: self.layer,
            resolution_mm: self.resolution,
            contact_mm2: self.contact_area_min,
            compare: self.compare,
        }
    }
}

/// The parts that `--part` names: numbers and ranges, as `0,3,5-7`.
fn chosen(args: &Verb) -> Result<PartChoice, Failure> {
    let Some(text) = &args.part else { return Ok(if args.whole { PartChoice::Whole } else { PartChoice::Each }) };
    let bad = |why: &str| Failure::Usage(format!("--part {text:?}: {why}"));
    let mut wanted: Vec<RangeInclusive<usize>> = Vec::new();
    for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let (first, last) = word.split_once('-').unwrap_or((word, word));
        let number =
            |t: &str| t.trim().parse::<usize>().map_err(|_| bad(&format!("{word:?} is no part; write 0,3,5-7")));
        wanted.push(number(first)?..=number(last)?);
    }
    if wanted.iter().all(RangeInclusive::is_empty) {
        return Err(bad("names no part; write a number, or leave it out for all parts"));
    }
    Ok(PartChoice::Numbered(wanted))
}

/// Minima shown of each objective.
const SHOWN: usize = 8;

fn text(part: &OrientedPart) -> String {
    let mut out = format!("part {}, {} facets\n", part.id, part.mesh.facets().len());
    part.results.iter().for_each(|result| result_text(result, &mut out));
    part.compared.iter().for_each(|rows| table(rows, &mut out));
    out.push('\n');
    out
}

fn result_text(result: &Oriented, out: &mut String) {
    let found = &result.found;
    let proof = match found.lower_bound {
        Some(bound) => format!("proved at least {bound:.9e}{}", gap(result, bound)),
        None => result.unproved.as_ref().map_or("not proved".to_owned(), |why| format!("not proved ({why})")),
    };
    let (evaluations, seconds) = (found.evaluations, result.seconds);
    let _ = writeln!(
        out,
        "\n  {} by {}: {proof}, {evaluations} evaluations, {seconds:.2} s",
        result.objective, result.method
    );
    let _ = writeln!(out, "    value             up                              alpha     beta  deg");
    for m in found.minima.iter().take(SHOWN) {
        let (alpha, beta) = to_angles(&m.up);
        let up = format!("({:.5}, {:.5}, {:.5})", m.up.x, m.up.y, m.up.z);
        let (alpha, beta) = (alpha.to_degrees(), beta.to_degrees());
        let _ = writeln!(out, "    {:<17.9e} {up:30} {alpha:8.3} {beta:8.3}  {}", m.value + 0.0, result.kind(m));
    }
    if found.minima.len() > SHOWN {
        let _ = writeln!(out, "    and {} more; --json lists them", found.minima.len() - SHOWN);
    }
}

/// The gap in words.
fn gap(result: &Oriented, bound: f64) -> String {
    let best = result.best().value;
    let gap = if best == bound { 0.0 } else { (best - bound) / best.abs() };
    let end = if result.found.stop == Stop::Budget { ", where the budget ended" } else { "" };
    if gap.is_finite() && bound != 0.0 {
        format!(" (gap {gap:.1e}{end})")
    } else {
        format!(" (gap {:.3e}{end})", best - bound)
    }
}

fn table(rows: &[Compared], out: &mut String) {
    let wide = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let _ = write!(out, "\n  {:wide$}", "");
    rows.first().map(document::figures).into_iter().flatten().for_each(|(name, ..)| _ = write!(out, " {name:>14}"));
    for row in rows {
        let _ = write!(out, "\n  {:wide$}", row.name);
        document::figures(row).into_iter().for_each(|(.., value)| _ = write!(out, " {value:>14.4}"));
    }
    out.push('\n');
}
