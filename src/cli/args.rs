//! Every flag, declared once.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Parser, Subcommand};

use crate::calibrate::{FitOptions, Tip};
use crate::job::{
    Arrangement, PackOptions, PlanOptions, SlicingOptions, SplitOptions, Standing, SupportOptions, Triple,
};
use crate::orient::PRINTABLE;

/// From a model of several closed parts to a verified G-code file for a printer whose table tilts and turns.
#[derive(Parser)]
#[command(version, about, max_term_width = 100, after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(subcommand)]
    pub(super) verb: Verb,
    /// Print one JSON document on stdout; messages stay on stderr
    #[arg(long, global = true)]
    pub(super) json: bool,
    /// Say nothing but warnings and errors
    #[arg(short, long, global = true)]
    pub(super) quiet: bool,
    /// Say more
    #[arg(short, long, global = true)]
    pub(super) verbose: bool,
}

const AFTER_HELP: &str = "\
Lengths are millimetres, angles degrees, speeds as each profile key says.

The usual way:
  trunnion prepare model.stl -m generic-ac -o model.gcode
The way from inside a slicer's window:
  trunnion plan model.stl -m machine.toml -o plan.json
  trunnion slice plan.json -o slots      (then open slots/project.3mf, print objects one by one)
  post-processing script:  trunnion rewrite --in-place --plan /path/plan.json

Exit codes: 0 done; 1 done, and the answer is no (findings, no plan); 2 usage or bad input;
3 the slicer failed; 4 printer or wire; 130 interrupted.";

#[derive(Subcommand)]
pub(super) enum Verb {
    /// Do everything: from a model to a verified file
    Prepare(Box<Prepare>),
    /// Say what a model is made of: parts, volumes, interfaces, unit
    Inspect(Inspect),
    /// Find the best build directions of each part, with a proof where there is one
    Orient(Orient),
    /// Cut one solid into parts that print without supports, each along its own direction
    Split(Split),
    /// Plan supports for what overhangs, with the least material, and write them as a mesh
    Support(Support),
    /// Pack models or boxes into as few runs as there must be, or the most value into one
    Pack(Pack),
    /// Find orientations and a sequence of time slots, or say why there is none
    Plan(Plan),
    /// Write each print's mesh, a project with all of them, and sliced files
    Slice(Slice),
    /// Turn sliced files into one for the machine (also as a post-processing script)
    Rewrite(Rewrite),
    /// Replay a finished file on the machine model and report what is wrong with it
    Verify(Verify),
    /// Show a finished file, a plan, or why there is none, as one page for the browser
    Preview(Preview),
    /// Stream a verified file to a printer: every line once, in order, or stop safely
    Send(Send),
    /// Be a printer: on a pseudo-terminal or a TCP address, with motion, heat, and faults on purpose
    Simulate(Simulate),
    /// List, show, check and calibrate machine profiles
    #[command(subcommand)]
    Profile(Profile),
}

/// The model and how to read it.
#[derive(ClapArgs)]
pub(super) struct ModelArgs {
    /// STL, OBJ, 3MF or OFF with one or several closed parts
    pub(super) model: PathBuf,
    /// Unit of the file's numbers: um, mm, cm, in, ft or m [default: the file's own, else guessed]
    #[arg(long)]
    pub(super) unit: Option<String>,
    /// Mend what is safe to mend: flipped facets, doubled facets, plane holes
    #[arg(long)]
    pub(super) repair: bool,
}

/// How models are set up before they are planned.
#[derive(ClapArgs)]
pub(super) struct ArrangeArgs {
    /// More models for the same table; MODEL*3 for three of one
    #[arg(value_name = "MODEL[*COUNT]")]
    pub(super) more: Vec<String>,
    /// Direction of the file that is up, or auto: as `trunnion orient` recommends for printing whole, on supports [default: as drawn]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "base")]
    pub(super) up: Option<Standing>,
    /// Stand the model on this part's largest face below which there is nothing
    #[arg(long, value_name = "PART", conflicts_with = "more")]
    pub(super) base: Option<usize>,
    /// Close gaps between parts up to this width, and cut overlapping parts along each other; 0 leaves both
    #[arg(long, default_value_t = Arrangement::default().snap_mm, value_name = "MM")]
    pub(super) snap: f64,
    /// Make one solid of parts that touch or overlap; it is cut again where it has no plan (prepare)
    #[arg(long, conflicts_with = "snap")]
    pub(super) join: bool,
    /// Room between models [default: as far as the head reaches sideways; less where the table is too small]
    #[arg(long, value_name = "MM")]
    pub(super) gap: Option<f64>,
}

