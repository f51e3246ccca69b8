//! `trunnion orient`

mod asked;
mod compare;
mod outcome;

use std::path::PathBuf;

use serde_json::{Value, json};

use super::args::{ModelArgs, Orient};
use super::requests::outputs;
use super::{Console, Failure};
use crate::geom::{Object, Slot, Vec3};
use crate::job::{self, Disk, Files, Output, Progress};
use crate::mesh::{Fault, ReadOptions, TriangleMesh, Unit, read_surface, stl_binary, threemf};
use crate::orient::{Facets, Paint, landscape, turned, view};
use asked::Asked;
use outcome::Done;

pub(super) fn run(args: &Orient, console: &Console) -> Result<(), Failure> {
    let asked = Asked::of(args)?;
    let mut outputs = outputs([args.model.model.as_path()]);
    let mut claim = |path: &Option<PathBuf>| path.as_deref().map(|path| outputs.claim(path)).transpose();
    let wanted = [claim(&args.output)?, claim(&args.landscape)?, claim(&args.view)?];
    let parts = chosen(args, parts(args, &asked, console)?)?;
    if wanted.iter().any(Option::is_some) && parts.len() != 1 {
        let text = format!(
            "-o, --landscape and --view are of one part, and there are {}; choose one with --part N, or take all as one with --whole",
            parts.len()
        );
        return Err(Failure::Usage(text));
    }
    let progress = console.begin("orienting", parts.len() * asked.objectives.len());
    let mut done = Vec::new();
    for (id, mesh) in &parts {
        let facets = Facets::of(mesh);
        if facets.each.is_empty() {
            return Err(without_area(*id, mesh));
        }
        let mut results = Vec::new();
        for f in &asked.objectives {
            results.push(asked.result(f.as_ref(), &facets)?);
            progress.at(done.len() * asked.objectives.len() + results.len());
        }
        let compared = args.compare.then(|| compare::table(&facets, &results, &asked.settings));
        done.push(Done { id: *id, facets: mesh.facets().len(), results, compared });
    }
    drop(progress);
    if let [(id, mesh)] = &parts[..] {
        write_all(&wanted, &asked, (*id, mesh), &done[0])?;
    }
    if console.json() {
        let parts: Vec<Value> = done.iter().map(Done::document).collect();
        console.document(&json!({"model": args.model.model.display().to_string(), "parts": parts}));
    } else {
        console.result(&done.iter().map(Done::text).collect::<String>());
    }
    Ok(())
}

fn without_area(id: usize, mesh: &TriangleMesh<Object>) -> Failure {
    let count = mesh.facets().len();
    Failure::Usage(format!(
        "part {id}: none of its {count} facets has an area, so no direction is better than another; export the model again"
    ))
}

/// The oriented part and the pictures that are asked for, of the first objective.
fn write_all(
    [oriented, drawn, viewed]: &[Option<Output>; 3],
    asked: &Asked,
    (id, mesh): (usize, &TriangleMesh<Object>),
    done: &Done,
) -> Result<(), Failure> {
    let (f, found) = (asked.objectives[0].as_ref(), &done.results[0].found);
    let up = found.minima[0].up;
    if let Some(output) = oriented {
        write(output, id, mesh, &up)?;
    }
    let facets = Facets::of(mesh);
    let picture = |output: &Output, picture: crate::orient::Picture| -> Result<(), Failure> {
        let bytes = picture.png().map_err(|e| Failure::Usage(format!("{}: {e}", output.path().display())))?;
        Ok(output.write(&bytes)?)
    };
    if let Some(output) = drawn {
        picture(output, landscape(f, &facets, &found.minima))?;
    }
    if let Some(output) = viewed {
        let costs = f.by_facet(&facets, &up);
        let overhang = asked.settings.overhang;
        let paint = costs.as_ref().map_or(Paint::Overhangs(overhang), |costs| Paint::Costs(costs, overhang));
        picture(output, view(&facets, &up, paint))?;
    }
    Ok(())
}

