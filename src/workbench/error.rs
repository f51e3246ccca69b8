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
    #[error("{name:?} is not a plain file name of a model; it must end in .stl, .obj, .3mf or .off")]
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
            Self::OldRevision | Self::Busy | Self::NotRunning | Self::Printing | Self::NotYet { .. } => 409,
            Self::TooLarge { .. } => 413,
            Self::BadRequest { .. } | Self::BadName { .. } | Self::BadChoice { .. } => 400,
            Self::Crowded => 503,
            Self::Port { .. } | Self::Folder { .. } | Self::NotStarted { .. } | Self::Crashed => 500,
        }
    }
}