/// The machine.
#[derive(ClapArgs)]
pub(super) struct MachineArgs {
    /// A shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(super) profile: String,
}

/// What is let pass of what hangs.
#[derive(ClapArgs)]
pub(super) struct PassArgs {
    /// What a line may span between two ends on material, for planning and verification [default: the profile's process.bridge_mm]
    #[arg(long, value_name = "MM")]
    pub(super) bridge: Option<f64>,
    /// What a connected patch may have that nothing carries, as in engraved text; verification still holds each line to --bridge
    #[arg(long, default_value_t = PlanOptions::default().tolerate_mm2, value_name = "MM2")]
    pub(super) tolerate: f64,
}

/// How to plan.
#[derive(ClapArgs)]
pub(super) struct PlanArgs {
    /// What the plan minimises: bss (sum of the parts' slot numbers), time, setups, slots, any objective of
    /// `trunnion orient` summed over the parts, or a sum such as 1*bss+0.01*staircase
    #[arg(long, default_value_t = PlanOptions::default().objective)]
    pub(super) objective: String,
    /// What the search for orientations minimises; decides where the plan's own objective does not look at orientations
    /// [default: the plan's objective where it is one of parts, else staircase]
    #[arg(long, value_name = "NAME")]
    pub(super) orient_by: Option<String>,
    /// The search for orientations, any of `trunnion orient` [default: a multistart of quick descents]
    #[arg(long, value_name = "METHOD")]
    pub(super) method: Option<String>,
    /// Most evaluations of that search, for one part and objective [default: the method's own]
    #[arg(long, value_name = "N")]
    pub(super) orient_budget: Option<usize>,
    /// Overhangs up to this angle from the vertical need no support (0 = walls only, 90 = everything)
    #[arg(long, default_value_t = PlanOptions::default().overhang_deg, value_name = "DEG")]
    pub(super) overhang: f64,
    #[command(flatten)]
    pub(super) pass: PassArgs,
    /// Let a part overhang by so much, or, without MM2, by whatever something else carries; may be given several times
    #[arg(long, value_name = "PART[:MM2]")]
    pub(super) allow: Vec<String>,
    /// Room the head keeps from parts it does not print on
    #[arg(long, default_value_t = PlanOptions::default().margin_mm, value_name = "MM")]
    pub(super) margin: f64,
    /// As many parts in a slot as can be, one after the other where possible, or never two
    #[arg(long, value_parser = ["together", "single", "only-single"], default_value = "together")]
    pub(super) slots: String,
    /// Let parts that stand on the table wait for later slots
    #[arg(long)]
    pub(super) table_later: bool,
    /// Seed of the orientation search
    #[arg(long, default_value_t = PlanOptions::default().seed)]
    pub(super) seed: u64,
    /// Where the file's origin comes to lie on the table [default: the model centred; elsewhere if the axes do not reach]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub(super) origin: Option<String>,
    /// Turn of the model about the table's normal; with --origin
    #[arg(long, value_name = "DEG", requires = "origin", allow_hyphen_values = true)]
    pub(super) turn: Option<f64>,
    /// Do not look for what would help where there is no plan
    #[arg(long)]
    pub(super) no_remedies: bool,
    /// Most steps of the sequence search
    #[arg(long, default_value_t = PlanOptions::default().budget, value_name = "STEPS")]
    pub(super) budget: u64,
}

/// How to slice.
#[derive(ClapArgs)]
pub(super) struct SliceArgs {
    /// auto, builtin, prusa-slicer, slic3r, cura (its engine), or the path of one
    #[arg(long, default_value_t = SlicingOptions::default().slicer.to_string())]
    pub(super) slicer: String,
    /// The slicer's own configuration, over the profile's [process]; may be given several times
    #[arg(long = "slicer-config", value_name = "FILE")]
    pub(super) slicer_config: Vec<PathBuf>,
    /// Give the slicer up after this long for one print
    #[arg(long, default_value_t = SlicingOptions::default().timeout.as_secs(), value_name = "SECONDS")]
    pub(super) slicer_timeout: u64,
}

