//! Why a job was not done, with the facts as fields.

use std::io::ErrorKind;
use std::path::PathBuf;

use super::{BadSetting, BadSimulation, NoPlan, NoWay, Rejected};
use crate::assembly::FitError;
use crate::link::serial::PortError;
use crate::link::{JournalError, ProgramError, Unfit};
use crate::mesh::{MeshError, UnknownUnit};
use crate::planning::{Infeasible, Misplaced, PlanError};
use crate::profile::{ImportError, ProfileError};
use crate::publish::{BadInput, PublishError};
use crate::slicing::SliceError;
use crate::toolpath::{RewriteError, SlicedError, TooLarge};

/// Why a job was not done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read.
    #[error("{}: {}", path.display(), in_words(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// A file that cannot be written.
    #[error("{}: cannot be written: {}{}", path.display(), in_words(source), remedy(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// A pipe or a device might never end.
    #[error("{} is {kind}; give the name of a file", path.display())]
    NotAFile {
        /// What was to be read.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// A file that could not be held beside what is made of it.
    #[error("{}: {bytes} bytes; at most {most} (4 GiB) are read", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// What is allowed.
        most: u64,
    },
    /// Not UTF-8.
    #[error("{name}: not a text file")]
    NotText {
        /// The file.
        name: String,
    },
    /// An output that is no file.
    #[error("{} is {kind}; give the name of a file for the output", path.display())]
    NoOutput {
        /// What was to be written.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// An output in a folder that is not there.
    #[error("{}: there is no folder {}; make it first", path.display(), folder.display())]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// An output whose owner forbids writing.
    #[error("{} is protected against writing; allow writing to it, or give the output another name", path.display())]
    Protected {
        /// The output.
        path: PathBuf,
    },
    /// An output that the same call reads, or writes otherwise.
    #[error("{} is also {what}; give the output another name", path.display())]
    Twice {
        /// The output.
        path: PathBuf,
        /// `an input` or `another output`.
        what: &'static str,
    },
    /// Two prints of one call for the same printer.
    #[error("{port}: two prints cannot go to one port ({} and {}); give each its own", files[0].display(), files[1].display())]
    SamePort {
        /// The port.
        port: String,
        /// Their files.
        files: [PathBuf; 2],
    },
    /// Profiles that extend each other without end, or one in hand that names a file.
    #[error("{file}: extends {named}; only files can extend files, {most} at most one over the other, and none itself")]
    Layers {
        /// The file.
        file: String,
        /// What it extends.
        named: String,
        /// How many may be.
        most: usize,
    },
    /// A finished program where a slicer's file was to be.
    #[error("{file} is a finished program already, by another plan; slice again, or give the plan it was made by")]
    OtherPlan {
        /// The file.
        file: String,
    },
    /// A file to be looked at that is no finished program.
    #[error(
        "{file} has no ;TRUNNION mark with a plan at its head, so neither prepare nor rewrite has written it; a slicer's own file must be \
         rewritten first"
    )]
    NotOurs {
        /// The file.
        file: String,
    },
    /// A file to be looked at that another plan made.
    #[error(
        "{file} was made by the plan with hash {made_by:.12}.., this one has {given:.12}..; give the plan it was made by"
    )]
    MadeByAnother {
        /// The file.
        file: String,
        /// In the file.
        made_by: String,
        /// Of the plan.
        given: String,
    },
    /// A program in which nothing moves.
    #[error("{file} has no moves, so there is nothing to see; was it cut short?")]
    NoMoves {
        /// The file.
        file: String,
    },
    /// A plan whose model is neither where it says nor beside it.
    #[error("{plan}: the model {model} is not there")]
    NoModel {
        /// The plan.
        plan: String,
        /// The model's file, as the plan names it.
        model: String,
    },
    /// A plan whose model has a unit that nobody knows.
    #[error("{plan}: {source}")]
    Unit {
        /// The plan.
        plan: String,
        /// The unit.
        source: UnknownUnit,
    },
    /// A setting of a request that cannot be.
    #[error(transparent)]
    Setting(#[from] BadSetting),
    /// What cannot be packed.
    #[error(transparent)]
    Packing(#[from] super::BadPacking),
    /// An answer about a new machine that is none.
    #[error("{what}: {why}")]
    Answer {
        /// The answer, or its file.
        what: String,
        /// What is wrong with it.
        why: String,
    },
    /// A machine of which too little is told.
    #[error(
        "not answered: {keys}; give each as --set KEY=VALUE or in --answers FILE, or take the rest as it is in the other profile with --keep-rest"
    )]
    Unanswered {
        /// The keys.
        keys: String,
    },
    /// A machine of which its firmware's files say too little.
    #[error(
        "not in these files: {keys}; give each as --set KEY=VALUE or in --answers FILE, or take the rest as it is in {like} with --keep-rest"
    )]
    Untold {
        /// The keys, each with what is asked.
        keys: String,
        /// The profile that the machine is like.
        like: String,
    },
    /// Files of a firmware that describe no machine.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A file that is not written over.
    #[error("{} is there already, and is not written over; give another name, or take it away first", path.display())]
    There {
        /// The file.
        path: PathBuf,
    },
    /// A profile of the user's own that nobody can ask for.
    #[error("{}: a shipped profile is called {name} too, and goes first; rename the file", path.display())]
    Hidden {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// Touches that are none.
    #[error(transparent)]
    Touches(#[from] crate::calibrate::TouchError),
    /// Touches that do not tell everything about a machine.
    #[error("{0}")]
    Calibration(Box<super::Uncalibrated>),
    /// A rehearsal on the machine that is not proved clear.
    #[error("no dry run: {why}; leave out --dry-run")]
    NoDryRun {
        /// The pose, and what is in the way.
        why: String,
    },
    /// A machine whose table no tip can touch.
    #[error(
        "profile {profile}: the head reaches the table in no pose within its limits; hold limits, pivot_mm and offset_mm against the machine"
    )]
    NoTouches {
        /// The profile.
        profile: String,
    },
    /// A simulated printer that cannot be.
    #[error(transparent)]
    Simulation(#[from] BadSimulation),
    /// A model that cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// An open surface where an objective is a volume or needs an inside.
    #[error("{source}; {objective} is a volume or needs an inside, so the mesh must be closed")]
    NeedsClosed {
        /// Where it is open.
        source: Box<MeshError>,
        /// The objective.
        objective: String,
    },
    /// A part of which no direction is better than another.
    #[error(
        "part {part}: none of its {facets} facets has an area, so no direction is better than another; export the model again"
    )]
    NoArea {
        /// The part.
        part: usize,
        /// Its facets.
        facets: usize,
    },
    /// A model of several parts where one solid is cut.
    #[error(
        "{file} has {parts} closed parts, and one solid is cut; give one part alone, or plan the parts as they are"
    )]
    NotOneSolid {
        /// The model.
        file: String,
        /// How many.
        parts: usize,
    },
    /// A profile with a value that TOML has no words for.
    #[error("the profile cannot be written as TOML: {why}")]
    Unwritable {
        /// The writer's words.
        why: String,
    },
    /// A profile that makes no sense.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A model that does not lie on its table.
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    /// A model that does not lie on its table, but on that of another shipped machine.
    #[error("{source}; {machine} has room for it (-m {machine})")]
    RoomElsewhere {
        /// Why it does not.
        source: Misplaced,
        /// The other machine.
        machine: &'static str,
    },
    /// Parts that cannot be made to meet.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A plan that is none, or is stale.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A model that cannot be planned at all, or has no sequence.
    #[error(transparent)]
    Infeasible(#[from] Infeasible),
    /// A model without a plan, with reasons and remedies.
    #[error("{}", .0.infeasible)]
    NoPlan(Box<NoPlan>),
    /// Nothing is left of the ways that were asked for.
    #[error("{0}")]
    NoWay(Box<NoWay>),
    /// A print that the slicer's bed does not hold.
    #[error(transparent)]
    OffBed(#[from] TooLarge),
    /// The slicer failed.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// A sliced file that is not understood.
    #[error(transparent)]
    Sliced(#[from] SlicedError),
    /// Sliced files that do not make a program.
    #[error(transparent)]
    Rewrite(#[from] RewriteError),
    /// A sliced file that could be any print of the plan.
    #[error("{file}: which print is it? name the file print-NN.., label objects in the slicer")]
    WhichPrint {
        /// The file.
        file: String,
    },
    /// A program that cannot be sent line by line.
    #[error("{}: {source}", path.display())]
    Program {
        /// The program.
        path: PathBuf,
        /// Why.
        source: ProgramError,
    },
    /// A program that the printer cannot do.
    #[error("{}: {unfit}; nothing was sent", path.display())]
    Unfit {
        /// The program.
        path: PathBuf,
        /// What it cannot.
        unfit: Unfit,
    },
    /// A profile whose printer nobody can stream to.
    #[error(
        "profile {profile}: [link] protocol is {protocol:?}, which cannot be streamed to; known are marlin, rrf, klipper and grbl"
    )]
    Protocol {
        /// The profile.
        profile: String,
        /// As it says.
        protocol: String,
    },
    /// No journal where one is looked for.
    #[error(
        "{}: there is no such journal, without which nobody knows how far the print of {} has come; it was looked for there only: give the one \
         that send has written with --journal FILE, or print from the start without --resume",
        path.display(),
        program.display()
    )]
    NoJournal {
        /// Where it was looked for.
        path: PathBuf,
        /// The program.
        program: PathBuf,
    },
    /// A file that is no journal.
    #[error("{}: {source}", path.display())]
    Journal {
        /// The journal.
        path: PathBuf,
        /// What is wrong with it.
        source: JournalError,
    },
    /// A program that is not the one whose print was interrupted.
    #[error(
        "{}: the file has changed since the print began, or the journal is another's (it is of {of}, {then} bytes; this one has {now}); what was \
         printed cannot be matched to it",
        path.display()
    )]
    ProgramChanged {
        /// The program.
        path: PathBuf,
        /// The program whose journal it is.
        of: String,
        /// Its size when the print began.
        then: u64,
        /// Its size now.
        now: u64,
    },
    /// A machine that is not the one whose print was interrupted.
    #[error("profile {profile} has changed since the print began; give the same one")]
    ProfileChanged {
        /// The profile.
        profile: String,
    },
    /// A print that is complete.
    #[error("{}: this print is complete; there is nothing to resume", path.display())]
    Ended {
        /// The program.
        path: PathBuf,
    },
    /// The operator does not want the machine to move.
    #[error(
        "nothing was moved; the print would continue at line {line}, in the way that is told above: agree to it by typing yes at a terminal, or by \
         --yes"
    )]
    Refused {
        /// The line of the program.
        line: u32,
    },
    /// A place where no host can connect.
    #[error("{link}: {source}")]
    Link {
        /// The place.
        link: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// A simulated printer's log that takes nothing.
    #[error("log: {source}")]
    Log {
        /// The system's words.
        source: std::io::Error,
    },
    /// A port that cannot be had.
    #[error(transparent)]
    Port(#[from] PortError),
    /// A folder or a list without a model.
    #[error("{}: there is no model in it; a model ends in .stl, .obj, .3mf or .off", path.display())]
    NoModels {
        /// The folder or list.
        path: PathBuf,
    },
    /// A server, a key or a name that cannot be.
    #[error(transparent)]
    PublishInput(#[from] BadInput),
    /// A server that does not take a program.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// The printer, the wire or the operator ended the print.
    #[error("{0}")]
    Printer(String),
    /// The program was made, and has findings.
    #[error("{0}")]
    Rejected(Box<Rejected>),
}

/// The system's words without its number, and plainer for what happens every day.
pub fn in_words(source: &std::io::Error) -> String {
    match source.kind() {
        ErrorKind::NotFound => "there is no such file".to_owned(),
        ErrorKind::PermissionDenied => "access is not allowed".to_owned(),
        _ => {
            let words = source.to_string();
            words.split(" (os error ").next().unwrap_or_default().to_lowercase()
        }
    }
}

/// What can be done where the system's own words do not say; begins with a semicolon, or is empty.
pub fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull => "; free some room on the disk, or choose another",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose another folder, or allow writing there"
        }
        _ => "",
    }
}
