//! Every flag, declared once: here what several verbs share, and a file for each family of verbs.

mod batch;
mod link;
mod machine;
mod mistake;
mod open;
mod print;
mod profile;
mod project;
mod shape;

use std::path::{Path, PathBuf};

use clap::builder::NonEmptyStringValueParser;
use clap::{Args as ClapArgs, Parser, Subcommand};

use crate::job::{Arrangement, Finish, PlanOptions, PoseChoice, SlicingOptions, SupportForm};

pub(in crate::cli) use batch::{BatchArgs, OfMany, words_of_one};
pub(in crate::cli) use link::{OnePrint, Publish, Send, Simulate, StreamArgs};
pub(in crate::cli) use machine::{Jog, Machine, Place, Read};
pub(in crate::cli) use mistake::{in_flags, told};
pub(in crate::cli) use open::Open;
pub(in crate::cli) use print::{Plan, Prepare, Preview, Rewrite, Slice, Verify};
pub(in crate::cli) use profile::{Answers, Calibrate, CheckProfile, Import, Made, New, Profile};
pub(in crate::cli) use project::with_project;
pub(in crate::cli) use shape::{Explain, Inspect, Orient, Pack, Split, Support};

/// Headings of `--help`; `-h` shows what is asked for every day.
const MODEL: &str = "Model";
const MACHINE: &str = "Machine";
const PLANNING: &str = "Planning";
const SLICING: &str = "Slicing";
const SUPPORTS: &str = "Supports";
const OUTPUT: &str = "Output";
const PRINTING: &str = "Printing";
const GENERAL: &str = "General";

/// From a model of several closed parts to a verified G-code file for a printer whose table tilts and turns.
#[derive(Parser)]
#[command(version, about, max_term_width = 100, after_help = AFTER_HELP, disable_help_flag = true)]
pub(in crate::cli) struct Args {
    #[command(subcommand)]
    pub(in crate::cli) verb: Verb,
    /// Print one JSON document on stdout; messages stay on stderr
    #[arg(long, global = true, help_heading = GENERAL)]
    pub(in crate::cli) json: bool,
    /// Print only warnings and errors
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub(in crate::cli) quiet: bool,
    /// Print more
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub(in crate::cli) verbose: bool,
    /// Refuse models and programs that are known to take more memory
    #[arg(long, global = true, value_name = "MB", help_heading = GENERAL, hide_short_help = true, value_parser = clap::value_parser!(u64).range(1..))]
    pub(in crate::cli) max_memory: Option<u64>,
    /// Print help: -h for everyday options, --help for all options
    #[arg(id = "help", short, long = "help", global = true, action = clap::ArgAction::Help, help_heading = GENERAL)]
    _help: Option<bool>,
}

const AFTER_HELP: &str = "\
Lengths are in millimetres, angles in degrees, speeds in the unit that each profile key names.

The usual way:
  trunnion prepare model.stl -m generic-ac -o model.gcode
From inside a slicer's window:
  trunnion plan model.stl -m machine.toml -o plan.json
  trunnion slice plan.json -o slots      (then open slots/project.3mf, print objects one by one)
  post-processing script:  trunnion rewrite --in-place --plan /path/plan.json

Exit codes: 0 done; 1 done, and the answer is no (findings, no plan); 2 usage or bad input;
3 the slicer failed; 4 printer or connection; 130 interrupted.";