/// The slicer's bed, on whose centre each single print is put.
#[derive(ClapArgs)]
pub(super) struct BedArgs {
    /// The slicer's bed, on whose middle each print stands: 250x210, or from where to where, -125..125x-105..105
    #[arg(long, default_value = "250x250", value_name = "XxY", allow_hyphen_values = true)]
    pub(super) bed: String,
}

#[derive(ClapArgs)]
pub(super) struct Prepare {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    #[command(flatten)]
    pub(super) arrange: ArrangeArgs,
    #[command(flatten)]
    pub(super) machine: MachineArgs,
    /// The file for the machine; written only if nothing is found wrong with it
    #[arg(short, long, value_name = "OUT.gcode")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) plan: PlanArgs,
    #[command(flatten)]
    pub(super) slicing: SliceArgs,
    #[command(flatten)]
    pub(super) bed: BedArgs,
    /// Keep the plan
    #[arg(long, value_name = "FILE")]
    pub(super) plan_out: Option<PathBuf>,
    /// The plan as one picture, a frame for each pose
    #[arg(long, value_name = "SHEET.svg|.png|.pdf")]
    pub(super) sheet: Option<PathBuf>,
    /// The file as one page for the browser, to be seen before it is printed
    #[arg(long, value_name = "VIEW.html")]
    pub(super) preview: Option<PathBuf>,
    /// Open that page
    #[arg(long, requires = "preview")]
    pub(super) open: bool,
    /// Cut solids by planes where there is no plan for them as they are; the parts are written beside the output as OUT.parts.3mf
    #[arg(long, value_parser = ["auto", "never"], default_value = "auto")]
    pub(super) split: String,
    /// Print solids upright on supports where there is no plan for them as they are, nor in parts
    #[arg(long, value_parser = ["auto", "never"], default_value = "auto")]
    pub(super) supports: String,
    /// Go on and print: a serial device, or tcp:host:port
    #[arg(long, value_name = "PATH")]
    pub(super) port: Option<String>,
    #[command(flatten)]
    pub(super) stream: StreamArgs,
}

#[derive(ClapArgs)]
pub(super) struct Inspect {
    #[command(flatten)]
    pub(super) model: ModelArgs,
}

#[derive(ClapArgs)]
pub(super) struct Orient {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// printable (grams and minutes of a pose that stands, with reasons), staircase, support-area, height, overhang-angle,
    /// normal-z, weighted-normal-z, tanh-overhang,
    /// support-volume-convex, support-volume-convex-smooth, support-volume, support-volume-column, interface-area,
    /// alexander, contact-area, or a sum such as 0.7*staircase+0.3*height, weights of either sign; may be given several times
    #[arg(long, default_value = PRINTABLE, value_name = "NAME", allow_hyphen_values = true)]
    pub(super) objective: Vec<String>,
    /// certified (best value and a lower bound), mmls (all minima, seed 004), multistart, bfgs, cg, newton-cg, nelder-mead,
    /// direct, differential-evolution or grid
    #[arg(long, default_value = "certified")]
    pub(super) method: String,
    /// Only these parts, as 0,3,5-7 [default: each]
    #[arg(long, value_name = "N", conflicts_with = "whole")]
    pub(super) part: Option<String>,
    /// All parts together as one
    #[arg(long)]
    pub(super) whole: bool,
    /// Most evaluations for one objective [default: the method's own]
    #[arg(long, value_name = "N")]
    pub(super) budget: Option<usize>,
    /// Seed of the methods that draw numbers: mmls, multistart, differential-evolution
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Surfaces up to this angle from the vertical need no support
    #[arg(long, default_value_t = 45.0, value_name = "DEG")]
    pub(super) overhang: f64,
    /// Layer height of printable, staircase and alexander [default: the machine's, else 0.2]
    #[arg(long, value_name = "MM")]
    pub(super) layer: Option<f64>,
    /// Price by this machine's process: a shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(super) profile: Option<String>,
    /// Price this pose too: the direction of the file that is up while printing, as 0,0,1
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(super) up: Option<Triple>,
    /// Width of the columns that support volumes are measured by [default: 0.5, for parts above 200 mm a 400th of their length]
    #[arg(long, value_name = "MM")]
    pub(super) resolution: Option<f64>,
    /// Only directions whose first layer lies on the bed with at least this much
    #[arg(long, value_name = "MM2")]
    pub(super) contact_area_min: Option<f64>,
    /// Also the model as it lies beside each best: support volume, overhang area, staircase, height, contact area
    #[arg(long)]
    pub(super) compare: bool,
    /// Write the parts with the first objective's best direction up, on z = 0, beside each other (STL; 3MF by its ending)
    #[arg(short, long, value_name = "OUT.stl")]
    pub(super) output: Option<PathBuf>,
    /// Draw the first objective over all directions, its minima numbered (the best in red)
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(super) landscape: Option<PathBuf>,
    /// Draw the part as the first objective would have it: overhangs, or what each facet costs, and supports
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(super) view: Option<PathBuf>,
}

