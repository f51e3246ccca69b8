//! Reading and rewriting a large sliced file: megabytes of input a second, and the memory taken beside it.
//!
//! `cargo bench -p trunnion-benches --bench gcode`; `TRUNNION_BENCH_MB` is the size of the file (200). It is a toothed prism at fine layers: the
//! built-in slicer makes some, and those are repeated further up. Every figure is the best of five runs, so that ratios of
//! one run can be compared.

use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

use trunnion::gcode::{ParsedLine, lines};
use trunnion::mesh::{Model, ReadOptions, read_model};
use trunnion::planning::{MachineRef, ModelRef, PartRef, Plan, Print, TimeSlot, Workpiece};
use trunnion::profile::{Profile, resolve, shipped};
use trunnion::slicing::{Adhesion, BuiltIn, SliceJob, Slicer};
use trunnion::toolpath::{Input, InputWords, RewriteJob, read_sliced, rewrite, slot_mesh};

const BED: [f64; 2] = [250.0, 250.0];
const MIDDLE: [f64; 2] = [BED[0] / 2.0, BED[1] / 2.0];
const LAYER_MM: f64 = 0.05;
/// Corners of the outline.
const CORNERS: usize = 1800;
/// Layers that are really sliced, and of those the ones that are repeated: behind the solid bottom, before the solid top.
const SLICED: u32 = 16;
const REPEATED: std::ops::Range<usize> = 6..10;

/// A prism of `height` mm with teeth, 80 mm across, as binary STL.
fn prism(height: f64) -> Vec<u8> {
    let point = |i: usize| {
        let (angle, radius) =
            ((i % CORNERS) as f64 / CORNERS as f64 * std::f64::consts::TAU, 40.0 - (i % 4 / 2) as f64);
        [(radius * angle.cos()) as f32, (radius * angle.sin()) as f32]
    };
    let mut bytes = vec![b' '; 80];
    bytes.extend_from_slice(&(4 * CORNERS as u32).to_le_bytes());
    let mut facet = |corners: [([f32; 2], f32); 3]| {
        bytes.extend_from_slice(&[0; 12]);
        corners.iter().flat_map(|(p, z)| [p[0], p[1], *z]).for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
        bytes.extend_from_slice(&[0; 2]);
    };
    let top = height as f32;
    for i in 0..CORNERS {
        let (a, b, middle) = (point(i), point(i + 1), [0.0; 2]);
        facet([(middle, 0.0), (b, 0.0), (a, 0.0)]);
        facet([(middle, top), (a, top), (b, top)]);
        facet([(a, 0.0), (b, 0.0), (b, top)]);
        facet([(a, 0.0), (b, top), (a, top)]);
    }
    bytes
}

fn print() -> Print {
    Print { part: 0, up: [0.0, 0.0, 1.0], tilt_deg: 0.0, rotation_deg: 0.0, supports: None }
}

/// What the built-in slicer makes of the model in `stl`.
fn sliced(stl: &[u8], profile: &Profile) -> String {
    let model = read_model(stl, "prism.stl", &ReadOptions::default()).expect("reads");
    let workpiece = Workpiece::place(&model, &Workpiece::centred(&model));
    let mesh = slot_mesh(&workpiece, &profile.kinematics(), &print(), MIDDLE);
    let job =
        SliceJob { name: "print-00-prism".to_owned(), on_table: true, bed_mm: BED, adhesion: Adhesion::default() };
    String::from_utf8(BuiltIn.slice(&mesh.mesh, &profile.process, &job).expect("slices").gcode).expect("text")
}

/// `text` with its middle layers repeated until it is as large as `bytes`, and how many layers that are.
fn repeated(text: &str, bytes: f64) -> (Vec<u8>, u32) {
    const LAYER: &str = ";LAYER_CHANGE\n";
    let mut layers: Vec<&str> = text.split(LAYER).collect();
    let head = layers.remove(0);
    let (last, tail) = layers.pop().and_then(|last| last.split_once("; filament used")).expect("a last layer");
    layers.push(last);
    let block: usize = layers[REPEATED].iter().map(|layer| LAYER.len() + layer.len()).sum();
    let times = ((bytes - text.len() as f64) / block as f64).ceil().max(0.0) as usize;
    let repeats = layers[REPEATED].iter().cycle().take(times * REPEATED.len());
    let (below, above) = layers.split_at(REPEATED.end);
    let all: Vec<&str> = below.iter().chain(repeats).chain(above).copied().collect();
    let (mut out, mut filament) = (head.to_owned(), 0.0);
    for (index, layer) in all.iter().enumerate() {
        out += LAYER;
        let z = (index + 1) as f64 * LAYER_MM;
        for line in layer.lines() {
            let was: Option<f64> = line.strip_prefix("G1 Z").and_then(|l| l.split(' ').next()?.parse().ok());
            match (was, line.starts_with(";Z:")) {
                (Some(_), _) => out += &format!("G1 Z{z:.3}{}\n", line.find(" F").map_or("", |f| &line[f..])),
                (None, true) => out += &format!(";Z:{z}\n"),
                (None, false) => out.extend([line, "\n"]),
            }
            let e = line.contains('X').then(|| line.split_once(" E")?.1.parse::<f64>().ok()).flatten();
            filament += e.unwrap_or(0.0).max(0.0);
        }
    }
    let settings = tail.split_once('\n').map_or("", |(_, rest)| rest);
    out += &format!("; filament used [mm] = {filament:.2}\n{settings}");
    (out.into_bytes(), all.len() as u32)
}