#[derive(Subcommand)]
pub(in crate::cli) enum Verb {
    /// Do everything, from a model to a verified file
    ///
    /// MODEL may be a project of the workbench, NAME.trunnion: it is unpacked into the working folder, and prepared as its page does.
    Prepare(Box<Prepare>),
    /// List a model's parts, volumes, interfaces and unit
    Inspect(Inspect),
    /// Explain the code of an error or a finding
    Explain(Explain),
    /// Find the best build directions of each part, with a proof where there is one
    Orient(Orient),
    /// Cut one solid into parts that print without supports, each along its own direction
    Split(Split),
    /// Plan supports with the least material, and write them as a mesh
    Support(Support),
    /// Pack models or boxes into the fewest print runs, or the most valuable ones into one run
    Pack(Pack),
    /// Find orientations and a sequence of time slots, or explain why there is none
    Plan(Plan),
    /// Write each print's mesh, a project with all of them, and sliced files
    Slice(Slice),
    /// Rewrite sliced files into one for the machine (also as a post-processing script)
    Rewrite(Rewrite),
    /// Replay a finished file on the machine model and report what is wrong with it
    Verify(Verify),
    /// Show a finished file, a plan, or why there is none, as one page for the browser
    Preview(Preview),
    /// Open the workbench: one page to see, choose and print
    Open(Open),
    /// Stream a verified file to a printer: every line once, in order, or stop safely
    Send(Send),
    /// Upload a verified file to a printer's server: OctoPrint, Moonraker or a Duet
    Publish(Publish),
    /// Simulate a printer on a pseudo-terminal or TCP port, with motion, heat and injected faults
    Simulate(Simulate),
    /// List, show, check and calibrate machine profiles
    #[command(subcommand)]
    Profile(Profile),
    /// Ask a connected machine for its settings, and try which way each axis moves
    #[command(subcommand)]
    Machine(Machine),
}

/// The model and how to read it.
#[derive(ClapArgs)]
pub(in crate::cli) struct ModelArgs {
    /// STL, OBJ, 3MF or OFF with one or several closed parts
    pub(in crate::cli) model: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) read: ReadArgs,
}

/// How to read it.
#[derive(ClapArgs)]
pub(in crate::cli) struct ReadArgs {
    /// Unit of the file's numbers: um, mm, cm, in, ft or m
    ///
    /// [default: the file's own, else guessed]
    #[arg(help_heading = MODEL, long)]
    pub(in crate::cli) unit: Option<String>,
    /// Plate of a Bambu Studio or OrcaSlicer project
    ///
    /// [default: the only one; inspect, pack and prepare --plates read all of them]
    #[arg(help_heading = MODEL, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), hide_short_help = true)]
    pub(in crate::cli) plate: Option<u32>,
    /// Repair of meshes: auto (cracks, flipped and doubled facets, vertices on edges and small holes are repaired, with a warning), strict (what needs
    /// repair is refused) or off (open meshes are refused)
    #[arg(help_heading = MODEL, long, value_name = "HOW", hide_possible_values = true, value_parser = ["auto", "strict", "off"], default_value = "auto", hide_short_help = true)]
    pub(in crate::cli) repair: String,
    /// As `--repair off`
    #[arg(help_heading = MODEL, long, conflicts_with = "repair", hide = true)]
    pub(in crate::cli) no_repair: bool,
}

/// How models are set up before they are planned.
#[derive(ClapArgs)]
pub(in crate::cli) struct ArrangeArgs {
    /// More models for the same table; MODEL*3 for three copies
    #[arg(value_name = "MODEL[*COUNT]", help_heading = None::<&'static str>)]
    pub(in crate::cli) more: Vec<PathBuf>,
    /// Direction in the model that points up, or auto [default: as drawn]
    ///
    /// Three numbers in the model's coordinates; auto: as `trunnion orient` recommends for printing whole, on supports; any, with plan --all: every way
    /// in which it can stand on a face
    #[arg(help_heading = MODEL, long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "base")]
    pub(in crate::cli) up: Option<PoseChoice>,
    /// Stand the model on this part's largest face that has nothing below it
    #[arg(help_heading = MODEL, long, value_name = "PART", conflicts_with = "more", hide_short_help = true)]
    pub(in crate::cli) base: Option<usize>,
    /// Close gaps between parts up to this width, and remove overlaps between parts; 0 disables both
    #[arg(help_heading = MODEL, long, default_value_t = Arrangement::default().snap_mm, value_name = "MM", hide_short_help = true)]
    pub(in crate::cli) snap: f64,
    /// Join parts that touch or overlap into one solid, which prepare may cut again
    #[arg(help_heading = MODEL, long, conflicts_with = "snap", hide_short_help = true)]
    pub(in crate::cli) join: bool,
    /// Distance between models [default: as far as the head reaches sideways; less if the table is too small]
    #[arg(help_heading = MODEL, long, value_name = "MM", hide_short_help = true)]
    pub(in crate::cli) gap: Option<f64>,
}