type Numbered = (usize, TriangleMesh<Object>);

/// The model's closed parts; or its open surface as one, where no volume is asked for.
fn parts(args: &Orient, asked: &Asked, console: &Console) -> Result<Vec<Numbered>, Failure> {
    let error = match args.model.source().and_then(|source| Ok(job::load_model(&source, &console.world())?)) {
        Ok(loaded) if args.whole => return Ok(vec![(0, joined(loaded.model.parts.iter().map(|part| &part.mesh)))]),
        Ok(loaded) => return Ok(loaded.model.parts.into_iter().map(|part| (part.id, part.mesh)).collect()),
        Err(error) => error,
    };
    let open = matches!(&error, Failure::Job(job::Error::Mesh(e)) if matches!(e.fault, Fault::Open { .. } | Fault::Winding { .. }));
    if !open || args.compare {
        return Err(error);
    }
    if let Some(f) = asked.objectives.iter().find(|f| f.needs_closed()) {
        return Err(Failure::Usage(format!(
            "{error}; {} is a volume or needs an inside, so the mesh must be closed",
            f.name()
        )));
    }
    console.warning(&format!("{error}: taken as one surface, since no volume is asked for"));
    surface(&args.model).map(|mesh| vec![(0, mesh)])
}

fn surface(args: &ModelArgs) -> Result<TriangleMesh<Object>, Failure> {
    let unit = args.unit.as_deref().map(str::parse::<Unit>).transpose().map_err(|e| Failure::Usage(e.to_string()))?;
    let bytes = Disk.read(&args.model)?;
    Ok(read_surface(&bytes, &args.model.display().to_string(), &ReadOptions { unit, repair: false })?)
}

/// All parts as one mesh.
fn joined<'a>(parts: impl Iterator<Item = &'a TriangleMesh<Object>>) -> TriangleMesh<Object> {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    for part in parts {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(part.vertices());
        facets.extend(part.facets().iter().map(|facet| facet.map(|i| i + first)));
    }
    TriangleMesh::new(vertices, facets)
}

/// The parts that `--part` names: numbers and ranges, as `0,3,5-7`.
fn chosen(args: &Orient, mut parts: Vec<Numbered>) -> Result<Vec<Numbered>, Failure> {
    let Some(text) = &args.part else { return Ok(parts) };
    let bad = |why: String| Failure::Usage(format!("--part {text:?}: {why}"));
    let mut wanted = Vec::new();
    for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let (first, last) = word.split_once('-').unwrap_or((word, word));
        let number =
            |t: &str| t.trim().parse::<usize>().map_err(|_| bad(format!("{word:?} is no part; write 0,3,5-7")));
        wanted.push(number(first)?..=number(last)?);
    }
    if wanted.iter().all(|range| range.is_empty()) {
        return Err(bad("names no part; write a number, or leave it out for all parts".to_owned()));
    }
    let last = parts.len() - 1;
    if let Some(range) = wanted.iter().find(|range| *range.end() > last) {
        return Err(bad(format!(
            "{} is out of range: {} has parts 0..{last}",
            range.end(),
            args.model.model.display()
        )));
    }
    parts.retain(|(id, _)| wanted.iter().any(|range| range.contains(id)));
    Ok(parts)
}

/// The part with `up` turned to +Z and its lowest point at z = 0.
fn write(output: &Output, id: usize, mesh: &TriangleMesh<Object>, up: &Vec3) -> Result<(), Failure> {
    let mesh: TriangleMesh<Slot> = turned(mesh, up);
    let is_3mf = output.path().extension().is_some_and(|end| end.eq_ignore_ascii_case("3mf"));
    let bytes = if is_3mf { threemf(&[(format!("part-{id}"), &mesh)]) } else { stl_binary(&mesh) };
    Ok(output.write(&bytes)?)
}
