//! `trunnion inspect`

use std::fmt::Write;

use super::args::Inspect;
use super::{Console, Failure};
use crate::mesh::Model;
use crate::spelling::counted;
use crate::{document, job};

pub(super) fn run(args: &Inspect, console: &Console) -> Result<(), Failure> {
    let loaded = job::load_model(&args.model.source()?, &console.world())?;
    if console.json() {
        console.document(&document::inspected(&loaded.model));
    } else {
        console.result(&text(&loaded.model));
    }
    Ok(())
}

fn text(model: &Model) -> String {
    let mut out = String::new();
    let size = model.bounds.size();
    let _ = writeln!(
        out,
        "{}, {:.2} x {:.2} x {:.2} mm, read in {}",
        counted(model.parts.len(), "part"),
        size.x,
        size.y,
        size.z,
        model.unit.short()
    );
    let _ = writeln!(out, "\npart  facets  volume mm3   area mm2  size mm                 name");
    for p in &model.parts {
        let s = p.mesh.bounds().size();
        let size = format!("{:.2} x {:.2} x {:.2}", s.x, s.y, s.z);
        let (volume, area) = (p.mesh.volume(), p.mesh.area());
        let _ = writeln!(out, "{:4} {:7} {volume:11.1} {area:10.1}  {size:23} {}", p.id, p.mesh.facets().len(), p.name);
    }
    let _ = writeln!(out, "\non the table: {}", list(&model.on_table));
    for i in &model.interfaces {
        let _ = writeln!(out, "parts {} and {} share {:.2} mm2", i.a, i.b, i.area_mm2);
    }
    if !model.floating().is_empty() {
        let _ = writeln!(out, "touching nothing that stands: {}", list(&model.floating()));
    }
    out
}

fn list(parts: &[usize]) -> String {
    parts.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