#[derive(ClapArgs)]
pub(super) struct Plan {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    #[command(flatten)]
    pub(super) arrange: ArrangeArgs,
    #[command(flatten)]
    pub(super) machine: MachineArgs,
    /// The plan file
    #[arg(short, long, value_name = "PLAN.json")]
    pub(super) output: Option<PathBuf>,
    /// The plan as one picture, a frame for each pose
    #[arg(long, value_name = "SHEET.svg|.png|.pdf")]
    pub(super) sheet: Option<PathBuf>,
    /// Compare the best so many distinct plans with each other, and with printing in three axes on supports
    #[arg(long, value_name = "K")]
    pub(super) top: Option<usize>,
    /// List every feasible sequence, one a line, instead of planning
    #[arg(long, conflicts_with_all = ["top", "output", "sheet"])]
    pub(super) all: bool,
    /// Most sequences that --all lists
    #[arg(long, default_value_t = 1000, value_name = "N", requires = "all")]
    pub(super) limit: usize,
    /// Print solids upright on supports where there is no plan for them as they are
    #[arg(long, value_parser = ["auto", "never"], default_value = "never")]
    pub(super) supports: String,
    #[command(flatten)]
    pub(super) plan: PlanArgs,
}

#[derive(ClapArgs)]
pub(super) struct Split {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    #[command(flatten)]
    pub(super) machine: MachineArgs,
    /// The parts, in the order of printing (3MF); written only if the machine has a plan for them
    #[arg(short, long, value_name = "PARTS.3mf")]
    pub(super) output: PathBuf,
    /// Overhangs up to this angle from the vertical need no support
    #[arg(long, default_value_t = SplitOptions::default().overhang_deg, value_name = "DEG")]
    pub(super) overhang: f64,
    #[command(flatten)]
    pub(super) pass: PassArgs,
    /// Room the head keeps from parts it does not print on
    #[arg(long, default_value_t = SplitOptions::default().margin_mm, value_name = "MM")]
    pub(super) margin: f64,
    /// Most cuts
    #[arg(long, default_value_t = SplitOptions::default().max_cuts, value_name = "N")]
    pub(super) max_cuts: usize,
    /// What may still need support in the end; half a square millimetre a part passes as rounding
    #[arg(long, default_value_t = SplitOptions::default().allow_mm2, value_name = "MM2")]
    pub(super) allow: f64,
    /// Take everything beyond each plane, so that the head never passes what is left
    #[arg(long)]
    pub(super) strict: bool,
    /// Where no seam may come, in the file's frame; may be given several times
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true)]
    pub(super) no_cut: Vec<String>,
    /// Height of a part below the model, printed first [default: none; 10, 20 and 40 where nothing else helps]
    #[arg(long, value_name = "MM")]
    pub(super) pedestal: Option<f64>,
}

