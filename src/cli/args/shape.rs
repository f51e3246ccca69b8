//! Flags of what asks about models: `inspect`, `orient`, `split`, `support`, `pack`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::{BatchArgs, MachineArgs, ModelArgs, PassArgs};
use crate::job::{PackOptions, SplitOptions, Standing, SupportOptions, Triple};
use crate::orient::PRINTABLE;

#[derive(ClapArgs)]
pub(in crate::cli) struct Explain {
    /// The code, as JSON documents have it: mesh/open
    #[arg(value_name = "CODE")]
    pub(in crate::cli) code: String,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Inspect {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Orient {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    /// printable (grams and minutes of a pose that stands, with reasons), staircase, support-area, height, overhang-angle,
    /// normal-z, weighted-normal-z, tanh-overhang,
    /// support-volume-convex, support-volume-convex-smooth, support-volume, support-volume-column, interface-area,
    /// alexander, contact-area, or a sum such as 0.7*staircase+0.3*height, weights of either sign; may be given several times
    #[arg(long, default_value = PRINTABLE, value_name = "NAME", allow_hyphen_values = true)]
    pub(in crate::cli) objective: Vec<String>,
    /// certified (best value and a lower bound), mmls (all minima, seed 004), multistart, bfgs, cg, newton-cg, nelder-mead,
    /// direct, differential-evolution or grid
    #[arg(long, default_value = "certified")]
    pub(in crate::cli) method: String,
    /// Only these parts, as 0,3,5-7 [default: each]
    #[arg(long, value_name = "N", conflicts_with = "whole")]
    pub(in crate::cli) part: Option<String>,
    /// All parts together as one
    #[arg(long)]
    pub(in crate::cli) whole: bool,
    /// Most evaluations for one objective [default: the method's own]
    #[arg(long, value_name = "N")]
    pub(in crate::cli) budget: Option<usize>,
    /// Seed of the methods that draw numbers: mmls, multistart, differential-evolution
    #[arg(long, default_value_t = 1)]
    pub(in crate::cli) seed: u64,
    /// Surfaces up to this angle from the vertical need no support
    #[arg(long, default_value_t = 45.0, value_name = "DEG")]
    pub(in crate::cli) overhang: f64,
    /// Layer height of printable, staircase and alexander [default: the machine's, else 0.2]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) layer: Option<f64>,
    /// Price by this machine's process: a shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(in crate::cli) profile: Option<String>,
    /// Price this pose too: the direction of the file that is up while printing, as 0,0,1
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) up: Option<Triple>,
    /// Width of the columns that support volumes are measured by [default: 0.5, for parts above 100 mm a 200th of their length]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) resolution: Option<f64>,
    /// Only directions whose first layer lies on the bed with at least this much
    #[arg(long, value_name = "MM2")]
    pub(in crate::cli) contact_area_min: Option<f64>,
    /// Also the model as it lies beside each best: support volume, overhang area, staircase, height, contact area
    #[arg(long)]
    pub(in crate::cli) compare: bool,
    /// Write the parts with the first objective's best direction up, on z = 0, beside each other (STL; 3MF by its ending)
    #[arg(short, long, value_name = "OUT.stl")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Draw the first objective over all directions, its minima numbered (the best in red)
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) landscape: Option<PathBuf>,
    /// Draw the part as the first objective would have it: overhangs, or what each facet costs, and supports
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) batch: BatchArgs,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Split {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// Direction of the file that is up, or auto: as `trunnion orient` recommends [default: as drawn]; the parts come out so turned
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "no_cut")]
    pub(in crate::cli) up: Option<Standing>,
    /// The parts, in the order of printing (3MF); written only if the machine has a plan for them
    #[arg(short, long, value_name = "PARTS.3mf")]
    pub(in crate::cli) output: PathBuf,
    /// Slopes up to this angle from the vertical need no support [default: what lines of the profile's width and layers carry]
    #[arg(long, value_name = "DEG")]
    pub(in crate::cli) overhang: Option<f64>,
    #[command(flatten)]
    pub(in crate::cli) pass: PassArgs,
    /// Room the head keeps from parts it does not print on
    #[arg(long, default_value_t = SplitOptions::default().margin_mm, value_name = "MM")]
    pub(in crate::cli) margin: f64,
    /// Most cuts
    #[arg(long, default_value_t = SplitOptions::default().max_cuts, value_name = "N")]
    pub(in crate::cli) max_cuts: usize,
    /// Most cuts that are tried; then the search ends
    #[arg(long, default_value_t = SplitOptions::default().tries, value_name = "N")]
    pub(in crate::cli) budget: u64,
    /// What may still need support in the end; half a square millimetre a part passes as rounding
    #[arg(long, default_value_t = SplitOptions::default().allow_mm2, value_name = "MM2")]
    pub(in crate::cli) allow: f64,
    /// Take everything beyond each plane, so that the head never passes what is left
    #[arg(long)]
    pub(in crate::cli) strict: bool,
    /// Where no seam may come, in the file's frame; may be given several times
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) no_cut: Vec<String>,
    /// Height of a part below the model, printed first [default: none; 10, 20 and 40 where nothing else helps]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) pedestal: Option<f64>,
    /// Picture of the solid with what overhangs, and of its parts; written also where no cut helps
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
}

