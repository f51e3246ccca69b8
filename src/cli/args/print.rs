//! Flags of the way from a model to a file: `prepare`, its steps, and `preview`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::{
    ArrangeArgs, BatchArgs, BedArgs, MachineArgs, ModelArgs, PassArgs, PlanArgs, PlanRef, ReadArgs, SliceArgs,
    StreamArgs,
};
use crate::cli::Failure;
use crate::strategy::Way;

#[derive(ClapArgs)]
pub(in crate::cli) struct Prepare {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    #[command(flatten)]
    pub(in crate::cli) arrange: ArrangeArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// The file for the machine; written only if nothing is found wrong with it
    #[arg(short, long, value_name = "OUT.gcode")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) plan: PlanArgs,
    #[command(flatten)]
    pub(in crate::cli) pass: PassArgs,
    #[command(flatten)]
    pub(in crate::cli) slicing: SliceArgs,
    #[command(flatten)]
    pub(in crate::cli) bed: BedArgs,
    /// Keep the plan
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) plan_out: Option<PathBuf>,
    /// The plan as one picture, a frame for each pose
    #[arg(long, value_name = "SHEET.svg|.png|.pdf")]
    pub(in crate::cli) sheet: Option<PathBuf>,
    /// The file as one page for the browser, to be seen before it is printed
    #[arg(long, value_name = "VIEW.html")]
    pub(in crate::cli) preview: Option<PathBuf>,
    /// Open that page
    #[arg(long, requires = "preview")]
    pub(in crate::cli) open: bool,
    /// Also a file to rehearse the print with on the machine itself: cold and slowly to each pose and its outermost places, 20 mm above
    /// them, with a stop at each pose
    #[arg(long, value_name = "DRY.gcode")]
    pub(in crate::cli) dry_run: Option<PathBuf>,
    /// How to print: as-drawn, turned (another side down), supports, cut; or auto, the cheapest that works by the profile's [price]
    #[arg(long, value_name = "WAY", value_parser = ["auto", "as-drawn", "turned", "supports", "turned-supports", "cut"], default_value = "auto")]
    pub(in crate::cli) way: String,
    /// Cut solids by planes where there is no plan for them as they are; the parts are written beside the output as OUT.parts.3mf
    #[arg(long, value_parser = ["auto", "never"], default_value = "auto")]
    pub(in crate::cli) split: String,
    /// Print solids upright on supports where there is no plan for them as they are, and no cheaper cut
    #[arg(long, value_parser = ["auto", "never"], default_value = "auto")]
    pub(in crate::cli) supports: String,
    /// Go on and print: a serial device, or tcp:host:port
    #[arg(long, value_name = "PATH")]
    pub(in crate::cli) port: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) stream: StreamArgs,
    #[command(flatten)]
    pub(in crate::cli) batch: BatchArgs,
}