/// `A.stl*3`: the file and how many; one where nothing is said, or where that is the file's own name.
pub(in crate::cli) fn copies(word: &Path) -> (&Path, usize) {
    let said = word.to_str().and_then(|word| word.rsplit_once('*')).filter(|_| !word.exists());
    said.and_then(|(name, count)| Some((Path::new(name), count.parse().ok()?))).unwrap_or((word, 1))
}

/// The machine.
#[derive(ClapArgs)]
pub(in crate::cli) struct MachineArgs {
    /// A shipped profile's name, or a TOML file
    ///
    /// `trunnion profile list` lists them; `trunnion profile new` creates one for your machine.
    #[arg(help_heading = MACHINE, short = 'm', long = "machine", value_name = "PROFILE", env = "TRUNNION_MACHINE", hide_env_values = true, value_parser = NonEmptyStringValueParser::new())]
    pub(in crate::cli) profile: String,
}

/// What is let pass of what hangs.
#[derive(ClapArgs)]
pub(in crate::cli) struct PassArgs {
    /// Longest bridge between two supported ends, for planning and verification [default: the profile's process.bridge_mm]
    #[arg(help_heading = PLANNING, long, value_name = "MM", hide_short_help = true)]
    pub(in crate::cli) bridge: Option<f64>,
    /// Largest unsupported patch, for example in engraved text; verification still limits each line to --bridge
    #[arg(help_heading = PLANNING, long, default_value_t = PlanOptions::default().tolerate_mm2, value_name = "MM2", hide_short_help = true)]
    pub(in crate::cli) tolerate: f64,
    /// Quality of overhangs: practised (small droops allowed) or fine (no droops) [default: practised]
    #[arg(help_heading = PLANNING, long, value_name = "HOW", hide_short_help = true)]
    pub(in crate::cli) finish: Option<Finish>,
}

