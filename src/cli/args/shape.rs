//! Flags of what asks about models: `inspect`, `orient`, `split`, `support`, `pack`.

use std::path::PathBuf;

use clap::Args as ClapArgs;
use clap::builder::NonEmptyStringValueParser;

use super::{BatchArgs, MACHINE, ModelArgs, PassArgs};
use crate::job::{OrientOptions, PackOptions, PackSpace, PoseChoice, SplitOptions, SupportOptions, ThreeNumbers};
use crate::orient::PRINTABLE;

#[derive(ClapArgs)]
pub(in crate::cli) struct Explain {
    /// Code of an error or a finding, for example mesh/open
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
    /// What to minimise: printable (grams and minutes of a stable pose, with reasons), staircase, support-area, height, overhang-angle,
    /// normal-z, weighted-normal-z, tanh-overhang,
    /// support-volume-convex, support-volume-convex-smooth, support-volume, support-volume-column, interface-area,
    /// alexander, contact-area, or a sum such as 0.7*staircase+0.3*height, weights of either sign; may be given several times
    #[arg(long, default_value = PRINTABLE, value_name = "NAME", allow_hyphen_values = true)]
    pub(in crate::cli) objective: Vec<String>,
    /// Search method: certified (best value and a lower bound), mmls (all minima), multistart, bfgs, cg, newton-cg, nelder-mead,
    /// direct, differential-evolution or grid
    #[arg(long, default_value = "certified")]
    pub(in crate::cli) method: String,
    /// Only these parts, as 0,3,5-7 [default: each]
    #[arg(long, value_name = "N", conflicts_with = "whole")]
    pub(in crate::cli) part: Option<String>,
    /// Treat all parts as one
    #[arg(long)]
    pub(in crate::cli) whole: bool,
    /// Maximum evaluations for one objective [default: the method's own]
    #[arg(long, value_name = "N")]
    pub(in crate::cli) budget: Option<usize>,
    /// Seed of the random methods mmls, multistart and differential-evolution
    #[arg(long, default_value_t = 1)]
    pub(in crate::cli) seed: u64,
    /// Surfaces up to this angle from the vertical need no support
    #[arg(long, default_value_t = 45.0, value_name = "DEG")]
    pub(in crate::cli) overhang: f64,
    /// Layer height for the objectives printable, staircase and alexander [default: the profile's, else 0.2]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) layer: Option<f64>,
    /// Machine whose process settings are used for print time and filament: a shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(in crate::cli) profile: Option<String>,
    /// Also rate this pose: the direction in the model's coordinates that points up, for example 0,0,1
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) up: Option<ThreeNumbers>,
    /// Column width for measuring support volumes [default: 0.5, for parts above 100 mm a 200th of their length]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) resolution: Option<f64>,
    /// Steepness of the smoothed steps in support-volume, interface-area and support-volume-convex-smooth
    #[arg(long, default_value_t = OrientOptions::default().smooth_k, value_name = "K", hide_short_help = true)]
    pub(in crate::cli) smooth_k: f64,
    /// Weight of the lowest points in the same objectives, per mm
    #[arg(long, default_value_t = OrientOptions::default().smooth_w, value_name = "W", hide_short_help = true)]
    pub(in crate::cli) smooth_w: f64,
    /// In the same objectives, surfaces that face up carry supports from this angle from the vertical on
    #[arg(long, default_value_t = OrientOptions::default().carrying_deg, value_name = "DEG", hide_short_help = true)]
    pub(in crate::cli) carrying: f64,
    /// Only directions with at least this much bed contact
    #[arg(long, value_name = "MM2")]
    pub(in crate::cli) contact_area_min: Option<f64>,
    /// Compare the best directions with the file's orientation: support volume, overhang area, staircase, height, contact area
    #[arg(long)]
    pub(in crate::cli) compare: bool,
    /// Write the parts with the first objective's best direction up, on z = 0, beside each other (STL, or 3MF by its extension)
    #[arg(short, long, value_name = "OUT.stl")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Draw the first objective over all directions, its minima numbered (the best in red)
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) landscape: Option<PathBuf>,
    /// Draw the part in the first objective's best pose: overhangs or the cost of each facet, and supports
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) batch: BatchArgs,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Split {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    /// A shipped profile's name, or a TOML file; not needed with --convex
    ///
    /// `trunnion profile list` lists them; `trunnion profile new` creates one for your machine.
    #[arg(help_heading = MACHINE, short = 'm', long = "machine", value_name = "PROFILE", env = "TRUNNION_MACHINE", hide_env_values = true, value_parser = NonEmptyStringValueParser::new(), required_unless_present = "convex")]
    pub(in crate::cli) profile: Option<String>,
    /// Cut this part of a model that has several, as `trunnion inspect` numbers them
    #[arg(long, value_name = "PART")]
    pub(in crate::cli) part: Option<usize>,
    /// Take the model apart into nearly convex pieces instead, and write the hull of each: for simulators and planners, not for printing
    #[arg(long, conflicts_with_all = ["part", "up", "cut", "no_cut", "strict", "pedestal", "overhang", "bridge", "tolerate", "margin", "max_cuts", "budget", "allow"])]
    pub(in crate::cli) convex: bool,
    /// How far a piece may be from convex [default: a hundredth of the diagonal of each part's box]
    #[arg(long, value_name = "MM", requires = "convex", allow_hyphen_values = true)]
    pub(in crate::cli) concavity: Option<f64>,
    /// Direction in the model's coordinates that points up, or auto: as `trunnion orient` recommends [default: as drawn]; the parts are written in that orientation
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with_all = ["cut", "no_cut"])]
    pub(in crate::cli) up: Option<PoseChoice>,
    /// The parts, in the order of printing (3MF); written only if the machine has a plan for them. With --json it may be left out
    #[arg(short, long, value_name = "PARTS.3mf")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Slopes up to this angle from the vertical need no support [default: from the profile's line width and layer height]
    #[arg(long, value_name = "DEG")]
    pub(in crate::cli) overhang: Option<f64>,
    #[command(flatten)]
    pub(in crate::cli) pass: PassArgs,
    /// Clearance of the head from parts it does not print on
    #[arg(long, default_value_t = SplitOptions::default().margin_mm, value_name = "MM")]
    pub(in crate::cli) margin: f64,
    /// Maximum number of cuts
    #[arg(long, default_value_t = SplitOptions::default().max_cuts, value_name = "N")]
    pub(in crate::cli) max_cuts: usize,
    /// Maximum number of cuts to try
    #[arg(long, default_value_t = SplitOptions::default().tries, value_name = "N")]
    pub(in crate::cli) budget: u64,
    /// Area that may still need support at the end; 0.5 mm2 a part is ignored as rounding
    #[arg(long, default_value_t = SplitOptions::default().allow_mm2, value_name = "MM2")]
    pub(in crate::cli) allow: f64,
    /// Cut off everything beyond each plane, so that the head never has to pass the remaining part
    #[arg(long)]
    pub(in crate::cli) strict: bool,
    /// Cut along this plane first, whatever it gains; may be repeated, in the order of cutting
    ///
    /// The direction points to what is cut off, which is printed along it; OFFSET is the plane's distance from the origin along the
    /// direction, in mm. Of several parts PART is the one that --part chooses. @X,Y,Z takes only the part that this point lies in, where several lie beyond the plane. What is cut off is not cut again: name outer planes first. The search then
    /// cuts what is left; --max-cuts counts these cuts, too.
    #[arg(long, value_name = "[PART:]X,Y,Z,OFFSET[@X,Y,Z]", allow_hyphen_values = true)]
    pub(in crate::cli) cut: Vec<String>,
    /// Box that no cut may cross, in the file's coordinates; may be repeated
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) no_cut: Vec<String>,
    /// Height of a pedestal below the model [default: none; 10, 20 and 40 if nothing else helps]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) pedestal: Option<f64>,
    /// Picture of the solid with its overhangs, and of its parts; written even if no cut helps
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
}