#[derive(ClapArgs)]
#[command(group = clap::ArgGroup::new("room").required(true).args(["space", "profile"]))]
pub(super) struct Pack {
    /// Models; MODEL*3 for three of one
    #[arg(value_name = "MODEL[*COUNT]", required_unless_present = "boxes", conflicts_with = "boxes")]
    pub(super) models: Vec<String>,
    /// Boxes instead of models: a text with a line `width depth height [count [value]]` each, in mm
    #[arg(long, value_name = "FILE")]
    pub(super) boxes: Option<PathBuf>,
    /// Unit of the files' numbers: um, mm, cm, in, ft or m [default: each file's own, else guessed]
    #[arg(long)]
    pub(super) unit: Option<String>,
    /// Mend what is safe to mend: flipped facets, doubled facets, plane holes
    #[arg(long)]
    pub(super) repair: bool,
    /// The space of each run
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(super) space: Option<Triple>,
    /// The machine on whose table models stand side by side: a shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(super) profile: Option<String>,
    /// A folder for the runs, one 3MF each
    #[arg(short, long, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    /// A picture of all runs
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(super) view: Option<PathBuf>,
    /// Least distance between two pieces [default: 1 for models, 0 for boxes, on a table as far as the head reaches sideways]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(super) gap: Option<f64>,
    /// none, z90 (quarter turns about Z), z (any angle about Z) or any
    #[arg(long, default_value_t = PackOptions::default().turn)]
    pub(super) turn: String,
    /// Fill one run with the most value instead of taking all in few runs: volume, file (values of --boxes), or a value for each model
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    pub(super) fill: Option<String>,
    /// auto, ip, ip-local-search or tabu; for models also coverings and anneal
    #[arg(long, default_value_t = PackOptions::default().method)]
    pub(super) method: String,
    /// End after so many seconds [default: after a number of steps, the same on every machine]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub(super) time: Option<f64>,
    /// Every model must come out straight up, one after the other
    #[arg(long)]
    pub(super) no_interlock: bool,
    /// Seed of the methods that draw numbers
    #[arg(long, default_value_t = PackOptions::default().seed, value_name = "N")]
    pub(super) seed: u64,
}

#[derive(ClapArgs)]
pub(super) struct Support {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// The supports (.stl), or the model as it stands with its supports (.3mf)
    #[arg(short, long, value_name = "SUPPORTS.stl|.3mf")]
    pub(super) output: Option<PathBuf>,
    /// A picture of the model with its supports
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(super) view: Option<PathBuf>,
    /// The direction that is up, in the file's frame
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true)]
    pub(super) up: Triple,
    /// Take the file's own z = 0 for the ground, instead of standing the model on it
    #[arg(long)]
    pub(super) keep_z: bool,
    /// Distance between columns, and height of a level
    #[arg(long, default_value_t = SupportOptions::default().step_mm, value_name = "MM", allow_hyphen_values = true)]
    pub(super) step: f64,
    /// The space, from the origin on, that the model lies in and supports may use [default: the model's box and five steps around it]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(super) space: Option<Triple>,
    /// Overhangs up to this angle from the vertical need no support
    #[arg(long, default_value_t = SupportOptions::default().overhang_deg, value_name = "DEG")]
    pub(super) overhang: f64,
    /// Columns that may join in one piece of support
    #[arg(long, default_value_t = SupportOptions::default().capacity, value_name = "N")]
    pub(super) capacity: u16,
    /// Columns that may pass one node [default: as many as its pieces carry]
    #[arg(long, value_name = "N")]
    pub(super) node_capacity: Option<u16>,
    /// auto (least material), min-cost (straightest, exact), push-relabel (fastest) or shortest-paths
    #[arg(long, default_value_t = SupportOptions::default().method)]
    pub(super) method: String,
    /// x (two crossed sheets), prism (solid squares) or tree (round rods)
    #[arg(long, default_value_t = SupportOptions::default().structure)]
    pub(super) structure: String,
    /// Thickness of a sheet, and half that of the thinnest rod [default: 0.4, or half a step where that is less]
    #[arg(long, value_name = "MM")]
    pub(super) wall: Option<f64>,
    /// What is left free between the supports and the model
    #[arg(long, default_value_t = SupportOptions::default().gap_mm, value_name = "MM", allow_hyphen_values = true)]
    pub(super) gap: f64,
    /// Seed of the methods that draw numbers
    #[arg(long, default_value_t = SupportOptions::default().seed, value_name = "N")]
    pub(super) seed: u64,
}

/// A plan and what it was made for.
#[derive(ClapArgs)]
pub(super) struct PlanRef {
    /// The model, where it is no longer where the plan says
    #[arg(long, value_name = "FILE")]
    pub(super) model: Option<PathBuf>,
    /// The profile, where it is no longer where the plan says
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(super) profile: Option<String>,
}

#[derive(ClapArgs)]
pub(super) struct Slice {
    /// The plan
    pub(super) plan: PathBuf,
    /// Where the meshes, the project and the sliced files go
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) plan_ref: PlanRef,
    #[command(flatten)]
    pub(super) slicing: SliceArgs,
    #[command(flatten)]
    pub(super) bed: BedArgs,
    /// Only the meshes and the project, nothing sliced
    #[arg(long)]
    pub(super) meshes_only: bool,
}

