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
//! What a job touches beyond its own values (files, slicers, ports, the clock, whoever watches) comes with its [`World`];
//! `world/` holds the real one. Results are values: to write one, claim its file before the work with [`Outputs`]. There is no
//! JSON here, no flags and no terminal: those are the command's.
//! Lengths mm, angles degrees, times seconds where a name does not say otherwise.

mod adhesion;
mod arrange;
mod batch;
mod below;
mod bench;
mod calibrate;
mod cutting;
mod dry_run;
mod error;
mod form;
mod holding;
mod load;
mod loose;
mod orient;
mod pack;
mod pictures;
mod plan;
mod prepare;
mod preview;
pub(crate) mod printer;
mod profile_check;
mod profile_head;
mod profile_import;
mod profile_new;
mod progress;
mod publish;
mod refused;
mod rewrite;
mod send;
mod setting;
mod simulate;
mod slice;
mod solids;
mod source;
mod split;
mod support;
mod supported;
mod tries;
mod turning;
mod verify;
mod ways;
mod world;

pub use crate::toolpath::{Bed, Spot};
pub use arrange::{ArrangedModel, Arrangement, Standing};
pub use batch::{BatchRequest, BatchResult, Batched, Fate, Models, Share};
pub use bench::Bench;
pub use calibrate::{CalibrateRequest, CalibrateResult, PosesRequest, PosesResult, Uncalibrated, calibrate, poses};
pub use cutting::{CutModel, Cutting};
pub use dry_run::{DryRun, dry_run};
pub use error::{Error, in_words, remedy};
pub use form::SupportForm;
use load::load_unposed;
pub use load::{
    CheckedPlan, LoadedModel, LoadedProfile, PlanSource, load_model, load_plan, load_profile, own_profiles,
};
pub use orient::{Compared, OrientOptions, OrientRequest, OrientResult, Oriented, OrientedPart, PartChoice, orient};
pub use pack::{
    BadPacking, Contents, Into as PackInto, MOST_PIECES, PackOptions, PackRequest, PackResult, Piece, Plate, Plates,
    pack,
};
pub use pictures::PictureFile;
pub use plan::{
    Finish, Hindrance, Listed, NoPlan, PlaceRequest, PlanOptions, PlanRequest, PlanResult, Supporting, allowed,
    sequences,
};
pub use prepare::{PrepareRequest, PrepareResult, Seconds, prepare};
pub use preview::{MOST_LOOKED_AT, PoseShown, PreviewRequest, PreviewResult, is_page, preview, show, show_rejected};
pub use profile_check::{CheckedProfile, Tilted, check_profile};
pub use profile_head::HEAD_QUESTIONS;
pub use profile_import::{ImportProfile, ImportedProfile, import_profile};
pub use profile_new::{Answers, MadeProfile, NewProfile, QUESTIONS, keep_profile, new_profile};
pub use progress::{Bar, Progress, Silent, Step};
pub use publish::{PublishRequest, PublishResult, publish, server_address, server_key};
pub use refused::Refused;
pub use rewrite::{RewriteRequest, RewriteResult, is_finished, rewrite};
pub use send::{
    Answer, At, Desk, Ended, Figures, Loaded, Operator, Print, Rehearsal, SendOptions, SendRequest, Sending,
    Unattended, Wire, can_be_sent, rehearse, resume, send, send_several,
};
pub use setting::BadSetting;
pub use simulate::{BadSimulation, SimulateRequest, simulate};
pub use slice::{LARGEST_BED_MM, Prints, SliceRequest, SliceResult, SlicerName, SlicingOptions, bed, slice};
pub use solids::CutSolid;
pub use source::{MachineSource, ModelSource, Source};
pub use split::{SplitOptions, SplitRequest, SplitResult, Uncut, split};
pub use support::{SupportOptions, SupportRequest, SupportResult, Triple, is_3mf, support};
pub use supported::{HeldModel, HeldPart, Holding};
pub use tries::plan;
pub use verify::{Rejected, Verified, VerifyRequest, VerifyResult, verify};
pub use ways::{NoWay, TriedWay, WaysOut};
pub(crate) use world::interrupts;
pub use world::{
    Clock, Disk, Files, Installed, OutputFile, Outputs, OwnPorts, OwnWeb, Ports, Slicers, SystemClock, World, batch,
    desk, key_from_environment, models_at, with_suffix,
};