#[derive(ClapArgs)]
#[command(group = clap::ArgGroup::new("room").required(true).args(["space", "profile"]))]
pub(in crate::cli) struct Pack {
    /// Models; MODEL*3 for three copies
    #[arg(value_name = "MODEL[*COUNT]", required_unless_present = "boxes", conflicts_with = "boxes")]
    pub(in crate::cli) models: Vec<PathBuf>,
    /// Boxes instead of models: a text file with one `width depth height [count [value]] [up[:AXES]]` a line, in mm
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) boxes: Option<PathBuf>,
    /// Unit of the files' numbers: um, mm, cm, in, ft or m [default: each file's own, else guessed]
    #[arg(long)]
    pub(in crate::cli) unit: Option<String>,
    /// Repair of meshes: auto (what is sure is repaired, with a warning), strict (what needs repair is refused) or off (open meshes are refused)
    #[arg(long, value_name = "HOW", hide_possible_values = true, value_parser = ["auto", "strict", "off"], default_value = "auto")]
    pub(in crate::cli) repair: String,
    /// As `--repair off`
    #[arg(long, conflicts_with = "repair", hide = true)]
    pub(in crate::cli) no_repair: bool,
    /// Build space of each run; with --goal height its base X,Y alone, or a limit of the height as Z
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) space: Option<PackSpace>,
    /// The machine on whose table models stand side by side: a shipped profile's name, or a TOML file
    #[arg(short = 'm', long = "machine", value_name = "PROFILE")]
    pub(in crate::cli) profile: Option<String>,
    /// A folder for the runs, one 3MF each
    #[arg(short, long, value_name = "FOLDER")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// A picture of all runs
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
    /// Minimum distance between two objects [default: 1 for models, 0 for boxes, on a table as far as the head reaches sideways]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) gap: Option<f64>,
    /// Allowed rotations: none, z90 (quarter turns about Z), z (any angle about Z) or any
    #[arg(long, default_value_t = PackOptions::default().turn)]
    pub(in crate::cli) turn: String,
    /// What to look for: runs (all pieces in the fewest runs), fill (the most value in one run) or height (all pieces in one run, as low as
    /// possible) [default: runs, or fill with --fill]
    #[arg(long, value_name = "GOAL")]
    pub(in crate::cli) goal: Option<String>,
    /// Values for --goal fill: volume, file (values of --boxes), or a value for each model [default: volume]
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    pub(in crate::cli) fill: Option<String>,
    /// Packing method: auto, blocks, ip (integer program), ip-local-search or tabu; for models also coverings and anneal
    #[arg(long, default_value_t = PackOptions::default().method)]
    pub(in crate::cli) method: String,
    /// Neighbourhood of ip-local-search: boxes that may come or go in a step [default: 2, then 5, then 8]
    #[arg(long, value_name = "N", requires = "direction_distance")]
    pub(in crate::cli) used_distance: Option<u32>,
    /// Neighbourhood of ip-local-search: relations between boxes (left of, below, ..) that may change in a step [default: 30, then 20, then 10]
    #[arg(long, value_name = "N", requires = "used_distance")]
    pub(in crate::cli) direction_distance: Option<u32>,
    /// Time limit, reading and the exact test included [default: a step limit, the same on every machine]
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub(in crate::cli) time: Option<f64>,
    /// Pack coarser meshes around the models, their vertices raised by at most this much; the result is tested on the models themselves
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) inflate: Option<f64>,
    /// Require that models lift straight out, one after the other
    #[arg(long)]
    pub(in crate::cli) no_interlock: bool,
    /// Seed of the random methods
    #[arg(long, default_value_t = PackOptions::default().seed, value_name = "N")]
    pub(in crate::cli) seed: u64,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Support {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    /// Output: the supports alone (.stl), or the oriented model with its supports (.3mf)
    #[arg(short, long, value_name = "SUPPORTS.stl|.3mf")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// A picture of the model with its supports
    #[arg(long, value_name = "OUT.svg|.png|.pdf")]
    pub(in crate::cli) view: Option<PathBuf>,
    /// Up direction, in the file's coordinates
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", allow_hyphen_values = true)]
    pub(in crate::cli) up: ThreeNumbers,
    /// Use the file's own z = 0 as the ground, instead of placing the model on it
    #[arg(long)]
    pub(in crate::cli) keep_z: bool,
    /// Distance between columns, and height of a level
    #[arg(long, default_value_t = SupportOptions::default().step_mm, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) step: f64,
    /// Space from the origin for the model and its supports [default: the model's bounding box, extended by five --step sideways and one upward]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(in crate::cli) space: Option<ThreeNumbers>,
    /// Overhangs up to this angle from the vertical need no support
    #[arg(long, default_value_t = SupportOptions::default().overhang_deg, value_name = "DEG")]
    pub(in crate::cli) overhang: f64,
    /// Maximum number of columns that may merge into one
    #[arg(long, default_value_t = SupportOptions::default().capacity, value_name = "N")]
    pub(in crate::cli) capacity: u16,
    /// Maximum number of columns through one node [default: as many as its arcs carry]
    #[arg(long, value_name = "N")]
    pub(in crate::cli) node_capacity: Option<u16>,
    /// Routing method: auto (least material), min-cost (straightest, exact), push-relabel (fastest) or shortest-paths
    #[arg(long, default_value_t = SupportOptions::default().method)]
    pub(in crate::cli) method: String,
    /// Shape of the columns: x (two crossed sheets), prism (solid squares) or tree (round rods)
    #[arg(long, default_value_t = SupportOptions::default().structure)]
    pub(in crate::cli) structure: String,
    /// Thickness of a sheet; the thinnest rod is twice as thick [default: 0.4, but at most half a step, or 0.3 of one with --touch-every]
    #[arg(long, value_name = "MM")]
    pub(in crate::cli) wall: Option<f64>,
    /// Gap between the supports and the model
    #[arg(long, default_value_t = SupportOptions::default().gap_mm, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) gap: f64,
    /// Let crossed sheets touch their neighbours at every Nth level only, so that powder can be removed [1: everywhere]
    #[arg(long, default_value_t = SupportOptions::default().touch_every, value_name = "N")]
    pub(in crate::cli) touch_every: u16,
    /// Height of a roof of bars on top of the supports, at most --step [0: none]
    #[arg(long, default_value_t = 0.0, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) roof: f64,
    /// Spacing of the roof's bars [default: twice the wall]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) roof_pitch: Option<f64>,
    /// Brace columns with an unbraced length above this (at least twice --step) [0: none]
    #[arg(long, default_value_t = 0.0, value_name = "MM", allow_hyphen_values = true)]
    pub(in crate::cli) brace: f64,
    /// Seed of the random methods
    #[arg(long, default_value_t = SupportOptions::default().seed, value_name = "N")]
    pub(in crate::cli) seed: u64,
}
