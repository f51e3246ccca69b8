//! The jobs that the command and a library's user have in common: typed request and [`World`] in, typed result out.
//!
//! ```text
//! PrepareRequest --prepare--> PrepareResult{planned, gcode: Verified}      all of the following, in memory
//! OrientRequest  --orient--> OrientResult{parts}                         orientations of parts, with bounds
//! PlanRequest    --plan--> PlanResult{plan: CheckedPlan}                   or Error::NoPlan{reasons, remedies}
//! SplitRequest   --split--> SplitResult{split}                           one solid in parts, printable or why not
//! SupportRequest --support--> SupportResult{planned, built}              supports for a model in one pose, or what stays bare
//! CalibrateRequest --calibrate--> CalibrateResult{fit}                  a machine's numbers from touches; PosesRequest: which to make
//! ImportProfile  --import_profile--> ImportedProfile                   a machine from the configuration of its firmware
//! PackRequest    --pack--> PackResult{plates}                              models in as few runs as there must be, or the most value in one
//! PlanSource     --load_plan--> CheckedPlan                                a plan file with its model and its machine
//! CheckedPlan    --Prints::of, slice--> SliceResult --rewrite--> RewriteResult{gcode: Verified}
//! Source         --verify--> VerifyResult --verified()--> Verified         or Error::Rejected{report}
//! PreviewRequest --preview--> PreviewResult                              a program, a plan or the lack of one, to be looked at
//! Verified       --send, resume, rehearse--> the printer                   an Operator stands by
//! BatchRequest   --batch--> BatchResult                                  many models by one verb, a process and a document each
//! Verified       --publish--> PublishResult                              a server has it, the same bytes
//! ```
//!
//! What a job touches beyond its own values (files, slicers, ports, the clock, whoever watches) comes with its [`World`]. Results are values: to write one, claim its file before the work with [`Outputs`]. There is no
//! JSON here, no flags and no terminal: those are the command's.
//! Lengths mm, angles degrees, times seconds where a name does not say otherwise.

mod batch;
mod bench;
mod calibrate;
mod dry_run;
mod error;
mod orient;
mod pack;
mod picture_file;
mod prepare;
mod preview;
pub(crate) mod printer;
mod profile_check;
mod profile_drawn;
mod profile_head;
mod profile_import;
mod profile_new;
mod publish;
mod rewrite;
mod runs;
mod send;
mod simulate;
mod slice;
mod support;
mod together;
mod verify;

pub(crate) use crate::input::missing;
pub use crate::input::{
    BadSetting, CheckedPlan, InputError, LoadedModel, LoadedProfile, MachineSource, ModelSource, PlanSource, Source,
    load_model, load_plan, load_profile, own_profiles,
};
pub use crate::strategy::{
    self, ArrangedModel, Arrangement, CutModel, CutSolid, Cutting, Finish, HeldModel, HeldPart, Hindrance, Holding,
    Listed, NoPlan, NoWay, PlaceRequest, PlanOptions, PlanRequest, PlanResult, Refused, SplitOptions, SplitRequest,
    SplitResult, Standing, SupportForm, Supporting, TriedWay, Uncut, WaysOut, allowed, plan, sequences, split,
};
pub use crate::toolpath::{Bed, ProjectSpot};
pub(crate) use crate::world::interrupts;
pub use crate::world::{
    Bar, Clock, Disk, FileError, Files, Installed, NoSlicer, OutputFile, Outputs, OwnPorts, OwnWeb, Ports, Progress,
    Silent, Slicers, SystemClock, World, in_words, key_from_environment, remedy, with_suffix,
};
pub use batch::{BatchRequest, BatchResult, Batched, Fate, Models, Share};
pub use bench::Bench;
pub use calibrate::{CalibrateRequest, CalibrateResult, PosesRequest, PosesResult, Uncalibrated, calibrate, poses};
pub use dry_run::{DryRun, dry_run};
pub use error::Error;
pub use orient::{Compared, OrientOptions, OrientRequest, OrientResult, Oriented, OrientedPart, PartChoice, orient};
pub use pack::{
    BadPacking, Contents, Into as PackInto, MOST_PIECES, PackOptions, PackRequest, PackResult, Piece, Plate, Plates,
    pack,
};
pub use picture_file::PictureFile;
pub use prepare::{PrepareRequest, PrepareResult, Seconds, prepare};
pub use preview::{MOST_LOOKED_AT, PoseShown, PreviewRequest, PreviewResult, is_page, preview, show, show_rejected};
pub use profile_check::{CheckedProfile, Tilted, check_profile};
pub use profile_head::HEAD_QUESTIONS;
pub use profile_import::{ImportProfile, ImportedProfile, import_profile};
pub use profile_new::{Answers, MadeProfile, NewProfile, QUESTIONS, keep_profile, new_profile};
pub use publish::{PublishRequest, PublishResult, publish, server_address, server_key};
pub use rewrite::{RewriteRequest, RewriteResult, is_finished, rewrite};
pub use runs::{batch, models_at};
pub use send::{
    Answer, At, Desk, Ended, Figures, Loaded, Operator, Print, Rehearsal, SendOptions, SendRequest, Sending,
    Unattended, Wire, can_be_sent, rehearse, resume, send, send_several,
};
pub use simulate::{BadSimulation, SimulateRequest, simulate};
pub use slice::{LARGEST_BED_MM, Prints, SliceRequest, SliceResult, SlicerName, SlicingOptions, bed, slice};
pub use support::{SupportOptions, SupportRequest, SupportResult, Triple, is_3mf, support};
pub use together::desk;
pub use verify::{Rejected, Verified, VerifyRequest, VerifyResult, verify};
