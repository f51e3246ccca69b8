//! The jobs that the command and a library's user have in common: typed request and [`World`] in, typed result out.
//!
//! ```text
//! PrepareRequest --prepare--> PrepareResult{planned, gcode: Verified}      all of the following, in memory
//! OrientRequest  --orient--> OrientResult{parts}                         orientations of parts, with bounds
//! PrepareRequest --prepare_plates--> PlateEvent::Made                    the same over as many plates as it takes, in files
//! PlanRequest    --plan--> PlanResult{plan: CheckedPlan}                   or StrategyError::NoPlan{reasons, remedies}
//! SplitRequest   --split--> SplitResult{split}                           one solid in parts, printable or why not
//! SupportRequest --support--> SupportResult{planned, built}              supports for a model in one pose, or what stays bare
//! CalibrateRequest --calibrate--> CalibrateResult{fit}                  a machine's numbers from touches; PosesRequest: which to make
//! TowerRequest   --tower--> TowerResult{plan, gcode: Verified}         a calibration tower; read_tower: what its measurements say
//! JogRequest     --jog--> JogResult{jogged}                            which axis of a connected machine does what
//! MachineAt      --read_machine--> Source                              what a connected machine says of itself, for import_profile
//! ImportProfile  --import_profile--> ImportedProfile                   a machine from the configuration of its firmware
//! PackRequest    --pack--> PackResult{plates}                              models in as few runs as there must be, or the most value in one
//! PlanSource     --load_plan--> CheckedPlan                                a plan file with its model and its machine
//! CheckedPlan    --Prints::of, slice--> SliceResult --rewrite--> RewriteResult{gcode: Verified}
//! Source         --verify--> VerifyResult --verified()--> Verified         or PrintError::Rejected{report}
//! PreviewRequest --preview--> PreviewResult                              a program, a plan or the lack of one, to be looked at
//! Verified       --document::certificate--> a document                 what was proved, for others
//! Verified       --send, resume, rehearse--> the printer                   an Operator stands by
//! BatchRequest   --batch--> BatchResult                                  many models by one verb, a process and a document each
//! Verified       --publish--> PublishResult                              a server has it, the same bytes
//! ```
//!
//! Three of these jobs one after the other; [`prepare`] does them all in one call:
//!
//! ```
//! use trunnion::job::{
//!     self, PlanRequest, Prints, RewriteRequest, Silent, SliceRequest, SlicingOptions, Source, World,
//! };
//! use trunnion::slicing::SlicerChoice;
//!
//! let world = World::here(&Silent);
//! let plan = job::plan(&PlanRequest::new("fixtures/cube.stl", "generic-ac"), &world)?.plan;
//!
//! let options = SlicingOptions { slicer: SlicerChoice::BuiltIn, ..SlicingOptions::default() };
//! let prints = Prints::of(&plan, options.bed);
//! let sliced = job::slice(&SliceRequest { plan: &plan, prints: &prints, options: &options }, &world)?.sliced;
//!
//! let named = prints.names.iter().zip(sliced);
//! let sliced = named.map(|(name, bytes)| Source::Bytes { name: format!("{name}.gcode"), bytes }).collect();
//! let done = job::rewrite(&RewriteRequest { plan: &plan, sliced, print: None, bed: options.bed }, &world)?;
//! // One part is one print, and its program has been replayed without a finding.
//! assert_eq!(prints.names.len(), 1);
//! assert!(done.gcode.report().is_some_and(|report| report.is_clean()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What a job touches beyond its own values (files, slicers, ports, the clock, whoever watches) comes with its [`World`]. Results are values: to write one, claim its file before the work with [`Outputs`]. There is no
//! JSON here, no flags and no terminal: those are the command's.
//! Lengths mm, angles degrees, times seconds where a name does not say otherwise.

mod batch;
mod error;
mod machine;
mod orient;
mod pack;
mod print;
pub(crate) mod printer;
mod publish;
mod send;
mod shape;

pub(crate) use crate::input::missing;
pub use crate::input::{
    BadSetting, CheckedPlan, InputError, LoadedModel, LoadedProfile, MachineSource, ModelSource, PlanSource, Source,
    load_model, load_plan, load_profile, own_profiles,
};
pub use crate::strategy::{
    self, ArrangedModel, Arrangement, CutModel, CutSolid, Cutting, Finish, GivenCut, HeldModel, HeldPart, Hindrance,
    Holdings, Listed, NoPlan, NoWay, PlaceRequest, PlanOptions, PlanRequest, PlanResult, PlateModel, PoseChoice,
    Refused, SplitOptions, SplitRequest, SplitResult, StrategyError, SupportForm, Supporting, TriedWay, Uncut, WaysOut,
    allowed, ordered, plan, sequences, split,
};
pub use crate::toolpath::{Bed, ProjectSpot};
pub(crate) use crate::world::interrupts;
pub use crate::world::{
    Bar, Clock, Disk, FileError, Files, Installed, Logging, NoSlicer, OutputFile, Outputs, OwnPorts, OwnWeb, Ports,
    Progress, Silent, Slicers, SystemClock, World, in_words, key_from_environment, open_in_browser, remedy, shown_line,
    with_suffix,
};
pub use batch::{BatchError, BatchRequest, BatchResult, Batched, Fate, Models, Share, batch, models_at};
pub use error::Error;
pub use machine::{
    Answers, CalibrateRequest, CalibrateResult, Calibrated, CheckedProfile, DryRun, ImportProfile, ImportedProfile,
    JogChange, JogRequest, JogResult, MachineAt, MachineError, MadeProfile, NewProfile, PosesRequest, PosesResult,
    QUESTIONS, REQUIRED_KEYS, Tilted, TowerReading, TowerRequest, TowerResult, Written, calibrate, calibrate_by,
    check_profile, dry_run, import_profile, jog, keep_form, keep_profile, new_profile, own_machines, poses,
    read_machine, read_tower, tower,
};
pub use orient::{
    Compared, OrientError, OrientOptions, OrientRequest, OrientResult, Oriented, OrientedPart, PartChoice, orient,
};
pub use pack::{
    BadPacking, Coarsened, Contents, Into as PackInto, MOST_PIECES, PackError, PackOptions, PackRequest, PackResult,
    PackSpace, Piece, Plate, Plates, pack,
};
pub use print::{
    LARGEST_BED_MM, MOST_LOOKED_AT, PlateEvent, PlateFolder, PoseShown, PrepareRequest, PrepareResult, PreviewRequest,
    PreviewResult, PrintError, Prints, RefereeRequest, RefereeResult, Rejected, RewriteRequest, RewriteResult, Seconds,
    SliceRequest, SliceResult, SlicerName, SlicingOptions, Verified, VerifyRequest, VerifyResult, bed, is_finished,
    is_page, prepare, prepare_plates, preview, referee, rewrite, show, show_rejected, slice, verify,
};
pub use printer::{BadSimulation, Bench, PrinterError, SimulateRequest, simulate};
pub use publish::{PublishRequest, PublishResult, UploadError, publish, server_address, server_key};
pub use send::{
    Answer, At, Desk, EndedPrint, Figures, Loaded, Operator, Rehearsal, SendError, SendOptions, SendRequest, Sending,
    SentPrint, Unattended, Wire, can_be_sent, desk, rehearse, resume, send, send_several,
};
pub use shape::{
    ConvexRequest, ConvexResult, HullOfPiece, PictureFile, SupportOptions, SupportRequest, SupportResult, ThreeNumbers,
    convex, is_3mf, support,
};
