//! `trunnion orient`

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::args::{ModelArgs, Orient};
use super::{Console, Failure, files, load};
use crate::geom::{Angle, Object, Slot, Vec3};
use crate::mesh::{Fault, ReadOptions, TriangleMesh, Unit, read_surface, stl_binary, threemf};
use crate::orient::{
    Certified, Direct, Facets, Found, Grid, Minimum, Multistart, NelderMead, Objective, Search, Settings, has_bounds,
    nearest, objective, to_angles, turned,
};

const METHODS: [&str; 5] = ["certified", "multistart", "nelder-mead", "direct", "grid"];
/// Fewer evaluations than this say nothing of a whole sphere.
const LEAST_BUDGET: usize = 100;
/// Minima whose values agree to this, relative, are the same: the gap to which the best is proved.
const SAME_VALUE: f64 = 1e-6;

pub(super) fn run(args: &Orient, console: &Console) -> Result<(), Failure> {
    let asked = Asked::of(args)?;
    let parts = chosen(parts(args, &asked, console)?, args.part, &args.model.model)?;
    if args.output.is_some() && parts.len() != 1 {
        let text = format!("-o writes one part, and there are {}; choose one with --part N", parts.len());
        return Err(Failure::Usage(text));
    }
    let progress = console.progress("orienting", parts.len() * asked.objectives.len());
    let mut done = Vec::new();
    for (id, mesh) in &parts {
        let facets = Facets::of(mesh);
        let results = asked.objectives.iter().map(|f| {
            let result = asked.result(f.as_ref(), &facets, console);
            progress.at(done.len() * asked.objectives.len() + 1);
            result
        });
        done.push(Done { id: *id, facets: mesh.facets().len(), results: results.collect() });
    }
    drop(progress);
    if let (Some(path), [(id, mesh)]) = (&args.output, &parts[..]) {
        write(path, *id, mesh, &done[0].results[0].best().up)?;
    }
    if console.json() {
        let parts: Vec<Value> = done.iter().map(Done::document).collect();
        console.document(&json!({"model": args.model.model.display().to_string(), "parts": parts}));
    } else {
        console.result(&done.iter().map(Done::text).collect::<String>());
    }
    Ok(())
}

/// What the flags ask for, checked.
struct Asked {
    objectives: Vec<Box<dyn Objective>>,
    method: &'static str,
    budget: Option<usize>,
    seed: u64,
}

impl Asked {
    fn of(args: &Orient) -> Result<Self, Failure> {
        let out_of = |flag: &str, value: f64, range: &str| Failure::Usage(format!("{flag} {value} is out of {range}"));
        if !(0.0..90.0).contains(&args.overhang) {
            return Err(out_of("--overhang", args.overhang, "0..90 deg"));
        }
        if !(0.001..=10.0).contains(&args.layer) {
            return Err(out_of("--layer", args.layer, "0.001..10 mm"));
        }
        if let Some(budget) = args.budget.filter(|&budget| budget < LEAST_BUDGET) {
            let text = format!("--budget {budget} is too few evaluations; give at least {LEAST_BUDGET}");
            return Err(Failure::Usage(text));
        }
        let method = METHODS.into_iter().find(|name| *name == args.method).ok_or_else(|| {
            let near = nearest(&args.method, &METHODS);
            let all = METHODS.join(", ");
            Failure::Usage(format!("--method {}: did you mean {near}? this version knows {all}", args.method))
        })?;
        let overhang = Angle::from_deg(args.overhang);
        let settings = Settings { layer_mm: args.layer, overhang, ..Settings::default() };
        let made = args.objective.iter().map(|text| objective(text, &settings));
        let objectives =
            made.collect::<Result<Vec<_>, _>>().map_err(|e| Failure::Usage(format!("--objective: {e}")))?;
        Ok(Self { objectives, method, budget: args.budget, seed: args.seed })
    }

    /// The search for `f`, and its name: `certified` only where there is something to prove with.
    fn search(&self, f: &dyn Objective, facets: &Facets, console: &Console) -> (Box<dyn Search>, &'static str) {
        let budget = |own: usize| self.budget.unwrap_or(own);
        let (walks, simplices, proof) = (Multistart::default(), NelderMead::default(), Certified::default());
        let search: Box<dyn Search> = match self.method {
            "multistart" => {
                let budget = (budget(walks.budget * walks.starts) / walks.starts).max(3);
                Box::new(Multistart { budget, seed: self.seed, ..walks })
            }
            "direct" => Box::new(Direct { budget: budget(Direct::default().budget) }),
            "grid" => Box::new(Grid { budget: budget(Grid::default().budget) }),
            "certified" if has_bounds(f, facets) => Box::new(Certified { budget: budget(proof.budget), ..proof }),
            _ => Box::new(NelderMead { budget: budget(simplices.budget), ..simplices }),
        };
        if search.name() != self.method {
            let (name, used) = (f.name(), search.name());
            console.warning(&format!("{name}: this version has no proof for it; searched by {used}"));
        }
        let name = search.name();
        (search, name)
    }

