//! Flags of the way from a model to a file: `prepare`, its steps, and `preview`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::{
    ArrangeArgs, BatchArgs, BedArgs, MachineArgs, ModelArgs, OUTPUT, PLANNING, PRINTING, PassArgs, PlanArgs, PlanRef,
    ReadArgs, SUPPORTS, SliceArgs, StreamArgs, copies,
};
use crate::cli::Failure;
use crate::gcode::marks::made_by;
use crate::job::{World, missing};
use crate::strategy::Way;

#[derive(ClapArgs)]
pub(in crate::cli) struct Prepare {
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    #[command(flatten)]
    pub(in crate::cli) arrange: ArrangeArgs,
    #[command(flatten)]
    pub(in crate::cli) machine: MachineArgs,
    /// Output G-code [default: MODEL.gcode]
    ///
    /// The default is beside the model, and replaces no files of other programs. Written only if verification finds nothing.
    #[arg(short, long, value_name = "OUT.gcode", help_heading = OUTPUT)]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Output folder for as many plates as the models need
    ///
    /// It gets a model, a plan and G-code for each plate. Objects that stand apart are placed where there is room. Equal plates are written once, with the number of times to print them.
    #[arg(long, value_name = "DIR", help_heading = OUTPUT, conflicts_with_all = ["output", "plan_out", "sheet", "preview", "dry_run", "certificate", "port"])]
    pub(in crate::cli) plates: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) plan: PlanArgs,
    #[command(flatten)]
    pub(in crate::cli) pass: PassArgs,
    #[command(flatten)]
    pub(in crate::cli) slicing: SliceArgs,
    #[command(flatten)]
    pub(in crate::cli) bed: BedArgs,
    /// Write the plan
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub(in crate::cli) plan_out: Option<PathBuf>,
    /// Write the plan as one picture, a frame for each pose
    #[arg(long, value_name = "SHEET.svg|.png|.pdf", help_heading = OUTPUT)]
    pub(in crate::cli) sheet: Option<PathBuf>,
    /// Write a 3D preview page for the browser
    #[arg(long, value_name = "VIEW.html", help_heading = OUTPUT)]
    pub(in crate::cli) preview: Option<PathBuf>,
    /// Open the preview page
    #[arg(long, requires = "preview", help_heading = OUTPUT, hide_short_help = true)]
    pub(in crate::cli) open: bool,
    /// Write G-code for a dry run, without heat or filament
    ///
    /// On the machine it moves slowly to each pose and its outermost points, 20 mm above them, and stops at each pose.
    #[arg(long, value_name = "DRY.gcode", help_heading = OUTPUT)]
    pub(in crate::cli) dry_run: Option<PathBuf>,
    /// Write a certificate of the output
    ///
    /// Hashes of all that was checked, with plan and machine, so that others can check the file.
    #[arg(long, value_name = "CERT.json", help_heading = OUTPUT, hide_short_help = true)]
    pub(in crate::cli) certificate: Option<PathBuf>,
    /// How to print: auto, as-drawn, turned, supports, cut
    ///
    /// auto: the cheapest that works, by the profile's [price]; turned: another side down; turned-supports: another side down, on supports
    #[arg(long, value_name = "WAY", help_heading = PLANNING, hide_possible_values = true, value_parser = ["auto", "as-drawn", "turned", "supports", "turned-supports", "cut"], default_value = "auto")]
    pub(in crate::cli) way: String,
    /// Cut the model along this plane first, whatever it gains; may be repeated. `trunnion split --help` explains the words
    ///
    /// Of several parts PART is the number of the one that is cut, with its copies, and the plane is in the coordinates of its own file.
    #[arg(long, value_name = "[PART:]X,Y,Z,OFFSET[@X,Y,Z]", allow_hyphen_values = true, conflicts_with = "plates", help_heading = PLANNING, hide_short_help = true)]
    pub(in crate::cli) cut: Vec<String>,
    /// Cut solids that have no plan as drawn; the parts are written to OUT.parts.3mf
    #[arg(long, value_parser = ["auto", "never"], default_value = "auto", help_heading = PLANNING, hide_short_help = true)]
    pub(in crate::cli) split: String,
    /// Print solids on supports if they have no plan as drawn and no cheaper cut
    #[arg(long, value_parser = ["auto", "never"], default_value = "auto", help_heading = SUPPORTS, hide_short_help = true)]
    pub(in crate::cli) supports: String,
    /// Print afterwards: a serial device, or tcp:host:port
    #[arg(long, value_name = "PATH", help_heading = PRINTING)]
    pub(in crate::cli) port: Option<String>,
    #[command(flatten)]
    pub(in crate::cli) stream: StreamArgs,
    #[command(flatten)]
    pub(in crate::cli) batch: BatchArgs,
}

