//! Why the workbench does not start, and why it refuses a request.

use std::path::PathBuf;

use crate::world::{in_words, remedy};

/// Why the workbench does not start, or refuses a request.
#[derive(Debug, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "workbench/")]
pub enum WorkbenchError {
    /// The port is used by another program, or needs more rights.
    #[error("cannot listen on 127.0.0.1:{port}: {}{}", in_words(source), remedy(source))]
    Port {
        /// The port that was asked for.
        port: u16,
        /// The system's words.
        source: std::io::Error,
    },
    /// The project folder cannot be read or written.
    #[error("cannot use the folder {}: {}{}", path.display(), in_words(source), remedy(source))]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// The program cannot start a copy of itself, or the system has no random numbers.
    #[error("cannot start a job: {}{}", in_words(source), remedy(source))]
    NotStarted {
        /// The system's words.
        source: std::io::Error,
    },
    /// A request without the secret of this workbench.
    #[error("this page is not authorised; open the whole address that trunnion open printed")]
    Unauthorised,
    /// A request to another host name than that of this computer.
    #[error("the host name of this address is not accepted; use 127.0.0.1 or localhost")]
    WrongHost,
    /// A request that a page of another site sent.
    #[error("requests from pages of other sites are refused")]
    ForeignOrigin,
    /// A request that is not HTTP as browsers send it.
    #[error("the request cannot be read: {what}")]
    BadRequest {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A method that the address does not take.
    #[error("this address does not take that method")]
    WrongMethod,
    /// An address or a file that is not part of the workbench.
    #[error("not found; the page may be older than this workbench: load it again")]
    NotFound,
    /// A header of a request, or a request as a whole, that is too large.
    #[error("the request is too large; the limit is {limit_mb} MB for a model")]
    TooLarge {
        /// The largest model, MB.
        limit_mb: u64,
    },
    /// A file name that is not a plain one, or not that of a model.
    #[error("{name:?} is not a plain file name of a model; it must end in .stl, .obj, .3mf, .off or .trunnion")]
    BadName {
        /// The name.
        name: String,
    },
    /// A change that was made on an older state of the project: another page has changed it meanwhile.
    #[error("the project has changed in another window; check it and try again")]
    OldRevision,
    /// A value that is not one of the choices.
    #[error("{value:?} is not a choice for {name}")]
    BadChoice {
        /// What is chosen.
        name: &'static str,
        /// The value.
        value: String,
    },
    /// A job that needs something which the project does not have yet.
    #[error("{what} first")]
    NotYet {
        /// What is to be done first.
        what: &'static str,
    },
    /// Nothing that could be taken back, or made again.
    #[error("there is nothing to {what}")]
    NoStep {
        /// Undo or redo.
        what: &'static str,
    },
    /// A removed model whose file is another one now, and of which there was no space to keep a copy.
    #[error("{name} has changed since it was removed, and no copy was kept; add it again")]
    NotKept {
        /// The model.
        name: String,
    },
    /// A project file, or a file of it, that cannot be read.
    #[error("cannot read {}: {}{}", path.display(), in_words(source), remedy(source))]
    ProjectUnread {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// A project file that is no zip archive, is damaged, or is not that of a project.
    #[error("{project} is damaged: {reason}; save the project again")]
    ProjectDamaged {
        /// The file.
        project: String,
        /// What is wrong.
        reason: String,
    },
    /// A name in a project file that leads out of the project's folder, or that some system cannot write.
    #[error("{project} names a file outside of its folder: {name:?}; nothing was unpacked")]
    ProjectName {
        /// The file.
        project: String,
        /// The name.
        name: String,
    },
    /// A project file that unpacks to more than a project may.
    #[error("{project} unpacks to more than {limit_mb} MB; nothing was unpacked")]
    ProjectTooLarge {
        /// The file.
        project: String,
        /// The most, MB.
        limit_mb: u64,
    },
    /// A project file of a newer version of the format.
    #[error(
        "{project} has format version {version}, and this trunnion reads up to version {known}; install a newer trunnion"
    )]
    ProjectNewer {
        /// The file.
        project: String,
        /// Its version.
        version: u64,
        /// The newest version that is read.
        known: u64,
    },
    /// A model or a machine that a project file names and does not have.
    #[error("{project} does not contain {name}; save the project again where that file is")]
    ProjectMissing {
        /// The file.
        project: String,
        /// What is missing.
        name: String,
    },
    /// A word in a project's command that is not one of the page's choices.
    #[error("{project}: {word:?} is not a choice of the workbench")]
    ProjectWord {
        /// The file.
        project: String,
        /// The word.
        word: String,
    },
    /// A machine whose profile cannot be read, so that the project cannot be saved with it.
    #[error("cannot save the machine: {why}")]
    BadMachine {
        /// Why.
        why: String,
    },
    /// Two project files for one workbench.
    #[error("a workbench has one project; name one .trunnion file")]
    SecondProject,
    /// A job while another one runs.
    #[error("a job is running; wait until it ends, or stop it")]
    Busy,
    /// A stop or an answer for a job that does not run.
    #[error("this job is not running")]
    NotRunning,
    /// The workbench is to end while it prints.
    #[error("a print is running; stop it before you end the workbench")]
    Printing,
    /// A job that ended without a document and without a message: killed by somebody, by the system, or by its own fault.
    #[error("the job ended without a message; it may have run out of memory")]
    Crashed,
    /// More pages and downloads at once than the workbench serves.
    #[error("too many requests at once; try again")]
    Crowded,
}

impl WorkbenchError {
    /// What stands for it in documents, for good.
    pub fn code(&self) -> &'static str {
        self.into()
    }

    /// Status of the HTTP answer.
    pub fn status(&self) -> u16 {
        match self {
            Self::Unauthorised => 401,
            Self::WrongHost | Self::ForeignOrigin => 403,
            Self::NotFound => 404,
            Self::WrongMethod => 405,
            Self::OldRevision
            | Self::Busy
            | Self::NotRunning
            | Self::Printing
            | Self::NotYet { .. }
            | Self::NoStep { .. }
            | Self::NotKept { .. }
            | Self::BadMachine { .. } => 409,
            Self::TooLarge { .. } => 413,
            Self::BadRequest { .. } | Self::BadName { .. } | Self::BadChoice { .. } => 400,
            Self::ProjectDamaged { .. } | Self::ProjectName { .. } | Self::ProjectTooLarge { .. } => 400,
            Self::ProjectNewer { .. }
            | Self::ProjectMissing { .. }
            | Self::ProjectWord { .. }
            | Self::SecondProject => 400,
            Self::ProjectUnread { .. } => 409,
            Self::Crowded => 503,
            Self::Port { .. } | Self::Folder { .. } | Self::NotStarted { .. } | Self::Crashed => 500,
        }
    }
}