impl Prepare {
    /// The one way that is wanted.
    pub(in crate::cli) fn only(&self) -> Result<Option<Way>, Failure> {
        let only = self.way.parse::<Way>().ok();
        let held = matches!(only, Some(Way::Supports | Way::TurnedSupports));
        let flags = [("split", &self.split, only == Some(Way::Cut)), ("supports", &self.supports, held)];
        match flags.into_iter().find(|(_, word, wanted)| *wanted && *word == "never") {
            Some((flag, ..)) => {
                Err(Failure::Usage(format!("--way {} and --{flag} never cannot both be; leave one out", self.way)))
            }
            None => Ok(only),
        }
    }
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Plan {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    #[command(flatten)]
    pub(in crate::cli) arrange: ArrangeArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// The plan file
    #[arg(short, long, value_name = "PLAN.json")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// The plan as one picture, a frame for each pose
    #[arg(long, value_name = "SHEET.svg|.png|.pdf")]
    pub(in crate::cli) sheet: Option<PathBuf>,
    /// Compare the best so many distinct plans with each other, and with printing in three axes on supports
    #[arg(long, value_name = "K")]
    pub(in crate::cli) top: Option<usize>,
    /// List every feasible sequence, one a line, instead of planning
    #[arg(long, conflicts_with_all = ["top", "output", "sheet"])]
    pub(in crate::cli) all: bool,
    /// Most sequences that --all lists
    #[arg(long, default_value_t = 1000, value_name = "N", requires = "all")]
    pub(in crate::cli) limit: usize,
    /// Print solids upright on supports where there is no plan for them as they are
    #[arg(long, value_parser = ["auto", "never"], default_value = "never")]
    pub(in crate::cli) supports: String,
    #[command(flatten)]
    pub(in crate::cli) plan: PlanArgs,
    #[command(flatten)]
    pub(in crate::cli) pass: PassArgs,
    #[command(flatten)]
    pub(in crate::cli) batch: BatchArgs,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Slice {
    /// The plan
    pub(in crate::cli) plan: PathBuf,
    /// Where the meshes, the project and the sliced files go
    #[arg(short, long, value_name = "DIR")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    #[command(flatten)]
    pub(in crate::cli) slicing: SliceArgs,
    #[command(flatten)]
    pub(in crate::cli) bed: BedArgs,
    /// Only the meshes and the project, nothing sliced
    #[arg(long)]
    pub(in crate::cli) meshes_only: bool,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Rewrite {
    /// Sliced files; each is one print (by its object label, by its name print-NN.., or by --print), or several one by one
    #[arg(required = true)]
    pub(in crate::cli) files: Vec<PathBuf>,
    /// The plan
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: PathBuf,
    /// The file for the machine
    #[arg(short, long, value_name = "OUT.gcode", required_unless_present = "in_place")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Put the result in the file's place: the way of a slicer's post-processing script
    #[arg(long, conflicts_with = "output")]
    pub(in crate::cli) in_place: bool,
    /// Which print of the plan an unlabelled file is
    #[arg(long, value_name = "N")]
    pub(in crate::cli) print: Option<usize>,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    #[command(flatten)]
    pub(in crate::cli) bed: BedArgs,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Verify {
    /// The file to replay
    pub(in crate::cli) gcode: PathBuf,
    /// The plan it was made by
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Preview {
    /// The finished file; without it the plan alone is shown. Or a model, which is planned for the machine first
    #[arg(required_unless_present_any = ["plan", "compare"])]
    pub(in crate::cli) file: Option<PathBuf>,
    /// The plan it was made by
    #[arg(long, value_name = "PLAN.json", required_unless_present_any = ["profile", "compare"],
        conflicts_with_all = ["ReadArgs", "ArrangeArgs", "PlanArgs", "PassArgs", "supports"])]
    pub(in crate::cli) plan: Option<PathBuf>,
    /// Two side by side: plans, or finished files with theirs, as OUT.gcode=PLAN.json
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["file", "plan", "ReadArgs", "ArrangeArgs", "PlanArgs", "PassArgs", "supports"])]
    pub(in crate::cli) compare: Vec<String>,
    /// The page
    #[arg(short, long, value_name = "VIEW.html")]
    pub(in crate::cli) output: PathBuf,
    /// Open it in the browser
    #[arg(long)]
    pub(in crate::cli) open: bool,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    #[command(flatten, next_help_heading = "How a model is planned")]
    pub(in crate::cli) read: ReadArgs,
    #[command(flatten, next_help_heading = "How a model is planned")]
    pub(in crate::cli) arrange: ArrangeArgs,
    #[command(flatten, next_help_heading = "How a model is planned")]
    pub(in crate::cli) planning: PlanArgs,
    #[command(flatten, next_help_heading = "How a model is planned")]
    pub(in crate::cli) pass: PassArgs,
    /// Print solids upright on supports where there is no plan for them as they are
    #[arg(long, value_parser = ["auto", "never"], default_value = "never", help_heading = "How a model is planned")]
    pub(in crate::cli) supports: String,
}