#[derive(ClapArgs)]
pub(super) struct Rewrite {
    /// Sliced files; each is one print (by its object label, by its name print-NN.., or by --print), or several one by one
    #[arg(required = true)]
    pub(super) files: Vec<PathBuf>,
    /// The plan
    #[arg(long, value_name = "PLAN.json")]
    pub(super) plan: PathBuf,
    /// The file for the machine
    #[arg(short, long, value_name = "OUT.gcode", required_unless_present = "in_place")]
    pub(super) output: Option<PathBuf>,
    /// Put the result in the file's place: the way of a slicer's post-processing script
    #[arg(long, conflicts_with = "output")]
    pub(super) in_place: bool,
    /// Which print of the plan an unlabelled file is
    #[arg(long, value_name = "N")]
    pub(super) print: Option<usize>,
    #[command(flatten)]
    pub(super) plan_ref: PlanRef,
    #[command(flatten)]
    pub(super) bed: BedArgs,
}

#[derive(ClapArgs)]
pub(super) struct Verify {
    /// The file to replay
    pub(super) gcode: PathBuf,
    /// The plan it was made by
    #[arg(long, value_name = "PLAN.json")]
    pub(super) plan: PathBuf,
    #[command(flatten)]
    pub(super) plan_ref: PlanRef,
}

#[derive(ClapArgs)]
pub(super) struct Preview {
    /// The finished file; without it the plan alone is shown. Or a model, which is planned for the machine first
    #[arg(required_unless_present_any = ["plan", "compare"])]
    pub(super) file: Option<PathBuf>,
    /// The plan it was made by
    #[arg(long, value_name = "PLAN.json", required_unless_present_any = ["profile", "compare"])]
    pub(super) plan: Option<PathBuf>,
    /// Two side by side: plans, or finished files with theirs, as OUT.gcode=PLAN.json
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["file", "plan"])]
    pub(super) compare: Vec<String>,
    /// The page
    #[arg(short, long, value_name = "VIEW.html")]
    pub(super) output: PathBuf,
    /// Open it in the browser
    #[arg(long)]
    pub(super) open: bool,
    #[command(flatten)]
    pub(super) plan_ref: PlanRef,
}

/// How to stream.
#[derive(ClapArgs)]
pub(super) struct StreamArgs {
    /// Resume an interrupted print: from the printer's own line counter, or after a reset from the last layer
    #[arg(long)]
    pub(super) resume: bool,
    /// Do not ask before the machine homes and moves for --resume
    #[arg(long)]
    pub(super) yes: bool,
    /// Where the journal is kept [default: OUT.gcode.journal]
    #[arg(long, value_name = "FILE")]
    pub(super) journal: Option<PathBuf>,
    /// Bits a second [default: the profile's]
    #[arg(long)]
    pub(super) baud: Option<u32>,
    /// Wait this long for a device that has disappeared, before giving up
    #[arg(long, default_value_t = 600, value_name = "SECONDS")]
    pub(super) wait: u64,
    /// Where devices stand under their own names
    #[arg(long, default_value = "/dev/serial/by-id", value_name = "DIR", hide = true)]
    pub(super) devices: PathBuf,
}

#[derive(ClapArgs)]
pub(super) struct Send {
    /// The file to print
    pub(super) gcode: PathBuf,
    /// A serial device, or tcp:host:port
    #[arg(long, value_name = "PATH", required_unless_present = "dry_run")]
    pub(super) port: Option<String>,
    /// The plan it was made by: the file is verified against it first
    #[arg(long, value_name = "PLAN.json")]
    pub(super) plan: Option<PathBuf>,
    #[command(flatten)]
    pub(super) plan_ref: PlanRef,
    /// Send a file without verifying it (give the profile with -m)
    #[arg(long, conflicts_with = "plan")]
    pub(super) unverified: bool,
    /// Rehearse on the simulated printer, without waiting and without a port
    #[arg(long)]
    pub(super) dry_run: bool,
    #[command(flatten)]
    pub(super) stream: StreamArgs,
}