    fn result(&self, f: &dyn Objective, facets: &Facets, console: &Console) -> Outcome {
        let start = Instant::now();
        let (search, method) = self.search(f, facets, console);
        let found = search.search(f, facets).with_dips(f, facets);
        Outcome { objective: f.name().to_owned(), method, found, seconds: start.elapsed().as_secs_f64() }
    }
}

type Numbered = (usize, TriangleMesh<Object>);

/// The model's closed parts; or its open surface as one, where no volume is asked for.
fn parts(args: &Orient, asked: &Asked, console: &Console) -> Result<Vec<Numbered>, Failure> {
    let error = match load::model(&args.model, console) {
        Ok(loaded) => return Ok(loaded.model.parts.into_iter().map(|part| (part.id, part.mesh)).collect()),
        Err(error) => error,
    };
    let open = matches!(&error, Failure::Mesh(e) if matches!(e.fault, Fault::Open { .. } | Fault::Winding { .. }));
    if !open || asked.objectives.iter().any(|f| f.name().contains("support-volume")) {
        return Err(error);
    }
    console.warning(&format!("{error}: taken as one surface, since no volume is asked for"));
    surface(&args.model).map(|mesh| vec![(0, mesh)])
}

fn surface(args: &ModelArgs) -> Result<TriangleMesh<Object>, Failure> {
    let unit = args.unit.as_deref().map(str::parse::<Unit>).transpose().map_err(|e| Failure::Usage(e.to_string()))?;
    let bytes = files::read(&args.model)?;
    Ok(read_surface(&bytes, &args.model.display().to_string(), &ReadOptions { unit, repair: false })?)
}

fn chosen(mut parts: Vec<Numbered>, part: Option<usize>, model: &Path) -> Result<Vec<Numbered>, Failure> {
    let count = parts.len();
    if let Some(wanted) = part {
        parts.retain(|(id, _)| *id == wanted);
    }
    if parts.is_empty() {
        let (last, wanted) = (count.saturating_sub(1), part.unwrap_or(0));
        let text = format!("--part {wanted} is out of range: {} has parts 0..{last}", model.display());
        return Err(Failure::Usage(text));
    }
    Ok(parts)
}

/// The part with `up` turned to +Z and its lowest point at z = 0.
fn write(path: &Path, id: usize, mesh: &TriangleMesh<Object>, up: &Vec3) -> Result<(), Failure> {
    let mesh: TriangleMesh<Slot> = turned(mesh, up);
    let is_3mf = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("3mf"));
    let bytes = if is_3mf { threemf(&[(format!("part-{id}"), &mesh)]) } else { stl_binary(&mesh) };
    files::write(path, &bytes)
}

struct Outcome {
    objective: String,
    method: &'static str,
    found: Found,
    seconds: f64,
}

impl Outcome {
    fn best(&self) -> &Minimum {
        &self.found.minima[0]
    }

    fn kind(&self, minimum: &Minimum) -> &'static str {
        let best = self.best().value;
        if minimum.value <= best + SAME_VALUE * best.abs() { "global" } else { "local" }
    }

    fn document(&self) -> Value {
        let minimum = |m: &Minimum| {
            let (alpha, beta) = to_angles(&m.up);
            json!({
                "value": m.value, "up": m.up.as_slice(), "kind": self.kind(m),
                "alpha_deg": alpha.to_degrees(), "beta_deg": beta.to_degrees(),
            })
        };
        json!({
            "objective": self.objective, "method": self.method,
            "minima": self.found.minima.iter().map(minimum).collect::<Vec<_>>(),
            "lower_bound": self.found.lower_bound, "evaluations": self.found.evaluations, "seconds": self.seconds,
        })
    }

    fn text(&self, out: &mut String) {
        let proof = match self.found.lower_bound {
            Some(bound) => format!("proved at least {bound:.9e}"),
            None => "not proved".to_owned(),
        };
        let (evaluations, seconds) = (self.found.evaluations, self.seconds);
        let _ = writeln!(
            out,
            "\n  {} by {}: {proof}, {evaluations} evaluations, {seconds:.2} s",
            self.objective, self.method
        );
        let _ = writeln!(out, "    value             up                              alpha     beta  deg");
        for m in self.found.minima.iter().take(SHOWN) {
            let (alpha, beta) = to_angles(&m.up);
            let up = format!("({:.5}, {:.5}, {:.5})", m.up.x, m.up.y, m.up.z);
            let (alpha, beta) = (alpha.to_degrees(), beta.to_degrees());
            let _ = writeln!(out, "    {:<17.9e} {up:30} {alpha:8.3} {beta:8.3}  {}", m.value, self.kind(m));
        }
        if self.found.minima.len() > SHOWN {
            let _ = writeln!(out, "    and {} more; --json lists them", self.found.minima.len() - SHOWN);
        }
    }
}

/// Minima shown of each objective.
const SHOWN: usize = 8;

struct Done {
    id: usize,
    facets: usize,
    results: Vec<Outcome>,
}

impl Done {
    fn document(&self) -> Value {
        let results: Vec<Value> = self.results.iter().map(Outcome::document).collect();
        json!({"id": self.id, "facets": self.facets, "results": results})
    }

    fn text(&self) -> String {
        let mut out = format!("part {}, {} facets\n", self.id, self.facets);
        self.results.iter().for_each(|result| result.text(&mut out));
        out.push('\n');
        out
    }
}