struct Made {
    profile: Profile,
    model: Model,
    plan: Plan,
    sliced: Vec<u8>,
}

impl Made {
    fn new(megabytes: f64) -> Self {
        let (file, text) = shipped("generic-ac").expect("shipped");
        let mut profile = resolve(file, text).expect("resolves").0;
        profile.process.layer_height_mm = LAYER_MM;
        let short = sliced(&prism(f64::from(SLICED) * LAYER_MM), &profile);
        let (sliced, layers) = repeated(&short, megabytes * 1e6);
        let height = f64::from(layers) * LAYER_MM;
        let model = read_model(&prism(height), "prism.stl", &ReadOptions::default()).expect("reads");
        let (placement, print) = (Workpiece::centred(&model), print());
        let plan = Plan {
            format: Plan::FORMAT.to_owned(),
            version: Plan::VERSION,
            made_by: String::new(),
            model: ModelRef { file: String::new(), sha256: String::new(), unit: "mm".to_owned() },
            machine: MachineRef { profile: String::new(), sha256: String::new() },
            machine_values: None,
            placement,
            bridge_mm: None,
            parts: model.parts.iter().map(|p| PartRef { id: p.id, name: p.name.clone() }).collect(),
            slots: vec![TimeSlot { id: 0, prints: vec![print] }],
        };
        Self { profile, model, plan, sliced }
    }

    /// Reads and rewrites into `sink`; the bytes written.
    fn rewritten(&self, sink: &mut (dyn Write + Send)) -> u64 {
        let workpiece = Workpiece::place(&self.model, &self.plan.placement);
        let sliced = read_sliced(&self.sliced, "bench", InputWords::default()).expect("reads").remove(0).sliced;
        let input = Input { print: 0, centre_mm: MIDDLE, file: "bench", sliced: &sliced };
        let job =
            RewriteJob { plan: &self.plan, plan_sha256: "", profile: &self.profile, workpiece: &workpiece, head: "" };
        rewrite(&[input], &job, sink).expect("rewrites").bytes
    }
}

/// The best rate of five runs, MB/s of `bytes`.
fn rate<T>(bytes: usize, mut run: impl FnMut() -> T) -> f64 {
    let times = (0..5).map(|_| {
        let start = Instant::now();
        black_box(run());
        start.elapsed().as_secs_f64()
    });
    bytes as f64 / 1e6 / times.fold(f64::INFINITY, f64::min)
}

/// The most memory that `run` held beyond what was held before, MB; `None` where the system does not say.
fn peak_mb<T>(run: impl FnOnce() -> T) -> Option<f64> {
    let field = |name: &str| {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        status.lines().find_map(|l| l.strip_prefix(name)?.trim().strip_suffix("kB")?.trim().parse::<f64>().ok())
    };
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    let before = field("VmRSS:")?;
    black_box(run());
    Some((field("VmHWM:")? - before) * 1024.0 / 1e6)
}

fn parse(bytes: &[u8]) -> usize {
    let mut parsed = ParsedLine::default();
    lines(bytes).filter(|line| parsed.read(line.bytes).is_ok() && !parsed.words.is_empty()).count()
}

fn main() {
    let megabytes = std::env::var("TRUNNION_BENCH_MB").ok().and_then(|v| v.parse().ok()).unwrap_or(200.0);
    let made = Made::new(megabytes);
    let bytes = &made.sliced;
    let read = || read_sliced(bytes, "bench", InputWords::default()).expect("reads").len();
    let mut out = String::new();
    let to_file = || made.rewritten(&mut tempfile::tempfile().expect("a file"));
    let memory = peak_mb(to_file);
    out += &format!("sliced file {:10.1} MB, {} lines\n", bytes.len() as f64 / 1e6, lines(bytes).count());
    out += &format!("parse       {:10.1} MB/s\n", rate(bytes.len(), || parse(bytes)));
    out += &format!("read        {:10.1} MB/s\n", rate(bytes.len(), read));
    out += &format!("rewrite     {:10.1} MB/s\n", rate(bytes.len(), || made.rewritten(&mut std::io::sink())));
    out += &format!("to a file   {:10.1} MB/s\n", rate(bytes.len(), to_file));
    out += &memory.map_or(String::new(), |mb| format!("memory      {mb:10.1} MB beside the sliced file\n"));
    std::io::stdout().write_all(out.as_bytes()).expect("says");
}