/// How to plan. Nothing is flattened in it, so that `conflicts_with` may name it.
#[derive(ClapArgs)]
pub(in crate::cli) struct PlanArgs {
    /// What the plan minimises: bss, time, setups or slots
    ///
    /// bss (sum of the parts' slot numbers), time, setups, slots, any objective of `trunnion orient` summed over the parts, or a sum such
    /// as 1*bss+0.01*staircase
    #[arg(help_heading = PLANNING, long, default_value_t = PlanOptions::default().objective)]
    pub(in crate::cli) objective: String,
    /// Objective of the orientation search, if the plan's own objective does not depend on orientations
    /// [default: the plan's objective if `trunnion orient` has it, else staircase]
    #[arg(help_heading = PLANNING, long, value_name = "NAME", hide_short_help = true)]
    pub(in crate::cli) orient_by: Option<String>,
    /// Orientation search, any method of `trunnion orient` [default: a multistart of quick descents]
    #[arg(help_heading = PLANNING, long, value_name = "METHOD", hide_short_help = true)]
    pub(in crate::cli) method: Option<String>,
    /// Maximum evaluations of the orientation search, per part and objective [default: depends on --method]
    #[arg(help_heading = PLANNING, long, value_name = "N", hide_short_help = true)]
    pub(in crate::cli) orient_budget: Option<usize>,
    /// Slopes up to this angle from the vertical need no support (90: everything) [default: from the profile's line width and layer height]
    #[arg(help_heading = PLANNING, long, value_name = "DEG", hide_short_help = true)]
    pub(in crate::cli) overhang: Option<f64>,
    /// Allow a part this much overhang, or any amount without MM2; may be repeated
    #[arg(help_heading = PLANNING, long, value_name = "PART[:MM2]", hide_short_help = true)]
    pub(in crate::cli) allow: Vec<String>,
    /// Clearance of the head from parts it does not print on
    #[arg(help_heading = PLANNING, long, default_value_t = PlanOptions::default().margin_mm, value_name = "MM", hide_short_help = true)]
    pub(in crate::cli) margin: f64,
    /// Parts per time slot: as many as possible (together), preferably one (single) or exactly one (only-single)
    #[arg(help_heading = PLANNING, long, value_parser = ["together", "single", "only-single"], default_value = "together", hide_short_help = true)]
    pub(in crate::cli) slots: String,
    /// Allow parts on the table to wait for later slots
    #[arg(help_heading = PLANNING, long, hide_short_help = true)]
    pub(in crate::cli) table_later: bool,
    /// Print parts in this order, each in a later slot than those before: part numbers such as 2,0,1
    ///
    /// A plus joins parts whose order does not matter, such as 0,2+3,1; parts that are not named are printed when it suits. Of a solid that is cut these
    /// are the numbers of its parts. What cannot be printed in this order is refused, with the reasons.
    #[arg(help_heading = PLANNING, long, value_name = "PARTS", hide_short_help = true)]
    pub(in crate::cli) order: Option<String>,
    /// Seed of the orientation search
    #[arg(help_heading = PLANNING, long, default_value_t = PlanOptions::default().seed, hide_short_help = true)]
    pub(in crate::cli) seed: u64,
    /// Position of the file's origin on the table [default: the model centred; elsewhere if the axes do not reach]
    #[arg(help_heading = PLANNING, long, value_name = "X,Y", allow_hyphen_values = true, hide_short_help = true)]
    pub(in crate::cli) origin: Option<String>,
    /// Rotation of the model about the table's normal, about its own centre unless --origin is given
    #[arg(help_heading = PLANNING, long, value_name = "DEG", allow_hyphen_values = true, hide_short_help = true)]
    pub(in crate::cli) turn: Option<f64>,
    /// Height of a denser roof on top of supports, rounded up to whole layers [0: none]
    #[arg(long, default_value_t = SupportForm::PRINTED.roof_mm, help_heading = SUPPORTS, value_name = "MM", allow_hyphen_values = true, hide_short_help = true)]
    pub(in crate::cli) roof: f64,
    /// Line spacing of the support roof [default: two line widths]
    #[arg(long, help_heading = SUPPORTS, value_name = "MM", allow_hyphen_values = true, hide_short_help = true)]
    pub(in crate::cli) roof_pitch: Option<f64>,
    /// Brace support columns with an unbraced length above this [0: none]
    #[arg(long, default_value_t = SupportForm::PRINTED.brace_mm, help_heading = SUPPORTS, value_name = "MM", allow_hyphen_values = true, hide_short_help = true)]
    pub(in crate::cli) brace: f64,
    /// Do not search for remedies if there is no plan
    #[arg(help_heading = PLANNING, long, hide_short_help = true)]
    pub(in crate::cli) no_remedies: bool,
    /// Maximum steps of the sequence search, and maximum cuts tried
    #[arg(help_heading = PLANNING, long, default_value_t = PlanOptions::default().budget, value_name = "STEPS", hide_short_help = true)]
    pub(in crate::cli) budget: u64,
}

/// How to slice.
#[derive(ClapArgs)]
pub(in crate::cli) struct SliceArgs {
    /// auto, builtin, prusa-slicer, slic3r, cura, or a path
    ///
    /// cura means its engine, CuraEngine; a path may lead to any of these slicers.
    #[arg(help_heading = SLICING, long, default_value_t = SlicingOptions::default().slicer.to_string())]
    pub(in crate::cli) slicer: String,
    /// Slicer configuration that overrides the profile's [process]
    ///
    /// May be repeated.
    #[arg(help_heading = SLICING, long = "slicer-config", value_name = "FILE")]
    pub(in crate::cli) slicer_config: Vec<PathBuf>,
    /// Time limit of the slicer for one print
    #[arg(help_heading = SLICING, long, default_value_t = SlicingOptions::default().timeout.as_secs(), value_name = "SECONDS", hide_short_help = true)]
    pub(in crate::cli) slicer_timeout: u64,
}

/// The slicer's bed, on whose centre each single print is put.
#[derive(ClapArgs)]
pub(in crate::cli) struct BedArgs {
    /// The slicer's bed, on whose centre each print is placed: 250x210, or -125..125x-105..105
    #[arg(help_heading = SLICING, long, default_value = "250x250", value_name = "XxY", allow_hyphen_values = true, hide_short_help = true)]
    pub(in crate::cli) bed: String,
}

/// A plan and what it was made for.
#[derive(ClapArgs)]
pub(in crate::cli) struct PlanRef {
    /// Path of the model, if it has moved since the plan was written
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) model: Option<PathBuf>,
    /// Path or name of the profile, if it has moved since the plan was written
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(in crate::cli) profile: Option<String>,
}