#[derive(ClapArgs)]
#[command(group = clap::ArgGroup::new("room").required(true).args(["space", "profile"]))]
pub(in crate::cli) struct Pack {
    /// Models; MODEL*3 for three of one
    #[arg(value_name = "MODEL[*COUNT]", required_unless_present = "boxes", conflicts_with = "boxes")]
    pub(in crate::cli) models: Vec<PathBuf>,
    /// Boxes instead of models: a text with a line `width depth height [count [value]]` each, in mm
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) boxes: Option<PathBuf>,
    /// Unit of the files' numbers: um, mm, cm, in, ft or m [default: each file's own, else guessed]
    #[arg(long)]
    pub(in crate::cli) unit: Option<String>,
    /// Refuse what is not closed, and mend nothing [default: flipped and doubled facets, corners on sides and plane holes are mended, and said]
    #[arg(long, conflicts_with = "repair")]
    pub(in crate::cli) no_repair: bool,
    /// The same as without it
    #[arg(long, hide = true)]
    pub(in crate::cli) repair: bool,
    /// The space of each run
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) space: Option<Triple>,
    /// The machine on whose table models stand side by side: a shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(in crate::cli) profile: Option<String>,
    /// A folder for the runs, one 3MF each
    #[arg(short, long, value_name = "FOLDER")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// A picture of all runs
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
    /// Least distance between two pieces [default: 1 for models, 0 for boxes, on a table as far as the head reaches sideways]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) gap: Option<f64>,
    /// none, z90 (quarter turns about Z), z (any angle about Z) or any
    #[arg(long, default_value_t = PackOptions::default().turn)]
    pub(in crate::cli) turn: String,
    /// Fill one run with the most value instead of taking all in few runs: volume, file (values of --boxes), or a value for each model
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    pub(in crate::cli) fill: Option<String>,
    /// auto, ip, ip-local-search or tabu; for models also coverings and anneal
    #[arg(long, default_value_t = PackOptions::default().method)]
    pub(in crate::cli) method: String,
    /// End after so many seconds [default: after a number of steps, the same on every machine]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub(in crate::cli) time: Option<f64>,
    /// Every model must come out straight up, one after the other
    #[arg(long)]
    pub(in crate::cli) no_interlock: bool,
    /// Seed of the methods that draw numbers
    #[arg(long, default_value_t = PackOptions::default().seed, value_name = "N")]
    pub(in crate::cli) seed: u64,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Support {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    /// The supports (.stl), or the model as it stands with its supports (.3mf)
    #[arg(short, long, value_name = "SUPPORTS.stl|.3mf")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// A picture of the model with its supports
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
    /// The direction that is up, in the file's frame
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true)]
    pub(in crate::cli) up: Triple,
    /// Take the file's own z = 0 for the ground, instead of standing the model on it
    #[arg(long)]
    pub(in crate::cli) keep_z: bool,
    /// Distance between columns, and height of a level
    #[arg(long, default_value_t = SupportOptions::default().step_mm, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) step: f64,
    /// The space, from the origin on, that the model lies in and supports may use [default: the model's box and five steps around it]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) space: Option<Triple>,
    /// Overhangs up to this angle from the vertical need no support
    #[arg(long, default_value_t = SupportOptions::default().overhang_deg, value_name = "DEG")]
    pub(in crate::cli) overhang: f64,
    /// Columns that may join in one piece of support
    #[arg(long, default_value_t = SupportOptions::default().capacity, value_name = "N")]
    pub(in crate::cli) capacity: u16,
    /// Columns that may pass one node [default: as many as its pieces carry]
    #[arg(long, value_name = "N")]
    pub(in crate::cli) node_capacity: Option<u16>,
    /// auto (least material), min-cost (straightest, exact), push-relabel (fastest) or shortest-paths
    #[arg(long, default_value_t = SupportOptions::default().method)]
    pub(in crate::cli) method: String,
    /// x (two crossed sheets), prism (solid squares) or tree (round rods)
    #[arg(long, default_value_t = SupportOptions::default().structure)]
    pub(in crate::cli) structure: String,
    /// Thickness of a sheet, and half that of the thinnest rod [default: 0.4, or half a step where that is less]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) wall: Option<f64>,
    /// What is left free between the supports and the model
    #[arg(long, default_value_t = SupportOptions::default().gap_mm, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) gap: f64,
    /// Height of a roof of bars below what is held, up to a step [0: none]
    #[arg(long, default_value_t = 0.0, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) roof: f64,
    /// From one bar of the roof to the next [default: twice the wall]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) roof_pitch: Option<f64>,
    /// Tie columns together that stand free of others over more than this, two steps or more [0: none]
    #[arg(long, default_value_t = 0.0, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) brace: f64,
    /// Seed of the methods that draw numbers
    #[arg(long, default_value_t = SupportOptions::default().seed, value_name = "N")]
    pub(in crate::cli) seed: u64,
}