impl Prepare {
    /// The file it writes: the one that is named, else MODEL.gcode beside the model, where no stranger's stands there.
    pub(in crate::cli) fn output(&self, world: &World<'_>) -> Result<PathBuf, Failure> {
        if let Some(output) = &self.output {
            return Ok(output.clone());
        }
        let model = copies(&self.model.model).0;
        // Whoever misspells the model is told of that, not of a file beside it.
        world.files.size(model).map_err(|error| missing(model, error, world))?;
        let output = model.with_extension("gcode");
        let strange = world.files.read(&output).is_ok_and(|bytes| made_by(&bytes).is_none());
        match strange {
            false => Ok(output),
            true => Err(Failure::Usage(format!(
                "{} already exists, and trunnion has not made it; name another file with -o",
                output.display()
            ))),
        }
    }

    /// The one way that is wanted.
    pub(in crate::cli) fn only(&self) -> Result<Option<Way>, Failure> {
        let only = self.way.parse::<Way>().ok();
        let held = matches!(only, Some(Way::Supports | Way::TurnedSupports));
        if held && self.plan.order.is_some() {
            return Err(Failure::Usage(format!(
                "--way {} contradicts --order: on supports there is one print; remove one of them",
                self.way
            )));
        }
        let flags = [("split", &self.split, only == Some(Way::Cut)), ("supports", &self.supports, held)];
        match flags.into_iter().find(|(_, word, wanted)| *wanted && *word == "never") {
            Some((flag, ..)) => {
                Err(Failure::Usage(format!("--way {} contradicts --{flag} never; remove one of them", self.way)))
            }
            None if self.cut.is_empty() => Ok(only),
            None if self.split == "never" => {
                Err(Failure::Usage("--cut contradicts --split never; remove one of them".to_owned()))
            }
            None if only.is_some_and(|way| way != Way::Cut) => {
                Err(Failure::Usage(format!("--cut contradicts --way {}; remove one of them", self.way)))
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
    /// Output plan file (JSON)
    #[arg(short, long, value_name = "PLAN.json", help_heading = OUTPUT)]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Write the plan as one picture, a frame for each pose
    #[arg(long, value_name = "SHEET.svg|.png|.pdf", help_heading = OUTPUT)]
    pub(in crate::cli) sheet: Option<PathBuf>,
    /// Compare the K best plans, and printing in three axes on supports
    #[arg(long, value_name = "K", help_heading = PLANNING)]
    pub(in crate::cli) top: Option<usize>,
    /// List every feasible sequence, one a line, instead of planning
    #[arg(long, conflicts_with_all = ["top", "output", "sheet"], help_heading = PLANNING)]
    pub(in crate::cli) all: bool,
    /// Maximum number of sequences that --all lists
    #[arg(long, default_value_t = 1000, value_name = "N", requires = "all", help_heading = PLANNING)]
    pub(in crate::cli) limit: usize,
    /// Print solids upright on supports if they have no plan as drawn
    #[arg(long, value_parser = ["auto", "never"], default_value = "never", help_heading = SUPPORTS)]
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
    /// Plan file, as written by `trunnion plan -o`
    pub(in crate::cli) plan: PathBuf,
    /// Folder for the meshes, the project and the sliced files
    #[arg(short, long, value_name = "DIR")]
    pub(in crate::cli) output: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    #[command(flatten)]
    pub(in crate::cli) slicing: SliceArgs,
    #[command(flatten)]
    pub(in crate::cli) bed: BedArgs,
    /// Write the meshes and the project only, without slicing
    #[arg(long)]
    pub(in crate::cli) meshes_only: bool,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Rewrite {
    /// Sliced files, each with one print (identified by its object label, its name print-NN.., or --print) or with several printed one after the other
    #[arg(required = true)]
    pub(in crate::cli) files: Vec<PathBuf>,
    /// Plan of the sliced files
    #[arg(long, value_name = "PLAN.json")]
    pub(in crate::cli) plan: PathBuf,
    /// Output G-code
    #[arg(short, long, value_name = "OUT.gcode", required_unless_present = "in_place")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Overwrite the input file, as a slicer's post-processing script does
    #[arg(long, conflicts_with = "output")]
    pub(in crate::cli) in_place: bool,
    /// Number of the print in the plan, for a file without labels
    #[arg(long, value_name = "N")]
    pub(in crate::cli) print: Option<usize>,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    #[command(flatten)]
    pub(in crate::cli) bed: BedArgs,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Verify {
    /// The G-code file to verify
    pub(in crate::cli) gcode: PathBuf,
    /// Plan of the G-code file; without one, as for a file of another program, the rules that need no plan are checked on the machine given with -m
    #[arg(long, value_name = "PLAN.json", required_unless_present = "profile")]
    pub(in crate::cli) plan: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    /// Write a certificate: hashes of all that was checked, with plan and machine
    ///
    /// Written only if verification finds nothing. Others can check the file with it: see examples/second_opinion/.
    #[arg(long, value_name = "CERT.json", help_heading = OUTPUT, requires = "plan")]
    pub(in crate::cli) certificate: Option<PathBuf>,
}

#[derive(ClapArgs)]
pub(in crate::cli) struct Preview {
    /// G-code file to show, or a model to plan first; omit it to show only the plan
    #[arg(required_unless_present_any = ["plan", "compare"])]
    pub(in crate::cli) file: Option<PathBuf>,
    /// Plan of the G-code file
    #[arg(long, value_name = "PLAN.json", required_unless_present_any = ["profile", "compare"],
        conflicts_with_all = ["ReadArgs", "ArrangeArgs", "PlanArgs", "PassArgs", "supports"])]
    pub(in crate::cli) plan: Option<PathBuf>,
    /// Show two side by side: plans, or finished files with their plans as OUT.gcode=PLAN.json
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["file", "plan", "ReadArgs", "ArrangeArgs", "PlanArgs", "PassArgs", "supports"])]
    pub(in crate::cli) compare: Vec<String>,
    /// Output file, one HTML page
    #[arg(short, long, value_name = "VIEW.html")]
    pub(in crate::cli) output: PathBuf,
    /// Open the page in the browser
    #[arg(long)]
    pub(in crate::cli) open: bool,
    #[command(flatten)]
    pub(in crate::cli) plan_ref: PlanRef,
    #[command(flatten)]
    pub(in crate::cli) read: ReadArgs,
    #[command(flatten)]
    pub(in crate::cli) arrange: ArrangeArgs,
    #[command(flatten)]
    pub(in crate::cli) planning: PlanArgs,
    #[command(flatten)]
    pub(in crate::cli) pass: PassArgs,
    /// Print solids upright on supports if they have no plan as drawn
    #[arg(long, value_parser = ["auto", "never"], default_value = "never", help_heading = SUPPORTS)]
    pub(in crate::cli) supports: String,
}