#[derive(ClapArgs)]
pub(super) struct Simulate {
    #[command(flatten)]
    pub(super) machine: MachineArgs,
    /// Where to make a link to the pseudo-terminal; or tcp:PORT (this machine only), or tcp:host:port
    #[arg(long, value_name = "PATH")]
    pub(super) link: String,
    /// Simulated seconds per second, or max: no waiting at all
    #[arg(long, default_value = "1", value_name = "FACTOR")]
    pub(super) speed: String,
    /// Heaters this many times as fast as real ones
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    pub(super) heat: f64,
    /// A fault: NAME@LINE, NAME:PROBABILITY or random:PROBABILITY; may be given several times
    #[arg(long, value_name = "FAULT")]
    pub(super) fault: Vec<String>,
    /// Seed of random faults
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// advanced-ok, no-ok-after-resend, refuses-doubles, no-emergency-parser, no-busy, repetier-errors, blank-behind-slash, latches-errors or three-axes
    #[arg(long, value_name = "NAME")]
    pub(super) quirk: Vec<String>,
    /// Bits a second of the simulated wire [default: no limit]
    #[arg(long)]
    pub(super) baud: Option<u32>,
    /// Write every accepted line and the pose after every move
    #[arg(long, value_name = "FILE")]
    pub(super) log: Option<PathBuf>,
}

#[derive(Subcommand)]
pub(super) enum Profile {
    /// The shipped profiles, and your own in $XDG_CONFIG_HOME/trunnion/profiles
    List,
    /// A profile with all its values, and where each comes from
    Show(ProfileName),
    /// Whether a profile makes sense, and what follows from it
    Check(CheckProfile),
    /// Describe a machine of your own: asks on a terminal, else takes answers from flags and a file
    New(New),
    /// Find pivot, offset and zeros from touches at several poses, or choose the touches to make
    Calibrate(Calibrate),
}

#[derive(ClapArgs)]
pub(super) struct CheckProfile {
    #[command(flatten)]
    pub(super) of: ProfileName,
    /// Draw table, head and frame from the side
    #[arg(long, value_name = "FILE.svg")]
    pub(super) view: Option<PathBuf>,
}

#[derive(ClapArgs)]
pub(super) struct New {
    /// Its name, by which it is found from then on
    pub(super) name: String,
    /// The profile that it is like
    #[arg(long, default_value = "generic-ac", value_name = "PROFILE")]
    pub(super) like: String,
    /// An answer: any key of a profile, as --set kinematics.tilt.max_deg=60; may be given again and again
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
    /// A TOML file of answers
    #[arg(long, value_name = "FILE.toml")]
    pub(super) answers: Option<PathBuf>,
    /// Whatever is not answered is as in the other profile
    #[arg(long)]
    pub(super) keep_rest: bool,
    /// Where to write it [default: NAME.toml in $XDG_CONFIG_HOME/trunnion/profiles]
    #[arg(short, long)]
    pub(super) output: Option<PathBuf>,
}

/// Either TOUCHES or --poses.
#[derive(ClapArgs)]
pub(super) struct Calibrate {
    /// Touches as written down; docs/machine.md says how
    #[arg(required_unless_present = "poses")]
    pub(super) touches: Option<PathBuf>,
    #[command(flatten)]
    pub(super) machine: MachineArgs,
    /// Where to write a profile that extends the given one [default: its keys on stdout]
    #[arg(short, long, conflicts_with = "poses")]
    pub(super) output: Option<PathBuf>,
    /// The most, mm, that a machine with axes that are not square may be off from what a profile can say
    #[arg(long, default_value_t = FitOptions::default().tolerance_mm, value_name = "MM", conflicts_with = "poses")]
    pub(super) tolerance: f64,
    /// Take the axes as square, with fewer touches
    #[arg(long)]
    pub(super) assume_square: bool,
    /// Choose the touches to make, and write a file to fill in
    #[arg(long, value_name = "FILE.toml", conflicts_with = "touches")]
    pub(super) poses: Option<PathBuf>,
    /// With --poses: G-code that goes to each, cold and slowly, and stops there
    #[arg(long, value_name = "FILE.gcode", requires = "poses")]
    pub(super) gcode: Option<PathBuf>,
    /// With --poses: how well one touch repeats (standard deviation)
    #[arg(long, default_value_t = Tip::default().repeats_to_mm, value_name = "MM", requires = "poses")]
    pub(super) repeats_to: f64,
    /// With --poses: so many touches at most
    #[arg(long, default_value_t = 60, value_name = "COUNT", requires = "poses")]
    pub(super) most: usize,
}

#[derive(ClapArgs)]
pub(super) struct ProfileName {
    /// A shipped profile's name, or a TOML file
    pub(super) profile: String,
}
